//! The program as a user runs it.

mod names;
mod options;
mod stats;

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use orograph::files::{Limits, read_height};
use serde_json::{Value as Json, json};

use crate::rig::skip::skip;

pub(crate) fn orograph() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_orograph"));
    command.stdin(Stdio::null()).env("XDG_CONFIG_HOME", "/nonexistent");
    command
}

pub(crate) fn run(args: &[&str]) -> Output {
    orograph().args(args).output().unwrap()
}

pub(crate) fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or(-1)
}

pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

pub(crate) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Starts a command that tells its progress in lines, and comes back when it has told so many, or has ended.
pub(crate) fn until_told(command: &mut Command, lines: usize) -> Child {
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut told = BufReader::with_capacity(256, child.stderr.take().unwrap());
    let mut line = String::new();
    for _ in 0..lines {
        line.clear();
        if told.read_line(&mut line).unwrap() == 0 {
            break;
        }
    }
    // What it tells from here on has somewhere to go.
    std::thread::spawn(move || std::io::copy(&mut told, &mut std::io::sink()));
    child
}

/// A folder with a graph of hills and two outputs.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new(outputs: &Json) -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        let graph = json!({
            "orograph": 1,
            "terrain": { "width": 2048, "depth": 1024, "base": 129, "sea_level": 5 },
            "expose": { "relief": { "bind": ["hills.amplitude"], "value": 200, "min": 10, "max": 500 } },
            "nodes": {
                "hills": { "kind": "fractal_noise", "set": { "seed": 3 } },
                "soft": { "kind": "blur", "in": { "field": "hills.field" }, "set": { "radius": 60 } },
                "dem": { "kind": "import_height", "set": { "file": "missing.tif" } },
            },
            "outputs": outputs,
        });
        std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn build(&self, args: &[&str]) -> Output {
        let (graph, out) = (text(&self.path("a.graph")), text(&self.path("out")));
        run(&[&["build", &graph, "-o", &out], args].concat())
    }

    fn report(&self) -> Json {
        serde_json::from_slice(&std::fs::read(self.path("out/report.json")).unwrap()).unwrap()
    }
}

fn height() -> Json {
    json!({ "height": { "from": "soft.field", "format": "r32" } })
}

fn sha256(path: &Path) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(std::fs::read(path).unwrap()).iter().map(|b| format!("{b:02x}")).collect()
}

#[test]
fn a_build_leaves_whole_files_and_a_true_report() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "picture": { "from": "hills.field", "format": "png16" },
    }));
    let built = desk.build(&["--set", "relief=300"]);
    assert_eq!(code(&built), 0, "{}", said(&built));
    let report = desk.report();
    assert_eq!(report["status"], "done");
    assert_eq!(report["variables"]["relief"], "300");
    assert_eq!(report["warnings"], json!([]));
    let outputs = report["outputs"].as_array().unwrap();
    assert_eq!(outputs.len(), 2);
    for o in outputs {
        let path = desk.path("out").join(o["path"].as_str().unwrap());
        assert_eq!(o["sha256"], sha256(&path));
        assert_eq!((o["cols"].as_u64(), o["rows"].as_u64()), (Some(129), Some(65)));
        assert_eq!(o["effective_cell"], o["cell"]);
    }
    let nodes: Vec<_> =
        report["nodes"].as_array().unwrap().iter().map(|n| n["node"].as_str().unwrap()).collect();
    assert!(nodes.contains(&"hills") && nodes.contains(&"soft") && !nodes.contains(&"dem"), "{nodes:?}");
    // The same again: the same bits, and no complaint about files that a build wrote.
    let before = report["outputs"][0]["sha256"].clone();
    assert_eq!(code(&desk.build(&["--set", "relief=300", "--threads", "1"])), 0);
    assert_eq!(desk.report()["outputs"][0]["sha256"], before);
}

