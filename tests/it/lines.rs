//! Lines as outputs of a graph: what is written, and that it comes back.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use orograph::engine::{Engine, Files, Options, Unobserved, Want};
use orograph::files::vectors::{Imported, Mapping, geojson, svg};
use orograph::files::{Format, WriteError, WriteJob, encode};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::nodes::Registry;
use orograph::value::rivers::RiverVertex;
use orograph::value::rivers::written::{WrittenRiver, network};
use orograph::value::{Curves, Field, Geo, Grid, Quantity, Rivers, Terrain, Value};
use serde_json::{Value as Json, json};

use super::cli::{code, run, said, text};

/// A ridge whose height and slopes change along it, and a path of one height.
fn curves() -> Curves {
    let specs = json!([
        {
            "name": "ridge & <spur>", "through": [100.5, 200.0, 700.25, 300.0, 1500.0, 1100.0],
            "height": [0, 400, 20, 0.5, 650, 20, 1, 300, 20],
            "slope": [0, 200, 300, -30, -20, 1, 200, 500, -30, -40],
        },
        { "line": [0, 1000, 1200, 1000], "height": [0, 50, 0] },
    ]);
    Curves::from_specs(&serde_json::from_value::<Vec<_>>(specs).unwrap()).unwrap()
}

fn terrain(geo: bool) -> Terrain {
    let origin = [-250.0, 125.0];
    let geo = geo.then_some(Geo { epsg: 32632, east: 500_000.0, north: 5_200_000.0 });
    Terrain { origin, width: 2000.0, depth: 1500.0, geo, ..Terrain::default() }
}

fn written(value: &Value, format: Format, terrain: &Terrain) -> Result<Vec<u8>, WriteError> {
    let mut out = Cursor::new(Vec::new());
    encode(&WriteJob::new(value, format, terrain, terrain.base_grid()), &mut out)?;
    Ok(out.into_inner())
}

/// All values of a file of the program's own, by their own names.
fn own() -> Mapping {
    let property = |name: &str| json!({ "property": { "name": name } });
    let mut mapping = serde_json::Map::new();
    for name in ["radius", "left_extent", "right_extent", "left_angle", "right_angle"] {
        mapping.insert(name.to_owned(), property(name));
    }
    mapping.insert("height".to_owned(), json!({ "z": {} }));
    serde_json::from_value(Json::Object(mapping)).unwrap()
}

/// The farthest that points along one set of curves lie from those of another, in the plane and in height.
fn apart(a: &Curves, b: &Curves) -> [f64; 2] {
    assert_eq!(a.len(), b.len());
    let mut most = [0.0_f64; 2];
    for (a, b) in a.iter().zip(b.iter()) {
        for ((p, h), (q, k)) in a.sketch().into_iter().zip(points(b, a.sketch().len())) {
            most[0] = most[0].max(libm::hypot(p[0] - q[0], p[1] - q[1]));
            most[1] = most[1].max((h.unwrap() - k.unwrap()).abs());
        }
    }
    most
}

/// The ends of the pieces of a curve that was read: the positions of the file.
fn points(curve: &orograph::value::Curve, count: usize) -> Vec<([f64; 2], Option<f64>)> {
    assert_eq!(curve.pieces() + 1, count, "a piece from each position to the next");
    let length = curve.length();
    let end = |i: usize| (curve.piece(i).at(1.0), curve.height(curve.piece_span(i)[1] / length));
    std::iter::once((curve.piece(0).at(0.0), curve.height(0.0))).chain((0..curve.pieces()).map(end)).collect()
}

fn read_geojson(bytes: &[u8], terrain: &Terrain) -> Imported {
    let place = geojson::Place { smooth: false, ..geojson::Place::on(terrain) };
    geojson::read(bytes, &place, &own(), &|_| true).unwrap()
}

