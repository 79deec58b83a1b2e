//! Whose a sidecar is, and what it carries, as a user of the program meets it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::{Value as Json, json};

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn json(&self, name: &str) -> Json {
        serde_json::from_str(&self.text(name)).unwrap()
    }

    /// Runs the program in the folder.
    fn run(&self, args: &[&str]) -> (i32, String) {
        let output: Output = Command::new(env!("CARGO_BIN_EXE_orograph"))
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .env("XDG_CONFIG_HOME", "/nonexistent")
            .args(args)
            .output()
            .unwrap();
        let said = [output.stdout, output.stderr].map(|b| String::from_utf8_lossy(&b).into_owned()).concat();
        (output.status.code().unwrap_or(-1), said)
    }

    fn done(&self, args: &[&str]) -> String {
        let (code, said) = self.run(args);
        assert_eq!(code, 0, "{args:?}: {said}");
        said
    }

    fn info(&self, args: &[&str]) -> Json {
        serde_json::from_str(&self.done(&[&["info", "--json"], args].concat())).unwrap()
    }
}

fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/files/fixtures");
    std::fs::read(folder.join(name)).unwrap()
}

/// Integers of 16 bits, `4 + k` in a square.
fn steps(side: u16) -> Vec<u8> {
    (0..side * side).flat_map(|k| (4 + k).to_le_bytes()).collect()
}

#[test]
fn the_sidecar_of_an_input_is_never_written() {
    let desk = Desk::new();
    desk.write("turned.r16", steps(9));
    let sidecar = r#"{"cols": 9, "rows": 9, "range": [-500, 2500], "rows_from": "south"}"#;
    desk.write("turned.json", sidecar);
    let before = desk.info(&["turned.r16"]);
    for more in [&[][..], &["--overwrite"]] {
        let (code, said) =
            desk.run(&[&["convert", "turned.r16", "turned.png", "--range", "-1000,4000"], more].concat());
        assert!(code == 2 && said.contains("is the sidecar of turned.r16, an input"), "{code}: {said}");
        assert!(!desk.path("turned.png").exists(), "it is refused before any work");
        assert_eq!(desk.text("turned.json"), sidecar);
    }
    assert_eq!(desk.info(&["turned.r16"]), before);
    desk.done(&["convert", "turned.r16", "again.png", "--range", "-1000,4000"]);
    assert_eq!(desk.json("again.json")["file"], "again.png");
    // Its own is: the input is another file.
    desk.done(&["convert", "turned.r16", "again.png", "--range", "-1000,5000", "--overwrite"]);
    assert_eq!(desk.json("again.json")["range"], json!([-1000.0, 5000.0]));
}

