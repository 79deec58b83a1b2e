//! `plan` and `build` say the same: what is needed, whether it is allowed, why something cannot be made.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::{Value as Json, json};

fn run(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_orograph"));
    command.stdin(Stdio::null()).env("XDG_CONFIG_HOME", "/nonexistent").args(args).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or(-1)
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

struct Desk(tempfile::TempDir);

impl Desk {
    fn new(nodes: Json, outputs: Json) -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let terrain = json!({ "width": 2048, "depth": 1024, "base": 129 });
        let graph = json!({ "orograph": 1, "terrain": terrain, "nodes": nodes, "outputs": outputs });
        std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
        desk
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_string_lossy().into_owned()
    }

    fn plan(&self, args: &[&str]) -> Output {
        run(&[&["plan", &self.path("a.graph")], args].concat())
    }

    fn build(&self, args: &[&str]) -> Output {
        let out = self.path("out");
        if Path::new(&out).exists() {
            std::fs::remove_dir_all(&out).unwrap();
        }
        run(&[&["build", &self.path("a.graph"), "-o", &out], args].concat())
    }

    /// Ends both with the same code, and gives what each told.
    fn both(&self, args: &[&str], exit: i32) -> [String; 2] {
        let ended = [self.plan(args), self.build(args)];
        for one in &ended {
            assert_eq!(code(one), exit, "{args:?}: {}", told(one));
        }
        ended.map(|e| told(&e))
    }
}

fn hills() -> Json {
    json!({
        "hills": { "kind": "fractal_noise", "set": { "seed": 3 } },
        "soft": { "kind": "blur", "in": { "field": "hills.field" }, "set": { "radius": 60 } },
    })
}

fn soft() -> Json {
    json!({ "height": { "from": "soft.field", "format": "r32" } })
}

/// To the byte: what `plan` says is needed is enough for both, and a byte less for neither.
#[test]
fn plan_and_build_need_the_same_memory() {
    let desk = Desk::new(hills(), soft());
    for size in
        [vec!["--size", "257"], vec!["--size", "513", "--tile-size", "129"], vec!["--region", "0,0,500,400"]]
    {
        let json = desk.plan(&[&size[..], &["--json"]].concat());
        let plan: Json = serde_json::from_slice(&json.stdout).unwrap();
        let need = plan["need_bytes"].as_u64().unwrap();
        let [peak, reserve] = ["peak_bytes", "reserve_bytes"].map(|key| plan[key].as_u64().unwrap());
        // A tenth is the allocator's.
        assert_eq!(need, peak + peak / 10 + reserve);
        for (memory, exit) in [(need, 0), (need + 1, 0), (need - 1, 5), (1 << 20, 5), (need * 2, 0)] {
            let memory = memory.to_string();
            let [plan, build] = desk.both(&[&size[..], &["--memory", &memory]].concat(), exit);
            if exit == 5 {
                assert!(plan.contains("--memory") && build.contains("--memory"), "{plan}{build}");
            }
        }
        let report = std::fs::read(desk.path("out/report.json")).unwrap();
        let report: Json = serde_json::from_slice(&report).unwrap();
        assert_eq!([&report["planned_bytes"], &report["reserve_bytes"]], [peak, reserve]);
    }
}

/// The reason and the code are those of a build, for whatever cannot be made.
#[test]
fn plan_says_why_something_cannot_be_made_and_ends_as_build_does() {
    let cycle = json!({
        "a": { "kind": "blur", "in": { "field": "b.field" } },
        "b": { "kind": "blur", "in": { "field": "a.field" } },
    });
    let file = |name: &str| json!({ "dem": { "kind": "import_height", "set": { "file": name } } });
    let bad = json!({ "soft": { "kind": "fractal_noise", "set": { "octaves": 1000 } } });
    let cases = [
        (cycle, "a.field", 3, "cycle"),
        (file("missing.tif"), "dem.height", 4, "no such file"),
        (file("../out.tif"), "dem.height", 4, "refused"),
        (file("/etc/passwd"), "dem.height", 4, "refused"),
        (bad, "soft.field", 3, "octaves"),
        (json!({ "soft": { "kind": "blur" } }), "soft.field", 3, "must be connected"),
        (json!({ "soft": { "kind": "blurr" } }), "soft.field", 3, "blurr"),
        (hills(), "sofft.field", 3, "sofft"),
        (hills(), "soft.feeld", 3, "feeld"),
    ];
    for (nodes, from, exit, why) in cases {
        let desk = Desk::new(nodes, json!({ "height": { "from": from } }));
        for text in desk.both(&[], exit) {
            assert!(text.contains("output `height`") && text.contains(why), "{from}: {text}");
        }
        let json: Json = serde_json::from_slice(&desk.plan(&["--json"]).stdout).unwrap();
        assert_eq!(json["failures"][0]["output"], "height");
        assert_eq!(json["failures"][0]["exit"], exit);
    }
}

