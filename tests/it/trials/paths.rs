//! What a graph names as a file: nothing outside its folder is opened, nothing hangs.

use std::os::unix::fs::symlink;

use serde_json::json;

use super::{Desk, run, text};

#[test]
fn no_name_leads_out_of_the_folder() {
    let desk = Desk::new();
    let outside = tempfile::tempdir().unwrap();
    let secret = outside.path().join("secret.asc");
    std::fs::write(&secret, "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n").unwrap();
    std::fs::copy(&secret, desk.path("inside.asc")).unwrap();
    symlink(&secret, desk.path("link.asc")).unwrap();
    symlink(outside.path(), desk.path("folder")).unwrap();
    symlink("inside.asc", desk.path("here.asc")).unwrap();
    symlink("loop.asc", desk.path("loop.asc")).unwrap();
    let pipe = std::process::Command::new("mkfifo").arg(desk.path("pipe.asc")).status().unwrap();
    assert!(pipe.success());
    std::fs::create_dir(desk.path("dir.asc")).unwrap();
    let absolute = text(&secret);
    let climbing = format!("../{}/secret.asc", outside.path().file_name().unwrap().to_string_lossy());
    let long = "a".repeat(1100) + ".asc";
    let refused = [
        absolute.as_str(),
        &climbing,
        "./../../../etc/passwd",
        "sub/../../x.asc",
        "/etc/passwd",
        "/dev/zero",
        "/dev/stdin",
        "/proc/self/environ",
        "/proc/self/fd/0",
        "link.asc",
        "folder/secret.asc",
        "loop.asc",
        "pipe.asc",
        "dir.asc",
        "con.asc",
        "NUL.tif",
        "com1.asc",
        "C:\\Windows\\win.ini",
        "\\\\host\\share\\a.asc",
        "..\\secret.asc",
        "file:///etc/passwd",
        "http://localhost/a.asc",
        "x\u{0}.asc",
        "~/a.asc",
        "$HOME/a.asc",
        "missing.asc",
        ".",
        "..",
        "/",
        &long,
    ];
    for name in refused.into_iter().chain(["inside.asc", "here.asc"]) {
        let allowed = ["inside.asc", "here.asc"].contains(&name);
        let graph = json!({
            "orograph": 1,
            "terrain": { "width": 100, "depth": 100, "base": 17 },
            "nodes": { "dem": { "kind": "import_height", "set": { "file": name } } },
            "outputs": { "height": { "from": "dem.height", "format": "r32" } },
        });
        let graph = desk.write("paths.graph", graph.to_string().as_bytes());
        let out = text(&desk.path("out"));
        for command in [vec!["plan", &graph], vec!["build", &graph, "-o", &out]] {
            let end = run(&command);
            assert_eq!(end.fault(), None, "{name}");
            let right: &[i32] = if allowed { &[0] } else { &[3, 4] };
            assert!(
                right.contains(&end.code.unwrap()),
                "{} {name}: {:?}, {}",
                command[0],
                end.code,
                end.said
            );
            assert!(end.took.as_secs() < 20, "{name} took {:?}", end.took);
        }
    }
}
