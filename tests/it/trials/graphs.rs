//! Graphs by strangers: whatever a file says, every command ends in time, with a documented code and a clean word.

use serde_json::{Value as Json, json};

use super::{Desk, hills, run, some_of, text};

/// A text that moves the cursor, changes the title, rings, turns the writing round and forges a line.
const POISON: &str =
    "T\u{1b}[31m\u{1b}]0;x\u{7}\u{1b}[2J\u{9b}31m\u{202e}abc\u{200b}\r\u{8}\nlicense  CC0-1.0";

/// Values that may stand where a number, a name or a list was meant.
fn odd_values() -> Vec<Json> {
    let deep = (0..400).fold(json!(1), |inner, _| json!([inner]));
    vec![
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1e308),
        json!(-1e308),
        json!(5e-324),
        json!(18_446_744_073_709_551_615u64),
        json!(""),
        json!(POISON),
        json!("x".repeat(100_000)),
        json!([]),
        json!({}),
        json!([1, "a", {}]),
        json!({ "__proto__": 1 }),
        deep,
    ]
}

/// Every place of a graph at which a value may be put.
const PLACES: [&[&str]; 17] = [
    &["orograph"],
    &["title"],
    &["terrain"],
    &["terrain", "width"],
    &["terrain", "base"],
    &["terrain", "seed"],
    &["terrain", "geo"],
    &["nodes"],
    &["nodes", "hills"],
    &["nodes", "hills", "kind"],
    &["nodes", "hills", "set"],
    &["nodes", "hills", "set", "octaves"],
    &["nodes", "soft", "in", "field"],
    &["outputs"],
    &["outputs", "height", "from"],
    &["expose"],
    &["notes"],
];

fn put(graph: &mut Json, place: &[&str], value: Json) {
    match place {
        [] => *graph = value,
        [key, rest @ ..] => {
            if !graph[*key].is_object() && !rest.is_empty() {
                graph[*key] = json!({});
            }
            put(&mut graph[*key], rest, value);
        }
    }
}

/// Graphs with an odd value at a place, as bytes.
fn with_odd_values() -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for place in PLACES {
        for (i, value) in odd_values().into_iter().enumerate() {
            let mut graph = hills();
            put(&mut graph, place, value);
            all.push((format!("{} = value {i}", place.join(".")), graph.to_string().into_bytes()));
        }
    }
    all
}

/// Graphs that are a burden: long chains, cycles, many strokes, wide fans.
fn burdens() -> Vec<(String, Vec<u8>)> {
    let chain = |n: usize, closed: bool| {
        let mut graph = hills();
        for i in 0..n {
            let from = match i {
                0 if closed => format!("c{}.field", n - 1),
                0 => "hills.field".to_owned(),
                i => format!("c{}.field", i - 1),
            };
            graph["nodes"][format!("c{i}")] = json!({ "kind": "clamp", "in": { "field": from } });
        }
        graph["outputs"] = json!({ "height": { "from": format!("c{}.field", n - 1), "format": "r32" } });
        graph
    };
    let mut strokes = hills();
    let paths: Vec<Json> = (0..2000).map(|i| json!({ "path": [i, i, 2 * i, 500], "radius": 100 })).collect();
    strokes["nodes"]["brush"] = json!({ "kind": "paint_mask", "set": { "strokes": paths } });
    strokes["outputs"]["brush"] = json!({ "from": "brush.mask", "format": "r32" });
    let mut poisoned = hills();
    for key in ["title", "author", "license", "about"] {
        poisoned[key] = json!(POISON);
    }
    poisoned["tags"] = json!([POISON]);
    poisoned[POISON] = json!(POISON);
    poisoned["nodes"][POISON] =
        json!({ "kind": POISON, "set": { POISON: POISON }, "in": { POISON: POISON } });
    poisoned["nodes"]["dem"] = json!({ "kind": "import_height", "set": { "file": POISON } });
    poisoned["outputs"][POISON] = json!({ "from": POISON, "about": POISON });
    poisoned["outputs"]["dem"] = json!({ "from": "dem.height", "about": POISON });
    poisoned["expose"] =
        json!({ POISON: { "bind": [POISON], "value": POISON, "about": POISON, "label": POISON } });
    let text = hills().to_string();
    let mut all: Vec<(String, Vec<u8>)> = vec![
        ("a chain of 3000".into(), chain(3000, false).to_string().into_bytes()),
        ("a cycle of 1000".into(), chain(1000, true).to_string().into_bytes()),
        ("2000 strokes".into(), strokes.to_string().into_bytes()),
        ("poison everywhere".into(), poisoned.to_string().into_bytes()),
        ("nothing".into(), Vec::new()),
        ("zeros".into(), vec![0; 4096]),
        ("brackets".into(), "[".repeat(200_000).into_bytes()),
        ("a key twice".into(), format!("{{\"{0}\": 1, \"{0}\": 2}}", POISON.escape_debug()).into_bytes()),
        ("raw poison".into(), format!("{{\"orograph\": 1, \"title\": {POISON}}}").into_bytes()),
        ("UTF-16".into(), text.encode_utf16().flat_map(u16::to_le_bytes).collect()),
        ("a byte order mark".into(), format!("\u{feff}{text}").into_bytes()),
    ];
    all.extend((1..20).map(|i| (format!("cut at {i}/20"), text.as_bytes()[..text.len() * i / 20].to_vec())));
    all
}

#[test]
fn every_command_survives_every_graph() {
    let mut graphs = burdens();
    graphs.extend(some_of(with_odd_values(), 13));
    let desk = Desk::new();
    let mut faults = Vec::new();
    for (i, (what, bytes)) in graphs.iter().enumerate() {
        let graph = desk.write("hostile.graph", bytes);
        let (out, png) = (text(&desk.path(&format!("out{i}"))), text(&desk.path(&format!("{i}.png"))));
        let commands: [&[&str]; 8] = [
            &["check", &graph],
            &["check", &graph, "--json"],
            &["info", &graph],
            &["info", &graph, "--json"],
            &["plan", &graph],
            &["fmt", "--check", &graph],
            &["build", &graph, "-o", &out, "--size", "33", "--time", "60"],
            &["render", &graph, "-o", &png, "--size", "33", "--width", "64", "--time", "60"],
        ];
        for command in commands {
            let end = run(command);
            let json = command.contains(&"--json");
            let broken = json && !serde_json::from_str::<Json>(&end.told).is_ok_and(|v| !v.is_null());
            let fault = end.fault().or_else(|| broken.then(|| format!("is no JSON: {}", end.told)));
            faults.extend(fault.map(|fault| format!("{} of {what}: {fault}", command[0])));
        }
    }
    println!("{} graphs, 8 commands each", graphs.len());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