/// What will be written is known before anything runs, and is what the build writes.
#[test]
fn plan_and_info_say_format_and_quantity() {
    let mut nodes = hills();
    nodes["steep"] = json!({ "kind": "select_slope", "in": { "height": "hills.field" } });
    nodes["tints"] = json!({ "kind": "colorize", "in": { "field": "hills.field" } });
    let outputs = json!({
        "height": { "from": "soft.field" }, "engine": { "from": "soft.field", "target": "unity" },
        "mask": { "from": "steep.mask" }, "slope": { "from": "steep.slope" }, "color": { "from": "tints.colors" },
    });
    let desk = Desk::new(nodes, outputs);
    let said = |json: &[u8]| -> Vec<String> {
        let json: Json = serde_json::from_slice(json).unwrap();
        let text =
            |o: &Json| ["name", "format", "quantity", "unit"].map(|key| o[key].as_str().unwrap()).join(" ");
        json["outputs"].as_array().unwrap().iter().map(text).collect()
    };
    let plan = said(&desk.plan(&["--json"]).stdout);
    let wanted = [
        "height exr elevation m",
        "engine r16 elevation m",
        "mask png16 mask 1",
        "slope exr slope deg",
        "color png8 color 1",
    ];
    assert_eq!(plan, wanted);
    let info = run(&["info", &desk.path("a.graph"), "--json"]);
    assert_eq!(said(&info.stdout), wanted);
    desk.build(&["--size", "33"]);
    assert_eq!(said(&std::fs::read(desk.path("out/report.json")).unwrap()), wanted);
}

/// The outputs that can be made are planned, with the memory they need, whatever stands beside them.
#[test]
fn a_plan_holds_what_can_be_made() {
    let outputs =
        json!({ "gone": { "from": "nowhere.field" }, "height": { "from": "soft.field", "format": "r32" } });
    let desk = Desk::new(hills(), outputs);
    let plan = desk.plan(&["--json"]);
    assert_eq!(code(&plan), 3);
    let plan: Json = serde_json::from_slice(&plan.stdout).unwrap();
    assert_eq!(plan["outputs"].as_array().unwrap().len(), 1);
    assert_eq!(plan["tasks"].as_array().unwrap().len(), 2);
    desk.both(&["--memory", "1M"], 5);
}

#[test]
fn a_time_that_is_no_number_of_seconds_is_refused() {
    let desk = Desk::new(hills(), soft());
    for time in ["nan", "NaN", "inf", "-inf", "-1", "1e999", "x", ""] {
        for text in desk.both(&["--time", time], 2) {
            assert!(text.contains("--time"), "{time}: {text}");
        }
        let picture = desk.path("a.png");
        assert_eq!(
            code(&run(&["render", &desk.path("a.graph"), "-o", &picture, "--time", time])),
            2,
            "{time}"
        );
    }
    desk.both(&["--time", "0"], 5);
    desk.both(&["--time", "1e9"], 0);
}

/// A file over the budget is refused by its length and header: by `plan`, by `build`, by `render`.
#[test]
fn a_huge_file_is_refused_before_it_is_read() {
    let desk = Desk::new(
        json!({ "dem": { "kind": "import_height", "set": { "file": "huge.r32" } } }),
        json!({ "height": { "from": "dem.height", "format": "r32" } }),
    );
    std::fs::File::create(desk.path("huge.r32")).unwrap().set_len(4 * 30_000 * 30_000).unwrap();
    let start = std::time::Instant::now();
    for text in desk.both(&["--memory", "500M"], 5) {
        assert!(text.contains("node `dem`"), "{text}");
    }
    let picture = desk.path("a.png");
    let render = run(&["render", &desk.path("a.graph"), "-o", &picture, "--memory", "500M"]);
    assert_eq!(code(&render), 5, "{}", told(&render));
    assert!(start.elapsed().as_secs_f64() < 3.0, "{:?}", start.elapsed());
}

/// Each cause has its code, in what is said and in the report.
#[test]
fn the_cause_of_a_failure_is_in_the_report() {
    let desk = Desk::new(
        json!({ "dem": { "kind": "import_height", "set": { "file": "a.tif" } } }),
        json!({ "height": { "from": "dem.height", "format": "r32" } }),
    );
    std::fs::write(desk.path("a.tif"), "no picture").unwrap();
    let build = desk.build(&[]);
    assert_eq!(code(&build), 4, "{}", told(&build));
    let report: Json = serde_json::from_slice(&std::fs::read(desk.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["failures"][0]["exit"], 4);
    assert!(report["failures"][0]["error"].as_str().unwrap().contains("a.tif"));
}

#[test]
fn a_cache_that_keeps_nothing_is_in_the_report() {
    let desk = Desk::new(hills(), soft());
    let build = desk.build(&["--cache", &desk.path("cache"), "--cache-size", "1K"]);
    assert_eq!(code(&build), 0, "{}", told(&build));
    assert_eq!(told(&build).matches("does not keep all results").count(), 1, "{}", told(&build));
    let report: Json = serde_json::from_slice(&std::fs::read(desk.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["warnings"].to_string().matches("does not keep all results").count(), 1);
}
