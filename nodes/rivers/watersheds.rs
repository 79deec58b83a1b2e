//! The land that drains to each outlet.

use crate::kit::flow::{Surface, Tree};
use crate::kit::hash;
use crate::kit::rows::by_index;
use crate::prelude::*;

/// Parts the land into watersheds: what drains to the same outlet is one.
///
/// Water goes to the neighbour of steepest descent, out of a depression over its lowest pass, and leaves the land into the
/// sea or over the border of the terrain (`flow_routing`, D8). Each sample of land belongs to one watershed, and each
/// watershed has one outlet: a sample of the sea, or one of the border. They are numbered from 1 in the order of their
/// outlets from the north-west; the sea is 0.
///
/// # Limits
/// It runs on the base grid. Slopes that fall straight into the sea or over the border are many small watersheds.
///
/// # See also
/// `flow_routing`, `extract_rivers`, `extract_ridges`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Watersheds {
    /// Chooses the colours.
    pub seed: Seed,
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// The number of the watershed, from 1; 0 in the sea.
        label: Field = Meaning::Fixed(Quantity::Label),
        /// A colour for each watershed, black in the sea.
        colors: Colors,
        /// 1 on the samples that touch another watershed, 0 elsewhere.
        boundaries: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for Watersheds {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["ocallaghan1984", "cordonnier2019"])
        .keywords(&["basin", "catchment", "divide", "drainage", "segment"])
        .reads(Reads::TERRAIN.and(Reads::SEED));

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 180.0).with_fields(grid, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { height }: Inputs) -> Result<Outputs> {
        let height = height.crop(&cx.grid);
        let surface = Surface::of(&height, cx.terrain()?.sea_level);
        let tree = Tree::of(&surface, &cx.work.stage(0.0, 0.6))?;
        let basins = tree.basins(|cell| surface.is_land(cell), &cx.work.stage(0.6, 0.8))?;
        let label = by_index(&cx.work.stage(0.8, 0.85), &cx.grid, Quantity::Label, |i| basins[i] as f32)?;
        let seed = cx.seed(self.seed)?;
        let colors = cx.stage(0.85, 0.95).fill(Quantity::Color, |row, out: &mut [[f32; 3]]| {
            out.iter_mut().zip(row.j * cx.grid.cols..).for_each(|(o, i)| *o = color(seed, basins[i]));
        })?;
        let boundary = |i: usize| {
            let other = |(_, n): (u8, usize)| basins[n] != basins[i];
            f32::from(u8::from(basins[i] != 0 && tree.cells.around(i).any(other)))
        };
        let boundaries = by_index(&cx.work.stage(0.95, 1.0), &cx.grid, Quantity::Mask, boundary)?;
        Ok(Outputs { label, colors, boundaries })
    }
}

/// The colour of a watershed: neither dark nor grey.
fn color(seed: u64, basin: u32) -> [f32; 3] {
    if basin == 0 {
        return [0.0; 3];
    }
    let [hue, light] = [0, 1].map(|k| hash::unit(seed, u64::from(basin) << 1 | k) as f32);
    let channel = |shift: f32| {
        let wave = (6.0 * (hue + shift).fract() - 3.0).abs() - 1.0;
        (0.25 + 0.65 * wave.clamp(0.0, 1.0)) * (0.7 + 0.3 * light)
    };
    [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)]
}
