//! Options and formats: what contradicts, or would be ignored, is refused.

use serde_json::Value as Json;

use super::{Desk, code, height, orograph, run, said, text};

#[test]
fn what_is_wrong_with_the_command_line_is_json_where_json_is_asked_for() {
    let desk = Desk::new(&height());
    let graph = text(&desk.path("a.graph"));
    for (args, words) in [
        (&["info", &graph, "--json", "--seed", "abc"][..], "invalid value 'abc' for '--seed"),
        (&["info", &graph, "--base", "q", "--json"], "--base"),
        (&["check", "--json", "--nonsense"], "unexpected argument '--nonsense'"),
        (&["plan", "--json"], "required arguments were not provided"),
        (&["build", "--json", &graph, "-o", "x"], "unexpected argument '--json'"),
        (&["plan", &graph, "--json", "--cache-size", "1G"], "--cache-size is for a cache folder"),
    ] {
        let ended = run(args);
        assert_eq!(code(&ended), 2, "{args:?}: {}", said(&ended));
        let json: Json = serde_json::from_slice(&ended.stdout).unwrap();
        let error = json["error"].as_str().unwrap();
        assert_eq!(json["exit"], 2, "{json}");
        assert!(error.contains(words) && !error.contains("Usage:"), "{args:?}: {error}");
        assert!(!error.starts_with("error"), "{error}");
    }
    let plain = run(&["check", "--nonsense", "--", "--json"]);
    assert!(code(&plain) == 2 && plain.stdout.is_empty(), "{}", said(&plain));
}

/// No option is ignored in silence: what it is for is said.
#[test]
fn options_that_would_be_ignored_are_refused() {
    let desk = Desk::new(&height());
    let [graph, asc, raw, out, picture] =
        ["a.graph", "a.asc", "a.r16", "out", "a.png"].map(|name| text(&desk.path(name)));
    std::fs::write(&asc, "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n").unwrap();
    std::fs::write(&raw, [0; 8]).unwrap();
    let draw = |option: &'static str, value: &'static str, view: &'static str| {
        ["render", &graph, "-o", &picture, "--view", view, option, value].map(str::to_owned).to_vec()
    };
    let words = |args: &[&str]| args.iter().map(|a| (*a).to_owned()).collect::<Vec<String>>();
    for (args, said_of) in [
        (words(&["info", &asc, "--sample", "u8"]), "--sample is for a raw file, which"),
        (
            words(&["info", &asc, "--byte-order", "big", "--cols", "2"]),
            "--byte-order, --cols are for a raw file",
        ),
        (words(&["info", &asc, "--terrarium"]), "--terrarium is for a PNG, which"),
        (words(&["convert", &raw, &picture, "--terrain-rgb"]), "--terrain-rgb is for a PNG, which"),
        (
            words(&["render", &raw, "-o", &picture, "--channel", "Z"]),
            "--channel is for a file of channels or bands",
        ),
        (words(&["fit", &graph, &asc, "--channel", "1"]), "--channel is for a file of channels or bands"),
        (
            words(&["convert", &asc, "b.exr", "--range", "0,9"]),
            "--range is for formats of integers, which exr is not",
        ),
        (words(&["convert", &asc, "b.r32", "--clip"]), "--clip is for formats of integers, which r32 is not"),
        (draw("--camera", "0,10,45", "map"), "--camera is for a perspective, and a map is drawn"),
        (draw("--haze", "2", "map"), "--haze is for a perspective"),
        (draw("--height", "200", "map"), "--height is for a perspective"),
        (draw("--distance", "200", "map"), "--distance is for a perspective"),
        (draw("--look-at", "0,0,0", "map"), "--look-at is for a perspective"),
        (draw("--edge", "haze", "map"), "--edge is for a perspective"),
        (draw("--contours", "20", "perspective"), "--contours is for a map, and a perspective is drawn"),
        (words(&["build", &graph, "-o", &out, "--cache-size", "1G"]), "--cache-size is for a cache folder"),
        (
            words(&["fit", &graph, &asc, "--dry-run", "--overwrite"]),
            "--overwrite is for a graph that is written",
        ),
        (words(&["fit", &graph, &asc, "--overwrite"]), "--overwrite is for another graph; name it with -o"),
        (words(&["render", &asc, "-o", &picture, "--threads", "1"]), "--threads is for graphs, which"),
        (
            words(&["build", &graph, "-o", &out, "--seed", "1", "--set", "terrain.seed=2"]),
            "--seed and --set terrain.seed set the same",
        ),
        (
            words(&["plan", &graph, "--base", "65", "--set", "terrain.base=33"]),
            "--base and --set terrain.base",
        ),
    ] {
        let ended = orograph().args(&args).output().unwrap();
        assert_eq!(code(&ended), 2, "{args:?}: {}", said(&ended));
        assert!(said(&ended).contains(said_of), "{args:?}: {}", said(&ended));
    }
    assert!(!desk.path("out").exists() && !desk.path("a.png").exists() && !desk.path("b.graph").exists());
}

#[test]
fn a_format_does_not_contradict_the_name_of_its_file() {
    let desk = Desk::new(&height());
    let asc = text(&desk.path("a.asc"));
    std::fs::write(&asc, "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n").unwrap();
    for (name, format, words) in [
        ("b.r32", "png16", "is the name of a file of"),
        ("b.hgt", "tiff", "end it in .tif"),
        ("b.r16", "r32", "end it in .r32"),
        ("b.png", "tiff16", "end it in .tif"),
    ] {
        let ended = run(&["convert", &asc, &text(&desk.path(name)), "--format", format]);
        assert!(code(&ended) == 2 && said(&ended).contains(words), "{name} {format}: {}", said(&ended));
        assert!(!desk.path(name).exists(), "{name}");
    }
    for (name, format) in [("c.tif", "tiff16"), ("d.png", "png8"), ("e.dem", "tiff"), ("f.raw", "r32")] {
        let range: &[&str] = if matches!(format, "png8" | "tiff16") { &["--range", "0,9"] } else { &[] };
        let ended = run(&[&["convert", &asc, &text(&desk.path(name)), "--format", format], range].concat());
        assert_eq!(code(&ended), 0, "{name} {format}: {}", said(&ended));
    }
}
