//! The chain of kinds from a network to land, in a graph.

use orograph::engine::{Engine, Evaluation, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::{Colors, Field, Rivers, Value};
use serde_json::{Value as Json, json};

/// Rivers of some lines, and all that is made of them.
fn graph(lines: &Json) -> Graph {
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 4096, "base": 129, "sea_level": null },
        "nodes": {
            "line": { "kind": "tokunaga_rivers", "set": { "lines": lines, "max_depth": 5 } },
            "network": { "kind": "infill_rivers", "set": { "spacing": 300 }, "in": { "rivers": "line.rivers" } },
            "beds": { "kind": "river_profile", "in": { "rivers": "network.rivers" } },
            "ridges": { "kind": "voronoi_ridges", "in": { "rivers": "beds.rivers" } },
            "skeleton": {
                "kind": "skeleton_raster", "in": { "rivers": "beds.rivers", "ridges": "ridges.ridges" },
            },
            "hints": {
                "kind": "enrich", "set": { "reach": 128 },
                "in": { "height": "skeleton.height", "known": "skeleton.known" },
            },
            "land": {
                "kind": "diffuse_points", "set": { "known_as": "weights" },
                "in": { "field": "hints.height", "known": "hints.weight" },
            },
            "noise": { "kind": "fractal_noise", "set": { "feature_size": 150, "amplitude": 30 } },
            "rough": { "kind": "combine", "in": { "a": "land.field", "b": "noise.field" } },
            "carved": { "kind": "carve_rivers", "in": { "height": "rough.field", "rivers": "beds.rivers" } },
            "picture": { "kind": "draw_rivers", "in": { "rivers": "beds.rivers" } },
            "crests": {
                "kind": "draw_ridges", "in": { "ridges": "ridges.ridges", "under": "picture.colors" },
            },
        },
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &Registry::standard()).expect("a graph")
}

fn one_line() -> Json {
    json!([[2000, 4096, 2300, 500]])
}

fn evaluate(g: &Graph, size: u32, wants: &[(&str, &str)]) -> Evaluation {
    let engine = Engine::new(&Options { threads: 2, ..Options::default() }, Files::default()).unwrap();
    let grid = g.terrain().grid(size).unwrap();
    let want = |&(node, port): &(&str, &str)| Want { node: g.find(node).unwrap(), port: port.into(), grid };
    let wants: Vec<_> = wants.iter().map(want).collect();
    engine.evaluate(g, &wants, &Unobserved, &Cancel::default()).unwrap()
}

fn field(done: &Evaluation, i: usize) -> Field {
    match &done.values[i] {
        Ok(Value::Field(field)) => field.clone(),
        other => panic!("a field, not {other:?}"),
    }
}

fn colors(done: &Evaluation, i: usize) -> Colors {
    match &done.values[i] {
        Ok(Value::Colors(colors)) => colors.clone(),
        other => panic!("colours, not {other:?}"),
    }
}

/// The steepest way down of each sample to one of eight neighbours; itself in a pit.
fn ways(height: &Field) -> Vec<usize> {
    let (cols, rows) = (height.grid().cols, height.grid().rows);
    let down = |k: usize| {
        let (i, j, z) = (k % cols, k / cols, height.data()[k]);
        let mut best = (0.0, k);
        for y in j.saturating_sub(1)..(j + 2).min(rows) {
            for x in i.saturating_sub(1)..(i + 2).min(cols) {
                let steps = ((x.abs_diff(i) + y.abs_diff(j)) as f64).max(1.0).sqrt();
                let fall = f64::from(z - height.data()[y * cols + x]) / steps;
                if fall > best.0 {
                    best = (fall, y * cols + x);
                }
            }
        }
        best.1
    };
    (0..cols * rows).map(down).collect()
}

/// Samples of beds, and those of them whose water ends neither on the border nor at an outlet.
fn stranded(height: &Field, bed: &Field, rivers: &Rivers) -> (usize, Vec<[usize; 2]>) {
    let (grid, ways) = (*height.grid(), ways(height));
    let beds: Vec<_> = (0..grid.len()).filter(|&k| bed.data()[k] == 1.0).collect();
    let cell = grid.cell().max(32.0);
    let ends_well = |k: usize| {
        let (i, j) = (k % grid.cols, k / grid.cols);
        let on_border = i == 0 || j == 0 || i + 1 == grid.cols || j + 1 == grid.rows;
        let near = |o: usize| {
            let [x, y] = rivers.vertices()[o].at;
            libm::hypot(x - grid.x(i), y - grid.y(j)) <= 2.0 * cell
        };
        on_border || rivers.outlets().any(near)
    };
    let end = |mut k: usize| {
        while ways[k] != k {
            k = ways[k];
        }
        k
    };
    let bad = beds.iter().copied().filter(|&k| !ends_well(end(k)));
    (beds.len(), bad.map(|k| [k % grid.cols, k / grid.cols]).collect())
}

#[test]
fn rivers_reach_their_outlets_at_the_base_and_beyond_with_noise_everywhere() {
    let g = graph(&one_line());
    for size in [129, 257, 385] {
        let wants = [("carved", "height"), ("carved", "bed"), ("beds", "rivers"), ("rough", "field")];
        let done = evaluate(&g, size, &wants);
        let (height, bed) = (field(&done, 0), field(&done, 1));
        let rivers: Rivers = done.values[2].as_ref().unwrap().object().cloned().unwrap();
        let (beds, bad) = stranded(&height, &bed, &rivers);
        assert!(beds > 1000, "size {size}: {beds} samples of beds");
        assert!(
            bad.is_empty(),
            "size {size}: {} of {beds} stranded, first {:?}",
            bad.len(),
            &bad[..bad.len().min(5)]
        );
        // Without the beds noise strands most of them.
        let (_, bad) = stranded(&field(&done, 3), &bed, &rivers);
        assert!(bad.len() > beds / 4, "size {size}: {} of {beds} stranded in plain noise", bad.len());
    }
}

