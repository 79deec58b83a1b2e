//! Surfaces whose flow is known in closed form.

use orograph::kit::flow::{Rule, Spread, accumulate, wetness};
use orograph::work::Work;

use super::ground::Ground;
use super::routing::{filled, tree};

#[test]
fn d_infinity_is_exact_on_planes() {
    let n = 21;
    for degree in (0..360).step_by(7).chain([45, 90, 135, 180, 225, 270, 315]) {
        let (south, east) = libm::sincos(f64::from(degree).to_radians());
        let ground = Ground::of(n, n, |c, r| (1000.0 - 3.0 * (c as f64 * east + r as f64 * south)) as f32);
        let (tree, filled) = (tree(&ground), filled(&ground));
        let spread = Spread::new(ground.surface(), &tree, &filled, Rule::Infinity);
        for (c, r) in (1..n - 1).flat_map(|c| (1..n - 1).map(move |r| (c, r))) {
            let [x, y] = spread.direction(r * n + c);
            // Heights of a thousand metres have six decimals in an f32.
            assert!((x - east).abs() < 1e-4 && (y - south).abs() < 1e-4, "{degree}°: {x}, {y} at {c}, {r}");
            // The share of each is by the angle between.
            let shares = spread.shares(r * n + c);
            let turned = f64::from(degree) / 45.0;
            let largest = shares.iter().copied().fold(0.0, f64::max);
            let wanted = (turned.fract()).max(1.0 - turned.fract());
            assert!((largest - wanted).abs() < 1e-3, "{degree}°: {shares:?}");
        }
    }
}

#[test]
fn area_on_a_plane_along_an_axis_is_the_number_of_cells_above() {
    let ground = Ground::of(13, 17, |_, r| r as f32);
    let (tree, filled, work) = (tree(&ground), filled(&ground), Work::default());
    let count = accumulate::count(&tree, |_| true, &work).unwrap();
    let spread = Spread::new(ground.surface(), &tree, &filled, Rule::Infinity);
    let infinity = spread.accumulate(vec![1.0; ground.len()], &work).unwrap();
    for cell in 0..ground.len() {
        let above = 17 - cell / 13;
        assert_eq!((count[cell], infinity[cell]), (above as u32, above as f64));
    }
}

#[test]
fn area_on_a_cone_spreads_evenly() {
    // Area over width of contour on a cone is r/2; D8 makes a star of it.
    let n = 201;
    let distance = |c: usize, r: usize| libm::hypot(c as f64 - 100.0, r as f64 - 100.0);
    let ground = Ground::of(n, n, |c, r| (1000.0 - distance(c, r)) as f32);
    let (tree, filled, work) = (tree(&ground), filled(&ground), Work::default());
    let worst = |area: &[f64]| {
        let ring = (0..n * n).filter(|i| (79.5..80.5).contains(&distance(i % n, i / n)));
        ring.map(|i| (area[i] / 40.0 - 1.0).abs()).fold(0.0, f64::max)
    };
    let spread = |rule| Spread::new(ground.surface(), &tree, &filled, rule);
    let of = |rule| spread(rule).accumulate(vec![1.0; n * n], &work).unwrap();
    let d8: Vec<f64> = accumulate::along(&tree, vec![1.0; n * n], &work).unwrap();
    let [infinity, freeman] = [Rule::Infinity, Rule::Slopes { exponent: 1.1 }].map(of);
    let (infinity, freeman, d8) = (worst(&infinity), worst(&freeman), worst(&d8));
    assert!(infinity < 0.35 && freeman < 0.35 && d8 > 0.8, "{infinity} {freeman} {d8}");
}

#[test]
fn wetness_of_a_plane_is_that_of_its_slope() {
    let (slope, cell) = (0.2, 10.0);
    let ground = Ground::of(9, 31, |_, r| r as f32 * (slope * cell) as f32);
    let tree = tree(&ground);
    let area = accumulate::along(&tree, vec![cell * cell; ground.len()], &Work::default()).unwrap();
    let at = 4 * 9 + 4;
    let index = wetness::index(area[at], cell, slope, 1e-3);
    assert!((index - libm::log(27.0 * cell / slope)).abs() < 1e-12, "{index}");
    assert_eq!(wetness::index(500.0, cell, -1.0, 0.5), libm::log(100.0));
    assert!(wetness::index(0.0, cell, 0.0, 1e-3).is_finite());
}

#[test]
fn height_above_a_river_is_over_where_it_is_met() {
    // A valley along the middle column that falls to the south; its sides fall to it.
    let ground = Ground::of(21, 40, |c, r| 4.0 * (c as f32 - 10.0).abs() + (39 - r) as f32);
    let tree = tree(&ground);
    let river = |cell: usize| cell % 21 == 10;
    let found = wetness::above_river(&tree, |i| ground.height[i], river, &Work::default()).unwrap();
    for (cell, &above) in found.iter().enumerate() {
        let meets = super::routing::way(&tree, cell).into_iter().find(|&i| river(i)).unwrap();
        assert_eq!(above, ground.height[cell] - ground.height[meets]);
    }
}
