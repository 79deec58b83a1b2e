//! The state of a level carried to the next finer one.
//!
//! Ground and load are carried by a smooth curve, within their bounds, and none is made or lost (see
//! [`prolong`](crate::kit::erosion::prolong)). Water is carried by its surface where it is deep, so that lakes stay level,
//! and by its depth where it is a film; the difference is told. Flow goes on in the direction that it had.
//!
//! The input of the finer level has detail that the coarser one did not know. Where that cut or filled, the detail fades: a
//! valley floor that was laid down has no bumps of the old land. What bumps lose fills the hollows, so that nothing is lost.

use super::{Settings, Site, State};
use crate::kit::erosion::ladder::Level;
use crate::kit::erosion::prolong::{Curve, Least, Rule, cap, prolong, sum};
use crate::work::{Cancelled, Work};

/// Depth in metres from which water is carried by its surface.
const DEEP: f32 = 1.0;

/// Height of detail that survives, in cells of the finer level.
const ROUGH: f64 = 0.15;

/// What a level is to the next: its points, what it was given, what has become of it.
#[derive(Clone, Copy)]
pub(super) struct Coarse<'a> {
    pub(super) level: &'a Level,
    pub(super) site: &'a Site,
    pub(super) state: &'a State,
}

/// Ground and load at the start of a finer level. Its input heights are changed where their detail fades.
pub(super) fn ground(
    from: Coarse<'_>,
    level: &Level,
    site: &mut Site,
    settings: &Settings,
    work: &Work<'_>,
) -> Result<State, Cancelled> {
    let levels = [from.level, level];
    let amount = Rule { mask: site.mask.as_deref(), ..Rule::AMOUNT };
    let mut state = State::of(site);
    state.wear = prolong(levels, &from.state.wear, &amount, work)?.values;
    if settings.most_wear > 0.0 {
        cap(&mut state.wear, |_| settings.most_wear as f32);
    }
    // A mask does not hold water back, and load is in the water.
    state.load = prolong(levels, &from.state.load, &Rule::AMOUNT, work)?.values;
    let gained = match &from.site.before {
        Some(before) => from.state.loose.iter().zip(before).map(|(loose, before)| loose - before).collect(),
        None => from.state.loose.clone(),
    };
    let floor: Option<Vec<f32>> =
        site.before.as_ref().map(|before| before.iter().map(|before| -before).collect());
    let least = floor.as_deref().map_or(Least::Zero, Least::Each);
    let mut gained = prolong(levels, &gained, &Rule { least, ..amount }, work)?.values;
    if settings.most_deposit > 0.0 {
        cap(&mut gained, |k| settings.most_deposit as f32 + state.wear[k]);
    }
    state.loose.iter_mut().zip(&gained).for_each(|(loose, gained)| *loose = (*loose + gained).max(0.0));
    let faded = fade(from, level, site, &state, work)?;
    for (height, faded) in site.height.iter_mut().zip(&faded).filter(|(_, faded)| **faded != 0.0) {
        *height -= faded;
    }
    site.faded = Some(faded);
    Ok(state)
}

/// What detail loses where the coarser level cut or filled, in metres; below 0 where hollows are filled with that.
fn fade(
    from: Coarse<'_>,
    level: &Level,
    site: &Site,
    state: &State,
    work: &Work<'_>,
) -> Result<Vec<f32>, Cancelled> {
    let levels = [from.level, level];
    let free = Rule { mask: site.mask.as_deref(), ..Rule::CHANGE };
    let (input, before) = match &from.site.faded {
        Some(faded) => (
            from.site.height.iter().zip(faded).map(|(height, faded)| height + faded).collect(),
            prolong(levels, faded, &free, work)?.values,
        ),
        None => (from.site.height.clone(), vec![0.0; site.len()]),
    };
    let coarse = prolong(levels, &input, &Rule::CHANGE, work)?.values;
    let (cols, height) = (level.grid.cols, ROUGH * site.cell);
    let mut faded = level.fill(work, |j, out| {
        for (out, k) in out.iter_mut().zip(j * cols..) {
            let loose = site.before.as_ref().map_or(0.0, |before| before[k]);
            let laid = (state.loose[k] - loose).max(0.0);
            let part = f64::from(laid) / height;
            let fades = (1.0 - libm::exp(-part * part)) as f32;
            let mask = site.mask.as_ref().map_or(1.0, |mask| mask[k]);
            let fades = if laid > 0.0 { fades * mask } else { 0.0 };
            *out = before[k] + (site.height[k] - coarse[k]) * fades;
        }
    })?;
    // What bumps lose fills the hollows: the larger sum gives way.
    let (lost, got) = (sum(&faded, |v| v.max(0.0)), sum(&faded, |v| (-v).max(0.0)));
    let of_lost = if lost > got { got / lost } else { 1.0 };
    let of_got = if got > lost { lost / got } else { 1.0 };
    for faded in &mut faded {
        *faded = (f64::from(*faded) * if *faded > 0.0 { of_lost } else { of_got }) as f32;
    }
    Ok(faded)
}

