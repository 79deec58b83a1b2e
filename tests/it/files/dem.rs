//! Real elevation models, where the machine has them: the folder named by `OROGRAPH_DEM`, or `../shared/dem`.

use std::path::PathBuf;

use orograph::files::{HeightFile, Info, Limits, read_height};
use serde_json::Value as Json;

use crate::rig::skip::skip;

/// The folder; its absence is told.
fn folder(test: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/dem");
    let folder = std::env::var_os("OROGRAPH_DEM").map_or_else(beside, PathBuf::from);
    if folder.join("index.json").is_file() {
        return Some(folder);
    }
    let at = folder.display();
    skip(test, &format!("no elevation models at {at}; set OROGRAPH_DEM to their folder"), &folder);
    None
}

fn open(folder: &std::path::Path, name: &str) -> HeightFile {
    let bytes = std::fs::read(folder.join(name)).expect("the index names files that are there");
    read_height(name, &bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_model_has_the_heights_and_the_cell_of_the_index() {
    let Some(folder) = folder("every_model_has_the_heights_and_the_cell_of_the_index") else { return };
    let index: Vec<Json> =
        serde_json::from_slice(&std::fs::read(folder.join("index.json")).expect("reads")).expect("parses");
    let mut seen = 0;
    for entry in &index {
        let name = entry["file"].as_str().expect("a name");
        if name.ends_with(".nc") || name.ends_with(".npz") {
            continue;
        }
        seen += 1;
        let file = open(&folder, name);
        assert_eq!(format!("{}x{}", file.cols, file.rows), entry["size"].as_str().expect("a size"), "{name}");
        let number = |key: &str| entry[key].as_f64();
        let scale = number("zscale").unwrap_or(1.0);
        assert_eq!(file.metres, scale == 1.0, "{name}: only plain PNGs need a scale");
        let [lo, hi] = file.range().expect("some height").map(|v| f64::from(v) * scale);
        let (want_lo, want_hi) = (number("min_m").expect("min"), number("max_m").expect("max"));
        assert!((lo - want_lo).abs() < 0.06 && (hi - want_hi).abs() < 0.06, "{name}: {lo} to {hi} m");
        let void = file.voids() as f64 / file.data.len() as f64;
        assert!((void - number("void_frac").expect("voids")).abs() < 1e-5, "{name}: {void} void");
        if let (Some([dx, dy]), Some(want)) = (file.placement.cell, number("cell_m")) {
            // The index took the Earth for a ball; 0.4 % lie between that and the ellipsoid.
            let cell = (dx * dy).sqrt();
            assert!((cell / want - 1.0).abs() < 0.004, "{name}: a cell of {cell} m, not {want}");
        } else {
            assert!(name.ends_with(".png"), "{name} says how far apart its samples are");
        }
        println!("{}", Info::of(name, &file));
    }
    assert!(seen >= 10, "only {seen} models in the index");
}

/// Sum of all heights, voids, and two samples, as GDAL 3.10 reads them (rows counted in the order of the file).
type Model = (&'static str, f64, usize, [f64; 2]);

const AS_GDAL_READS: [Model; 19] = [
    ("N43E006.hgt", 622434911.0, 0, [877.0, 0.0]),
    ("N43E007.hgt", 227626026.0, 4, [0.0, 0.0]),
    ("N44E005.hgt", 1253658649.0, 4822, [922.0, 733.0]),
    ("aiguestortes_20m.png", 45407334476.0, 0, [26226.0, 8584.0]),
    ("appalachians.png", 1149053477.0, 0, [3248.0, 1047.0]),
    ("bigtujunga.tif", 944102028.0, 0, [1483.0, 852.0]),
    ("boulder_SRTMGL3.asc", 88027030.0, 0, [2864.0, 2008.0]),
    ("carrizo.tif", 301272400.82592773, 0, [645.1489868164062, 685.3359985351562]),
    ("co_elevation_roi.tif", 2094881730.0705566, 0, [2922.819580078125, 2834.927978515625]),
    ("gobi.png", 1281772684.0, 0, [3116.0, 2928.0]),
    ("grandcanyon.tif", 407699138.0, 0, [1361.0, 1831.0]),
    ("greenriver.tif", 2632303698.013672, 0, [1321.2099609375, 1309.0999755859375]),
    ("karakoram.png", 7268925685.0, 0, [15152.0, 19761.0]),
    ("pyrenees_30m.png", 16661623539.0, 0, [9492.0, 6396.0]),
    ("srtm90.tif", 16627198331.0, 0, [1427.0, 455.0]),
    ("srtm_oetztal.tif", 647237653.0, 0, [2053.0, 1569.0]),
    ("sthelens_10m.png", 48066900661.0, 0, [9106.0, 8384.0]),
    ("terrarium_sthelens_256.png", 89065660.66796875, 0, [1050.57421875, 2118.921875]),
    ("yangshuo.png", 524332831.0, 0, [493.0, 403.0]),
];

#[test]
fn every_model_reads_as_gdal_reads_it() {
    let Some(folder) = folder("every_model_reads_as_gdal_reads_it") else { return };
    for (name, sum, voids, samples) in AS_GDAL_READS {
        let file = open(&folder, name);
        let got: f64 = file.data.iter().filter(|v| !v.is_nan()).map(|v| f64::from(*v)).sum();
        assert!((got - sum).abs() < 1e-9 * sum.abs(), "{name}: the sum is {got}, not {sum}");
        assert_eq!(file.voids(), voids, "{name}");
        // Carrizo's rows run from south to north; the reader turns them.
        let row = |j: usize| if name == "carrizo.tif" { file.rows - 1 - j } else { j };
        let at = |j: usize, i: usize| f64::from(file.data[row(j) * file.cols + i]);
        let (cols, rows) = (file.cols, file.rows);
        assert_eq!([at(rows / 3, cols / 4), at(rows - 2, cols - 3)], samples, "{name}");
    }
}

#[test]
fn every_model_knows_its_place() {
    let Some(folder) = folder("every_model_knows_its_place") else { return };
    for (name, epsg, north_west) in [
        ("bigtujunga.tif", Some(32611), [376_328.655_454, 3_807_902.827_628]),
        ("greenriver.tif", Some(6341), [561_000.5, 4_304_999.5]),
        ("grandcanyon.tif", Some(3857), [-12_601_676.012_693, 4_344_030.972_677]),
        ("srtm90.tif", Some(4326), [-120.755_523_107, 38.626_519_192]),
        ("N44E005.hgt", Some(4326), [5.0, 45.0]),
        ("boulder_SRTMGL3.asc", None, [-105.55, 40.21]),
        ("carrizo.tif", None, [241_028.441, 3_910_577.74]),
    ] {
        let place = open(&folder, name).placement;
        assert_eq!(place.epsg, epsg, "{name}");
        let [x, y] = place.affine.expect("a place").origin;
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * b.abs().max(1.0);
        assert!(near(x, north_west[0]) && near(y, north_west[1]), "{name}: {x}, {y}");
    }
}
