//! What writing takes, for plans and budgets; docs/budgets.md holds it against what was taken.

use super::bands;
use super::codec::Format;

/// Bytes that a writer takes beside what it writes, and seconds on one core.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WriterCost {
    /// Bytes at the peak.
    pub bytes: u64,
    /// Seconds on one core, those for the hashes of a report among them.
    pub seconds: f64,
}

/// What it takes to write so many columns and rows of some numbers each on so many threads.
pub fn writer_cost(format: Format, [cols, rows]: [usize; 2], channels: usize, threads: usize) -> WriterCost {
    let numbers = cols as f64 * rows as f64 * channels as f64;
    WriterCost {
        bytes: bands::held_bytes(cols, channels, threads),
        seconds: numbers * (format.form().nanoseconds + HASHES) * 1e-9,
    }
}

/// Nanoseconds a number for SHA-256 of the samples and of the file.
const HASHES: f64 = 10.0;
