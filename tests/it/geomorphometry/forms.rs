//! Land whose figures are known in closed form.

use std::f64::consts::{PI, TAU};

use super::{figures, land, near};

#[test]
fn a_plane_has_one_slope_and_one_direction() {
    // It falls to the north-east, more to the east: 0.3 m a metre in all.
    let (east, north) = (0.3 * libm::cos(0.3), 0.3 * libm::sin(0.3));
    let found = figures(&land(90, 70, 20.0, |i, j| 5000.0 - 20.0 * (east * i - north * j)));
    let slope = found.slope.expect("slopes");
    let degrees = libm::atan(0.3).to_degrees();
    for share in [slope.mean, slope.p5, slope.p50, slope.p95, slope.p99] {
        near(share, degrees, 2e-3);
    }
    assert_eq!((slope.steeper_than_35, slope.flatter_than_half), (0.0, 0.0));
    let aspect = found.aspect.expect("directions");
    near(aspect.m1, 1.0, 1e-6);
    near(aspect.m2, 1.0, 1e-6);
    near(aspect.m4, libm::cos(1.2), 1e-3);
    near(aspect.m8, libm::cos(2.4), 1e-3);
    near(aspect.used, 1.0, 0.0);
    near(found.hypsometry.integral, 0.5, 1e-6);
    near(found.hypsometry.skewness, 0.0, 1e-5);
    assert_eq!(found.spectrum, None, "a plane has no waves");
    assert_eq!((found.depressions.pits_per_1000, found.depressions.filled), (0.0, 0.0));
    assert_eq!(found.land, 1.0);
}

#[test]
fn a_cone_fills_a_third_of_its_cylinder_and_faces_everywhere() {
    let (middle, radius) = (150.0, 149.0);
    let found = figures(&land(301, 301, 10.0, |i, j| {
        let r = libm::hypot(i - middle, j - middle);
        if r > radius { f64::NAN } else { 1000.0 * (1.0 - r / radius) }
    }));
    near(found.hypsometry.integral, 1.0 / 3.0, 2e-3);
    near(found.land, PI * radius * radius / (301.0 * 301.0), 2e-3);
    let slope = found.slope.expect("slopes");
    near(slope.p50, libm::atan(1000.0 / (radius * 10.0)).to_degrees(), 0.01);
    let aspect = found.aspect.expect("directions");
    for harmonic in [aspect.m1, aspect.m2, aspect.m4, aspect.m8] {
        near(harmonic, 0.0, 2e-3);
    }
    assert_eq!(found.depressions.pits_per_1000, 0.0);
}

#[test]
fn a_wave_has_the_slopes_of_its_derivative() {
    // Without the fraction the samples would stand on the same phases over and over.
    let (length, height) = (40.3, 30.0);
    let found = figures(&land(256, 128, 5.0, |i, _| height * libm::sin(TAU * i / length)));
    let steepest = height * TAU / (length * 5.0);
    let at = |share: f64| libm::atan(steepest * libm::sin(share * PI / 2.0)).to_degrees();
    let slope = found.slope.expect("slopes");
    for (found, share) in [(slope.p5, 0.05), (slope.p50, 0.5), (slope.p95, 0.95), (slope.p99, 0.99)] {
        near(found, at(share), 0.5);
    }
    let aspect = found.aspect.expect("directions");
    near(aspect.m2, 1.0, 1e-6);
    near(aspect.m4, 1.0, 1e-6);
    near(aspect.m8, 1.0, 1e-6);
    for scale in &found.curvature {
        near(scale.skewness, 0.0, 0.03);
        near(scale.asymmetry, 0.0, 0.03);
    }
}

