//! Lines of `GeoJSON` files.

use serde_json::Value as Json;

use super::mapping::Line;
use super::{Budget, Imported, Mapping, Property, check_size, short};
use crate::kit::curves::short::shares;
use crate::value::Curves;
use crate::value::curves::bezier::{Point, norm, sub};
use crate::value::curves::{CurveError, smooth};

/// How the lines of a file come to stand on the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// East and north in the file, in metres, that come to stand at `at`: of a terrain on Earth its north-west corner.
    pub origin: [f64; 2],
    /// Where that is on the terrain, x east and y south, in metres.
    pub at: Point,
    /// Whether the curve is smooth through the positions, rather than straight from each to the next.
    pub smooth: bool,
    /// Positions nearer to the one before than this are left out, in metres; the last one stays.
    pub spacing: f64,
}

impl Default for Place {
    fn default() -> Self {
        Self { origin: [0.0; 2], at: [0.0; 2], smooth: true, spacing: 0.0 }
    }
}

/// The curves of all `LineString`s and `MultiLineString`s of a file whose coordinates are metres to the east and
/// north, with the constraints that a mapping makes of their properties. Other geometry is left out and counted.
///
/// # Errors
/// Names feature, line and position.
pub fn read(text: &str, place: &Place, mapping: &Mapping) -> Result<Imported, CurveError> {
    check_size(text)?;
    let json: Json =
        serde_json::from_str(text).map_err(|e| CurveError::file("GeoJSON", format!("is not JSON: {e}")))?;
    let mut reader = Reader {
        place,
        mapping,
        curves: Vec::new(),
        budget: Budget::default(),
        others: 0,
        bare: 0,
        degrees: true,
    };
    match json["type"].as_str() {
        Some("FeatureCollection") => {
            let Some(features) = json["features"].as_array() else {
                return Err(CurveError::file("GeoJSON", "a FeatureCollection must have a list `features`"));
            };
            for (i, feature) in features.iter().enumerate() {
                reader.feature(feature, &format!("feature {i}"))?;
            }
        }
        Some("Feature") => reader.feature(&json, "feature 0")?,
        Some(_) => reader.geometry(&json, &Json::Null, "geometry", 0)?,
        None => return Err(CurveError::file("GeoJSON", "must be an object with a text `type`")),
    }
    reader.finish()
}

struct Reader<'a> {
    place: &'a Place,
    mapping: &'a Mapping,
    curves: Vec<std::sync::Arc<crate::value::Curve>>,
    budget: Budget,
    /// Geometry that is no line.
    others: usize,
    /// Lines on which nothing is set.
    bare: usize,
    /// Whether every position could be longitude and latitude.
    degrees: bool,
}

