//! The spectrum against surfaces whose spectrum is chosen.

use std::f64::consts::TAU;

use orograph::kit::geomorphometry::{Land, Spectrum};
use orograph::kit::hash;

use super::{figures, land, near};

/// A sum of waves of all directions and, by their logarithms, of all lengths, with power `k^−β`.
///
/// As many waves in each equal ratio of wavenumbers stand for `k²` as many in each equal area of them, so that each has
/// the power `k^(2−β)`.
fn surface(size: usize, beta: f64, seed: u64) -> Land {
    const WAVES: u64 = 1500;
    let mut heights = vec![0.0f64; size * size];
    let (low, high) = (0.5 / size as f64, 0.5);
    for wave in 0..WAVES {
        let number = |n: u64| hash::unit(seed, wave * 3 + n);
        // One in each of so many equal steps: less is left to chance.
        let k = low * libm::exp(libm::log(high / low) * (wave as f64 + number(0)) / WAVES as f64);
        let (angle, phase) = (TAU * number(1), TAU * number(2));
        let amplitude = libm::pow(k, 0.5 * (2.0 - beta));
        let (x, y) = (TAU * k * libm::cos(angle), TAU * k * libm::sin(angle));
        let (turn, shift) = (libm::sin(x), libm::cos(x));
        for (j, row) in heights.chunks_exact_mut(size).enumerate() {
            let (mut s, mut c) = (libm::sin(phase + y * j as f64), libm::cos(phase + y * j as f64));
            for z in row {
                *z += amplitude * c;
                (s, c) = (s * shift + c * turn, c * shift - s * turn);
            }
        }
    }
    Land::new(size, size, 30.0, heights.into_iter().map(|z| z as f32).collect())
}

fn spectrum(land: &Land) -> Spectrum {
    figures(land).spectrum.expect("a spectrum")
}

#[test]
fn a_fractal_surface_has_the_exponent_it_was_made_with() {
    for (seed, beta) in [(1, 2.6), (2, 3.4), (3, 4.2)] {
        let found = spectrum(&surface(192, beta, seed));
        near(found.beta, beta, 0.5);
        near(found.beta_fine.expect("fine waves"), beta, 0.6);
        near(found.beta_coarse.expect("coarse waves"), beta, 0.6);
        near(found.hurst, (found.beta - 2.0) / 2.0, 1e-12);
        assert!(found.beta_r2 > 0.9, "{found:?}");
        near(found.finest_power.expect("finest waves"), 1.0, 0.6);
        assert_eq!(found.window, [192, 192]);
    }
}

#[test]
fn stripes_along_the_grid_are_told_apart() {
    let fractal = surface(128, 3.0, 5);
    let striped = |along: fn(usize) -> usize| {
        let row = |k: usize| 200.0 * libm::sin(TAU * along(k) as f64 / 6.4) as f32;
        let heights = fractal.heights().iter().enumerate().map(|(k, z)| z + row(k));
        spectrum(&Land::new(128, 128, 30.0, heights.collect()))
    };
    let plain = spectrum(&fractal);
    let both = |found: Spectrum| [found.stripes_east_west.unwrap(), found.stripes_north_south.unwrap()];
    let [east, south] = both(plain);
    assert!(east < 2.0 && south < 2.0, "{plain:?}");
    // What changes from row to row are stripes from west to east.
    let [along, across] = both(striped(|k| k / 128));
    assert!(along > 3.0 && across < 2.0, "{along} {across}");
    let [across, along] = both(striped(|k| k % 128));
    assert!(along > 3.0 && across < 2.0, "{along} {across}");
}

#[test]
fn enlarged_land_lacks_the_finest_waves() {
    let rough = surface(97, 3.0, 7);
    let at = |i: usize, j: usize| rough.heights()[j * 97 + i];
    // Between two samples lies their mean.
    let height = |k: usize| {
        let (i, j) = (k % 193, k / 193);
        let corners =
            [(i / 2, j / 2), (i.div_ceil(2), j / 2), (i / 2, j.div_ceil(2)), (i.div_ceil(2), j.div_ceil(2))];
        corners.map(|(i, j)| at(i, j)).iter().sum::<f32>() / 4.0
    };
    let smooth = spectrum(&Land::new(193, 193, 30.0, (0..193 * 193).map(height).collect()));
    assert!(smooth.finest_power.expect("finest waves") < 0.5, "{smooth:?}");
}

/// The spectrum is that of the largest rectangle without a void, wherever the voids lie.
#[test]
fn the_largest_rectangle_is_measured() {
    let hole = |i: f64, j: f64| {
        let z = 30.0 * libm::sin(i * i * 0.013 + j * 0.31);
        if (i, j) == (20.0, 50.0) || i > 140.0 { f64::NAN } else { z }
    };
    let found = spectrum(&land(150, 100, 10.0, hole));
    assert_eq!(found.window, [120, 100]);
    assert_eq!(figures(&land(63, 200, 10.0, hole)).spectrum, None);
}
