//! What files of the field hold beside plain heights: masks, alpha, units, layers, windows, narrow tiles, files beside
//! them. The fixtures were written by GDAL 3.10 (rasterio) and OpenEXR 3.5, with the samples of `foreign.rs`.

use orograph::files::{
    Affine, Anchor, Companion, Encoding, Fault, HeightFile, Input, Limits, ReadError, Reading, Units,
};
use orograph::work::Work;

const COLS: usize = 21;
const ROWS: usize = 13;

fn floats(i: usize, j: usize) -> f32 {
    100.0 + 3.0 * i as f32 - 2.0 * j as f32 + ((i * j) % 7) as f32 / 2.0
}

fn integers(i: usize, j: usize) -> f32 {
    7.0 * i as f32 - 5.0 * j as f32 + ((i * j) % 11) as f32
}

fn moved(i: usize, j: usize) -> f32 {
    integers(i, j) + 100.0
}

/// Reads a file as a person says, with what lies beside it; what it claims must be what it has.
pub(super) fn try_read(
    name: &str,
    bytes: &[u8],
    beside: &[(&str, &[u8])],
    reading: &Reading,
) -> Result<HeightFile, ReadError> {
    let companions: Vec<_> = beside.iter().map(|&(name, bytes)| Companion { name, bytes }).collect();
    let limits = Limits::default();
    let input = Input {
        name,
        bytes: &bytes,
        companions: &companions,
        reading,
        limits: &limits,
        work: Work::default(),
    };
    let file = input.read()?;
    let claim = input.claim().expect("what can be read has a sound header");
    assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64], "{name}");
    assert!(claim.bytes >= 4 * claim.cols * claim.rows, "{name}");
    Ok(file)
}

