//! The land that curves make where they lie between samples: smooth along them, in every direction.

use orograph::kit::curves::Transform;
use orograph::node::{Cancel, Context, Node};
use orograph::nodes::curves::diffuse::{Diffuse, Inputs, Quality};
use orograph::value::{Curves, Field, Grid, Terrain};

use super::{curves, grid, raster, samples};

const ANGLES: [f64; 6] = [0.0, 7.0, 17.0, 30.0, 45.0, 73.0];
const MIDDLE: f64 = 80.0;

/// The land of some curves.
pub(super) fn solved(set: &Curves, grid: Grid, quality: Quality) -> Field {
    let (terrain, cancel) = (Terrain::default(), Cancel::default());
    let node = Diffuse { quality, ..Diffuse::default() };
    let inputs = Inputs { constraints: raster(set, &grid), base: None };
    node.run(&Context::bare(grid, &terrain, &cancel), inputs).expect("land").height
}

/// The settled land of some curves.
fn land(set: &Curves, grid: Grid) -> Field {
    solved(set, grid, Quality::Converged)
}

/// The largest error in a straight scene turned about its middle, of the samples whose distance south of the middle line
/// is within bounds. What a scene says it says of that distance.
fn worst(scene: &[&str], within: [f64; 2], truth: impl Fn(f64) -> f64) -> f64 {
    let g = grid([0.0; 2], 1.0, 161);
    let error = |degrees: f64| {
        let turned = Transform { rotate: degrees, pivot: [MIDDLE; 2], ..Transform::default() };
        let field = land(&turned.apply(&curves(scene)).expect("curves"), g);
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let mut worst = 0.0_f64;
        for ([i, j], [x, y]) in samples(&g) {
            let [x, y] = [x - MIDDLE, y - MIDDLE];
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            if along.abs() < 30.0 && within[0] <= across && across <= within[1] {
                let off = f64::from(field.at(i as i64, j as i64)) - truth(across);
                worst = worst.max(off.abs());
            }
        }
        println!("{degrees}°: {worst:.3} m");
        worst
    };
    ANGLES.into_iter().map(error).fold(0.0, f64::max)
}

/// A foot and a rim say heights alone: between them the ground is a plane that meets both lines where they are, not at
/// the samples nearest to them.
#[test]
fn a_wall_between_two_lines_is_a_plane() {
    let scene = [
        r#"{"line":[-200,73.7,360,73.7],"height":[0,100,0]}"#,
        r#"{"line":[-200,86.2,360,86.2],"height":[0,0,0]}"#,
    ];
    let rise = |y: f64| 100.0 * ((6.2 - y) / 12.5).clamp(0.0, 1.0);
    assert!(worst(&scene, [-30.0, 30.0], rise) < 0.1);
}

/// Plateaus end where their radius says.
#[test]
fn the_edges_of_plateaus_lie_between_samples() {
    let scene = [
        r#"{"line":[-200,60,360,60],"height":[0,100,13.4]}"#,
        r#"{"line":[-200,100,360,100],"height":[0,0,14.3]}"#,
    ];
    let rise = |y: f64| 100.0 * ((5.7 - y) / 12.3).clamp(0.0, 1.0);
    assert!(worst(&scene, [-30.0, 30.0], rise) < 0.1);
}

/// What a slope of extent `a` rises over a distance.
fn profile(tan: f64, a: f64, distance: f64) -> f64 {
    let x = distance.clamp(0.0, a);
    tan * x * (1.0 - 0.5 * x / a)
}

#[test]
fn a_ridge_between_samples_keeps_its_crest_and_its_slopes() {
    let scene = [r#"{"line":[-200,80.3,360,80.3],"height":[0,100,0],"slope":[0,25,25,-45,-45]}"#];
    let fall = |y: f64| 100.0 - profile(1.0, 25.0, (y - 0.3).abs());
    assert!(worst(&scene, [-24.0, 24.0], fall) < 0.5);
    let wide = [r#"{"line":[-200,80.3,360,80.3],"height":[0,100,5.6],"slope":[0,25,25,-45,-45]}"#];
    let fall = |y: f64| 100.0 - profile(1.0, 25.0, (y - 0.3).abs() - 5.6);
    assert!(worst(&wide, [-29.0, 29.0], fall) < 0.5);
}

/// A wall without a height of its own is one slope down from the high ground, without a step on its line; what the land
/// is too high or too low for it, by 5.4 m here, the low ground takes.
#[test]
fn a_cliff_is_one_smooth_wall() {
    let scene = [
        r#"{"line":[-200,80.3,360,80.3],"slope":[0,20,20,60,-60]}"#,
        r#"{"line":[-200,40,360,40],"height":[0,40,0]}"#,
        r#"{"line":[-200,120,360,120],"height":[0,0,0]}"#,
    ];
    let tan = libm::tan(60_f64.to_radians());
    let fall = |y: f64| 40.0 - 17.3205 + profile(tan, 20.0, (y - 0.3).abs()).copysign(0.3 - y);
    // Half smoothness rounds it by some hundredths of its height.
    assert!(worst(&scene, [-19.0, 19.0], fall) < 2.0);
}

/// Walls that rise on both sides meet in a valley where the line is.
#[test]
fn a_crack_has_its_bottom_on_its_line() {
    let scene = [
        r#"{"line":[-200,80.3,360,80.3],"slope":[0,20,20,60,60]}"#,
        r#"{"line":[-200,40,360,40],"height":[0,100,0]}"#,
        r#"{"line":[-200,120,360,120],"height":[0,100,0]}"#,
    ];
    let tan = libm::tan(60_f64.to_radians());
    let rise = |y: f64| 100.0 - 17.3205 + profile(tan, 20.0, (y - 0.3).abs());
    assert!(worst(&scene, [-19.0, 19.0], rise) < 2.0);
}
