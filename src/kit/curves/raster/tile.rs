//! Tiles: which parts touch which, and filling one in.

use super::cell::{Nearest, Outcome, Reach, Strict};
use super::ribbon::{Ribbon, Rim};
use super::shape::Shape;
use super::{MAX_BINNED, Options, SLACK};
use crate::value::curves::CurveError;
use crate::value::curves::bezier::sub;
use crate::value::{Grid, Mark, Planes};

/// Cells along a side of a tile.
const SIDE: usize = 32;

/// The number of a curve and of one of its parts.
type Entry = (u32, u32);

/// The parts that touch each tile, curve by curve in order.
pub(super) struct Bins {
    tiles: Vec<Vec<Entry>>,
    across: usize,
}

impl Bins {
    pub(super) fn new<'a, P>(grid: &Grid, curves: impl Iterator<Item = P>) -> Result<Self, CurveError>
    where
        P: Iterator<Item = &'a Shape>,
    {
        let (across, down) = (grid.cols.div_ceil(SIDE), grid.rows.div_ceil(SIDE));
        let mut bins = Self { tiles: vec![Vec::new(); across * down], across };
        if grid.is_empty() {
            return Ok(bins);
        }
        let mut entries = 0;
        let (origin, step) = ([grid.x(0), grid.y(0)], SIDE as f64 * grid.cell());
        let last = (SIDE - 1) as f64 * grid.cell();
        for (c, parts) in curves.enumerate() {
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
                    return Err(CurveError::TooMany { what: "parts of curves in tiles", most, found });
                }
            }
        }
        Ok(bins)
    }

    fn at(&self, row: usize, column: usize) -> &[Entry] {
        &self.tiles[row * self.across + column]
    }
}

/// The rows of all planes that one row of tiles fills.
pub(super) struct Band<'a> {
    /// Number of the row of tiles.
    number: usize,
    rows: usize,
    marks: &'a mut [u8],
    height: Option<&'a mut [f32]>,
    direction: Option<&'a mut [[f32; 2]]>,
    steepness: Option<&'a mut [f32]>,
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
        let Planes { marks, height, direction, steepness, noise, envelope } = planes;
        let (mut height, mut direction) = (cut(height, n), cut(direction, n));
        let (mut steepness, mut noise) = (cut(steepness, n), cut(noise, n));
        let mut envelope = cut(envelope, n);
        let band = |(number, marks): (usize, &'a mut [u8])| Self {
            number,
            rows: marks.len() / grid.cols,
            marks,
            height: height.next().flatten(),
            direction: direction.next().flatten(),
            steepness: steepness.next().flatten(),
            noise: noise.next().flatten(),
            envelope: envelope.next().flatten(),
        };
        marks.chunks_mut(n).enumerate().map(band).collect()
    }
}

/// All that filling a tile reads.
pub(super) struct Scene<'a> {
    pub(super) grid: &'a Grid,
    pub(super) xs: &'a [f64],
    pub(super) ready: &'a [(Ribbon, Vec<Rim>)],
    pub(super) strips: &'a Bins,
    pub(super) rims: &'a Bins,
    pub(super) options: &'a Options,
}

/// Where a tile stands in its band.
struct Place {
    row: usize,
    rows: usize,
    column: usize,
    columns: usize,
}

/// The cells of a tile while it is filled; what is not listed as touched is as new.
struct Desk {
    strict: Vec<Strict>,
    nearest: Vec<Nearest>,
    outcomes: Vec<Outcome>,
    /// Cells that the curve at hand touches, then all that were touched.
    touched: Vec<u16>,
    all: Vec<u16>,
}

impl Desk {
    fn new() -> Self {
        let n = SIDE * SIDE;
        Self {
            strict: vec![Strict::default(); n],
            nearest: vec![Nearest::NOTHING; n],
            outcomes: vec![Outcome::default(); n],
            touched: Vec::with_capacity(n),
            all: Vec::with_capacity(n),
        }
    }
}

