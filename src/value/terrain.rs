//! The world being made.

use serde::{Deserialize, Serialize};

use super::{Bounds, Grid, Lattice};

/// Fewest samples along the longer side of a grid.
pub const MIN_SIZE: u32 = 3;
/// Most samples along the longer side of a grid; 2¹⁸ + 1 is a 65-gigasample terrain, built in tiles.
pub const MAX_SIZE: u32 = (1 << 18) + 1;
/// Most samples along the longer side of the base grid, which is held in memory whole.
pub const MAX_BASE: u32 = (1 << 14) + 1;
/// Largest extent of a terrain, in metres: half the girth of the Earth.
pub const MAX_EXTENT: f64 = 2.0e7;

/// The world being made: where it lies, how large it is, and the grid on which global nodes run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Terrain {
    /// North-west corner, in metres, x to the east and y to the south.
    pub origin: [f64; 2],
    /// East-west extent, in metres.
    pub width: f64,
    /// North-south extent, in metres.
    pub depth: f64,
    /// Height of the water, in metres; none where the land is dry however low it lies.
    pub sea_level: Option<f64>,
    /// Seed of the whole graph; every random choice mixes it in.
    pub seed: u32,
    /// Samples along the longer side of the base grid.
    pub base: u32,
    /// Where the terrain lies on Earth, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geo: Option<Geo>,
}

/// The projected coordinates of a terrain's north-west corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geo {
    /// EPSG code of a projected coordinate system in metres.
    pub epsg: u32,
    /// Easting of the corner, in metres.
    pub east: f64,
    /// Northing of the corner, in metres.
    pub north: f64,
}

impl Default for Terrain {
    fn default() -> Self {
        let (width, depth) = (8192.0, 8192.0);
        Self { origin: [0.0, 0.0], width, depth, sea_level: Some(0.0), seed: 1, base: 1025, geo: None }
    }
}

impl Terrain {
    /// The longer side, in metres.
    pub fn span(&self) -> f64 {
        self.width.max(self.depth)
    }

    /// The whole rectangle, in metres.
    pub fn bounds(&self) -> Bounds {
        let [x, y] = self.origin;
        Bounds { min: [x, y], max: [x + self.width, y + self.depth] }
    }

    /// What is wrong with the settings: the name of the setting and a sentence; `None` when nothing is.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        let extent = |v: f64| v.is_finite() && (1.0..=MAX_EXTENT).contains(&v);
        if let Some((name, v)) =
            [("width", self.width), ("depth", self.depth)].into_iter().find(|(_, v)| !extent(*v))
        {
            return Some((name, format!("must be from 1 to {MAX_EXTENT} m, got {v}")));
        }
        if self.origin.iter().any(|v| !v.is_finite() || v.abs() > 1e8) {
            return Some(("origin", format!("must lie within 1e8 m of zero, got {:?}", self.origin)));
        }
        if let Some(level) = self.sea_level.filter(|v| !v.is_finite() || v.abs() > 1e5) {
            return Some(("sea_level", format!("must be from -1e5 to 1e5 m, got {level}")));
        }
        if self.geo.is_some_and(|g| !g.east.is_finite() || !g.north.is_finite()) {
            return Some(("geo", "needs finite coordinates".into()));
        }
        if !(MIN_SIZE..=MAX_BASE).contains(&self.base) {
            return Some((
                "base",
                format!("must be from {MIN_SIZE} to {MAX_BASE} samples, got {}", self.base),
            ));
        }
        self.grid(self.base).err().map(|e| ("base", e))
    }

    /// The grid of the whole terrain with `size` samples along the longer side.
    ///
    /// # Errors
    /// A sentence when the size is out of range, or when its cell does not divide the shorter side; the nearest
    /// sizes that do are named.
    pub fn grid(&self, size: u32) -> Result<Grid, String> {
        if !(MIN_SIZE..=MAX_SIZE).contains(&size) {
            return Err(format!("a size is from {MIN_SIZE} to {MAX_SIZE} samples, got {size}"));
        }
        let intervals = size - 1;
        let short = self.width.min(self.depth);
        let Some(steps) = self.divides(intervals) else {
            let near = self.sizes_near(size);
            let hint = match near.as_slice() {
                [] => "no size fits; make one side a multiple of the other".to_owned(),
                [one] => format!("the nearest that does is {one}"),
                near => format!("the nearest that do are {}", join(near)),
            };
            return Err(format!(
                "{size} samples over {} m give a cell that does not divide the other side of {short} m; {hint}",
                self.span()
            ));
        };
        let lattice = Lattice { origin: self.origin, span: self.span(), intervals };
        let (long, short) = (size as usize, steps as usize + 1);
        let (cols, rows) = if self.width >= self.depth { (long, short) } else { (short, long) };
        Ok(Grid { lattice, col: 0, row: 0, cols, rows })
    }

    /// The grid on which global nodes and summaries run.
    ///
    /// # Panics
    /// When the settings have a [`fault`](Self::fault): a checked terrain has none.
    pub fn base_grid(&self) -> Grid {
        self.grid(self.base).expect("a checked terrain has a base grid")
    }

    /// The lattice of the base grid.
    pub fn base_lattice(&self) -> Lattice {
        Lattice { origin: self.origin, span: self.span(), intervals: self.base.max(2) - 1 }
    }

    /// The widest window of a lattice that is ever evaluated: the terrain and half its longer side around it.
    /// Beyond it border values continue, so that no chain of wide filters asks for more than four terrains.
    pub fn apron(&self, lattice: Lattice) -> Grid {
        let whole = Grid::covering(lattice, self.bounds().shrunk_by_rounding());
        whole.grow_cells(i64::from(lattice.intervals.div_ceil(2)))
    }

    /// Distance between samples of the base grid, in metres.
    pub fn base_cell(&self) -> f64 {
        self.span() / f64::from(self.base - 1)
    }

    /// Steps along the shorter side, when `intervals` along the longer side divide it.
    fn divides(&self, intervals: u32) -> Option<u32> {
        let steps = self.width.min(self.depth) * f64::from(intervals) / self.span();
        let whole = steps.round();
        ((steps - whole).abs() <= 1e-9 * whole.max(1.0) && whole >= 1.0).then_some(whole as u32)
    }

    /// The nearest size below and above that divides both sides.
    fn sizes_near(&self, size: u32) -> Vec<u32> {
        let fits = |n: &u32| self.divides(n - 1).is_some();
        let below = (MIN_SIZE..size).rev().take(1 << 16).find(fits);
        let above = (size + 1..=MAX_SIZE).take(1 << 16).find(fits);
        below.into_iter().chain(above).collect()
    }
}

fn join(sizes: &[u32]) -> String {
    sizes.iter().map(u32::to_string).collect::<Vec<_>>().join(" and ")
}
