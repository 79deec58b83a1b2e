//! Masks mix outputs with inputs.

use serde_json::json;

use super::{bits, engine, evaluate, field, graph, grid};

#[test]
fn masks_select_exactly_at_their_ends() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "zero": { "kind": "constant", "set": { "value": 0 } },
        "one": { "kind": "constant", "set": { "value": 1 } },
        "half": { "kind": "constant", "set": { "value": 0.5 } },
        "plain": { "kind": "smooth", "in": { "field": "hills.field" } },
        "none": { "kind": "smooth", "in": { "field": "hills.field", "mask": "zero.field" } },
        "all": { "kind": "smooth", "in": { "field": "hills.field", "mask": "one.field" } },
        "some": { "kind": "smooth", "in": { "field": "hills.field", "mask": "half.field" } },
    }));
    let e = engine(2);
    let of = |node| field(&evaluate(&e, &g, node, grid(&g, 65)), 0);
    assert_eq!(bits(&of("none")), bits(&of("hills")));
    assert_eq!(bits(&of("all")), bits(&of("plain")));
    let (a, b, m) = (of("hills").at(9, 9), of("plain").at(9, 9), of("some").at(9, 9));
    assert!((m - (a + b) / 2.0).abs() < 1e-4);
}
