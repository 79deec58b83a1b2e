//! Steps.

use crate::kit::curve::{bias, gain};
use crate::kit::hash;
use crate::kit::rows::Rows;
use crate::kit::sample::fit;
use crate::prelude::*;

/// Lays a field into terraces: flat treads and steep risers, like banks of hard and soft rock.
///
/// Within a step from one level to the next, the way `t` from 0 to 1 becomes a curve that is flat at the foot and steep
/// at the lip \[schlick1994\]. So the treads keep some of the slope they had, and every ridge and gully runs on through
/// them.
///
/// # Limits
/// Between samples a riser is as steep as the grid can show.
///
/// # See also
/// `curve` for a profile drawn by hand.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Terrace {
    /// How high the steps are.
    pub steps: Steps,
    /// 0 leaves the field as it is, 1 makes the treads flat and the risers upright.
    pub sharpness: Ratio,
    /// 1 makes a sharp lip over a soft foot, 0 rounds both off alike.
    pub lip: Ratio,
    /// How much the heights of the steps differ, at random: 0 not at all, 1 up to twice the height and nearly nothing.
    pub variation: Ratio,
    /// Moves all levels up, in the unit of the field.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-100.0, 100.0]))]
    pub offset: Number,
    /// Chooses the heights of the steps.
    pub seed: Seed,
}

/// How high the steps of a [`Terrace`] are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Steps {
    /// A height of each.
    Height {
        /// From one level to the next.
        #[schemars(range(min = 0.001, max = 1.0e5), extend("x-soft" = [5.0, 300.0], "x-log" = true))]
        height: Metres,
    },
    /// A number of them from the lowest to the highest value of the whole terrain, on the base grid.
    Count {
        /// Number of steps.
        #[schemars(range(min = 1, max = 1000), extend("x-soft" = [2, 30], "x-unit" = "1"))]
        count: u32,
    },
}

impl Default for Terrace {
    fn default() -> Self {
        Self {
            steps: Steps::Height { height: Metres(60.0) },
            sharpness: Ratio(0.8),
            lip: Ratio(0.8),
            variation: Ratio(0.5),
            offset: Number(0.0),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Field to lay into steps.
        field: Field,
        /// Raises the levels where it is high, in the unit of the field: a tilted plane or soft noise lets the banks dip.
        shift: Option<Field>,
    }
    pub struct Outputs {
        /// Stepped field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Terrace {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["schlick1994"])
        .reads(Reads::SEED)
        .mixes(&[("field", "field")])
        .keywords(&["steps", "strata", "layers", "mesa", "canyon", "stairs", "plateau"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 25.0)
    }

    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        matches!(self.steps, Steps::Count { .. })
            .then_some(|_, cx, input| cx.range_summary(&input.field, 0.0))
    }

    fn run(&self, cx: &Context<'_>, Inputs { field, shift }: Inputs) -> Result<Outputs> {
        let profile = Profile::new(self, cx)?;
        let quantity = field.quantity();
        if profile.height <= 0.0 || self.sharpness.0 == 0.0 {
            return Ok(Outputs { field: field.crop(&cx.grid) });
        }
        let rows = Rows::of(&field, &cx.grid);
        let shift = shift.map(|s| Rows::of(&s, &cx.grid));
        let field = cx.fill(quantity, |row, out: &mut [f32]| {
            let raised = |i: usize| shift.as_ref().map_or(0.0, |s| f64::from(s.at(row.row)[i]));
            for (i, (o, &x)) in out.iter_mut().zip(rows.at(row.row)).enumerate() {
                *o = fit(quantity, (f64::from(x) + profile.change(f64::from(x) - raised(i))) as f32);
            }
        })?;
        Ok(Outputs { field })
    }
}

/// The transfer of a terrace.
struct Profile {
    height: f64,
    base: f64,
    /// What half the way up a step becomes, from 0 to 1/2.
    middle: f64,
    lip: f64,
    variation: f64,
    seed: u64,
}

impl Profile {
    fn new(node: &Terrace, cx: &Context<'_>) -> Result<Self> {
        let (base, height) = match node.steps {
            Steps::Height { height } => (0.0, height.0),
            Steps::Count { count } => {
                let [low, high] = cx.summary_range()?;
                (low, (high - low) / f64::from(count.max(1)))
            }
        };
        Ok(Self {
            height,
            base: base + node.offset.0,
            // Never quite 0: a riser stays a function of the height.
            middle: (0.5 * (1.0 - node.sharpness.0)).max(1e-4),
            lip: node.lip.0,
            variation: node.variation.0,
            seed: cx.seed(node.seed)?,
        })
    }

    /// What is added to a value.
    fn change(&self, x: f64) -> f64 {
        let t = (x - self.base) / self.height;
        // Beyond, a step is finer than an f64 can tell apart.
        if t.abs() > 1e12 {
            return 0.0;
        }
        let (below, above) = self.levels(t);
        let width = above - below;
        let share = ((t - below) / width).clamp(0.0, 1.0);
        let bent = gain(share, self.middle) * (1.0 - self.lip) + bias(share, self.middle) * self.lip;
        (bent - share) * width * self.height
    }

    /// The levels below and above, in steps.
    fn levels(&self, t: f64) -> (f64, f64) {
        let nearest = t.floor() as i64;
        let (here, next) = (self.level(nearest), self.level(nearest + 1));
        if t < here {
            (self.level(nearest - 1), here)
        } else if t >= next {
            (next, self.level(nearest + 2))
        } else {
            (here, next)
        }
    }

    /// A level, in steps: at most 0.45 from its even place, so that no two change their order.
    fn level(&self, index: i64) -> f64 {
        index as f64 + 0.9 * self.variation * (hash::unit(self.seed, index as u64) - 0.5)
    }
}
