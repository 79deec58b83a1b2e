//! Tiles: which parts touch which, and filling one in.

use super::cell::{Nearest, Outcome, Reach, Strict};
use super::meeting::{self, Meeting, Said};
use super::ribbon::{Ribbon, Rim};
use super::shape::Shape;
use super::stock::Window;
use super::{Options, SLACK};
use crate::value::curves::CurveError;
use crate::value::{Grid, Mark, Planes};

/// Cells along a side of a tile.
const SIDE: usize = 32;

/// Most parts in all tiles together, at once; 8 bytes each, and as much again while their lists grow.
pub(super) const MAX_BINNED: usize = 1 << 18;

/// The number of a curve and of one of its parts.
type Entry = (u32, u32);

/// Parts of curves in a tile after which it is asked whether to stop: some milliseconds of work.
const PACE: usize = 64;

/// Asked now and then whether to give up.
pub(super) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// # Errors
/// When the work was asked to stop.
fn check(stop: Stop<'_>) -> Result<(), CurveError> {
    if stop() { Err(CurveError::Cancelled) } else { Ok(()) }
}

/// Some rows of tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles {
    first: usize,
    down: usize,
    across: usize,
}

impl Tiles {
    pub(super) fn of(bands: &[Band<'_>], grid: &Grid) -> Self {
        let first = bands.first().map_or(0, |b| b.number);
        Self { first, down: bands.len(), across: grid.cols.div_ceil(SIDE) }
    }

    /// Where their samples lie, and a cell around them.
    pub(super) fn window(&self, grid: &Grid) -> Window {
        let cell = grid.cell();
        let (top, bottom) = (self.first * SIDE, ((self.first + self.down) * SIDE).min(grid.rows));
        Window {
            min: [grid.x(0) - cell, grid.y(top) - cell],
            max: [grid.x(grid.cols - 1) + cell, grid.y(bottom - 1) + cell],
        }
    }
}

/// The parts that touch each of some tiles, curve by curve in order.
pub(super) struct Bins {
    tiles: Vec<Vec<Entry>>,
    of: Tiles,
}

impl Bins {
    pub(super) fn new<'a, P>(
        grid: &Grid,
        of: &Tiles,
        curves: impl Iterator<Item = P>,
        stop: Stop<'_>,
    ) -> Result<Self, CurveError>
    where
        P: Iterator<Item = &'a Shape>,
    {
        let Tiles { first, down, across } = *of;
        let mut bins = Self { tiles: vec![Vec::new(); across * down], of: *of };
        let mut entries = 0;
        let (origin, step) = ([grid.x(0), grid.y(first * SIDE)], SIDE as f64 * grid.cell());
        let last = (SIDE - 1) as f64 * grid.cell();
        for (c, parts) in curves.enumerate() {
            check(stop)?;
            for (p, shape) in parts.enumerate() {
                let range = |k: usize, tiles: usize| {
                    let at = shape.from[k] - origin[k];
                    let low = ((at + shape.min[k] - last) / step).ceil().max(0.0);
                    let high = ((at + shape.max[k]) / step).floor().min(tiles as f64 - 1.0);
                    // An empty range where the shape lies beside the grid.
                    if low <= high { low as usize..high as usize + 1 } else { 0..0 }
                };
                let columns = range(0, across);
                for row in range(1, down) {
                    for column in columns.clone() {
                        let corner = |k: usize, tile: usize| origin[k] + tile as f64 * step - shape.from[k];
                        let min = [corner(0, column), corner(1, row)];
                        if shape.touches(min, min.map(|x| x + last)) {
                            bins.tiles[row * across + column].push((c as u32, p as u32));
                            entries += 1;
                        }
                    }
                }
                if entries > MAX_BINNED {
                    let (most, found) = (MAX_BINNED as u64, entries as u64);
                    return Err(CurveError::TooMany {
                        what: "parts of curves in tiles of 32 rows",
                        most,
                        found,
                    });
                }
            }
        }
        Ok(bins)
    }

    fn at(&self, row: usize, column: usize) -> &[Entry] {
        &self.tiles[(row - self.of.first) * self.of.across + column]
    }
}