#[test]
fn files_of_others_and_inputs_are_not_overwritten() {
    let desk = Desk::new(&height());
    std::fs::create_dir_all(desk.path("out")).unwrap();
    std::fs::write(desk.path("out/height.r32"), "mine").unwrap();
    let refused = desk.build(&[]);
    assert_eq!(code(&refused), 2);
    assert!(said(&refused).contains("--overwrite"), "{}", said(&refused));
    assert_eq!(std::fs::read(desk.path("out/height.r32")).unwrap(), b"mine");
    assert_eq!(code(&desk.build(&["--overwrite"])), 0);
    // An output that would land on an input.
    let height = desk.path("out/height.r32");
    let graph = json!({
        "orograph": 1,
        "nodes": { "dem": { "kind": "import_height", "set": { "file": "height.r32" } } },
        "outputs": { "height": { "from": "dem.height", "format": "r32" } },
    });
    std::fs::write(desk.path("out/b.graph"), graph.to_string()).unwrap();
    let before = sha256(&height);
    let out = text(&desk.path("out"));
    let refused = run(&["build", &text(&desk.path("out/b.graph")), "-o", &out, "--overwrite"]);
    assert_eq!(code(&refused), 2, "{}", said(&refused));
    assert!(said(&refused).contains("never overwritten"), "{}", said(&refused));
    assert_eq!(sha256(&height), before);
}

#[test]
fn reports_and_pictures_spare_inputs_and_files_of_others() {
    let desk = Desk::new(&height());
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    let before = sha256(&desk.path("a.graph"));
    std::fs::write(desk.path("mine.txt"), "mine").unwrap();
    std::fs::write(desk.path("vars.json"), r#"{"relief": 100}"#).unwrap();
    let build = |report: &str| {
        run(&["build", &graph, "-o", &out, "--report", report, "--vars", &text(&desk.path("vars.json"))])
    };
    for (report, words) in [
        (graph.clone(), "never overwritten"),
        (text(&desk.path("vars.json")), "never overwritten"),
        (text(&desk.path("mine.txt")), "is no report"),
        (text(&desk.path("out/height.r32")), "where the report goes"),
    ] {
        let refused = build(&report);
        assert_eq!(code(&refused), 2, "{report}: {}", said(&refused));
        assert!(said(&refused).contains(words), "{report}: {}", said(&refused));
    }
    assert_eq!(std::fs::read(desk.path("mine.txt")).unwrap(), b"mine");
    let picture = run(&["render", &graph, "-o", &graph]);
    assert_eq!(code(&picture), 2, "{}", said(&picture));
    assert_eq!(sha256(&desk.path("a.graph")), before);
    let own = text(&desk.path("r.json"));
    assert_eq!((code(&build(&own)), code(&build(&own))), (0, 0), "a report gives way to the next");
    let printed = build("-");
    assert_eq!(serde_json::from_slice::<Json>(&printed.stdout).unwrap()["status"], "done");
    // An output whose sidecar would be the report.
    let desk = Desk::new(&json!({ "report": { "from": "soft.field", "format": "png16" } }));
    let refused = desk.build(&[]);
    assert_eq!(code(&refused), 2, "{}", said(&refused));
    assert!(said(&refused).contains("where the report goes"), "{}", said(&refused));
}

#[test]
fn a_build_does_not_mind_who_stops_listening() {
    let desk = Desk::new(&height());
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_orograph"))
        .args(["build", &graph, "-o", &out, "--size", "257", "--progress", "json"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(desk.path("out/height.r32").exists());
}

#[test]
fn a_build_sweeps_what_dead_builds_left() {
    let desk = Desk::new(&height());
    assert_eq!(code(&desk.build(&[])), 0);
    let old = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    for (name, age) in [
        (".height.r32.1-0.part", old),
        (".height.r32.2-0.part", std::time::SystemTime::now()),
        (".theirs.txt.1-0.part", old),
    ] {
        let file = std::fs::File::create(desk.path("out").join(name)).unwrap();
        file.set_modified(age).unwrap();
    }
    assert_eq!(code(&desk.build(&[])), 0);
    assert!(!desk.path("out/.height.r32.1-0.part").exists(), "nobody has written it for an hour");
    assert!(desk.path("out/.height.r32.2-0.part").exists(), "another build may be at it");
    assert!(desk.path("out/.theirs.txt.1-0.part").exists(), "not the name of a file of this folder");
}

#[test]
fn unity_gets_the_southernmost_row_first() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "for_unity": { "from": "soft.field", "target": "unity", "range": [-1000, 1000] },
    }));
    assert_eq!(code(&desk.build(&[])), 0);
    let sidecar: Json =
        serde_json::from_slice(&std::fs::read(desk.path("out/for_unity.json")).unwrap()).unwrap();
    assert_eq!((&sidecar["rows_from"], &sidecar["format"]), (&json!("south"), &json!("r16")));
    let heights = std::fs::read(desk.path("out/height.r32")).unwrap();
    let heights: Vec<f32> = heights.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let steps = std::fs::read(desk.path("out/for_unity.r16")).unwrap();
    let steps: Vec<u16> = steps.chunks(2).map(|b| u16::from_le_bytes(b.try_into().unwrap())).collect();
    for (row, line) in steps.chunks(129).rev().enumerate() {
        for (step, height) in line.iter().zip(&heights[row * 129..]) {
            let metres = f32::from(*step) / 65535.0 * 2000.0 - 1000.0;
            assert!((metres - height).abs() < 0.02, "row {row}: {metres} and {height}");
        }
    }
}

