//! The document: files, problems, edits.

mod edits;
mod exposed;
mod files;
mod hostile;
mod kinds;
mod properties;
mod schema;