/// Water of the finer level, as a change from its start, and the volume in m³ that it has more than the coarser one.
pub(super) fn water(
    from: Coarse<'_>,
    level: &Level,
    site: &Site,
    state: &State,
    work: &Work<'_>,
) -> Result<(Vec<f32>, f64), Cancelled> {
    let (coarse, cols) = (from.site, from.level.grid.cols);
    let corners = Corners { from: from.level, to: level };
    let water = level.fill(work, |j, out| {
        let start = j * level.grid.cols;
        for (i, out) in out.iter_mut().enumerate() {
            let k = start + i;
            let lake = site.filled[k] - site.height[k];
            let change = state.change(site, k);
            let (mut deep, mut surface, mut film) = (0.0, 0.0, 0.0);
            for ([a, b], share) in corners.of([i, j]) {
                let at = b * cols + a;
                let (depth, wet) = (from.state.depth(coarse, at), from.state.water[at]);
                // Between two lakes of the start only the change counts: each level knows its own sill.
                let same = lake > 0.0 && coarse.filled[at] > coarse.height[at];
                let rose = from.state.change(coarse, at) + wet;
                let rose = if same { rose } else { (coarse.filled[at] - site.filled[k]) + rose };
                // A lake of the coarser start alone is one of its sampling, and no water that came.
                if if same { depth } else { wet } > DEEP {
                    deep += share;
                    surface += share * rose;
                }
                film += share * wet;
            }
            *out = if deep > 0.0 { surface / deep - change } else { film };
            *out = out.max(-lake);
        }
    })?;
    let volume = |values: &[f32], level: &Level| sum(values, |depth| depth) * level.cell_area();
    let more = volume(&water, level) - volume(&from.state.water, from.level);
    Ok((water, more))
}

/// Flow over the edges of the finer level, so that water goes on where it went: its vectors between the points of the coarser
/// one, along each edge.
pub(super) fn flow(from: Coarse<'_>, level: &Level, work: &Work<'_>) -> Result<[Vec<f32>; 4], Cancelled> {
    let vectors: Vec<[f32; 2]> =
        (0..from.site.len()).map(|cell| from.state.vector(from.site, cell)).collect();
    let rule = Rule { curve: Curve::Straight, ..Rule::CHANGE };
    let carried = |axis: usize| {
        let along: Vec<f32> = vectors.iter().map(|vector| vector[axis]).collect();
        Ok(prolong([from.level, level], &along, &rule, work)?.values)
    };
    let (x, y) = (carried(0)?, carried(1)?);
    let (cols, rows) = (level.grid.cols, level.grid.rows);
    let diagonal = std::f32::consts::FRAC_1_SQRT_2;
    let edges = |step: [isize; 2], unit: [f32; 2]| {
        level.fill(work, |j, out| {
            for (i, out) in out.iter_mut().enumerate() {
                let there = [i.wrapping_add_signed(step[0]), j.wrapping_add_signed(step[1])];
                if there[0] < cols && there[1] < rows {
                    let (a, b) = (j * cols + i, there[1] * cols + there[0]);
                    *out = 0.5 * ((x[a] + x[b]) * unit[0] + (y[a] + y[b]) * unit[1]);
                }
            }
        })
    };
    Ok([
        edges([1, 0], [1.0, 0.0])?,
        edges([0, 1], [0.0, 1.0])?,
        edges([1, 1], [diagonal, diagonal])?,
        edges([-1, 1], [-diagonal, diagonal])?,
    ])
}

/// Points of a coarser level around those of a finer one.
struct Corners<'a> {
    from: &'a Level,
    to: &'a Level,
}

impl Corners<'_> {
    /// The four points around a point of the finer level, with their shares, which add up to 1.
    fn of(&self, at: [usize; 2]) -> [([usize; 2], f32); 4] {
        let last = [self.from.grid.cols - 1, self.from.grid.rows - 1];
        let axis = |axis: usize| {
            let steps = self.to.steps_on(self.from, at[axis]).clamp(0.0, last[axis] as f64);
            let first = steps as usize;
            (first, (first + 1).min(last[axis]), (steps - first as f64) as f32)
        };
        let ((west, east, a), (north, south, b)) = (axis(0), axis(1));
        [
            ([west, north], (1.0 - a) * (1.0 - b)),
            ([east, north], a * (1.0 - b)),
            ([west, south], (1.0 - a) * b),
            ([east, south], a * b),
        ]
    }
}
