//! TIFF: masks, alpha, compressions, units, overviews.

use orograph::files::{Fault, Units};

use super::{COLS, channel, floats, holds, integers, moved, notes, outside_the_hole, read, try_read};

#[test]
fn tiff_masks_and_alpha_make_voids() {
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
fn tiff_and_exr_levels_are_read_at_the_finest() {
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