#[test]
fn geojson_of_curves_comes_back_where_it_was() {
    for geo in [false, true] {
        let terrain = terrain(geo);
        let bytes = written(&curves().into(), Format::Geojson, &terrain).unwrap();
        let read = read_geojson(&bytes, &terrain);
        assert_eq!(read.warnings, Vec::<String>::new());
        let [plan, height] = apart(&curves(), &read.curves);
        assert!(plan < 1e-8 && height < 0.02, "{plan} m in the plane, {height} m in height");
        let names = |c: &Curves| c.iter().map(|c| c.name().to_owned()).collect::<Vec<_>>();
        assert_eq!(names(&curves()), names(&read.curves));
        let [slope, back] = [&curves(), &read.curves].map(|c| c.iter().next().unwrap().tracks().clone());
        let [slope, back] = [slope, back].map(|t| t.slope.unwrap().at(0.25));
        let off = slope.iter().zip(back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{slope:?} came back as {back:?}");
        let json: Json = serde_json::from_slice(&bytes).unwrap();
        let crs = json["crs"]["properties"]["name"].as_str();
        assert_eq!(crs, geo.then_some("urn:ogc:def:crs:EPSG::32632"), "GIS must know where it lies");
        let first = &json["features"][0]["geometry"]["coordinates"][0];
        let first: [f64; 3] = serde_json::from_value(first.clone()).unwrap();
        let [east, north] = if geo { [500_000.0, 5_200_000.0] } else { [0.0, 0.0] };
        assert_eq!(first, [east + 350.5, north - 75.0, 400.0]);
    }
}

#[test]
fn svg_of_curves_comes_back_where_it_was() {
    let terrain = terrain(false);
    let bytes = written(&curves().into(), Format::Svg, &terrain).unwrap();
    let mapping = serde_json::from_value(json!({ "height": { "property": { "name": "height" } } })).unwrap();

    let read = svg::read(&bytes, terrain.bounds(), svg::Fit::default(), &mapping, &|_| true).unwrap();
    assert_eq!(read.warnings, Vec::<String>::new());
    let [plan, height] = apart(&curves(), &read.curves);
    // Heights of a picture are a list spread evenly, where the curve itself has a cubic.
    assert!(plan < 1e-6 && height < 60.0, "{plan} m in the plane, {height} m in height");
}

#[test]
fn formats_hold_lines_or_samples() {
    let terrain = terrain(false);
    let grid = Grid::between(terrain.base_lattice(), [0, 0], [3, 3]);
    let field = Value::Field(Field::constant(grid, Quantity::Elevation, 1.0));
    for format in Format::ALL {
        assert_eq!(written(&curves().into(), format, &terrain).is_ok(), format.holds_lines(), "{format}");
        assert_eq!(format.takes_wire(field.wire_type()), !format.holds_lines(), "{format}");
    }
    let error = written(&field, Format::Geojson, &terrain).unwrap_err().to_string();
    assert!(error.starts_with("geojson cannot hold samples on a grid; png8, png16, "), "{error}");
    let error = written(&curves().into(), Format::Exr, &terrain).unwrap_err().to_string();
    assert_eq!(error, "exr cannot hold curves; geojson and svg can");
    let none: Value = Curves::default().into();
    let empty = written(&none, Format::Geojson, &terrain).unwrap();
    assert_eq!(serde_json::from_slice::<Json>(&empty).unwrap()["features"], json!([]));
}

/// Two rivers, one of them with a tributary, at places that binary fractions miss.
fn rivers() -> Rivers {
    let vertex = |x: f64, y: f64, down: Option<u32>, area: f32| RiverVertex {
        at: [x, y],
        height: y / 7.0,
        down,
        area,
        width: area.sqrt() / 3.0,
        ..RiverVertex::default()
    };
    Rivers::new(vec![
        vertex(100.1, 130.0, None, 900.3),
        vertex(200.2, 150.0, Some(0), 700.7),
        vertex(300.3, 170.0, Some(1), 400.1),
        vertex(250.0, 290.0, Some(1), 100.9),
        vertex(900.0, 900.9, None, 50.0),
        vertex(910.0, 950.9, Some(4), 20.0),
    ])
    .unwrap()
}

/// A graph that reads a file of rivers, and the network that it reads.
fn imported(folder: &Path, file: &str, set: &Json) -> (Rivers, Vec<String>) {
    let mut all = json!({ "file": file });
    all.as_object_mut().unwrap().extend(set.as_object().unwrap().clone());
    let graph = json!({
        "orograph": 1, "terrain": { "origin": [-250, 125], "width": 2000, "depth": 1500, "base": 65 },
        "nodes": { "rivers": { "kind": "import_rivers", "set": all } },
    });
    let graph = Graph::from_bytes(graph.to_string().as_bytes(), &Registry::standard()).unwrap();
    let mut files = Files::default();
    files.allow_folder(folder).unwrap();
    let engine = Engine::new(&Options::default(), files).unwrap();
    let want = Want {
        node: graph.find("rivers").unwrap(),
        port: "rivers".into(),
        grid: graph.terrain().base_grid(),
    };
    let done = engine.evaluate(&graph, &[want], &Unobserved, &Cancel::default()).unwrap();
    let value = done.values[0].as_ref().unwrap();
    let notices = done.notices.iter().map(ToString::to_string).collect();
    (value.object::<Rivers>().unwrap().clone(), notices)
}

#[test]
fn rivers_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let terrain = terrain(false);
    for format in [Format::Geojson, Format::Svg] {
        let file = format!("rivers.{}", format.extension());
        std::fs::write(folder.path().join(&file), written(&rivers().into(), format, &terrain).unwrap())
            .unwrap();
        let (back, notices) = imported(folder.path(), &file, &json!({}));
        assert_eq!(notices, Vec::<String>::new());
        let level = |rivers: &Rivers| -> Vec<_> {
            rivers.vertices().iter().map(|v| RiverVertex { height: 0.0, ..*v }).collect()
        };
        match format {
            // The corner of the terrain is taken off and put on again, which rounds places.
            Format::Geojson => {
                for (a, b) in back.vertices().iter().zip(rivers().vertices()) {
                    assert!(libm::hypot(a.at[0] - b.at[0], a.at[1] - b.at[1]) < 1e-9);
                    let at = b.at;
                    assert_eq!(RiverVertex { at, length: 0.0, ..*a }, RiverVertex { length: 0.0, ..*b });
                }
            }
            // The page is laid in the middle of the terrain, which rounds places.
            _ => {
                let pairs = level(&back).into_iter().zip(level(&rivers()));
                for (a, b) in pairs {
                    assert!(libm::hypot(a.at[0] - b.at[0], a.at[1] - b.at[1]) < 1e-6);
                    assert_eq!((a.down, a.area, a.width, a.order), (b.down, b.area, b.width, b.order));
                }
            }
        }
    }
}

