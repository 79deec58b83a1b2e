//! Mountains that rise while rivers cut into them.

use crate::kit::erosion::Level;
use crate::kit::erosion::stream_power::{self, Erodibility, Land, Settings};
use crate::prelude::*;

/// Makes mountains as they are made: rock rises for millions of years, and rivers cut into it.
///
/// Each year the land changes by `U − K A^m S + D ∇²h` \[howard1994, whipple1999\]: the uplift `U`, less what rivers take by
/// the area `A` that drains through a place and the slope `S`, and what creeps down the hillslopes. The rivers are
/// computed from their mouths up, all of a step at once \[braun2013\], on coarse grids first, whose valleys the finer ones
/// go on from. Water leaves over the border, which stays where it is, and into the sea.
///
/// Nobody knows `K` of a place. Ask for a `relief`, and it is found: the land that would stay as it is under this uplift
/// then has its highest place so far above its outlet. Much less time than `relief` over `uplift` leaves a plateau that
/// rivers have begun to cut.
///
/// Rivers begin where the steady slope is `steepest`, so that mountains have hillslopes between their valleys. `variety`
/// makes rock harder and softer from place to place, without which hillslopes are flat facets.
///
/// # Limits
/// It runs on the base grid. A finer base shows the same ranges and valleys, with more small ones between: heights at 513
/// and 1025 samples correlate by 0.999, and 99 % of them differ by less than 4 % of the relief. Nothing is laid down:
/// depressions of the start stay until they rise. Detail of the start that is finer than the base grid stays where little
/// wore.
///
/// # See also
/// `flow_routing`, `extract_rivers` and `lakes` show the water on the land; `tokunaga_rivers` makes land of rivers that are
/// drawn.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StreamPower {
    /// How long it goes on.
    #[schemars(range(min = 0.0, max = 1e9), extend("x-soft" = [1e5, 2e7], "x-log" = true))]
    pub duration: Years,
    /// Uplift where its field is 1.
    #[schemars(range(min = -100.0, max = 100.0), extend("x-soft" = [0.0, 5.0], "x-unit" = "mm/a"))]
    pub uplift: Number,
    /// How easily rock gives way.
    pub rock: Rock,
    /// The power `m` of the drained area: the higher, the more hollow the profiles of rivers.
    #[schemars(range(min = 0.1, max = 1.0), extend("x-soft" = [0.3, 0.6]))]
    pub concavity: Number,
    /// Slope on which rivers begin.
    #[schemars(range(min = 5.0, max = 80.0), extend("x-soft" = [20.0, 50.0]))]
    pub steepest: Degrees,
    /// How far rock varies: so many powers of two up and down.
    #[schemars(range(min = 0.0, max = 8.0), extend("x-soft" = [0.0, 3.0]))]
    pub variety: Number,
    /// Size of the largest bodies of harder and softer rock.
    #[schemars(range(min = 1.0, max = 1e6), extend("x-soft" = [100.0, 10_000.0], "x-log" = true))]
    pub body_size: Metres,
    /// How fast hillslopes creep and crests grow round.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 0.05], "x-unit" = "m2/a"))]
    pub creep: Number,
    /// Height of detail finer than the base grid that survives: where as much wore, a third of it is left.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 100.0], "x-log" = true))]
    pub detail_height: Metres,
    /// Decides which way water takes, and where rock is hard.
    pub seed: Seed,
}

/// How easily rock gives way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rock {
    /// As easily as a relief takes.
    Relief {
        /// Height of the highest place above its outlet that steady land would have.
        #[schemars(range(min = 1.0, max = 20_000.0), extend("x-soft" = [100.0, 4000.0]))]
        relief: Metres,
    },
    /// By a number of one's own.
    Erodibility {
        /// `K`, in millionths of m^(1 − 2m) a year.
        #[schemars(range(min = 0.0, max = 1e9), extend("x-soft" = [0.1, 100.0], "x-log" = true))]
        k: Number,
    },
}