#[test]
fn another_files_sidecar_is_neither_replaced_unasked_nor_believed() {
    let desk = Desk::new();
    desk.write("a.tif", fixture("point_f32.tif"));
    desk.done(&["convert", "a.tif", "x.r16"]);
    let before = desk.info(&["x.r16"]);
    assert_eq!((&before["metres"], &before["notes"]), (&json!(true), &json!([])));
    let (code, said) = desk.run(&["convert", "a.tif", "x.r32"]);
    assert!(code == 2 && said.contains("x.json is the sidecar of x.r16"), "{code}: {said}");
    assert!(!desk.path("x.r32").exists());
    assert_eq!(desk.info(&["x.r16"]), before);
    // Asked for, it is replaced; the other file says what it has lost.
    desk.done(&["convert", "a.tif", "x.r32", "--overwrite"]);
    assert_eq!(desk.info(&["x.r32"])["metres"], true);
    let lost = desk.info(&["x.r16", "--cols", "21"]);
    assert_eq!(lost["metres"], false);
    assert!(lost["notes"].to_string().contains("`x.json` is the sidecar of `x.r32`"), "{lost}");
    // What is no sidecar at all is somebody's as well.
    desk.write("y.json", r#"{"mine":1}"#);
    let (code, said) = desk.run(&["convert", "a.tif", "y.png"]);
    assert!(code == 2 && said.contains("y.json is there already"), "{code}: {said}");
    assert_eq!(desk.text("y.json"), r#"{"mine":1}"#);
    // A format that needs no sidecar does not mind.
    desk.done(&["convert", "a.tif", "y.asc"]);
    assert_eq!(desk.text("y.json"), r#"{"mine":1}"#);
    let (code, said) = desk.run(&["convert", "a.tif", "z.json", "--format", "r16"]);
    assert!(code == 2 && said.contains("its own sidecar"), "{code}: {said}");
}

#[test]
fn sidecars_of_older_builds_belong_to_the_format_they_name() {
    let desk = Desk::new();
    desk.write("x.r16", steps(3));
    desk.write("x.json", r#"{"orograph": 1, "format": "r16", "cols": 3, "rows": 3, "range": [0, 65535]}"#);
    assert_eq!(desk.info(&["x.r16"])["metres"], true);
    desk.write("a.tif", fixture("point_f32.tif"));
    let (code, said) = desk.run(&["convert", "a.tif", "x.exr"]);
    assert!(code == 2 && said.contains("x.json is the sidecar of x.r16"), "{code}: {said}");
    desk.write("x.json", r#"{"orograph": 1, "format": "exr", "cols": 3, "rows": 3, "cell": 7}"#);
    let other = desk.info(&["x.r16"]);
    assert!(other["notes"].to_string().contains("sidecar of `x.exr`"), "{other}");
    assert_eq!(other["cell"], Json::Null);
}

#[test]
fn a_json_that_is_no_sidecar_is_no_error() {
    let desk = Desk::new();
    desk.write("a.tif", fixture("point_f32.tif"));
    desk.done(&["convert", "a.tif", "b.png"]);
    for (other, why) in [
        (r#"{"width": 5000.0, "height": 1288.5, "format": 16, "scale": [4, 4, 1]}"#, "cannot be read"),
        (r#"{"width": 5000, "height": 1288, "scale": 4}"#, "5000 x 1288 samples, the file has 21 x 13"),
        (r#"{"frames": []}"#, "says nothing of heights"),
        ("[1, 2]", "holds no object"),
        ("{ half of it", "cannot be read"),
        ("", "cannot be read"),
    ] {
        for name in ["b.png", "a.tif"] {
            let json = name.replace("png", "json").replace("tif", "json");
            desk.write(&json, other);
            let info = desk.info(&[name]);
            assert_eq!(info["metres"], name == "a.tif", "{other}");
            let notes = info["notes"].to_string();
            assert!(name == "a.tif" || notes.contains(why), "{other}: {notes}");
        }
    }
    // One that says it is ours and is broken is an error: metres would be lost unseen.
    desk.write("b.json", r#"{"orograph": 1, "format": "png16", "range": [9, 1]}"#);
    let (code, said) = desk.run(&["info", "b.png"]);
    assert!(code == 4 && said.contains("must go upwards"), "{code}: {said}");
    desk.write("b.json", "\u{feff}{\"range\": [0, 65535]}");
    assert_eq!(desk.info(&["b.png"])["metres"], true, "a byte order mark is passed over");
}

#[test]
fn a_build_in_another_format_does_not_take_the_sidecar_of_the_first() {
    let desk = Desk::new();
    let graph = json!({
        "orograph": 1, "terrain": { "width": 1000, "depth": 500, "base": 33 },
        "nodes": { "hills": { "kind": "fractal_noise" } },
        "outputs": { "h": { "from": "hills.field", "format": "r16", "range": [-500, 500] } },
    });
    desk.write("g.graph", graph.to_string());
    desk.done(&["build", "g.graph", "-o", "out"]);
    let before = desk.info(&["out/h.r16"]);
    desk.done(&["build", "g.graph", "-o", "out", "--size", "65"]);
    desk.done(&["build", "g.graph", "-o", "out"]);
    let (code, said) = desk.run(&["build", "g.graph", "-o", "out", "--format", "r32"]);
    assert!(code == 2 && said.contains("is the sidecar of h.r16"), "{code}: {said}");
    assert!(!desk.path("out/h.r32").exists());
    assert_eq!(desk.info(&["out/h.r16"]), before);
    desk.done(&["build", "g.graph", "-o", "out", "--format", "r32", "--overwrite"]);
    assert_eq!(desk.json("out/h.json")["file"], "h.r32");
    assert!(desk.info(&["out/h.r16", "--cols", "33"])["notes"].to_string().contains("sidecar of `h.r32`"));
    // Where the other file is gone its sidecar stands in nobody's way.
    std::fs::remove_file(desk.path("out/h.r32")).unwrap();
    std::fs::remove_file(desk.path("out/h.r16")).unwrap();
    desk.done(&["build", "g.graph", "-o", "out", "--format", "exr"]);
}

#[test]
fn a_picture_is_not_drawn_over_heights_unasked() {
    let desk = Desk::new();
    desk.write("a.tif", fixture("point_f32.tif"));
    desk.done(&["convert", "a.tif", "h.png"]);
    let before = std::fs::read(desk.path("h.png")).unwrap();
    let (code, said) = desk.run(&["render", "a.tif", "-o", "h.png"]);
    assert!(code == 2 && said.contains("h.png holds heights"), "{code}: {said}");
    assert_eq!(std::fs::read(desk.path("h.png")).unwrap(), before);
    desk.done(&["render", "a.tif", "-o", "h.png", "--overwrite"]);
    desk.done(&["render", "a.tif", "-o", "map.png"]);
    desk.done(&["render", "a.tif", "-o", "map.png"]);
    // A picture beside the sidecar of another file is no height file.
    desk.done(&["convert", "a.tif", "x.r16"]);
    desk.done(&["render", "a.tif", "-o", "x.png"]);
    desk.done(&["render", "a.tif", "-o", "x.png"]);
    assert_eq!(desk.info(&["x.r16"])["metres"], true);
}

/// The cell and extent that every format with a place must keep.
#[test]
fn cells_that_are_not_square_are_kept_by_every_format() {
    let desk = Desk::new();
    desk.write("d.tif", fixture("degrees_f32.tif"));
    let first = desk.info(&["d.tif"]);
    let numbers = |info: &Json, key: &str| -> Vec<f64> {
        let list = info[key].as_array().unwrap_or_else(|| panic!("no {key} in {info}"));
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let cell = numbers(&first, "cell");
    assert!((cell[0] / cell[1] - 1.0).abs() > 0.2, "{cell:?}");
    for extension in ["png", "r16", "r32", "exr", "asc", "tif"] {
        let name = format!("to_{extension}.{extension}");
        desk.done(&["convert", "d.tif", &name]);
        // And back through a file that knows no place but its own.
        let back = format!("back_{extension}.tif");
        desk.done(&["convert", &name, &back]);
        for name in [&name, &back] {
            let info = desk.info(&[name]);
            for key in ["cell", "extent"] {
                for (found, want) in numbers(&info, key).iter().zip(numbers(&first, key)) {
                    assert!((found / want - 1.0).abs() < 1e-9, "{name}: {key} {found}, not {want}");
                }
            }
        }
    }
}

#[test]
fn a_file_of_oblong_cells_is_drawn_in_proportion() {
    let desk = Desk::new();
    desk.write("d.tif", fixture("degrees_f32.tif"));
    let extent = desk.info(&["d.tif"])["extent"].clone();
    let ratio = extent[1].as_f64().unwrap() / extent[0].as_f64().unwrap();
    desk.done(&["render", "d.tif", "-o", "map.png", "--width", "320"]);
    let picture = std::fs::File::open(desk.path("map.png")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(picture)).read_info().unwrap();
    let (width, height) = (reader.info().width, reader.info().height);
    assert_eq!((width, height), (320, (320.0 * ratio).round() as u32), "{ratio}");
    desk.write("long.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 1\ndy 5000\n1 2\n3 4\n");
    let (code, said) = desk.run(&["render", "long.asc", "-o", "long.png"]);
    assert!(code == 2 && said.contains("5000"), "{code}: {said}");
}

#[test]
fn voids_byte_order_and_size_can_be_said() {
    let desk = Desk::new();
    desk.write(
        "u.asc",
        "ncols 3\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ncellsize 10\n100 110 120\n130 -9999 150",
    );
    let plain = desk.info(&["u.asc"]);
    assert_eq!((&plain["voids"], &plain["range"]), (&json!(0), &json!([-9999.0, 150.0])));
    assert!(plain["notes"].to_string().contains("nodata"), "{plain}");
    let said = desk.info(&["u.asc", "--nodata", "-9999"]);
    assert_eq!((&said["voids"], &said["range"]), (&json!(1), &json!([100.0, 150.0])));
    desk.done(&["convert", "u.asc", "v.tif", "--nodata", "-9999"]);
    assert_eq!(desk.info(&["v.tif"])["voids"], 1);
    desk.done(&["render", "u.asc", "-o", "u.png", "--nodata", "-9999"]);
    let slope = |k: u16| (k % 33) * 400 + (k / 33) * 800;
    desk.write("big.raw", (0..33u16 * 33).flat_map(|k| slope(k).to_be_bytes()).collect::<Vec<_>>());
    let wrong = desk.info(&["big.raw"]);
    assert!(wrong["notes"].to_string().contains("`byte_order` big"), "{wrong}");
    let right = desk.info(&["big.raw", "--byte-order", "big"]);
    assert_eq!((&right["range"], &right["notes"]), (&json!([0.0, 38400.0]), &json!([])));
    desk.write("big.json", r#"{"file": "big.raw", "byte_order": "big", "range": [0, 65535]}"#);
    assert_eq!(desk.info(&["big.raw"])["range"], json!([0.0, 38400.0]));
    // Another width, another type, by a person's word.
    desk.write("w.raw", (0..6i16).flat_map(|k| (k * 100 - 300).to_le_bytes()).collect::<Vec<_>>());
    let (code, text) = desk.run(&["info", "w.raw"]);
    assert!(code == 4 && text.contains("`cols`"), "{code}: {text}");
    let sized = desk.info(&["w.raw", "--cols", "3", "--sample", "i16"]);
    assert_eq!(
        (&sized["cols"], &sized["rows"], &sized["range"]),
        (&json!(3), &json!(2), &json!([-300.0, 200.0]))
    );
    let (code, text) = desk.run(&["info", "w.raw", "--cols", "4"]);
    assert!(code == 4 && text.contains("no whole number of rows of 4"), "{code}: {text}");
    let (code, text) = desk.run(&["info", "u.asc", "--sample", "q8"]);
    assert!(code == 2 && text.contains("one of u8, u16"), "{code}: {text}");
}

#[test]
fn an_import_takes_what_is_said_of_its_file() {
    let desk = Desk::new();
    desk.write("big.raw", (0..33u16 * 33).flat_map(|k| (k % 33 * 400).to_be_bytes()).collect::<Vec<_>>());
    desk.write("u.asc", "ncols 3\nnrows 2\ncellsize 10\n100 110 120\n130 -9999 150");
    let graph = |set: &Json| {
        json!({
            "orograph": 1, "terrain": { "width": 320, "depth": 320, "base": 33 },
            "nodes": { "dem": { "kind": "import_height", "set": set } },
            "outputs": { "h": { "from": "dem.height", "format": "r32" }, "v": { "from": "dem.voids", "format": "r32" } },
        })
        .to_string()
    };
    let range = |name: &str| desk.info(&[name])["range"].clone();
    desk.write("b.graph", graph(&json!({ "file": "big.raw", "byte_order": "big" })));
    desk.done(&["build", "b.graph", "-o", "b"]);
    assert_eq!(range("b/h.r32"), json!([0.0, 12800.0]));
    desk.write("n.graph", graph(&json!({ "file": "u.asc", "nodata": -9999, "interpolation": "linear" })));
    desk.done(&["build", "n.graph", "-o", "n"]);
    assert_eq!((range("n/h.r32"), range("n/v.r32")), (json!([100.0, 150.0]), json!([0.0, 1.0])));
    // Without it the reader's suspicion reaches the report.
    desk.write("n.graph", graph(&json!({ "file": "u.asc" })));
    let said = desk.done(&["build", "n.graph", "-o", "n"]);
    assert!(said.contains("warning: node `dem`") && said.contains("nodata"), "{said}");
    assert!(desk.json("n/report.json")["warnings"].to_string().contains("-9999"));
}

/// What `info` advises and what `fit` sets are the same, and the build fits to the last sample.
#[test]
fn fit_makes_a_terrain_that_the_file_fits() {
    let desk = Desk::new();
    let rows: Vec<String> = (0..17)
        .map(|j| (0..33).map(|i| (i * 31 + j * 17).to_string()).collect::<Vec<_>>().join(" "))
        .collect();
    desk.write(
        "dem.asc",
        format!("ncols 33\nnrows 17\nxllcenter 0\nyllcenter 0\ncellsize 30\n{}\n", rows.join("\n")),
    );
    let graph = json!({
        "orograph": 1, "terrain": { "width": 2000, "depth": 2000, "base": 33 },
        "expose": { "file": { "bind": ["dem.file"], "value": "" }, "width": { "bind": ["terrain.width"], "value": 2000 } },
        "nodes": { "dem": { "kind": "import_height" } },
        "outputs": { "h": { "from": "dem.height", "format": "r32" } },
    });
    desk.write("g.graph", graph.to_string());
    desk.write("stretched.graph", graph.to_string());
    let said = desk.done(&["build", "stretched.graph", "-o", "s", "--set", "file=dem.asc"]);
    assert!(said.contains("stretched 2.00 times as much to the south"), "{said}");
    let before = desk.text("g.graph");
    let dry = desk.done(&["fit", "g.graph", "dem.asc", "--dry-run"]);
    assert_eq!(desk.text("g.graph"), before);
    for line in ["width = 960", "terrain.depth = 480", "file = \"dem.asc\""] {
        assert!(dry.contains(line), "{line} in {dry}");
    }
    assert_eq!(desk.done(&["fit", "g.graph", "dem.asc"]), dry);
    assert!(desk.done(&["fit", "g.graph", "dem.asc"]).contains("fits already"));
    let said = desk.done(&["build", "g.graph", "-o", "out"]);
    assert!(!said.contains("stretched"), "{said}");
    let heights = std::fs::read(desk.path("out/h.r32")).unwrap();
    let heights: Vec<f32> = heights.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(heights.len(), 33 * 17);
    for (k, h) in heights.iter().enumerate() {
        assert_eq!(*h, (k % 33 * 31 + k / 33 * 17) as f32);
    }
    // The advice of `info` is what any graph takes.
    let advice = desk.done(&["info", "dem.asc"]);
    let advice = advice.lines().find(|l| l.contains("--set terrain.width")).expect("advice").to_owned();
    let words: Vec<&str> = advice.split_whitespace().skip(1).collect();
    let mut plain = graph.clone();
    plain["expose"] = json!({});
    plain["nodes"]["dem"]["set"] = json!({ "file": "dem.asc" });
    desk.write("plain.graph", plain.to_string());
    let said = desk.done(&[&["build", "plain.graph", "-o", "p", "--output", "h"], &words[..]].concat());
    assert!(!said.contains("stretched"), "{said}");
    // Where nothing near divides both sides, less than a base cell is cropped and the file stays in its proportions.
    desk.write(
        "odd.asc",
        "ncols 3\nnrows 3\nxllcenter 0\nyllcenter 0\ndx 100\ndy 70.77\n0 100 200\n0 100 200\n0 100 200\n",
    );
    desk.write("odd.graph", graph.to_string());
    let said = desk.done(&["fit", "odd.graph", "odd.asc"]);
    assert!(said.contains("are cropped, less than a base cell"), "{said}");
    let said = desk.done(&["build", "odd.graph", "-o", "odd"]);
    assert!(!said.contains("stretched"), "{said}");
    let range = desk.info(&["odd/h.r32"])["range"].clone();
    assert!(range[0] == 0.0 && (range[1].as_f64().unwrap() - 200.0).abs() < 0.001, "{range}");
    // Another graph is written, and not over one that is there.
    desk.done(&["fit", "stretched.graph", "dem.asc", "-o", "new.graph"]);
    assert_eq!(desk.run(&["fit", "stretched.graph", "dem.asc", "-o", "new.graph"]).0, 2);
    assert_eq!(desk.json("new.graph")["terrain"]["depth"], 480);
    assert_eq!(desk.run(&["fit", "g.graph", "dem.asc", "--node", "nobody"]).0, 2);
}
