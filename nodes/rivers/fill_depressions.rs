//! Land from which all water finds its way.

use crate::kit::flow::{Depressions, Surface, breach, epsilon};
use crate::prelude::*;

/// Makes land from which all water runs off: fills its depressions or cuts through what closes them.
///
/// A depression is what no way leads out of downhill. Its level is the least height that water must climb on any way from
/// its deepest place to the sea or over the border of the terrain. The fill raises all ground to its level, to the bit; the
/// slope does the same and lets the ground rise by `rise` at least from cell to cell on the way from the spill, so that
/// lakes drain too \[barnes2014\]. The breach keeps the depressions and lowers the ground instead, along the bottom of
/// the valley from the deepest place over the lowest pass, where `deepest` allows; where a cut would be deeper the
/// depression is filled to that much below its level first \[lindsay2016\].
///
/// The levels come from the graph of passes between the basins of all pits \[cordonnier2019\]. What drains by itself stays
/// as it is. Nothing is filled below the level of the sea, and nothing is cut down to it.
///
/// # Limits
/// It runs on the base grid, and what it changes there is carried to finer grids. Detail finer than the base grid may have
/// pits of its own.
///
/// # See also
/// `lakes` for what stands in the depressions, `carve_rivers` for channels that hold at every size.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FillDepressions {
    /// What becomes of depressions.
    pub mode: Mode,
}

/// What becomes of depressions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Mode {
    /// They are filled to the brim, and level.
    #[default]
    Fill,
    /// They are filled with a slope towards where they spill.
    Slope {
        /// Least rise from cell to cell.
        #[schemars(range(min = 0.0, max = 10.0), extend("x-soft" = [0.0, 0.1]))]
        rise: Metres,
    },
    /// Channels are cut from their deepest places over the lowest passes.
    Breach {
        /// Greatest depth of a cut.
        #[serde(default = "any_depth")]
        #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 100.0]))]
        deepest: Metres,
    },
}

/// As deep as it takes.
fn any_depth() -> Metres {
    Metres(10_000.0)
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// Heights of ground that drains.
        height: Field = Meaning::like("height"),
    }
}

impl Node for FillDepressions {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["barnes2014", "cordonnier2019", "lindsay2016"])
        .keywords(&["sink", "pit", "priority flood", "carve", "epsilon", "drain", "hydrology"])
        .reads(Reads::TERRAIN)
        .carries(&[("height", "height")])
        .mixes(&[("height", "height")]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let nanoseconds = match self.mode {
            Mode::Fill => 60.0,
            Mode::Slope { .. } => 200.0,
            Mode::Breach { .. } => 120.0,
        };
        Cost::per_sample(grid, nanoseconds).with_fields(grid, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let drained = match self.mode {
            Mode::Fill => {
                let depressions = Depressions::find(&surface, &cx.work.stage(0.0, 0.9))?;
                depressions.filled(&surface, &cx.work.stage(0.9, 1.0))?
            }
            Mode::Slope { rise } => epsilon::fill(&surface, rise.0, &cx.work)?,
            Mode::Breach { deepest } => breach::cut(&surface, Some(deepest.0), &cx.work)?,
        };
        Ok(Outputs { height: Field::new(cx.grid, height.quantity(), drained) })
    }
}
