//! Pictures, and files that say where others lie.

use orograph::files::{Affine, Encoding, Reading, Units};

use super::{channel, floats, holds, integers, notes, read, try_read};

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
fn colour_pictures_are_read_as_heights_only_on_request() {
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
