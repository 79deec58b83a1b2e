//! The other commands.

use orograph::files::{Limits, read_height};
use serde_json::{Value as Json, json};

use super::{Desk, code, height, names, run, said, text};

#[test]
fn commands_answer() {
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

/// The terrain has the size of the file at the cell that is asked for, and so does the file in it.
#[test]
fn fit_by_a_cell_sets_it_on_the_node() {
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
