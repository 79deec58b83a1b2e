//! Any file of lines, told by the end of its name.

use super::svg::{self, Fit};
use super::{GoOn, Imported, Wanted, geojson};
use crate::value::Terrain;
use crate::value::curves::CurveError;

/// How the lines of a file come to stand on a terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Laying {
    /// How a picture comes to lie on the terrain.
    pub fit: Fit,
    /// Whether lines are smooth through the positions of `GeoJSON`, rather than straight from each to the next.
    pub smooth: bool,
    /// Positions of `GeoJSON` nearer to the one before than this are left out, in metres.
    pub spacing: f64,
}

/// The lines of an SVG picture or a `GeoJSON` file.
///
/// # Errors
/// As the reader of the format, and where the name ends in neither `.svg`, `.geojson` nor `.json`.
pub fn read<'a>(
    name: &str,
    bytes: &[u8],
    terrain: &Terrain,
    laying: Laying,
    wanted: impl Into<Wanted<'a>>,
    go_on: &GoOn<'_>,
) -> Result<Imported, CurveError> {
    let lower = name.to_ascii_lowercase();
    if lower.ends_with(".svg") {
        return svg::read(bytes, terrain.bounds(), laying.fit, wanted, go_on);
    }
    if !(lower.ends_with(".geojson") || lower.ends_with(".json")) {
        return Err(CurveError::Name);
    }
    let place =
        geojson::Place { smooth: laying.smooth, spacing: laying.spacing, ..geojson::Place::on(terrain) };
    geojson::read(bytes, &place, wanted, go_on)
}

/// Bytes that reading a file of a name and a length takes, the file itself not counted.
///
/// The elements of a text and the curves of its numbers are some tens of times as large as the text, and so are the rules
/// of its style sheets. `use` may make of a small picture as much as 65 536 lines take.
pub fn memory(name: &str, length: u64) -> u64 {
    let more = if name.to_ascii_lowercase().ends_with(".svg") { 48 << 20 } else { 1 << 20 };
    length.saturating_mul(40).saturating_add(more)
}