impl Reader<'_> {
    fn feature(&mut self, feature: &Json, place: &str) -> Result<(), CurveError> {
        let geometry = &feature["geometry"];
        if geometry.is_null() {
            self.others += 1;
            return Ok(());
        }
        self.geometry(geometry, feature, place, 0)
    }

    fn geometry(
        &mut self,
        geometry: &Json,
        feature: &Json,
        place: &str,
        depth: u32,
    ) -> Result<(), CurveError> {
        let list = |key: &str| {
            let missing = || CurveError::file(place, format!("must have a list `{key}`"));
            geometry[key].as_array().ok_or_else(missing)
        };
        match geometry["type"].as_str() {
            Some("LineString") => self.line(list("coordinates")?, feature, place.to_owned()),
            Some("MultiLineString") => {
                for (i, line) in list("coordinates")?.iter().enumerate() {
                    let place = format!("{place}, line {i}");
                    let Some(positions) = line.as_array() else {
                        return Err(CurveError::file(place, "must be a list of positions"));
                    };
                    self.line(positions, feature, place)?;
                }
                Ok(())
            }
            Some("GeometryCollection") if depth < 8 => {
                for (i, part) in list("geometries")?.iter().enumerate() {
                    self.geometry(part, feature, &format!("{place}, geometry {i}"), depth + 1)?;
                }
                Ok(())
            }
            Some(_) => {
                self.others += 1;
                Ok(())
            }
            None => Err(CurveError::file(place, "must have a geometry with a text `type`")),
        }
    }

    fn line(&mut self, positions: &[Json], feature: &Json, place: String) -> Result<(), CurveError> {
        self.budget.take(positions.len())?;
        let mut points: Vec<Point> = Vec::new();
        let mut heights: Vec<Option<f64>> = Vec::new();
        for (i, position) in positions.iter().enumerate() {
            let number = |k: usize| position.get(k).and_then(Json::as_f64);
            let (Some(east), Some(north)) = (number(0), number(1)) else {
                let got: String = position.to_string().chars().take(60).collect();
                let message = format!("position {i} must be a list [east, north] of numbers, got {got}");
                return Err(CurveError::file(place, message));
            };
            self.degrees &= east.abs() <= 180.0 && north.abs() <= 90.0;
            let Place { origin, at, .. } = self.place;
            let point = [at[0] + (east - origin[0]), at[1] - (north - origin[1])];
            let last = i + 1 == positions.len();
            let near = |p: &Point| {
                let distance = norm(sub(point, *p));
                distance == 0.0 || (distance < self.place.spacing && !last)
            };
            if points.last().is_none_or(|p| !near(p)) {
                points.push(point);
                heights.push(number(2));
            }
        }
        let line = if self.place.smooth { smooth::through(&points) } else { smooth::straight(&points) };
        let knots = line.map_err(|fault| CurveError::file(place.clone(), fault.0))?;
        let mut z: Vec<(f64, f64)> = Vec::new();
        for (u, height) in shares(&knots).into_iter().zip(&heights) {
            if let Some(height) = height
                && z.last().is_none_or(|last| last.0 < u)
            {
                z.push((u, *height));
            }
        }
        let properties = &feature["properties"];
        let property = |name: &str| property(&properties[name], name);
        let text = |json: &Json| json.as_str().map(str::to_owned);
        let name = text(&properties["name"]).or_else(|| text(&feature["id"])).unwrap_or_default();
        let line = Line { name: short(&name), knots, z, property: &property, place };
        match self.mapping.curve(line)? {
            Some(curve) => self.curves.push(std::sync::Arc::new(curve)),
            None => self.bare += 1,
        }
        Ok(())
    }

    fn finish(self) -> Result<Imported, CurveError> {
        let mut warnings = Vec::new();
        if self.others > 0 {
            warnings.push(format!("{} geometries that are no lines were left out", self.others));
        }
        if self.bare > 0 {
            warnings.push(format!("{} lines on which the mapping sets nothing were left out", self.bare));
        }
        if self.degrees && !self.curves.is_empty() {
            warnings.push("all positions could be longitudes and latitudes; metres are expected".to_owned());
        }
        Ok(Imported { curves: Curves::new(self.curves)?, warnings })
    }
}

/// A number, a text that is one, or a list of numbers.
fn property(json: &Json, name: &str) -> Result<Option<Property>, String> {
    let bad = || {
        let got: String = json.to_string().chars().take(60).collect();
        format!("property `{name}` must be a number or a list of numbers, got {got}")
    };
    match json {
        Json::Null => Ok(None),
        Json::Number(n) => n.as_f64().map(Property::Number).map(Some).ok_or_else(bad),
        Json::String(text) => text
            .trim()
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .map(Property::Number)
            .map(Some)
            .ok_or_else(bad),
        Json::Array(items) => {
            let numbers: Option<Vec<f64>> = items.iter().map(Json::as_f64).collect();
            numbers.map(Property::List).map(Some).ok_or_else(bad)
        }
        Json::Bool(_) | Json::Object(_) => Err(bad()),
    }
}
