//! What was not tried on this machine: told past the harness, which keeps the words of tests that pass, and listed in the
//! file that `OROGRAPH_SKIPS` names; `.ci/run` shows it at its end.

use std::io::Write as _;
use std::path::Path;

/// Tells that a test did not do all its work, and why. `needs` is what would have to be there, where that is a path:
/// `.ci/run` fails where it is.
pub(crate) fn skip(test: &str, reason: &str, needs: &Path) {
    let list = std::env::var_os("OROGRAPH_SKIPS").filter(|v| !v.is_empty());
    enter(list.as_deref().map(Path::new), &format!("{test}\t{reason}\t{}", needs.display()));
    // Straight to the stream: `eprintln` would be kept.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {reason}");
}

fn enter(list: Option<&Path>, line: &str) {
    let Some(path) = list else { return };
    let file = std::fs::File::options().create(true).append(true).open(path);
    let entered = file.and_then(|mut file| file.write_all(format!("{line}\n").as_bytes()));
    entered.unwrap_or_else(|e| panic!("a skip cannot be entered: {e}: {}", path.display()));
}

#[test]
fn skips_are_entered_one_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skips");
    enter(None, "nowhere");
    enter(Some(&path), "a\tno disk\t");
    enter(Some(&path), "b\tno model\t/dem");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "a\tno disk\t\nb\tno model\t/dem\n");
}
