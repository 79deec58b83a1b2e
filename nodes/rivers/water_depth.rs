//! The water on the ground.

use crate::prelude::*;

/// Measures how deep the water of lakes stands over the ground.
///
/// `depth = max(level − height, 0)` where the label names a lake, and 0 elsewhere. Level and label are those of `lakes`;
/// the ground may be of any size and finer than they are, so that shores follow it.
///
/// # Limits
/// Where a lake spills, its water ends half a cell of the base grid beyond the last sample of the lake.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WaterDepth {}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
        /// Level of the water in the lakes.
        level: Field,
        /// Where the lakes are: the number of each, 0 off the lakes.
        label: Field,
    }
    pub struct Outputs {
        /// Depth of the water, in metres.
        depth: Field = Meaning::Fixed(Quantity::Depth),
        /// Where there is water: 1, and 0 elsewhere.
        water: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for WaterDepth {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&["lake", "mask", "bathymetry", "shore"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn run(&self, cx: &Context<'_>, Inputs { height, level, label }: Inputs) -> Result<Outputs> {
        let [height, level, label] = [height, level, label].map(|field| field.crop(&cx.grid));
        let depth = cx.stage(0.0, 0.7).fill(Quantity::Depth, |row, out: &mut [f32]| {
            let inputs = height.row(row.j).iter().zip(level.row(row.j)).zip(label.row(row.j));
            for (depth, ((&height, &level), &label)) in out.iter_mut().zip(inputs) {
                // A difference of two heights of opposite sign may be too large for an f32.
                *depth = if label > 0.0 { (level - height).clamp(0.0, f32::MAX) } else { 0.0 };
            }
        })?;
        let wet = |depth: f32| f32::from(u8::from(depth > 0.0));
        let water = cx.stage(0.7, 1.0).map(&depth, Quantity::Mask, wet)?;
        Ok(Outputs { depth, water })
    }
}
