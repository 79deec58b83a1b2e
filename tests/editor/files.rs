//! Files: saved, changed by others, recovered.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use eframe::egui::{Key, Modifiers};
use orograph::editor::{Answer, Setup};
use orograph::graph::Graph;

use super::{PRESET, Window, ground, preset};

fn with_home(home: &Path, path: Option<&Path>) -> Window {
    Window::of(Setup {
        path: path.map(Path::to_owned),
        home: Some(home.to_owned()),
        asker: Box::new(|_, _, _| Answer::known(None)),
        ..Setup::default()
    })
}

#[test]
fn saves_where_it_is_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("new.graph");
    let answer = to.clone();
    let asker = Box::new(move |_, _: Option<&Path>, _: &_| Answer::known(Some(answer.clone())));
    let mut window = Window::of(Setup { home: None, asker, ..Setup::default() });
    window.add(ground(20.0, 30.0), "fractal");
    window.keys(Modifiers::COMMAND, Key::S);
    window.steps(3);
    assert_eq!(std::fs::read(&to).unwrap(), window.graph().to_bytes());
    assert!(!window.editor().document().is_unsaved());
}

#[test]
fn a_system_without_dialogs_has_the_path_typed() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::no_dialogs());
    let mut window = Window::of(Setup { path: Some(path), home: None, asker, ..Setup::default() });
    window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.steps(3);
    let to = folder.path().join("copy.graph");
    window.keys(Modifiers::COMMAND, Key::A);
    window.text(to.to_str().unwrap());
    window.key(Key::Enter);
    window.steps(3);
    assert!(std::fs::read(&to).unwrap() == window.graph().to_bytes());
    assert_eq!(window.editor().document().path(), Some(&*to));
    let other = folder.path().join("other.graph");
    std::fs::write(&other, "somebody's").unwrap();
    window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.steps(3);
    window.keys(Modifiers::COMMAND, Key::A);
    window.text(other.to_str().unwrap());
    window.key(Key::Enter);
    window.steps(3);
    assert_eq!(std::fs::read(&other).unwrap(), b"somebody's", "a file that is there is asked about");
    window.click("Replace it");
    assert!(std::fs::read(&other).unwrap() == window.graph().to_bytes());
}

/// The extension is added before the question whether a file is replaced, whoever asked for the path.
#[test]
fn a_name_without_extension_does_not_replace_a_graph_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let other = folder.path().join("other.graph");
    std::fs::write(&other, "somebody's").unwrap();
    let typed = folder.path().join("other");
    for by_system in [true, false] {
        let answer = typed.clone();
        let asker =
            Box::new(
                move |_, _: Option<&Path>, _: &_| {
                    if by_system { Answer::known(Some(answer.clone())) } else { Answer::no_dialogs() }
                },
            );
        let mut window =
            Window::of(Setup { path: Some(path.clone()), home: None, asker, ..Setup::default() });
        window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        window.steps(3);
        if !by_system {
            window.keys(Modifiers::COMMAND, Key::A);
            window.text(typed.to_str().unwrap());
            window.key(Key::Enter);
            window.steps(3);
        }
        assert_eq!(std::fs::read(&other).unwrap(), b"somebody's");
        assert!(window.sees("There is a file of this name."));
        window.click("Cancel");
    }
    let new = folder.path().join("my.v2");
    let asker = Box::new(move |_, _: Option<&Path>, _: &_| Answer::known(Some(new.clone())));
    let mut window = Window::of(Setup { path: Some(path), home: None, asker, ..Setup::default() });
    window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window.steps(3);
    assert!(folder.path().join("my.v2.graph").exists());
}

/// Saving at once after another program has written, before the editor has looked at the file.
#[test]
fn saving_does_not_replace_what_others_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let mut window = Window::of(Setup { path: Some(path.clone()), home: None, ..Setup::default() });
    window.add(ground(20.0, 30.0), "blur");
    let mut other = Graph::new();
    other.add("second", "constant").unwrap();
    other.save(&path).unwrap();
    window.keys(Modifiers::COMMAND, Key::S);
    window.steps(3);
    assert_eq!(std::fs::read(&path).unwrap(), other.to_bytes());
    assert!(window.sees("The file has changed"));
    window.click("Keep mine");
    window.keys(Modifiers::COMMAND, Key::S);
    window.steps(3);
    assert_eq!(std::fs::read(&path).unwrap(), window.graph().to_bytes());
}

#[test]
fn opening_a_graph_writes_nothing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let home = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let mut window = with_home(home.path(), Some(&path));
    window.settle();
    drop(window);
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().flatten().map(|e| e.file_name()).collect();
    assert_eq!(names, ["first_light.graph"]);
    assert_eq!(std::fs::read(&path).unwrap(), std::fs::read(PRESET).unwrap());
}

#[test]
fn a_second_editor_on_a_file_is_warned() {
    let folder = tempfile::tempdir().unwrap();
    let home = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let first = with_home(home.path(), Some(&path));
    let second = with_home(home.path(), Some(&path));
    assert!(second.sees("Another editor has this file open") && !first.sees("Another editor"));
}

#[test]
fn a_file_changed_by_others_is_read_again_or_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = preset(folder.path());
    let mut window = Window::on(&path);
    let mut other = Graph::from_bytes(&std::fs::read(&path).unwrap(), window.graph().registry()).unwrap();
    other.add("stranger", "constant").unwrap();
    other.save(&path).unwrap();
    // Nothing is unsaved, so the editor reads the file without asking.
    window.until("the changed file is read", |w| w.graph().find("stranger").is_some());
    window.add(ground(20.0, 30.0), "blur");
    other.add("second", "constant").unwrap();
    other.save(&path).unwrap();
    window.appears("Read the file");
    window.click("Read the file");
    assert!(window.graph().find("second").is_some() && window.graph().find("blur").is_none());
    window.keys(Modifiers::COMMAND, Key::Z);
    assert!(window.graph().find("blur").is_some(), "what was here is in the history");
}

/// Where the process that is to be killed keeps its work.
const HOME: &str = "OROGRAPH_TEST_HOME";

/// Edits until the process is killed.
fn edit_until_killed(home: &Path) -> ! {
    let mut window = with_home(home, None);
    window.add(ground(20.0, 30.0), "fractal");
    loop {
        window.steps(1);
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Runs itself once more in a process of its own, which it kills.
#[test]
fn a_killed_editor_loses_nothing() {
    if let Some(home) = std::env::var_os(HOME) {
        edit_until_killed(Path::new(&home));
    }
    let home = tempfile::tempdir().unwrap();
    let mut victim = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "files::a_killed_editor_loses_nothing"])
        .env(HOME, home.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let kept = || {
        let entries = std::fs::read_dir(home.path().join("sessions")).into_iter().flatten().flatten();
        entries.map(|e| e.path()).any(|p| p.extension().is_some_and(|e| e == "json"))
    };
    let start = Instant::now();
    while !kept() {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was kept");
        std::thread::sleep(Duration::from_millis(50));
    }
    victim.kill().unwrap();
    victim.wait().unwrap();
    let mut window = with_home(home.path(), None);
    assert!(window.sees("Unsaved work was found"));
    window.click("Recover");
    assert!(window.graph().find("fractal_noise").is_some());
    assert!(window.editor().document().is_unsaved());
}
