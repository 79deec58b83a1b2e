//! Land that rises and wears, against what is known of it without running it.

use orograph::kit::erosion::Level;
use orograph::kit::erosion::stream_power::{Eroded, Erodibility, Land, Settings, erode};
use orograph::kit::hash;
use orograph::value::{Field, Grid, Lattice, Quantity};
use orograph::work::{Cancel, Cancelled, Work};

/// Columns and rows with cells of some metres.
fn grid(cols: usize, rows: usize, cell: f64) -> Grid {
    let intervals = (cols.max(rows) - 1).max(1) as u32;
    let lattice = Lattice { origin: [0.0, 0.0], span: cell * f64::from(intervals), intervals };
    Grid { lattice, col: 0, row: 0, cols, rows }
}

fn field(grid: Grid, quantity: Quantity, of: impl Fn(usize, usize) -> f32) -> Field {
    Field::new(grid, quantity, (0..grid.len()).map(|k| of(k % grid.cols, k / grid.cols)).collect())
}

fn land(base: &Level) -> Land<'_> {
    Land { height: None, uplift: None, erodibility: None, mask: None, sea: None, base }
}

const PLAIN: Settings = Settings {
    years: 4e6,
    uplift: 1e-3,
    erodibility: Erodibility::ForRelief(900.0),
    exponent: 0.5,
    steepest: 0.84,
    creep: 0.0,
    variety: 0.0,
    bodies: 1500.0,
    seed: 1,
};

fn run(land: &Land<'_>, settings: &Settings) -> Eroded {
    erode(land, settings, &mut |_| (), &Work::default()).expect("nobody stops it")
}

fn highest(heights: &[f32]) -> f32 {
    heights.iter().fold(f32::MIN, |most, &h| most.max(h))
}

/// After a long time `U = K A^m S` along the way of every cell, with the area at which rivers begin added to `A`: so a cell
/// stands above one of its neighbours by just that slope times the distance.
#[test]
fn steady_land_has_the_slopes_of_the_law() {
    for (exponent, k) in [(0.5, 1e-5), (0.4, 4e-5)] {
        let base = Level::of(&grid(49, 37, 90.0));
        let settings = Settings { years: 3e8, exponent, erodibility: Erodibility::Given(k), ..PLAIN };
        let done = run(&land(&base), &settings);
        let begin = libm::pow(settings.uplift / (k * settings.steepest), 1.0 / exponent);
        let (cols, rows) = (base.grid.cols, base.grid.rows);
        let (mut all, mut steady) = (0, 0);
        for j in 1..rows - 1 {
            for i in 1..cols - 1 {
                let at = j * cols + i;
                let slope = settings.uplift / (k * libm::pow(done.area[at] + begin, exponent));
                let fits = |(x, y): (usize, usize)| {
                    let distance = 90.0 * libm::hypot(x as f64 - i as f64, y as f64 - j as f64);
                    let rise = f64::from(done.height[at] - done.height[y * cols + x]);
                    (rise / distance - slope).abs() < 0.01 * slope
                };
                let around = (j - 1..=j + 1).flat_map(|y| (i - 1..=i + 1).map(move |x| (x, y)));
                all += 1;
                steady += usize::from(around.filter(|&at| at != (i, j)).any(fits));
            }
        }
        assert!(steady as f64 > 0.995 * all as f64, "m {exponent}: {steady} of {all} cells");
    }
}

#[test]
fn a_bump_creeps_as_the_heat_kernel_does() {
    let base = Level::of(&grid(65, 61, 10.0));
    let [x, y] = [32.0, 30.0];
    let bump = |spread: f64| {
        move |i: usize, j: usize| {
            let r = (i as f64 - x) * (i as f64 - x) + (j as f64 - y) * (j as f64 - y);
            (100.0 * 25.0 / spread * libm::exp(-0.5 * r / spread)) as f32
        }
    };
    let start = field(base.grid, Quantity::Elevation, bump(25.0));
    let settings =
        Settings { years: 1e5, uplift: 0.0, erodibility: Erodibility::Given(0.0), creep: 0.01, ..PLAIN };
    let done = run(&Land { height: Some(&start), ..land(&base) }, &settings);
    // The variance, in cells, grows by 2 D t.
    let wanted = field(base.grid, Quantity::Elevation, bump(25.0 + 2.0 * 0.01 * 1e5 / 100.0));
    let off = done.height.iter().zip(wanted.data()).fold(0.0f32, |most, (a, b)| most.max((a - b).abs()));
    assert!(off < 0.01 * highest(wanted.data()), "{off} of {}", highest(wanted.data()));
}

#[test]
fn the_highest_land_reaches_the_relief_that_is_asked_for() {
    for relief in [300.0, 1500.0] {
        let base = Level::of(&grid(129, 129, 120.0));
        let settings = Settings { years: 2e7, erodibility: Erodibility::ForRelief(relief), ..PLAIN };
        let top = f64::from(highest(&run(&land(&base), &settings).height));
        assert!((top / relief - 1.0).abs() < 0.15, "{top} of {relief} m");
    }
}

