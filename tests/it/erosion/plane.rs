//! Water on tilted planes runs down the fall line as Manning says, whatever its direction on the grid.

use super::land::{run, site, still};

/// Discharge over that of Manning and the angle to the fall line in degrees, in the middle of a plane that falls by `slope`
/// towards an angle from the east, from a height.
fn flow(angle: f64, slope: f64, height: f64) -> [f64; 2] {
    let (n, cell, steps) = (97, 16.0, 500);
    let (sin, cos) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
    let at = |k: usize| height - slope * cell * (cos * (k % n) as f64 + sin * (k / n) as f64);
    let heights = (0..n * n).map(|k| at(k) as f32).collect();
    let run = run(site(n, cell, heights, 100.0, false), &still(), steps);
    let (site, state) = (run.site(), run.state());
    let (mut sum, mut deep, mut count) = ([0.0; 2], 0.0, 0.0);
    for k in (0..n * n).filter(|k| (44..53).contains(&(k % n)) && (44..53).contains(&(k / n))) {
        let v = state.vector(site, k);
        sum = [sum[0] + f64::from(v[0]), sum[1] + f64::from(v[1])];
        deep += libm::pow(f64::from(state.depth(site, k)), 5.0 / 3.0);
        count += 1.0;
    }
    let manning = deep / count * slope.sqrt() / 0.05;
    let turned = libm::atan2(sum[1], sum[0]).to_degrees() - angle;
    [libm::hypot(sum[0], sum[1]) / count / manning, turned]
}

#[test]
fn planes_carry_what_manning_says_down_the_fall_line() {
    for angle in [0.0, 11.25, 22.5, 33.75, 45.0] {
        // At 8000 m an f32 has no bits for a film: differences must be taken first.
        for (slope, height) in [(0.1, 500.0), (0.02, 8000.0)] {
            let [discharge, turned] = flow(angle, slope, height);
            println!("{angle} {slope}: {discharge:.4} of Manning, {turned:.3} degrees off");
            assert!((discharge - 1.0).abs() < 0.01, "{angle}, {slope}: {discharge} of Manning's discharge");
            assert!(turned.abs() < 0.5, "{angle}, {slope}: {turned} degrees off");
        }
    }
}
