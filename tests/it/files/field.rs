//! What files of the field say in ways that are easily read wrongly: flat seas, systems without a code, depths, marks of
//! voids that nobody declares, files of other programs beside them.

use orograph::files::{
    Affine, Fault, Format, HeightFile, Limits, Placement, ReadError, Reading, Units, Writing, encode_file,
    read_height,
};

use super::cases::try_read as try_read_as;
use super::tiffs::{self, Entry};
use crate::cli::{code, run, said, text};

fn try_read(name: &str, bytes: &[u8], beside: &[(&str, &[u8])]) -> Result<HeightFile, ReadError> {
    try_read_as(name, bytes, beside, &Reading::default())
}

/// Reads a file of which a person says what marks voids.
fn read_with_nodata(name: &str, bytes: &[u8], beside: &[(&str, &[u8])], nodata: f64) -> HeightFile {
    let reading = Reading { nodata: Some(nodata), ..Reading::default() };
    try_read_as(name, bytes, beside, &reading).unwrap_or_else(|e| panic!("{e}"))
}

fn read(name: &str, bytes: &[u8], beside: &[(&str, &[u8])]) -> HeightFile {
    try_read(name, bytes, beside).unwrap_or_else(|e| panic!("{e}"))
}

fn notes(file: &HeightFile) -> String {
    file.origin.notes.join("; ")
}