#[test]
fn where_the_mask_is_zero_and_where_no_time_passes_every_bit_stays() {
    let base = Level::of(&grid(97, 129, 60.0));
    let rough = |i: usize, j: usize| match hash::unit(3, (j * 97 + i) as u64) {
        zero if zero < 0.1 => -0.0,
        height => 300.0 * height as f32,
    };
    let start = field(base.grid, Quantity::Elevation, rough);
    let mask = field(base.grid, Quantity::Mask, |i, j| if i + j < 100 { 0.0 } else { 0.7 });
    let land = Land { height: Some(&start), mask: Some(&mask), ..land(&base) };
    let settings = Settings { creep: 0.01, variety: 1.0, ..PLAIN };
    let done = run(&land, &settings);
    let mut changed = 0;
    for (k, (now, before)) in done.height.iter().zip(start.data()).enumerate() {
        let is_same = now.to_bits() == before.to_bits();
        assert!(is_same || mask.data()[k] > 0.0, "sample {k}: {before} became {now}");
        changed += usize::from(!is_same);
    }
    assert!(changed > 1000, "{changed} samples changed");
    let done = run(&land, &Settings { years: 0.0, ..settings });
    assert!(done.height.iter().zip(start.data()).all(|(a, b)| a.to_bits() == b.to_bits()));
    assert!(done.wear.iter().all(|w| *w == 0.0));
}

/// The correlation of two lands at the points of the coarser.
fn correlation(coarse: &[f32], fine: &[f32], n: usize) -> f64 {
    let pairs: Vec<[f64; 2]> = (0..n * n)
        .map(|k| [coarse[k], fine[(k / n) * 2 * (2 * n - 1) + (k % n) * 2]].map(f64::from))
        .collect();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let (a, b) = (mean(&|p| p[0]), mean(&|p| p[1]));
    let spread = |x: usize, m: f64| mean(&|p| (p[x] - m) * (p[x] - m)).sqrt();
    mean(&|p| (p[0] - a) * (p[1] - b)) / (spread(0, a) * spread(1, b))
}

#[test]
fn a_finer_base_shows_the_same_range() {
    let breadth = std::env::var_os("OROGRAPH_BREADTH").is_some_and(|v| !v.is_empty() && v != "0");
    let settings = Settings { creep: 0.001, variety: 1.5, ..PLAIN };
    let sizes: &[(usize, f64)] =
        if breadth { &[(129, 0.95), (257, 0.98), (513, 0.98)] } else { &[(129, 0.95)] };
    for &(n, least) in sizes {
        let made = |n: usize| {
            let base = Level::of(&grid(n, n, 15_360.0 / (n - 1) as f64));
            run(&land(&base), &settings).height
        };
        let found = correlation(&made(n), &made(2 * n - 1), n);
        assert!(found > least, "{n}: {found}");
    }
}

#[test]
fn threads_change_nothing_and_whoever_looks_is_shown_each_level() {
    let base = Level::of(&grid(257, 193, 60.0));
    let settings = Settings { creep: 0.001, variety: 1.5, ..PLAIN };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&land(&base), &settings))
    };
    assert_eq!(on(1), on(3));
    let mut seen = Vec::new();
    erode(&land(&base), &settings, &mut |p| seen.push((p.level.across(), p.height.len())), &Work::default())
        .expect("nobody stops it");
    assert_eq!(seen, [(64, 65 * 49), (128, 129 * 97), (256, 257 * 193)]);
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(erode(&land(&base), &settings, &mut |_| (), &Work::new(&cancel)), Err(Cancelled));
}

#[test]
fn hostile_land_stays_finite() {
    for (cols, rows, cell) in [(3, 3, 0.1), (1, 40, 5.0), (40, 1, 5.0), (2, 2, 1000.0), (33, 20, 1000.0)] {
        let base = Level::of(&grid(cols, rows, cell));
        let high =
            field(base.grid, Quantity::Elevation, |i, j| 8848.0 * hash::unit(1, (i * 99 + j) as u64) as f32);
        let odd = field(base.grid, Quantity::Mask, |i, _| if i % 2 == 0 { -5.0 } else { 1e6 });
        for settings in [
            Settings { creep: 1e3, variety: 8.0, ..PLAIN },
            Settings { years: 1e9, uplift: 10.0, ..PLAIN },
            Settings { uplift: 0.0, ..PLAIN },
            Settings { uplift: -1e-3, exponent: 1.0, ..PLAIN },
            Settings { erodibility: Erodibility::Given(1e3), exponent: 0.1, ..PLAIN },
        ] {
            for land in [
                land(&base),
                Land { height: Some(&high), sea: Some(9000.0), ..land(&base) },
                Land { height: Some(&high), uplift: Some(&odd), erodibility: Some(&odd), ..land(&base) },
            ] {
                let done = run(&land, &settings);
                let of = |values: &[f32]| values.iter().all(|v| v.is_finite());
                assert!(of(&done.height) && of(&done.wear), "{cols} × {rows}: {settings:?}");
            }
        }
    }
}
