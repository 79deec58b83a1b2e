//! Tiles, windows, sizes and threads give the same bits (laws 2 to 5).

use orograph::value::{Grid, Terrain};
use serde_json::json;

use super::{bits, chain, engine, evaluate, field, graph, grid};

#[test]
fn tiles_equal_the_whole_bit_for_bit() {
    let g = chain();
    for size in [65, 129, 257, 513] {
        let whole_grid = grid(&g, size);
        let whole = field(&evaluate(&engine(2), &g, "end", whole_grid), 0);
        let steps = [(whole_grid.cols - 1) / 4, (whole_grid.rows - 1) / 2];
        for (i, j) in [(0, 0), (3, 1), (1, 0), (2, 1)] {
            let tile = Grid {
                col: (i * steps[0]) as i64,
                row: (j * steps[1]) as i64,
                cols: steps[0] + 1,
                rows: steps[1] + 1,
                ..whole_grid
            };
            let alone = field(&evaluate(&engine(2), &g, "end", tile), 0);
            assert_eq!(bits(&alone), bits(&whole.crop(&tile)), "tile {i},{j} of {size}");
        }
    }
}

#[test]
fn tiles_differ_for_a_kind_that_reads_beyond_its_footprint() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "peek": { "kind": "peeks", "in": { "field": "hills.field" } },
    }));
    let whole_grid = grid(&g, 129);
    let whole = field(&evaluate(&engine(1), &g, "peek", whole_grid), 0);
    let tile = Grid { col: 32, cols: 33, rows: 33, ..whole_grid };
    let alone = field(&evaluate(&engine(1), &g, "peek", tile), 0);
    assert_ne!(bits(&alone), bits(&whole.crop(&tile)));
}

#[test]
fn threads_do_not_change_the_bits() {
    let g = chain();
    let of = |threads| bits(&field(&evaluate(&engine(threads), &g, "end", grid(&g, 257)), 0));
    let one = of(1);
    assert_eq!(one, of(2));
    assert_eq!(one, of(7));
}

#[test]
fn point_nodes_are_equal_to_the_bit_at_every_size() {
    let g = chain();
    let coarse = field(&evaluate(&engine(2), &g, "rough", grid(&g, 43)), 0);
    for factor in [2, 3, 5] {
        let fine = field(&evaluate(&engine(2), &g, "rough", grid(&g, 42 * factor + 1)), 0);
        for j in 0..coarse.grid().rows {
            for i in 0..coarse.grid().cols {
                let f = i64::from(factor);
                assert_eq!(coarse.at(i as i64, j as i64), fine.at(i as i64 * f, j as i64 * f));
            }
        }
    }
}

#[test]
fn windows_beyond_the_apron_continue_the_border() {
    let terrain = Terrain { width: 1000.0, depth: 500.0, base: 101, ..Terrain::default() };
    let apron = terrain.apron(terrain.base_grid().lattice);
    assert_eq!((apron.col, apron.row, apron.cols, apron.rows), (-50, -50, 201, 151));
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "wide": { "kind": "smooth", "set": { "radius": 100_000 }, "in": { "field": "hills.field" } },
    }));
    let e = engine(1);
    let whole = evaluate(&e, &g, "wide", grid(&g, 65));
    assert!(
        whole.planned_bytes < 4 << 20,
        "the apron bounds what a wide filter asks for: {}",
        whole.planned_bytes
    );
    let tile = Grid { col: 16, cols: 17, rows: 17, ..grid(&g, 65) };
    let alone = field(&evaluate(&engine(1), &g, "wide", tile), 0);
    assert_eq!(bits(&alone), bits(&field(&whole, 0).crop(&tile)));
}