/// The rows of all planes that one row of tiles fills.
pub(super) struct Band<'a> {
    /// Number of the row of tiles.
    number: usize,
    rows: usize,
    marks: &'a mut [u8],
    height: Option<&'a mut [f32]>,
    lean: Option<&'a mut [[f32; 2]]>,
    direction: Option<&'a mut [[f32; 2]]>,
    steepness: Option<&'a mut [f32]>,
    trust: Option<&'a mut [f32]>,
    ground: Option<&'a mut [f32]>,
    noise: Option<&'a mut [[f32; 2]]>,
    envelope: Option<&'a mut [f32]>,
}

impl<'a> Band<'a> {
    pub(super) fn split(planes: &'a mut Planes, grid: &Grid) -> Vec<Self> {
        fn cut<T>(plane: &mut Option<Vec<T>>, n: usize) -> impl Iterator<Item = Option<&mut [T]>> {
            let mut chunks = plane.as_mut().map(|p| p.chunks_mut(n));
            std::iter::from_fn(move || Some(chunks.as_mut().and_then(Iterator::next)))
        }
        let n = SIDE * grid.cols;
        let Planes { marks, height, lean, direction, steepness, trust, ground, noise, envelope } = planes;
        let (mut height, mut lean, mut direction) = (cut(height, n), cut(lean, n), cut(direction, n));
        let (mut steepness, mut noise) = (cut(steepness, n), cut(noise, n));
        let (mut trust, mut ground, mut envelope) = (cut(trust, n), cut(ground, n), cut(envelope, n));
        let band = |(number, marks): (usize, &'a mut [u8])| Self {
            number,
            rows: marks.len() / grid.cols,
            marks,
            height: height.next().flatten(),
            lean: lean.next().flatten(),
            direction: direction.next().flatten(),
            steepness: steepness.next().flatten(),
            trust: trust.next().flatten(),
            ground: ground.next().flatten(),
            noise: noise.next().flatten(),
            envelope: envelope.next().flatten(),
        };
        marks.chunks_mut(n).enumerate().map(band).collect()
    }
}

impl Band<'_> {
    /// Writes the values that curves together give a cell.
    fn strict(&mut self, at: usize, o: &Outcome) {
        if let (Some(plane), Some((height, lean))) = (&mut self.height, o.height()) {
            plane[at] = height as f32;
            if let Some(plane) = &mut self.lean {
                plane[at] = lean.map(|x| x as f32);
            }
            self.marks[at] |= if o.heights > 0.0 { Mark::Height.bit() } else { Mark::Edge.bit() };
        }
        if let Some(plane) = &mut self.noise
            && o.noises > 0.0
        {
            plane[at] = o.noise.map(|x| (x / f64::from(o.noises)) as f32);
            self.marks[at] |= Mark::Noise.bit();
        }
    }

    /// Writes what the slopes of curves together say about a cell; where that is nothing, it is left open.
    #[inline]
    fn slope(&mut self, at: usize, said: &Said) {
        let (Some(direction), Some(steepness), Some(trust)) =
            (&mut self.direction, &mut self.steepness, &mut self.trust)
        else {
            return;
        };
        trust[at] = said.trust;
        if let Some(gradient) = said.gradient {
            (direction[at], steepness[at]) = gradient;
            self.marks[at] |= Mark::Gradient.bit();
        } else {
            self.marks[at] |= Mark::Open.bit();
        }
        let known = Mark::Height.bit() | Mark::Edge.bit();
        if let (Some((height, share)), Some(plane), Some(ground)) =
            (said.ground, &mut self.height, &mut self.ground)
            && self.marks[at] & known == 0
        {
            (plane[at], ground[at]) = (height as f32, share);
        }
    }
}

/// All that filling a tile reads.
pub(super) struct Scene<'a> {
    pub(super) grid: &'a Grid,
    pub(super) per_cell: f64,
    pub(super) xs: &'a [f64],
    pub(super) ys: &'a [f64],
    pub(super) ready: &'a [(Ribbon, Vec<Rim>)],
    pub(super) strips: &'a Bins,
    pub(super) rims: &'a Bins,
    pub(super) options: &'a Options,
    pub(super) stop: Stop<'a>,
}

/// Where a tile stands in its band.
struct Place {
    row: usize,
    rows: usize,
    column: usize,
    columns: usize,
}

