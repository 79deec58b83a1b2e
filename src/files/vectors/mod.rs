//! Readers of lines: SVG pictures and `GeoJSON` files become feature curves, or lines with their properties.
//!
//! A reader goes through the text once, in time and memory that follow its length, and asks every few hundred elements
//! whether to go on. What one line or element of a file gets wrong costs that line alone: the rest is read, and a
//! warning says how many there were and where the first stands. A file fails as a whole when it is not of its format at
//! all, says that it lies elsewhere on Earth, or is over a limit.

mod collect;
mod decode;
pub mod geojson;
mod mapping;
mod open;
pub mod svg;
mod tally;
mod wanted;

pub use mapping::{Mapping, Property, Source};
pub use open::{Laying, memory, read};
pub use wanted::{FileLine, Wanted};

use crate::value::Curves;
use crate::value::curves::CurveError;

/// Longest file taken, in bytes.
pub const MAX_FILE: usize = 64 << 20;
/// Most positions or path segments of a file.
pub const MAX_POSITIONS: usize = 1 << 20;
/// Most elements of a picture, and most that are drawn of it, `use` counted.
pub const MAX_ELEMENTS: usize = 1 << 20;

/// What a file gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// The curves, in the order of the file.
    pub curves: Curves,
    /// The lines, in the order of the file, where they were wanted as they are.
    pub lines: Vec<FileLine>,
    /// What was left out or looks wrong, a sentence each without a full stop.
    pub warnings: Vec<String>,
}

/// Is told the finished share of the work, 0 to 1, and answers whether to go on.
pub type GoOn<'a> = dyn Fn(f32) -> bool + 'a;

/// Asks whether to go on, now and then.
struct Watch<'a> {
    go_on: &'a GoOn<'a>,
    /// Length of the work, in whatever unit its places are told in.
    length: f32,
    calls: std::cell::Cell<u32>,
}

impl<'a> Watch<'a> {
    /// How many calls there are from question to question: some microseconds of work.
    const PACE: u32 = 64;

    fn new(go_on: &'a GoOn<'a>, length: usize) -> Self {
        Self { go_on, length: length.max(1) as f32, calls: std::cell::Cell::new(0) }
    }

    /// The work has come to a place.
    fn at(&self, place: usize) -> Result<(), CurveError> {
        let calls = self.calls.get();
        self.calls.set(calls.wrapping_add(1));
        if !calls.is_multiple_of(Self::PACE) || (self.go_on)((place as f32 / self.length).min(1.0)) {
            Ok(())
        } else {
            Err(CurveError::Cancelled)
        }
    }
}

fn check_size(bytes: &[u8]) -> Result<(), CurveError> {
    too_many("bytes of the file", MAX_FILE, bytes.len())
}

/// # Errors
/// When there is more of something than may be.
fn too_many(what: &'static str, most: usize, found: usize) -> Result<(), CurveError> {
    if found <= most {
        return Ok(());
    }
    Err(CurveError::TooMany { what, most: most as u64, found: found as u64 })
}

/// A name of the file, cut to what a name may be.
fn short(name: &str) -> String {
    name.chars().take(64).collect()
}