#[test]
fn exit_codes_tell_what_went_wrong() {
    let desk = Desk::new(&height());
    let graph = text(&desk.path("a.graph"));
    let out = text(&desk.path("out"));
    let expect = |args: &[&str], exit: i32, words: &str| {
        let ended = run(args);
        assert_eq!(code(&ended), exit, "{args:?}: {}", said(&ended));
        assert!(said(&ended).contains(words), "{args:?}: {}", said(&ended));
    };
    expect(&["build", "nowhere.graph", "-o", &out], 4, "nowhere.graph");
    expect(&["build", &graph], 2, "--out");
    expect(&["build", &graph, "-o", &out, "--set", "relife=3"], 2, "did you mean `relief`");
    expect(&["build", &graph, "-o", &out, "--set", "relief=9999"], 2, "500");
    expect(&["build", &graph, "-o", &out, "--set", "hills.amplitude=9"], 2, "relief");
    expect(&["build", &graph, "-o", &out, "--set", "hills.octaves=1e9"], 2, "16");
    expect(&["build", &graph, "-o", &out, "--base", "1000000"], 2, "base");
    expect(&["build", &graph, "-o", &out, "--output", "hight"], 2, "did you mean `height`");
    expect(&["build", &graph, "-o", &out, "--size", "130"], 2, "129");
    expect(&["build", &graph, "-o", &out, "--tiles", "3x1"], 2, "cannot be cut");
    expect(&["build", &graph, "-o", &out, "--region", "5,5,1,1"], 2, "--region");
    expect(&["build", &graph, "-o", &out, "--size", "16385", "--memory", "100M"], 5, "--tile-size");
    expect(&["build", &graph, "-o", &out, "--size", "16385", "--time", "0.001"], 5, "--time");
    expect(&["build", &graph, "-o", &out, "--backend", "gpu"], 6, "GPU");
    expect(&["nodes", "blurr"], 2, "did you mean `blur`");
    std::fs::write(desk.path("bad.graph"), "{\"orograph\": 1, ").unwrap();
    expect(&["check", &text(&desk.path("bad.graph"))], 3, "cut off");
    expect(&["check", &graph], 4, "node `dem`, parameter `file`: there is no such file");
    expect(&["build", &graph, "-o", &out, "--threads", "100000"], 2, "512");
    expect(&["build", &graph, "-o", &out, "--seed", "-1"], 2, "--seed");
    expect(&["render", &graph, "-o", &text(&desk.path("a.jpg"))], 2, ".png");
    std::fs::write(desk.path("twice.json"), r#"{"relief": 100, "relief": 200}"#).unwrap();
    expect(&["build", &graph, "-o", &out, "--vars", &text(&desk.path("twice.json"))], 2, "written twice");
    expect(&["build", &text(&desk.path("")), "-o", &out], 4, "not a regular file");
    assert!(!desk.path("out/report.json").exists(), "nothing was built");
}

#[test]
fn outputs_that_fail_are_listed_and_the_others_are_made() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "r32" },
        "file": { "from": "dem.height", "format": "r32" },
        "lost": { "from": "nobody.field" },
    }));
    let built = desk.build(&[]);
    assert_eq!(code(&built), 3, "{}", said(&built));
    let report = desk.report();
    assert_eq!(report["status"], "failed");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 1);
    let failures = report["failures"].to_string();
    assert!(failures.contains("missing.tif") && failures.contains("nobody"), "{failures}");
    assert!(desk.path("out/height.r32").exists());
    assert_eq!(code(&desk.build(&["--output", "file"])), 4);
}