impl Place {
    /// The index in the band of a cell of the tile.
    #[inline]
    fn index(&self, i: usize, cols: usize) -> usize {
        (i / SIDE) * cols + self.column + i % SIDE
    }
}

/// Cells of a tile.
const CELLS: usize = SIDE * SIDE;

/// The cells of a tile while it is filled; what is not listed is as new.
struct Desk {
    /// Cells on slopes of the curve at hand.
    nearest: Box<[Nearest; CELLS]>,
    sloped: Vec<u16>,
    /// Cells on slopes of any curve.
    meetings: Vec<Meeting>,
    met: Vec<u16>,
    /// Cells on its plateaus.
    strict: Vec<Strict>,
    flat: Vec<u16>,
    /// Cells on plateaus of any curve.
    outcomes: Vec<Outcome>,
    touched: Vec<u16>,
}

impl Desk {
    fn new() -> Self {
        Self {
            nearest: Box::new([Nearest::NOTHING; CELLS]),
            sloped: Vec::with_capacity(CELLS),
            meetings: vec![Meeting::default(); CELLS],
            met: Vec::with_capacity(CELLS),
            strict: vec![Strict::default(); CELLS],
            flat: Vec::with_capacity(CELLS),
            outcomes: vec![Outcome::default(); CELLS],
            touched: Vec::with_capacity(CELLS),
        }
    }

    /// The state of a cell's slope, listed from now on.
    #[inline(always)]
    fn slope(&mut self, i: usize) -> &mut Nearest {
        let nearest = &mut self.nearest[i % CELLS];
        if !nearest.is_some() {
            self.sloped.push(i as u16);
        }
        nearest
    }

    /// The state of a cell's plateau, listed from now on.
    fn plateau(&mut self, i: usize) -> &mut Strict {
        let strict = &mut self.strict[i];
        if !strict.is_some() {
            self.flat.push(i as u16);
        }
        strict
    }
}

