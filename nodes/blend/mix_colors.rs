//! From one set of colours to another.

use crate::kit::color::{oklab_from_srgb, srgb_from_oklab};
use crate::kit::rows::lerp;
use crate::prelude::*;

/// Goes from colours to others, by an amount and a mask: layers of ground on a map.
///
/// Colours between the two run through Oklab, so that they are neither muddy nor banded \[ottosson2020\]. Where the share,
/// `amount · mask`, is 0 or 1, `a` or `b` come out to the bit.
///
/// # See also
/// `colorize` to make colours, `mix` for fields.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MixColors {
    /// Share of `b`; with a mask, its share where the mask is 1.
    pub amount: Ratio,
}

impl Default for MixColors {
    fn default() -> Self {
        Self { amount: Ratio(1.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Colours where the mask is 0, or the amount.
        a: Colors,
        /// Colours where mask and amount are 1.
        b: Colors,
        /// Where `b` lies: 0 keeps `a`, 1 takes `b`.
        mask: Option<Field>,
        /// Brightness, 0 to 1, to multiply the mixed colours with.
        shade: Option<Field>,
    }
    pub struct Outputs {
        /// The colours, sRGB encoded.
        colors: Colors,
    }
}

impl Node for MixColors {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["ottosson2020"])
        .keywords(&["color", "colour", "blend", "layer", "texture", "material", "splat"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 60.0).with_fields(grid, 8.0)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let [a, b] = [&input.a, &input.b].map(|colors| colors.crop(&cx.grid));
        let crop = |field: Option<Field>| field.map(|field| field.crop(&cx.grid));
        let (mask, shade) = (crop(input.mask), crop(input.shade));
        let amount = self.amount.0 as f32;
        let colors = cx.fill(Quantity::Color, |row, out: &mut [[f32; 3]]| {
            let (a, b) = (a.row(row.j), b.row(row.j));
            let (mask, shade) = (mask.as_ref().map(|f| f.row(row.j)), shade.as_ref().map(|f| f.row(row.j)));
            for (i, out) in out.iter_mut().enumerate() {
                let share = amount * mask.map_or(1.0, |mask| mask[i].clamp(0.0, 1.0));
                let light = shade.map_or(1.0, |shade| shade[i].clamp(0.0, 1.0));
                *out = between(a[i], b[i], share).map(|channel| channel * light);
            }
        })?;
        Ok(Outputs { colors })
    }
}

/// A colour between two, both sRGB encoded.
fn between(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    match share {
        0.0 => a,
        1.0 => b,
        share => {
            let (a, b) = (oklab_from_srgb(a), oklab_from_srgb(b));
            srgb_from_oklab([0, 1, 2].map(|k| lerp(a[k], b[k], share))).map(|channel| channel.clamp(0.0, 1.0))
        }
    }
}
