//! Turned, mirrored and reversed curves give turned, mirrored and reversed maps.

use orograph::kit::curves::{Mirror, Transform, merge};
use orograph::value::{Constraints, Curves, Mark};

use super::{curves, grid, raster, samples};

fn scene() -> Curves {
    curves(&[
        r#"{"through":[-70,-50,-20,10,15,-30,60,40],"height":[0,100,4,0.4,150,2,1,90,6],"slope":[0,30,14,-35,20,1,10,25,-20,-40],"noise":[0,9,0.5]}"#,
        r#"{"line":[-80,60,0,60,0,20,60,-60],"slope":[0,12,18,50,30],"envelope":[0,9,4,1,2,7]}"#,
        r#"{"line":[-60,-80,40,-80,-50,-70],"height":[0,40,3],"slope":[0,20,20,-10,-10]}"#,
    ])
}

/// What stands at each sample must be what stands at its image, with directions mapped as well.
fn same(a: &Constraints, b: &Constraints, image: impl Fn([f64; 2]) -> [f64; 2]) {
    let g = *a.grid();
    let (mut differ, mut marked) = (0, 0);
    for (at, p) in samples(&g) {
        let q = image(p);
        let there = [0, 1].map(|k| ((q[k] - g.lattice.origin[k]) / g.cell()).round() as usize);
        let close = |x: f32, y: f32| (x - y).abs() <= 1e-4 * (1.0 + x.abs());
        let heights = match (a.height(at), b.height(there)) {
            (Some(x), Some(y)) => close(x, y),
            (x, y) => x == y,
        };
        let gradients = match (a.gradient(at), b.gradient(there)) {
            (Some((n, s)), Some((m, t))) => {
                let n = image(n.map(f64::from)).map(|x| x as f32);
                close(s, t) && close(n[0], m[0]) && close(n[1], m[1])
            }
            (x, y) => x.is_some() == y.is_some(),
        };
        let rest = a.has(Mark::Open, at) == b.has(Mark::Open, there)
            && a.noise(at) == b.noise(there)
            && close(a.envelope(at), b.envelope(there));
        marked += usize::from(a.height(at).is_some() || a.gradient(at).is_some());
        // Rounding decides about cells on the very edge.
        differ += usize::from(!(heights && gradients && rest));
    }
    assert!(marked > 2000 && differ <= marked / 500, "{differ} of {marked} differ");
}

#[test]
fn mirrored_curves_give_the_mirrored_map() {
    let g = grid([-100.0; 2], 1.0, 201);
    let set = scene();
    let a = raster(&set, &g);
    let east_west = Transform { mirror: Mirror::EastWest, ..Transform::default() };
    same(&a, &raster(&east_west.apply(&set).expect("curves"), &g), |[x, y]| [-x, y]);
    let north_south = Transform { mirror: Mirror::NorthSouth, ..Transform::default() };
    same(&a, &raster(&north_south.apply(&set).expect("curves"), &g), |[x, y]| [x, -y]);
}

#[test]
fn quarter_turns_go_clockwise() {
    let g = grid([-100.0; 2], 1.0, 201);
    let set = scene();
    let turned = Transform { rotate: 90.0, ..Transform::default() }.apply(&set).expect("curves");
    // North, which is −y, goes to the east.
    same(&raster(&set, &g), &raster(&turned, &g), |[x, y]| [-y, x]);
    let back = Transform { rotate: -90.0, ..Transform::default() }.apply(&turned).expect("curves");
    assert_eq!(back, set);
}

#[test]
fn a_reversed_curve_with_its_sides_changed_gives_the_same_map() {
    let g = grid([-100.0; 2], 1.0, 201);
    let forth = r#"{"through":[-70,-50,-20,10,15,-30,60,40],"height":[0,100,4,1,90,6],"slope":[0,30,14,-35,20,1,10,25,-20,-40]}"#;
    let back = r#"{"through":[60,40,15,-30,-20,10,-70,-50],"height":[0,90,6,1,100,4],"slope":[0,25,10,-40,-20,1,14,30,20,-35]}"#;
    same(&raster(&curves(&[forth]), &g), &raster(&curves(&[back]), &g), |p| p);
}

#[test]
fn scaling_keeps_the_shape_of_the_ground() {
    let set = scene();
    let t = Transform {
        scale: 2.0,
        height_scale: 3.0,
        raise: 10.0,
        pivot: [5.0, 5.0],
        shift: [100.0, -40.0],
        rotate: 30.0,
        mirror: Mirror::None,
    };
    let scaled = t.apply(&set).expect("curves");
    for (a, b) in set.iter().zip(scaled.iter()) {
        assert!((b.length() - 2.0 * a.length()).abs() < 1e-6 * b.length());
        let (p, q) = (a.attributes(0.37), b.attributes(0.37));
        if let (Some(p), Some(q)) = (p.elevation, q.elevation) {
            assert!(
                (q.height - (3.0 * p.height + 10.0)).abs() < 1e-9 && (q.radius - 2.0 * p.radius).abs() < 1e-9
            );
        }
        let (p, q) = (a.attributes(0.0).slope.expect("slopes"), b.attributes(0.0).slope.expect("slopes"));
        assert!(
            (libm::tan(q.left_angle.to_radians()) - 1.5 * libm::tan(p.left_angle.to_radians())).abs() < 1e-9
        );
        assert!((q.right_extent - 2.0 * p.right_extent).abs() < 1e-9);
    }
    for (name, bad) in [
        ("scale", Transform { scale: 0.0, ..t }),
        ("shift", Transform { shift: [f64::NAN, 0.0], ..t }),
        ("rotate", Transform { rotate: f64::INFINITY, ..t }),
    ] {
        assert!(bad.apply(&set).is_err_and(|e| e.to_string().contains(name)), "{name}");
    }
    assert_eq!(merge([&set, &scaled]).expect("merged").len(), 6);
}
