//! Rain wears the land and lays it down again.

use crate::kit::erosion::hydraulic::{self, Border, Land, Settings, Showers};
use crate::kit::erosion::ladder::Level;
use crate::prelude::*;

/// Lets rain fall on land for some hours: water gathers, cuts valleys, and lays down what it carried as fans, valley floors and
/// deltas.
///
/// Water runs through eight pipes between each cell and its neighbours, driven by the fall of its surface and slowed by
/// friction on the bed, in metres and seconds \[weiss2015, VI; bates2010\]. It carries ground in proportion to its discharge
/// and the fall of its surface; where it could carry more it wears loose ground, then rock, and where it carries too much it
/// lays it down. Slopes that become too steep slip. What is taken is laid down, carried by the water, or leaves over the
/// border, to within rounding.
///
/// Work begins on a coarse grid, whose cells depend on the terrain alone, and goes to finer ones up to the base grid: the
/// large valleys form first, and a draft on a coarser base shows them too. The hours are real ones, with rain of a flood: an
/// hour of heavy rain on soft rock does here what takes a climate a thousand years.
///
/// # Limits
/// It runs on the base grid. Detail finer than that stays on untouched land and fades where ground was worn or laid down.
/// Valleys of ten kilometres take more hours than one likes to wait: make ranges by `stream_power` and let rain fall on
/// them. Rock neither rises nor sinks meanwhile.
///
/// # See also
/// `stream_power` for ranges, `thermal_erosion` for slopes alone, `carve_rivers` for rivers whose way is known.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HydraulicErosion {
    /// How long it rains, on all grids together.
    #[schemars(range(min = 0.0, max = 1e9), extend("x-soft" = [0.0, 24.0]))]
    pub duration: Hours,
    /// Rain where `moisture` is 1.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub rain: MillimetresPerHour,
    /// Width of the largest valleys: the first grid has eight cells across it, and at most 64 across the terrain.
    #[schemars(range(min = 0.1, max = 1e7), extend("x-soft" = [100.0, 20_000.0], "x-log" = true))]
    pub feature_size: Metres,
    /// How much of the rain falls in showers; the rest is even.
    pub showers: Ratio,
    /// Width of a shower.
    #[schemars(range(min = 1.0, max = 1e6), extend("x-soft" = [100.0, 10_000.0], "x-log" = true))]
    pub shower_size: Metres,
    /// How long a shower lasts.
    #[schemars(range(min = 1.0, max = 1e7), extend("x-soft" = [60.0, 7200.0]))]
    pub shower_time: Seconds,
    /// Discharge of all `sources` together.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-soft" = [0.0, 2000.0]))]
    pub source_discharge: Discharge,
    /// Water that goes into the air, at 30 °C or where no `temperature` is given; in proportion to it from 0 °C up.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 50.0]))]
    pub evaporation: MillimetresPerHour,
    /// Roughness of beds, Manning's n: 0.03 for a smooth bed, 0.05 for gravel, 0.1 for growth and boulders.
    #[schemars(range(min = 0.001, max = 10.0), extend("x-soft" = [0.02, 0.2]))]
    pub roughness: Number,
    /// Ground that water can carry, in metres over discharge per width times slope: more makes larger valleys and fans.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub capacity: Number,
    /// How fast load sinks.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-soft" = [0.0, 0.5]))]
    pub settling: MetresPerSecond,
    /// How fast water takes up rock, as a speed over its depth.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-soft" = [0.0, 0.05]))]
    pub rock_erodibility: MetresPerSecond,
    /// How fast water takes up loose ground, as a speed over its depth.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-soft" = [0.0, 0.2]))]
    pub loose_erodibility: MetresPerSecond,
    /// Wear after which rock is half as erodible; 0 for rock that is the same at any depth.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-soft" = [0.0, 200.0]))]
    pub hardening_depth: Metres,
    /// Most rock that water takes anywhere; 0 for no bound. Slopes may fall beyond it.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-soft" = [0.0, 500.0]))]
    pub largest_wear: Metres,
    /// Most that water lays down anywhere; 0 for no bound.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-soft" = [0.0, 500.0]))]
    pub largest_deposit: Metres,
    /// Steepest slope on which rock stands.
    #[schemars(range(min = 0.0, max = 89.0), extend("x-soft" = [20.0, 80.0]))]
    pub rock: Degrees,
    /// Steepest slope on which loose ground lies.
    #[schemars(range(min = 0.0, max = 89.0), extend("x-soft" = [15.0, 45.0]))]
    pub rubble: Degrees,
    /// Whether water and load leave over the border.
    pub border: Edge,
    /// Whether lakes are full when the rain begins.
    pub full_lakes: bool,
    /// Height of detail finer than the base grid that survives: where as much was worn or laid down, a third of it is left.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 100.0], "x-log" = true))]
    pub detail_height: Metres,
    /// Decides where showers fall.
    pub seed: Seed,
}

/// The border of the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Edge {
    /// Water and load leave.
    #[default]
    Open,
    /// A wall: water stands against it.
    Closed,
}