#[test]
fn hostile_graphs_are_refused_before_harm() {
    let desk = Desk::new(&height());
    let expect = |graph: Json, words: &str| {
        std::fs::write(desk.path("x.graph"), graph.to_string()).unwrap();
        let ended = run(&["build", &text(&desk.path("x.graph")), "-o", &text(&desk.path("x"))]);
        assert!(matches!(code(&ended), 3 | 4), "{graph}: {} {}", code(&ended), said(&ended));
        assert!(said(&ended).contains(words), "{graph}: {}", said(&ended));
    };
    for file in ["../../../../../../etc/passwd", "/etc/passwd", "CON", "/dev/zero"] {
        let node = json!({ "kind": "import_height", "set": { "file": file } });
        expect(
            json!({ "orograph": 1, "nodes": { "n": node }, "outputs": { "o": { "from": "n.height" } } }),
            "node `n`",
        );
    }
    for name in ["../x", "con", "A", "a/b", ""] {
        let outputs: Json = [(name.to_owned(), json!({ "from": "n.field" }))].into_iter().collect();
        let nodes = json!({ "n": { "kind": "constant" } });
        expect(json!({ "orograph": 1, "nodes": nodes, "outputs": outputs }), "output");
    }
    let noise = json!({ "kind": "fractal_noise", "set": { "octaves": 1e9 } });
    expect(
        json!({ "orograph": 1, "nodes": { "n": noise }, "outputs": { "o": { "from": "n.field" } } }),
        "octaves",
    );
    let mut claim = b"ncols 1000000\nnrows 1000000\nxllcorner 0\nyllcorner 0\ncellsize 1\n".to_vec();
    claim.extend(b"1 2 3\n");
    std::fs::write(desk.path("huge.asc"), claim).unwrap();
    let node = json!({ "kind": "import_height", "set": { "file": "huge.asc" } });
    expect(
        json!({ "orograph": 1, "nodes": { "n": node }, "outputs": { "o": { "from": "n.height" } } }),
        "huge.asc",
    );
    let left: Vec<_> =
        std::fs::read_dir(desk.folder.path()).unwrap().flatten().map(|e| e.file_name()).collect();
    assert!(left.iter().all(|n| ["a.graph", "x.graph", "x", "huge.asc"].iter().any(|k| n == k)), "{left:?}");
}

