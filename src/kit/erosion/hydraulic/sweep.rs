//! One step of a band of rows: every stage of the scheme in one sweep, so that each number is read and written once.
//!
//! A row is finished when three rows after it have been begun: its cells need the limits of their neighbours, which need the
//! flows around those, which need the flow vectors of the cells beyond, which need the edges of a third ring. The rows before
//! and after a band are worked out again from copies taken before the step, so that bands go side by side in any order, and
//! the result has the same bits whatever the bands are.

use super::border;
use super::consts::Consts;
use super::ground::{Around, Edges, Given, drown, exchange};
use super::held::Held;
use super::site::Site;
use super::water::{Ends, drive, evaporate, limit, rain, share, slow, square, start};
use crate::kit::erosion::band::Band;
use crate::kit::erosion::lines::Lines;
use crate::kit::simd::Kernel;

/// Rows beyond a band that its own rows hang on.
pub(super) const REACH: usize = 3;

/// Quantities of the state: water, load, wear, loose ground, flows to the east, south, south-east and south-west.
pub(super) const STATE: usize = 8;

/// A step of a band.
pub(super) struct Sweep<'a> {
    pub(super) site: &'a Site,
    pub(super) consts: Consts,
    pub(super) band: Band<'a, STATE>,
    pub(super) held: &'a mut Held,
}

impl Kernel for Sweep<'_> {
    #[inline(always)]
    fn run(mut self) {
        match (self.site.sea.is_some(), self.consts.per_hardening > 0.0) {
            (false, false) => self.sweep::<false, false>(),
            (false, true) => self.sweep::<false, true>(),
            (true, false) => self.sweep::<true, false>(),
            (true, true) => self.sweep::<true, true>(),
        }
    }
}

/// The row that a stage works on which follows so many rows behind the first, if it has to.
#[inline(always)]
fn behind(t: usize, rows: usize, from: usize, to: usize) -> Option<usize> {
    let y = t.checked_sub(rows)?;
    (from..to).contains(&y).then_some(y)
}