impl Default for StreamPower {
    fn default() -> Self {
        Self {
            duration: Years(4e6),
            uplift: Number(1.0),
            rock: Rock::Relief { relief: Metres(1200.0) },
            concavity: Number(0.5),
            steepest: Degrees(42.0),
            variety: Number(1.5),
            body_size: Metres(2000.0),
            creep: Number(0.001),
            detail_height: Metres(10.0),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Land at the start, in metres; without it level land at 0.
        height: Option<Field>,
        /// Factor on the uplift: where mountains rise.
        uplift: Option<Field>,
        /// Factor on how easily rock gives way: above 1 soft, below 1 hard.
        erodibility: Option<Field>,
        /// Factor on all that happens, 0 to 1; where it is 0 the land stays.
        mask: Option<Field>,
    }
    pub struct Outputs {
        /// The land, in metres.
        height: Field = Meaning::Fixed(Quantity::Elevation),
        /// The land that drains through each sample, in square metres.
        area: Field = Meaning::Fixed(Quantity::Area),
        /// Rock that went, in metres.
        wear: Field = Meaning::Fixed(Quantity::Distance),
        /// The share of finer detail that stays: 1 where nothing wore.
        detail: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for StreamPower {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["howard1994", "whipple1999", "braun2013", "fairfield1991"])
        .keywords(&[
            "uplift",
            "mountain",
            "range",
            "river",
            "tectonics",
            "erosion",
            "landscape evolution",
            "valley",
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
        let steps = if self.duration.0 > 0.0 { stream_power::cell_steps(&Level::of(grid)) } else { 0.0 };
        let cost = Cost::per_sample(grid, 400.0).with_fields(grid, 20.0);
        Cost { bytes: cost.bytes, seconds: cost.seconds + steps * 250e-9 }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let crop = |field: Option<Field>| field.map(|field| field.crop(&cx.grid));
        let (height, uplift) = (crop(input.height), crop(input.uplift));
        let (erodibility, mask) = (crop(input.erodibility), crop(input.mask));
        let base = Level::of(&cx.grid);
        let land = Land {
            height: height.as_ref(),
            uplift: uplift.as_ref(),
            erodibility: erodibility.as_ref(),
            mask: mask.as_ref(),
            sea: cx.terrain()?.sea_level,
            base: &base,
        };
        let mut on_level = |picture: stream_power::Picture<'_>| {
            cx.show("height", || {
                Field::new(picture.level.grid, Quantity::Elevation, picture.height.to_vec())
            });
        };
        let done = stream_power::erode(&land, &self.settings(cx)?, &mut on_level, &cx.work.stage(0.0, 0.97))?;
        let field = |quantity, data| Field::new(cx.grid, quantity, data);
        let area = done.area.iter().map(|&a| a.min(f64::from(f32::MAX)) as f32).collect();
        let gone = |&wear: &f32| libm::exp(-f64::from(wear) / self.detail_height.0) as f32;
        let detail = done.wear.iter().map(gone).collect();
        Ok(Outputs {
            height: field(Quantity::Elevation, done.height),
            area: field(Quantity::Area, area),
            wear: field(Quantity::Distance, done.wear),
            detail: field(Quantity::Mask, detail),
        })
    }
}

impl StreamPower {
    fn settings(&self, cx: &Context<'_>) -> Result<Settings> {
        Ok(Settings {
            years: self.duration.0,
            uplift: 1e-3 * self.uplift.0,
            erodibility: match self.rock {
                Rock::Relief { relief } => Erodibility::ForRelief(relief.0),
                Rock::Erodibility { k } => Erodibility::Given(1e-6 * k.0),
            },
            exponent: self.concavity.0,
            steepest: libm::tan(self.steepest.0.to_radians()),
            creep: self.creep.0,
            variety: self.variety.0,
            bodies: self.body_size.0,
            seed: cx.seed(self.seed)?,
        })
    }
}