fn samples(path: &Path) -> Vec<f32> {
    let bytes = std::fs::read(path).unwrap();
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn tiles_and_regions_on_disk_are_cut_from_the_whole() {
    let desk = Desk::new(&height());
    assert_eq!(code(&desk.build(&["--size", "257"])), 0);
    let whole = samples(&desk.path("out/height.r32"));
    assert_eq!(whole.len(), 257 * 129);
    assert_eq!(code(&desk.build(&["--size", "257", "--tile-size", "65"])), 0);
    for (i, j) in [(0, 0), (3, 1), (2, 0)] {
        let tile = samples(&desk.path(&format!("out/height_x{i}_y{j}.r32")));
        for r in 0..65 {
            let start = (j * 64 + r) * 257 + i * 64;
            assert_eq!(tile[r * 65..][..65], whole[start..start + 65], "tile {i},{j} row {r}");
        }
    }
    assert_eq!(code(&desk.build(&["--size", "257", "--region", "512,256,1024,512"])), 0);
    let region = samples(&desk.path("out/height.r32"));
    assert_eq!(region.len(), 65 * 33);
    assert_eq!(region[..65], whole[32 * 257 + 64..][..65]);
}

#[test]
fn a_killed_build_leaves_whole_files_and_no_lying_report() {
    let outputs = json!({
        "height": { "from": "soft.field", "format": "exr" },
        "picture": { "from": "hills.field", "format": "png16", "range": [-900, 900] },
        "plain": { "from": "hills.field", "format": "tiff" },
    });
    // Spread over all that a whole build tells.
    let whole = Desk::new(&outputs);
    let told = said(&whole.build(&["--size", "513", "--progress", "json"])).lines().count();
    assert!(told > 10, "{told} lines");
    let mut cut_short = 0;
    for i in 0..24 {
        let desk = Desk::new(&outputs);
        assert_eq!(code(&desk.build(&["--size", "33"])), 0, "an old report stands there");
        let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
        let mut build = orograph();
        build.args(["build", &graph, "-o", &out, "--size", "513", "--progress", "json"]);
        let mut child = until_told(&mut build, told * i / 23);
        // SIGKILL: no handler runs.
        let _ = child.kill();
        let ended = child.wait().unwrap();
        cut_short += usize::from(!ended.success());
        for entry in std::fs::read_dir(desk.path("out")).unwrap().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = entry.path();
            let bytes = std::fs::read(&path).unwrap();
            if ["exr", "png", "tif"].iter().any(|e| name.ends_with(e)) && !name.starts_with('.') {
                read_height(&name, &bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
            }
            if name == "report.json" {
                let report: Json = serde_json::from_slice(&bytes).unwrap();
                for o in report["outputs"].as_array().unwrap() {
                    let file = desk.path("out").join(o["path"].as_str().unwrap());
                    assert_eq!(o["sha256"], sha256(&file), "the report speaks of another file");
                }
            }
        }
        assert_eq!(code(&desk.build(&["--size", "65"])), 0, "the next build is not in the way of the last");
    }
    assert!(cut_short >= 5, "only {cut_short} builds were cut short");
}

#[cfg(unix)]
#[test]
fn an_interrupted_build_ends_with_130_and_no_report() {
    let desk = Desk::new(&height());
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    let mut build = orograph();
    build.args(["build", &graph, "-o", &out, "--size", "8193", "--set", "soft.radius=3000"]);
    // Its first word says that the work has begun.
    let child = until_told(build.args(["--progress", "json"]), 1);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(code(&ended), 130);
    assert!(!desk.path("out/report.json").exists() && !desk.path("out/height.r32").exists());
}

#[test]
fn the_process_stays_within_its_budget_of_memory() {
    let desk = Desk::new(&json!({
        "height": { "from": "soft.field", "format": "exr" },
        "picture": { "from": "hills.field", "format": "png16", "range": [-900, 900] },
    }));
    for (size, budget) in [("1025", 160u64), ("2049", 256)] {
        let built = desk.build(&["--size", size, "--memory", &format!("{budget}M")]);
        assert_eq!(code(&built), 0, "{}", said(&built));
        let report = desk.report();
        let Some(peak) = report["process_peak_bytes"].as_u64() else {
            let reason = "this system does not tell the peak of memory";
            let needs = std::path::Path::new("/proc/self/status");
            return skip("the_process_stays_within_its_budget_of_memory", reason, needs);
        };
        println!("{size}: {peak} of {budget} MiB, planned {}", report["planned_bytes"]);
        assert!(peak <= budget << 20, "{size}: {peak} bytes of {budget} MiB");
    }
}

#[test]
fn a_cache_folder_serves_the_next_process() {
    let desk = Desk::new(&height());
    let cache = text(&desk.path("cache"));
    assert_eq!(code(&desk.build(&["--cache", &cache])), 0);
    let cold = desk.report()["outputs"][0]["sha256"].clone();
    assert_eq!(code(&desk.build(&["--cache", &cache])), 0);
    let report = desk.report();
    assert_eq!(report["outputs"][0]["sha256"], cold);
    let runs: u64 = report["nodes"].as_array().unwrap().iter().map(|n| n["runs"].as_u64().unwrap()).sum();
    assert_eq!(runs, 0, "{}", report["nodes"]);
}

#[test]
fn the_other_commands_answer() {
    let desk = Desk::new(&height());
    let graph = text(&desk.path("a.graph"));
    let plan = run(&["plan", &graph, "--output", "height", "--json"]);
    let plan: Json = serde_json::from_slice(&plan.stdout).unwrap();
    assert_eq!(plan["tasks"].as_array().unwrap().len(), 2);
    assert!(plan["peak_bytes"].as_u64().unwrap() > 60_000);
    let info = run(&["info", &graph, "--json"]);
    let info: Json = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!(info["exposed"][0]["name"], "relief");
    assert!(said(&run(&["nodes"])).contains("fractal_noise"));
    assert!(said(&run(&["nodes", "blur"])).contains("## Parameters"));
    assert!(serde_json::from_slice::<Json>(&run(&["schema"]).stdout).is_ok());
    assert!(said(&run(&["completions", "bash"])).contains("_orograph"));
    assert_eq!(code(&run(&["fmt", "--check", &graph])), 1);
    assert_eq!(code(&run(&["fmt", &graph])), 0);
    assert_eq!(code(&run(&["fmt", "--check", &graph])), 0);
    let check = run(&["check", &graph, "--json"]);
    let problems: Json = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(problems[0]["place"]["parameter"], json!({ "node": "dem", "parameter": "file" }));
    let picture = text(&desk.path("a.png"));
    for view in ["map", "perspective"] {
        let drawn =
            run(&["render", &graph, "-o", &picture, "--size", "65", "--width", "160", "--view", view]);
        assert_eq!(code(&drawn), 0, "{}", said(&drawn));
        let png = std::fs::read(desk.path("a.png")).unwrap();
        assert_eq!(&png[1..4], b"PNG");
    }
}

#[test]
fn convert_keeps_every_sample() {
    let desk = Desk::new(&json!({ "height": { "from": "soft.field", "format": "tiff" } }));
    assert_eq!(code(&desk.build(&[])), 0);
    let tif = text(&desk.path("out/height.tif"));
    let read =
        |name: &str| read_height(name, &std::fs::read(name).unwrap(), None, &Limits::default()).unwrap();
    let first = read(&tif);
    let mut from = tif.clone();
    for to in ["b.exr", "c.asc", "d.tif"] {
        let to = text(&desk.path(to));
        let done = run(&["convert", &from, &to]);
        assert_eq!(code(&done), 0, "{}", said(&done));
        from = to;
    }
    assert_eq!(read(&from).data, first.data);
    let again = run(&["convert", &tif, &from]);
    assert_eq!(code(&again), 2, "{}", said(&again));
    assert_eq!(code(&run(&["convert", &tif, &tif, "--overwrite"])), 2);
}

/// What a node skips is said on standard error and in the report, once, by node.
#[test]
fn a_node_warns() {
    let desk = Desk::new(&height());
    let line = json!({ "type": "LineString", "coordinates": [[100, -200], [900, -300], [1800, -700]] });
    let features = [
        json!({ "type": "Feature", "properties": { "elevation": 300 }, "geometry": line }),
        json!({ "type": "Feature", "properties": {}, "geometry": { "type": "Point", "coordinates": [1, 2] } }),
    ];
    let file = json!({ "type": "FeatureCollection", "features": features });
    std::fs::write(desk.path("lines.geojson"), file.to_string()).unwrap();
    let mapping = json!({ "height": { "property": { "name": "elevation" } } });
    let graph = json!({
        "orograph": 1,
        "kinds": { "import_curves": 2, "curve_raster": 1, "diffuse": 1 },
        "terrain": { "width": 2048, "depth": 1024, "base": 129 },
        "nodes": {
            "lines": { "kind": "import_curves", "set": { "file": "lines.geojson", "mapping": mapping } },
            "marks": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
            "land": { "kind": "diffuse", "in": { "constraints": "marks.constraints" } },
        },
        "outputs": { "height": { "from": "land.height", "format": "r32" } },
    });
    std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
    let built = desk.build(&["--tiles", "2x1"]);
    let said = said(&built);
    assert_eq!(code(&built), 0, "{said}");
    let warning = "node `lines`: 1 geometry that is no line, left out: feature 1, a Point";
    assert_eq!(said.matches(warning).count(), 1, "{said}");
    assert_eq!(desk.report()["warnings"], json!([warning]));
    let drawn = run(&["render", &text(&desk.path("a.graph")), "-o", &text(&desk.path("a.png"))]);
    let drawn = String::from_utf8_lossy(&drawn.stderr).into_owned();
    assert!(drawn.contains(warning), "{drawn}");
}

#[cfg(unix)]
#[test]
fn a_report_keeps_its_mode() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new(&height());
    assert_eq!(code(&desk.build(&[])), 0);
    let report = desk.path("out/report.json");
    std::fs::set_permissions(&report, std::fs::Permissions::from_mode(0o640)).unwrap();
    assert_eq!(code(&desk.build(&[])), 0);
    assert_eq!(report.metadata().unwrap().permissions().mode() & 0o777, 0o640);
}

