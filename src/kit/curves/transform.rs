//! Moving, turning, scaling and mirroring curves, and putting several sets together.

use std::sync::Arc;

use rayon::prelude::*;

use crate::value::Curves;
use crate::value::curves::bezier::{Point, add, sub};
use crate::value::curves::{Curve, CurveError, Track, Tracks};

/// Which way curves are mirrored.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Mirror {
    /// Not at all.
    #[default]
    None,
    /// East and west change places.
    EastWest,
    /// North and south change places.
    NorthSouth,
}

/// What is done to curves: they are mirrored, scaled and turned about a point, in this order, and then moved.
///
/// Lengths along the ground (radius, extents, widths) scale with `scale`, heights with `height_scale`. Angles follow:
/// `tan θ` becomes `tan θ · height_scale / scale`. Mirroring changes left and right, so that what lay on a side of the
/// curve lies on its mirror image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Mirror.
    pub mirror: Mirror,
    /// Factor of all lengths along the ground, above 0.
    pub scale: f64,
    /// Turn in degrees, clockwise on the map (from north to east).
    pub rotate: f64,
    /// The point that stays where it is, in metres.
    pub pivot: Point,
    /// Way to the east and south, in metres.
    pub shift: Point,
    /// Factor of heights and amplitudes, 0 or above.
    pub height_scale: f64,
    /// Added to heights, in metres.
    pub raise: f64,
}

impl Default for Transform {
    fn default() -> Self {
        Self {
            mirror: Mirror::None,
            scale: 1.0,
            rotate: 0.0,
            pivot: [0.0; 2],
            shift: [0.0; 2],
            height_scale: 1.0,
            raise: 0.0,
        }
    }
}

/// Cosine and sine of degrees, exact at quarter turns.
fn turn(degrees: f64) -> [f64; 2] {
    let quarters = degrees / 90.0;
    if quarters == quarters.trunc() {
        return [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][quarters.rem_euclid(4.0) as usize & 3];
    }
    let (sin, cos) = libm::sincos(degrees.to_radians());
    [cos, sin]
}

impl Transform {
    /// The curves, transformed.
    ///
    /// # Errors
    /// When a parameter is out of its range or a curve leaves what a curve may be.
    pub fn apply(&self, curves: &Curves) -> Result<Curves, CurveError> {
        let check = |name, value: f64, min: f64, max: f64| {
            let message = format!("must be a number from {min} to {max}, got {value}");
            if (min..=max).contains(&value) { Ok(()) } else { Err(CurveError::Parameter { name, message }) }
        };
        check("scale", self.scale, 1e-6, 1e6)?;
        check("height_scale", self.height_scale, 0.0, 1e6)?;
        check("rotate", self.rotate, -36_000.0, 36_000.0)?;
        check("raise", self.raise, -1e6, 1e6)?;
        for (name, point) in [("pivot", self.pivot), ("shift", self.shift)] {
            point.iter().try_for_each(|&x| check(name, x, -1e9, 1e9))?;
        }
        let rotation = turn(self.rotate);
        let one = |(number, curve): (usize, &Arc<Curve>)| {
            let mapped = curve.mapped(|p| self.point(p, rotation), |t| self.tracks(t));
            let name = || curve.name().to_owned();
            mapped.map(Arc::new).map_err(|fault| CurveError::Curve { number, name: name(), fault })
        };
        let all: Vec<_> = curves.shared().par_iter().enumerate().map(one).collect();
        Curves::new(all.into_iter().collect::<Result<_, _>>()?)
    }

    fn point(&self, p: Point, [cos, sin]: [f64; 2]) -> Point {
        let [x, y] = sub(p, self.pivot).map(|v| v * self.scale);
        let [x, y] = match self.mirror {
            Mirror::None => [x, y],
            Mirror::EastWest => [-x, y],
            Mirror::NorthSouth => [x, -y],
        };
        add(add([x * cos - y * sin, x * sin + y * cos], self.pivot), self.shift)
    }

    fn tracks(&self, t: &Tracks) -> Tracks {
        let (k, v) = (self.scale, self.height_scale);
        let angle = |degrees: f64| {
            if k == v {
                return degrees;
            }
            libm::atan(libm::tan(degrees.to_radians()) * v / k).to_degrees()
        };
        let mirrored = self.mirror != Mirror::None;
        let sides = |[a, b]: [f64; 2]| if mirrored { [b, a] } else { [a, b] };
        let map2 = |t: &Option<Track<2>>, f: &dyn Fn([f64; 2]) -> [f64; 2]| t.as_ref().map(|t| t.mapped(f));
        let slope = |[a, b, left, right]: [f64; 4]| {
            let ([a, b], [left, right]) = (sides([a * k, b * k]), sides([angle(left), angle(right)]));
            [a, b, left, right]
        };
        Tracks {
            elevation: map2(&t.elevation, &|[h, r]| [h * v + self.raise, r * k]),
            slope: t.slope.as_ref().map(|t| t.mapped(slope)),
            noise: map2(&t.noise, &|[a, r]| [a * v, r]),
            envelope: map2(&t.envelope, &|w| sides(w.map(|w| w * k))),
        }
    }
}

/// All curves of several sets, in order.
///
/// # Errors
/// When there are too many together.
pub fn merge<'a>(sets: impl IntoIterator<Item = &'a Curves>) -> Result<Curves, CurveError> {
    Curves::new(sets.into_iter().flat_map(|c| c.shared().iter().cloned()).collect())
}
