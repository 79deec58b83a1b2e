//! A farm's way of building: many processes, one folder; and what is left of builds that went before.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use serde_json::{Value as Json, json};

use super::cli::{code, orograph, run, said, text};

/// A folder with a graph of two outputs, which is made in no time.
struct Farm(tempfile::TempDir);

impl Farm {
    fn new() -> Self {
        let farm = Self(tempfile::tempdir().unwrap());
        farm.graph(100, json!({ "height": { "from": "hills.field", "format": "r32" }, "map": { "from": "soft.field", "format": "exr" } }));
        farm
    }

    fn graph(&self, amplitude: u32, outputs: Json) {
        let hills = json!({ "kind": "fractal_noise", "set": { "seed": 3, "amplitude": amplitude } });
        let soft = json!({ "kind": "blur", "in": { "field": "hills.field" }, "set": { "radius": 60 } });
        let graph = json!({
            "orograph": 1, "terrain": { "width": 1200, "depth": 900, "base": 65 },
            "nodes": { "hills": hills, "soft": soft }, "outputs": outputs,
        });
        std::fs::write(self.path("a.graph"), graph.to_string()).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn words(&self, out: &str, more: &[&str]) -> Vec<String> {
        self.words_at(97, out, more)
    }

    fn words_at(&self, size: u32, out: &str, more: &[&str]) -> Vec<String> {
        let (graph, out, size) = (text(&self.path("a.graph")), text(&self.path(out)), size.to_string());
        let words = ["build", &graph, "-o", &out, "--size", &size];
        words.iter().chain(more).map(|w| (*w).to_owned()).collect()
    }

    fn build(&self, out: &str, more: &[&str]) {
        let built = orograph().args(self.words(out, more)).output().unwrap();
        assert_eq!(code(&built), 0, "{more:?}: {}", said(&built));
    }

    fn json(&self, name: &str) -> Json {
        serde_json::from_slice(&std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// The files of a folder and what they hold, but for those that say when and by whom.
    fn files(&self, out: &str) -> Vec<(String, Vec<u8>)> {
        let mut files: Vec<_> = names(&self.path(out)).into_iter().filter(|n| !n.starts_with('.')).collect();
        files.retain(|n| n != "report.json");
        files.into_iter().map(|n| (n.clone(), std::fs::read(self.path(out).join(n)).unwrap())).collect()
    }
}

fn names(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

fn each_tile() -> impl Iterator<Item = (u32, u32)> {
    (0..3).flat_map(|j| (0..4).map(move |i| (i, j)))
}

#[test]
fn a_process_a_tile_makes_what_one_process_makes() {
    let farm = Farm::new();
    farm.build("whole", &["--tiles", "4x3"]);
    farm.build("twice", &["--tiles", "4x3", "--tile", "1,0", "--tile", "2,0"]);
    for (i, j) in each_tile() {
        farm.build("apart", &["--tiles", "4x3", "--tile", &format!("{i},{j}")]);
    }
    assert_eq!(farm.files("apart"), farm.files("whole"));
    assert_eq!(farm.files("whole").len(), 4 * 12, "two outputs, each with a sidecar");
    assert_eq!(farm.files("twice").len(), 4 * 2);
    for (i, j) in each_tile() {
        let sidecar = farm.json(&format!("apart/height_x{i}_y{j}.json"));
        assert_eq!(sidecar["tile"], json!({ "col": i, "row": j, "cols": 4, "rows": 3 }));
    }
    // The report of the folder speaks of all of them, as that of one process does.
    let [apart, whole] = ["apart", "whole"].map(|out| farm.json(&format!("{out}/report.json")));
    assert_eq!(apart["outputs"], whole["outputs"]);
    assert_eq!(apart["tiles"], json!({ "cols": 4, "rows": 3, "built": 12 }));
    assert_eq!(
        (&apart["status"], &apart["failures"], &apart["stale"]),
        (&json!("done"), &json!([]), &json!([]))
    );
    assert_eq!(apart["graph_key"], whole["graph_key"]);
    assert!(apart["outputs"].as_array().unwrap().iter().all(|o| o["tile"]["cols"] == 4));
}

#[test]
fn processes_at_the_same_time_lose_nothing() {
    let farm = Farm::new();
    farm.build("whole", &["--tiles", "4x3"]);
    let jobs: Vec<_> = each_tile()
        .map(|(i, j)| {
            let words =
                farm.words("apart", &["--tiles", "4x3", "--tile", &format!("{i},{j}"), "--threads", "1"]);
            orograph().args(words).stderr(Stdio::piped()).spawn().unwrap()
        })
        .collect();
    for job in jobs {
        let ended = job.wait_with_output().unwrap();
        assert_eq!(code(&ended), 0, "{}", said(&ended));
    }
    assert_eq!(farm.files("apart"), farm.files("whole"));
    let list = farm.json("apart/.orograph-files.json");
    let listed: BTreeSet<_> =
        list["files"].as_array().unwrap().iter().map(|n| n.as_str().unwrap().to_owned()).collect();
    let there: BTreeSet<_> = farm.files("apart").into_iter().map(|(name, _)| name).collect();
    assert_eq!(listed, there);
    let report = farm.json("apart/report.json");
    assert_eq!(report["tiles"]["built"], 12);
    assert_eq!(report["outputs"], farm.json("whole/report.json")["outputs"]);
    assert!(names(&farm.path("apart")).iter().all(|n| !n.ends_with(".part")));
    // Once more, over all that is there.
    farm.build("apart", &["--tiles", "4x3", "--tile", "0,0"]);
    assert_eq!(farm.json("apart/report.json")["tiles"]["built"], 12);
}

#[test]
fn a_report_that_the_user_names_is_of_one_build() {
    let farm = Farm::new();
    let report = text(&farm.path("one.json"));
    for tile in ["0,0", "1,0"] {
        farm.build("out", &["--tiles", "4x3", "--tile", tile, "--report", &report]);
    }
    let report = farm.json("one.json");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 2);
    assert_eq!(report["outputs"][0]["tile"], json!({ "col": 1, "row": 0, "cols": 4, "rows": 3 }));
    assert!(!farm.path("out/report.json").exists());
}

#[test]
fn tiles_of_another_build_are_not_in_the_report() {
    let farm = Farm::new();
    farm.build("out", &["--tiles", "4x3", "--tile", "0,0"]);
    farm.build("out", &["--tiles", "4x3", "--tile", "1,0", "--set", "hills.amplitude=50"]);
    let report = farm.json("out/report.json");
    assert_eq!(report["tiles"]["built"], 1, "another graph");
    let stale: Vec<_> = report["stale"].as_array().unwrap().iter().map(|s| s.as_str().unwrap()).collect();
    assert_eq!(stale, ["height_x0_y0.json", "height_x0_y0.r32", "map_x0_y0.exr", "map_x0_y0.json"]);
    farm.build("out", &["--tiles", "2x3", "--tile", "1,0", "--set", "hills.amplitude=50"]);
    assert_eq!(
        farm.json("out/report.json")["tiles"],
        json!({ "cols": 2, "rows": 3, "built": 1 }),
        "another cut"
    );
}

#[test]
fn one_tile_that_is_asked_for_is_named_as_one() {
    let farm = Farm::new();
    farm.build("out", &["--tiles", "1x1"]);
    assert!(farm.path("out/height_x0_y0.r32").exists() && !farm.path("out/height.r32").exists());
    let out = text(&farm.path("other"));
    let lone = run(&["build", &text(&farm.path("a.graph")), "-o", &out, "--tile", "0,0"]);
    assert_eq!(code(&lone), 2, "{}", said(&lone));
    assert!(said(&lone).contains("--tiles NxM") && !farm.path("other").exists(), "{}", said(&lone));
}

/// After a build that failed, files of it and of the build before stand side by side: the report tells which.
#[test]
fn files_of_an_earlier_build_are_named_by_the_report() {
    let farm = Farm::new();
    farm.build("out", &[]);
    assert_eq!(farm.json("out/report.json")["stale"], json!([]));
    let first = farm.json("out/height.json")["graph_key"].clone();
    assert_eq!(first, farm.json("out/report.json")["graph_key"]);
    farm.graph(100, json!({
        "height": { "from": "hills.nothing", "format": "r32" }, "map": { "from": "soft.field", "format": "exr" },
    }));
    let failed = orograph().args(farm.words("out", &[])).output().unwrap();
    assert_eq!(code(&failed), 3, "{}", said(&failed));
    let report = farm.json("out/report.json");
    assert_eq!(report["stale"], json!(["height.json", "height.r32"]));
    assert_ne!(report["graph_key"], first);
    assert_eq!(farm.json("out/height.json")["graph_key"], first);
    assert_eq!(farm.json("out/map.json")["graph_key"], report["graph_key"]);
    // Another size is another build, too; files of others are nobody's here.
    farm.graph(100, json!({ "height": { "from": "hills.field", "format": "r32" } }));
    std::fs::write(farm.path("out/mine.txt"), "mine").unwrap();
    let built = orograph().args(farm.words_at(65, "out", &[])).output().unwrap();
    assert_eq!(code(&built), 0, "{}", said(&built));
    assert_eq!(farm.json("out/report.json")["stale"], json!(["map.exr", "map.json"]));
}

#[test]
fn a_build_says_what_it_wrote_and_where() {
    let farm = Farm::new();
    let out = farm.path("out");
    let built = orograph().args(farm.words("out", &[])).output().unwrap();
    let told = String::from_utf8(built.stderr).unwrap();
    for name in ["height.r32", "map.exr", "report.json"] {
        assert!(told.contains(&text(&out.join(name))), "{told}");
    }
    assert!(built.stdout.is_empty());
    let quiet = orograph().args(farm.words("out", &["--progress", "none"])).output().unwrap();
    assert_eq!((code(&quiet), said(&quiet)), (0, String::new()));
    let events = orograph().args(farm.words("out", &["--progress", "json"])).output().unwrap();
    for line in String::from_utf8(events.stderr).unwrap().lines() {
        assert!(serde_json::from_str::<Json>(line).unwrap()["event"].is_string(), "{line}");
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_work() {
    let farm = Farm::new();
    let expect = |more: &[&str], exit: i32, words: &str| {
        let ended = orograph().args(farm.words("out", more)).output().unwrap();
        assert_eq!(code(&ended), exit, "{more:?}: {}", said(&ended));
        assert!(said(&ended).contains(words), "{more:?}: {}", said(&ended));
        assert!(!farm.path("out/height.r32").exists(), "{more:?}");
    };
    expect(&["--report", &text(&farm.path("absent/report.json"))], 1, "cannot write the report");
    expect(&["--report", &text(farm.0.path())], 2, "is there already");
    let graph = text(&farm.path("a.graph"));
    if cfg!(target_os = "linux") {
        let ended = run(&["build", &graph, "-o", "/proc/self"]);
        assert_eq!(code(&ended), 1, "{}", said(&ended));
        assert!(said(&ended).contains("cannot write into the folder /proc/self"), "{}", said(&ended));
    }
    let drawn = run(&["render", &graph, "-o", &text(&farm.path("absent/a.png"))]);
    assert_eq!(code(&drawn), 1, "{}", said(&drawn));
}

#[cfg(unix)]
#[test]
fn read_only_results_are_not_replaced() {
    use std::os::unix::fs::PermissionsExt as _;
    let farm = Farm::new();
    farm.build("out", &[]);
    let file = farm.path("out/height.r32");
    let before = std::fs::read(&file).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o444)).unwrap();
    let refused = orograph().args(farm.words("out", &["--set", "hills.amplitude=7"])).output().unwrap();
    assert_eq!(code(&refused), 1, "{}", said(&refused));
    assert!(said(&refused).contains("read-only"), "{}", said(&refused));
    assert_eq!(std::fs::read(&file).unwrap(), before);
}

/// A build that is killed leaves its file behind; the next one in the folder clears it away at once.
#[cfg(target_os = "linux")]
#[test]
fn what_a_killed_build_left_goes_with_the_next() {
    let farm = Farm::new();
    farm.build("out", &[]);
    let mut left = 0;
    for i in 0..40 {
        let amplitude = format!("hills.amplitude={}", 100 + i);
        let words = farm.words_at(1153, "out", &["--format", "asc", "--threads", "1", "--set", &amplitude]);
        let mut child = orograph().args(words).stderr(Stdio::null()).spawn().unwrap();
        // Until it is writing: then its file is there.
        for _ in 0..4000 {
            let writes = names(&farm.path("out")).iter().any(|n| n.ends_with(".part"));
            if writes || child.try_wait().unwrap().is_some() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let _ = child.kill();
        child.wait().unwrap();
        left += names(&farm.path("out")).iter().filter(|n| n.ends_with(".part")).count();
        if left >= 3 {
            break;
        }
    }
    assert!(left >= 3, "no build was killed while it wrote");
    farm.build("out", &[]);
    let after = names(&farm.path("out"));
    assert!(after.iter().all(|n| !n.ends_with(".part")), "{after:?}");
}