/// The terrain has the size of the file at the cell that is asked for, and so does the file in it.
#[test]
fn fitting_by_a_cell_gives_it_to_the_node() {
    let folder = names::travelled("");
    let path = |name: &str| text(&folder.path().join(name));
    let (graph, heights) = (path("home/a.graph"), path("home/heights/a.asc"));
    let rows = "1 2 3 4 5 6 7 8 9\n".repeat(9);
    std::fs::write(&heights, format!("ncols 9\nnrows 9\nxllcenter 0\nyllcenter 0\ncellsize 300\n{rows}"))
        .unwrap();
    let middle = json!({ "true_size": { "x": 0, "y": 0, "rotation": 0 } });
    let fitted = |own: Option<f64>, placement: &Json, args: &[&str]| {
        let mut set = json!({ "file": "heights/a.asc", "placement": placement });
        own.into_iter().for_each(|cell| set["cell"] = json!(cell));
        let nodes = json!({ "dem": { "kind": "import_height", "set": set } });
        std::fs::write(&graph, json!({ "orograph": 1, "nodes": nodes }).to_string()).unwrap();
        let ended = run(&[&["fit", &graph, &heights], args].concat());
        let made: Json = serde_json::from_slice(&std::fs::read(&graph).unwrap()).unwrap();
        let [width, cell] = [&made["terrain"]["width"], &made["nodes"]["dem"]["set"]["cell"]];
        (code(&ended), width.as_f64(), cell.as_f64())
    };
    for (own, args, width, cell) in [
        (None, &[][..], 2400.0, None),
        (None, &["--cell", "100"][..], 800.0, Some(100.0)),
        (Some(200.0), &[], 1600.0, Some(200.0)),
        (Some(200.0), &["--cell", "100"], 800.0, Some(100.0)),
    ] {
        assert_eq!(fitted(own, &middle, args), (0, Some(width), cell), "{own:?} {args:?}");
    }
    // A georeference has the steps of the file, whatever anybody says.
    assert_eq!(fitted(None, &json!("georeference"), &["--cell", "100"]).0, 2);
    let refused = said(&run(&["fit", &graph, &heights, "--cell", "100"]));
    assert!(refused.contains("--cell is for nodes that are stretched"), "{refused}");
}