fn read(name: &str, bytes: &[u8]) -> HeightFile {
    try_read(name, bytes, &[], &Reading::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn channel(name: &str) -> Reading {
    Reading { channel: Some(name.into()), ..Reading::default() }
}

macro_rules! fixture {
    ($name:literal) => {
        include_bytes!(concat!("fixtures/", $name))
    };
}

macro_rules! open {
    ($name:literal) => {
        read($name, fixture!($name))
    };
}

/// Checks every sample; `None` is a void.
fn holds(file: &HeightFile, sample: &str, f: impl Fn(usize, usize) -> Option<f32>) {
    assert_eq!((file.cols, file.rows, file.origin.sample), (COLS, ROWS, sample));
    for (k, v) in file.data.iter().enumerate() {
        let (i, j) = (k % COLS, k / COLS);
        match f(i, j) {
            Some(want) => {
                assert!((v - want).abs() <= 1e-6 * want.abs(), "column {i}, row {j}: {v}, not {want}")
            }
            None => assert!(v.is_nan(), "column {i}, row {j}: {v}, not a void"),
        }
    }
}

fn outside_the_hole(i: usize, j: usize) -> Option<()> {
    (!((5..9).contains(&i) && (2..4).contains(&j))).then_some(())
}

fn notes(file: &HeightFile) -> String {
    file.origin.notes.join("; ")
}

#[test]
fn masks_and_alpha_in_a_tiff_make_voids() {
    let floats = |i, j| outside_the_hole(i, j).map(|()| floats(i, j));
    let masked = open!("mask_inside_f32.tif");
    holds(&masked, "f32", floats);
    assert!(notes(&masked).contains("mask"), "{}", notes(&masked));
    for file in [open!("alpha_pixel_f32.tif"), open!("alpha_band_f32.tif")] {
        holds(&file, "f32", floats);
        assert!(notes(&file).contains("alpha"), "{}", notes(&file));
    }
    // Behind the picture stand its mask, smaller pictures and smaller masks.
    holds(&open!("overviews_mask_i16.tif"), "i16", |i, j| outside_the_hole(i, j).map(|()| integers(i, j)));
    let alpha = try_read("a.tif", fixture!("alpha_pixel_f32.tif"), &[], &channel("2")).expect("asked for");
    assert_eq!((alpha.data[0], alpha.data[2 * COLS + 5]), (255.0, 0.0));
}

#[test]
fn tiffs_of_every_compression_and_width_are_read() {
    let some = |f: fn(usize, usize) -> f32| move |i, j| Some(f(i, j));
    holds(&open!("zstd_p2_i16.tif"), "i16", some(integers));
    holds(&open!("zstd_tiled_p3_f32.tif"), "f32", some(floats));
    holds(&open!("lzma_f32.tif"), "f32", some(floats));
    holds(&open!("lzma_i16.tif"), "i16", some(integers));
    holds(&open!("packed_u12.tif"), "u12", some(moved));
    holds(&open!("packed_u12_deflate_bands.tif"), "u12", some(moved));
    holds(&open!("i64.tif"), "i64", some(integers));
    holds(&open!("u64_motorola.tif"), "u64", some(moved));
    let second = try_read("b.tif", fixture!("packed_u12_deflate_bands.tif"), &[], &channel("2"));
    holds(&second.expect("asked for"), "u12", |i, j| Some(moved(i, j) + 7.0));
    let third = try_read("b.tif", fixture!("packed_u12_deflate_bands.tif"), &[], &channel("3"));
    let error = third.expect_err("there are two").fault;
    assert!(matches!(&error, Fault::Channel { .. }) && error.to_string().contains("bands 1 to 2"), "{error}");
}

#[test]
fn units_of_height_and_of_coordinates_become_metres() {
    const FOOT_US: f64 = 1200.0 / 3937.0;
    let feet = |metres: f64| move |i, j| Some((f64::from(floats(i, j)) * metres) as f32);
    let us = open!("unit_foot_us.tif");
    holds(&us, "f32", feet(FOOT_US));
    assert_eq!(us.placement.cell, Some([30.0, 30.0]));
    assert!(notes(&us).contains("times"), "{}", notes(&us));
    holds(&open!("unit_foot.tif"), "f32", feet(0.3048));
    // GeoTIFF 1.1 names systems by codes only: EPSG:6529 and 6360 count in US survey feet.
    let codes = open!("vertical_codes.tif");
    holds(&codes, "f32", feet(FOOT_US));
    let [dx, dy] = codes.placement.cell.expect("known");
    assert!((dx - 30.0 * FOOT_US).abs() < 1e-9 && (dy - 30.0 * FOOT_US).abs() < 1e-9, "{dx}, {dy}");
    assert_eq!((codes.placement.epsg, codes.placement.units), (Some(6529), Units::Length(FOOT_US)));
    // EPSG:2225 in US survey feet, 8228 in international ones.
    let codes = open!("vertical_codes_10.tif");
    holds(&codes, "f32", feet(0.3048));
    assert!((codes.placement.cell.expect("known")[0] - 30.0 * FOOT_US).abs() < 1e-6);
}

#[test]
fn the_channel_of_heights_of_an_exr_is_found_or_asked_for() {
    let some = |i, j| Some(floats(i, j));
    let layers = open!("layers_f32.exr");
    holds(&layers, "f32", some);
    assert!(notes(&layers).contains("`ViewLayer.Depth.Z`"), "{}", notes(&layers));
    holds(&open!("parts_f16.exr"), "f16", some);
    holds(&open!("tiled_f32.exr"), "f32", some);
    holds(&open!("grey_rgb_f32.exr"), "f32", some);
    let named = |name| try_read("l.exr", fixture!("layers_f32.exr"), &[], &channel(name));
    assert_eq!(named("ViewLayer.Combined.A").expect("asked for").data[0], 1.0);
    assert_eq!(named("viewlayer.combined.g").expect("asked for").data[0], 0.3);
    let error = named("Z").expect_err("there is none").fault.to_string();
    assert!(error.contains("`ViewLayer.Depth.Z`") && error.contains("\"Z\""), "{error}");
}

/// Writes a small picture of channels that all hold the same number, their index, into memory.
fn exr_of(channels: &[&str]) -> Vec<u8> {
    use exr::prelude::*;
    let samples = |i: usize| FlatSamples::F32((0..12).map(|k| (i * 100 + k) as f32).collect());
    let list = channels.iter().enumerate().map(|(i, name)| AnyChannel::new(*name, samples(i))).collect();
    let image = Image::from_channels((4, 3), AnyChannels::sort(list));
    let mut out = std::io::Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut out).expect("writes");
    out.into_inner()
}

#[test]
fn names_of_channels_tell_or_are_listed() {
    let got = |channels: &[&str]| try_read("a.exr", &exr_of(channels), &[], &Reading::default());
    for (channels, chosen) in [
        (&["A", "Y"][..], 1),
        (&["R", "G", "B", "A", "height"], 4),
        (&["A", "whatever"], 1),
        (&["depth.V", "Combined.R", "Combined.G", "Combined.B"], 0),
        (&["Normal.X", "Normal.Y", "Normal.Z", "Depth.Z"], 3),
        (&["land.elevation", "land.Z"], 0),
    ] {
        let file = got(channels).unwrap_or_else(|e| panic!("{channels:?}: {e}"));
        assert_eq!(file.data[0], (chosen * 100) as f32, "{channels:?}: {}", notes(&file));
    }
    for channels in [
        &["R", "G", "B"][..],
        &["R", "G", "B", "A"],
        &["A"],
        &["one", "two"],
        &["first.Z", "second.Z"],
        &["P.X", "P.Y", "P.Z"],
    ] {
        let error = got(channels).expect_err("not to be told").to_string();
        let listed = channels == ["A"] || error.contains("`channel`");
        assert!(listed && !error.contains("damaged"), "{channels:?}: {error}");
    }
}

#[test]
fn windows_of_an_exr_leave_voids_and_cut() {
    let window = open!("window_f32.exr");
    let inner = |i: usize, j: usize| (5..15).contains(&i) && (3..10).contains(&j);
    holds(&window, "f32", |i, j| inner(i, j).then(|| floats(i, j)));
    assert!(notes(&window).contains("display window"), "{}", notes(&window));
    let over = open!("overscan_f32.exr");
    assert_eq!((over.cols, over.rows), (10, 20));
    for (k, v) in over.data.iter().enumerate() {
        let (i, j) = (k % 10 + 2, k / 10 + 1);
        assert!(if j < ROWS { *v == floats(i, j) } else { v.is_nan() }, "{i}, {j}: {v}");
    }
    assert!(notes(&over).contains("1.5 times as wide"), "{}", notes(&over));
}

#[test]
fn the_finest_of_several_levels_is_read() {
    use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Levels};
    use exr::math::RoundingMode;
    use exr::prelude::{Compression, LayerAttributes, LineOrder, Vec2, WritableImage};
    let level = |n: usize, v: f32| FlatSamples::F32(vec![v; n * n]);
    let samples = Levels::Mip {
        rounding_mode: RoundingMode::Down,
        level_data: vec![level(8, 7.0), level(4, 2.0), level(2, 1.0), level(1, 0.0)],
    };
    let channel = AnyChannel::new("Y", samples);
    let encoding = Encoding {
        compression: Compression::ZIP1,
        blocks: Blocks::Tiles(Vec2(4, 4)),
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new((8, 8), LayerAttributes::default(), encoding, channels);
    let mut out = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut out).expect("writes");
    let file = read("a.exr", &out.into_inner());
    assert_eq!((file.cols, file.rows), (8, 8));
    assert!(file.data.iter().all(|v| *v == 7.0));
}

