//! Geomorphometry: figures that tell made land from real land.
//!
//! [`Figures::of`] measures [`Land`]. Real land has its figures within ranges that hang on the size of its cells and, less,
//! on its extent, and made land that looks wrong is mostly outside some of them:
//!
//! - [`Hypsometry`]: how heights are spread.
//! - [`Spectrum`]: how rough land is at every wavelength, and whether it is so in all directions.
//! - [`Slope`] and [`Aspect`]: how steep it is, and whether it faces the axes of the grid.
//! - [`Curvature`]: whether ridges or valleys are the sharper.
//! - [`Depressions`]: how much of it has no way down.
//! - [`Channels`]: how its streams run, and how steep they are for what they drain.
//! - [`Network`]: how its streams branch; [`RiverFigures`] has the same of a network that was drawn.
//!
//! Almost every figure changes with the size of a cell, so that land is compared with land of about the same cell and
//! extent in cells; [`Land::averaged`] makes cells larger.
//!
//! Sums go in a fixed order, so that figures are the same for any number of threads. Those of the spectrum hang on the
//! sines of the standard library in the last digits, which other machines may round otherwise.

mod channels;
mod curvature;
mod depressions;
mod gradient;
mod hypsometry;
mod land;
mod line;
mod network;
mod rectangle;
mod rivers;
mod spectrum;
mod sums;

use serde::Serialize;

pub use channels::Channels;
pub use curvature::Curvature;
pub use depressions::Depressions;
pub use gradient::{Aspect, Slope};
pub use hypsometry::Hypsometry;
pub use land::Land;
pub use line::Fit;
pub use network::{Network, Node, Order, Tokunaga};
pub use rivers::RiverFigures;
pub use spectrum::Spectrum;

use crate::kit::flow::{self, Surface, Tree, accumulate, epsilon};
use crate::work::{Cancelled, Work};

/// Bytes a cell of land that [`Figures::of`] takes beside the heights, at most.
pub const BYTES: u64 = 40;

/// Most cells of land that [`Figures::of`] measures.
pub const MOST_CELLS: usize = 1 << 28;

/// Drained area, in cells, from which a cell is a channel where nothing else is said.
pub const CHANNEL: u32 = 200;

/// All figures of some land.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Columns and rows.
    pub samples: [usize; 2],
    /// Side of a cell, in metres.
    pub cell: f64,
    /// Share of the cells that are land: neither void nor sea.
    pub land: f64,
    /// How heights are spread.
    pub hypsometry: Hypsometry,
    /// Roughness at every wavelength.
    pub spectrum: Option<Spectrum>,
    /// Slope.
    pub slope: Option<Slope>,
    /// Directions of slopes.
    pub aspect: Option<Aspect>,
    /// Curvature at each scale.
    pub curvature: Vec<Curvature>,
    /// Pits and what fills them.
    pub depressions: Depressions,
    /// Channels.
    pub channels: Option<Channels>,
    /// The streams of the channels.
    pub network: Option<Network>,
}

impl Figures {
    /// The figures of some land, whose channels drain `channel` m² or more; none where there is no land. Figures that so
    /// little land has not are left out.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    ///
    /// # Panics
    /// When there are more than [`MOST_CELLS`] cells: that is a bug of the caller.
    pub fn of(land: &Land, channel: Option<f64>, work: &Work<'_>) -> Result<Option<Self>, Cancelled> {
        let Some(hypsometry) = Hypsometry::of(land) else { return Ok(None) };
        work.step(0.05)?;
        let spectrum = Spectrum::of(land, &work.stage(0.05, 0.3))?;
        let (slope, aspect) = gradient::measure(land, &work.stage(0.3, 0.45))?;
        let curvature = curvature::measure(land, &work.stage(0.45, 0.7))?;
        let (depressions, channels, network) =
            drainage(land, hypsometry.relief, channel, &work.stage(0.7, 1.0))?;
        Ok(Some(Self {
            samples: [land.cols(), land.rows()],
            cell: land.cell(),
            land: land.count() as f64 / land.heights().len() as f64,
            hypsometry,
            spectrum,
            slope,
            aspect,
            curvature,
            depressions,
            channels,
            network,
        }))
    }
}

/// The figures of water that runs over land.
///
/// Depths and slopes are those of the filled surface. Ways are those of one that rises by the least that heights can
/// differ by, from cell to cell, where the other is level: they cross lakes in the shortest way to their outlet.
#[allow(clippy::type_complexity, reason = "three figures of one pass, taken apart at once")]
fn drainage(
    land: &Land,
    relief: f64,
    channel: Option<f64>,
    work: &Work<'_>,
) -> Result<(Depressions, Option<Channels>, Option<Network>), Cancelled> {
    let (cols, cell) = (land.cols(), land.cell());
    let surface = Surface::new(cols, land.rows(), cell, land.heights(), None);
    let level = flow::Depressions::find(&surface, &work.stage(0.0, 0.15))?.filled(&surface, &work.quiet())?;
    let filled = depressions::Filled::new(land, &level, &work.stage(0.15, 0.2))?;
    let depressions = filled.figures(relief, work)?;
    let sloped = epsilon::fill(&surface, 0.0, &work.stage(0.2, 0.4))?;
    let tree = Tree::of(&surface.with_height(&sloped), &work.stage(0.4, 0.5))?;
    drop(sloped);
    let is_land = |cell: usize| land.heights()[cell].is_finite();
    let area = accumulate::count(&tree, is_land, &work.stage(0.5, 0.6))?;
    let threshold = channel.unwrap_or(f64::from(CHANNEL) * cell * cell);
    // A quotient such as 0.3 / 0.1 may fall just short of the whole number it stands for.
    let cells = (threshold / (cell * cell) - 1e-9).ceil().max(1.0) as u32;
    let Some(course) = channels::Course::new(&filled, &tree, &area, cells) else {
        return Ok((depressions, None, None));
    };
    let channels = course.figures(threshold, &work.stage(0.6, 0.9))?;
    Ok((depressions, Some(channels), Network::of(&course.nodes())))
}
