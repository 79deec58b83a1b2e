//! `poisson_blend` in a graph, at sizes that the base grid does not have.

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::{Field, Value};
use serde_json::{Value as Json, json};

/// Samples along the base grid.
const BASE: u32 = 129;

/// Hills, other hills with a gain, and a disc off the middle.
fn graph(reference: &str, set: &Json) -> Graph {
    let noise = |feature: f64, amplitude: f64, offset: f64, seed: u32| {
        let set = json!({
            "feature_size": feature, "amplitude": amplitude, "offset": offset, "octaves": 9, "seed": seed,
        });
        json!({ "kind": "fractal_noise", "set": set })
    };
    let disc = json!([{ "path": [1900, 2100], "radius": 1300, "softness": 0 }]);
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 4096, "base": BASE },
        "nodes": {
            "source": noise(1500.0, 400.0, 0.0, 1),
            "reference": noise(900.0, 500.0, 2000.0, 2),
            "disc": { "kind": "paint_mask", "set": { "strokes": disc } },
            "all": { "kind": "constant", "set": { "value": 1 } },
            "end": {
                "kind": "poisson_blend",
                "set": set,
                "in": { "source": "source.field", "reference": reference, "mask": "disc.mask" },
            },
        },
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).expect("a graph")
}

fn fields<const N: usize>(graph: &Graph, size: u32, nodes: [(&str, &str); N]) -> [Field; N] {
    let engine = Engine::new(&Options { threads: 2, ..Options::default() }, Files::default()).unwrap();
    let grid = graph.terrain().grid(size).unwrap();
    let want = |(node, port): (&str, &str)| Want { node: graph.find(node).unwrap(), port: port.into(), grid };
    let done = engine.evaluate(graph, &nodes.map(want), &Unobserved, &Cancel::default()).unwrap();
    let mut values = done.values.into_iter();
    nodes.map(|_| match values.next() {
        Some(Ok(Value::Field(field))) => field,
        other => panic!("a field, not {other:?}"),
    })
}

/// The blend, what it is made of, and where.
fn blended(graph: &Graph, size: u32) -> [Field; 4] {
    fields(graph, size, [("end", "height"), ("source", "field"), ("reference", "field"), ("disc", "mask")])
}

/// The 95th percentile of the size of second differences along rows and columns of what `of` gives, of those triples whose
/// samples stand as `picked` says by how far they are inside: cells beyond the edge of the disc.
fn bends(mask: &Field, of: impl Fn(usize) -> f32, picked: impl Fn([f64; 3]) -> bool) -> f32 {
    let grid = *mask.grid();
    let depth = |k: usize| {
        let (x, y) = (grid.x(k % grid.cols), grid.y(k / grid.cols));
        (1300.0 - libm::hypot(x - 1900.0, y - 2100.0)) / grid.cell()
    };
    let mut all = Vec::new();
    for j in 1..grid.rows - 1 {
        for i in 1..grid.cols - 1 {
            let k = j * grid.cols + i;
            for step in [1, grid.cols] {
                let triple = [k - step, k, k + step];
                if picked(triple.map(depth)) {
                    let [a, b, c] = triple.map(&of);
                    all.push((a - 2.0 * b + c).abs());
                }
            }
        }
    }
    assert!(all.len() > 200, "{} triples", all.len());
    all.sort_by(f32::total_cmp);
    all[all.len() * 95 / 100]
}

fn inside(depths: [f64; 3]) -> bool {
    depths.iter().all(|d| *d > 6.0)
}

fn across(depths: [f64; 3]) -> bool {
    depths.iter().any(|d| *d >= 0.0) && depths.iter().any(|d| *d < 0.0)
}

#[test]
fn outside_the_region_every_bit_of_the_source_stays_at_any_size() {
    for mixed in [false, true] {
        let g = graph("reference.field", &json!({ "gain": 1.7, "mixed": mixed }));
        for size in [65, BASE, 193, 257, 401] {
            let [end, source, _, mask] = blended(&g, size);
            let mut changed = 0;
            for (k, (t, s)) in end.data().iter().zip(source.data()).enumerate() {
                if mask.data()[k] == 0.0 {
                    assert_eq!(t.to_bits(), s.to_bits(), "size {size}, sample {k}");
                } else {
                    changed += usize::from(t != s);
                }
            }
            assert!(changed > 500, "size {size}: {changed} changed");
        }
    }
}

#[test]
fn a_terrain_blended_into_itself_is_itself_at_any_size() {
    let g = graph("source.field", &json!({}));
    for size in [BASE, 193, 257] {
        let [end, source, ..] = blended(&g, size);
        assert_eq!(end.data(), source.data(), "size {size}");
    }
}

#[test]
fn what_is_added_to_the_reference_is_smooth_at_twice_the_base() {
    for gain in [0.5, 1.0, 2.0] {
        let g = graph("reference.field", &json!({ "gain": gain }));
        let [end, _, reference, mask] = blended(&g, 257);
        let membrane = |k: usize| end.data()[k] - gain as f32 * reference.data()[k];
        let (smooth, rough) =
            (bends(&mask, membrane, inside), bends(&mask, |k| gain as f32 * reference.data()[k], inside));
        assert!(smooth < 0.05 * rough, "gain {gain}: {smooth} of {rough}");
        // Without the detail of the reference it would be rough: what the base grid alone knows is no smooth addition.
        let plain = graph("reference.field", &json!({ "gain": 0 }));
        let [flat, ..] = blended(&plain, 257);
        assert!(bends(&mask, |k| flat.data()[k], inside) < 0.05 * rough);
    }
}

#[test]
fn no_seam_shows_at_the_base_and_at_twice_the_base() {
    let g = graph("reference.field", &json!({}));
    // At twice the base the source keeps detail outside that the reference does not have inside.
    for (size, most) in [(BASE, 1.2), (257, 1.8)] {
        let [end, source, reference, mask] = blended(&g, size);
        let of = |k: usize| end.data()[k];
        let (seam, within) = (bends(&mask, of, across), bends(&mask, of, inside));
        assert!(seam <= most * within, "size {size}: {seam} across the border, {within} inside");
        let pasted = |k: usize| if mask.data()[k] > 0.0 { reference.data()[k] } else { source.data()[k] };
        assert!(bends(&mask, pasted, across) > 4.0 * within, "a plain paste shows");
    }
}

#[test]
fn a_region_that_covers_all_warns_and_gives_the_reference_with_its_gain() {
    let mut file: Json =
        serde_json::from_slice(&graph("reference.field", &json!({ "gain": 2 })).to_bytes()).unwrap();
    file["nodes"]["end"]["in"]["mask"] = json!("all.field");
    let g = Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).unwrap();
    let engine = Engine::new(&Options::default(), Files::default()).unwrap();
    let grid = g.terrain().base_grid();
    let want = |node: &str, port: &str| Want { node: g.find(node).unwrap(), port: port.into(), grid };
    let wants = [want("end", "height"), want("reference", "field")];
    let done = engine.evaluate(&g, &wants, &Unobserved, &Cancel::default()).unwrap();
    let [end, reference] = [0, 1].map(|i| done.values[i].as_ref().unwrap().components());
    assert!(end.iter().zip(reference).all(|(t, r)| *t == 2.0 * r));
    let said: Vec<_> = done.tasks.iter().flat_map(|r| &r.warnings).collect();
    assert!(said.iter().any(|w| w.contains("covers the whole terrain")), "{said:?}");
}