fn hgt(cols: usize, rows: usize) -> Vec<u8> {
    (0..cols * rows).flat_map(|k| (100 + (k / cols / 40) as i16).to_be_bytes()).collect()
}

#[test]
fn narrow_tiles_of_high_latitudes_are_read() {
    for (cols, rows) in [(1801, 3601), (601, 1201), (2401, 3601), (721, 3601), (241, 1201), (1201, 1201)] {
        let file = read("N61E009.hgt", &hgt(cols, rows));
        assert_eq!((file.cols, file.rows), (cols, rows));
        assert_eq!((file.data[0], file.data[file.data.len() - 1]), (100.0, (100 + (rows - 1) / 40) as f32));
        let step = [1.0 / (cols - 1) as f64, 1.0 / (rows - 1) as f64];
        assert_eq!(file.placement.affine, Some(Affine::upright([9.0, 62.0], step)));
    }
    let odd = try_read("N61E009.hgt", &hgt(1800, 3601), &[], &Reading::default());
    assert!(odd.expect_err("no tile").to_string().contains("no square"));
}

#[test]
fn grids_of_text_have_voids_in_many_words() {
    let grid = |nodata: &str, numbers: &str| {
        let text =
            format!("ncols 3\r\nnrows 2\r\nxllcorner 0\r\nyllcorner 0\r\ncellsize 10\r\n{nodata}{numbers}");
        let file = read("a.asc", text.as_bytes());
        file.data.iter().map(|v| if v.is_nan() { -1.0 } else { *v }).collect::<Vec<_>>()
    };
    let want = [100.0, 110.0, 120.0, 130.0, -1.0, 150.0];
    for (nodata, void) in [
        ("NODATA_value null\r\n", "null"),
        ("NODATA_value nan\r\n", "NaN"),
        ("NODATA_value -inf\r\n", "-inf"),
        ("nodata_value -9999,0\r\n", "-9999"),
        ("", "1.#QNAN"),
        ("", "-1.#IND00"),
        ("", "*"),
        ("NODATA_value -3.4028234663852886e+38\r\n", "-3.40282346638529e+38"),
    ] {
        assert_eq!(grid(nodata, &format!("100 110 120\r\n130 {void} 150\r\n")), want, "{nodata} {void}");
    }
    assert_eq!(grid("NODATA_value null\r\n", "null 110 120 130 140 150")[0], -1.0, "a void comes first");
    let centre = read("a.asc", b"NCOLS 2\nNROWS 2\nXLLCENTER 5\nYLLCENTER 7\nDX 2\nDY 3\n1 2 3 4");
    assert_eq!(centre.placement.affine, Some(Affine::upright([5.0, 10.0], [2.0, 3.0])));
    assert_eq!(centre.placement.anchor, Anchor::Point);
    let letters = try_read("a.asc", b"ncols 1\nnrows 1\nseven", &[], &Reading::default());
    assert!(letters.is_err());
}

