//! Protection of sidecars: a command replaces the sidecar of the file it writes, and no other without `--overwrite`.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::exit::Stop;
use crate::files::{LONGEST_SIDECAR, Owner, sidecar_name};

/// Refuses to write the sidecar of a file over another file's, over that of an input, or over the file itself.
///
/// `inputs` are the files that are read; their sidecars are never overwritten.
pub(super) fn spare_sidecars(file: &Path, inputs: &[PathBuf], overwrite: bool) -> Result<(), Stop> {
    let (sidecar, name) = (sidecar_of(file), name_of(file));
    if same_path(&sidecar, file) {
        return Err(Stop::usage(format!(
            "{} would be its own sidecar; give it the extension of its format",
            file.display()
        )));
    }
    if sidecar.symlink_metadata().is_err() {
        return Ok(());
    }
    let json = contents(&sidecar);
    let of_input = |input: &PathBuf| {
        let of_it = json.as_ref().is_some_and(|j| match Owner::of(j, &name_of(input)) {
            Owner::Unnamed => true,
            owner => owner.is(&name_of(input)),
        });
        of_it && same_path(&sidecar, &sidecar_of(input))
    };
    if let Some(input) = inputs.iter().find(|input| of_input(input)) {
        return Err(Stop::usage(format!(
            "{} is the sidecar of {}, an input, and is never overwritten; give the output another name",
            sidecar.display(),
            input.display()
        )));
    }
    if overwrite {
        return Ok(());
    }
    let owner = json.as_ref().map_or(Owner::Nobody, |j| Owner::of(j, &name));
    if owner.is(&name) {
        return Ok(());
    }
    let whose = match owner {
        Owner::File(other) => format!("is the sidecar of {other}"),
        Owner::Unnamed | Owner::Nobody => "is there already".into(),
    };
    Err(Stop::usage(format!(
        "{} {whose}, and {name} needs one of that name; give it another name or say --overwrite",
        sidecar.display()
    )))
}

/// Refuses to write a picture over a file that holds heights according to its sidecar.
pub(super) fn spare_heights(picture: &Path, overwrite: bool) -> Result<(), Stop> {
    let name = name_of(picture);
    let is_there = !overwrite && picture.symlink_metadata().is_ok();
    let json = is_there.then(|| contents(&sidecar_of(picture))).flatten();
    if json.is_some_and(|j| Owner::of(&j, &name).is(&name)) {
        return Err(Stop::usage(format!(
            "{} holds heights, as its sidecar says; give the picture another name or say --overwrite",
            picture.display()
        )));
    }
    Ok(())
}

/// The name of the file to which the sidecar of `file` belongs, where this is another file that exists.
pub(super) fn other_owner(folder: &Path, file: &str) -> Option<String> {
    let json = contents(&folder.join(sidecar_name(file)))?;
    match Owner::of(&json, file) {
        Owner::File(other) => {
            let is_there = folder.join(&other).symlink_metadata().is_ok();
            (is_there && !other.eq_ignore_ascii_case(file)).then_some(other)
        }
        Owner::Unnamed | Owner::Nobody => None,
    }
}

/// The content of a small regular file.
fn contents(path: &Path) -> Option<Vec<u8>> {
    let is_file = path.metadata().is_ok_and(|m| m.is_file());
    let file = is_file.then(|| std::fs::File::open(path).ok()).flatten()?;
    let mut bytes = Vec::new();
    file.take(LONGEST_SIDECAR + 1).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn sidecar_of(file: &Path) -> PathBuf {
    file.with_file_name(sidecar_name(&name_of(file)))
}

fn name_of(file: &Path) -> String {
    file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Whether two paths are the same place; their last parts need not exist.
fn same_path(a: &Path, b: &Path) -> bool {
    let whole = |p: &Path| {
        p.canonicalize().ok().or_else(|| {
            let folder = p.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(folder.canonicalize().ok()?.join(p.file_name()?))
        })
    };
    whole(a).is_some_and(|a| whole(b) == Some(a))
}
