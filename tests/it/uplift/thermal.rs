//! Slopes that give way.

use orograph::kit::erosion::thermal::{Land, Slipped, slip};
use orograph::kit::hash;
use orograph::value::{Field, Grid, Lattice, Quantity};
use orograph::work::{Cancel, Cancelled, Work};

fn grid(cols: usize, rows: usize, cell: f64) -> Grid {
    let intervals = (cols.max(rows) - 1).max(1) as u32;
    let lattice = Lattice { origin: [0.0, 0.0], span: cell * f64::from(intervals), intervals };
    Grid { lattice, col: 0, row: 0, cols, rows }
}

fn field(grid: Grid, quantity: Quantity, of: impl Fn(usize, usize) -> f32) -> Field {
    Field::new(grid, quantity, (0..grid.len()).map(|k| of(k % grid.cols, k / grid.cols)).collect())
}

fn land(height: &Field) -> Land<'_> {
    Land { height, loose: None, rock: (1.0, None), rubble: (0.6, None), mask: None, steps: 200 }
}

fn run(land: &Land<'_>) -> Slipped {
    slip(land, &Work::default()).expect("nobody stops it")
}

/// A pile of loose ground, dropped on a plain, becomes a cone at the angle of repose, as round as it is wide.
#[test]
fn a_dropped_pile_becomes_a_round_cone_at_the_angle_of_repose() {
    let (n, cell, tangent) = (65, 20.0, 0.6);
    let grid = grid(n, n, cell);
    let middle = (n / 2) as f64;
    let far = |i: usize, j: usize| libm::hypot(i as f64 - middle, j as f64 - middle);
    // A square block: its corners must go.
    let pile = field(grid, Quantity::Elevation, |i, j| {
        let side = (i as f64 - middle).abs().max((j as f64 - middle).abs());
        if side <= 5.0 { 300.0 } else { 0.0 }
    });
    let done = run(&Land { loose: Some(&pile), rubble: (tangent, None), steps: 3000, ..land(&pile) });
    let volume: f64 = pile.data().iter().map(|z| f64::from(*z)).sum::<f64>() * cell * cell;
    let moved: f64 = done.height.iter().map(|z| f64::from(*z)).sum::<f64>() * cell * cell;
    assert!((moved / volume - 1.0).abs() < 1e-5, "{moved} of {volume} m³");
    // Of a cone of that volume and slope.
    let radius = libm::cbrt(3.0 * volume / (std::f64::consts::PI * tangent)) / cell;
    let mut foot = Vec::new();
    for degrees in (0..360).step_by(5) {
        let (x, y) = (libm::cos(f64::from(degrees).to_radians()), libm::sin(f64::from(degrees).to_radians()));
        // Where the flank stands half as high as the cone does: the foot is a slope of few cells.
        let height = |r: f64| {
            let (u, v) = (middle + r * x, middle + r * y);
            let (i, j) = (u.floor() as usize, v.floor() as usize);
            let (s, t) = (u.fract(), v.fract());
            let z = |i: usize, j: usize| f64::from(done.height[j * n + i]);
            (1.0 - t) * ((1.0 - s) * z(i, j) + s * z(i + 1, j))
                + t * ((1.0 - s) * z(i, j + 1) + s * z(i + 1, j + 1))
        };
        let half = 0.5 * radius * cell * tangent;
        let at = (0..600).map(|k| f64::from(k) * 0.1).find(|&r| height(r) < half).expect("a flank");
        foot.push(at);
        let slope = (height(at - 3.0) - height(at + 3.0)) / (6.0 * cell);
        assert!((slope / tangent - 1.0).abs() < 0.05, "{degrees}°: a slope of {slope}");
    }
    let mean = foot.iter().sum::<f64>() / foot.len() as f64;
    let off = foot.iter().fold(0.0f64, |most, r| most.max((r / mean - 1.0).abs()));
    assert!(off < 0.03, "{off} out of round");
    assert!((mean / (0.5 * radius) - 1.0).abs() < 0.06, "{mean} of {} cells", 0.5 * radius);
    assert!(far(0, 0) > radius && done.height[0] == 0.0, "the plain stays");
}

fn rough(grid: Grid, most: f32) -> Field {
    field(grid, Quantity::Elevation, |i, j| match hash::unit(9, (j * 1000 + i) as u64) {
        zero if zero < 0.1 => -0.0,
        height => most * height as f32,
    })
}