fn picture(color: png::ColorType, cols: usize, pixels: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let rows = pixels.len() / color.samples() / cols;
    let mut encoder = png::Encoder::new(&mut out, cols as u32, rows as u32);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("writes");
    writer.write_image_data(pixels).expect("writes");
    writer.finish().expect("writes");
    out
}

#[test]
fn colour_pictures_hold_no_heights_unless_they_are_asked() {
    let pixels = |f: &dyn Fn(usize, usize) -> [u8; 3]| -> Vec<u8> {
        (0..64 * 64).flat_map(|k| f(k % 64, k / 64)).collect()
    };
    let sepia = pixels(&|x, y| [112, 66, 20].map(|c| (c as f32 * (1.0 + (x + y) as f32 / 500.0)) as u8));
    let refused = try_read("a.png", &picture(png::ColorType::Rgb, 64, &sepia), &[], &Reading::default());
    let error = refused.expect_err("a picture").to_string();
    assert!(error.contains("colour") && error.contains("`encoding`"), "{error}");
    let asked = |encoding| {
        try_read("a.png", &picture(png::ColorType::Rgb, 64, &sepia), &[], &Reading::from(encoding))
    };
    assert_eq!(asked(Encoding::Terrarium).expect("asked for").origin.sample, "terrarium");
    let file = asked(Encoding::TerrainRgb).expect("asked for");
    assert_eq!((file.origin.sample, file.metres), ("terrain_rgb", true));
    assert_eq!(file.data[0], -10000.0 + (112.0 * 65536.0 + 66.0 * 256.0 + 20.0) / 10.0);
    let tile = pixels(&|x, y| {
        let n = ((1000.0 + 9.7 * x as f32 + 3.3 * y as f32 + 32768.0) * 256.0) as u32;
        [(n >> 16) as u8, (n >> 8) as u8, n as u8]
    });
    let file = read("a.png", &picture(png::ColorType::Rgb, 64, &tile));
    assert_eq!((file.origin.sample, file.data[0]), ("terrarium", 1000.0));
}

