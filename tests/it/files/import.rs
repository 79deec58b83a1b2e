//! `import_height`: where a file goes on the terrain, what runs between its samples, what becomes of its voids.

use std::sync::Arc;

use orograph::files::{Format, HeightFile, Limits, Writing, encode_file, read_height};
use orograph::kit::hash;
use orograph::node::{Cancel, Context, Error, Node, SourceFile};
use orograph::nodes::files::import_height::{Fill, ImportHeight, Inputs, Interpolation, Outputs, Placing};
use orograph::units::{Degrees, FilePath, Metres, Number};
use orograph::value::{Field, Geo, Grid, Terrain, Value};
use orograph::work::Work;

use super::{heights, job, write};

fn source(name: &str, bytes: Vec<u8>) -> Arc<SourceFile> {
    Arc::new(SourceFile::new(name.into(), bytes))
}

/// A GeoTIFF with a cell of 10 m.
fn tiff(cols: usize, rows: usize, f: impl Fn(usize, usize) -> f32) -> Arc<SourceFile> {
    let value = heights(cols, rows, |k| f(k % cols, k / cols));
    source("a.tif", write(&job(&value, Format::Tiff, &Terrain::default())).0)
}

fn node(placement: Placing) -> ImportHeight {
    ImportHeight { file: FilePath("a.tif".into()), placement, ..ImportHeight::default() }
}

fn run(
    node: &ImportHeight,
    files: &[Arc<SourceFile>],
    terrain: &Terrain,
    grid: Grid,
) -> Result<Outputs, Error> {
    let cancel = Cancel::default();
    node.run(&Context { files, ..Context::bare(grid, terrain, &cancel) }, Inputs {})
}

fn square(side: f64) -> Terrain {
    Terrain { width: side, depth: side, ..Terrain::default() }
}

fn rough(i: usize, j: usize) -> f32 {
    (hash::unit(3, (i * 1000 + j) as u64) * 900.0) as f32
}

#[test]
fn samples_that_coincide_are_the_file_to_the_bit() {
    let files = [tiff(33, 33, rough)];
    let terrain = square(777.0);
    let same = run(&node(Placing::Stretch), &files, &terrain, terrain.grid(33).expect("fits")).expect("runs");
    for (k, v) in same.height.data().iter().enumerate() {
        assert_eq!(v.to_bits(), rough(k % 33, k / 33).to_bits());
    }
    for size in [65, 97, 129] {
        let fine =
            run(&node(Placing::Stretch), &files, &terrain, terrain.grid(size).expect("fits")).expect("runs");
        let step = i64::from(size - 1) / 32;
        for k in 0..33 * 33i64 {
            let (i, j) = (k % 33, k / 33);
            assert_eq!(fine.height.at(i * step, j * step), rough(i as usize, j as usize), "size {size}");
        }
    }
}

#[test]
fn a_window_is_the_crop_of_the_whole() {
    let files = [tiff(41, 29, rough)];
    let terrain = Terrain { width: 900.0, depth: 600.0, origin: [50.0, -70.0], ..Terrain::default() };
    let turned = Placing::TrueSize { x: Metres(31.0), y: Metres(-17.5), rotation: Degrees(33.0) };
    for placement in [Placing::Stretch, turned] {
        for interpolation in [Interpolation::Cubic, Interpolation::Linear] {
            let node = ImportHeight { interpolation, ..node(placement) };
            let whole = terrain.grid(181).expect("fits").grow_cells(20);
            let big = run(&node, &files, &terrain, whole).expect("runs");
            for corner in [[-20, -20], [0, 0], [57, 93], [150, 100]] {
                let window = Grid::between(whole.lattice, corner, [corner[0] + 23, corner[1] + 17]);
                let small = run(&node, &files, &terrain, window).expect("runs");
                let same = |a: &Field, b: &Field| {
                    a.data().iter().map(|v| v.to_bits()).eq(b
                        .crop(&window)
                        .data()
                        .iter()
                        .map(|v| v.to_bits()))
                };
                assert!(same(&small.height, &big.height), "{placement:?} {interpolation:?} at {corner:?}");
                assert!(same(&small.inside, &big.inside));
            }
        }
    }
}

