//! One node of a kind in a graph, fed busy fields: what the loops over all kinds look at.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use orograph::ports::{MASK, Port};
use orograph::value::{Curves, Grid, Object as _, Value, WireType};
use orograph::widget::Widget;
use serde_json::{Map, json};

use super::World;
use super::sets::{Set, brief};
use crate::kinds::registry;

/// A folder with a small height file, for the kinds that read one.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let mut text =
        String::from("ncols 20\nnrows 13\nxllcorner 0\nyllcorner 0\ncellsize 200\nNODATA_value -9999\n");
    for r in 0..13 {
        let row: Vec<String> = (0..20).map(|c| ((c * 7 + r * 13) % 29 * 10).to_string()).collect();
        text += &(row.join(" ") + "\n");
    }
    std::fs::write(folder.path().join("small.asc"), text).unwrap();
    let picture = r#"<svg viewBox="0 0 100 50"><path d="M 5 5 C 30 40 60 0 95 45" data-h="80"/></svg>"#;
    std::fs::write(folder.path().join("small.svg"), picture).unwrap();
    let mut file = std::fs::File::create(folder.path().join("small.png")).unwrap();
    let mut encoder = png::Encoder::new(&mut file, 20, 13);
    encoder.set_color(png::ColorType::Rgba);
    let pixels: Vec<u8> = (0..20 * 13 * 4u32).map(|k| (k * k * 7 % 251) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    folder
});

/// The folder with the small files.
pub(crate) fn files() -> Files {
    let mut files = Files::default();
    files.allow_folder(FOLDER.path()).unwrap();
    files
}

pub(crate) fn engine(threads: usize) -> Engine {
    Engine::new(&Options { threads, ..Options::default() }, files()).unwrap()
}

/// A graph in which one node of a kind is fed busy fields: heights, and masks where the input is one.
pub(crate) fn fed(kind: &Kind, set: &Set, mask: Option<&str>) -> Graph {
    fed_on(World::Wide, kind, set, mask)
}

