//! Rivers as a picture.

use super::skeleton_raster::river;
use crate::kit::land::WideLine;
use crate::kit::land::draw::Drawing;
use crate::kit::ramp::{Blend, Palette, Ramp};
use crate::prelude::*;
use crate::value::Rivers;

/// Draws rivers as a mask, and in colours by their order.
///
/// Each link is as wide as its river times `width`, and at least `least_width`. The mask is the share of each sample's cell
/// that rivers cover. Strahler orders run through the palette: the highest of the network takes the first colour, sources
/// the last. Larger rivers lie over smaller ones.
///
/// # See also
/// `carve_rivers` cuts the same rivers into land, `draw_ridges` draws what lies between them.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DrawRivers {
    /// Factor on the width of the rivers.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-soft" = [0.0, 5.0]))]
    pub width: Number,
    /// Width of the narrowest lines; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 100.0], "x-log" = true))]
    pub least_width: Option<Metres>,
    /// Lowest Strahler order that is drawn.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub least_order: u32,
    /// Colours from the highest order to the lowest.
    pub palette: Palette,
}

impl Default for DrawRivers {
    fn default() -> Self {
        Self { width: Number(1.0), least_width: None, least_order: 1, palette: Palette::Ocean }
    }
}

ports! {
    pub struct Inputs {
        /// Rivers to draw.
        rivers: Rivers,
        /// Picture to draw them on; white where it is not connected.
        under: Option<Colors>,
    }
    pub struct Outputs {
        /// The share of the land that rivers cover, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// The picture, sRGB encoded.
        colors: Colors,
    }
}

impl Node for DrawRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .keywords(&["map", "strahler", "stream", "network", "order", "water", "mask"])
        .reads(Reads::BASE);

    /// A sample hangs on the picture under it alone, but also on the cell of the grid.
    fn reach(&self) -> Reach {
        Reach::local(0.0)
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let rivers = load.object::<Rivers>("rivers").unwrap_or_default();
        cost(&load.grid, &self.lines(&rivers, load.terrain.base_cell()))
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers, under }: Inputs) -> Result<Outputs> {
        let lines = self.lines(&rivers, cx.base_cell()?);
        let highest = rivers.vertices().iter().map(|vertex| vertex.order).max().unwrap_or(1);
        let drawn =
            Drawing { palette: by_order(&self.palette, highest), under }.draw(&cx.work, &cx.grid, lines)?;
        Ok(Outputs { mask: drawn.mask, colors: drawn.colors })
    }
}

impl DrawRivers {
    fn lines(&self, rivers: &Rivers, base_cell: f64) -> Vec<WideLine> {
        let least = self.least_width.map_or(base_cell, |m| m.0);
        let large = rivers
            .links()
            .filter(|(upper, _)| u32::from(rivers.vertices()[*upper].order) >= self.least_order);
        let link = |(upper, lower): (usize, usize)| {
            let of = rivers.vertices()[upper];
            let width = (f64::from(of.width) * self.width.0).max(least);
            WideLine { line: river(rivers, (upper, lower)), width, order: of.order }
        };
        large.map(link).collect()
    }
}

/// The colours of the orders from 1 to the highest, which takes the first of a palette.
pub(super) fn by_order(palette: &Palette, highest: u8) -> Vec<[f32; 3]> {
    let ramp = Ramp::of(palette, Blend::Smooth);
    let steps = f32::from(highest.max(2) - 1);
    (1..=highest.max(1)).map(|order| ramp.color(f32::from(highest - order.min(highest)) / steps)).collect()
}

/// What drawing lines takes.
pub(super) fn cost(grid: &Grid, lines: &[WideLine]) -> Cost {
    // The lines, a copy of them, and the picture under them.
    let picture = 12 * grid.len() as u64;
    let bytes = Drawing::bytes(grid, lines) + size_of_val(lines) as u64 + picture;
    Cost { bytes, seconds: grid.len() as f64 * 25e-9 + lines.len() as f64 * 2e-6 }
}