#[test]
fn all_ground_that_goes_is_laid_down() {
    for (cols, rows) in [(65, 65), (200, 131)] {
        let high = rough(grid(cols, rows, 30.0), 400.0);
        let some = field(*high.grid(), Quantity::Distance, |i, j| 3.0 * ((i * j) % 5) as f32);
        let done = run(&Land { loose: Some(&some), ..land(&high) });
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        let moved: f64 = done.deposit.iter().map(|d| f64::from(d.abs())).sum();
        assert!(moved > 1e4, "{moved} m moved");
        assert!(sum(&done.deposit).abs() < 1e-5 * moved, "{} of {moved}", sum(&done.deposit));
        let grown = sum(&done.loose) - sum(some.data());
        assert!((grown - sum(&done.wear)).abs() < 1e-5 * moved, "{grown} of {}", sum(&done.wear));
        assert!(done.loose.iter().chain(&done.wear).all(|v| *v >= 0.0));
    }
}

#[test]
fn gentle_slopes_masked_land_and_no_steps_keep_every_bit() {
    let grid = grid(97, 129, 30.0);
    let same = |done: &Slipped, before: &Field, of: &dyn Fn(usize) -> bool| {
        (0..before.data().len())
            .filter(|k| of(*k))
            .all(|k| done.height[k].to_bits() == before.data()[k].to_bits())
    };
    let gentle = rough(grid, 6.0);
    assert!(same(&run(&land(&gentle)), &gentle, &|_| true));
    let steep = rough(grid, 300.0);
    let mask = field(grid, Quantity::Mask, |i, j| if i + j < 110 { 0.0 } else { 1.0 });
    let done = run(&Land { mask: Some(&mask), ..land(&steep) });
    assert!(same(&done, &steep, &|k| mask.data()[k] == 0.0));
    assert!(!same(&done, &steep, &|_| true));
    assert!(same(&run(&Land { steps: 0, ..land(&steep) }), &steep, &|_| true));
}

#[test]
fn loose_ground_goes_before_rock_and_a_field_says_where_rock_holds() {
    let grid = grid(65, 65, 10.0);
    let cliff = field(grid, Quantity::Elevation, |i, _| if i < 32 { 120.0 } else { 0.0 });
    let bare = run(&land(&cliff));
    let thick = field(grid, Quantity::Distance, |_, _| 200.0);
    let covered = run(&Land { loose: Some(&thick), ..land(&cliff) });
    let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
    assert!(sum(&bare.wear) > 1000.0 && sum(&covered.wear) == 0.0);
    let holds = field(grid, Quantity::Number, |_, j| if j < 32 { 1000.0 } else { 1.0 });
    let half = run(&Land { rock: (1.0, Some(&holds)), ..land(&cliff) });
    let of = |done: &Slipped, rows: std::ops::Range<usize>| sum(&done.wear[rows.start * 65..rows.end * 65]);
    assert!(of(&half, 0..24) == 0.0 && of(&half, 40..65) > 500.0);
}

#[test]
fn hostile_land_stays_finite_and_whoever_asks_is_heeded() {
    for (cols, rows, cell) in [(3, 3, 0.1), (1, 50, 10.0), (50, 1, 10.0), (2, 2, 1000.0)] {
        let high = rough(grid(cols, rows, cell), 8848.0);
        let odd = field(*high.grid(), Quantity::Number, |i, _| if i % 2 == 0 { -5.0 } else { 1e9 });
        for land in [land(&high), Land { rock: (0.0, Some(&odd)), loose: Some(&odd), ..land(&high) }] {
            let done = run(&land);
            assert!(done.height.iter().chain(&done.loose).chain(&done.wear).all(|v| v.is_finite()));
        }
    }
    let cancel = Cancel::default();
    cancel.cancel();
    let high = rough(grid(65, 65, 10.0), 300.0);
    assert_eq!(slip(&land(&high), &Work::new(&cancel)), Err(Cancelled));
}

#[test]
fn a_thin_pillar_falls_where_it_stands_and_digs_no_hole() {
    let grid = grid(257, 257, 10.0);
    let pillar = field(grid, Quantity::Elevation, |i, j| if (i, j) == (128, 132) { 200.0 } else { 0.0 });
    let done = run(&land(&pillar));
    assert!(done.height.iter().all(|z| *z >= 0.0), "a hole around the pillar");
    assert!(done.height[132 * 257 + 128] < 30.0);
}