/// The same on one of the terrains.
pub(crate) fn fed_on(world: World, kind: &Kind, set: &Set, mask: Option<&str>) -> Graph {
    let (width, depth, base) = world.extent();
    let file = json!({
        "orograph": 1,
        "terrain": { "width": width, "depth": depth, "base": base, "seed": 9 },
        "nodes": {
            "first": { "kind": "waves", "set": { "height": 300, "length": 900, "seed": 5 } },
            "second": { "kind": "waves", "set": { "height": 120, "length": 333, "seed": 6 } },
            "share": { "kind": "stretch", "in": { "field": "second.field" } },
            "turns": { "kind": "normals", "in": { "height": "first.field" } },
            "tints": { "kind": "colorize", "in": { "field": "first.field" } },
            "lines": { "kind": "feature_curves", "set": { "curves": [
                { "through": [300, 400, 1500, 900, 3000, 500], "height": [0, 80, 60, 1, 220, 90],
                  "slope": [0, 300, 400, -20, 35], "noise": [0, 30, 0.4] },
                { "line": [500, 1500, 3600, 1700], "height": [0, -40, 0] },
            ] } },
            "marks": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
            "streams": { "kind": "tokunaga_rivers", "set": { "max_depth": 4, "seed": 7 } },
            "crests": { "kind": "voronoi_ridges", "in": { "rivers": "streams.rivers" } },
            "zero": { "kind": "constant", "set": { "value": 0, "quantity": "mask" } },
            "one": { "kind": "constant", "set": { "value": 1, "quantity": "mask" } },
            "node": { "kind": kind.id.as_str(), "set": given(kind, set), "in": wires(kind, mask) },
        },
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).unwrap()
}

/// The parameters of a set, with a small file where the kind reads one, and with strokes where it draws some.
fn given(kind: &Kind, set: &Set) -> Set {
    let mut set = brief(kind, set);
    let gives = |wire: WireType| kind.outputs.iter().any(|o| o.wire == wire);
    for p in kind.params().iter().filter(|p| p.widget == Some(Widget::File)) {
        let (curves, colors) = (gives(WireType::Object(Curves::TYPE)), gives(WireType::Colors));
        let file = if curves { "small.svg" } else { ["small.asc", "small.png"][usize::from(colors)] };
        set.entry(p.name.clone()).or_insert(json!(file));
        if curves && !set.contains_key("mapping") {
            set.insert("mapping".into(), json!({ "height": { "property": { "name": "h" } } }));
        }
    }
    // Nothing drawn would be nothing tested.
    for p in kind.params().iter().filter(|p| p.widget == Some(Widget::Strokes)) {
        set.entry(p.name.clone()).or_insert_with(|| {
            json!([
                { "path": [300, 400, 1500, 900, 3000, 500], "radius": 450 },
                { "path": [2000, 1500], "radius": 800, "softness": 1, "strength": 0.6 },
                { "path": [1200, 100, 1300, 1900], "radius": 200, "softness": 0, "value": 0 },
            ])
        });
    }
    set
}

/// A source for each input. A mask that the engine alone reads is left out unless one is named: it has a test of its own.
fn wires(kind: &Kind, mask: Option<&str>) -> Set {
    let engines = !kind.hands_over(&MASK.name);
    let mut wires = Map::new();
    for (i, port) in kind.inputs.iter().enumerate() {
        match (port.name == MASK.name, mask) {
            (true, Some(mask)) => drop(wires.insert(port.name.to_string(), json!(mask))),
            (true, None) if engines => (),
            _ => drop(wires.insert(port.name.to_string(), json!(source(i, port)))),
        }
    }
    wires
}

fn source(i: usize, port: &Port) -> &'static str {
    match port.wire {
        WireType::Field if is_share(&port.name) => "share.field",
        WireType::Field => ["first.field", "second.field"][i % 2],
        WireType::Vectors => "turns.vectors",
        WireType::Colors => "tints.colors",
        WireType::Object(object) => match object.name {
            "curves" => "lines.curves",
            "rivers" => "streams.rivers",
            "ridges" => "crests.ridges",
            _ => "marks.constraints",
        },
    }
}

fn is_share(port: &str) -> bool {
    matches!(port, "mask" | "below" | "known" | "roughness" | "shade" | "amount")
}

/// All outputs of the node, or the first failure.
pub(crate) fn outputs(
    engine: &Engine,
    graph: &Graph,
    kind: &Kind,
    grid: Grid,
) -> Result<BTreeMap<String, Value>, String> {
    let node = graph.find("node").unwrap();
    let wants: Vec<Want> = kind.outputs.iter().map(|p| Want { node, port: p.name.clone(), grid }).collect();
    let all = engine.evaluate(graph, &wants, &Unobserved, &Cancel::default()).map_err(|e| e.to_string())?;
    kind.outputs
        .iter()
        .zip(all.values)
        .map(|(p, v)| Ok((p.name.to_string(), v.map_err(|f| f.to_string())?)))
        .collect()
}

/// The same by an engine of its own, so that nothing comes from a cache.
pub(crate) fn alone(graph: &Graph, kind: &Kind, grid: Grid) -> Result<BTreeMap<String, Value>, String> {
    outputs(&engine(2), graph, kind, grid)
}

/// Whether a failure refuses parameters that do not fit each other, by name, rather than tells of a bug.
pub(crate) fn is_refusal(failure: &str) -> bool {
    failure.contains("parameter `") && !failure.contains("bug")
}

/// What the wires of the node carry on a window.
pub(crate) fn carried<'a>(
    graph: &'a Graph,
    engine: &'a Engine,
) -> impl Fn(&str, &Grid) -> Option<Value> + Sync + 'a {
    let node = graph.find("node").unwrap();
    move |port, grid| {
        let source = graph.source(node, port)?;
        let want = Want { node: source.node, port: source.port, grid: *grid };
        let all = engine.evaluate(graph, &[want], &Unobserved, &Cancel::default()).unwrap();
        all.values.into_iter().next()?.ok()
    }
}
