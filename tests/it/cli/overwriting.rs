//! Files that a build replaces, and files that it spares.

use serde_json::{Value as Json, json};

use super::{Desk, code, height, run, said, sha256, text};

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
fn temporary_files_of_dead_builds_are_removed() {
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

#[cfg(unix)]
#[test]
fn reports_keep_their_mode() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new(&height());
    assert_eq!(code(&desk.build(&[])), 0);
    let report = desk.path("out/report.json");
    std::fs::set_permissions(&report, std::fs::Permissions::from_mode(0o640)).unwrap();
    assert_eq!(code(&desk.build(&[])), 0);
    assert_eq!(report.metadata().unwrap().permissions().mode() & 0o777, 0o640);
}