#[test]
fn weights_draw_a_membrane_as_far_as_they_say() {
    let g = graph(&one_line());
    let done = evaluate(
        &g,
        129,
        &[("land", "field"), ("hints", "height"), ("hints", "weight"), ("skeleton", "known")],
    );
    let [land, hints, weight, known] = [0, 1, 2, 3].map(|i| field(&done, i));
    let (cols, rows) = (land.grid().cols, land.grid().rows);
    let (low, high) = land.range().unwrap();
    let (mut soft, mut held) = (0, 0);
    for k in 0..cols * rows {
        let (i, j) = (k % cols, k / cols);
        let clamped = |di: isize, dj: isize| {
            let [x, y] =
                [i.saturating_add_signed(di).min(cols - 1), j.saturating_add_signed(dj).min(rows - 1)];
            f64::from(land.data()[y * cols + x])
        };
        let mean = (clamped(-1, 0) + clamped(1, 0) + clamped(0, -1) + clamped(0, 1)) / 4.0;
        let w = f64::from(weight.data()[k]);
        let wanted = w * f64::from(hints.data()[k]) + (1.0 - w) * mean;
        let found = f64::from(land.data()[k]);
        assert!((found - wanted).abs() < 1e-4 * f64::from(high - low), "at {i}, {j}: {found}, not {wanted}");
        held += usize::from(known.data()[k] == 1.0 && land.data()[k] == hints.data()[k]);
        soft += usize::from(w > 0.0 && w < 1.0);
        assert!(known.data()[k] == 0.0 || w == 1.0, "what was known counts whole");
        assert!(w <= 0.3 || known.data()[k] == 1.0, "what was filled counts at most as much as it may");
    }
    assert!(soft > 500, "{soft} samples of some weight");
    assert_eq!(held, known.data().iter().filter(|k| **k == 1.0).count(), "what is known is held to the bit");
}

#[test]
fn a_thin_plate_takes_no_weights() {
    let registry = Registry::standard();
    let kind = registry.find("diffuse_points").unwrap();
    let set = json!({ "surface": "thin_plate", "known_as": "weights" });
    let said = kind.parse(set.as_object().unwrap()).unwrap_err().to_string();
    assert!(said.contains("known_as") && said.contains("thin plate"), "{said}");
}

#[test]
fn no_line_gives_level_land_and_says_that_nothing_is_known() {
    let g = graph(&json!([]));
    let done =
        evaluate(&g, 129, &[("land", "field"), ("carved", "bed"), ("picture", "mask"), ("crests", "mask")]);
    for i in 0..4 {
        assert!(field(&done, i).data().iter().all(|z| *z == 0.0), "output {i}");
    }
    let said: Vec<_> = done.tasks.iter().filter(|t| t.node == "skeleton").flat_map(|t| &t.warnings).collect();
    assert!(said.iter().any(|w| w.contains("no river and no ridge")), "{said:?}");
}

#[test]
fn pictures_cover_what_lines_cover_and_orders_have_their_colours() {
    let g = graph(&one_line());
    let wants = [("picture", "mask"), ("picture", "colors"), ("crests", "mask"), ("beds", "rivers")];
    let done = evaluate(&g, 257, &wants);
    let (mask, picture, crests) = (field(&done, 0), colors(&done, 1), field(&done, 2));
    let rivers: Rivers = done.values[3].as_ref().unwrap().object().cloned().unwrap();
    let share = |f: &Field| f.data().iter().sum::<f32>() / f.data().len() as f32;
    // Lines of a base cell, 32 m: their length times their width is their share of the land, less where they join.
    let length: f64 = rivers
        .links()
        .filter(|&(a, b)| {
            [a, b].iter().all(|&v| rivers.vertices()[v].at.iter().all(|x| (0.0..4096.0).contains(x)))
        })
        .map(|(a, b)| {
            let ([ax, ay], [bx, by]) = (rivers.vertices()[a].at, rivers.vertices()[b].at);
            libm::hypot(ax - bx, ay - by)
        })
        .sum();
    let wanted = (length * 32.0 / 4096.0 / 4096.0) as f32;
    assert!((share(&mask) - wanted).abs() < 0.2 * wanted, "{} covered, not {wanted}", share(&mask));
    assert!(share(&crests) > 0.02, "{}", share(&crests));
    for (m, c) in mask.data().iter().zip(picture.data()) {
        assert_eq!(*m == 0.0, *c == [1.0; 3], "white where nothing is drawn, and nowhere else");
    }
    // On the main river its colour, on a source another.
    let at = |v: usize| {
        picture.data()[{
            let [i, j] = picture.grid().nearest(rivers.vertices()[v].at);
            j * picture.grid().cols + i
        }]
    };
    let inside = |v: &usize| rivers.vertices()[*v].at.iter().all(|x| (100.0..4000.0).contains(x));
    let order = |v: usize| rivers.vertices()[v].order;
    let all = || (0..rivers.len()).filter(inside);
    let (main, source) = (all().max_by_key(|v| order(*v)).unwrap(), all().min_by_key(|v| order(*v)).unwrap());
    assert!(order(main) > order(source) + 2);
    assert_ne!(at(main), at(source));
}
