//! What is written comes back, and other programs' readers see the same.

use std::io::Cursor;

use orograph::files::{
    Affine, Anchor, Format, HeightFile, Limits, Target, Tile, Units, WriteError, WriteJob, Writing, encode,
    encode_file, read_height,
};
use orograph::kit::hash;
use orograph::value::{Colors, Field, Geo, Quantity, Terrain, Value, Vectors};

use super::{grid, heights, job, there_and_back, write};

const SIZES: [(usize, usize); 7] = [(1, 1), (1, 7), (7, 1), (3, 5), (17, 16), (257, 129), (700, 301)];

fn rough(k: usize) -> f32 {
    match k % 23 {
        0 => 1e-30,
        1 => -3.4e29,
        2 => 0.0,
        3 => f32::MIN_POSITIVE,
        4 => 8848.86,
        _ => (hash::unit(1, k as u64) * 4000.0 - 500.0) as f32,
    }
}

fn bits(data: &[f32]) -> Vec<u32> {
    data.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn floats_come_back_to_the_bit() {
    let terrain = Terrain::default();
    for (cols, rows) in SIZES {
        let value = heights(cols, rows, rough);
        for format in [Format::Tiff, Format::Exr, Format::R32, Format::Asc] {
            let back = there_and_back(&job(&value, format, &terrain));
            assert_eq!((back.cols, back.rows), (cols, rows), "{format}");
            assert!(bits(&back.data) == bits(value.components()), "{format} {cols} x {rows}");
            assert!(back.metres, "{format}");
        }
    }
}

#[test]
fn integers_come_back_to_the_step() {
    let terrain = Terrain::default();
    let range = [-100.0, 1548.3];
    for (format, levels) in
        [(Format::Png16, 65535.0), (Format::R16, 65535.0), (Format::Tiff16, 65535.0), (Format::Png8, 255.0)]
    {
        let step = (range[1] - range[0]) / levels;
        for (cols, rows) in SIZES {
            let level = |k: usize| (hash::nth(2, k as u64) % (levels as u64 + 1)) as f64;
            let value = heights(cols, rows, |k| (range[0] + level(k) * step) as f32);
            let back =
                there_and_back(&job(&value, Writing { range: Some(range), ..format.into() }, &terrain));
            assert_eq!((back.cols, back.rows), (cols, rows));
            assert!(back.metres);
            for (k, (a, b)) in back.data.iter().zip(value.components()).enumerate() {
                assert!((a - b).abs() <= 2e-4, "{format} {cols} x {rows} at {k}: {a}, not {b}");
            }
        }
    }
}

#[test]
fn whole_metres_need_no_range_in_tiff16() {
    let value = heights(33, 21, |k| (hash::nth(4, k as u64) % 9000) as f32 - 400.0);
    let back = there_and_back(&job(&value, Format::Tiff16, &Terrain::default()));
    assert!(back.data == value.components());
    assert_eq!(back.origin.sample, "i16");
}

#[test]
fn other_readers_see_the_same() {
    let terrain = Terrain::default();
    let (cols, rows) = (129, 77);
    let value = heights(cols, rows, |k| (hash::nth(6, k as u64) % 5000) as f32 / 4.0 + (k / cols) as f32);
    let (bytes, _) = write(&job(&value, Format::Tiff, &terrain));
    let mut decoder = ::tiff::decoder::Decoder::new(Cursor::new(bytes)).expect("opens");
    match decoder.read_image().expect("decodes") {
        ::tiff::decoder::DecodingResult::F32(data) => assert!(data == value.components()),
        other => panic!("{other:?}"),
    }
    let ranged = Writing { range: Some([0.0, 65535.0]), ..Format::Png16.into() };
    let (bytes, _) = write(&job(&value, ranged, &terrain));
    let mut reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().expect("opens");
    let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
    reader.next_frame(&mut pixels).expect("decodes");
    for (p, v) in pixels.chunks_exact(2).zip(value.components()) {
        assert_eq!(u16::from_be_bytes([p[0], p[1]]), (v + 0.5).floor() as u16);
    }
    let (bytes, _) = write(&job(&value, Format::Exr, &terrain));
    let back = read_height("a.exr", &bytes, None, &Limits::default()).expect("reads");
    assert!(back.data == value.components());
}

#[test]
fn pictures_hold_colours() {
    use exr::prelude::{ReadChannels, ReadLayers};
    let (cols, rows) = (21, 9);
    let pixel = |k: usize| [0u64, 1, 2].map(|c| (hash::nth(9, k as u64 * 3 + c) % 256) as f32 / 255.0);
    let colors = Colors::new(grid(cols, rows, 1.0), Quantity::Color, (0..cols * rows).map(pixel).collect());
    let (value, terrain) = (Value::Colors(colors.clone()), Terrain::default());
    let (bytes, sidecar) = write(&job(&value, Format::Png8, &terrain));
    assert!(sidecar.is_none(), "a picture needs no sidecar");
    let mut reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().expect("opens");
    assert_eq!(reader.output_color_type(), (::png::ColorType::Rgb, ::png::BitDepth::Eight));
    let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
    reader.next_frame(&mut pixels).expect("decodes");
    let want: Vec<u8> = value.components().iter().map(|v| (v * 255.0).round() as u8).collect();
    assert!(pixels == want);
    let (bytes, _) = write(&job(&value, Format::Tiff, &terrain));
    let mut decoder = ::tiff::decoder::Decoder::new(Cursor::new(bytes)).expect("opens");
    assert_eq!(decoder.colortype().expect("has one"), ::tiff::ColorType::RGB(32));
    match decoder.read_image().expect("decodes") {
        ::tiff::decoder::DecodingResult::F32(data) => assert!(data == value.components()),
        other => panic!("{other:?}"),
    }
    let (bytes, _) = write(&job(&value, Format::Exr, &terrain));
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image =
        image.first_valid_layer().all_attributes().from_buffered(Cursor::new(bytes)).expect("decodes");
    let names: Vec<_> = image.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R"]);
    let red: Vec<f32> = image.layer_data.channel_data.list[2].sample_data.values_as_f32().collect();
    for (got, p) in red.iter().zip(colors.data()) {
        // IEC 61966-2-1: 0.5 is 0.2140 of the light, and so on; here against the inverse.
        let back =
            if *got <= 0.003_130_8 { got * 12.92 } else { 1.055 * libm::powf(*got, 1.0 / 2.4) - 0.055 };
        assert!((back - p[0]).abs() < 1e-5);
    }
}

#[test]
fn vectors_go_into_floats_only() {
    let data = (0..12).map(|k| [k as f32, -(k as f32)]).collect();
    let value = Value::Vectors(Vectors::new(grid(4, 3, 1.0), Quantity::Vector, data));
    let terrain = Terrain::default();
    let (bytes, _) = write(&job(&value, Format::Tiff, &terrain));
    let mut decoder = ::tiff::decoder::Decoder::new(Cursor::new(bytes)).expect("opens");
    match decoder.read_image().expect("decodes") {
        ::tiff::decoder::DecodingResult::F32(data) => assert!(data == value.components()),
        other => panic!("{other:?}"),
    }
    for format in [Format::Png8, Format::Png16, Format::R16, Format::R32, Format::Asc, Format::Tiff16] {
        let error = encode(&job(&value, format, &terrain), &mut Cursor::new(Vec::new())).expect_err("cannot");
        assert!(matches!(error, WriteError::Unfit { .. }), "{format}: {error}");
    }
}

#[test]
fn masks_have_their_range_and_heights_need_one() {
    let terrain = Terrain::default();
    let mask = Value::Field(Field::new(grid(5, 1, 1.0), Quantity::Mask, vec![0.0, 0.25, 0.5, 1.0, 1.0]));
    let back = there_and_back(&job(&mask, Format::Png16, &terrain));
    assert_eq!((back.data[0], back.data[3]), (0.0, 1.0));
    let value = heights(4, 4, |k| k as f32);
    for format in [Format::Png8, Format::Png16, Format::R16] {
        let error =
            encode(&job(&value, format, &terrain), &mut Cursor::new(Vec::new())).expect_err("no range");
        assert!(error.to_string().contains("needs a range"), "{error}");
    }
}

#[test]
fn clipping_is_an_error_unless_allowed() {
    let terrain = Terrain::default();
    let value = heights(10, 10, |k| k as f32);
    let strict = Writing { range: Some([10.0, 90.0]), ..Format::Png16.into() };
    let mut out = Cursor::new(Vec::new());
    let error = encode(&job(&value, strict, &terrain), &mut out).expect_err("19 are outside");
    assert!(error.to_string().contains("19 of 100"), "{error}");
    assert!(out.into_inner().is_empty(), "nothing is written before the check");
    let lax = job(&value, Writing { clip: true, ..strict }, &terrain);
    assert_eq!(encode(&lax, &mut Cursor::new(Vec::new())).expect("writes").clipped, 19);
    let back = there_and_back(&lax);
    assert_eq!((back.data[0], back.data[99]), (10.0, 90.0));
}

#[test]
fn the_place_is_written_and_read() {
    let geo = Geo { epsg: 32611, east: 380_000.0, north: 3_800_000.0 };
    let terrain = Terrain { origin: [100.0, 200.0], geo: Some(geo), ..Terrain::default() };
    let mut at = grid(9, 6, 10.0);
    (at.col, at.row) = (30, 50);
    let value = Value::Field(Field::new(at, Quantity::Elevation, (0..54).map(|k| k as f32).collect()));
    // Sample (30, 50) stands at (300, 500), 200 m east and 300 m south of the terrain's corner.
    let north_west = [380_200.0, 3_799_700.0];
    for format in [Format::Tiff, Format::R32, Format::Asc] {
        let place = there_and_back(&job(&value, format, &terrain)).placement;
        assert_eq!(place.affine, Some(Affine::upright(north_west, [10.0, 10.0])), "{format}");
        assert_eq!(place.cell, Some([10.0, 10.0]), "{format}");
        let known = if format == Format::Asc { None } else { Some(32611) };
        assert_eq!((place.epsg, place.anchor), (known, Anchor::Point), "{format}");
    }
    let nowhere = Terrain { geo: None, ..terrain };
    let place = there_and_back(&job(&value, Format::Tiff, &nowhere)).placement;
    assert_eq!(place.affine, Some(Affine::upright([300.0, -500.0], [10.0, 10.0])));
    assert_eq!((place.epsg, place.units), (None, Units::Length(1.0)));
}

#[test]
fn sidecars_tell_range_sea_grid_and_tile() {
    let terrain = Terrain { sea_level: Some(12.5), ..Terrain::default() };
    let mut at = grid(5, 4, 10.0);
    (at.col, at.row) = (4, 8);
    let value = Value::Field(Field::new(at, Quantity::Elevation, vec![7.0; 20]));
    let tile = Tile { col: 1, row: 2, cols: 3, rows: 3 };
    let writing = Writing { range: Some([-256.0, 1792.0]), ..Format::R16.into() };
    let whole = grid(13, 13, 10.0);
    let (_, sidecar) = write(&WriteJob { tile: Some(tile), whole, ..job(&value, writing, &terrain) });
    let json: serde_json::Value = serde_json::from_slice(&sidecar.expect("r16 has one")).expect("parses");
    for (pointer, want) in [
        ("/cols", serde_json::json!(5)),
        ("/rows", serde_json::json!(4)),
        ("/range", serde_json::json!([-256.0, 1792.0])),
        ("/unit", serde_json::json!("m")),
        ("/cell", serde_json::json!(10.0)),
        ("/sea_level", serde_json::json!(12.5)),
        ("/grid/col", serde_json::json!(4)),
        ("/grid/whole_cols", serde_json::json!(13)),
        ("/tile/row", serde_json::json!(2)),
        ("/rows_from", serde_json::json!("north")),
    ] {
        assert_eq!(json.pointer(pointer), Some(&want), "{pointer} of {json}");
    }
}

#[test]
fn unity_gets_its_rows_upside_down() {
    let terrain = Terrain::default();
    let value = heights(33, 33, |k| (k / 33) as f32);
    let writing = Writing {
        range: Some([0.0, 65535.0]),
        flip: Target::Unity.flip(),
        target: Some(Target::Unity),
        ..Target::Unity.format().into()
    };
    let unity = job(&value, writing, &terrain);
    let (bytes, _) = write(&unity);
    assert_eq!(bytes[..4], [32, 0, 32, 0], "the southernmost row comes first");
    assert!(there_and_back(&unity).data == value.components(), "and is turned back on reading");
    let notes = encode(&unity, &mut Cursor::new(Vec::new())).expect("writes").notes;
    assert_eq!(notes.len(), 1, "33 is a size that Unity takes: {notes:?}");
    assert!(notes[0].contains("Y = 65535"), "{notes:?}");
}

#[test]
fn unreal_takes_32768_for_zero() {
    let terrain = Terrain::default();
    let value = heights(505, 505, |k| if k == 0 { 0.0 } else { (k % 700) as f32 - 100.0 });
    let range = Target::Unreal.range([-100.0, 599.0]);
    let writing =
        Writing { range: Some(range), target: Some(Target::Unreal), ..Target::Unreal.format().into() };
    let unreal = job(&value, writing, &terrain);
    let (bytes, _) = write(&unreal);
    let plain = read_height("a.png", &bytes, None, &Limits::default()).expect("reads");
    assert_eq!(plain.data[0], 32768.0);
    let notes = encode(&unreal, &mut Cursor::new(Vec::new())).expect("writes").notes;
    assert!(notes.len() == 1 && notes[0].contains("location Z = 0"), "{notes:?}");
    let small = heights(500, 505, |_| 1.0);
    let odd = job(&small, Writing { format: Format::R16, ..writing }, &terrain);
    let notes = encode(&odd, &mut Cursor::new(Vec::new())).expect("writes").notes;
    assert!(notes[0].contains("500 x 505"), "{notes:?}");
}

fn convert(file: &HeightFile, format: Format) -> HeightFile {
    let mut out = Cursor::new(Vec::new());
    let written = encode_file(file, &format.into(), &mut out).expect("writes");
    let sidecar = written.sidecar.map(|j| j.to_string().into_bytes());
    let name = format!("b.{}", format.extension());
    read_height(&name, &out.into_inner(), sidecar.as_deref(), &Limits::default()).expect("reads")
}

#[test]
fn converting_keeps_numbers_place_and_voids() {
    let open = |name: &str, bytes: &[u8]| read_height(name, bytes, None, &Limits::default()).expect("reads");
    let voids = open("v.tif", include_bytes!("fixtures/nodata_f32.tif"));
    for format in [Format::Tiff, Format::Asc, Format::R32, Format::Exr] {
        let back = convert(&voids, format);
        assert!(back.data.iter().map(|v| v.is_nan()).eq(voids.data.iter().map(|v| v.is_nan())), "{format}");
        assert!(back.data.iter().zip(&voids.data).all(|(a, b)| a == b || a.is_nan()), "{format}");
    }
    assert_eq!(convert(&voids, Format::Tiff).origin.nodata, Some(-9999.0));
    assert_eq!(convert(&voids, Format::Asc).origin.nodata, Some(-9999.0));
    let refused = encode_file(&voids, &Format::Png16.into(), &mut Cursor::new(Vec::new()));
    assert!(refused.expect_err("voids").to_string().contains("voids"));
    for (name, bytes) in [
        ("degrees", &include_bytes!("fixtures/degrees_f32.tif")[..]),
        ("point", include_bytes!("fixtures/point_f32.tif")),
        ("turned", include_bytes!("fixtures/turned_f32.tif")),
    ] {
        let file = open("p.tif", bytes);
        let back = convert(&file, Format::Tiff).placement;
        assert_eq!(
            (back.epsg, back.anchor, back.units),
            (file.placement.epsg, file.placement.anchor, file.placement.units)
        );
        let (a, b) = (file.placement.affine.expect("has one"), back.affine.expect("kept"));
        for (i, j) in [(0.0, 0.0), (20.0, 12.0)] {
            let d = [0, 1].map(|k| (a.at(i, j)[k] - b.at(i, j)[k]).abs());
            assert!(d[0] < 1e-8 && d[1] < 1e-8, "{name}: off by {d:?}");
        }
    }
    let whole = open("i.tif", include_bytes!("fixtures/tiled_lzw_p2_i16.tif"));
    for format in [Format::Tiff16, Format::Png16, Format::R16, Format::Tiff] {
        assert!(convert(&whole, format).data == whole.data, "{format}");
    }
}
