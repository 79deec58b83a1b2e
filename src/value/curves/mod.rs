//! Feature curves: lines in the plane that say how high, how steep and how rough the ground beside them is.
//!
//! A curve is a piecewise cubic Bézier in metres, x to the east and y to the south. Constraint points stand at `u`,
//! the share of its length from its start, and carry any of four groups \[hnaidi2010, 3.1; weiss2015, V-D\]:
//!
//! | group | values |
//! | --- | --- |
//! | elevation | height h (m), radius r of the plateau on both sides (m) |
//! | slope | extents a to the left and b to the right, from the edge of the plateau (m); angles θ left and φ right (degrees), positive where the ground rises away from the curve |
//! | noise | amplitude A (m), roughness R (0 to 1) |
//! | envelope | widths `l_l` and `l_r` of the smoothed strip beyond the slopes (m) |
//!
//! **Left and right** are those of somebody who walks along growing `u` and looks ahead: on a curve to the east, left
//! is north. Since y grows to the south, left of the heading `(tx, ty)` is `(ty, −tx)`.
//!
//! Between two points that carry a group its values go linearly with `u`, h along a cubic that does not overshoot
//! ([`Rise`]); before the first and after the last they are held. So each end carries every group of its curve, and
//! a value that does not change is written once.
//!
//! # Differs from the paper
//! The paper asks for constraint points at both ends; here values are held to them. Its height is a free cubic, here
//! [`Rise::Free`]; the default does not overshoot. `u` is the share of the length, where the paper says "linear
//! coordinate along the spline".

pub mod bezier;
mod build;
pub mod edit;
mod error;
mod object;
pub mod smooth;
mod spec;
mod track;

use std::sync::Arc;

use bezier::{Cubic, Point};
pub use build::Keys;
pub use error::{CurveError, Fault};
pub use spec::CurveSpec;
pub use track::{Profile, Rise, Track, hermite_value};

/// Most curves in one value.
pub const MAX_CURVES: usize = 65_536;
/// Most Bézier pieces of a curve.
pub const MAX_PIECES: usize = 16_384;
/// Most constraint points of a group of a curve.
pub const MAX_POINTS: usize = 4096;
/// Farthest coordinate from zero, in metres, as for terrains.
pub const MAX_COORDINATE: f64 = 1e8;
/// Highest and, negated, lowest height, in metres.
pub const MAX_HEIGHT: f64 = 1e5;
/// Largest radius, extent or width, in metres.
pub const MAX_EXTENT: f64 = 1e6;
/// Steepest angle, in degrees; its tangent is 57.
pub const MAX_ANGLE: f64 = 89.0;
/// Shortest curve, in metres.
pub const MIN_LENGTH: f64 = 1e-3;

/// The height of a curve and the flat ground beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elevation {
    /// Height h, in metres.
    pub height: f64,
    /// Radius r of the plateau on both sides, in metres.
    pub radius: f64,
}

/// How the ground slopes beside a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Extent a on the left, from the edge of the plateau, in metres.
    pub left_extent: f64,
    /// Extent b on the right, in metres.
    pub right_extent: f64,
    /// Angle θ on the left, in degrees, positive where the ground rises away from the curve.
    pub left_angle: f64,
    /// Angle φ on the right, in degrees.
    pub right_angle: f64,
}

/// How rough the ground on a curve is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Amplitude A, in metres.
    pub amplitude: f64,
    /// Roughness R, from 0 to 1.
    pub roughness: f64,
}

/// How far beyond the slopes the ground is smoothed into an existing terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope {
    /// Width `l_l` on the left, in metres.
    pub left: f64,
    /// Width `l_r` on the right, in metres.
    pub right: f64,
}

/// A place on a curve and what holds there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConstraintPoint {
    /// Share of the length from the start of the curve, from 0 to 1.
    pub u: f64,
    /// Height and plateau.
    pub elevation: Option<Elevation>,
    /// Extents and angles.
    pub slope: Option<Slope>,
    /// Amplitude and roughness.
    pub noise: Option<Noise>,
    /// Smoothed strip.
    pub envelope: Option<Envelope>,
}

impl From<[f64; 2]> for Elevation {
    fn from([height, radius]: [f64; 2]) -> Self {
        Self { height, radius }
    }
}