/// A TIFF of floats in one strip that is packed in some way, with more tags.
fn tiff(side: u16, compression: u16, strip: &[u8], more: &[(u16, Entry<'_>)]) -> Vec<u8> {
    let tags = tiffs::grey([u32::from(side); 2], (32, 3), compression, strip.len() as u32);
    tiffs::tiff(strip, &[&tags[..], more].concat())
}

/// A TIFF of plain floats.
fn floats(side: u16, f: impl Fn(usize) -> f32, more: &[(u16, Entry<'_>)]) -> Vec<u8> {
    let side_ = usize::from(side);
    let strip: Vec<u8> = (0..side_ * side_).flat_map(|k| f(k).to_le_bytes()).collect();
    tiff(side, 1, &strip, more)
}

/// Zeros as ZSTD packs them best: blocks of 128 KiB of one value.
fn zstd_zeros(bytes: usize) -> Vec<u8> {
    const BLOCK: usize = 1 << 17;
    // Magic number, a frame of unknown length, a window of 128 KiB.
    let mut out = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x38];
    for left in (1..=bytes / BLOCK).rev() {
        let head = ((BLOCK as u32) << 3) | 1 << 1 | u32::from(left == 1);
        out.extend(&head.to_le_bytes()[..3]);
        out.push(0);
    }
    out
}

/// A flat sea takes next to nothing, which is no reason to refuse it.
#[test]
fn flat_files_are_read_however_well_they_are_pressed() {
    let bytes = tiff(1024, 50000, &zstd_zeros(4 << 20), &[]);
    assert!(bytes.len() < 400, "{} bytes", bytes.len());
    assert_eq!(read("sea.tif", &bytes, &[]).range(), Some([0.0, 0.0]));
    let lzma = include_bytes!("fixtures/flat_lzma_f32.tif");
    assert_eq!(read("sea.tif", lzma, &[]).range(), Some([0.0, 0.0]));
}

/// The same length does not do where the compression cannot do as much.
#[test]
fn a_claim_is_held_against_its_own_compression() {
    for (compression, fits) in [(1u16, 1usize), (5, 2560), (8, 1032), (32773, 64)] {
        let strip = vec![0; (4 << 20) / fits - 1000];
        let error = try_read("a.tif", &tiff(1024, compression, &strip, &[]), &[]).expect_err("too much");
        assert!(matches!(error.fault, Fault::Overclaim { .. }), "compression {compression}: {error}");
    }
}

/// Geographic keys, each a code.
fn keys(keys: &[(u16, u16)]) -> Vec<u16> {
    let codes = keys.iter().flat_map(|(key, code)| [*key, 0, 1, *code]);
    [1, 1, 0, keys.len() as u16].into_iter().chain(codes).collect()
}

/// A hillside of 3 x 3 samples in some place.
fn placed(codes: &[(u16, u16)], step: [f64; 2], [x, y]: [f64; 2]) -> Vec<u8> {
    let codes = keys(codes);
    let (scale, tie) = ([step[0], step[1], 0.0], [0.0, 0.0, 0.0, x, y, 0.0]);
    let tags =
        [(33550, Entry::Doubles(&scale)), (33922, Entry::Doubles(&tie)), (34735, Entry::Shorts(&codes))];
    floats(3, |k| 100.0 + k as f32, &tags)
}

const STEP: [f64; 2] = [10.0, 20.0];
const CORNER: [f64; 2] = [1_000_000.0, 4_300_000.0];

#[test]
fn a_projected_system_has_not_the_code_of_its_base() {
    // Albers as a user defines it, on NAD83, in metres.
    let albers = [(1024, 1), (1025, 1), (2048, 4269), (3072, 32767), (3076, 9001)];
    let file = read("a.tif", &placed(&albers, STEP, CORNER), &[]);
    assert_eq!((file.placement.epsg, file.placement.units), (None, Units::Length(1.0)));
    assert!(notes(&file).contains("no EPSG code"), "{}", notes(&file));
    let globe = placed(&[(1024, 2), (2048, 4269)], [0.01; 2], [7.0, 45.0]);
    assert_eq!(read("a.tif", &globe, &[]).placement.epsg, Some(4269));
}

fn convert(file: &HeightFile, format: Format) -> (HeightFile, String) {
    let mut out = std::io::Cursor::new(Vec::new());
    let written = encode_file(file, &Writing::from(format), &mut out).expect("writes");
    let sidecar = written.sidecar.map(|j| j.to_string().into_bytes());
    let name = format!("a.{}", format.extension());
    let back = read_height(&name, &out.into_inner(), sidecar.as_deref(), &Limits::default()).expect("reads");
    (back, written.notes.join("; "))
}

/// What a format cannot say of a place is said in a note, and what it holds is read as it was meant.
#[test]
fn sizes_stay_as_they_are_in_formats_without_a_unit() {
    for (name, codes, step, corner) in [
        ("feet", &[(1024, 1), (3072, 2263)][..], STEP, CORNER),
        ("nameless feet", &[(1024, 1), (3072, 32767), (3076, 9003)], STEP, CORNER),
        ("mercator", &[(1024, 1), (3072, 3857)], STEP, CORNER),
        ("degrees", &[(1024, 2), (2048, 4326)], [0.25; 2], [7.0, 45.0]),
    ] {
        let file = read("a.tif", &placed(codes, step, corner), &[]);
        let want = file.placement.cell.expect("known");
        for format in Format::of_samples().filter(|f| *f != Format::Png8) {
            let (back, said) = convert(&file, format);
            let Some(got) = back.placement.cell else { panic!("{name} as {format}: no cell") };
            let near = (0..2).all(|k| (got[k] / want[k] - 1.0).abs() < 1e-9);
            assert!(near, "{name} as {format}: {got:?}, not {want:?}");
            let keeps = matches!(format, Format::Tiff | Format::Tiff16);
            assert!(keeps || !said.is_empty(), "{name} as {format}: nothing is said of the place");
        }
    }
    let own = read("a.tif", &placed(&[(1024, 1), (3072, 32633)], STEP, CORNER), &[]);
    let (back, said) = convert(&own, Format::R32);
    assert_eq!((back.placement.epsg, said.as_str()), (Some(32633), ""));
    let turned = Affine { origin: [0.0, 9.0], col: [8.0, 6.0], row: [6.0, -8.0] };
    let placement = Placement { affine: Some(turned), cell: Some([10.0; 2]), ..own.placement };
    let (_, said) = convert(&HeightFile { placement, ..own }, Format::R32);
    assert!(said.contains("turned"), "{said}");
}

#[test]
fn depths_are_turned_into_heights() {
    for (vertical, sign) in [(5715u16, -1.0), (5336, -1.0), (6357, -1.0), (5703, 1.0), (5773, 1.0)] {
        let codes = [(1024, 1), (3072, 32613), (4096, vertical)];
        let file = read("a.tif", &placed(&codes, STEP, CORNER), &[]);
        assert_eq!(file.data[8], sign * 108.0, "EPSG:{vertical}");
        assert_eq!(notes(&file).contains("depths"), sign < 0.0, "{}", notes(&file));
    }
    let feet = read("a.tif", &placed(&[(1024, 1), (3072, 32613), (4096, 8051)], STEP, CORNER), &[]);
    assert!((feet.data[0] + 30.48).abs() < 1e-4, "{}", feet.data[0]);
    // By its name, where it has no code.
    let codes = [1, 1, 0, 3, 1024, 0, 1, 1, 4096, 0, 1, 32767, 4097, 34737, 10, 0];
    let named = [(34735, Entry::Shorts(&codes[..])), (34737, Entry::Text("MSL depth|"))];
    let file = read("a.tif", &floats(3, |k| 100.0 + k as f32, &named), &[]);
    assert_eq!(file.data[0], -100.0);
    let prj: &[u8] =
        br#"PROJCS["x",UNIT["Meter",1.0]],VERTCS["x",PARAMETER["Direction",-1.0],UNIT["Meter",1.0]]"#;
    let text: &[u8] = b"ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 10\n5 6\n";
    let hdr: &[u8] =
        b"ncols 2\nnrows 1\nnbits 8\npixeltype unsignedint\nxdim 10\nydim 10\nulxmap 0\nulymap 0\n";
    let world: &[u8] = b"10\n0\n0\n-10\n5\n5\n";
    let plain = floats(3, |k| k as f32 + 5.0, &[]);
    for file in [
        read("a.asc", text, &[("a.prj", prj)]),
        read("a.bil", &[5, 6], &[("a.hdr", hdr), ("a.prj", prj)]),
        read("a.xyz", b"0 0 5\n10 0 6\n", &[("a.prj", prj)]),
        read("a.tif", &plain, &[("a.tfw", world), ("a.prj", prj)]),
    ] {
        assert_eq!(file.data[..2], [-5.0, -6.0], "{:?}", file.origin.format);
        let said = notes(&file);
        assert_eq!(said.matches("counts depths downwards").count(), 1, "{:?}: {said}", file.origin.format);
    }
}

#[test]
fn numbers_that_look_like_voids_earn_a_note() {
    for code in [1e20f32, -99999.9, -999.0, 32767.0, 1e10] {
        let bytes = floats(9, |k| if k % 5 == 4 { code } else { 200.0 + 7.0 * k as f32 }, &[]);
        let file = read("a.tif", &bytes, &[]);
        assert!(notes(&file).contains("would make voids"), "{code}: {}", notes(&file));
        let file = read_with_nodata("a.tif", &bytes, &[], f64::from(code));
        assert_eq!((file.voids(), notes(&file).as_str()), (16, ""), "{code}");
        let other = read_with_nodata("a.tif", &bytes, &[], 200.0);
        assert!(
            other.voids() == 1 && notes(&other).contains("would make voids"),
            "{code}: {}",
            notes(&other)
        );
    }
    let plain = read("a.tif", &floats(9, |k| 200.0 + 7.0 * k as f32, &[]), &[]);
    assert_eq!(notes(&plain), "");
}

/// A grey PNG of 16 bits.
fn png(side: u32, f: impl Fn(usize) -> u16) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let data: Vec<u8> = (0..side as usize * side as usize).flat_map(|k| f(k).to_be_bytes()).collect();
    encoder.write_header().and_then(|mut w| w.write_image_data(&data)).expect("writes");
    out
}

#[test]
fn units_of_a_sidecar_are_read_and_a_scale_alone_is_none() {
    let bytes = png(4, |k| if k == 15 { 65535 } else { 0 });
    let with = |json: &str| read("a.png", &bytes, &[("a.json", json.as_bytes())]);
    let feet = with(r#"{"orograph": 1, "file": "a.png", "unit": "ft", "range": [0, 1000]}"#);
    assert!((feet.data[15] - 304.8).abs() < 1e-3 && feet.metres, "{}", feet.data[15]);
    assert!(notes(&feet).contains("ft"), "{}", notes(&feet));
    assert_eq!(with(r#"{"orograph": 1, "unit": "m", "range": [0, 1000]}"#).data[15], 1000.0);
    let odd = with(r#"{"unit": "furlong", "range": [0, 1000]}"#);
    assert!(odd.data[15] == 1000.0 && notes(&odd).contains("furlong"), "{}", notes(&odd));
    let foreign = with(r#"{"name": "hero", "scale": 2}"#);
    assert!(!foreign.metres && foreign.data[15] == 65535.0, "{}", foreign.data[15]);
    assert!(notes(&foreign).contains("says nothing of heights"), "{}", notes(&foreign));
}

#[test]
fn a_json_of_others_beside_a_raw_file_is_no_error() {
    let bytes: Vec<u8> = (0..9u16).flat_map(u16::to_le_bytes).collect();
    let json = br#"{"width": 5000, "height": 1288, "name": "x"}"#;
    let file = read("a.raw", &bytes, &[("a.json", json)]);
    assert_eq!((file.cols, file.rows), (3, 3));
    assert!(notes(&file).contains("5000 x 1288"), "{}", notes(&file));
    let ours = br#"{"orograph": 1, "file": "a.raw", "cols": 5000, "rows": 1288}"#;
    assert!(try_read("a.raw", &bytes, &[("a.json", ours)]).is_err());
}

#[test]
fn what_gdal_writes_beside_a_file_is_read_or_named() {
    let bytes = floats(3, |k| if k == 4 { -9999.0 } else { 100.0 }, &[]);
    let aux = br#"<PAMDataset><PAMRasterBand band="1"><NoDataValue>-9999</NoDataValue><UnitType>ft</UnitType>
        </PAMRasterBand></PAMDataset>"#;
    let file = read("d/a.tif", &bytes, &[("d/a.tif.aux.xml", aux)]);
    assert_eq!((file.voids(), file.origin.nodata), (1, Some(-9999.0)));
    assert!((file.data[0] - 30.48).abs() < 1e-4, "{}", file.data[0]);
    let broken = read("d/a.tif", &bytes, &[("d/a.tif.aux.xml", b"<a></b>")]);
    assert!(notes(&broken).contains("not understood"), "{}", notes(&broken));
    for name in ["d/a.wld", "d/a.tifw", "d/a.tfw"] {
        let world: &[u8] = b"30\n0\n0\n-30\n500015\n3999985\n";
        let file = read("d/a.tif", &bytes, &[(name, world)]);
        assert_eq!(file.placement.cell, Some([30.0, 30.0]), "{name}");
    }
}

/// A person's number stands beside the one that the file, its sidecar or its `.aux.xml` names, in all formats.
#[test]
fn a_number_of_ones_own_marks_voids_as_well() {
    let bytes = floats(3, |k| [100.0, -9999.0, 0.0][k.min(2)], &[]);
    let aux: &[u8] = br#"<PAMDataset><PAMRasterBand band="1"><NoDataValue>-9999</NoDataValue></PAMRasterBand></PAMDataset>"#;
    let file = read_with_nodata("a.tif", &bytes, &[("a.tif.aux.xml", aux)], 0.0);
    assert_eq!((file.voids(), file.origin.nodata), (8, Some(-9999.0)), "{}", notes(&file));
    assert!(notes(&file).contains("-9999 marks voids"), "{}", notes(&file));
    let alone = read_with_nodata("a.tif", &bytes, &[], 0.0);
    assert_eq!((alone.voids(), alone.origin.nodata), (7, Some(0.0)));
    let side = br#"{"orograph": 1, "file": "a.png", "nodata": 3}"#;
    let file = read_with_nodata("a.png", &png(4, |k| k as u16), &[("a.json", side)], 7.0);
    assert_eq!((file.voids(), file.origin.nodata), (2, Some(3.0)));
    // The number is that of the file, before any scale, and what is scaled is not struck by it.
    let mut terragen = b"TERRAGENTERRAIN XPTS\x02\0\0\0YPTS\x01\0\0\0ALTW\0\x08\0\0".to_vec();
    terragen.extend([5i16, 160].iter().flat_map(|v| v.to_le_bytes()));
    let all = read("a.ter", &terragen, &[]);
    assert!((all.data[1] - 150.0).abs() < 1e-3, "{:?}", all.data);
    let file = read_with_nodata("a.ter", &terragen, &[], 5.0);
    assert!(file.data[0].is_nan() && file.data[1] == all.data[1], "{:?}", file.data);
    assert_eq!(read_with_nodata("a.ter", &terragen, &[], 150.0).voids(), 0);
}

/// A mask of 3 x 3 samples that is 0 in the first row.
fn mask(bits: u16, strip: &[u8], side: u32) -> Vec<u8> {
    tiffs::tiff(strip, &tiffs::grey([side; 2], (bits, 1), 1, strip.len() as u32))
}

#[test]
fn a_mask_beside_a_file_makes_voids() {
    let rows = |file: &HeightFile| [0, 3, 6].map(|k| file.data[k].is_nan());
    let bytes = floats(3, |k| k as f32, &[]);
    let bytewise = mask(8, &[0, 0, 0, 255, 255, 255, 255, 1, 255], 3);
    for msk in [&bytewise[..], &mask(1, &[0, 0xe0, 0xe0], 3)] {
        let file = read("d/a.tif", &bytes, &[("d/a.tif.msk", msk)]);
        assert_eq!((file.voids(), rows(&file)), (3, [true, false, false]), "{}", notes(&file));
        assert!(notes(&file).contains("a mask beside it"), "{}", notes(&file));
    }
    // The rows of a mask are those of the file, whichever way they run.
    let south = [(33550, Entry::Doubles(&[10.0, -10.0, 0.0])), (33922, Entry::Doubles(&[0.0; 6]))];
    let turned = read("a.tif", &floats(3, |k| k as f32, &south), &[("a.tif.msk", &bytewise)]);
    assert_eq!(rows(&turned), [false, false, true], "{}", notes(&turned));
    let raw: Vec<u8> = (0..9u16).flat_map(u16::to_le_bytes).collect();
    assert_eq!(read("a.r16", &raw, &[("a.r16.msk", &bytewise)]).voids(), 3);
    // What is no such mask is named, and changes nothing.
    let strip = vec![0; 16];
    let wide = [tiffs::grey([3; 2], (8, 1), 1, 9), vec![(322, Entry::Long(1 << 30)), (323, Entry::Long(1))]]
        .concat();
    let wide = tiffs::tiff(&strip, &[wide, vec![(324, Entry::Long(8)), (325, Entry::Long(9))]].concat());
    for msk in [&b"II*\0"[..], &mask(8, &strip, 4), &mask(8, &strip[..5], 3), &wide] {
        let file = read("d/a.tif", &bytes, &[("d/a.tif.msk", msk)]);
        assert!(file.voids() == 0 && notes(&file).contains("is not read"), "{}", notes(&file));
    }
}

#[test]
fn integers_without_a_pixel_type_have_no_sign() {
    let bytes: Vec<u8> = [1u16, 65000, 3, 4].iter().flat_map(|v| v.to_le_bytes()).collect();
    let with = |more: &str| {
        let hdr = format!("NROWS 2\nNCOLS 2\nNBITS 16\nBYTEORDER I\n{more}");
        read("a.bil", &bytes, &[("a.hdr", hdr.as_bytes())])
    };
    let file = with("");
    assert_eq!((file.data[1], file.origin.sample), (65000.0, "u16"));
    assert!(notes(&file).contains("pixeltype"), "{}", notes(&file));
    assert_eq!(with("PIXELTYPE SIGNEDINT\n").data[1], -536.0);
    assert_eq!(with("NODATA -9999\n").data[1], -536.0);
    for name in ["a.blw", "a.bilw", "a.BLW"] {
        let world: &[u8] = b"30\n0\n0\n-30\n500015\n3999985\n";
        let hdr: &[u8] = b"NROWS 2\nNCOLS 2\nNBITS 16\nPIXELTYPE UNSIGNEDINT\n";
        let file = read("a.bil", &bytes, &[("a.hdr", hdr), (name, world)]);
        assert_eq!(
            file.placement.affine,
            Some(Affine::upright([500_015.0, 3_999_985.0], [30.0; 2])),
            "{name}"
        );
        // The word of the header goes first.
        let hdr = [hdr, b"XDIM 5\nYDIM 5\nULXMAP 0\nULYMAP 0\n"].concat();
        let file = read("a.bil", &bytes, &[("a.hdr", &hdr), (name, world)]);
        assert_eq!(file.placement.cell, Some([5.0; 2]), "{name}");
    }
    let floats: Vec<u8> = [1f32; 4].iter().flat_map(|v| v.to_le_bytes()).collect();
    let hdr = b"ncols 2\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ndx 10\ndy 20\nbyteorder LSBFIRST\n";
    let file = read("a.flt", &floats, &[("a.hdr", hdr)]);
    assert_eq!(file.placement.cell, Some([10.0, 20.0]));
}

#[test]
fn places_that_cannot_be_are_named() {
    let text: &[u8] = b"ncols 2\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ncellsize 10\n1 2\n3 4\n";
    let prj: &[u8] = br#"GEOGCS["GCS_WGS_1984",UNIT["Degree",0.0174532925199433]]"#;
    let file = read("a.asc", text, &[("a.prj", prj)]);
    assert_eq!(file.placement.cell, None);
    assert!(notes(&file).contains("no place on the globe"), "{}", notes(&file));
    // What is written in place of the cell is said to be nothing but that.
    for unknown in [&file, &read("a.png", &png(4, |k| k as u16), &[])] {
        let (back, said) = convert(unknown, Format::Asc);
        assert_eq!(back.placement.cell, Some([1.0; 2]));
        assert!(said.contains("is not known") && !said.contains("on the ground"), "{said}");
    }
    let twice = read("a.xyz", b"0 0 100\n10 0 110\n0 10 120\n10 10 130\n0 0 1\n", &[]);
    assert!(notes(&twice).contains("line 5"), "{}", notes(&twice));
    let far = try_read("a.xyz", b"0 0 1\n1e-9 0 1\n0 1e-9 1\n1e15 1e15 5\n", &[]).expect_err("too many");
    assert!(far.to_string().contains("claims"), "{far}");
    let two = try_read("a.asc", b"ncols 2\nnrows 1\ncellsize 10 20\n1 2\n", &[]).expect_err("two numbers");
    assert!(two.to_string().contains("`cellsize` takes one number"), "{two}");
}

#[test]
fn bands_and_channels_are_named_as_they_are() {
    let reading = Reading { channel: Some("7".into()), ..Reading::default() };
    let bytes = floats(3, |k| k as f32, &[]);
    let error = try_read_as("a.tif", &bytes, &[], &reading).expect_err("there is one").to_string();
    assert!(error.contains("asks for \"7\"; there is band 1"), "{error}");
}

/// Voids cannot go where nothing marks them; the advice names what helps.
#[test]
fn the_advice_on_voids_names_other_formats() {
    let bytes = floats(3, |k| if k == 4 { f32::NAN } else { k as f32 + 0.5 }, &[]);
    let file = read("a.tif", &bytes, &[]);
    for format in [Format::Tiff16, Format::Png16, Format::R16] {
        let writing = Writing { range: Some([0.0, 9.0]), ..Writing::from(format) };
        let error = encode_file(&file, &writing, &mut std::io::Cursor::new(Vec::new())).expect_err("voids");
        let error = error.to_string();
        let (_, advice) = error.split_once("; ").expect("advice");
        assert!(advice.contains("--fill") && !advice.contains(&format!("{format} ")), "{error}");
    }
}

#[test]
fn convert_fills_voids_and_names_what_it_cannot_write() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    std::fs::write(path("a.tif"), include_bytes!("fixtures/nodata_f32.tif")).unwrap();
    let (from, to) = (path("a.tif"), path("b.r16"));
    let refused = run(&["convert", &from, &to]);
    assert!(code(&refused) == 1 && said(&refused).contains("--fill"), "{}", said(&refused));
    assert!(said(&refused).contains("b.r16"), "{}", said(&refused));
    let filled = run(&["convert", &from, &to, "--fill"]);
    assert_eq!(code(&filled), 0, "{}", said(&filled));
    let fixed = path("c.asc");
    std::fs::write(&fixed, "").unwrap();
    let mut rights = std::fs::metadata(&fixed).unwrap().permissions();
    rights.set_readonly(true);
    std::fs::set_permissions(&fixed, rights).unwrap();
    let refused = run(&["convert", &from, &fixed, "--overwrite"]);
    assert!(code(&refused) == 1 && said(&refused).contains("c.asc"), "{}", said(&refused));
}

#[test]
fn what_is_too_long_to_stand_beside_a_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    std::fs::write(path("a.png"), png(4, |k| k as u16)).unwrap();
    std::fs::write(path("a.json"), format!("{{\"range\": [0, 1], \"x\": \"{}\"}}", "x".repeat(70_000)))
        .unwrap();
    let told = run(&["info", &path("a.png")]);
    assert!(said(&told).contains("`a.json` is not read: it has 700"), "{}", said(&told));
}

#[test]
fn the_byte_order_of_floats_is_told_by_what_heights_are() {
    let heights = (0..400).map(|k| 1000.0 + 4.9 * k as f32);
    let little: Vec<u8> = heights.clone().flat_map(f32::to_le_bytes).collect();
    let file = read("a.r32", &little, &[]);
    assert!(!notes(&file).contains("byte_order"), "{}", notes(&file));
    let big: Vec<u8> = heights.flat_map(f32::to_be_bytes).collect();
    let file = read("a.r32", &big, &[]);
    assert!(notes(&file).contains("`byte_order` big would say so"), "{}", notes(&file));
}

#[test]
fn words_of_a_header_that_are_not_known_are_refused() {
    let bytes = [7u8; 8];
    let with = |more: &str| {
        let hdr = format!("NROWS 2\nNCOLS 2\nNBITS 16\n{more}\n");
        try_read("a.bil", &bytes, &[("a.hdr", hdr.as_bytes())])
    };
    for word in ["byteorder X", "byteorder VMS_FFLOAT", "pixeltype FOO", "layout FOO"] {
        let error = with(word).expect_err(word).to_string();
        assert!(error.contains(word), "{word}: {error}");
    }
    let file = with("NODATA zz").expect("reads");
    assert!(notes(&file).contains("\"zz\", is no number"), "{}", notes(&file));
}

#[test]
fn a_second_mark_of_voids_earns_a_note() {
    let grid = b"ncols 3\nnrows 2\ncellsize 10\nNODATA_value -9999\n-32768 120 130\n-32768 125 -9999\n";
    let file = read("a.asc", grid, &[]);
    assert_eq!(file.voids(), 1);
    assert!(notes(&file).contains("2 samples are -32768"), "{}", notes(&file));
}
