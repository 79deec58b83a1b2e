//! Texts of strangers on a terminal: no command shows them raw, whatever they hold and wherever they stand.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::{Value as Json, json};

use super::cli::{code, run, said, text};

/// What a terminal obeys, what turns or hides text, and line breaks with lines of somebody's own.
const POISON: &str = "Höhe 高さ\u{1b}[31m\u{1b}]0;x\u{7}\u{8}\r\nlicense  CC0-1.0\nsafe     verified\u{9b}2J\u{85}\u{202e}\u{2066}\
     \u{200b}\u{200d}\u{2028}\u{feff}\u{ad}\u{e0041}\u{7f}end";
/// A part of it that is to be read as it is.
const PLAIN: &str = "Höhe 高さ";

/// The characters of an output that should not stand there, and lines that somebody else worded.
fn raw(output: &str) -> Vec<String> {
    let hidden = |c: &char| {
        matches!(c, '\0'..='\u{9}' | '\u{b}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{ad}' | '\u{61c}' | '\u{feff}')
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{e0000}'..)
    };
    let chars = output.chars().filter(hidden).map(|c| format!("U+{:04X}", u32::from(c)));
    let lines =
        output.lines().filter(|l| ["license  CC0", "safe  "].iter().any(|f| l.trim_start().starts_with(f)));
    chars.chain(lines.map(str::to_owned)).collect()
}

fn assert_clean(what: &str, output: &Output) {
    let said = said(output);
    assert!(raw(&said).is_empty(), "{what}: {:?} in {said:?}", raw(&said));
}

/// A graph that is poisoned in every text there is, with an output that can be made.
fn poisoned() -> Json {
    let p = POISON;
    json!({
        "orograph": 1,
        "kinds": { p: 7 },
        "title": p, "author": p, "license": p, "about": p, "tags": [p, p], p: p,
        "terrain": { "base": 33, "sea_level": p, p: p, "geo": p },
        "expose": {
            "relief": { "bind": ["hills.amplitude"], "value": 200, "min": 10, "label": p, "about": p, p: p },
            p: { "bind": [p, format!("{p}.{p}"), format!("hills.{p}")], "value": p },
        },
        "nodes": {
            "hills": { "kind": "fractal_noise", "set": { "seed": 3, p: p }, "in": { p: p, "mask": p }, p: p },
            p: { "kind": p, "set": { p: p } },
            "other": { "kind": "blur", "in": { "field": format!("{p}.{p}") }, "backend": p, "set": { "radius": p } },
            "form": { "kind": "fractal_noise", "set": { "form": p } },
            "ring": { "kind": "blur", "in": { "field": "gnir.field" } },
            "gnir": { "kind": "blur", "in": { "field": "ring.field" } },
            "dem": { "kind": "import_height", "set": { "file": format!("{p}.tif") } },
            "lines": { "kind": "import_curves", "set": { "file": format!("{p}\0.svg") } },
            "fine": { "kind": "constant", "set": { "value": 3 } },
        },
        "outputs": {
            "height": { "from": "fine.field", "format": "r32", "about": p, p: p },
            "file": { "from": "dem.height", "about": p },
            p: { "from": p, "format": p },
            "lost": { "from": format!("{p}.{p}"), "target": p },
        },
        "notes": { p: { "title": p, "text": p, "color": p, p: p } },
    })
}

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), bytes).unwrap();
        text(&self.path(name))
    }
}

/// The checker itself sees what it looks for.
#[test]
fn raw_text_is_found() {
    let found = raw(POISON);
    for c in
        ["U+001B", "U+0007", "U+0008", "U+000D", "U+009B", "U+202E", "U+200B", "U+200D", "U+FEFF", "U+E0041"]
    {
        assert!(found.iter().any(|f| f == c), "{c} in {found:?}");
    }
    assert!(found.iter().any(|f| f.starts_with("license")), "{found:?}");
    assert!(raw("Höhe 高さ\nexit  0\n").is_empty());
}

#[test]
fn no_command_shows_the_texts_of_a_graph_raw() {
    let desk = Desk::new();
    let graph = desk.write("a.graph", poisoned().to_string());
    // What is wrong with the terrain stops every output.
    let mut sound = poisoned();
    sound["terrain"] = json!({ "base": 33, POISON: POISON });
    let sound = desk.write("sound.graph", sound.to_string());
    let (out, picture) = (text(&desk.path("out")), text(&desk.path("a.png")));
    for (args, exit) in [
        (&["check", &graph][..], 3),
        (&["check", &graph, "--json"], 3),
        (&["check", &graph, "--strict"], 3),
        (&["info", &graph], 0),
        (&["info", &graph, "--json"], 0),
        (&["build", &graph, "-o", &out], 3),
        (&["build", &sound, "-o", &out], 3),
        (&["build", &sound, "-o", &out, "--output", "height", "--progress", "json", "--report", "-"], 0),
        (&["build", &graph, "-o", &out, "--output", "nothing"], 2),
        (&["build", &graph, "-o", &out, "--set", "nothing=3"], 2),
        (&["build", &graph, "-o", &out, "--strict"], 3),
        (&["render", &sound, "-o", &picture, "--output", "height"], 0),
        (&["fmt", &graph, "--check"], 1),
        (&["fmt", &graph], 0),
    ] {
        let ended = run(args);
        assert_eq!(code(&ended), exit, "{args:?}: {}", said(&ended));
        assert_clean(&format!("{args:?}"), &ended);
    }
    for graph in [&graph, &sound] {
        for args in [&["plan", graph][..], &["plan", graph, "--json"], &["render", graph, "-o", &picture]] {
            assert_clean(&format!("{args:?}"), &run(args));
        }
    }
    let shown = said(&run(&["info", &graph]));
    assert!(shown.contains(PLAIN) && shown.contains("\\u{1b}[31m") && shown.contains("\\u{202e}"), "{shown}");
    assert_eq!(shown.lines().filter(|l| l.starts_with("license")).count(), 1, "{shown}");
    let report = std::fs::read_to_string(desk.path("out/report.json")).unwrap();
    assert!(raw(&report).is_empty(), "{:?}", raw(&report));
    let json: Json = serde_json::from_slice(&run(&["info", &graph, "--json"]).stdout).unwrap();
    assert_eq!(json["title"], POISON, "the same text to a program");
}

