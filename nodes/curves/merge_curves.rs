//! Several sets of curves as one.

use crate::kit::curves::transform::merge;
use crate::prelude::*;

/// Puts several sets of feature curves together, in the order of the inputs.
///
/// # Limits
/// Where curves meet, `curve_raster` decides: fixed values are averaged, gradients left open.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MergeCurves {}

ports! {
    pub struct Inputs {
        /// First curves.
        a: Option<Curves>,
        /// Second curves.
        b: Option<Curves>,
        /// Third curves.
        c: Option<Curves>,
        /// Fourth curves.
        d: Option<Curves>,
        /// Fifth curves.
        e: Option<Curves>,
        /// Sixth curves.
        f: Option<Curves>,
    }
    pub struct Outputs {
        /// All curves.
        curves: Curves,
    }
}

impl Node for MergeCurves {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().quick().keywords(&["join", "append", "together", "union", "collect"]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let of = |port: &str| load.object::<Curves>(port).map_or(0, |curves| curves.len());
        let curves: usize = ["a", "b", "c", "d", "e", "f"].map(of).iter().sum();
        // A pointer for each, twice while they are collected.
        Cost { bytes: (1 << 20) + 32 * curves as u64, seconds: 1e-5 + curves as f64 * 5e-8 }
    }

    fn run(&self, _: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let Inputs { a, b, c, d, e, f } = input;
        Ok(Outputs { curves: merge([a, b, c, d, e, f].iter().flatten()).map_err(Error::of_curves)? })
    }
}
