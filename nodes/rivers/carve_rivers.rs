//! The beds of rivers, cut into land of any size.

use super::skeleton_raster::river;
use crate::kit::land::WideLine;
use crate::kit::land::carve::Carving;
use crate::prelude::*;
use crate::value::Rivers;

/// Cuts the beds of rivers into land, so that their water runs to its outlet on the grid that is built.
///
/// A bed is as wide as its river times `width`, and at least 1.5 cells: the coarser of those of the base grid and of the
/// build. In it every sample gets the *lowest* height of a river within half the width: along a river these fall as it
/// does, and where two rivers meet, neither dams the other. Samples beside a bed are lifted above every bed sample that
/// they touch, so that a river that stands above the land does not leak. From the bed, banks rise at `bank_slope` and cut
/// what stands above them, as far as `banks`; in the outer half of that they fade out.
///
/// Land that drains no longer does when it is interpolated, or has noise added. So this comes last, on the grid of the
/// build.
///
/// # Limits
/// Beds drain as far as the rivers fall: `river_profile` sees to that. Tops of walls stand where `banks` is too short to
/// reach up to the land.
///
/// # See also
/// `river_profile` for the heights of the beds, `draw_rivers` for a mask of the same rivers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CarveRivers {
    /// Factor on the width of the rivers.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-soft" = [0.0, 5.0]))]
    pub width: Number,
    /// Slope of the banks.
    #[schemars(range(min = 0.0, max = 85.0), extend("x-soft" = [5.0, 60.0]))]
    pub bank_slope: Degrees,
    /// How far banks reach from the edge of the bed.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub banks: Metres,
    /// Lowest Strahler order of the rivers that are cut: 1 cuts all, 2 leaves the sources out.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub least_order: u32,
}

impl Default for CarveRivers {
    fn default() -> Self {
        Self { width: Number(1.0), bank_slope: Degrees(25.0), banks: Metres(80.0), least_order: 1 }
    }
}

ports! {
    pub struct Inputs {
        /// Land to cut, in metres.
        height: Field,
        /// Rivers with the heights of their beds.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// Land with beds, in metres.
        height: Field = Meaning::like("height"),
        /// Where there is a bed: 1, and 0 elsewhere.
        bed: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for CarveRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zhang2016"])
        .keywords(&["river bed", "channel", "burn", "drain", "valley", "water"])
        .mixes(&[("height", "height")])
        .reads(Reads::BASE);

    /// A sample hangs on the land under it alone, but also on the cell of the grid.
    fn reach(&self) -> Reach {
        Reach::local(0.0)
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let grid = &load.grid;
        let rivers = load.object::<Rivers>("rivers").unwrap_or_default();
        let lines = self.lines(&rivers);
        let own = size_of_val(lines.as_slice()) as u64;
        let bytes = self.carving(grid, load.terrain.base_cell()).bytes(grid, &lines) + own;
        // Links look at the samples around them: so many cells wide at the least.
        let looks = lines.len() as f64 * (self.banks.0 / grid.cell() + 2.0) * 20.0;
        let most = 40.0 * grid.len() as f64;
        Cost { bytes, seconds: grid.len() as f64 * 12e-9 + looks.min(most) * 6e-9 }
    }

    fn run(&self, cx: &Context<'_>, Inputs { height, rivers }: Inputs) -> Result<Outputs> {
        let lines = self.lines(&rivers);
        let carved = self.carving(&cx.grid, cx.base_cell()?).carve(&cx.work, &height, &cx.grid, &lines)?;
        Ok(Outputs { height: carved.height, bed: carved.bed })
    }
}

impl CarveRivers {
    fn carving(&self, grid: &Grid, base_cell: f64) -> Carving {
        let radians = self.bank_slope.0 * (std::f64::consts::PI / 180.0);
        Carving { cell: grid.cell().max(base_cell), rise: libm::tan(radians), reach: self.banks.0 }
    }

    fn lines(&self, rivers: &Rivers) -> Vec<WideLine> {
        let large = rivers
            .links()
            .filter(|(upper, _)| u32::from(rivers.vertices()[*upper].order) >= self.least_order);
        let link = |(upper, lower): (usize, usize)| {
            let of = rivers.vertices()[upper];
            WideLine {
                line: river(rivers, (upper, lower)),
                width: f64::from(of.width) * self.width.0,
                order: of.order,
            }
        };
        large.map(link).collect()
    }
}