/// A plane comes through spline and planes alike, so every placement has a closed form.
#[test]
fn true_size_turns_about_the_middle() {
    let (cols, rows) = (31, 21);
    let files = [tiff(cols, rows, |i, j| 500.0 + 3.0 * i as f32 - 2.0 * j as f32)];
    let terrain = square(1000.0);
    let grid = terrain.grid(101).expect("fits");
    for (angle, dx, dy) in [(0.0, 0.0, 0.0), (0.0, 120.0, -80.0), (90.0, 5.0, 9.0), (-37.0, -60.0, 44.0)] {
        let placing = Placing::TrueSize { x: Metres(dx), y: Metres(dy), rotation: Degrees(angle) };
        for interpolation in [Interpolation::Cubic, Interpolation::Linear] {
            let out =
                run(&ImportHeight { interpolation, ..node(placing) }, &files, &terrain, grid).expect("runs");
            let mut inside = 0;
            for k in 0..grid.len() {
                let (x, y) = (grid.x(k % 101) - 500.0 - dx, grid.y(k / 101) - 500.0 - dy);
                // Turned clockwise by `angle` seen from above, with y to the south: back by the same.
                let (sin, cos) = libm::sincos(angle.to_radians());
                let (u, v) = (x * cos + y * sin, -x * sin + y * cos);
                let (i, j) = (u / 10.0 + 15.0, v / 10.0 + 10.0);
                let (ci, cj) = (i.clamp(0.0, 30.0), j.clamp(0.0, 20.0));
                let want = 500.0 + 3.0 * ci - 2.0 * cj;
                let got = f64::from(out.height.data()[k]);
                assert!((got - want).abs() < 1e-3, "{angle} degrees at ({x}, {y}): {got}, not {want}");
                let edge = [i, 30.0 - i, j, 20.0 - j].into_iter().fold(f64::MAX, f64::min);
                if edge.abs() > 1e-4 {
                    assert_eq!(out.inside.data()[k], if edge > 0.0 { 1.0 } else { 0.0 });
                }
                inside += usize::from(edge > 0.0);
            }
            assert!(inside > 300, "the file lies on the terrain");
        }
    }
}

