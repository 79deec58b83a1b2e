//! Names of files: those of other systems, those through `..`, those that are no text.

use serde_json::json;

use super::{Desk, code, height, orograph, run, said, text};

#[cfg(unix)]
#[test]
fn a_name_that_is_no_text_is_not_written_as_another() {
    use std::os::unix::ffi::OsStrExt as _;
    let desk = Desk::new(&height());
    let asc = text(&desk.path("a.asc"));
    std::fs::write(&asc, "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n").unwrap();
    let name = desk.path("").join(std::ffi::OsStr::from_bytes(b"out\xff.tif"));
    let ended = orograph().args(["convert", &asc]).arg(&name).output().unwrap();
    assert_eq!(code(&ended), 2, "{}", said(&ended));
    assert!(said(&ended).contains("must be text in UTF-8"), "{}", said(&ended));
    assert_eq!(std::fs::read_dir(desk.path("")).unwrap().count(), 2, "the graph and the heights");
}

/// A folder `home` with a graph of one height file, and the folders `home/heights`, `win` and `out_of_reach` with one.
pub(super) fn travelled(file: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for inner in ["home/heights", "win", "out_of_reach"] {
        std::fs::create_dir_all(folder.path().join(inner)).unwrap();
        let heights = "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n";
        std::fs::write(folder.path().join(inner).join("a.asc"), heights).unwrap();
    }
    let graph = json!({
        "orograph": 1,
        "terrain": { "width": 64, "depth": 64, "base": 33 },
        "nodes": { "dem": { "kind": "import_height", "set": { "file": file } } },
        "outputs": { "height": { "from": "dem.height", "format": "r32" } },
    });
    std::fs::write(folder.path().join("home/a.graph"), graph.to_string()).unwrap();
    folder
}

#[cfg(unix)]
#[test]
fn a_graph_of_another_system_finds_its_files() {
    for (file, exit, words) in [
        ("heights/a.asc", 0, "wrote"),
        ("heights\\a.asc", 0, "wrote"),
        (".\\heights\\a.asc", 0, "wrote"),
        ("heights\\..\\heights\\a.asc", 0, "wrote"),
        ("heights/../heights/a.asc", 0, "wrote"),
        ("..\\win\\a.asc", 0, "wrote"),
        ("../win/a.asc", 0, "wrote"),
        ("../home/heights/a.asc", 0, "wrote"),
        ("../out_of_reach/a.asc", 4, "refused"),
        ("..\\out_of_reach\\a.asc", 4, "refused"),
        ("../win/../out_of_reach/a.asc", 4, "refused"),
        ("linked/a.asc", 4, "refused"),
        ("..\\..\\..\\..\\..\\..\\..\\..\\etc\\passwd", 4, "refused"),
        ("\\etc\\passwd", 4, "refused"),
        ("heights\\b.asc", 4, "there is no such file"),
        ("C:\\heights\\a.asc", 4, "names a drive of Windows"),
        ("c:/heights/a.asc", 4, "names a drive of Windows"),
        ("heights\\con", 4, "is the name of a device"),
    ] {
        let folder = travelled(file);
        let path = |name: &str| text(&folder.path().join(name));
        std::os::unix::fs::symlink("../out_of_reach", folder.path().join("home/linked")).unwrap();
        let (graph, out, win) = (path("home/a.graph"), path("out"), path("win"));
        let built = run(&["build", &graph, "-o", &out, "--allow", &win]);
        assert_eq!(code(&built), exit, "{file}: {}", said(&built));
        assert!(said(&built).contains(words), "{file}: {}", said(&built));
    }
    // A folder above all that is named holds what lies beside it, too, although the files beside it are not there.
    let folder = travelled("../win/a.asc");
    let path = |name: &str| text(&folder.path().join(name));
    let built = run(&["build", &path("home/a.graph"), "-o", &path("out"), "--allow", &path("")]);
    assert_eq!(code(&built), 0, "{}", said(&built));
    // Where a file has the very name, it is that file.
    let folder = travelled("heights\\a.asc");
    std::fs::write(folder.path().join("home/heights\\a.asc"), "ncols 3\nnrows 2\ncellsize 1\n1 2 3\n4 5 6\n")
        .unwrap();
    let graph = text(&folder.path().join("home/a.graph"));
    let built = run(&["build", &graph, "-o", &text(&folder.path().join("out"))]);
    assert_eq!(code(&built), 0, "{}", said(&built));
}

#[cfg(unix)]
#[test]
fn a_file_named_on_the_command_line_may_have_separators_of_windows() {
    let folder = travelled("nothing.asc");
    let built = orograph()
        .current_dir(folder.path())
        .args(["build", "home/a.graph", "-o", "out", "--set", "dem.file=out_of_reach\\a.asc"])
        .output()
        .unwrap();
    assert_eq!(code(&built), 0, "{}", said(&built));
}

#[cfg(unix)]
#[test]
fn fitting_knows_the_node_that_names_the_file_as_on_windows() {
    let folder = travelled("");
    let node = |file: &str| json!({ "kind": "import_height", "set": { "file": file } });
    let nodes = json!({ "one": node("b.asc"), "two": node("heights\\a.asc") });
    std::fs::write(folder.path().join("home/a.graph"), json!({ "orograph": 1, "nodes": nodes }).to_string())
        .unwrap();
    let [graph, heights] = ["home/a.graph", "home/heights/a.asc"].map(|name| text(&folder.path().join(name)));
    let fitted = run(&["fit", &graph, &heights, "--dry-run", "--cell", "100"]);
    assert_eq!(code(&fitted), 0, "{}", said(&fitted));
    assert!(said(&fitted).contains("terrain.width"), "{}", said(&fitted));
}

/// An input that is found in an allowed folder, or by a name of another system, is spared as any other.
#[cfg(unix)]
#[test]
fn inputs_are_spared_by_whatever_name_the_graph_gives_them() {
    for file in ["..\\win\\height.r32", "../win/height.r32", "height.r32"] {
        let folder = travelled(file);
        let win = text(&folder.path().join("win"));
        std::fs::write(folder.path().join("win/height.r32"), [0; 16]).unwrap();
        let graph = text(&folder.path().join("home/a.graph"));
        let built = run(&["build", &graph, "-o", &win, "--allow", &win, "--overwrite"]);
        assert!(code(&built) == 2 && said(&built).contains("never overwritten"), "{file}: {}", said(&built));
    }
}
