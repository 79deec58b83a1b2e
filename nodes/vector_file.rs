//! What kinds that read files of lines share.

use std::sync::Arc;

use crate::files::vectors::{self, Imported, Laying, MAX_FILE, Wanted};
use crate::node::{Context, Cost, Error, FileRequest, Result, SourceFile};
use crate::source;
use crate::units::FilePath;
use crate::value::curves::CurveError;

/// Seconds that a byte of text takes.
const PARSING_SECONDS: f64 = 0.2e-6;

/// The file that a parameter `file` names, where it names one.
pub(crate) fn request(file: &FilePath) -> Vec<FileRequest> {
    let named = !file.0.is_empty();
    named
        .then(|| FileRequest { parameter: "file", name: file.0.clone(), optional: false })
        .into_iter()
        .collect()
}

/// What reading takes.
///
/// # Errors
/// Where no file is named, or it is too long.
pub(crate) fn cost(files: &[Arc<SourceFile>]) -> Result<Cost> {
    let Some(first) = files.first() else { return Err(Error::no_file("file")) };
    if let Some(long) = files.iter().find(|f| f.len() > MAX_FILE as u64) {
        let (file, found) = (long.name().to_owned(), long.len());
        let too_long = CurveError::TooMany { what: "bytes of the file", most: MAX_FILE as u64, found };
        return Err(Error::File { parameter: "file", file, message: too_long.to_string() });
    }
    let content = source::reading(files);
    let bytes = vectors::memory(first.name(), content.bytes);
    Ok(content.and(Cost { bytes, seconds: content.bytes as f64 * PARSING_SECONDS }))
}

/// Reads the lines, and says what was left out.
///
/// # Errors
/// Where the file is not there, is none of lines, or the work was asked to stop.
pub(crate) fn read<'a>(
    cx: &Context<'_>,
    file: &FilePath,
    laying: Laying,
    wanted: impl Into<Wanted<'a>>,
) -> Result<Imported> {
    if file.0.is_empty() {
        return Err(Error::no_file("file"));
    }
    let fault = |message: String| Error::File { parameter: "file", file: file.0.clone(), message };
    let source = cx.file(file).ok_or_else(|| fault("not found".into()))?;
    let bytes = cx.stage(0.0, 0.2).read("file", source)?;
    let parsing = cx.stage(0.2, 1.0);
    let go_on = |share: f32| {
        parsing.report(share);
        !parsing.work.is_cancelled()
    };
    let read = vectors::read(&file.0, &bytes, cx.terrain()?, laying, wanted, &go_on);
    let mut imported = read.map_err(|e| match e {
        CurveError::Cancelled => Error::Cancelled,
        other => fault(other.to_string()),
    })?;
    std::mem::take(&mut imported.warnings).into_iter().for_each(|warning| cx.warn(warning));
    Ok(imported)
}
