//! Names of kinds, families and ports.

/// A name, or a short text that goes with one; cheap to clone. A kind of this program borrows its names from the
/// source, one that is made while the program runs owns them.
pub use smol_str::SmolStr as Name;
