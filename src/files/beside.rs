//! Whose the JSON file is that stands beside a file: a sidecar is believed by its own file and replaced with it, and
//! by no other of the same name.

use std::str::FromStr;

use serde_json::Value as Json;

use super::codec::{Codec, Format};
use super::error::Fault;
use super::sidecar::{Sidecar, sidecar_name};

/// Longest sidecar that is read, in bytes: a page of text.
pub const LONGEST_SIDECAR: u64 = crate::source::HEAD_BYTES;

/// What makes a sidecar of an object; `width` and `height` are other names of `cols` and `rows`. A `scale` alone may be
/// that of anything.
const KEYS: [&str; 16] = [
    "orograph",
    "file",
    "cols",
    "rows",
    "width",
    "height",
    "range",
    "sample",
    "byte_order",
    "nodata",
    "rows_from",
    "cell",
    "cells",
    "position",
    "geo",
    "grid",
];

/// Whose a JSON file is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Owner {
    /// It is the sidecar of the file of this name.
    File(String),
    /// It is a sidecar that names no file, made by hand or by another program.
    Unnamed,
    /// It is no sidecar.
    Nobody,
}

impl Owner {
    /// Whose the JSON is that stands where the sidecar of a file does.
    pub fn of(json: &[u8], file: &str) -> Self {
        match parse(json) {
            Ok(sidecar) => sidecar.owner(file).map_or(Self::Unnamed, Self::File),
            Err(_) => Self::Nobody,
        }
    }

    /// Whether it is the sidecar of a file by its own word.
    pub fn is(&self, file: &str) -> bool {
        matches!(self, Self::File(name) if same_name(name, file))
    }
}

impl Sidecar {
    /// The file it describes, by its own word: in older ones that of the format, beside a file of some name.
    fn owner(&self, beside: &str) -> Option<String> {
        if !self.file.is_empty() {
            return Some(last(&self.file).to_owned());
        }
        self.orograph?;
        let format = Format::from_str(&self.format).ok()?;
        let own = Codec::of_name(beside).is_some_and(|codec| Some(codec) == format.codec());
        let stem = sidecar_name(last(beside));
        let stem = stem.strip_suffix("json").unwrap_or(&stem);
        Some(if own { last(beside).to_owned() } else { format!("{stem}{}", format.extension()) })
    }
}

/// The sidecar of a file in the JSON beside it, with a note where that is none, or another file's.
///
/// # Errors
/// When it is this file's by its own word and cannot be read.
pub(super) fn read(file: &str, json: Option<&[u8]>) -> Result<Sidecar, Fault> {
    let Some(json) = json else { return Ok(Sidecar::default()) };
    let (name, left) = (sidecar_name(last(file)), "it is not read");
    let noted = |note: String| Ok(Sidecar { note: Some(note), ..Sidecar::default() });
    match parse(json) {
        Ok(sidecar) => match sidecar.owner(file) {
            Some(owner) if !same_name(&owner, file) => {
                noted(format!("`{name}` is the sidecar of `{owner}`: {left}"))
            }
            _ => Ok(sidecar),
        },
        Err(NoSidecar { why, ours: true }) => Err(Fault::Sidecar(why)),
        Err(NoSidecar { why, ours: false }) => {
            noted(format!("`{name}` beside it is no sidecar, {left}: it {why}"))
        }
    }
}

/// Why a JSON file is no sidecar.
struct NoSidecar {
    why: String,
    /// Whether it says that it is one.
    ours: bool,
}

fn parse(json: &[u8]) -> Result<Sidecar, NoSidecar> {
    let none = |why: String| NoSidecar { why, ours: false };
    let bytes = json.len() as u64;
    if bytes > LONGEST_SIDECAR {
        return Err(none(format!("is {bytes} bytes long; the limit is {LONGEST_SIDECAR}")));
    }
    let text = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let value: Json = serde_json::from_slice(text).map_err(|e| none(format!("cannot be read: {e}")))?;
    let Some(object) = value.as_object() else { return Err(none("holds no object".into())) };
    if !KEYS.iter().any(|k| object.contains_key(*k)) {
        return Err(none("says nothing of heights".into()));
    }
    let ours = object.get("orograph").is_some_and(Json::is_u64);
    let sidecar: Sidecar =
        serde_json::from_value(value).map_err(|e| NoSidecar { why: format!("cannot be read: {e}"), ours })?;
    match sidecar.fault() {
        Some(why) => Err(NoSidecar { why, ours }),
        None => Ok(sidecar),
    }
}

/// A file's name without its folders.
pub fn last_name(name: &str) -> &str {
    last(name)
}

fn last(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// Whether two names, without their folders, are the same where capitals do not count, as on Windows.
fn same_name(a: &str, b: &str) -> bool {
    last(a).eq_ignore_ascii_case(last(b))
}
