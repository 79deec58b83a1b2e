//! Where water goes, and how much.

use crate::kit::flow::neighbor::unit;
use crate::kit::flow::{Depressions, Rule, Spread, Surface, accumulate};
use crate::kit::rows::by_index;
use crate::prelude::*;

/// Cubic metres a second that a millimetre an hour gives on a square metre.
const PER_MILLIMETRE: f64 = 1e-3 / 3600.0;

/// Follows water over the land: which way it goes, how large the land is that drains through each place, how far it is to
/// the outlet, and how much water comes.
///
/// Water leaves the land at *outlets*: into the sea, and over the border of the terrain where nothing beside is lower.
/// Three methods say where the water of a sample goes:
///
/// - D8: to the neighbour of steepest descent \[ocallaghan1984\]. Rivers are lines one sample wide, in eight directions.
/// - D-infinity: along the steepest of the eight triangles around the sample, over the two neighbours beside that direction
///   by its angle to them \[tarboton1997\].
/// - MFD: over all lower neighbours, in proportion to `slope^exponent` \[freeman1991, holmgren1994\].
///
/// Water in a depression goes over its lowest pass, along the bottom of the valley, as D8 with all methods; on flats it
/// goes to the nearest exit. Ties go by the order of the samples, from the north-west.
///
/// With the size `c²` of a cell, `area = c² · n`, where `n` counts all samples of land that drain through this one, or
/// their shares, its own included. `flow = rain · moisture · c²`, summed in the same way. At the outlets both add up to the
/// whole land.
///
/// # Limits
/// It runs on the base grid. Distances are along the D8 ways with every method.
///
/// # See also
/// `extract_rivers`, `watersheds`, `wetness`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FlowRouting {
    /// How water is divided.
    pub method: Method,
    /// Rain that runs off, in millimetres an hour.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 50.0], "x-unit" = "mm/h"))]
    pub rain: Number,
}

/// How water is divided over the neighbours of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// All of it to one of eight.
    D8,
    /// Over the two on either side of the steepest descent.
    DInfinity,
    /// Over all that are lower.
    Mfd {
        /// The power of the slope: the higher, the more goes the steepest way.
        #[schemars(range(min = 0.0, max = 25.0), extend("x-soft" = [1.0, 10.0]))]
        exponent: Number,
    },
}

impl Method {
    /// The rule by which water is divided; none where it is not.
    pub fn rule(self) -> Option<Rule> {
        match self {
            Self::D8 => None,
            Self::DInfinity => Some(Rule::Infinity),
            Self::Mfd { exponent } => Some(Rule::Slopes { exponent: exponent.0 }),
        }
    }
}

impl Default for FlowRouting {
    fn default() -> Self {
        Self { method: Method::D8, rain: Number(10.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
        /// Factor on the rain, nowhere below 0.
        moisture: Option<Field>,
    }
    pub struct Outputs {
        /// Where the water goes: a vector of length one to the east and south; 0 and 0 at outlets.
        direction: Vectors,
        /// The land that drains through each sample, in square metres.
        area: Field = Meaning::Fixed(Quantity::Area),
        /// Distance to the outlet along the way of the water, in metres.
        distance: Field = Meaning::Fixed(Quantity::Distance),
        /// Water that passes, in cubic metres a second.
        flow: Field = Meaning::Fixed(Quantity::Flow),
    }
}

impl Node for FlowRouting {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["ocallaghan1984", "tarboton1997", "freeman1991", "holmgren1994", "cordonnier2019"])
        .keywords(&["drainage", "accumulation", "catchment", "discharge", "runoff", "hydrology", "wetness"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let nanoseconds = match self.method {
            Method::D8 => 250.0,
            Method::DInfinity => 600.0,
            Method::Mfd { .. } => 1500.0,
        };
        Cost::per_sample(grid, nanoseconds).with_fields(grid, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height, moisture }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let moisture = moisture.map(|field| field.crop(&cx.grid));
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let depressions = Depressions::find(&surface, &cx.work.stage(0.0, 0.2))?;
        let rule = self.method.rule();
        let filled = rule.map(|_| depressions.filled(&surface, &cx.work.stage(0.2, 0.25))).transpose()?;
        let tree = depressions.into_tree(&surface, &cx.work)?;
        let spread =
            rule.zip(filled.as_deref()).map(|(rule, filled)| Spread::new(surface, &tree, filled, rule));
        let sum = |cx: &Context<'_>, amount: &(dyn Fn(usize) -> f64 + Sync)| {
            let land = |cell: usize| if surface.is_land(cell) { amount(cell) } else { 0.0 };
            let amounts = accumulate::each(tree.cells, land, &cx.work.stage(0.0, 0.1))?;
            match &spread {
                Some(spread) => spread.accumulate(amounts, &cx.work.stage(0.1, 1.0)),
                None => accumulate::along(&tree, amounts, &cx.work.stage(0.1, 1.0)),
            }
        };
        let cell = cx.grid.cell() * cx.grid.cell();
        let area = {
            let area = sum(&cx.stage(0.25, 0.5), &|_| cell)?;
            field(&cx.stage(0.5, 0.52), Quantity::Area, |i| area[i])?
        };
        let rain = self.rain.0 * PER_MILLIMETRE;
        let flow = match &moisture {
            // Even rain flows as the area does.
            None => {
                let flow = |i: usize| rain * f64::from(area.data()[i]);
                field(&cx.stage(0.52, 0.79), Quantity::Flow, flow)?
            }
            Some(moisture) => {
                let wet = |i: usize| rain * cell * f64::from(moisture.data()[i]).max(0.0);
                let flow = sum(&cx.stage(0.52, 0.77), &wet)?;
                field(&cx.stage(0.77, 0.79), Quantity::Flow, |i| flow[i])?
            }
        };
        let distance = tree.distance(&cx.work.stage(0.79, 0.9))?;
        let distance = field(&cx.stage(0.9, 0.92), Quantity::Distance, |i| distance[i])?;
        let direction = cx.stage(0.92, 1.0).fill(Quantity::Vector, |row, out: &mut [[f32; 2]]| {
            for (out, i) in out.iter_mut().zip(row.j * cx.grid.cols..) {
                let toward = spread.as_ref().map_or_else(|| unit(tree.directions()[i]), |s| s.direction(i));
                *out = toward.map(|x| x as f32);
            }
        })?;
        Ok(Outputs { direction, area, distance, flow })
    }
}

/// A field of numbers that may be too large for an f32.
fn field(cx: &Context<'_>, quantity: Quantity, value: impl Fn(usize) -> f64 + Sync) -> Result<Field> {
    Ok(by_index(&cx.work, &cx.grid, quantity, |i| value(i).min(f64::from(f32::MAX)) as f32)?)
}
