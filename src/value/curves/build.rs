//! Making curves, and the checks that every curve has passed.

use super::bezier::Point;
use super::{
    ConstraintPoint, Curve, Cut, Fault, MAX_ANGLE, MAX_COORDINATE, MAX_EXTENT, MAX_HEIGHT, MAX_PIECES,
    MAX_POINTS, MIN_LENGTH, Profile, Rise, Track, Tracks,
};

/// What a value of a group is called and where it may lie.
type Limit = (&'static str, f64, f64);

const ELEVATION: [Limit; 2] = [("h", -MAX_HEIGHT, MAX_HEIGHT), ("r", 0.0, MAX_EXTENT)];
const SLOPE: [Limit; 4] = [
    ("the left extent", 0.0, MAX_EXTENT),
    ("the right extent", 0.0, MAX_EXTENT),
    ("the left angle", -MAX_ANGLE, MAX_ANGLE),
    ("the right angle", -MAX_ANGLE, MAX_ANGLE),
];
const NOISE: [Limit; 2] = [("the amplitude", 0.0, MAX_HEIGHT), ("the roughness", 0.0, 1.0)];
const ENVELOPE: [Limit; 2] = [("the left width", 0.0, MAX_EXTENT), ("the right width", 0.0, MAX_EXTENT)];

/// The keys of each group, before they are checked.
#[derive(Clone, Debug, Default)]
pub struct Keys {
    /// `u`, h, r.
    pub elevation: Vec<(f64, [f64; 2])>,
    /// `u`, a, b, θ, φ.
    pub slope: Vec<(f64, [f64; 4])>,
    /// `u`, A, R.
    pub noise: Vec<(f64, [f64; 2])>,
    /// `u`, `l_l`, `l_r`.
    pub envelope: Vec<(f64, [f64; 2])>,
}

impl Keys {
    fn tracks(self) -> Result<Tracks, Fault> {
        let tracks = Tracks {
            elevation: track("height", &ELEVATION, self.elevation)?,
            slope: track("slope", &SLOPE, self.slope)?,
            noise: track("noise", &NOISE, self.noise)?,
            envelope: track("envelope", &ENVELOPE, self.envelope)?,
        };
        if tracks == Tracks::default() {
            return Err(Fault::new(
                "has no constraint; at least one point with height, slope, noise or envelope",
            ));
        }
        Ok(tracks)
    }
}

fn track<const N: usize>(
    group: &str,
    limits: &[Limit; N],
    keys: Vec<(f64, [f64; N])>,
) -> Result<Option<Track<N>>, Fault> {
    if keys.len() > MAX_POINTS {
        return Err(Fault(format!("`{group}` may have {MAX_POINTS} points, got {}", keys.len())));
    }
    let mut before = f64::NEG_INFINITY;
    for (i, (u, values)) in keys.iter().enumerate() {
        let bad = |message: String| Err(Fault(format!("`{group}` point {i}: {message}")));
        if !(0.0..=1.0).contains(u) {
            return bad(format!("u must be a number from 0 to 1, got {u}"));
        }
        if *u <= before {
            return bad(format!("u must rise from point to point, got {u} after {before}"));
        }
        before = *u;
        for (&(name, min, max), value) in limits.iter().zip(values) {
            if !(min..=max).contains(value) {
                return bad(format!("{name} must be a number from {min} to {max}, got {value}"));
            }
        }
    }
    // −0 as 0, so that two spellings of one value are one.
    let plain = |(u, v): (f64, [f64; N])| (u + 0.0, v.map(|x| x + 0.0));
    Ok(Track::new(keys.into_iter().map(plain).collect()))
}

impl Curve {
    /// A curve from its anchors and handles (a start, then two handles and an end for each piece; metres) and its
    /// constraint points in the order of `u`.
    ///
    /// # Errors
    /// Names the point, the value found and what it may be.
    pub fn new(
        name: impl Into<String>,
        knots: Vec<Point>,
        points: &[ConstraintPoint],
        rise: Rise,
    ) -> Result<Self, Fault> {
        let mut keys = Keys::default();
        for p in points {
            keys.elevation.extend(p.elevation.map(|e| (p.u, [e.height, e.radius])));
            let sides = |s: super::Slope| [s.left_extent, s.right_extent, s.left_angle, s.right_angle];
            keys.slope.extend(p.slope.map(|s| (p.u, sides(s))));
            keys.noise.extend(p.noise.map(|n| (p.u, [n.amplitude, n.roughness])));
            keys.envelope.extend(p.envelope.map(|e| (p.u, [e.left, e.right])));
        }
        Self::from_keys(name.into(), knots, keys, rise)
    }

    /// A curve from the keys of each group.
    ///
    /// # Errors
    /// As [`Curve::new`].
    pub fn from_keys(name: String, knots: Vec<Point>, keys: Keys, rise: Rise) -> Result<Self, Fault> {
        check_knots(&knots)?;
        let tracks = keys.tracks()?;
        Self::finish(name, knots, tracks, rise)
    }

    /// The same curve with other knots, of the same number, and other attributes at the same `u`.
    pub(crate) fn mapped(
        &self,
        point: impl Fn(Point) -> Point,
        tracks: impl FnOnce(&Tracks) -> Tracks,
    ) -> Result<Self, Fault> {
        let knots: Vec<_> = self.knots.iter().map(|&p| point(p)).collect();
        let mapped = tracks(&self.tracks);
        let keys = Keys {
            elevation: mapped.elevation.map_or(Vec::new(), |t| t.keys().to_vec()),
            slope: mapped.slope.map_or(Vec::new(), |t| t.keys().to_vec()),
            noise: mapped.noise.map_or(Vec::new(), |t| t.keys().to_vec()),
            envelope: mapped.envelope.map_or(Vec::new(), |t| t.keys().to_vec()),
        };
        Self::from_keys(self.name.clone(), knots, keys, self.rise)
    }

    fn finish(name: String, knots: Vec<Point>, tracks: Tracks, rise: Rise) -> Result<Self, Fault> {
        let knots: Vec<_> = knots.into_iter().map(|p| p.map(|x| x + 0.0)).collect();
        let heights = |t: &Track<2>| t.keys().iter().map(|&(u, [h, _])| [u, h]).collect();
        let profile = tracks.elevation.as_ref().map(|t| Profile::new(heights(t), rise));
        let pieces = (knots.len() - 1) / 3;
        let mut curve = Self { name, knots, ends: Vec::new(), tracks, profile, rise, cuts: Vec::new() };
        let mut total = 0.0;
        for i in 0..pieces {
            total += curve.piece(i).length(0.0, 1.0);
            curve.ends.push(total);
        }
        if total < MIN_LENGTH {
            return Err(Fault(format!("must be at least {MIN_LENGTH} m long, got {total} m")));
        }
        let inner = curve.tracks.places().into_iter().filter(|&u| u > 0.0 && u < 1.0);
        curve.cuts = inner
            .map(|u| {
                let (piece, t) = curve.place(u);
                Cut { piece, t, u }
            })
            .collect();
        Ok(curve)
    }
}

fn check_knots(knots: &[Point]) -> Result<(), Fault> {
    if knots.len() < 4 || !(knots.len() - 1).is_multiple_of(3) {
        let n = knots.len();
        return Err(Fault(format!(
            "needs a start, then two handles and an end for each piece: 4, 7, 10, … points, got {n}"
        )));
    }
    let pieces = (knots.len() - 1) / 3;
    if pieces > MAX_PIECES {
        return Err(Fault(format!("may have {MAX_PIECES} pieces, got {pieces}")));
    }
    let out = |p: &Point| !p.iter().all(|x| x.abs() <= MAX_COORDINATE);
    match knots.iter().position(out) {
        Some(i) => {
            Err(Fault(format!("point {i} must lie within {MAX_COORDINATE} m of zero, got {:?}", knots[i])))
        }
        None => Ok(()),
    }
}
