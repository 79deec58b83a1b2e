//! Land that the tests rain on.

use orograph::kit::erosion::hydraulic::{Run, Settings, Site, State};
use orograph::kit::hash;
use orograph::work::Work;

/// Smooth noise of a wavelength in cells at a place in cells, −1 to 1.
pub(super) fn noise(seed: u64, wavelength: f64, [x, y]: [f64; 2]) -> f64 {
    let [u, v] = [x / wavelength, y / wavelength];
    let at = |i: f64, j: f64| hash::unit(seed, ((i + 5000.0) * 10_000.0 + j + 5000.0) as u64) * 2.0 - 1.0;
    let ease = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let [i, j] = [u.floor(), v.floor()];
    let [a, b] = [ease(u - i), ease(v - j)];
    let row = |j: f64| at(i, j) + (at(i + 1.0, j) - at(i, j)) * a;
    row(j) + (row(j + 1.0) - row(j)) * b
}

/// Noise of many wavelengths, the longest in cells, −1 to 1 or so.
pub(super) fn fractal(seed: u64, longest: f64, at: [f64; 2]) -> f64 {
    let octave = |k: u32| {
        let part = 1.0 / f64::from(1 << k);
        noise(seed + u64::from(k), longest * part, at) * part
    };
    (0..7).map(octave).sum()
}

/// Heights of an island of so many samples across.
pub(super) fn island(n: usize, relief: f64, seed: u64) -> Vec<f32> {
    let half = (n - 1) as f64 / 2.0;
    let height = |k: usize| {
        let [x, y] = [(k % n) as f64, (k / n) as f64];
        let (u, v) = ((x - half) / half, (y - half) / half);
        let far = u * u + v * v;
        (0.62 - far + 0.5 * fractal(seed, half / 1.6, [x, y])) * relief
    };
    (0..n * n).map(|k| height(k) as f32).collect()
}

/// An open site of so many samples across with even rain in mm/h; a sea at 0 m fills what lies below.
pub(super) fn site(n: usize, cell: f64, height: Vec<f32>, rain: f64, sea: bool) -> Site {
    let mut site = Site::new(n, n, cell, height);
    site.rain = vec![(rain / 3.6e6) as f32; n * n];
    if sea {
        site.sea = Some(0.0);
        site.filled.iter_mut().for_each(|h| *h = h.max(0.0));
    }
    site.open = true;
    site
}

/// A level after so many of the longest steps.
pub(super) fn run(site: Site, settings: &Settings, steps: usize) -> Run {
    let (state, dt) = (State::of(&site), settings.longest_step(site.cell));
    let mut run = Run::new(site, state, settings, dt);
    for _ in 0..steps {
        run.step(&Work::default()).unwrap();
    }
    run
}

/// Settings under which water runs and ground stays.
pub(super) fn still() -> Settings {
    Settings { capacity: 0.0, rock_repose: 1e3, loose_repose: 1e3, ..Settings::default() }
}