/// Factors on heights are taken in one way by all commands: rounded once, and refused where nothing can hold the product.
#[test]
fn heights_are_scaled_to_numbers_that_can_be_held() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    let [asc, png, tif] = ["a.asc", "a.png", "b.tif"].map(path);
    std::fs::write(&asc, "ncols 2\nnrows 2\ncellsize 1\n1e30 2\n3 4\n").unwrap();
    for args in [&["render", &asc, "-o", &png][..], &["convert", &asc, &tif]] {
        let ended = run(&[args, &["--height-scale", "1e9"]].concat());
        assert_eq!(code(&ended), 2, "{args:?}: {}", said(&ended));
        assert!(said(&ended).contains("too large to be kept"), "{args:?}: {}", said(&ended));
    }
}

/// The length of a file is held against its limit before anything is held against the budget.
#[test]
fn a_file_over_its_limit_is_no_question_of_memory() {
    let desk = Desk::new(&height());
    let long = std::fs::File::create(desk.path("long.svg")).unwrap();
    long.set_len((64 << 20) + 1).unwrap();
    let graph = json!({
        "orograph": 1,
        "terrain": { "base": 33 },
        "nodes": {
            "lines": { "kind": "import_curves", "set": { "file": "long.svg" } },
            "marks": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
            "land": { "kind": "diffuse", "in": { "constraints": "marks.constraints" } },
        },
        "outputs": { "height": { "from": "land.height", "format": "r32" } },
    });
    std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
    let graph = text(&desk.path("a.graph"));
    let words = "bytes of the file: at most 67108864, got 67108865";
    for ended in [
        desk.build(&["--memory", "256M"]),
        run(&["plan", &graph, "--memory", "256M"]),
        run(&["check", &graph]),
    ] {
        assert_eq!(code(&ended), 4, "{}", said(&ended));
        assert!(said(&ended).contains(words), "{}", said(&ended));
    }
}
