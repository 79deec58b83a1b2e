//! Slopes that are too steep give way.

use crate::kit::erosion::thermal::{self, Land};
use crate::prelude::*;

/// Most steps: those of a reach of 20 cells.
const MOST_STEPS: f64 = 1600.0;

/// Lets slopes that are too steep give way: cliffs fall, and what falls lies at their feet as loose ground.
///
/// Ground slips where it is steeper than its angle of repose, rock at one angle and loose ground at a gentler one, until it
/// is not \[musgrave1989; weiss2015, VI\]. It moves down the gradient, in proportion to what is too steep, so that a pile
/// becomes a round cone. Loose ground goes before the rock below it. What goes is laid down, to within rounding.
///
/// # Limits
/// It runs on the base grid, and takes four times the steps there for half the cell, so that ground slips as far in
/// metres. What lies farther than `reach` from where it must go is still too steep at the end; it counts as at most 20 cells
/// of the base grid. On a steep range much of the land comes to stand at the angle of repose, as facets: give it an angle
/// above most slopes. Detail finer than the base grid stays where nothing slipped.
///
/// # See also
/// `stream_power` makes mountains; `select_slope` finds what is steep.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ThermalErosion {
    /// Steepest slope on which rock stands.
    #[schemars(range(min = 0.0, max = 89.0), extend("x-soft" = [20.0, 70.0]))]
    pub rock: Degrees,
    /// Steepest slope on which loose ground lies.
    #[schemars(range(min = 0.0, max = 89.0), extend("x-soft" = [15.0, 45.0]))]
    pub rubble: Degrees,
    /// How far ground slips, about.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub reach: Metres,
    /// Height of detail finer than the base grid that survives: where as much slipped, a third of it is left.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 100.0], "x-log" = true))]
    pub detail_height: Metres,
}

impl Default for ThermalErosion {
    fn default() -> Self {
        Self { rock: Degrees(45.0), rubble: Degrees(34.0), reach: Metres(150.0), detail_height: Metres(5.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground, loose ground included, in metres.
        height: Field,
        /// Ground that is loose already, in metres.
        loose: Option<Field>,
        /// Steepest slope on which rock stands, in degrees, instead of the parameter.
        rock_angle: Option<Field>,
        /// Steepest slope on which loose ground lies, in degrees, instead of the parameter.
        rubble_angle: Option<Field>,
        /// Factor on all that slips, 0 to 1; where it is 0 the land stays.
        mask: Option<Field>,
    }
    pub struct Outputs {
        /// The land, in metres.
        height: Field = Meaning::like("height"),
        /// Loose ground, in metres.
        loose: Field = Meaning::Fixed(Quantity::Distance),
        /// Rock that went, in metres.
        wear: Field = Meaning::Fixed(Quantity::Distance),
        /// Ground laid down less ground taken, in metres.
        deposit: Field = Meaning::Fixed(Quantity::Length),
        /// The share of finer detail that stays: 1 where nothing slipped.
        detail: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for ThermalErosion {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["musgrave1989", "weiss2015"])
        .keywords(&[
            "talus",
            "scree",
            "slippage",
            "landslide",
            "repose",
            "cliff",
            "slope",
            "debris",
            "rubble",
        ])
        .carries(&[("height", "height")]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn keep(&self, _: &str) -> Detail {
        Detail::By("detail")
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let steps = (self.steps(grid) * grid.len()) as f64;
        let cost = Cost::per_sample(grid, 100.0).with_fields(grid, 24.0);
        Cost { bytes: cost.bytes, seconds: cost.seconds + steps * 30e-9 }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let crop = |field: Option<Field>| field.map(|field| field.crop(&cx.grid));
        let quantity = input.height.quantity();
        let (height, loose, mask) = (input.height.crop(&cx.grid), crop(input.loose), crop(input.mask));
        let tangents = |field: Option<Field>| field.map(tangents);
        let (rock, rubble) = (tangents(crop(input.rock_angle)), tangents(crop(input.rubble_angle)));
        let land = Land {
            height: &height,
            loose: loose.as_ref(),
            rock: (libm::tan(self.rock.0.to_radians()), rock.as_ref()),
            rubble: (libm::tan(self.rubble.0.to_radians()), rubble.as_ref()),
            mask: mask.as_ref(),
            steps: self.steps(&cx.grid),
        };
        let done = thermal::slip(&land, &cx.work.stage(0.0, 0.97))?;
        let field = |quantity, data| Field::new(cx.grid, quantity, data);
        let moved = |(wear, deposit): (&f32, &f32)| f64::from(wear.max(deposit.abs()));
        let detail = done.wear.iter().zip(&done.deposit).map(moved);
        let detail = detail.map(|moved| libm::exp(-moved / self.detail_height.0) as f32).collect();
        Ok(Outputs {
            height: field(quantity, done.height),
            loose: field(Quantity::Distance, done.loose),
            wear: field(Quantity::Distance, done.wear),
            deposit: field(Quantity::Length, done.deposit),
            detail: field(Quantity::Mask, detail),
        })
    }
}

impl ThermalErosion {
    /// Steps in which an excess spreads as far as it is to slip.
    fn steps(&self, grid: &Grid) -> usize {
        let cells = self.reach.0 / grid.cell();
        libm::ceil(4.0 * cells * cells).min(MOST_STEPS) as usize
    }
}

/// The tangents of angles in degrees, which are kept to 0 to 89.
fn tangents(angles: Field) -> Field {
    let tangent = |&angle: &f32| libm::tan(f64::from(angle.clamp(0.0, 89.0)).to_radians()) as f32;
    Field::new(*angles.grid(), Quantity::Number, angles.data().iter().map(tangent).collect())
}