impl Sweep<'_> {
    #[inline(always)]
    fn sweep<const SEA: bool, const HARD: bool>(&mut self) {
        let ([from, to], last) = (self.band.rows, self.site.rows);
        let first = from.saturating_sub(REACH);
        // Row t is begun; the stages follow it, as far as the band hangs on them.
        for t in first..to + REACH {
            if t < last {
                self.begin(t);
            }
            if let Some(y) = behind(t, 1, first, last) {
                self.drive(y);
                if y > first || y == 0 {
                    self.square(y);
                }
            }
            if let Some(y) = behind(t, 2, from.saturating_sub(2), last) {
                self.slow(y);
                if y + 1 >= from {
                    self.limit(y);
                }
            }
            if let Some(y) = behind(t, 3, from.saturating_sub(1), last) {
                self.share(y);
                if y >= from {
                    self.finish::<SEA, HARD>(y);
                }
            }
        }
    }

    /// Rain and evaporation, and what follows from the state of a row.
    #[inline(always)]
    fn begin(&mut self, y: usize) {
        let (site, held) = (self.site, &mut *self.held);
        if y == self.band.rows[0].saturating_sub(REACH) {
            held.swept.clear();
        }
        let own = self.band.owns(y);
        let span = site.span(y);
        let (height, filled) = (&site.height[span.clone()], &site.filled[span.clone()]);
        let [water, load, wear, loose, ..] = self.band.row(y);
        if self.consts.rains {
            let came = rain(self.consts.dt, &site.rain[span.clone()], water, &mut held.spare);
            if own {
                held.swept.rained.push(came);
            }
        }
        if let Some(rate) = site.evaporation.as_deref() {
            let gone = evaporate(self.consts.dt, [height, filled], &rate[span], water, &mut held.spare);
            if own {
                held.swept.evaporated.push(gone);
            }
        }
        let before = site.row_or(site.before.as_deref(), y, &held.none);
        let (given, state) = ([height, filled, before], [&*water, &*load, &*wear, &*loose]);
        let [depth, bed, surface, thick] =
            [&mut held.depth, &mut held.bed, &mut held.surface, &mut held.thick]
                .map(|lines| lines.row_mut(y));
        start(given, state, depth, bed, surface, thick);
    }

    /// The edges of a row: to the east in it, and those to the next row.
    #[inline(always)]
    fn drive(&mut self, y: usize) {
        let (c, site, held) = (&self.consts, self.site, &mut *self.held);
        let [_, _, _, _, before @ ..] = self.band.row(y);
        for (k, before) in before.into_iter().enumerate() {
            let next = if k == 0 { y } else { y + 1 };
            let [flow, deep, drop] =
                [&mut held.flow[k], &mut held.deep[k], &mut held.drop[k]].map(|lines| lines.row_mut(y));
            if next >= site.rows {
                flow.fill(0.0);
                drop.fill(0.0);
                continue;
            }
            let [a, b] = ends(k, site.cols);
            let (here, there) = (site.span(y), site.span(next));
            let ends = Ends {
                height: [&site.height[here.clone()][a.clone()], &site.height[there.clone()][b.clone()]],
                filled: [&site.filled[here][a.clone()], &site.filled[there][b.clone()]],
                bed: [&held.bed.row(y)[a.clone()], &held.bed.row(next)[b.clone()]],
                surface: [&held.surface.row(y)[a.clone()], &held.surface.row(next)[b.clone()]],
                depth: [&held.depth.row(y)[a.clone()], &held.depth.row(next)[b]],
            };
            let per = c.per_length[usize::from(k > 1)];
            drive(
                c,
                per,
                &before[a.clone()],
                &ends,
                &mut flow[a.clone()],
                &mut deep[a.clone()],
                &mut drop[a],
            );
        }
    }

    /// Squares of the flow vectors of a row.
    #[inline(always)]
    fn square(&mut self, y: usize) {
        let held = &mut *self.held;
        let around = around(&held.flow, &held.none, y);
        square(around.own, around.above, held.square.row_mut(y));
        if self.site.open {
            border::square(&mut held.square, y, [self.site.cols, self.site.rows]);
        }
    }

    /// Friction on the edges of a row.
    #[inline(always)]
    fn slow(&mut self, y: usize) {
        let (site, held) = (self.site, &mut *self.held);
        for k in 0..4 {
            let next = if k == 0 { y } else { y + 1 };
            if next < site.rows {
                let [a, b] = ends(k, site.cols);
                let squares = [&held.square.row(y)[a.clone()], &held.square.row(next)[b]];
                slow(&self.consts, squares, &held.deep[k].row(y)[a.clone()], &mut held.flow[k].row_mut(y)[a]);
            }
        }
        if site.open {
            border::flow(&mut held.flow, y, [site.cols, site.rows]);
        }
    }

    /// What the cells of a row can give.
    #[inline(always)]
    fn limit(&mut self, y: usize) {
        let held = &mut *self.held;
        let around = around(&held.flow, &held.none, y);
        limit(&self.consts, around.own, around.above, held.depth.row(y), held.can.row_mut(y));
    }

    /// What crosses the edges of a row.
    #[inline(always)]
    fn share(&mut self, y: usize) {
        let (site, held) = (self.site, &mut *self.held);
        for k in 0..4 {
            let next = if k == 0 { y } else { y + 1 };
            if next >= site.rows {
                held.load[k].row_mut(y).fill(0.0);
                held.deep[k].row_mut(y).fill(0.0);
                continue;
            }
            let [a, b] = ends(k, site.cols);
            let cells = [
                [&held.can.row(y)[a.clone()], &held.can.row(next)[b.clone()]],
                [&held.thick.row(y)[a.clone()], &held.thick.row(next)[b.clone()]],
                [&held.depth.row(y)[a.clone()], &held.depth.row(next)[b]],
            ];
            share(
                cells,
                &mut held.flow[k].row_mut(y)[a.clone()],
                &mut held.load[k].row_mut(y)[a.clone()],
                &mut held.drop[k].row_mut(y)[a.clone()],
                &mut held.deep[k].row_mut(y)[a],
            );
        }
    }

    /// The new state of a row.
    #[inline(always)]
    fn finish<const SEA: bool, const HARD: bool>(&mut self, y: usize) {
        let (site, held) = (self.site, &mut *self.held);
        let span = site.span(y);
        let given = Given {
            height: &site.height[span.clone()],
            filled: &site.filled[span],
            before: site.row_or(site.before.as_deref(), y, &held.none),
            soft: site.row_or(site.soft.as_deref(), y, &held.one),
            mask: site.row_or(site.mask.as_deref(), y, &held.one),
        };
        let edges = Edges {
            flow: around(&held.flow, &held.none, y),
            load: around(&held.load, &held.none, y),
            power: around(&held.drop, &held.none, y),
            fall: around(&held.deep, &held.none, y),
        };
        let [water, load, wear, loose, flows @ ..] = self.band.row(y);
        exchange::<SEA, HARD>(&self.consts, given, edges, water, load, wear, loose);
        for (row, flow) in flows.into_iter().zip(&held.flow) {
            row.copy_from_slice(flow.row(y));
        }
        if SEA {
            let taken = drown(&self.consts, given, [wear, loose], water, &mut held.spare);
            held.swept.sea.push(taken);
        }
    }
}

/// Columns of the first and of the second cells of the edges of a row, of those to the east, south, south-east, south-west.
#[inline(always)]
fn ends(k: usize, cols: usize) -> [std::ops::Range<usize>; 2] {
    let less = cols.saturating_sub(1);
    match k {
        1 => [0..cols, 0..cols],
        3 => [cols - less..cols, 0..less],
        _ => [0..less, cols - less..cols],
    }
}

/// A quantity on the edges around the cells of a row.
#[inline(always)]
fn around<'a>(lines: &'a [Lines; 4], none: &'a [f32], y: usize) -> Around<'a> {
    let [e, s, d, u] = lines;
    let own = [e.wide(y), s.wide(y), d.wide(y), u.wide(y)];
    let above = match y.checked_sub(1) {
        Some(above) => [none, s.wide(above), d.wide(above), u.wide(above)],
        None => [none; 4],
    };
    Around { own, above }
}
