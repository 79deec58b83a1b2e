//! What a level is given, and what changes on it.

use std::ops::Range;

use super::sweep::STATE;
use super::water::SIDE;

/// What a level is given: everything that no step changes but the rain, cell by cell, row by row.
#[derive(Clone, Debug)]
pub struct Site {
    /// Columns.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Distance between neighbours, in metres.
    pub cell: f64,
    /// Heights at the start, in metres: those of the input less what faded.
    pub height: Vec<f32>,
    /// Detail of the input that had faded before the level began, in metres; none on the first level.
    pub faded: Option<Vec<f32>>,
    /// The surface of water that is there at the start, or the height where there is none, in metres.
    pub filled: Vec<f32>,
    /// Loose ground at the start, in metres; none without it.
    pub before: Option<Vec<f32>>,
    /// Rain and sources, in m/s.
    pub rain: Vec<f32>,
    /// Evaporation, in m/s; none without it.
    pub evaporation: Option<Vec<f32>>,
    /// Factor on the erodibility of rock, 0 to 1.
    pub soft: Option<Vec<f32>>,
    /// Factor on every exchange of ground, 0 to 1.
    pub mask: Option<Vec<f32>>,
    /// Level of the sea, in metres.
    pub sea: Option<f32>,
    /// Whether water and load leave over the border. The cells of the border are then the outside.
    pub open: bool,
}

impl Site {
    /// Dry land of so many columns and rows, closed and without rain.
    ///
    /// # Panics
    /// When there is not one height per cell.
    pub fn new(cols: usize, rows: usize, cell: f64, height: Vec<f32>) -> Self {
        assert_eq!(height.len(), cols * rows, "one height per cell");
        let (filled, rain) = (height.clone(), vec![0.0; height.len()]);
        let (faded, before, evaporation, soft, mask, sea) = (None, None, None, None, None, None);
        Self {
            cols,
            rows,
            cell,
            height,
            faded,
            filled,
            before,
            rain,
            evaporation,
            soft,
            mask,
            sea,
            open: false,
        }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cols * self.rows
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell, in m².
    pub fn cell_area(&self) -> f64 {
        self.cell * self.cell
    }

    /// The cells of a row.
    #[inline(always)]
    pub(super) fn span(&self, y: usize) -> Range<usize> {
        y * self.cols..(y + 1) * self.cols
    }

    /// A row of what may not be there, or as much of another.
    #[inline(always)]
    pub(super) fn row_or<'a>(&self, data: Option<&'a [f32]>, y: usize, other: &'a [f32]) -> &'a [f32] {
        data.map_or(&other[..self.cols], |data| &data[self.span(y)])
    }
}

/// What changes on a level, cell by cell, row by row. Small changes of high land and deep water are kept apart from what was
/// there at the start, since an `f32` in thousands of metres swallows them.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Depth of water less that at the start, in metres.
    pub water: Vec<f32>,
    /// Load of the water, in metres of solid.
    pub load: Vec<f32>,
    /// Rock that has gone, in metres.
    pub wear: Vec<f32>,
    /// Loose ground, in metres.
    pub loose: Vec<f32>,
    /// Flow over the edges of each cell to the east, south, south-east and south-west, in m²/s; below 0 the other way.
    pub flow: [Vec<f32>; 4],
}

impl State {
    /// The state of a site at its start.
    pub fn of(site: &Site) -> Self {
        let none = || vec![0.0; site.len()];
        Self {
            water: none(),
            load: none(),
            wear: none(),
            loose: site.before.clone().unwrap_or_else(none),
            flow: [none(), none(), none(), none()],
        }
    }

    /// All quantities, to change.
    pub(super) fn all_mut(&mut self) -> [&mut [f32]; STATE] {
        let [e, s, d, u] = &mut self.flow;
        [&mut self.water, &mut self.load, &mut self.wear, &mut self.loose, e, s, d, u]
    }

    /// Change of the bed of a cell, in metres.
    #[inline(always)]
    pub fn change(&self, site: &Site, cell: usize) -> f32 {
        let before = site.before.as_ref().map_or(0.0, |before| before[cell]);
        (self.loose[cell] - before) - self.wear[cell]
    }

    /// Depth of water of a cell, in metres.
    #[inline(always)]
    pub fn depth(&self, site: &Site, cell: usize) -> f32 {
        ((site.filled[cell] - site.height[cell]) + self.water[cell]).max(0.0)
    }

    /// Flow of a cell as a vector to the east and south, in m²/s.
    pub fn vector(&self, site: &Site, cell: usize) -> [f32; 2] {
        let (cols, i, j) = (site.cols, cell % site.cols, cell / site.cols);
        let other = |k: usize, there: bool, back: usize| if there { self.flow[k][cell - back] } else { 0.0 };
        let across = self.flow[2][cell] + other(2, j > 0 && i > 0, cols + 1);
        let down = self.flow[3][cell] + other(3, j > 0 && i + 1 < cols, cols - 1);
        let x = (self.flow[0][cell] + other(0, i > 0, 1)) + (across - down);
        let y = (self.flow[1][cell] + other(1, j > 0, cols)) + (across + down);
        [x, y].map(|v| 0.5 * SIDE * v)
    }
}