impl From<[f64; 4]> for Slope {
    fn from([left_extent, right_extent, left_angle, right_angle]: [f64; 4]) -> Self {
        Self { left_extent, right_extent, left_angle, right_angle }
    }
}

impl From<[f64; 2]> for Noise {
    fn from([amplitude, roughness]: [f64; 2]) -> Self {
        Self { amplitude, roughness }
    }
}

impl From<[f64; 2]> for Envelope {
    fn from([left, right]: [f64; 2]) -> Self {
        Self { left, right }
    }
}

/// The groups of a curve, each along `u`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tracks {
    /// h and r.
    pub elevation: Option<Track<2>>,
    /// a, b, θ and φ.
    pub slope: Option<Track<4>>,
    /// A and R.
    pub noise: Option<Track<2>>,
    /// `l_l` and `l_r`.
    pub envelope: Option<Track<2>>,
}

/// A constraint point's place among the pieces of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Number of the piece.
    pub piece: usize,
    /// Parameter in the piece.
    pub t: f64,
    /// Share of the length of the curve.
    pub u: f64,
}

/// One feature curve; it is valid, whoever made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    name: String,
    knots: Vec<Point>,
    /// Length up to the end of each piece.
    ends: Vec<f64>,
    tracks: Tracks,
    profile: Option<Profile>,
    rise: Rise,
    /// Where attributes bend, without the ends of the curve.
    cuts: Vec<Cut>,
}

impl Curve {
    /// Its name, empty for none.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Anchors and handles: a start, then two handles and an end for each piece.
    pub fn knots(&self) -> &[Point] {
        &self.knots
    }

    /// Number of pieces.
    pub fn pieces(&self) -> usize {
        self.ends.len()
    }

    /// The `i`-th piece.
    pub fn piece(&self, i: usize) -> Cubic {
        let k = 3 * i;
        Cubic([self.knots[k], self.knots[k + 1], self.knots[k + 2], self.knots[k + 3]])
    }

    /// The length up to the start and up to the end of the `i`-th piece, in metres.
    pub fn piece_span(&self, i: usize) -> [f64; 2] {
        [if i == 0 { 0.0 } else { self.ends[i - 1] }, self.ends[i]]
    }

    /// Its length, in metres.
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// Whether it ends where it starts.
    pub fn is_closed(&self) -> bool {
        self.knots.first() == self.knots.last()
    }

    /// The groups along `u`.
    pub fn tracks(&self) -> &Tracks {
        &self.tracks
    }

    /// How its height goes from point to point.
    pub fn rise(&self) -> Rise {
        self.rise
    }

    /// Where attributes bend, in the order of `u`, without the ends of the curve.
    pub fn cuts(&self) -> &[Cut] {
        &self.cuts
    }

    /// The piece and its parameter at a share of the length, which is clipped to 0 to 1.
    pub fn place(&self, u: f64) -> (usize, f64) {
        let s = u.clamp(0.0, 1.0) * self.length();
        let i = self.ends.partition_point(|&end| end < s).min(self.ends.len() - 1);
        let [from, to] = self.piece_span(i);
        (i, self.piece(i).param_at(s - from, to - from))
    }

    /// The point at a share of the length, in metres.
    pub fn point(&self, u: f64) -> Point {
        let (i, t) = self.place(u);
        self.piece(i).at(t)
    }

    /// The heading at a share of the length, of length one; where two pieces meet, that of the earlier one.
    pub fn heading(&self, u: f64) -> Point {
        let (i, t) = self.place(u);
        // A piece of no length has no heading of its own; a valid curve has one that does.
        let near = (i..self.pieces()).chain((0..i).rev());
        near.map(|k| (k, if k == i { t } else { f64::from(u8::from(k < i)) }))
            .find_map(|(k, t)| self.piece(k).heading(t))
            .unwrap_or([1.0, 0.0])
    }

    /// The height at a share of the length, in metres, where the curve has one.
    pub fn height(&self, u: f64) -> Option<f64> {
        self.profile.as_ref().map(|p| p.at(u, false)[0])
    }

    /// The profile of the height, where the curve has one.
    pub fn profile(&self) -> Option<&Profile> {
        self.profile.as_ref()
    }