#[test]
fn sharp_valleys_and_sharp_ridges_have_opposite_skewness() {
    let folds =
        |sign: f64| figures(&land(200, 200, 10.0, |i, j| sign * 80.0 * libm::sin((i + 0.3 * j) / 9.0).abs()));
    let (valleys, ridges) = (folds(1.0), folds(-1.0));
    assert_eq!(valleys.curvature.len(), 3);
    for (valley, ridge) in valleys.curvature.iter().zip(&ridges.curvature) {
        assert!(valley.skewness > 0.3, "{valley:?}");
        near(valley.skewness, -ridge.skewness, 1e-3);
        near(valley.asymmetry, -ridge.asymmetry, 1e-3);
    }
}

/// The Laplacian against sums over the whole square of a kernel.
#[test]
fn curvature_is_that_of_the_whole_kernel() {
    let n = 60;
    let height = |i: f64, j: f64| 40.0 * libm::sin(0.7 * i + 0.001 * i * j) + 25.0 * libm::cos(0.05 * j * j);
    let found = figures(&land(n, n, 1.0, height));
    for scale in found.curvature.iter().filter(|scale| scale.sigma < 4) {
        let (sigma, reach) = (scale.sigma as f64, 4 * scale.sigma as i64);
        let bell = |x: i64| libm::exp(-0.5 * (x * x) as f64 / (sigma * sigma));
        let mass: f64 = (-reach..=reach).map(bell).sum();
        let second = |x: i64| ((x * x) as f64 / (sigma * sigma) - 1.0) / (sigma * sigma);
        let mirror = |k: i64| {
            (if k < 0 {
                -1 - k
            } else if k >= n as i64 {
                2 * n as i64 - 1 - k
            } else {
                k
            }) as f64
        };
        let at = |i: i64, j: i64| {
            let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
            let each = square.map(|(x, y)| {
                let weight = bell(x) * bell(y) / (mass * mass) * (second(x) + second(y));
                weight * f64::from(height(mirror(i + x), mirror(j + y)) as f32)
            });
            each.sum::<f64>()
        };
        let core = (6..n as i64 - 6).flat_map(|j| (6..n as i64 - 6).map(move |i| (i, j)));
        let all: Vec<f64> = core.map(|(i, j)| at(i, j)).collect();
        let mean = |f: &dyn Fn(f64) -> f64| all.iter().map(|l| f(*l)).sum::<f64>() / all.len() as f64;
        let middle = mean(&|l| l);
        let deviation = mean(&|l| (l - middle) * (l - middle)).sqrt();
        let skewness =
            mean(&|l| (l - middle) * (l - middle) * (l - middle)) / (deviation * deviation * deviation);
        near(scale.skewness, skewness, 1e-4);
    }
}

#[test]
fn blocks_have_the_means_of_their_land() {
    let given = land(7, 5, 10.0, |i, j| if i < 2.0 && j < 1.0 { f64::NAN } else { i + 10.0 * j });
    let found = given.clone().averaged(2);
    assert_eq!((found.cols(), found.rows(), found.cell()), (3, 2, 20.0));
    // The first block has half its cells.
    assert_eq!(found.heights(), [10.5, 7.5, 9.5, 25.5, 27.5, 29.5]);
    let sparse = land(2, 2, 10.0, |i, j| if i + j > 0.0 { f64::NAN } else { 7.0 }).averaged(2);
    assert!(sparse.heights()[0].is_nan());
    // Without the voids, which are not equal to themselves.
    assert_eq!(given.clone().averaged(1).heights()[2..], given.heights()[2..]);
    for (target, side) in [(1.0, 1), (13.9, 1), (14.1, 2), (24.0, 2), (25.0, 2), (26.0, 3), (90.0, 9)] {
        assert_eq!(given.block(target), side, "{target}");
    }
}

#[test]
fn the_sea_is_no_land() {
    let found = figures(&land(80, 60, 10.0, |i, _| i - 20.0).above_sea(0.0));
    near(found.land, 59.0 / 80.0, 1e-12);
    assert_eq!((found.hypsometry.lowest, found.hypsometry.highest), (1.0, 59.0));
}