#[test]
fn lines_without_any_property_are_rivers_that_join() {
    let folder = tempfile::tempdir().unwrap();
    let line = |points: Json, properties: Json| json!({ "type": "Feature", "properties": properties, "geometry": { "type": "LineString", "coordinates": points } });
    // East and north of the corner at -250, 125; a text where a number would be is no fault.
    let file = json!({ "type": "FeatureCollection", "features": [
        line(json!([[500, -100, 90], [500, -600, 40], [500, -1100, 10]]), json!({ "width": "wide" })),
        line(json!([[900, -300, 80], [510, -600, 60]]), json!({})),
        line(json!([[1500, -100], [1500, -700]]), json!({})),
    ]});
    std::fs::write(folder.path().join("a.geojson"), file.to_string()).unwrap();
    let (rivers, _) = imported(folder.path(), "a.geojson", &json!({ "snap": 20 }));
    assert_eq!(rivers.outlets().count(), 2, "{rivers:?}");
    let mouth = rivers.vertices().iter().find(|v| v.at == [250.0, 1225.0]).expect("the mouth of the first");
    assert_eq!((mouth.down, mouth.order, mouth.height), (None, 2, 10.0));
    let all: f64 = rivers.outlets().map(|i| f64::from(rivers.vertices()[i].area)).sum();
    assert!((all - 2000.0 * 1500.0).abs() < 10.0, "outlets drain the terrain: {all}");
    let (apart, _) = imported(folder.path(), "a.geojson", &json!({ "snap": 5 }));
    assert_eq!(apart.outlets().count(), 3);
    let (turned, _) = imported(folder.path(), "a.geojson", &json!({ "direction": "upstream", "snap": 20 }));
    assert!(turned.outlets().any(|i| turned.vertices()[i].at == [250.0, 225.0]), "{turned:?}");
}