impl Default for HydraulicErosion {
    fn default() -> Self {
        Self {
            duration: Hours(4.0),
            rain: MillimetresPerHour(50.0),
            feature_size: Metres(10_000.0),
            showers: Ratio(0.0),
            shower_size: Metres(2000.0),
            shower_time: Seconds(900.0),
            source_discharge: Discharge(100.0),
            evaporation: MillimetresPerHour(0.0),
            roughness: Number(0.05),
            capacity: Number(60.0),
            settling: MetresPerSecond(0.05),
            rock_erodibility: MetresPerSecond(0.008),
            loose_erodibility: MetresPerSecond(0.03),
            hardening_depth: Metres(0.0),
            largest_wear: Metres(0.0),
            largest_deposit: Metres(0.0),
            rock: Degrees(50.0),
            rubble: Degrees(36.0),
            border: Edge::Open,
            full_lakes: true,
            detail_height: Metres(5.0),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground, loose ground included, in metres.
        height: Field,
        /// Factor on the rain, 0 to 1.
        moisture: Option<Field>,
        /// Where the discharge of the sources comes up, 0 to 1.
        sources: Option<Field>,
        /// Temperature in °C: water goes into the air where it is warm.
        temperature: Option<Field>,
        /// How hard rock is, from 0, which wears as `rock_erodibility` says, to 1, which does not wear.
        hardness: Option<Field>,
        /// Ground that is loose already, in metres.
        loose: Option<Field>,
        /// Factor on all that is worn and laid down, 0 to 1; where it is 0 the land stays. Rain falls there too.
        mask: Option<Field>,
    }
    pub struct Outputs {
        /// The land, in metres.
        height: Field = Meaning::like("height"),
        /// Loose ground, in metres.
        loose: Field = Meaning::Fixed(Quantity::Distance),
        /// Depth of the water, mean of the last half of the rain, in metres.
        water: Field = Meaning::Fixed(Quantity::Depth),
        /// Discharge across a sample, in the same mean, in m³/s; 0 in the sea.
        flow: Field = Meaning::Fixed(Quantity::Flow),
        /// Speed of the water to the east and south, in the same mean, in m/s; 0 in the sea.
        velocity: Vectors = Meaning::Fixed(Quantity::Velocity),
        /// Rock that went, in metres.
        wear: Field = Meaning::Fixed(Quantity::Distance),
        /// Ground laid down less ground taken, in metres.
        deposit: Field = Meaning::Fixed(Quantity::Length),
        /// The share of finer detail that stays: 1 where nothing changed.
        detail: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for HydraulicErosion {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["weiss2015", "bates2010", "mei2007"])
        .keywords(&[
            "rain", "water", "river", "valley", "gully", "fan", "delta", "sediment", "erode", "flood",
            "canyon", "fluvial",
        ])
        .reads(Reads::TERRAIN.and(Reads::SEED))
        .carries(&[("height", "height")]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn keep(&self, _: &str) -> Detail {
        Detail::By("detail")
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let steps = hydraulic::cell_steps(&Level::of(grid), &self.settings(0));
        let cost = Cost::per_sample(grid, 400.0).with_fields(grid, 24.0);
        Cost { bytes: cost.bytes, seconds: cost.seconds + steps * 15e-9 }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let crop = |field: Option<Field>| field.map(|field| field.crop(&cx.grid));
        let quantity = input.height.quantity();
        let height = input.height.crop(&cx.grid);
        let (moisture, sources, temperature) =
            (crop(input.moisture), crop(input.sources), crop(input.temperature));
        let (hardness, loose, mask) = (crop(input.hardness), crop(input.loose), crop(input.mask));
        let land = Land {
            height: &height,
            moisture: moisture.as_ref(),
            sources: sources.as_ref(),
            temperature: temperature.as_ref(),
            hardness: hardness.as_ref(),
            loose: loose.as_ref(),
            mask: mask.as_ref(),
            sea: cx.terrain()?.sea_level,
            base: Level::of(&cx.grid),
        };
        let settings = self.settings(cx.seed(self.seed)?);
        let mut on_level = |picture: hydraulic::Picture<'_>| {
            cx.show("height", || Field::new(picture.level.grid, quantity, picture.height.to_vec()));
        };
        let done = hydraulic::erode(&land, &settings, &mut on_level, &cx.work.stage(0.0, 0.97))?;
        let field = |quantity, data| Field::new(cx.grid, quantity, data);
        let moved = |(wear, deposit): (&f32, &f32)| f64::from(wear.max(deposit.abs()));
        let detail = done.wear.iter().zip(&done.deposit).map(moved);
        let detail = detail.map(|moved| libm::exp(-moved / self.detail_height.0) as f32).collect();
        Ok(Outputs {
            height: field(quantity, done.height),
            loose: field(Quantity::Distance, done.loose),
            water: field(Quantity::Depth, done.water.depth),
            flow: field(Quantity::Flow, done.water.flow),
            velocity: Vectors::new(cx.grid, Quantity::Velocity, done.water.velocity),
            wear: field(Quantity::Distance, done.wear),
            deposit: field(Quantity::Length, done.deposit),
            detail: field(Quantity::Mask, detail),
        })
    }
}

impl HydraulicErosion {
    fn settings(&self, seed: u64) -> Settings {
        let tangent = |angle: Degrees| libm::tan(angle.0.to_radians());
        Settings {
            hours: self.duration.0,
            rain: self.rain.0,
            showers: Showers {
                size: self.shower_size.0,
                seconds: self.shower_time.0,
                strength: self.showers.0,
            },
            evaporation: self.evaporation.0,
            source_discharge: self.source_discharge.0,
            roughness: self.roughness.0,
            capacity: self.capacity.0,
            settling: self.settling.0,
            rock_erodibility: self.rock_erodibility.0,
            loose_erodibility: self.loose_erodibility.0,
            hardening: self.hardening_depth.0,
            most_wear: self.largest_wear.0,
            most_deposit: self.largest_deposit.0,
            rock_repose: tangent(self.rock),
            loose_repose: tangent(self.rubble),
            feature: self.feature_size.0,
            border: match self.border {
                Edge::Open => Border::Open,
                Edge::Closed => Border::Closed,
            },
            full_lakes: self.full_lakes,
            seed,
            ..Settings::default()
        }
    }
}
