//! Ridges as a picture.

use super::draw_rivers::{by_order, cost};
use crate::kit::land::draw::Drawing;
use crate::kit::land::{Line, WideLine};
use crate::kit::ramp::Palette;
use crate::prelude::*;
use crate::value::Ridges;

/// Draws ridges as a mask, and in colours by the rivers that they part.
///
/// The order of a ridge is the lower of the Strahler orders that the two rivers beside it have where they meet: 1 between
/// sources, high on main divides. Orders run through the palette: the highest takes the first colour. The mask is the share
/// of each sample's cell that ridges cover. Main divides lie over others.
///
/// # See also
/// `draw_rivers` draws the rivers; its colours may lie under these.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DrawRidges {
    /// Width of the lines; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 100.0], "x-log" = true))]
    pub width: Option<Metres>,
    /// Lowest order that is drawn.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub least_order: u32,
    /// Colours from the highest order to the lowest.
    pub palette: Palette,
}

impl Default for DrawRidges {
    fn default() -> Self {
        Self { width: None, least_order: 1, palette: Palette::Volcanic }
    }
}

ports! {
    pub struct Inputs {
        /// Ridges to draw.
        ridges: Ridges,
        /// Picture to draw them on; white where it is not connected.
        under: Option<Colors>,
    }
    pub struct Outputs {
        /// The share of the land that ridges cover, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// The picture, sRGB encoded.
        colors: Colors,
    }
}

impl Node for DrawRidges {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().keywords(&["map", "divide", "watershed", "crest", "skeleton", "mask"]).reads(Reads::BASE);

    /// A sample hangs on the picture under it alone, but also on the cell of the grid.
    fn reach(&self) -> Reach {
        Reach::local(0.0)
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let ridges = load.object::<Ridges>("ridges").unwrap_or_default();
        cost(&load.grid, &self.lines(&ridges, load.terrain.base_cell()))
    }

    fn run(&self, cx: &Context<'_>, Inputs { ridges, under }: Inputs) -> Result<Outputs> {
        let lines = self.lines(&ridges, cx.base_cell()?);
        let highest = ridges.edges().iter().map(|edge| edge.order).max().unwrap_or(1);
        let drawn =
            Drawing { palette: by_order(&self.palette, highest), under }.draw(&cx.work, &cx.grid, lines)?;
        Ok(Outputs { mask: drawn.mask, colors: drawn.colors })
    }
}

impl DrawRidges {
    fn lines(&self, ridges: &Ridges, base_cell: f64) -> Vec<WideLine> {
        let width = self.width.map_or(base_cell, |m| m.0);
        let large = ridges.edges().iter().filter(|edge| u32::from(edge.order) >= self.least_order);
        let link = |edge| {
            let [a, b] = ridges.ends(edge);
            WideLine {
                line: Line { ends: [a.at, b.at], heights: [a.height, b.height] },
                width,
                order: edge.order,
            }
        };
        large.map(link).collect()
    }
}