#[test]
fn world_files_and_prj_beside_a_file_give_its_place() {
    let grey: Vec<u8> = (0..12).collect();
    let bytes = picture(png::ColorType::Grayscale, 4, &grey);
    let world = b"30\n0\n0\n-30\n500015\n3999985\n";
    let prj = br#"PROJCS["WGS_1984_UTM_Zone_32N",GEOGCS["GCS_WGS_1984"],UNIT["Meter",1.0]]"#;
    let with =
        |beside: &[(&str, &[u8])]| try_read("d/a.png", &bytes, beside, &Reading::default()).expect("reads");
    let place = with(&[("d/a.pgw", world), ("d/a.prj", prj)]).placement;
    assert_eq!(place.affine, Some(Affine::upright([500_015.0, 3_999_985.0], [30.0, 30.0])));
    assert_eq!((place.epsg, place.units, place.cell), (Some(32632), Units::Length(1.0), Some([30.0, 30.0])));
    let feet = br#"PROJCS["x",GEOGCS["y"],UNIT["Foot_US",0.3048006096012192]]"#;
    let place = with(&[("d/a.pgw", world), ("d/a.prj", feet)]).placement;
    assert!((place.cell.expect("known")[0] - 9.144_018_288).abs() < 1e-6);
    let bad = with(&[("d/a.pgw", b"hello"), ("d/a.prj", prj)]);
    assert_eq!((bad.placement.affine, notes(&bad).contains("six numbers")), (None, true));
    assert_eq!(
        orograph::files::companions("d/a.tif"),
        ["d/a.tfw", "d/a.tifw", "d/a.wld", "d/a.prj", "d/a.tif.aux.xml", "d/a.tif.msk"],
        "TIFF says the rest itself; what else stands beside it is not read"
    );
}

#[test]
fn rasters_with_a_header_beside_them_are_read() {
    let some = |i, j| Some(floats(i, j));
    let beside: [(&str, &[u8]); 2] = [("gdal.hdr", fixture!("gdal.hdr")), ("gdal.prj", fixture!("gdal.prj"))];
    let file = try_read("gdal.flt", fixture!("gdal.flt"), &beside, &Reading::default()).expect("reads");
    holds(&file, "f32", some);
    assert_eq!(file.placement.affine, Some(Affine::upright([500_015.0, 3_999_985.0], [30.0, 30.0])));
    assert_eq!(file.placement.epsg, Some(32632));
    let hdr: [(&str, &[u8]); 1] = [("gdal_i16.HDR", fixture!("gdal_i16.hdr"))];
    let file = try_read("gdal_i16.bil", fixture!("gdal_i16.bil"), &hdr, &Reading::default()).expect("reads");
    holds(&file, "i16", |i, j| Some(integers(i, j)));
    let none = try_read("gdal.flt", fixture!("gdal.flt"), &[], &Reading::default());
    assert!(none.expect_err("no header").to_string().contains(".hdr"));
    // Two bands of two rows in three layouts, big-endian, behind four bytes; the number says column, row and band.
    let numbers = |order: &dyn Fn(usize) -> [usize; 3]| -> Vec<u8> {
        let number = |[i, j, b]: [usize; 3]| ((i + 10 * j + 100 * b) as u16).to_be_bytes();
        [0; 4].into_iter().chain((0..12).flat_map(|k| number(order(k)))).collect()
    };
    for (layout, bytes) in [
        ("BIL", numbers(&|k| [k % 3, k / 6, k / 3 % 2])),
        ("BIP", numbers(&|k| [k / 2 % 3, k / 6, k % 2])),
        ("BSQ", numbers(&|k| [k % 3, k / 3 % 2, k / 6])),
    ] {
        let hdr = format!(
            "NROWS 2\nNCOLS 3\nNBANDS 2\nNBITS 16\nPIXELTYPE UNSIGNEDINT\nBYTEORDER M\nSKIPBYTES 4\nLAYOUT {layout}\n\
             NODATA 111\n"
        );
        let read =
            |reading| try_read("a.bsq", &bytes, &[("a.hdr", hdr.as_bytes())], &reading).expect("reads").data;
        assert_eq!(read(Reading::default()), [0.0, 1.0, 2.0, 10.0, 11.0, 12.0], "{layout}");
        let second = read(channel("2"));
        assert_eq!(second[..4], [100.0, 101.0, 102.0, 110.0], "{layout}");
        assert!(second[4].is_nan(), "{layout}");
        assert!(try_read("a.bil", &bytes[..14], &[("a.hdr", hdr.as_bytes())], &Reading::default()).is_err());
    }
    // The header of a float grid, with its own words and order.
    let hdr =
        b"ncols 2\nnrows 1\nxllcorner 10\nyllcorner 20\ncellsize 4\nNODATA_value -9999\nbyteorder MSBFIRST\n";
    let bytes: Vec<u8> = [1.5f32, -9999.0].iter().flat_map(|v| v.to_be_bytes()).collect();
    let file = try_read("a.flt", &bytes, &[("a.hdr", hdr)], &Reading::default()).expect("reads");
    assert_eq!((file.data[0], file.data[1].is_nan()), (1.5, true));
    assert_eq!(file.placement.affine, Some(Affine::upright([12.0, 22.0], [4.0, 4.0])));
}

