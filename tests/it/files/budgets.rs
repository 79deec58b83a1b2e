//! Files that claim far more than they hold, read by the commands that take a height file: the header alone decides.

use std::path::Path;
use std::process::{Command, Output};

use super::tiffs::{Entry, tiff};

const SIDE: u32 = 32_768;
/// Bytes behind a header: enough that the claim is not refused as more than any compression can hold.
const BALLAST: usize = 1 << 21;

/// A TIFF of bytes, 32768 along a side, whose tiles are all left out.
fn sparse_tiff() -> Vec<u8> {
    let tiles = (SIDE / 512).pow(2);
    let mut out = tiff(
        &[],
        &[
            (256, Entry::Long(SIDE)),
            (257, Entry::Long(SIDE)),
            (258, Entry::Short(8)),
            (259, Entry::Short(8)),
            (262, Entry::Short(1)),
            (322, Entry::Short(512)),
            (323, Entry::Short(512)),
            (324, Entry::Elsewhere(tiles, 1024)),
            (325, Entry::Elsewhere(tiles, 1024 + 4 * tiles)),
        ],
    );
    out.resize(BALLAST, 0);
    out
}

fn png() -> Vec<u8> {
    let mut ihdr = b"IHDR".to_vec();
    ihdr.extend([SIDE.to_be_bytes(), SIDE.to_be_bytes()].concat());
    ihdr.extend([8, 0, 0, 0, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(&ihdr);
    let mut out = [&b"\x89PNG\r\n\x1a\n\0\0\0\x0d"[..], &ihdr, &crc.sum().to_be_bytes()].concat();
    out.extend([&(BALLAST as u32).to_be_bytes()[..], b"IDAT"].concat());
    out.resize(BALLAST, 0);
    out
}

fn exr() -> Vec<u8> {
    let mut out = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        out.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        out.extend([&(value.len() as u32).to_le_bytes()[..], value].concat());
    };
    let window: Vec<u8> = [0, 0, SIDE - 1, SIDE - 1].iter().flat_map(|v| v.to_le_bytes()).collect();
    let channel = [&b"Y\0"[..], &[2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0]].concat();
    attribute("channels", "chlist", &channel);
    attribute("compression", "compression", &[3]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    out.push(0);
    out.resize(BALLAST, 0);
    out
}

fn commands(folder: &Path, name: &str) -> Vec<Vec<String>> {
    let text = |name: &str| folder.join(name).to_string_lossy().into_owned();
    vec![
        vec!["info".into(), text(name)],
        vec!["convert".into(), text(name), text("out.r32")],
        vec!["render".into(), text(name), "-o".into(), text("out.png")],
    ]
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

#[test]
fn what_does_not_fit_the_budget_is_refused_by_its_header() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("a.tif", sparse_tiff()), ("a.png", png()), ("a.exr", exr())] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        for command in commands(folder.path(), name) {
            let mut program = Command::new(env!("CARGO_BIN_EXE_orograph"));
            let output = program.args(&command).args(["--memory", "300M"]).output().unwrap();
            let said = said(&output);
            assert_eq!(output.status.code(), Some(5), "{command:?}: {said}");
            let need = said.split("32768 x 32768 samples need ").nth(1).and_then(|t| t.split(' ').next());
            // The samples alone take 4096 MiB.
            let need: u64 = need.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{said}"));
            assert!(need >= 4096 && said.contains("--memory"), "{said}");
            assert!(said.trim_end().ends_with(name), "the file stands last: {said}");
        }
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "nothing is written: {left:?}");
}

/// Under a limit of the system that the budget knows nothing of, the program ends in order.
#[cfg(unix)]
#[test]
fn where_the_system_gives_no_memory_the_program_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("a.tif", sparse_tiff()), ("a.png", png()), ("a.exr", exr())] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        for command in commands(folder.path(), name) {
            let limited = "ulimit -v 3000000 && exec \"$0\" \"$@\"";
            let mut shell = Command::new("sh");
            shell.args(["-c", limited, env!("CARGO_BIN_EXE_orograph")]).args(&command);
            let output = shell.args(["--memory", "64G"]).output().unwrap();
            let said = said(&output);
            assert_eq!(output.status.code(), Some(5), "{command:?}: {said}");
            assert!(said.contains("bytes of memory, more than there are"), "{said}");
        }
    }
}

/// What fits is read, whatever stands beside it, and told in `info` with what was noticed.
#[test]
fn what_fits_is_read_with_its_notes() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_string_lossy().into_owned()
    };
    let mask = write("mask.tif", include_bytes!("fixtures/mask_inside_f32.tif"));
    let flt = write("gdal.flt", include_bytes!("fixtures/gdal.flt"));
    write("gdal.hdr", include_bytes!("fixtures/gdal.hdr"));
    write("gdal.prj", include_bytes!("fixtures/gdal.prj"));
    let layers = write("layers.exr", include_bytes!("fixtures/layers_f32.exr"));
    for (args, words) in [
        (vec!["info", &mask, "--memory", "100M"], &["voids     8", "note      a mask in the file"][..]),
        (vec!["info", &flt], &["21 x 13", "EPSG:32632"]),
        (vec!["info", &layers], &["ViewLayer.Depth.Z"]),
        (vec!["info", &layers, "--channel", "ViewLayer.Combined.A"], &["heights   1 to 1"]),
        (vec!["info", &layers, "--channel", "Z"], &["`ViewLayer.Depth.Z`"]),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_orograph")).args(&args).output().unwrap();
        let said = said(&output);
        assert!(words.iter().all(|w| said.contains(w)), "{args:?}: {said}");
    }
}
