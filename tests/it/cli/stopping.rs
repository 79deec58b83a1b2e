//! Builds that are killed or interrupted.

use std::process::Command;

use orograph::files::{Limits, read_height};
use serde_json::{Value as Json, json};

use super::{Desk, code, height, orograph, said, sha256, text, until_told};

#[test]
fn killed_builds_leave_whole_files_and_no_false_report() {
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
fn interrupted_builds_end_with_130_and_no_report() {
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
