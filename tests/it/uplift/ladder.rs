//! The ladder against its definition.

use orograph::kit::erosion::Ladder;
use orograph::value::{Field, Grid, Lattice, Quantity};
use orograph::work::Work;

fn grid(cols: usize, rows: usize) -> Grid {
    let intervals = (cols.max(rows) - 1).max(1) as u32;
    Grid { lattice: Lattice { origin: [100.0, -50.0], span: 8192.0, intervals }, col: 0, row: 0, cols, rows }
}

fn sizes(base: &Grid, feature: f64) -> Vec<[usize; 2]> {
    Ladder::new(base, feature).levels().iter().map(|level| [level.grid.cols, level.grid.rows]).collect()
}

#[test]
fn levels_double_from_64_cells_up_to_the_base() {
    let square = |n: usize| sizes(&grid(n, n), f64::INFINITY);
    assert_eq!(square(65), [[65, 65]]);
    assert_eq!(square(33), [[33, 33]]);
    assert_eq!(square(513), [[65, 65], [129, 129], [257, 257], [513, 513]]);
    // A base between two levels is a level of its own.
    assert_eq!(square(300), [[65, 65], [129, 129], [257, 257], [300, 300]]);
    assert_eq!(square(1009).last(), Some(&[1009, 1009]));
    // A side that a cell does not divide has one cell more.
    assert_eq!(sizes(&grid(257, 101), f64::INFINITY), [[65, 26], [129, 51], [257, 101]]);
    assert_eq!(sizes(&grid(102, 257), f64::INFINITY), [[27, 65], [52, 129], [102, 257]]);
    assert_eq!(sizes(&grid(1, 200), f64::INFINITY), [[1, 65], [1, 129], [1, 200]]);
    assert_eq!(sizes(&grid(1, 1), f64::INFINITY), [[1, 1]]);
}

#[test]
fn small_features_begin_on_finer_levels_whatever_the_base() {
    // Eight cells of 128 m are 1024 m across.
    let first = |n, feature| sizes(&grid(n, n), feature)[0][0];
    for n in [257, 513, 1025, 999] {
        assert_eq!([first(n, 1024.0), first(n, 1023.0), first(n, 512.0)], [65, 129, 129], "{n}");
    }
    assert_eq!(first(257, 1.0), 257);
    assert_eq!(first(257, f64::NAN), 65);
}

#[test]
fn levels_cover_the_terrain_and_begin_at_its_corner() {
    for (cols, rows) in [(300, 77), (77, 300), (513, 2), (130, 129), (1000, 999)] {
        let base = grid(cols, rows);
        for level in Ladder::new(&base, f64::INFINITY).levels() {
            let (found, whole) = (level.grid.bounds(), base.bounds());
            assert_eq!(found.min, whole.min);
            for axis in 0..2 {
                let over = found.max[axis] - whole.max[axis];
                assert!((-1e-9..level.grid.cell()).contains(&over), "{level:?} of {base:?}");
            }
        }
    }
}

#[test]
fn a_level_reads_the_samples_of_its_points() {
    let wave = |x: f64, y: f64| (300.0 * libm::sin(x * 2e-3) + 0.05 * y) as f32;
    let field = |n: usize| Field::from_fn(grid(n, n), Quantity::Elevation, wave);
    let (fine, finer) = (field(257), field(513));
    let ladder = Ladder::new(fine.grid(), f64::INFINITY);
    for level in ladder.levels() {
        let got = level.sample(&fine, &Work::default()).unwrap();
        let stride = 256 / (level.grid.cols - 1);
        for j in 0..level.grid.rows {
            for i in 0..level.grid.cols {
                assert_eq!(got[j * level.grid.cols + i], fine.row(j * stride)[i * stride]);
            }
        }
        // The same level of another base reads the same bits.
        let other = Ladder::new(finer.grid(), f64::INFINITY);
        let same = other.levels().iter().find(|other| other.across() == level.across()).unwrap();
        assert_eq!(same.sample(&finer, &Work::default()).unwrap(), got);
    }
}

#[test]
fn between_samples_a_level_reads_a_smooth_curve() {
    let wave = |x: f64, y: f64| (300.0 * libm::sin(x * 2e-3) + 0.05 * y) as f32;
    let field = Field::from_fn(grid(300, 170), Quantity::Elevation, wave);
    for level in Ladder::new(field.grid(), f64::INFINITY).levels() {
        let got = level.sample(&field, &Work::default()).unwrap();
        for j in 0..level.grid.rows {
            for i in 0..level.grid.cols {
                let edge = field.grid().bounds().max;
                let want = wave(level.grid.x(i).min(edge[0]), level.grid.y(j).min(edge[1]));
                // The curve knows less at the border.
                let border = i + 2 >= level.grid.cols || j + 2 >= level.grid.rows;
                let allowed = if border { 0.5 } else { 0.05 };
                assert!((got[j * level.grid.cols + i] - want).abs() < allowed, "{level:?} at {i} {j}");
            }
        }
    }
}
