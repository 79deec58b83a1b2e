//! Height files by strangers: what a header claims is never taken on its word.

use std::process::Command;

use orograph::kit::hash;
use serde_json::json;

use super::{Desk, ended, run, some_of, text};
use crate::files::tiffs::{grey, tiff};

/// A TIFF of one strip that claims a size and has next to nothing to show for it.
fn claiming_tiff(side: u32, compression: u16) -> Vec<u8> {
    tiff(&[0; 128], &grey([side; 2], (8, 1), compression, 64))
}

fn png(side: u32, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8], body: &[u8]| {
        out.extend((body.len() as u32).to_be_bytes());
        let mut crc = flate2::Crc::new();
        crc.update(name);
        crc.update(body);
        out.extend(name.iter().chain(body));
        out.extend(crc.sum().to_be_bytes());
    };
    let mut head = [side.to_be_bytes(), side.to_be_bytes()].concat();
    head.extend([16, 0, 0, 0, 0]);
    chunk(b"IHDR", &head);
    chunk(b"IDAT", data);
    chunk(b"IEND", &[]);
    out
}

/// A stream of zeros that is a thousandth of what it unpacks to.
fn packed_zeros(bytes: usize) -> Vec<u8> {
    use std::io::Write;
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let block = vec![0; 1 << 20];
    (0..bytes >> 20).for_each(|_| packer.write_all(&block).unwrap());
    packer.finish().unwrap()
}

/// Files that lie about their size, by name.
fn bombs() -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for side in [1, 30_000, 100_000, 1 << 18, u32::MAX] {
        for compression in [1u16, 5, 8, 32_773] {
            all.push((format!("claims{side}_{compression}.tif"), claiming_tiff(side, compression)));
        }
        all.push((format!("claims{side}.png"), png(side, &[0x78, 0x9c, 1])));
        let asc = format!("ncols {side}\nnrows {side}\ncellsize 1\n1 2 3\n");
        all.push((format!("claims{side}.asc"), asc.into_bytes()));
    }
    all.push(("packed.png".into(), png(16_384, &packed_zeros(540 << 20))));
    let sidecar = json!({ "cols": 4_000_000_000u64, "rows": 4_000_000_000u64, "range": [0, 1] });
    all.push(("sided.json".into(), sidecar.to_string().into_bytes()));
    all.push(("sided.r16".into(), vec![0; 64]));
    all.push(("empty.exr".into(), Vec::new()));
    all.push(("magic.exr".into(), vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]));
    all.push(("odd.hgt".into(), vec![1; 1001]));
    all
}

/// Runs the program under a limit on the memory it may ask the system for, so that taking a lying header at its word ends
/// the process.
fn limited(args: &[&str]) -> super::Ended {
    let script = "ulimit -v 2500000; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_orograph")]).args(args);
    ended(command.env("XDG_CONFIG_HOME", "/nonexistent").stdin(std::process::Stdio::null()))
}

#[cfg(unix)]
#[test]
fn no_file_is_believed_about_its_size() {
    let desk = Desk::new();
    let bombs = bombs();
    for (name, bytes) in &bombs {
        desk.write(name, bytes);
    }
    let mut faults = Vec::new();
    for (name, _) in bombs.iter().filter(|(name, _)| !name.ends_with("json")) {
        let file = text(&desk.path(name));
        let (png, tif) = (text(&desk.path("out.png")), text(&desk.path("out.tif")));
        let out = text(&desk.path("out"));
        let graph = json!({
            "orograph": 1,
            "terrain": { "width": 100, "depth": 100, "base": 17 },
            "nodes": { "dem": { "kind": "import_height", "set": { "file": name } } },
            "outputs": { "height": { "from": "dem.height", "format": "r32" } },
        });
        let graph = desk.write("bomb.graph", graph.to_string().as_bytes());
        let commands: [&[&str]; 5] = [
            &["info", &file, "--memory", "1G"],
            &["convert", &file, &tif, "--overwrite", "--memory", "1G"],
            &["render", &file, "-o", &png, "--width", "64", "--memory", "1G"],
            &["plan", &graph, "--memory", "1G"],
            &["build", &graph, "-o", &out, "--memory", "1G"],
        ];
        for command in commands {
            let end = limited(command);
            faults.extend(end.fault().map(|fault| format!("{} of {name}: {fault}", command[0])));
        }
    }
    println!("{} files, 5 commands each", bombs.len() - 1);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Files of every format that is written, with bytes changed at random.
#[test]
fn no_damaged_file_stops_a_command_without_a_word() {
    let desk = Desk::new();
    let formats = ["png8", "png16", "tiff", "tiff16", "exr", "r16", "r32", "asc"];
    let mut faults = Vec::new();
    for format in formats {
        let built = desk.build(format, &["--output", "height", "--format", format, "--size", "65"]);
        assert_eq!(built.code, Some(0), "{}", built.said);
        let report = desk.report(format);
        let name = report["outputs"][0]["path"].as_str().unwrap().to_owned();
        let good = std::fs::read(desk.path(format).join(&name)).unwrap();
        for round in some_of((0..60u64).collect(), 15) {
            let mut bad = good.clone();
            for i in 0..1 + hash::nth(round, 0) % 40 {
                let at = hash::nth(round, 2 * i + 1) as usize % bad.len().min(2000);
                bad[at] = hash::nth(round, 2 * i + 2) as u8;
            }
            bad.truncate(bad.len() - (hash::nth(round, 99) % 3) as usize * (bad.len() / 3));
            let file = text(&desk.path(format).join(&name));
            std::fs::write(&file, &bad).unwrap();
            let end = run(&["info", &file]);
            faults.extend(end.fault().map(|fault| format!("{format}, round {round}: {fault}")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
