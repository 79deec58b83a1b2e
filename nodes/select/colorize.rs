//! Colours by the values of a field.

use std::sync::Arc;

use crate::kit::ramp::{self, Blend, Palette, Ramp};
use crate::prelude::*;

/// Colours a field by a ramp: heights as on a wall map, or any other field.
///
/// The value at `low` takes the first colour of the ramp, the value at `high` the last; between stops the colours
/// run through Oklab, so that they are neither muddy nor banded \[ottosson2020\]. A shade, such as that of
/// `hillshade`, multiplies the colours as stored.
///
/// # Limits
/// An automatic range is the lowest and highest value on the base grid.
///
/// # See also
/// `hillshade` and `occlusion` for the shade, `select_slope` for the slope that the satellite palette can use.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Colorize {
    /// Which colours stand for which values.
    pub palette: Palette,
    /// How colours pass from stop to stop.
    pub blend: Blend,
    /// Which values take the first and the last colour.
    pub range: Range,
    /// Turns the ramp around.
    pub reverse: bool,
    /// How much of the shade to apply.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub shading: Ratio,
}

/// Which values take the first and the last colour of a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Range {
    /// The lowest and the highest value of the whole terrain.
    #[default]
    Auto,
    /// Values of one's own, in the unit of the field.
    Fixed {
        /// Value of the first colour.
        #[schemars(range(min = -1e9, max = 1e9), extend("x-soft" = [0.0, 3000.0]))]
        low: Number,
        /// Value of the last colour.
        #[schemars(range(min = -1e9, max = 1e9), extend("x-soft" = [0.0, 3000.0]))]
        high: Number,
    },
}

impl Default for Colorize {
    fn default() -> Self {
        Self {
            palette: Palette::Hypsometric,
            blend: Blend::Smooth,
            range: Range::Auto,
            reverse: false,
            shading: Ratio(1.0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Field to colour by.
        field: Field,
        /// Brightness, 0 to 1, to multiply the colours with.
        shade: Option<Field>,
        /// Slope in degrees, for the satellite palette.
        slope: Option<Field>,
    }
    pub struct Outputs {
        /// The colours, sRGB encoded.
        colors: Colors,
    }
}

impl Node for Colorize {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["ottosson2020", "zucker2019", "fritsch1980"]).keywords(&[
        "color",
        "colour",
        "gradient",
        "ramp",
        "hypsometric",
        "satellite",
        "texture",
        "map",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        // A cropped copy of each input, and the table of the ramp.
        let cost = Cost::per_sample(grid, 18.0).with_fields(grid, 3.0);
        Cost { bytes: cost.bytes + (1 << 20), ..cost }
    }

    fn check(&self) -> Result<()> {
        match self.range {
            Range::Fixed { low, high } if low.0 >= high.0 => {
                let message = format!("must have `low` below `high`, got {} and {}", low.0, high.0);
                Err(Error::Parameter { name: "range".into(), message })
            }
            _ => Ok(()),
        }
    }

    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        let extremes = |_: &Self, _: &Context<'_>, input: &Inputs| {
            let (low, high) = input.field.range().unwrap_or((0.0, 0.0));
            Ok(Summary(Arc::new([f64::from(low), f64::from(high)])))
        };
        (self.range == Range::Auto).then_some(extremes)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let (low, high) = match self.range {
            Range::Fixed { low, high } => (low.0, high.0),
            Range::Auto => match *cx.summary()?.0 {
                [low, high] => (low, high),
                _ => return Err(Error::Undeclared { what: "summary of two numbers" }),
            },
        };
        // A field of one value takes the first colour.
        let per_unit = if high > low { 1.0 / (high - low) } else { 0.0 };
        // A choice of numbers, made once, so that nothing is chosen for a sample.
        let (whole, turn) = if self.reverse { (1.0, -1.0) } else { (0.0, 1.0) };
        let share = |v: f32| whole + turn * ((f64::from(v) - low) * per_unit) as f32;
        let ramp = Ramp::of(&self.palette, self.blend);
        let field = input.field.crop(&cx.grid);
        let shade = input.shade.map(|f| f.crop(&cx.grid));
        let slope = input.slope.map(|f| f.crop(&cx.grid)).filter(|_| self.palette == Palette::Satellite);
        let strength = self.shading.0 as f32;
        let colors = cx.fill(Quantity::Color, |row, out: &mut [[f32; 3]]| {
            let values = field.row(row.j);
            match &slope {
                Some(slope) => {
                    let each = out.iter_mut().zip(values.iter().zip(slope.row(row.j)));
                    each.for_each(|(o, (&v, &slope))| *o = ramp::satellite(share(v), slope));
                }
                None => {
                    let places = |first: usize, ts: &mut [f32]| {
                        ts.iter_mut().zip(&values[first..]).for_each(|(t, &v)| *t = share(v));
                    };
                    ramp.row(places, out);
                }
            }
            for (o, s) in out.iter_mut().zip(shade.iter().flat_map(|s| s.row(row.j))) {
                let factor = 1.0 - strength * (1.0 - s.clamp(0.0, 1.0));
                *o = [o[0] * factor, o[1] * factor, o[2] * factor];
            }
        })?;
        Ok(Outputs { colors })
    }
}
