//! What the short forms of curves share: kinds with few parameters that expand to full feature curves, whose profiles
//! are those of Figures 5 to 8 \[hnaidi2010, 3.2\].
//!
//! On a strip of extent a the norm of the gradient fades linearly, so the ground rises or falls by `a · tan θ / 2` in
//! all: `crack` and `cliff` take a height and derive their extents from it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::node::Cost;
use crate::units::{Metres, Ratio};
use crate::value::curves::bezier::{Point, shares};
use crate::value::curves::{ConstraintPoint, CurveError, Elevation, Envelope, Fault, Rise, Slope, smooth};
use crate::value::{Curve, Curves};

/// Roughness of the ground along a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Grain {
    /// The curve says nothing about it.
    #[default]
    Unset,
    /// It is set.
    Set {
        /// Amplitude of the noise.
        #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 300.0]))]
        amplitude: Metres,
        /// Roughness of the noise: 0 smooth, 1 as much of every octave.
        roughness: Ratio,
    },
}

/// A side of a curve, for somebody who walks along it and looks ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Side")]
pub enum CurveSide {
    /// North of a curve to the east.
    #[default]
    Left,
    /// South of a curve to the east.
    Right,
}

/// What a short form puts on its curve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ground {
    /// Radius of the plateau, in metres.
    pub radius: f64,
    /// Extents and angles.
    pub slope: Option<Slope>,
    /// Roughness of the ground.
    pub grain: Grain,
    /// Width of the smoothed strip, in metres.
    pub blend: f64,
}

/// A smooth curve through points, with heights where there are some.
///
/// # Errors
/// Names the point or value.
pub fn curve(
    name: &str,
    points: &[Point],
    heights: Option<&[f64]>,
    ground: Ground,
) -> Result<Curves, CurveError> {
    let named = |fault: Fault| CurveError::Curve { number: 0, name: name.to_owned(), fault };
    let through = |fault: Fault| named(Fault(format!("`through` {fault}")));
    // Points that repeat the one before are left out of the line, so their heights are, too.
    let kept: Vec<usize> = (0..points.len()).filter(|&i| i == 0 || points[i] != points[i - 1]).collect();
    let knots = smooth::through(&kept.iter().map(|&i| points[i]).collect::<Vec<_>>()).map_err(through)?;
    let shares = shares(&knots);
    let mut all = vec![ConstraintPoint {
        slope: ground.slope,
        noise: match ground.grain {
            Grain::Unset => None,
            Grain::Set { amplitude, roughness } => Some([amplitude.0, roughness.0].into()),
        },
        envelope: (ground.blend > 0.0).then_some(Envelope { left: ground.blend, right: ground.blend }),
        ..ConstraintPoint::default()
    }];
    for (k, (&i, &u)) in kept.iter().zip(&shares).enumerate() {
        let elevation = heights.map(|h| Elevation { height: h[i], radius: ground.radius });
        if k == 0 {
            all[0].elevation = elevation;
        } else if elevation.is_some() && all.last().is_none_or(|p| p.u < u) {
            all.push(ConstraintPoint { u, elevation, ..ConstraintPoint::default() });
        }
    }
    Ok(Curves::one(Curve::new(name, knots, &all, Rise::Monotone).map_err(named)?))
}

/// East and south, and the height, of points given together.
pub fn apart(points: &[[Metres; 3]]) -> (Vec<Point>, Vec<f64>) {
    (points.iter().map(|p| [p[0].0, p[1].0]).collect(), points.iter().map(|p| p[2].0).collect())
}

/// East and south of points.
pub fn places(points: &[[Metres; 2]]) -> Vec<Point> {
    points.iter().map(|p| p.map(|x| x.0)).collect()
}

/// The extent over which ground of this angle rises or falls by a height.
pub fn extent(height: f64, degrees: f64) -> f64 {
    2.0 * height / libm::tan(degrees.to_radians())
}

/// What expanding a curve through some points costs.
pub fn cost(points: usize) -> Cost {
    Cost { bytes: 4096 + 256 * points as u64, seconds: points as f64 * 1e-6 }
}

/// Makes a struct of parameters with a method `curves` a node kind that gives its feature curve: a short form takes no
/// input, has no grid and is checked by making the curve.
macro_rules! short_form {
    ($kind:ident, $keywords:expr) => {
        ports! {
            pub struct Inputs {}
            pub struct Outputs {
                /// The feature curve.
                curves: Curves,
            }
        }

        impl Node for $kind {
            type In = Inputs;
            type Out = Outputs;
            const META: Meta = Meta::new().quick().cite(&["hnaidi2010"]).keywords(&$keywords);

            fn reach(&self) -> Reach {
                Reach::Gridless
            }

            fn cost(&self, _: &Load<'_>) -> Cost {
                super::short::cost(self.through.len())
            }

            fn check(&self) -> Result<()> {
                self.curves().map(|_| ())
            }

            fn run(&self, _: &Context<'_>, _: Inputs) -> Result<Outputs> {
                Ok(Outputs { curves: self.curves()? })
            }
        }
    };
}
pub(super) use short_form;