#[test]
fn a_cell_of_ones_own_changes_the_size() {
    let files = [tiff(11, 11, |i, _| i as f32)];
    let terrain = square(1000.0);
    let placing = Placing::TrueSize { x: Metres(0.0), y: Metres(0.0), rotation: Degrees(0.0) };
    let node = ImportHeight { cell: Some(Metres(50.0)), ..node(placing) };
    let out = run(&node, &files, &terrain, terrain.grid(21).expect("fits")).expect("runs");
    // 500 m wide: from 250 to 750.
    assert_eq!(out.height.row(10)[5..=15], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
    assert_eq!((out.inside.row(10)[4], out.inside.row(10)[5]), (0.0, 1.0));
}

#[test]
fn a_georeference_goes_where_it_says() {
    // The file begins 200 m east and 300 m south of the corner of the terrain it was written on.
    let geo = Geo { epsg: 32611, east: 380_000.0, north: 3_800_000.0 };
    let from = Terrain { geo: Some(geo), ..square(1000.0) };
    let mut at = super::grid(21, 11, 10.0);
    (at.col, at.row) = (20, 30);
    let data = (0..231).map(|k| ((k % 21) * 2 + (k / 21) * 5) as f32).collect();
    let value = Value::Field(Field::new(at, orograph::value::Quantity::Elevation, data));
    let files = [source("a.tif", write(&job(&value, Format::Tiff, &from)).0)];
    // Another terrain, 50 m further east and 100 m further north.
    let to = Terrain {
        origin: [-7.0, 13.0],
        geo: Some(Geo { east: 380_050.0, north: 3_800_100.0, ..geo }),
        ..square(800.0)
    };
    let out = run(&node(Placing::Georeference), &files, &to, to.grid(81).expect("fits")).expect("runs");
    // Its sample (0, 0) stands 150 m east and 400 m south there.
    for (i, j) in [(0, 0), (1, 0), (0, 1), (20, 10)] {
        assert_eq!(out.height.at(15 + i, 40 + j), (2 * i + 5 * j) as f32);
    }
    assert_eq!((out.inside.at(14, 40), out.inside.at(15, 40), out.inside.at(35, 50)), (0.0, 1.0, 1.0));
    let fails = |terrain: &Terrain, files: &[Arc<SourceFile>]| {
        let error = run(&node(Placing::Georeference), files, terrain, terrain.grid(81).expect("fits"));
        error.err().expect("cannot be placed").to_string()
    };
    assert!(fails(&square(800.0), &files).contains("no `geo`"));
    let other = Terrain { geo: Some(Geo { epsg: 32612, ..geo }), ..square(800.0) };
    assert!(fails(&other, &files).contains("EPSG:32611, the terrain in EPSG:32612"));
    let degrees = [source("a.tif", include_bytes!("fixtures/degrees_f32.tif").to_vec())];
    assert!(fails(&Terrain { geo: Some(Geo { epsg: 4326, ..geo }), ..other }, &degrees).contains("metres"));
    assert!(fails(&from, &[tiff(5, 5, rough)]).contains("no EPSG"));
}

#[test]
fn voids_are_closed_and_come_out_as_a_mask() {
    let files = [source("a.tif", include_bytes!("fixtures/nodata_f32.tif").to_vec())];
    let terrain = Terrain { width: 200.0, depth: 120.0, ..Terrain::default() };
    let grid = terrain.grid(21).expect("fits");
    assert_eq!((grid.cols, grid.rows), (21, 13));
    let out = run(&node(Placing::Stretch), &files, &terrain, grid).expect("runs");
    let void = |k: usize| (5..9).contains(&(k % 21)) && (2..4).contains(&(k / 21));
    for (k, v) in out.voids.data().iter().enumerate() {
        assert_eq!(*v == 1.0, void(k));
    }
    for k in (0..grid.len()).filter(|k| void(*k)) {
        // The plane under the fixture's ripples of 0 to 3 m.
        let (i, j) = ((k % 21) as f32, (k / 21) as f32);
        let plane = 100.0 + 3.0 * i - 2.0 * j + 1.5;
        assert!((out.height.data()[k] - plane).abs() < 3.0, "{} at ({i}, {j})", out.height.data()[k]);
    }
    let fill = Fill::Level { height: Metres(-5.0) };
    let level = ImportHeight {
        fill,
        height_scale: Number(2.0),
        height_offset: Metres(1.0),
        ..node(Placing::Stretch)
    };
    let out = run(&level, &files, &terrain, grid).expect("runs");
    for k in 0..grid.len() {
        let want = match void(k) {
            true => -5.0,
            false => 201.0 + 6.0 * (k % 21) as f32 - 4.0 * (k / 21) as f32 + ((k % 21) * (k / 21) % 7) as f32,
        };
        assert_eq!(out.height.data()[k], want);
    }
    let all = HeightFile { data: vec![f32::NAN; 21 * 13], ..open(&files[0]) };
    let mut bytes = std::io::Cursor::new(Vec::new());
    encode_file(&all, &Format::Tiff.into(), &mut bytes).expect("writes");
    let error = run(&node(Placing::Stretch), &[source("a.tif", bytes.into_inner())], &terrain, grid);
    assert!(error.err().expect("nothing there").to_string().contains("nothing but voids"));
}

fn open(file: &SourceFile) -> HeightFile {
    let bytes = file.read(&Work::default()).expect("is in memory");
    read_height(file.name(), &bytes, None, &Limits::default()).expect("reads")
}

#[test]
fn the_sidecar_gives_metres() {
    let value = heights(9, 9, |k| k as f32);
    let terrain = square(80.0);
    let writing = Writing { range: Some([-100.0, 200.0]), ..Format::Png16.into() };
    let (bytes, sidecar) = write(&job(&value, writing, &terrain));
    let both = [source("a.png", bytes), source("a.json", sidecar.expect("has one"))];
    let node = ImportHeight { file: FilePath("a.png".into()), ..node(Placing::Stretch) };
    let names: Vec<_> = node.files().into_iter().map(|f| (f.name, f.optional)).collect();
    let beside = |extension: &str| (format!("a.{extension}"), extension != "png");
    let all = ["png", "json", "pgw", "pngw", "wld", "prj", "png.aux.xml", "png.msk"];
    assert_eq!(names, all.map(beside));
    let grid = terrain.grid(9).expect("fits");
    let out = run(&node, &both, &terrain, grid).expect("runs");
    assert!(out.height.data().iter().enumerate().all(|(k, v)| (v - k as f32).abs() < 3e-3));
    let plain = run(&node, &both[..1], &terrain, grid).expect("runs");
    assert_eq!(plain.height.data()[0], (100.0f32 / 300.0 * 65535.0).round());
}

/// Between samples of a sine the spline is off by a fortieth of what planes are.
#[test]
fn the_spline_is_smoother_than_planes() {
    let wave = |x: f64| 100.0 * libm::sin(x * 0.5);
    let files = [tiff(65, 65, |i, j| (wave(i as f64) + wave(j as f64)) as f32)];
    let terrain = square(64.0);
    let grid = terrain.grid(64 * 5 + 1).expect("fits");
    let worst = |interpolation| {
        let out = run(&ImportHeight { interpolation, ..node(Placing::Stretch) }, &files, &terrain, grid)
            .expect("runs");
        let off = |k: usize| {
            let (i, j) = (k % grid.cols, k / grid.cols);
            // The natural end of the spline bends differently; a few cells inside it no longer matters.
            let near = [i, j].into_iter().any(|n| !(40..281).contains(&n));
            let want = wave(grid.x(i)) + wave(grid.y(j));
            if near { 0.0 } else { (f64::from(out.height.data()[k]) - want).abs() }
        };
        (0..grid.len()).map(off).fold(0.0, f64::max)
    };
    let (cubic, linear) = (worst(Interpolation::Cubic), worst(Interpolation::Linear));
    assert!(cubic < 0.2 && cubic < linear / 30.0, "cubic is off by {cubic}, linear by {linear}");
}

#[test]
fn errors_name_parameter_or_file() {
    let terrain = square(100.0);
    let grid = terrain.grid(11).expect("fits");
    let say = |node: &ImportHeight, files: &[Arc<SourceFile>]| {
        run(node, files, &terrain, grid).err().expect("an error").to_string()
    };
    assert_eq!(say(&ImportHeight::default(), &[]), "parameter `file` names no file; choose one");
    assert_eq!(say(&node(Placing::Stretch), &[]), "parameter `file`: not found: a.tif");
    let broken = [source("a.tif", b"II*\0".to_vec())];
    assert!(say(&node(Placing::Stretch), &broken).ends_with(": a.tif"));
    let mut raw = node(Placing::TrueSize { x: Metres(0.0), y: Metres(0.0), rotation: Degrees(0.0) });
    raw.file = FilePath("a.r16".into());
    assert!(say(&raw, &[source("a.r16", vec![0; 8])]).contains("`cell` must be set"));
}

/// Nodes that read one file in different ways do not disturb each other.
#[test]
fn one_file_serves_different_nodes() {
    let files = [tiff(9, 9, rough)];
    let terrain = square(80.0);
    let grid = terrain.grid(33).expect("fits");
    let smooth = node(Placing::Stretch);
    let linear = ImportHeight { interpolation: Interpolation::Linear, ..smooth.clone() };
    let first = run(&smooth, &files, &terrain, grid).expect("runs").height;
    let second = run(&linear, &files, &terrain, grid).expect("runs").height;
    assert!(first != second);
    assert!(run(&smooth, &files, &terrain, grid).expect("runs").height == first);
}

/// Before anybody went through a file, what needs its content is not looked at: `check` of a file without a header is short.
#[test]
fn the_content_of_a_file_is_not_read_to_look_at_it() {
    let look = |name: &str, bytes: &[u8], known: bool| {
        let place = Box::new(bytes.to_vec());
        let file = SourceFile::at(name.into(), bytes.len() as u64, place, Arc::default());
        if known {
            file.hash(&Work::default()).expect("in memory");
        }
        ImportHeight { file: FilePath(name.into()), ..ImportHeight::default() }.reading(&[Arc::new(file)])
    };
    let (good, bad) = (&b"0 0 1\n1 0 2\n0 1 3\n1 1 4\n"[..], &b"0 0 1\n1 0 x\n"[..]);
    assert!(look("a.xyz", bad, false).is_ok());
    assert!(look("a.xyz", bad, true).is_err());
    let [early, late] = [false, true].map(|known| look("a.xyz", good, known).expect("fine").bytes);
    assert!(late > early, "{late} bytes, not more than {early}");
    assert!(look("a.asc", bad, false).is_err());
}