#[test]
fn lines_of_points_are_a_grid_in_any_order() {
    let file = open!("gdal.xyz");
    holds(&file, "text", |i, j| Some(floats(i, j)));
    assert_eq!(file.placement.affine, Some(Affine::upright([500_015.0, 3_999_985.0], [30.0, 30.0])));
    let mut lines: Vec<String> = (0..12)
        .map(|k| format!("{},{},{}", 10.0 + (k % 4) as f64 * 0.333, 50.0 - (k / 4) as f64 * 0.333, k))
        .collect();
    lines.remove(5);
    let want: Vec<_> = (0..12).map(|k| if k == 5 { -1.0 } else { k as f32 }).collect();
    let got = |text: String| -> Vec<f32> {
        let file = read("a.xyz", text.as_bytes());
        assert_eq!((file.cols, file.rows), (4, 3));
        file.data.iter().map(|v| if v.is_nan() { -1.0 } else { *v }).collect()
    };
    assert_eq!(got(lines.join("\n")), want);
    assert_eq!(got(format!("lon,lat,elevation\r\n{}\r\n", lines.join("\r\n"))), want, "a line of names");
    lines.reverse();
    assert_eq!(got(lines.join("\n").replace(',', ";")), want, "from the last to the first");
    lines.sort();
    assert_eq!(got(lines.join("\n").replace(',', "\t")), want, "column by column");
    for (text, why) in
        [("1 2", "line 1"), ("1 2 3\n4 x 5", "line 2"), ("0 0 1\n1 0 2\n2.5 0 3", "grid"), ("", "no line")]
    {
        let error = try_read("a.xyz", text.as_bytes(), &[], &Reading::default());
        // A first line without numbers may be one of names.
        let error = error.expect_err(text).to_string();
        assert!(error.contains(why) || error.contains("no line"), "{text}: {error}");
    }
}

#[test]
fn float_maps_and_terragen_are_read() {
    let pfm = |order: &str, f: fn(f32) -> [u8; 4]| -> Vec<u8> {
        let rows = (0..ROWS).rev().flat_map(|j| (0..COLS).map(move |i| floats(i, j)));
        [format!("Pf\n{COLS} {ROWS}\n{order}\n").into_bytes(), rows.flat_map(f).collect()].concat()
    };
    holds(&read("a.pfm", &pfm("-1.0", f32::to_le_bytes)), "f32", |i, j| Some(floats(i, j)));
    holds(&read("a.pfm", &pfm("1.0", f32::to_be_bytes)), "f32", |i, j| Some(floats(i, j)));
    let colors =
        [b"PF 1 1 -1\n".to_vec(), [1f32, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes()).collect()].concat();
    assert!(try_read("a.pfm", &colors, &[], &Reading::default()).is_err());
    assert_eq!(try_read("a.pfm", &colors, &[], &channel("g")).expect("asked for").data, [2.0]);
    let ter = open!("gdal.ter");
    assert_eq!((ter.cols, ter.rows, ter.placement.cell), (COLS, ROWS, Some([30.0, 30.0])));
    for (k, v) in ter.data.iter().enumerate() {
        let want = floats(k % COLS, k / COLS);
        assert!((v - want).abs() < 0.01, "{k}: {v}, not {want}");
    }
}

