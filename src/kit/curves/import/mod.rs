//! Curves from files of other programs: SVG paths and `GeoJSON` lines.

mod arc;
pub mod geojson;
mod mapping;
pub mod svg;

pub use mapping::{Mapping, Property, Source};

use crate::value::Curves;

/// Longest file taken, in bytes.
pub const MAX_FILE: usize = 64 << 20;
/// Most positions or path segments of a file.
pub const MAX_POSITIONS: usize = 1 << 20;

/// What a file gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// The curves, in the order of the file.
    pub curves: Curves,
    /// What was left out or looks wrong, for a report.
    pub warnings: Vec<String>,
}

/// Counts, up to a limit.
#[derive(Clone, Copy, Debug, Default)]
struct Budget(usize);

impl Budget {
    fn take(&mut self, n: usize) -> Result<(), crate::value::curves::CurveError> {
        self.0 = self.0.saturating_add(n);
        if self.0 <= MAX_POSITIONS {
            return Ok(());
        }
        let (most, found) = (MAX_POSITIONS as u64, self.0 as u64);
        Err(crate::value::curves::CurveError::TooMany { what: "positions in the file", most, found })
    }
}

fn check_size(text: &str) -> Result<(), crate::value::curves::CurveError> {
    if text.len() <= MAX_FILE {
        return Ok(());
    }
    let (most, found) = (MAX_FILE as u64, text.len() as u64);
    Err(crate::value::curves::CurveError::TooMany { what: "bytes of the file", most, found })
}

/// The name of a curve, cut to what a name may be.
fn short(name: &str) -> String {
    name.chars().take(64).collect()
}