    /// All that holds at a share of the length.
    pub fn attributes(&self, u: f64) -> ConstraintPoint {
        let Tracks { elevation, slope, noise, envelope } = &self.tracks;
        let height = self.height(u);
        ConstraintPoint {
            u,
            elevation: elevation
                .as_ref()
                .map(|t| Elevation { height: height.unwrap_or(0.0), radius: t.at(u)[1] }),
            slope: slope.as_ref().map(|t| t.at(u).into()),
            noise: noise.as_ref().map(|t| t.at(u).into()),
            envelope: envelope.as_ref().map(|t| t.at(u).into()),
        }
    }

    /// Its constraint points in the order of `u`, each with the groups that are set there.
    pub fn points(&self) -> Vec<ConstraintPoint> {
        fn key<const N: usize, T: From<[f64; N]>>(track: &Option<Track<N>>, u: f64) -> Option<T> {
            let (_, value) = track.as_ref()?.keys().iter().find(|k| k.0 == u)?;
            Some((*value).into())
        }
        let t = &self.tracks;
        let one = |u: f64| ConstraintPoint {
            u,
            elevation: key(&t.elevation, u),
            slope: key(&t.slope, u),
            noise: key(&t.noise, u),
            envelope: key(&t.envelope, u),
        };
        t.places().into_iter().map(one).collect()
    }

    /// How far from it what it says may hold, at most: plateau, slope and smoothed strip together, in metres.
    pub fn reach(&self) -> f64 {
        let (plateau, beside) = self.tracks.widths();
        plateau + beside[0].max(beside[1])
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        let keys = self.tracks.places().len();
        (size_of::<Self>() + self.name.len() + 16 * self.knots.len() + 8 * self.ends.len() + 200 * keys)
            as u64
    }
}

impl Tracks {
    /// The widest plateau to one side, and the most that slope and smoothed strip together reach beyond it on the left
    /// and on the right, in metres.
    pub fn widths(&self) -> (f64, [f64; 2]) {
        let widest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let plateau = widest(&mut self.elevation.iter().flat_map(Track::keys).map(|(_, v)| v[1]));
        let beside = std::array::from_fn(|side| {
            let slope = widest(&mut self.slope.iter().flat_map(Track::keys).map(|(_, v)| v[side]));
            slope + widest(&mut self.envelope.iter().flat_map(Track::keys).map(|(_, v)| v[side]))
        });
        (plateau, beside)
    }

    /// Every `u` at which a group is set, rising.
    pub fn places(&self) -> Vec<f64> {
        let us =
            |t: &Option<Track<2>>| t.iter().flat_map(|t| t.keys().iter().map(|k| k.0)).collect::<Vec<_>>();
        let mut all = us(&self.elevation);
        all.extend(us(&self.noise));
        all.extend(us(&self.envelope));
        all.extend(self.slope.iter().flat_map(|t| t.keys().iter().map(|k| k.0)));
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }
}

/// Some feature curves; cheap to clone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves(Arc<[Arc<Curve>]>);

impl Curves {
    /// From valid curves.
    ///
    /// # Errors
    /// When there are more than [`MAX_CURVES`].
    pub fn new(curves: Vec<Arc<Curve>>) -> Result<Self, CurveError> {
        if curves.len() > MAX_CURVES {
            let found = curves.len() as u64;
            return Err(CurveError::TooMany { what: "curves", most: MAX_CURVES as u64, found });
        }
        Ok(Self(curves.into()))
    }

    /// One curve.
    pub fn one(curve: Curve) -> Self {
        Self([Arc::new(curve)].into())
    }

    /// From the form in which a file holds them.
    ///
    /// # Errors
    /// Names the curve, the group and the point.
    pub fn from_specs(specs: &[CurveSpec]) -> Result<Self, CurveError> {
        let one = |(number, spec): (usize, &CurveSpec)| {
            let curve = spec.build().map_err(|fault| {
                let name = spec.name.chars().take(64).collect();
                CurveError::Curve { number, name, fault }
            })?;
            Ok(Arc::new(curve))
        };
        Self::new(specs.iter().enumerate().map(one).collect::<Result<_, CurveError>>()?)
    }

    /// The form in which a file holds them.
    pub fn specs(&self) -> Vec<CurveSpec> {
        self.0.iter().map(|c| CurveSpec::of(c)).collect()
    }

    /// The curves in order.
    pub fn iter(&self) -> impl Iterator<Item = &Curve> {
        self.0.iter().map(|c| &**c)
    }

    /// The curves, shared.
    pub fn shared(&self) -> &[Arc<Curve>] {
        &self.0
    }

    /// Number of curves.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
