//! Disks that are full, folders that cannot be written, listeners that have gone: an error, whole files, nothing lost.

use std::path::Path;
use std::process::{Command, Stdio};

use super::{Desk, ended, program, run, text};
use crate::rig::skip::skip;

/// A file system of some size in memory, as long as it stands.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    /// None where this user may not mount one.
    fn mount(at: &'a Path, size: &str) -> Option<Self> {
        std::fs::create_dir_all(at).unwrap();
        let options = format!("size={size}");
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", &options, "orograph-test"]).arg(at).stderr(Stdio::null());
        mount.status().is_ok_and(|s| s.success()).then_some(Self(at))
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        // A folder that stays mounted is the machine's to clean up.
        let _ = Command::new("umount").arg(self.0).status();
    }
}

#[test]
fn a_full_disk_loses_nothing() {
    let desk = Desk::new();
    let at = desk.path("disk");
    let Some(_disk) = SmallDisk::mount(&at, "600k") else {
        return skip("a_full_disk_loses_nothing", "this user may not mount a small disk", Path::new(""));
    };
    // A first build fits; the second, larger, does not.
    let small = desk.build("disk/out", &["--size", "65"]);
    assert_eq!(small.code, Some(0), "{}", small.said);
    let before = std::fs::read(desk.path("disk/out/height.r32")).unwrap();
    let large = desk.build("disk/out", &["--size", "1025"]);
    assert_eq!((large.fault(), large.code), (None, Some(1)), "{}", large.said);
    assert!(large.said.contains("space"), "{}", large.said);
    assert_eq!(std::fs::read(desk.path("disk/out/height.r32")).unwrap(), before, "the old file is whole");
    let parts = std::fs::read_dir(desk.path("disk/out")).unwrap().flatten();
    let parts: Vec<_> =
        parts.map(|e| e.file_name()).filter(|n| n.to_string_lossy().ends_with(".part")).collect();
    assert!(parts.is_empty(), "{parts:?} are left over");
    // A graph that cannot be rewritten stays as it was.
    let graph = std::fs::read(desk.path("a.graph")).unwrap();
    std::fs::write(desk.path("disk/b.graph"), &graph).unwrap();
    let space = std::process::Command::new("dd")
        .args(["if=/dev/zero", &format!("of={}", text(&desk.path("disk/fill"))), "bs=4k"])
        .stderr(Stdio::null())
        .status();
    assert!(space.is_ok(), "dd runs");
    let fmt = run(&["fmt", &text(&desk.path("disk/b.graph"))]);
    assert_eq!(fmt.code, Some(1), "{}", fmt.said);
    assert_eq!(std::fs::read(desk.path("disk/b.graph")).unwrap(), graph);
    // A cache that can keep nothing says so and stops nothing.
    let cached = desk.build("out", &["--size", "257", "--cache", &text(&desk.path("disk/cache"))]);
    assert_eq!(cached.fault(), None);
    assert!(cached.said.contains("cache"), "{}", cached.said);
}

#[test]
fn listeners_that_have_gone_stop_no_build() {
    let desk = Desk::new();
    let (graph, out) = (text(&desk.path("a.graph")), text(&desk.path("out")));
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    let build = program().args(["build", &graph, "-o", &out]).stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(build.code(), Some(0));
    let info = program().args(["info", &graph]).stdout(full()).stderr(Stdio::null()).status().unwrap();
    assert_eq!(info.code(), Some(1), "what was asked for could not be told");
    let script = "\"$0\" info \"$1\" >&- 2>&-; \"$0\" nodes | head -n 1 >/dev/null";
    let end = ended(Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_orograph"), &graph]));
    assert_eq!(end.fault(), None);
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error() {
    let desk = Desk::new();
    desk.write("file", b"in the way");
    let end = desk.build("file/out", &[]);
    assert_eq!((end.fault(), end.code), (None, Some(1)), "{}", end.said);
    let end = desk.build("file", &[]);
    assert_eq!((end.fault(), end.code), (None, Some(1)), "{}", end.said);
    assert_eq!(std::fs::read(desk.path("file")).unwrap(), b"in the way");
}
