//! Files by other programs. The fixtures were written by GDAL 3.10 (the interlaced PNG by hand): 21 x 13 samples of
//! `100 + 3 i - 2 j + (i j mod 7) / 2`, or of `7 i - 5 j + (i j mod 11)` for integers, 100 more where they have no sign.

use orograph::files::{Affine, Anchor, Encoding, HeightFile, Limits, Units, read_height, read_height_as};

const COLS: usize = 21;
const ROWS: usize = 13;

fn floats(i: usize, j: usize) -> f32 {
    100.0 + 3.0 * i as f32 - 2.0 * j as f32 + ((i * j) % 7) as f32 / 2.0
}

fn integers(i: usize, j: usize) -> f32 {
    7.0 * i as f32 - 5.0 * j as f32 + ((i * j) % 11) as f32
}

fn open(name: &str, bytes: &[u8]) -> HeightFile {
    read_height(name, bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"))
}

macro_rules! fixture {
    ($name:literal) => {
        open($name, include_bytes!(concat!("fixtures/", $name)))
    };
}

fn holds(file: &HeightFile, sample: &str, f: impl Fn(usize, usize) -> f32) {
    assert_eq!((file.cols, file.rows, file.origin.sample), (COLS, ROWS, sample));
    for (k, v) in file.data.iter().enumerate() {
        let want = f(k % COLS, k / COLS);
        assert!(*v == want, "column {}, row {}: {v}, not {want}", k % COLS, k / COLS);
    }
}

#[test]
fn every_layout_compression_and_predictor_is_read() {
    let moved = |i, j| integers(i, j) + 100.0;
    holds(&fixture!("tiled_deflate_p3_f32.tif"), "f32", floats);
    holds(&fixture!("tiled_lzw_p2_i16.tif"), "i16", integers);
    holds(&fixture!("strip_lzw_p3_f64.tif"), "f64", floats);
    holds(&fixture!("band_deflate_p2_u16.tif"), "u16", moved);
    holds(&fixture!("pixel_lzw_p2_i32.tif"), "i32", integers);
    holds(&fixture!("big_tiled_f32.tif"), "f32", floats);
    holds(&fixture!("motorola_p3_f32.tif"), "f32", floats);
    holds(&fixture!("motorola_p2_i16.tif"), "i16", integers);
    holds(&fixture!("motorola_u32.tif"), "u32", moved);
    holds(&fixture!("packbits_u8.tif"), "u8", moved);
    holds(&fixture!("interlaced_u16.png"), "u16", moved);
}

#[test]
fn scale_and_offset_of_gdal_make_metres() {
    holds(&fixture!("scaled_u16.tif"), "u16", |i, j| (integers(i, j) + 100.0) / 4.0 - 50.0);
}

#[test]
fn places_are_those_of_gdal() {
    let area = fixture!("tiled_deflate_p3_f32.tif").placement;
    assert_eq!(area.affine, Some(Affine::upright([500_015.0, 3_999_985.0], [30.0, 30.0])));
    assert_eq!((area.epsg, area.anchor, area.units), (Some(32632), Anchor::Area, Units::Length(1.0)));
    assert_eq!(area.cell, Some([30.0, 30.0]));
    // GDAL shifts what it calls a corner by half a cell, so the sample stands where an area's would.
    let point = fixture!("point_f32.tif").placement;
    assert_eq!((point.affine, point.anchor), (area.affine, Anchor::Point));
    let turned = fixture!("turned_f32.tif").placement;
    let (sin, cos) = libm::sincos(30f64.to_radians());
    let [x, y] = turned.affine.expect("has one").at(2.0, 5.0);
    let (u, v) = (25.0, -55.0);
    assert!((x - (500_000.0 + u * cos - v * sin)).abs() < 1e-6, "{x}");
    assert!((y - (4_000_000.0 + u * sin + v * cos)).abs() < 1e-6, "{y}");
    let [dx, dy] = turned.cell.expect("known");
    assert!((dx - 10.0).abs() < 1e-9 && (dy - 10.0).abs() < 1e-9);
    let degrees = fixture!("degrees_f32.tif").placement;
    assert_eq!((degrees.epsg, degrees.units), (Some(4326), Units::Degrees));
    // pyproj: geodesics of 1/1200 degree around 46.4946 N are 63.96 m to the east and 92.62 m to the north.
    let [dx, dy] = degrees.cell.expect("known");
    assert!((dx - 63.965).abs() < 0.02 && (dy - 92.625).abs() < 0.02, "{dx}, {dy}");
}

#[test]
fn nodata_and_missing_tiles_are_voids() {
    let file = fixture!("nodata_f32.tif");
    let void = |k: usize| (5..9).contains(&(k % COLS)) && (2..4).contains(&(k / COLS));
    assert!(file.data.iter().enumerate().all(|(k, v)| v.is_nan() == void(k)));
    assert_eq!((file.voids(), file.origin.nodata), (8, Some(-9999.0)));
    let sparse = fixture!("sparse_i16.tif");
    let known = |k: usize| (16..32).contains(&(k % 40)) && (16..32).contains(&(k / 40));
    assert!(sparse.data.iter().enumerate().all(|(k, v)| if known(k) { *v == 5.0 } else { v.is_nan() }));
}

fn png(color: png::ColorType, depth: png::BitDepth, size: [u32; 2], data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().expect("writes");
    writer.write_image_data(data).expect("writes");
    writer.finish().expect("writes");
    out
}

#[test]
fn pngs_are_grey_terrarium_or_refused() {
    use png::{BitDepth, ColorType};
    let limits = Limits::default();
    let read = |bytes: &[u8], encoding| read_height_as("a.png", bytes, None, &limits, encoding);
    // 2125.5 m and 2130 m, by the formula of the Terrarium tiles.
    let tile = png(ColorType::Rgb, BitDepth::Eight, [2, 1], &[136, 77, 128, 136, 82, 0]);
    let file = read(&tile, Encoding::Auto).expect("a Terrarium tile");
    assert_eq!((file.data, file.metres, file.origin.sample), (vec![2125.5, 2130.0], true, "terrarium"));
    let grey = png(ColorType::Rgb, BitDepth::Eight, [3, 1], &[0, 0, 0, 200, 200, 200, 255, 255, 255]);
    let file = read(&grey, Encoding::Auto).expect("grey in three channels");
    assert_eq!((file.data, file.metres), (vec![0.0, 200.0, 255.0], false));
    let file = read(&grey, Encoding::Terrarium).expect("somebody said so");
    assert_eq!(file.data[1], 200.0 * 256.0 + 200.0 + 200.0 / 256.0 - 32768.0);
    let photo = png(ColorType::Rgb, BitDepth::Eight, [2, 1], &[250, 10, 30, 3, 200, 9]);
    assert!(read(&photo, Encoding::Auto).expect_err("a photo").to_string().contains("colour"));
    assert!(read(&photo, Encoding::Grey).expect_err("not grey").to_string().contains("colour"));
    let clear = png(ColorType::GrayscaleAlpha, BitDepth::Eight, [2, 1], &[9, 255, 7, 0]);
    let file = read(&clear, Encoding::Auto).expect("grey with holes");
    assert!(file.data[0] == 9.0 && file.data[1].is_nan());
    let low = png(ColorType::Grayscale, BitDepth::One, [3, 1], &[0b1010_0000]);
    assert_eq!(read(&low, Encoding::Auto).expect("black and white").data, [255.0, 0.0, 255.0]);
}

#[test]
fn esri_grids_are_read_as_people_write_them() {
    let text = "\u{feff}# made by hand\r\nNCOLS 3\r\nnrows 2\r\nXLLCENTER 10\r\nyllcenter 20\r\nDX 2\r\ndy 4\r\n\
                NoData_Value -1\r\n1 2,5 3e1\r\n-1 nan\t-7.25";
    let file = open("a.asc", text.as_bytes());
    assert_eq!((file.cols, file.rows), (3, 2));
    assert_eq!(file.data[..3], [1.0, 2.5, 30.0]);
    assert!(file.data[3].is_nan() && file.data[4].is_nan() && file.data[5] == -7.25);
    assert_eq!(file.placement.affine, Some(Affine::upright([10.0, 24.0], [2.0, 4.0])));
    assert_eq!((file.placement.anchor, file.placement.cell), (Anchor::Point, Some([2.0, 4.0])));
    let corner = open("a.asc", b"ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n1, 2,\n3, 4");
    assert_eq!(corner.data, [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(corner.placement.affine, Some(Affine::upright([5.0, 15.0], [10.0, 10.0])));
    for (text, message) in [
        ("ncols 2\nnrows 2\n1.0 2.0 3.0", "3 numbers where 4"),
        ("ncols 2\nnrows 2\n1 2 3 4 5", "5 numbers where 4"),
        ("ncols 2\nnrows 2\n1 2 x 4", "`x` is no number"),
        ("ncols 2\n1 2 3 4", "no `nrows`"),
        ("ncols 2.5\nnrows 2\n1 2 3 4", "no `ncols`"),
        ("ncols 2\nnrows 2\ncellsize 0\n1 2 3 4", "a cell of 0"),
        ("ncols 2\nnrows 2\nfoo 3\n1 2 3 4", "unknown key `foo`"),
        ("ncols 1000000\nnrows 1000000\n1", "1000000 x 1000000"),
        ("ncols 20000\nnrows 20000\n1 2 3", "ends early"),
        ("", "no `ncols`"),
    ] {
        let error = read_height("a.asc", text.as_bytes(), None, &Limits::default()).expect_err(text);
        assert!(error.to_string().contains(message), "{error}");
        assert!(error.to_string().ends_with(": a.asc"), "the file stands last: {error}");
    }
}

#[test]
fn raw_files_are_square_or_have_a_sidecar() {
    let limits = Limits::default();
    let bytes: Vec<u8> = (0..18u16).flat_map(|v| (v * 10).to_le_bytes()).collect();
    let square = read_height("a.r16", &bytes[..18], None, &limits).expect("3 x 3");
    assert_eq!((square.cols, square.rows, square.metres), (3, 3, false));
    let error = read_height("a.r16", &bytes, None, &limits).expect_err("18 is no square");
    assert!(error.to_string().contains("sidecar"), "{error}");
    let read = |sidecar: &str| read_height("a.raw", &bytes, Some(sidecar.as_bytes()), &limits);
    let file = read(r#"{"width": 6, "height": 3, "range": [-10, 655340]}"#).expect("6 x 3");
    assert_eq!((file.cols, file.data[0], file.metres), (6, -10.0, true));
    let scaled = read(r#"{"cols": 9, "rows": 2, "scale": 0.5, "offset": 3, "whatever": []}"#).expect("9 x 2");
    assert_eq!(scaled.data[1], 8.0);
    for (sidecar, message) in [
        (r#"{"cols": 7, "rows": 3}"#, "ends early"),
        (r#"{"cols": 2, "rows": 3}"#, "says 2 x 3 samples"),
        (r#"{"cols": 1000000, "rows": 1000000}"#, "the limit is"),
        (r#"{"cols": 6, "rows": 3, "range": [1, 1]}"#, "must go upwards"),
        (r#"{"cols": -6, "rows": 3}"#, "cannot be read"),
        ("[", "cannot be read"),
    ] {
        let error = read(sidecar).expect_err(sidecar);
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn names_and_contents_must_agree() {
    let limits = Limits::default();
    let tif = include_bytes!("fixtures/packbits_u8.tif");
    for (name, bytes, message) in [
        ("a.png", &tif[..], "named as PNG, and its content is TIFF"),
        ("a.asc", &tif[..], "named as Esri ASCII grid, and its content is TIFF"),
        ("a.tif", b"hello", "its content is something else"),
        ("a.pgn", &tif[..], "no reader for `.pgn`"),
        ("a.pgn", &tif[..], "did you mean `png`"),
        ("dem.nc", b"CDF\x01", "no reader for `.nc`"),
        ("noextension", b"", "a name without extension"),
    ] {
        let error = read_height(name, bytes, None, &limits).expect_err(name).to_string();
        assert!(error.contains(message), "{error}");
    }
}
