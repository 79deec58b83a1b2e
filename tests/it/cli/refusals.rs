//! Exit codes, hostile graphs and budgets.

use serde_json::{Value as Json, json};

use super::{Desk, code, height, run, said, text};
use crate::rig::skip::skip;

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

#[test]
fn memory_of_the_process_stays_within_its_budget() {
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
            return skip("memory_of_the_process_stays_within_its_budget", reason, needs);
        };
        println!("{size}: {peak} of {budget} MiB, planned {}", report["planned_bytes"]);
        assert!(peak <= budget << 20, "{size}: {peak} bytes of {budget} MiB");
    }
}

/// The length of a file is held against its limit before anything is held against the budget.
#[test]
fn file_limits_are_checked_before_the_budget() {
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
