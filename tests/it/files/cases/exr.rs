//! OpenEXR: channels, parts and windows.

use orograph::files::Reading;

use super::{ROWS, channel, floats, holds, notes, read, try_read};

#[test]
fn exr_channel_of_heights_is_found_or_asked_for() {
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
fn exr_channel_names_choose_the_heights_or_are_listed() {
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
fn exr_windows_leave_voids_and_cut() {
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