#[test]
fn names_of_files_and_words_of_the_command_line_are_not_shown_raw() {
    let desk = Desk::new();
    let name = POISON.replace('/', "");
    let graph = desk.write(&format!("{name}.graph"), "{ \"orograph\": 1 ");
    let heights = desk.write(&format!("{name}.asc"), "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n");
    let vars = desk.write("vars.json", json!({ POISON: POISON }).to_string());
    let twice = desk.write("twice.json", format!("{{ {0}: 1, {0}: 2 }}", Json::from(POISON)));
    let fine = desk.write("fine.graph", "{ \"orograph\": 1 }");
    let out = text(&desk.path(&name));
    for args in [
        &["check", &graph][..],
        &["info", &graph],
        &["plan", &graph],
        &["fmt", &graph],
        &["build", &graph, "-o", &out],
        &["render", &graph, "-o", &format!("{out}.png")],
        &["info", &heights],
        &["info", &heights, "--json"],
        &["convert", &heights, &format!("{out}.r32")],
        &["convert", &heights, &format!("{out}.{POISON}")],
        &["render", &heights, "-o", &format!("{out}.png")],
        &["render", &heights, "-o", &out],
        &["check", &fine, "--vars", &vars],
        &["check", &fine, "--vars", &twice],
        &["check", &fine, "--vars", &out],
        &["check", &fine, "--set", POISON],
        &["check", &fine, "--set", &format!("{POISON}={POISON}")],
        &["check", &fine, "--allow", POISON],
        &["check", &fine, &format!("--{POISON}")],
        &["build", &fine, "-o", &out, "--format", POISON],
        &["build", &fine, "-o", &out, "--memory", POISON],
        &["build", &fine, "-o", &out, "--region", POISON],
        &["build", &fine, "-o", &out, "--tiles", POISON],
        &["build", &fine, "-o", &out, "--progress", POISON],
        &["render", &fine, "-o", &format!("{out}.png"), "--palette", POISON],
        &["nodes", POISON],
        &[POISON],
    ] {
        assert_clean(&format!("{args:?}"), &run(args));
    }
}

/// A graph that does not parse, in all the ways of doing so.
#[test]
fn a_file_that_does_not_parse_gives_json_where_json_is_asked_for() {
    let desk = Desk::new();
    let quoted = Json::from(POISON).to_string();
    for (name, bytes, exit) in [
        ("cut", b"{ \"orograph\": 1, ".to_vec(), 3),
        ("twice", format!("{{ \"orograph\": 1, {quoted}: 1, {quoted}: 2 }}").into_bytes(), 3),
        ("shape", format!("{{ \"orograph\": 1, \"nodes\": {{ {quoted}: {quoted} }} }}").into_bytes(), 3),
        ("version", format!("{{ \"orograph\": {quoted} }}").into_bytes(), 3),
        ("bytes", b"\xff\xfe\x1b".to_vec(), 3),
        ("empty", Vec::new(), 3),
        ("raw", POISON.as_bytes().to_vec(), 3),
    ] {
        let graph = desk.write(&format!("{name}.graph"), bytes);
        for command in ["check", "info", "plan"] {
            for args in [&[command, &graph][..], &[command, &graph, "--json"]] {
                let ended = run(args);
                assert_eq!(code(&ended), exit, "{args:?}: {}", said(&ended));
                assert_clean(&format!("{args:?}"), &ended);
                if args.len() == 3 {
                    let json: Json = serde_json::from_slice(&ended.stdout).unwrap();
                    assert_eq!(json["exit"], exit, "{json}");
                    assert!(json["error"].as_str().is_some_and(|e| !e.is_empty()), "{json}");
                }
            }
        }
    }
    let absent = run(&["info", &text(&desk.path("absent.tif")), "--json"]);
    assert_eq!(serde_json::from_slice::<Json>(&absent.stdout).unwrap()["exit"], 4);
    // A plan over its budget is printed, and nothing after it.
    let graph = desk.write("fine.graph", json!({
        "orograph": 1, "nodes": { "n": { "kind": "fractal_noise" } }, "outputs": { "o": { "from": "n.field" } },
    }).to_string());
    let over = run(&["plan", &graph, "--json", "--size", "4097", "--memory", "1M"]);
    assert_eq!(code(&over), 5, "{}", said(&over));
    assert!(serde_json::from_slice::<Json>(&over.stdout).unwrap()["tasks"].is_array());
}