#[test]
fn a_changed_file_of_rivers_is_read_as_lines() {
    let river = |numbers: &'static [f64]| WrittenRiver {
        at: vec![[0.0, 0.0], [1.0, 1.0]],
        numbers,
        areas: &[1.0, 2.0],
        widths: &[1.0, 2.0],
        ..WrittenRiver::default()
    };
    assert!(network([river(&[1.0, 0.0])]).is_some());
    for numbers in
        [&[0.0, 1.0][..], &[2.0, 0.0], &[1.0], &[1.5, 0.0], &[-1.0, 0.0], &[1e18, 0.0], &[f64::NAN, 0.0]]
    {
        assert!(network([river(numbers)]).is_none(), "{numbers:?}");
    }
    assert!(network([]).is_none());
}

struct Desk(tempfile::TempDir);

impl Desk {
    fn new(outputs: &Json) -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let lines = json!([{ "line": [100, 100, 900, 700], "height": [0, 100, 0] }]);
        let graph = json!({
            "orograph": 1, "terrain": { "width": 1000, "depth": 1000, "base": 65 },
            "nodes": {
                "lines": { "kind": "feature_curves", "set": { "curves": lines } },
                "marks": { "kind": "curve_raster", "in": { "curves": "lines.curves" } },
                "hills": { "kind": "fractal_noise", "set": { "seed": 3 } },
            },
            "outputs": outputs,
        });
        std::fs::write(desk.path("a.graph"), graph.to_string()).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, words: &[&str]) -> (i32, String) {
        let graph = text(&self.path("a.graph"));
        let words: Vec<&str> = [words[0], &graph].into_iter().chain(words[1..].iter().copied()).collect();
        let output = run(&words);
        (code(&output), said(&output))
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_build_of_tiles_writes_lines_once() {
    let desk = Desk::new(&json!({
        "rivers": { "from": "lines.curves" }, "height": { "from": "hills.field" },
    }));
    let out = text(&desk.path("out"));
    let (code, said) = desk.run(&["build", "-o", &out, "--size", "65", "--tiles", "2x2", "--format", "r32"]);
    assert_eq!(code, 0, "{said}");
    let rasters = ["0_y0", "0_y1", "1_y0", "1_y1"];
    let rasters = rasters.iter().flat_map(|t| ["json", "r32"].map(|e| format!("height_x{t}.{e}")));
    let mut expected: Vec<String> =
        rasters.chain(["report.json", "rivers.geojson"].map(String::from)).collect();
    expected.sort();
    let mut found = names(Path::new(&out));
    found.retain(|name| !name.starts_with('.'));
    assert_eq!(found, expected, "a format of samples leaves lines their own");
    let report: Json = serde_json::from_slice(&std::fs::read(desk.path("out/report.json")).unwrap()).unwrap();
    let entries = report["outputs"].as_array().unwrap();
    let lines: Vec<_> = entries.iter().filter(|o| o["name"] == "rivers").collect();
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0]["cols"], Json::Null);
    assert_eq!(lines[0]["tile"], Json::Null);
    assert!(lines[0]["sha256"].is_string());
    // Another tile by itself leaves the lines to the first.
    let (code, said) =
        desk.run(&["build", "-o", &text(&desk.path("part")), "--tiles", "2x2", "--tile", "1,1"]);
    assert_eq!(code, 0, "{said}");
    assert!(!desk.path("part/rivers.geojson").exists());
}

#[test]
fn lines_and_samples_are_told_apart_before_a_build() {
    let desk = Desk::new(&json!({
        "a": { "from": "lines.curves", "format": "exr" }, "b": { "from": "hills.field", "format": "svg" },
        "c": { "from": "marks.constraints" }, "d": { "from": "lines.curves", "format": "svg" },
    }));
    let (code, said) = desk.run(&["check"]);
    assert_eq!(code, 3, "{said}");
    for line in [
        "output `a`: `format` exr holds samples on a grid, `lines.curves` is curves",
        "output `b`: `format` svg holds lines, `hills.field` is field",
        "output `c`: `from` must be a field, vectors, colours or lines, `marks.constraints` is constraints",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    let out = text(&desk.path("out"));
    let (_, said) = desk.run(&["build", "-o", &out, "--output", "d"]);
    assert!(desk.path("out/d.svg").exists(), "{said}");
    let (_, info) = desk.run(&["info"]);
    assert!(info.contains("output   d from lines.curves: svg, curves"), "{info}");
    let (_, plan) = desk.run(&["plan", "--output", "d"]);
    assert!(plan.contains("output d: svg, curves"), "{plan}");
}
