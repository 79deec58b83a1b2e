//! A block of one terrain in another.

use crate::kit::diffusion;
use crate::kit::poisson::{Blend, Gradients};
use crate::kit::sample::finite;
use crate::prelude::*;

/// Sets a piece of one terrain into another without a seam: the forms of the one, at the height of the other.
///
/// Inside the region `T = k R + m`, with `R` the reference, `k` the gain and `m` a membrane: `Δm = 0` inside and
/// `m = S − k R` in the source `S` all around. So `T` has the slopes of `k R` and meets `S` at the edge of the region
/// \[perez2003; zhang2016, section 6\]. The region is wherever `mask` is above 0; the result is mixed by `mask` besides, so a
/// soft edge blends detail, too. With `mixed`, each difference between neighbours is that of `S` where it is larger, so
/// that ridges and valleys of both remain.
///
/// Only `m` comes from the base grid: inside, detail of the reference that is finer than the base shows, weighed by the
/// gain, and outside every bit of the source stays at any size.
///
/// # Differs from the paper
/// (7) of \[zhang2016\] is minus the Laplacian, so (6) has the wrong sign, and the right side of (9) is minus the divergence
/// plus the heights around. (8) takes the divergence of central differences: a terrain blended into itself then misses
/// itself by 4 % of its range. The region may have any shape, not a rectangle alone. Its edge on the border of the
/// terrain is free.
///
/// # Limits
/// It runs on the base grid. A region that covers the whole terrain leaves nothing to say how high the reference lies: the
/// result is `k R`, with a warning. With `mixed`, detail of the source that is finer than the base does not show inside.
///
/// # See also
/// `import_height` and `transform` place a reference; `mix` goes over between two terrains at the height they have.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PoissonBlend {
    /// Factor `k` on the slopes of the reference: 0 leaves a membrane, 1 the forms as they are, more exaggerates them.
    #[schemars(range(min = -100.0, max = 100.0), extend("x-soft" = [0.0, 2.0]))]
    pub gain: Number,
    /// Lets the steeper of source and reference decide, instead of the reference alone.
    pub mixed: bool,
}

impl Default for PoissonBlend {
    fn default() -> Self {
        Self { gain: Number(1.0), mixed: false }
    }
}

ports! {
    pub struct Inputs {
        /// Terrain around the region, in metres.
        source: Field,
        /// Terrain whose forms are set in, in metres, wherever it lies.
        reference: Field,
        /// The region: wherever it is above 0. 0 keeps the source, 1 takes the blend, between mixes the two.
        mask: Option<Field>,
    }
    pub struct Outputs {
        /// The blend, in the unit of the source.
        height: Field = Meaning::like("source"),
    }
}

impl Node for PoissonBlend {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["perez2003", "zhang2016"])
        .keywords(&["seamless", "clone", "stamp", "paste", "gradient", "block", "real terrain", "membrane"])
        .carries(&[("height", "reference")])
        .mixes(&[("height", "source")]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn keep(&self, _: &str) -> Detail {
        Detail::Times(self.gain.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let fields = if self.mixed { 30.0 } else { 29.0 };
        let cost = Cost::per_sample(grid, 320.0).with_fields(grid, fields);
        Cost { bytes: cost.bytes + diffusion::scratch(), ..cost }
    }

    fn run(&self, cx: &Context<'_>, Inputs { source, reference, mask }: Inputs) -> Result<Outputs> {
        let (source, reference) = (source.crop(&cx.grid), reference.crop(&cx.grid));
        let mask = match mask {
            Some(mask) => mask.crop(&cx.grid),
            None => Field::constant(cx.grid, Quantity::Mask, 1.0),
        };
        let blend = Blend {
            cols: cx.grid.cols,
            rows: cx.grid.rows,
            source: source.data(),
            reference: reference.data(),
            mask: mask.data(),
            gain: self.gain.0 as f32,
            gradients: if self.mixed { Gradients::Mixed } else { Gradients::Reference },
        };
        let blended = blend.run(&cx.work).map_err(|error| match error {
            diffusion::Error::Cancelled => Error::Cancelled,
            misfit => Error::Input { port: "source".into(), message: misfit.to_string() },
        })?;
        if blended.covers_all {
            cx.warn("the region covers the whole terrain, so the result is the reference at its own height");
        }
        let mut height = blended.field;
        height.iter_mut().for_each(|z| *z = finite(*z));
        Ok(Outputs { height: Field::new(cx.grid, source.quantity(), height) })
    }
}
