//! The same bits for mirrored and turned land, for any number of threads and on any instruction set.

use orograph::kit::erosion::hydraulic::{Run, Settings, Site, State};
use orograph::kit::simd::Level;
use orograph::work::Work;

use super::land::{island, run, site};

const N: usize = 65;

/// Where each cell goes when the land is mirrored or turned.
fn moved(values: &[f32], to: impl Fn([usize; 2]) -> [usize; 2]) -> Vec<f32> {
    let mut out = vec![0.0; N * N];
    for (k, &value) in values.iter().enumerate() {
        let [i, j] = to([k % N, k / N]);
        out[j * N + i] = value;
    }
    out
}

fn land() -> Site {
    let mut site = site(N, 40.0, island(N, 700.0, 5), 60.0, true);
    site.before = Some(island(N, 3.0, 9).iter().map(|l| l.max(0.0)).collect());
    site
}

/// Where a column and row go on land whose last column and row have a number.
type Way = fn([usize; 2], usize) -> [usize; 2];

#[test]
fn mirrored_and_turned_land_erodes_to_the_same_bits() {
    let settings = Settings { hardening: 5.0, ..Settings::default() };
    let (land, last) = (land(), N - 1);
    let straight = run(land.clone(), &settings, 250);
    let ways: [(&str, Way); 4] = [
        ("mirrored east to west", |[i, j], last| [last - i, j]),
        ("mirrored north to south", |[i, j], last| [i, last - j]),
        ("mirrored along the diagonal", |[i, j], _| [j, i]),
        ("turned by a quarter", |[i, j], last| [last - j, i]),
    ];
    for (name, way) in ways {
        let to = |at: [usize; 2]| way(at, last);
        let mut site = land.clone();
        site.height = moved(&land.height, to);
        site.filled = moved(&land.filled, to);
        site.before = land.before.as_ref().map(|before| moved(before, to));
        let turned = run(site, &settings, 250);
        let (a, b) = (straight.state(), turned.state());
        for (what, a, b) in [
            ("wear", &a.wear, &b.wear),
            ("loose", &a.loose, &b.loose),
            ("water", &a.water, &b.water),
            ("load", &a.load, &b.load),
        ] {
            assert!(moved(a, to) == *b, "{name}: {what} differs");
        }
    }
    assert!(straight.state().wear.iter().any(|w| *w > 1.0), "nothing happened");
}

#[test]
fn threads_and_instruction_sets_give_the_same_bits() {
    let settings = Settings::default();
    let go = |threads: usize, level: Level| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let site = land();
            let (state, dt) = (State::of(&site), settings.longest_step(site.cell));
            let mut run = Run::new(site, state, &settings, dt).on(level);
            (0..120).for_each(|_| run.step(&Work::default()).unwrap());
            (*run.account(), run.into_parts().1)
        })
    };
    let first = go(1, Level::BASELINE);
    for level in Level::available() {
        for threads in [1, 2, 3, 7] {
            assert!(go(threads, level) == first, "{threads} threads, {level:?}");
        }
    }
}