impl Scene<'_> {
    /// Fills a band, tile by tile.
    pub(super) fn band(&self, band: &mut Band<'_>) {
        let mut desk = Desk::new();
        for t in 0..self.grid.cols.div_ceil(SIDE) {
            let column = t * SIDE;
            let columns = SIDE.min(self.grid.cols - column);
            let place = Place { row: band.number * SIDE, rows: band.rows, column, columns };
            for curve in self.strips.at(band.number, t).chunk_by(|a, b| a.0 == b.0) {
                self.curve(curve, &place, &mut desk);
            }
            for i in desk.all.drain(..).map(usize::from) {
                let at = (i / SIDE) * self.grid.cols + column + i % SIDE;
                write(band, at, &std::mem::take(&mut desk.outcomes[i]));
            }
            self.envelope(self.rims.at(band.number, t), &place, band);
        }
    }

    /// Goes through the parts of one curve in a tile.
    fn curve(&self, entries: &[Entry], place: &Place, desk: &mut Desk) {
        let Some(&(number, _)) = entries.first() else { return };
        let (ribbon, _) = &self.ready[number as usize];
        let slack = SLACK * self.grid.cell();
        for &(_, p) in entries {
            let part = &ribbon.parts[p as usize];
            self.cover(&part.shape, place, |i, at| {
                let Some(spot) = part.shape.locate(at) else { return };
                let reach = ribbon.reach(part, &spot, slack);
                if reach == Reach::Beyond {
                    return;
                }
                let (nearest, strict) = (&mut desk.nearest[i], &mut desk.strict[i]);
                if !nearest.is_some() && !strict.is_some() {
                    desk.touched.push(i as u16);
                }
                if reach != Reach::Plateau {
                    nearest.meet(spot.distance, p, slack);
                }
                if reach != Reach::Slope {
                    strict.meet(part, &spot, slack);
                }
            });
        }
        for i in desk.touched.drain(..) {
            let k = usize::from(i);
            let out = &mut desk.outcomes[k];
            if out.is_new() {
                desk.all.push(i);
            }
            let strict = &mut desk.strict[k];
            let on_plateau = ribbon.has_height && strict.is_some();
            if strict.is_some() {
                strict.finish(ribbon, out);
                *strict = Strict::default();
            }
            let nearest = std::mem::replace(&mut desk.nearest[k], Nearest::NOTHING);
            if nearest.is_some() && !on_plateau {
                let world = [self.xs[place.column + k % SIDE], self.grid.y(place.row + k / SIDE)];
                // Where several curves meet nothing will be given, so nothing needs working out.
                let known = if out.slopes > 0 {
                    None
                } else {
                    ribbon.gradient(&nearest, |part| sub(world, part.shape.from))
                };
                out.slope(ribbon, known);
            }
        }
    }

    /// Visits the cells of a tile that a shape may cover: index in the tile and position relative to the shape.
    #[inline(always)]
    fn cover(&self, shape: &Shape, place: &Place, mut visit: impl FnMut(usize, [f64; 2])) {
        let per_cell = 1.0 / self.grid.cell();
        let (x0, y0) = (self.xs[place.column] - shape.from[0], self.grid.y(place.row) - shape.from[1]);
        // The whole numbers from `low` to `high`, both in metres, below `n`; without `floor`, which is a call here.
        let range = |low: f64, high: f64, n: usize| {
            let (low, high) = ((low * per_cell).max(0.0), high * per_cell);
            let first = low as usize + usize::from((low as usize as f64) < low);
            first..if high < 0.0 { 0 } else { (high as usize).saturating_add(1).min(n) }
        };
        let xs = &self.xs[place.column..][..place.columns];
        for r in range(shape.min[1] - y0, shape.max[1] - y0, place.rows) {
            let y = self.grid.y(place.row + r) - shape.from[1];
            let Some([low, high]) = shape.span(y) else { continue };
            for c in range(low - x0, high - x0, place.columns) {
                visit(r * SIDE + c, [xs[c] - shape.from[0], y]);
            }
        }
    }

    /// Raises the envelope's weight to the largest that any part gives.
    fn envelope(&self, entries: &[Entry], place: &Place, band: &mut Band<'_>) {
        let Some(plane) = &mut band.envelope else { return };
        let slack = SLACK * self.grid.cell();
        for &(c, p) in entries {
            let rim = &self.ready[c as usize].1[p as usize];
            self.cover(&rim.shape, place, |i, p| {
                let at = (i / SIDE) * self.grid.cols + place.column + i % SIDE;
                let weight = rim.weight(p, self.options.feather, slack) as f32;
                plane[at] = plane[at].max(weight);
            });
        }
    }
}

/// Writes what the curves say together about a cell into the planes.
fn write(band: &mut Band<'_>, at: usize, o: &Outcome) {
    let mut marks = 0;
    if o.heights > 0.0
        && let Some(plane) = &mut band.height
    {
        plane[at] = (o.height / f64::from(o.heights)) as f32;
        marks |= Mark::Height.bit();
    }
    if o.noises > 0.0
        && let Some(plane) = &mut band.noise
    {
        plane[at] = o.noise.map(|x| (x / f64::from(o.noises)) as f32);
        marks |= Mark::Noise.bit();
    }
    if o.slopes > 1 {
        marks |= Mark::Open.bit();
    } else if o.slopes == 1
        && o.direction != [0.0; 2]
        && let (Some(direction), Some(steepness)) = (&mut band.direction, &mut band.steepness)
    {
        direction[at] = o.direction;
        steepness[at] = o.steepness;
        marks |= Mark::Gradient.bit();
    }
    band.marks[at] = marks;
}
