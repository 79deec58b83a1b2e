//! SRTM tiles, text grids, points, float maps and Terragen.

use orograph::files::{Affine, Anchor, Reading};

use super::{COLS, ROWS, channel, floats, holds, read, try_read};

fn hgt(cols: usize, rows: usize) -> Vec<u8> {
    (0..cols * rows).flat_map(|k| (100 + (k / cols / 40) as i16).to_be_bytes()).collect()
}

#[test]
fn hgt_tiles_of_high_latitudes_are_read() {
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
fn text_grids_have_many_words_for_voids() {
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

#[test]
fn points_in_any_order_are_a_grid() {
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
