//! Global nodes run on the base grid and are carried to the build grid (law 3).

use serde_json::json;

use super::{chain, engine, evaluate, field, graph, grid, want};

#[test]
fn carrying_adds_a_global_change_and_leaves_the_rest_bit_for_bit() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "detail": { "kind": "waves", "set": { "height": 5, "length": 40 } },
        "rough": { "kind": "sum", "in": { "a": "hills.field", "b": "detail.field" } },
        "dug": { "kind": "dig", "in": { "field": "rough.field" } },
    }));
    let fine = grid(&g, 1025);
    let e = engine(2);
    let before = field(&evaluate(&e, &g, "rough", fine), 0);
    let after = field(&evaluate(&e, &g, "dug", fine), 0);
    let mut unchanged = 0;
    for j in 0..fine.rows {
        for i in 0..fine.cols {
            let (x, a, b) = (fine.x(i), before.row(j)[i], after.row(j)[i]);
            let wanted = if x < 2048.0 { -50.0 * (1.0 - x / 2048.0) } else { 0.0 };
            // Linear where it acts, with a kink in the middle of the terrain: the spline rounds only that.
            let near = (x - 2048.0).abs() < 4.0 * 32.0;
            assert!((f64::from(b - a) - wanted).abs() < if near { 0.5 } else { 2e-3 }, "at {x}: {a} to {b}");
            if x > 2048.0 + 2.0 * 32.0 {
                assert_eq!(a.to_bits(), b.to_bits());
                unchanged += 1;
            }
        }
    }
    assert!(unchanged > 200_000);
    let base = field(&evaluate(&e, &g, "dug", grid(&g, 129)), 0);
    let direct = field(&evaluate(&e, &g, "rough", grid(&g, 129)), 0);
    assert_eq!(base.at(100, 20), direct.at(100, 20));
    assert_eq!(base.at(0, 20), direct.at(0, 20) - 50.0);
}

#[test]
fn sizes_agree_within_a_share_of_the_relief() {
    let g = chain();
    let e = engine(2);
    let at = |size| field(&evaluate(&e, &g, "end", grid(&g, size)), 0);
    let base = at(129);
    let (lo, hi) = base.range().unwrap();
    for (size, factor) in [(257, 2), (513, 4)] {
        let fine = at(size);
        let mut errors: Vec<f32> = Vec::new();
        for j in 0..base.grid().rows as i64 {
            for i in 0..base.grid().cols as i64 {
                errors.push((base.at(i, j) - fine.at(i * factor, j * factor)).abs());
            }
        }
        errors.sort_by(f32::total_cmp);
        let worst = errors[errors.len() * 99 / 100];
        assert!(worst <= 0.01 * (hi - lo), "{size}: {worst} of {}", hi - lo);
    }
}

#[test]
fn plans_name_features_narrower_than_two_base_cells() {
    let too_narrow = |metres: f64| {
        let g = graph(json!({
            "hills": { "kind": "waves" },
            "dug": { "kind": "dig", "set": { "narrowest": metres }, "in": { "field": "hills.field" } },
        }));
        let plan = engine(1).plan(&g, &[want(&g, "dug", grid(&g, 33))]);
        plan.too_narrow().into_iter().map(|(node, width)| (node.to_owned(), width)).collect::<Vec<_>>()
    };
    // Cells of the base grid are 32 m.
    assert_eq!(too_narrow(63.0), [("dug".to_owned(), 63.0)]);
    assert_eq!(too_narrow(64.0), []);
}
