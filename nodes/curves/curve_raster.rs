//! Curves as constraints on a grid.

use crate::kit::curves::raster::{self, Options};
use crate::prelude::*;
use crate::value::curves::CurveError;

/// Puts feature curves on the base grid, as the constraints that `diffuse` starts from.
///
/// Beside each curve lies its plateau, on which height, amplitude and roughness are fixed, and beyond it on both sides
/// the slope, on which the steepness fades linearly to nothing [hnaidi2010, section 4.1]. Where fixed values of several
/// curves meet they are averaged. Where slopes of different curves meet, the ground lies between those that each of them
/// gives, the nearer curve counting for more. A curve with slopes and no height gives its gradient the other way round,
/// so that heights flow towards it and the slope stays what it is; across a cliff they flow down all the way.
///
/// Edges lie between samples: a sample beside one says how far off it is, and a slope says what it rises from sample to
/// sample, so that walls are smooth along their curves, not stairs of base cells.
///
/// # Differs from the paper
/// The paper leaves samples open where gradients meet. Diffusion then fills them with gradients that no ground has, and
/// land that follows these from both curves piles up to horns. The paper paints quadrangles over each other; here a
/// sample takes the gradient of its nearest place on the curve, so that a strip that folds over itself at a sharp bend
/// has neither holes nor spikes. Outer sides of bends are round. Beside free ground and around the ends of a curve a
/// slope is followed less and less, so that it shows no border. A plateau thinner than a cell marks a connected line of
/// samples. The strip that is smoothed into an existing terrain [weiss2015, chapter V] may fade over a share of its
/// width.
///
/// # Limits
/// It stands on the base grid: features narrower than two of its cells are coarse. Where the slope of a curve that has
/// no height (a crack, a cliff) meets another, samples are left open, as in the paper: cracks that cross dig deeper there.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CurveRaster {
    /// Share of the width of a smoothed strip over which it fades; at 0 it ends sharply.
    pub feather: Ratio,
}

ports! {
    pub struct Inputs {
        /// Feature curves.
        curves: Curves,
    }
    pub struct Outputs {
        /// What they say about the samples of the base grid.
        constraints: Constraints,
    }
}

impl Node for CurveRaster {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["hnaidi2010", "weiss2015"])
        .keywords(&["rasterize", "constraint", "plateau", "slope", "draw"])
        .migrations(&[|_| {}]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let usual = Cost { bytes: raster::BESIDE, ..Cost::per_sample(&load.grid, 15.0) };
        let curves: Option<Curves> = load.object("curves");
        curves.map_or(usual, |curves| Cost { seconds: raster::seconds(&curves, &load.grid), ..usual })
    }

    fn run(&self, cx: &Context<'_>, Inputs { curves }: Inputs) -> Result<Outputs> {
        let options = Options { feather: self.feather.0 };
        let stop = || cx.work.is_cancelled();
        let constraints = raster::rasterise(&curves, &cx.grid, &options, &stop);
        let named = |e| match e {
            CurveError::TooMany { .. } => {
                let message = format!("has {e}; simplify the curves or lower the base");
                Error::Input { port: "curves".into(), message }
            }
            other => Error::of_curves(other),
        };
        Ok(Outputs { constraints: constraints.map_err(named)? })
    }
}