#[test]
fn reading_stops_when_it_is_asked_to() {
    let cancel = orograph::node::Cancel::default();
    cancel.cancel();
    let work = Work::new(&cancel);
    let hdr: &[u8] = fixture!("gdal.hdr");
    let companions = [Companion { name: "a.hdr", bytes: hdr }];
    for (name, bytes) in [
        ("a.tif", &fixture!("zstd_p2_i16.tif")[..]),
        ("a.exr", fixture!("layers_f32.exr")),
        ("a.png", fixture!("interlaced_u16.png")),
        ("a.flt", fixture!("gdal.flt")),
        ("a.xyz", fixture!("gdal.xyz")),
        ("a.ter", fixture!("gdal.ter")),
        ("a.asc", b"ncols 1\nnrows 1\n7"),
        ("a.hgt", &[0; 32]),
        ("a.r16", &[0; 32]),
        ("a.r32", &[0; 64]),
    ] {
        let (limits, reading) = (Limits::default(), Reading::default());
        let input =
            Input { name, bytes: &bytes, companions: &companions, reading: &reading, limits: &limits, work };
        assert_eq!(input.read().expect_err(name).fault, Fault::Cancelled, "{name}");
    }
}

/// A file of every new kind, with what lies beside it.
fn samples() -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
    let hdr = fixture!("gdal.hdr");
    let pfm = [b"Pf\n5 4\n-1\n".to_vec(), vec![63; 80]].concat();
    vec![
        ("a.tif", fixture!("mask_inside_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("overviews_mask_i16.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("alpha_pixel_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("packed_u12_deflate_bands.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("lzma_i16.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("zstd_tiled_p3_f32.tif").to_vec(), Vec::new()),
        ("a.tif", fixture!("vertical_codes.tif").to_vec(), Vec::new()),
        ("a.exr", fixture!("layers_f32.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("parts_f16.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("tiled_f32.exr").to_vec(), Vec::new()),
        ("a.exr", fixture!("window_f32.exr").to_vec(), Vec::new()),
        ("a.flt", fixture!("gdal.flt").to_vec(), hdr.to_vec()),
        ("a.bil", fixture!("gdal_i16.bil").to_vec(), fixture!("gdal_i16.hdr").to_vec()),
        ("a.xyz", fixture!("gdal.xyz").to_vec(), fixture!("gdal.prj").to_vec()),
        ("a.ter", fixture!("gdal.ter").to_vec(), Vec::new()),
        ("a.pfm", pfm, Vec::new()),
    ]
}

/// Reads with small limits; what comes back keeps them, and has the size that its header claims.
fn survives(name: &str, bytes: &[u8], beside: &[u8]) {
    const TIGHT: Limits = Limits { samples: 4096, side: 256 };
    let reading = Reading::default();
    let companions = ["a.hdr", "a.prj", "a.tfw", "a.json"].map(|name| Companion { name, bytes: beside });
    let companions = if beside.is_empty() { &companions[..0] } else { &companions[..3] };
    let input =
        Input { name, bytes: &bytes, companions, reading: &reading, limits: &TIGHT, work: Work::default() };
    let claim = input.claim();
    match input.read() {
        Ok(file) => {
            let claim = claim.expect("what can be read has a sound header");
            assert_eq!([claim.cols, claim.rows], [file.cols as u64, file.rows as u64], "{name}");
            assert!(claim.cols * claim.rows <= TIGHT.samples, "{name}");
            assert_eq!(file.data.len(), file.cols * file.rows, "{name}");
            assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()), "{name}");
        }
        Err(e) => assert!(e.to_string().ends_with(name), "the file stands last: {e}"),
    }
}

#[test]
fn damaged_files_of_these_kinds_do_no_harm() {
    use orograph::kit::hash;
    for (name, bytes, beside) in samples() {
        survives(name, &bytes, &beside);
        for n in (0..bytes.len()).step_by(3) {
            survives(name, &bytes[..n], &beside);
        }
        for at in 0..bytes.len().min(900) {
            for change in [0xff, 0x01, 0x80] {
                let mut bad = bytes.clone();
                bad[at] ^= change;
                survives(name, &bad, &beside);
            }
        }
        for at in 0..beside.len() {
            let mut bad = beside.clone();
            bad[at] ^= 0x11;
            survives(name, &bytes, &bad);
        }
        for round in 0..300u64 {
            let mut bad = bytes.clone();
            let random = |i: u64| hash::nth(round, i);
            for i in 0..1 + random(0) % 8 {
                let at = (random(3 * i + 1) % bad.len() as u64) as usize;
                bad[at] = random(3 * i + 3) as u8;
            }
            survives(name, &bad, &beside);
        }
    }
}
