//! Growing and shrinking by a disk.

use crate::kit::morphology::{self, Keep};
use crate::prelude::*;

/// Grows or shrinks the high parts of a field, such as a mask, by a radius in metres.
///
/// Every sample takes the largest (`dilate`) or smallest (`erode`) value within `radius` of it: the grey-scale
/// dilation and erosion by a flat disk \[serra1982\], exact, with the largest value under each chord of the disk found
/// by doubling \[urbach2008\]. `close` dilates, then erodes: it fills holes and gaps narrower than the disk; `open`
/// erodes, then dilates: it removes what is narrower. With `soft`, the result is blended with its surroundings
/// up to that far, by the bump `(1 − (d / soft)²)²` along each axis.
///
/// # Limits
/// Distances are between samples. The time for a sample grows in proportion to the radius in cells.
/// A finer build of a rough field has higher tips and deeper pits between the samples of a coarser one, and every one
/// of them fills a disk: what comes out of a rough field or mask is a matter of the size, that of a smooth one is not.
///
/// # See also
/// `distance` for falloffs wider than the radius.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Expand {
    /// What to do.
    pub mode: Mode,
    /// Radius of the disk.
    #[schemars(range(min = 0.0, max = 2000.0), extend("x-soft" = [0.0, 200.0]))]
    pub radius: Metres,
    /// Half the width over which an edge is softened afterwards.
    #[schemars(range(min = 0.0, max = 2000.0), extend("x-soft" = [0.0, 200.0]))]
    pub soft: Metres,
}

/// What to do with a disk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Take the largest value around: high parts grow.
    #[default]
    Dilate,
    /// Take the smallest value around: high parts shrink.
    Erode,
    /// Dilate, then erode: narrow gaps and holes are filled.
    Close,
    /// Erode, then dilate: narrow bridges and specks go.
    Open,
}

impl Default for Expand {
    fn default() -> Self {
        Self { mode: Mode::Dilate, radius: Metres(50.0), soft: Metres(0.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Mask or other field to grow or shrink.
        field: Field,
    }
    pub struct Outputs {
        /// The field grown or shrunk, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Expand {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["serra1982", "urbach2008"])
        .keywords(&["dilate", "erode", "grow", "shrink", "morphology", "open", "close", "maximum", "minimum"])
        .mixes(&[("field", "field")]);

    fn reach(&self) -> Reach {
        Reach::local(self.radius.0 * self.steps().len() as f64 + self.soft.0)
    }

    fn footprint(&self, _: &str, window: &Grid, _: &Terrain) -> Grid {
        let disk = self.steps().len() as i64 * morphology::reach(self.radius.0, window.cell());
        window.grow_cells(disk + morphology::reach(self.soft.0, window.cell()))
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let cells = |metres: f64| 2.0 * metres / grid.cell() + 1.0;
        let disks = self.steps().len() as f64;
        let around = grid.grow_metres(self.radius.0 + self.soft.0);
        let seconds = disks * (3.0 + 0.4 * cells(self.radius.0)) + 0.7 * cells(self.soft.0);
        let cost =
            Cost { bytes: morphology::scratch(&around, self.radius.0), ..Cost::per_sample(&around, seconds) };
        let between = if self.soft.0 > 0.0 { 2.0 } else { disks - 1.0 };
        cost.with_fields(&around, between)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let quantity = input.field.quantity();
        let cell = cx.grid.cell();
        let soft = cx.grid.grow_cells(morphology::reach(self.soft.0, cell));
        let (steps, mut field) = (self.steps(), input.field);
        for (i, &keep) in steps.iter().enumerate() {
            let left = (steps.len() - 1 - i) as i64;
            let window = soft.grow_cells(left * morphology::reach(self.radius.0, cell));
            let stage =
                cx.work.stage(0.8 * i as f32 / steps.len() as f32, 0.8 * (i + 1) as f32 / steps.len() as f32);
            field = morphology::disk(&stage, "field", &field, &window, self.radius.0, keep)?;
        }
        field = morphology::soften(&cx.work.stage(0.8, 1.0), "field", &field, &cx.grid, self.soft.0)?;
        Ok(Outputs { field: field.with_quantity(quantity) })
    }
}

impl Expand {
    fn steps(&self) -> &'static [Keep] {
        match self.mode {
            Mode::Dilate => &[Keep::Largest],
            Mode::Erode => &[Keep::Smallest],
            Mode::Close => &[Keep::Largest, Keep::Smallest],
            Mode::Open => &[Keep::Smallest, Keep::Largest],
        }
    }
}
