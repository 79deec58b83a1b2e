//! The rig on which every kind is tried: its parameter sets, the grids it stands on, and two ways to run it: in a graph by
//! the engine ([`graph`]), and alone on a bench ([`bench`]), with inputs that a function gives.
//!
//! What is too long for each run of `.ci/run` is tried there in a fixed part; `OROGRAPH_BREADTH=1` tries the whole.

pub(crate) mod bench;
pub(crate) mod bytes;
pub(crate) mod graph;
pub(crate) mod sets;
pub(crate) mod skip;
pub(crate) mod watch;

use std::sync::LazyLock;

use orograph::kit::hash;
use orograph::node::Kind;
use orograph::nodes::Registry;
use orograph::value::{Grid, Terrain};

/// Whether the whole is tried rather than a fixed part.
pub(crate) fn breadth() -> bool {
    std::env::var_os("OROGRAPH_BREADTH").is_some_and(|v| !v.is_empty() && v != "0")
}

/// All of a list, or where not the whole is tried one in so many; which is up to a name, so that lists of several names
/// are not all cut at the same places.
pub(crate) fn part<T>(all: Vec<T>, one_in: usize, name: &str) -> Vec<T> {
    if breadth() {
        return all;
    }
    let from = number(name) as usize % one_in;
    all.into_iter().skip(from).step_by(one_in).collect()
}

/// A number that hangs on a name.
fn number(name: &str) -> u64 {
    name.bytes().fold(7, |sum, b| hash::mix(sum ^ u64::from(b)))
}

/// The shipped kinds.
pub(crate) fn shipped() -> Vec<&'static Kind> {
    static ALL: LazyLock<Registry> = LazyLock::new(Registry::standard);
    ALL.iter().map(|kind| &**kind).collect()
}

/// The sizes that kinds are tried at: below the base grid of the rig's terrains, and above it by two factors.
pub(crate) const SIZES: [u32; 3] = [33, 129, 257];

/// Windows of a whole grid: at corners, of one row, of one sample, across the border of the terrain, and outside of it.
pub(crate) fn windows(whole: &Grid) -> Vec<Grid> {
    let (c, r) = (whole.cols as i64, whole.rows as i64);
    let cut = |[col, row]: [i64; 2], [end, row_end]: [i64; 2]| {
        Grid::between(whole.lattice, [col, row], [end.max(col + 1), row_end.max(row + 1)])
    };
    vec![
        cut([c / 3, r / 4], [c / 3 + c / 5, r / 4 + r / 3]),
        cut([0, 0], [c / 4 + 1, r / 2]),
        cut([c - c / 4, r - r / 3], [c, r]),
        cut([-c / 4, r / 2], [c / 8, r / 2 + 3]),
        cut([c - 3, -r / 4], [c + c / 4, r / 8]),
        cut([c / 2, r / 2], [c / 2 + 1, r / 2 + 1]),
        cut([c + 2, r / 3], [c + c / 3, r / 3 + 2]),
    ]
}

/// A window that the windows of a grid are cut from: all of the terrain and some of what lies around it.
pub(crate) fn around(whole: &Grid) -> Grid {
    let grow = (whole.cols.max(whole.rows) as i64 - 1) / 2;
    Grid::between(whole.lattice, [-grow, -grow], [whole.col_end() + grow, whole.row_end() + grow])
}

/// A terrain of the rig: twice as wide as deep, or half as deep again as wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum World {
    Wide,
    Deep,
}

impl World {
    /// Width, depth and base size.
    pub(crate) fn extent(self) -> (f64, f64, u32) {
        match self {
            Self::Wide => (4096.0, 2048.0, 65),
            Self::Deep => (2400.0, 3600.0, 49),
        }
    }

    /// The terrain and the size of a grid of it: one of [`SIZES`], or for the deep one a size that is no power of two and
    /// one more.
    pub(crate) fn sizes(self) -> Vec<u32> {
        match self {
            Self::Wide => SIZES.to_vec(),
            Self::Deep => vec![73],
        }
    }
}

/// The grid of a size on a terrain.
pub(crate) fn grid(terrain: &Terrain, size: u32) -> Grid {
    terrain.grid(size).unwrap_or_else(|e| panic!("{e}"))
}
