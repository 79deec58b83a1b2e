//! One node of a kind, fed busy fields: what the loops over all kinds look at.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use orograph::nodes::Registry;
use orograph::params::{Param, Shape};
use orograph::value::{Curves, Grid, Object as _, Value, WireType};
use orograph::widget::Widget;
use serde_json::{Map, Value as Json, json};

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

/// The shipped kinds.
pub(crate) fn shipped() -> Vec<&'static Kind> {
    static ALL: LazyLock<Registry> = LazyLock::new(Registry::standard);
    ALL.iter().map(|kind| &**kind).collect()
}

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
pub(crate) fn fed(kind: &Kind, set: &Map<String, Json>, mask: Option<&str>) -> Graph {
    let mut set = set.clone();
    for p in kind.params().iter().filter(|p| p.widget == Some(Widget::File)) {
        let curves = kind.outputs.iter().any(|o| o.wire == WireType::Object(Curves::TYPE));
        let colors = kind.outputs.iter().any(|o| o.wire == WireType::Colors);
        let file = if curves {
            "small.svg"
        } else if colors {
            "small.png"
        } else {
            "small.asc"
        };
        set.insert(p.name.clone(), json!(file));
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
    let mut inputs = Map::new();
    for (i, port) in kind.inputs.iter().enumerate().filter(|(_, p)| p.name != "mask" || mask.is_none()) {
        let wanted = match port.wire {
            WireType::Field => {
                ["first.field", "second.field", "share.field"][if is_share(&port.name) { 2 } else { i % 2 }]
            }
            WireType::Vectors => "turns.vectors",
            WireType::Colors => "tints.colors",
            WireType::Object(object) => match object.name {
                "curves" => "lines.curves",
                _ => "marks.constraints",
            },
        };
        // The engine's own mask is left out here: it has a test of its own.
        if port.name != "mask" || kind.mixes.is_empty() {
            inputs.insert(port.name.to_string(), json!(wanted));
        }
    }
    if let Some(mask) = mask {
        inputs.insert("mask".to_owned(), json!(mask));
    }
    let file = json!({
        "orograph": 1,
        "terrain": { "width": 4096, "depth": 2048, "base": 65, "seed": 9 },
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
            "zero": { "kind": "constant", "set": { "value": 0, "quantity": "mask" } },
            "one": { "kind": "constant", "set": { "value": 1, "quantity": "mask" } },
            "node": { "kind": kind.id.as_str(), "set": set, "in": inputs },
        },
        "outputs": {},
    });
    Graph::from_bytes(file.to_string().as_bytes(), &registry()).unwrap()
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

/// The samples of a raster to the bit; what else a value holds as its text.
pub(crate) fn bits(value: &Value) -> Vec<u32> {
    match value {
        Value::Object(object) => format!("{object:?}").bytes().map(u32::from).collect(),
        raster => raster.components().iter().map(|x| x.to_bits()).collect(),
    }
}

pub(crate) fn grid(graph: &Graph, size: u32) -> Grid {
    graph.terrain().grid(size).unwrap()
}

/// Values at the ends of what a parameter allows, and each of its modes with the ends of their fields.
pub(crate) fn extremes(shape: &Shape, default: &Json) -> Vec<Json> {
    match shape {
        Shape::Number { min, max, integer: true } => vec![json!(*min as i64), json!(*max as i64)],
        Shape::Number { min, max, .. } => vec![json!(min), json!(max), json!(min + (max - min) * 0.37)],
        Shape::Flag => vec![json!(true), json!(false)],
        Shape::Optional(inner) => extremes(inner, default).into_iter().chain([Json::Null]).collect(),
        Shape::Choice(modes) => modes.iter().flat_map(|m| mode_extremes(&m.name, &m.fields)).collect(),
        _ => vec![default.clone()],
    }
}

fn mode_extremes(name: &str, fields: &[Param]) -> Vec<Json> {
    if fields.is_empty() {
        return vec![json!(name)];
    }
    let at = |pick: usize| {
        let field = |f: &Param| {
            let ends = extremes(&f.shape, &f.default);
            let value = ends.get(pick.min(ends.len().saturating_sub(1))).cloned().unwrap_or(Json::Null);
            (f.name.clone(), value)
        };
        let body: Map<String, Json> = fields.iter().map(field).collect();
        json!({ name: body })
    };
    (0..3).map(at).collect()
}
