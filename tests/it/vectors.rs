//! Tests of the readers of lines: SVG and `GeoJSON`.

mod geojson;
mod hostile;
mod svg;
mod units;

use orograph::files::vectors::{Imported, Mapping, Source, geojson as geo, svg as pictures};
use orograph::units::Number;
use orograph::value::curves::CurveError;
use orograph::value::{Bounds, Curve};

/// Height from `h`, 50 and 60 m of slope, its angle on the left from `angle`.
pub(crate) fn mapping() -> Mapping {
    let property = |name: &str| Source::Property { name: name.into(), factor: Number(1.0) };
    Mapping {
        height: property("h"),
        left_extent: Source::Value { value: Number(50.0) },
        right_extent: Source::Value { value: Number(60.0) },
        left_angle: property("angle"),
        ..Mapping::default()
    }
}

/// The same height on every line.
pub(crate) fn plain() -> Mapping {
    Mapping { height: Source::Value { value: Number(1.0) }, ..Mapping::default() }
}

/// A terrain of 1000 by 1000 m.
pub(crate) const SQUARE: Bounds = Bounds { min: [0.0, 0.0], max: [1000.0, 1000.0] };

pub(crate) fn svg(text: &str, fit: pictures::Fit, mapping: &Mapping) -> Result<Imported, CurveError> {
    pictures::read(text.as_bytes(), SQUARE, fit, mapping, &|_| true)
}

pub(crate) fn json(text: &str, place: &geo::Place, mapping: &Mapping) -> Result<Imported, CurveError> {
    geo::read(text.as_bytes(), place, mapping, &|_| true)
}

/// On the square, straight from position to position.
pub(crate) fn place() -> geo::Place {
    geo::Place { origin: [0.0; 2], onto: SQUARE, epsg: None, smooth: false, spacing: 0.0 }
}

/// The corners of each curve, whole metres.
pub(crate) fn corners(got: &Imported) -> Vec<Vec<[i64; 2]>> {
    let one = |c: &Curve| c.knots().iter().step_by(3).map(|p| p.map(|x| x.round() as i64)).collect();
    got.curves.iter().map(one).collect()
}
