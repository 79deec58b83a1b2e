//! Kinds that read an input on further windows: near things on the build's lattice, far ones on the base grid's.

use orograph::engine::{Stage, Unobserved};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::Grid;
use serde_json::json;

use crate::engine::{engine, evaluate, field, graph, want};
use crate::rig::grid;

fn around() -> Graph {
    graph(json!({
        "hills": { "kind": "waves", "set": { "height": 200, "seed": 7 } },
        "end": { "kind": "around", "in": { "field": "hills.field" } },
    }))
}

#[test]
fn tiles_equal_the_crop_above_and_below_the_base_grid() {
    let g = around();
    for size in [65, 129, 257, 513] {
        let whole_grid = grid(g.terrain(), size);
        let whole = field(&evaluate(&engine(2), &g, "end", whole_grid), 0);
        for (col, row) in [(0, 0), (40, 12), (48, 16)] {
            let tile = Grid { col, row, cols: 17, rows: 17, ..whole_grid };
            let alone = field(&evaluate(&engine(2), &g, "end", tile), 0);
            assert!(alone == whole.crop(&tile), "{size} at {col}, {row}");
        }
    }
}

#[test]
fn a_view_ends_at_the_apron_and_is_read_once_with_the_build_where_the_lattices_are_one() {
    let mut g = around();
    g.assign("end.radius", "20000").unwrap();
    let e = engine(1);
    let runs = |size: u32| {
        let plan = e.plan(&g, &[want(&g, "end", grid(g.terrain(), size))]);
        let all = plan.tasks().into_iter().filter(|t| t.node == "hills" && t.stage == Stage::Run);
        let mut grids: Vec<Grid> = all.map(|t| t.grid.unwrap()).collect();
        grids.sort_by_key(|g| g.lattice.intervals);
        grids
    };
    let base = grid(g.terrain(), 129);
    let apron = g.terrain().apron(base.lattice);
    assert_eq!(runs(129), [apron], "one evaluation serves both");
    assert_eq!(runs(257), [apron, grid(g.terrain(), 257)], "the build's own and the base grid's");
    evaluate(&e, &g, "end", grid(g.terrain(), 257));
    let far = field(&evaluate(&e, &g, "end", base), 0);
    assert!(far.data().iter().all(|v| v.is_finite()));
}

#[test]
fn a_view_does_not_make_the_result_coarser_but_is_in_its_key() {
    let mut g = around();
    let e = engine(1);
    let fine = evaluate(&e, &g, "end", grid(g.terrain(), 513));
    assert_eq!(fine.effective_cells, [Some(8.0)]);
    let end = g.find("end").unwrap();
    let before = e.key(&g, end);
    g.assign("terrain.base", "65").unwrap();
    assert_ne!(e.key(&g, end), before);
}

#[test]
fn a_view_of_a_kind_that_does_not_declare_the_base_grid_is_refused() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "end": { "kind": "glances", "in": { "field": "hills.field" } },
    }));
    let all = engine(1)
        .evaluate(&g, &[want(&g, "end", grid(g.terrain(), 65))], &Unobserved, &Cancel::default())
        .unwrap();
    let said = all.values[0].as_ref().unwrap_err().to_string();
    assert!(said.contains("asks for `BASE`"), "{said}");
}

#[test]
fn files_of_the_kinds_before_they_read_the_base_grid_open_as_they_are() {
    let old = r#"{"orograph": 1, "kinds": {"fractal_noise": 1, "occlusion": 1, "transform": 1, "warp": 1}, "nodes": {
        "land": {"kind": "fractal_noise"},
        "bent": {"kind": "warp", "in": {"field": "land.field"}, "set": {"limit": 90, "seed": 3}},
        "moved": {"kind": "transform", "in": {"field": "bent.field"}, "set": {"rotate": 30}},
        "sky": {"kind": "occlusion", "in": {"height": "moved.field"}, "set": {"radius": 700, "detail": 12}}},
        "outputs": {"sky": {"from": "sky.visibility"}}}"#;
    let g = Graph::from_bytes(old.as_bytes(), &orograph::nodes::Registry::standard()).unwrap();
    assert_eq!(g.problems().len(), 0, "{:?}", g.problems());
    assert_eq!(g.to_bytes(), old.as_bytes(), "what is not edited stays");
    let text = String::from_utf8(g.canonical().to_vec()).unwrap();
    assert!(text.contains(r#""occlusion": 2, "transform": 2, "warp": 2"#), "{text}");
    assert!(text.contains(r#""set": { "radius": 700, "detail": 12 }"#), "{text}");
}
