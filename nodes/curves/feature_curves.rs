//! Curves drawn by hand.

use crate::prelude::*;
use crate::value::curves::CurveSpec;

/// Holds feature curves that an artist draws: ridges, riverbeds, cliffs, whatever gives the land its shape.
///
/// A curve is a piecewise cubic Bézier in metres, x to the east and y to the south. At places along it, given as the
/// share `u` of its length, stand any of four groups of values [hnaidi2010, section 3.1; weiss2015, chapter V]: height
/// and radius of a plateau; how far and how steeply the ground slopes on the left and on the right; amplitude and
/// roughness of noise; how wide the strip is that is smoothed into an existing terrain. Left and right are those of
/// somebody who walks along growing `u`; angles are positive where the ground rises away from the curve. Between two
/// places values change linearly, the height along a cubic that does not overshoot; beyond the first and the last they
/// are held, so that both ends carry every group of the curve. One place is enough: what it says then holds along the
/// whole curve. A curve without any place, or without a line, is an error that names the curve.
///
/// A curve is written in as few numbers as will do: `{ "through": [x, y, …], "height": [u, h, r, …], "slope": [u, a, b,
/// θ, φ, …] }`.
///
/// # Limits
/// It gives no field: `curve_raster` and `diffuse` make one.
///
/// # See also
/// `ridge_line`, `river_bed`, `cliff`, `hill` and `crack` make one curve of a kind from few numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FeatureCurves {
    /// The curves. The line of each is one of `bezier`, `through` and `line`; of `height`, `slope`, `noise` and `envelope`
    /// at least one is there.
    #[schemars(
        length(max = 4096),
        extend(
            "x-widget" = Widget::Curves,
            "examples" = [[{
                "name": "crest", "through": [1600, 4600, 3400, 3700, 6400, 4200],
                "height": [0, 500, 0, 0.5, 1100, 20, 1, 650, 0], "slope": [0, 900, 700, -35, -40],
                "noise": [0, 60, 0.3],
            }]],
        )
    )]
    pub curves: Vec<CurveSpec>,
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// The curves, in the order of the list.
        curves: Curves,
    }
}

impl Node for FeatureCurves {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().quick().cite(&["hnaidi2010", "weiss2015"]).keywords(&[
        "draw",
        "spline",
        "bezier",
        "ridge",
        "river",
        "constraint",
        "sketch",
    ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, _: &Load<'_>) -> Cost {
        let numbers = |c: &CurveSpec| {
            let line = c.bezier.len() + c.through.len() + c.line.len();
            line + c.height.len() + c.slope.len() + c.noise.len() + c.envelope.len()
        };
        let numbers: usize = self.curves.iter().map(numbers).sum();
        let n = self.curves.len();
        Cost {
            bytes: 4096 * n as u64 + 64 * numbers as u64,
            seconds: n as f64 * 2e-6 + numbers as f64 * 1e-6,
        }
    }

    fn check(&self) -> Result<()> {
        self.build().map(|_| ())
    }

    fn run(&self, _: &Context<'_>, _: Inputs) -> Result<Outputs> {
        Ok(Outputs { curves: self.build()? })
    }
}

impl FeatureCurves {
    fn build(&self) -> Result<Curves> {
        let wrong = |e: crate::value::curves::CurveError| Error::Parameter {
            name: "curves".into(),
            message: format!("has a fault: {e}"),
        };
        Curves::from_specs(&self.curves).map_err(wrong)
    }
}
