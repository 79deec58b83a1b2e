//! `stats`: figures of files and graphs.

use super::*;

/// Heights of a plane that rises by 3 m in 10 to the east, as a file of text.
fn plane(desk: &Desk, name: &str, head: &str) -> String {
    let row: Vec<String> = (0..40).map(|i| (3 * i).to_string()).collect();
    let rows = vec![row.join(" "); 30].join("\n");
    let path = desk.path(name);
    std::fs::write(&path, format!("ncols 40\nnrows 30\n{head}\n{rows}\n")).unwrap();
    text(&path)
}

fn json_of(args: &[&str]) -> Json {
    let ended = run(args);
    assert_eq!(code(&ended), 0, "{args:?}: {}", said(&ended));
    serde_json::from_slice(&ended.stdout).unwrap()
}

#[test]
fn a_file_has_figures() {
    let desk = Desk::new(&height());
    let asc = plane(&desk, "plane.asc", "xllcorner 0\nyllcorner 0\ncellsize 10");
    let found = json_of(&["stats", &asc, "--json"]);
    let slope = libm::atan(0.3).to_degrees();
    assert!((found["slope"]["p50"].as_f64().unwrap() - slope).abs() < 1e-3, "{found}");
    assert_eq!((&found["samples"], &found["cell"]), (&json!([40, 30]), &json!(10.0)));
    assert_eq!((&found["sea"], &found["land"], &found["output"]), (&Json::Null, &json!(1.0), &Json::Null));
    assert_eq!(found["spectrum"], Json::Null, "a plane has no waves");
    let lines = String::from_utf8(run(&["stats", &asc]).stdout).unwrap();
    for words in ["40 x 30 cells of 10 m, 0.4 x 0.3 km, land 100 %", "16.7°", "depressions", "real models"] {
        assert!(lines.contains(words), "{words}: {lines}");
    }
    let sunk = json_of(&["stats", &asc, "--json", "--sea", "29.5"]);
    assert_eq!((&sunk["land"], &sunk["hypsometry"]["lowest"]), (&json!(0.75), &json!(30.0)));
    let scaled =
        json_of(&["stats", &asc, "--json", "--height-scale", "2", "--cell", "60", "--target-cell", "120"]);
    assert_eq!(
        (&scaled["cell"], &scaled["averaged"], &scaled["samples"]),
        (&json!(120.0), &json!(2), &json!([20, 15]))
    );
    let slope = libm::atan(0.1).to_degrees();
    assert!((scaled["slope"]["p50"].as_f64().unwrap() - slope).abs() < 1e-3, "{scaled}");
}

#[test]
fn a_graph_has_figures_of_its_heights() {
    let desk = Desk::new(&json!({
        "steep": { "from": "rocks.mask" }, "height": { "from": "soft.field" }, "raw": { "from": "hills.field" },
    }));
    let graph = text(&desk.path("a.graph"));
    let with_mask = std::fs::read_to_string(&graph).unwrap().replace(
        "\"nodes\":{",
        "\"nodes\":{\"rocks\":{\"kind\":\"select_slope\",\"in\":{\"height\":\"hills.field\"}},",
    );
    std::fs::write(&graph, with_mask).unwrap();
    let found = json_of(&["stats", &graph, "--json", "--size", "257"]);
    assert_eq!(
        (&found["output"], &found["samples"], &found["sea"]),
        (&json!("height"), &json!([257, 129]), &json!(5.0))
    );
    assert_eq!(found["cell"], json!(8.0));
    let raw =
        json_of(&["stats", &graph, "--json", "--output", "raw", "--sea", "none", "--set", "relief=400"]);
    assert_eq!((&raw["sea"], &raw["land"], &raw["samples"]), (&Json::Null, &json!(1.0), &json!([129, 65])));
    assert!(raw["hypsometry"]["relief"].as_f64() > found["hypsometry"]["relief"].as_f64(), "{raw}");
    let compared = found["compared"].as_array().unwrap();
    let steepest = compared.iter().find(|row| row["figure"] == "/slope/p95").unwrap();
    assert_eq!(steepest["value"], found["slope"]["p95"]);
    assert!(["below", "inside", "above"].contains(&steepest["is"].as_str().unwrap()), "{steepest}");
    let mask = run(&["stats", &graph, "--output", "steep"]);
    assert_eq!(code(&mask), 2, "{}", said(&mask));
    assert!(said(&mask).contains("`steep` is"), "{}", said(&mask));
    let sunk = run(&["stats", &graph, "--json", "--sea", "1e5"]);
    assert_eq!(code(&sunk), 1, "{}", said(&sunk));
    let error: Json = serde_json::from_slice(&sunk.stdout).unwrap();
    assert!(error["error"].as_str().unwrap().contains("no land"), "{error}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let desk = Desk::new(&json!({}));
    let asc = plane(&desk, "plane.asc", "xllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value 0");
    let (graph, raw) = (text(&desk.path("a.graph")), text(&desk.path("a.r32")));
    std::fs::write(&raw, [0u8; 4 * 16]).unwrap();
    for (args, code_of, words) in [
        (&["stats", &raw, "--json"][..], 2, "give --cell METRES"),
        (&["stats", &asc, "--size", "65"], 2, "--size is for graphs"),
        (&["stats", &asc, "--output", "x", "--seed", "1"], 2, "are for graphs"),
        (&["stats", &graph, "--cell", "5"], 2, "--cell is for height files"),
        (&["stats", &graph], 3, "no outputs"),
        (&["stats", &asc, "--cell", "0"], 2, "above 0"),
        (&["stats", &asc, "--sea", "deep"], 2, "or `none`"),
        (
            &["stats", &asc, "--sea", "9999"],
            4,
            "no land to measure: every cell is void or not above the sea at 9999 m",
        ),
        (&["stats", &text(&desk.path("missing.tif"))], 4, "missing.tif"),
        (&["stats", &asc, "--memory", "1M"], 5, "Raise --memory"),
    ] {
        let ended = run(args);
        assert_eq!(code(&ended), code_of, "{args:?}: {}", said(&ended));
        assert!(said(&ended).contains(words), "{args:?}: {}", said(&ended));
    }
}