impl Scene<'_> {
    /// Fills a band, tile by tile.
    ///
    /// # Errors
    /// When the work was asked to stop.
    pub(super) fn band(&self, band: &mut Band<'_>) -> Result<(), CurveError> {
        let mut desk = Desk::new();
        for t in 0..self.grid.cols.div_ceil(SIDE) {
            check(self.stop)?;
            let column = t * SIDE;
            let columns = SIDE.min(self.grid.cols - column);
            let place = Place { row: band.number * SIDE, rows: band.rows, column, columns };
            for curve in self.strips.at(band.number, t).chunk_by(|a, b| a.0 == b.0) {
                self.curve(curve, &place, &mut desk)?;
            }
            for i in desk.touched.drain(..).map(usize::from) {
                let out = std::mem::take(&mut desk.outcomes[i]);
                band.strict(place.index(i, self.grid.cols), &out);
            }
            for i in desk.met.drain(..).map(usize::from) {
                band.slope(place.index(i, self.grid.cols), &desk.meetings[i].finish());
            }
            self.envelope(self.rims.at(band.number, t), &place, band)?;
        }
        Ok(())
    }

    /// A cell of a tile among the curves.
    fn cell<'a>(&'a self, i: usize, place: &Place) -> meeting::Place<'a, impl Fn(u32) -> &'a Ribbon> {
        let ribbon = |number: u32| &self.ready[number as usize].0;
        let at = [self.xs[place.column + i % SIDE], self.ys[place.row + i / SIDE]];
        meeting::Place { ribbon, at, cell: self.grid.cell() }
    }

    /// Goes through the parts of one curve in a tile.
    fn curve(&self, entries: &[Entry], place: &Place, desk: &mut Desk) -> Result<(), CurveError> {
        let Some(&(number, _)) = entries.first() else { return Ok(()) };
        let (ribbon, _) = &self.ready[number as usize];
        let slack = SLACK * self.grid.cell();
        for (k, &(_, p)) in entries.iter().enumerate() {
            if k % PACE == PACE - 1 {
                check(self.stop)?;
            }
            let part = &ribbon.parts[p as usize];
            let visit = |i: usize, at: [f64; 2]| {
                // Nearly all cells lie right beside a segment, on its slope.
                if ribbon.has_slope
                    && let Some(spot) = part.plain_slope(at, slack)
                {
                    desk.slope(i).meet(ribbon, p, &spot, slack);
                    return;
                }
                let Some(spot) = part.shape.locate(at) else { return };
                let reach = ribbon.reach(part, &spot, slack);
                if matches!(reach, Reach::Slope | Reach::Both) {
                    desk.slope(i).meet(ribbon, p, &spot, slack);
                }
                if matches!(reach, Reach::Plateau | Reach::Edge | Reach::Both) {
                    desk.plateau(i).meet(ribbon, part, &spot, reach != Reach::Edge, slack);
                }
            };
            if part.shape.axis == 0 {
                self.scan::<0>(&part.shape, place, visit);
            } else {
                self.scan::<1>(&part.shape, place, visit);
            }
        }
        for i in desk.flat.drain(..) {
            let k = usize::from(i);
            let out = &mut desk.outcomes[k];
            if out.is_new() {
                desk.touched.push(i);
            }
            std::mem::take(&mut desk.strict[k]).finish(ribbon, out);
            if ribbon.has_height {
                // On its own plateau a curve gives a height and no gradient.
                desk.nearest[k] = Nearest::NOTHING;
            }
        }
        for i in desk.sloped.drain(..).map(usize::from) {
            let nearest = &mut desk.nearest[i % CELLS];
            if nearest.is_some() {
                let meeting = &mut desk.meetings[i];
                if meeting.is_new() {
                    desk.met.push(i as u16);
                }
                meeting.join(number, nearest, &self.cell(i, place));
            }
            *nearest = Nearest::NOTHING;
        }
        Ok(())
    }

    /// Visits the cells of a tile that a shape may cover, in scan lines along axis `U`: index in the tile and position
    /// relative to the shape.
    #[inline(always)]
    fn scan<const U: usize>(&self, shape: &Shape, place: &Place, mut visit: impl FnMut(usize, [f64; 2])) {
        // The whole numbers from `low` to `high`, both in metres, below `n`; without `floor`, which is a call here.
        let range = |low: f64, high: f64, n: usize| {
            let (low, high) = ((low * self.per_cell).max(0.0), high * self.per_cell);
            // A tile has few cells: what is beyond `i32` is beyond the tile.
            let first = low as i32;
            let first = first.saturating_add(i32::from(f64::from(first) < low));
            let end = if high < 0.0 { 0 } else { (high as i32).saturating_add(1).min(n as i32) };
            first as usize..end as usize
        };
        let (xs, ys) = (&self.xs[place.column..][..place.columns], &self.ys[place.row..][..place.rows]);
        let (along, across) = if U == 0 { (xs, ys) } else { (ys, xs) };
        let from = [shape.from[U], shape.from[1 - U]];
        let start = [along[0] - from[0], across[0] - from[1]];
        let bounds = [shape.min[1 - U] - start[1], shape.max[1 - U] - start[1]];
        for line in range(bounds[0], bounds[1], across.len()) {
            let v = across[line] - from[1];
            let Some([low, high]) = shape.span(v) else { continue };
            let cells = range(low - start[0], high - start[0], along.len());
            let first = cells.start;
            for (k, u) in along.get(cells).into_iter().flatten().enumerate() {
                let (k, u) = (first + k, u - from[0]);
                if U == 0 {
                    visit(line * SIDE + k, [u, v]);
                } else {
                    visit(k * SIDE + line, [v, u]);
                }
            }
        }
    }

    /// Raises the envelope's weight to the largest that any part gives.
    fn envelope(&self, entries: &[Entry], place: &Place, band: &mut Band<'_>) -> Result<(), CurveError> {
        let Some(plane) = &mut band.envelope else { return Ok(()) };
        let slack = SLACK * self.grid.cell();
        for (k, &(c, p)) in entries.iter().enumerate() {
            if k % PACE == PACE - 1 {
                check(self.stop)?;
            }
            let rim = &self.ready[c as usize].1[p as usize];
            let visit = |i: usize, p: [f64; 2]| {
                let at = place.index(i, self.grid.cols);
                let weight = rim.weight(p, self.options.feather, slack) as f32;
                plane[at] = plane[at].max(weight);
            };
            if rim.shape.axis == 0 {
                self.scan::<0>(&rim.shape, place, visit);
            } else {
                self.scan::<1>(&rim.shape, place, visit);
            }
        }
        Ok(())
    }
}
