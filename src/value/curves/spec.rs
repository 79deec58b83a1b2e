//! The form of a curve in a file: few keys, flat lists of numbers, nothing that is a default.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bezier::Point;
use super::build::Keys;
use super::{Curve, Fault, Rise, Track, smooth};

/// One feature curve as a graph file holds it. Lists are flat and in metres, degrees and shares.
///
/// The line itself stands in one of `bezier`, `through` or `line`; of `height`, `slope`, `noise` and `envelope` at
/// least one is there. Each of these lists its points one after another in the order of `u`, the share of the length
/// (0 to 1); values go from point to point and are held beyond the first and last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CurveSpec {
    /// What it is called in messages and in the editor.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(length(max = 64))]
    pub name: String,
    /// Cubic pieces: x, y of the start, then of two handles and the end of each piece; x east and y south, metres.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 98_306),
        inner(range(min = -1e8, max = 1e8)),
        extend("x-unit" = "m", "x-items" = ["x", "y"])
    )]
    pub bezier: Vec<f64>,
    /// x, y of points that a smooth curve goes through, in metres.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 32_770),
        inner(range(min = -1e8, max = 1e8)),
        extend("x-unit" = "m", "x-items" = ["x", "y"])
    )]
    pub through: Vec<f64>,
    /// x, y of the corners of a line of straight pieces, in metres.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 32_770),
        inner(range(min = -1e8, max = 1e8)),
        extend("x-unit" = "m", "x-items" = ["x", "y"])
    )]
    pub line: Vec<f64>,
    /// Elevation: u, height, radius of the plateau; u, height, radius; …
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 12_288),
        inner(range(min = -1e5, max = 1e6)),
        extend("x-unit" = "m", "x-items" = ["u", "height", "radius"])
    )]
    pub height: Vec<f64>,
    /// Slope: u, extent to the left, to the right, angle on the left, on the right (degrees, positive where the ground
    /// rises away from the curve); …
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 20_480),
        inner(range(min = -89.0, max = 1e6)),
        extend("x-unit" = "m", "x-items" = ["u", "left extent", "right extent", "left angle", "right angle"])
    )]
    pub slope: Vec<f64>,
    /// Noise: u, amplitude, roughness (0 to 1); …
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 12_288),
        inner(range(min = 0.0, max = 1e5)),
        extend("x-unit" = "m", "x-items" = ["u", "amplitude", "roughness"])
    )]
    pub noise: Vec<f64>,
    /// Smoothed strip beyond the slopes: u, width to the left, to the right; …
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(
        length(max = 12_288),
        inner(range(min = 0.0, max = 1e6)),
        extend("x-unit" = "m", "x-items" = ["u", "left width", "right width"])
    )]
    pub envelope: Vec<f64>,
    /// How the height goes from point to point.
    #[serde(skip_serializing_if = "is_default")]
    #[schemars(extend("default" = "monotone"))]
    pub rise: Rise,
}

fn is_default(rise: &Rise) -> bool {
    *rise == Rise::default()
}

impl CurveSpec {
    /// The form of a curve.
    pub fn of(curve: &Curve) -> Self {
        fn flat<const N: usize>(track: &Option<Track<N>>) -> Vec<f64> {
            let keys = track.iter().flat_map(Track::keys);
            keys.flat_map(|(u, values)| std::iter::once(*u).chain(*values)).collect()
        }
        let tracks = curve.tracks();
        Self {
            name: curve.name().to_owned(),
            bezier: curve.knots().iter().flatten().copied().collect(),
            height: flat(&tracks.elevation),
            slope: flat(&tracks.slope),
            noise: flat(&tracks.noise),
            envelope: flat(&tracks.envelope),
            rise: curve.rise(),
            ..Self::default()
        }
    }

    /// The curve.
    ///
    /// # Errors
    /// Names the list, the point, the value found and what it may be.
    pub fn build(&self) -> Result<Curve, Fault> {
        let letters = self.name.chars().count();
        if letters > 64 {
            return Err(Fault(format!("`name` must be at most 64 characters, got {letters}")));
        }
        let keys = Keys {
            elevation: keys("height", "u, height, radius", &self.height)?,
            slope: keys("slope", "u, left extent, right extent, left angle, right angle", &self.slope)?,
            noise: keys("noise", "u, amplitude, roughness", &self.noise)?,
            envelope: keys("envelope", "u, left width, right width", &self.envelope)?,
        };
        Curve::from_keys(self.name.clone(), self.knots()?, keys, self.rise)
    }

    fn knots(&self) -> Result<Vec<Point>, Fault> {
        let lines = [("bezier", &self.bezier), ("through", &self.through), ("line", &self.line)];
        let mut set = lines.into_iter().filter(|(_, list)| !list.is_empty());
        let (name, list) = match (set.next(), set.next()) {
            (Some(only), None) => only,
            (None, _) => return Err(Fault::new("has no line; one of `bezier`, `through` or `line`")),
            (Some((a, _)), Some((b, _))) => {
                return Err(Fault(format!("has `{a}` and `{b}`; only one of them may be there")));
            }
        };
        let (points, rest) = list.as_chunks::<2>();
        if !rest.is_empty() {
            return Err(Fault(format!("`{name}` must list x, y, x, y, …, got {} numbers", list.len())));
        }
        let named = |fault: Fault| Fault(format!("`{name}` {fault}"));
        match name {
            "bezier" => Ok(points.to_vec()),
            "through" => smooth::through(points).map_err(named),
            _ => smooth::straight(points).map_err(named),
        }
    }
}

fn keys<const N: usize>(name: &str, form: &str, list: &[f64]) -> Result<Vec<(f64, [f64; N])>, Fault> {
    let stride = N + 1;
    if !list.len().is_multiple_of(stride) {
        let n = list.len();
        return Err(Fault(format!("`{name}` must list {stride} numbers a point ({form}), got {n}")));
    }
    let one = |point: &[f64]| (point[0], std::array::from_fn(|k| point[k + 1]));
    Ok(list.chunks_exact(stride).map(one).collect())
}
