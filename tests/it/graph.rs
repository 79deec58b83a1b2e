//! The document: files, problems, edits.
#![allow(clippy::unwrap_used, reason = "a test stops where something fails")]

mod canvas;
mod drawn;
mod edits;
mod exposed;
mod files;
mod hostile;
mod kinds;
mod made;
mod parsed;
mod properties;
mod quantities;
mod schema;
pub(crate) mod weighted;
