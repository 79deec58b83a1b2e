//! The files that a graph may read (law 10).

use std::path::Path;

use orograph::engine::{Engine, Files, Options};
use orograph::value::Value;
use serde_json::json;

use super::{evaluate, graph, grid, ran};

fn reads(folder: &Path, name: &str) -> Result<f32, String> {
    let mut files = Files::default();
    files.allow_folder(folder).unwrap();
    let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
    read_with(&e, name)
}

fn read_with(e: &Engine, name: &str) -> Result<f32, String> {
    let g = graph(json!({ "file": { "kind": "bytes", "set": { "file": name } } }));
    let evaluation = evaluate(e, &g, "file", grid(&g, 5));
    match &evaluation.values[0] {
        Ok(Value::Field(f)) => Ok(f.at(0, 0)),
        Ok(other) => panic!("a field, not {other:?}"),
        Err(failure) => Err(failure.to_string()),
    }
}

#[test]
fn files_stay_below_the_folder() {
    let top = tempfile::tempdir().unwrap();
    let folder = top.path().join("graphs");
    std::fs::create_dir_all(folder.join("data")).unwrap();
    std::fs::write(top.path().join("secret"), "1234567").unwrap();
    std::fs::write(folder.join("data/a.bin"), "123").unwrap();
    assert_eq!(reads(&folder, "data/a.bin"), Ok(3.0));
    assert_eq!(reads(&folder, "./data/a.bin"), Ok(3.0));
    let secret = top.path().join("secret").to_string_lossy().into_owned();
    for name in ["../secret", "data/../../secret", "../../../../../etc/passwd", "/etc/passwd", &secret] {
        let refused = reads(&folder, name).unwrap_err();
        assert!(refused.contains("node `file`") && refused.contains("refused"), "{name}: {refused}");
    }
    assert!(reads(&folder, "data").unwrap_err().contains("not a regular file"));
    assert!(reads(&folder, "CON").unwrap_err().contains("device"));
    assert!(reads(&folder, "data/nul.tif").unwrap_err().contains("device"));
    assert!(reads(&folder, "missing.tif").unwrap_err().contains("no such file"));
}

#[cfg(unix)]
#[test]
fn files_behind_links_out_and_pipes_are_refused() {
    let top = tempfile::tempdir().unwrap();
    let folder = top.path().join("graphs");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(top.path().join("secret"), "1234567").unwrap();
    std::fs::write(folder.join("inside"), "12").unwrap();
    std::os::unix::fs::symlink("../secret", folder.join("out")).unwrap();
    std::os::unix::fs::symlink("/etc/passwd", folder.join("far")).unwrap();
    std::os::unix::fs::symlink("inside", folder.join("in")).unwrap();
    assert_eq!(reads(&folder, "in"), Ok(2.0));
    for name in ["out", "far"] {
        assert!(reads(&folder, name).is_err(), "{name}");
    }
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap();
    assert!(made.success());
    assert!(reads(&folder, "pipe").unwrap_err().contains("not a regular file"));
    assert!(reads(&folder, "/dev/zero").is_err());
}

#[test]
fn files_are_read_again_when_they_change_and_only_then() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.bin"), "123").unwrap();
    let mut files = Files::default();
    files.allow_folder(folder.path()).unwrap();
    let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
    assert_eq!(read_with(&e, "a.bin"), Ok(3.0));
    std::fs::write(folder.path().join("a.bin"), "12345").unwrap();
    assert_eq!(read_with(&e, "a.bin"), Ok(5.0));
    // The content and the last part of the name count, not the folder.
    std::fs::create_dir(folder.path().join("else")).unwrap();
    std::fs::copy(folder.path().join("a.bin"), folder.path().join("else/a.bin")).unwrap();
    let g = graph(json!({ "file": { "kind": "bytes", "set": { "file": "else/a.bin" } } }));
    assert_eq!(ran(&evaluate(&e, &g, "file", grid(&g, 5))), [""; 0]);
}

#[test]
fn files_named_by_the_user_may_lie_anywhere() {
    let top = tempfile::tempdir().unwrap();
    let path = top.path().join("dem.bin");
    std::fs::write(&path, "1234").unwrap();
    let mut files = Files::default();
    files.allow_file(&path);
    let e = Engine::new(&Options { threads: 1, ..Options::default() }, files).unwrap();
    assert_eq!(read_with(&e, &path.to_string_lossy()), Ok(4.0));
    assert!(read_with(&e, &top.path().join("other.bin").to_string_lossy()).is_err());
}
