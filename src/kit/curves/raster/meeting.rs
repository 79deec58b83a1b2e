//! Where slopes of several curves meet: one ground between those that each of them gives.
//!
//! # Theory
//! Gradients of several curves do not add up to the gradient of a ground: on a way round the place where they meet one
//! does not come back to the height where one began, and land that follows them piles up to horns. Heights do not have
//! this fault. At distance `d` from a curve of height `h` the ground is `P = h + rise(d)`, and where the slopes of several
//! curves hold a cell, it is the mean
//! ```text
//! P = Σ w P / Σ w,   w = e (1 / x − 1 / a)²
//! ```
//! with `x` the distance from the plateau and `a` the extent of the slope. `e` goes from 1 to 0 over the last part of the
//! curve, a part as long as `x`, as trust does. So on each plateau its own height holds, a curve has no weight left at
//! the outer side of its slope and beside its ends, and `P` is never above the highest nor below the lowest.
//!
//! Where one curve has nearly all of the weight, the land follows its gradient, as beside a single curve: the height
//! may have been changed on the way. As its share of the weight falls from 1 to 3/4, the land goes over from following
//! the mean of the gradients to following `P`; less so where trust is low, since there a curve alone does not raise or dig
//! the whole of its slope either.
//!
//! # Limits
//! Curves without elevation do not know how high their ground is. Where the slope of one of them takes part there is no
//! `P`: the cell is left open, as in the paper, for the gradient that diffusion finds. Cracks that cross dig deeper there
//! than each of them alone.

use super::SLACK;
use super::cell::Nearest;
use super::ribbon::{Part, Ribbon};
use super::shape::Spot;
use crate::value::curves::bezier::{Point, add, dot, norm, sub, times};

/// Least share of what a weight is half way out, so that there is always one.
const FAINT: f64 = 1e-3;
/// Nearest to a plateau that weights tell apart, in cells.
const TOUCHING: f64 = 1e-3;
/// How much faster than the strongest curve loses weight the land goes over to following heights.
const CONTEST: f64 = 4.0;
/// Directions that cancel to less than this say nothing.
const LEVEL: f64 = 1e-3;

/// What slopes say about a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Said {
    /// Direction and steepness along it; none where directions cancel.
    pub(super) gradient: Option<([f32; 2], f32)>,
    /// How far the gradient is followed.
    pub(super) trust: f32,
    /// How high the ground is, and how far that is followed; none where the gradient alone is.
    pub(super) ground: Option<(f64, f32)>,
}

/// The slopes that hold a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Meeting {
    count: u32,
    /// The numbers of the first curve and of its part that is nearest.
    first: (u32, u32),
    /// What the first says alone.
    alone: Said,
    /// Sums over all, where there are several.
    sum: Sum,
}

/// Sums over slopes that meet, with their weights.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    weight: f64,
    height: f64,
    rise: Point,
    away: Point,
    trust: f64,
    /// The most that one is trusted.
    trusted: f64,
    /// The largest weight, and whether that slope begins across its curve.
    most: f64,
    across: bool,
    /// Whether one has no height.
    floats: bool,
}

/// The curves of a scene, and a cell of it.
#[derive(Clone, Copy)]
pub(super) struct Place<'a, F: Fn(u32) -> &'a Ribbon> {
    pub(super) ribbon: F,
    /// Where the cell stands.
    pub(super) at: Point,
    /// A cell, in metres.
    pub(super) cell: f64,
}

impl<'a, F: Fn(u32) -> &'a Ribbon> Place<'a, F> {
    /// The slope of a part of a curve at the cell.
    fn slope(&self, (curve, part): (u32, u32)) -> Option<Slope<'a>> {
        let ribbon = (self.ribbon)(curve);
        let part = ribbon.parts.get(part as usize)?;
        let spot = part.shape.locate(sub(self.at, part.shape.from))?;
        Some(Slope { ribbon, part, spot, cell: self.cell })
    }
}

impl Meeting {
    /// Whether no slope holds the cell.
    pub(super) fn is_new(&self) -> bool {
        self.count == 0
    }

    /// Takes up the slope of one more curve.
    pub(super) fn join<'a, F: Fn(u32) -> &'a Ribbon>(
        &mut self,
        curve: u32,
        nearest: &Nearest,
        place: &Place<'a, F>,
    ) {
        let this = (curve, nearest.part);
        self.count += 1;
        if self.count == 1 {
            self.first = this;
            self.alone = alone(nearest, || place.slope(this).filter(Slope::begins_across), place.cell);
            return;
        }
        let first = Some(self.first).filter(|_| self.count == 2);
        let slopes = first.into_iter().chain([this]).filter_map(|numbers| place.slope(numbers));
        slopes.for_each(|slope| self.sum.add(&slope));
    }

    /// What the slopes say together; none is left.
    pub(super) fn finish(&mut self) -> Said {
        let Self { count, alone, sum, .. } = std::mem::take(self);
        if count == 1 { alone } else { sum.said() }
    }
}

/// What one slope says alone: its gradient, or right beside a curve whose slope begins across it its height.
fn alone<'a>(nearest: &Nearest, across: impl Fn() -> Option<Slope<'a>>, cell: f64) -> Said {
    let Some((direction, steepness, trust)) = nearest.mean() else {
        // What diffusion says there is followed all the way.
        return Said { trust: 1.0, ..Said::default() };
    };
    let gradient = Some((direction, steepness));
    match Some(nearest.distance < cell).filter(|&close| close).and_then(|_| across()) {
        Some(slope) => Said { gradient, trust: 0.0, ground: Some((slope.height(), trust)) },
        None => Said { gradient, trust, ground: None },
    }
}

/// The slope of a curve at a cell.
#[derive(Clone, Copy, Debug)]
struct Slope<'a> {
    ribbon: &'a Ribbon,
    part: &'a Part,
    spot: Spot,
    /// A cell, in metres.
    cell: f64,
}

impl Slope<'_> {
    /// How much it counts, per square metre.
    fn weight(&self) -> f64 {
        let Self { ribbon, part, spot, cell } = self;
        let extent = part.extent[spot.side].at(spot.share).max(*cell);
        let x = (spot.distance - part.radius.at(spot.share)).max(TOUCHING * cell);
        let arc = part.arc + spot.share * part.shape.length;
        let end = arc.min(ribbon.length - arc).max(0.0);
        let across = (1.0 / x - 1.0 / extent).max(FAINT / extent);
        smooth(end / x).max(FAINT * FAINT) * across * across
    }

    /// How high the ground is.
    fn height(&self) -> f64 {
        self.part.ground(self.spot.side, self.spot.share, self.spot.distance)
    }

    /// Whether the step to the cell from its neighbours on the side of the curve begins across the curve, on free ground.
    /// That does not know the height of the curve, so that the gradient says nothing there.
    fn begins_across(&self) -> bool {
        let Self { ribbon, part, spot, cell } = self;
        let step = cell * spot.away[0].abs().max(spot.away[1].abs());
        let free = ribbon.has_edge && part.extent[1 - spot.side].at(spot.share) <= SLACK * cell;
        free && spot.distance < step && part.radius.at(spot.share) < step
    }
}

impl Sum {
    fn add(&mut self, slope: &Slope<'_>) {
        let Slope { ribbon, part, spot, .. } = slope;
        let weight = slope.weight();
        if weight > self.most {
            (self.most, self.across) = (weight, slope.begins_across());
        }
        self.weight += weight;
        self.height += weight * slope.height();
        self.rise = add(self.rise, times(spot.away, weight * part.steepness(spot, true)));
        self.away = add(self.away, times(spot.away, weight));
        let trust = part.trust(spot, ribbon);
        self.trust += weight * trust;
        self.trusted = self.trusted.max(trust);
        self.floats |= !ribbon.has_height;
    }

    /// The mean of the gradients, as far as one curve rules, and of the heights, as far as none does.
    fn said(&self) -> Said {
        if self.floats || self.weight <= 0.0 {
            return Said { trust: self.trusted as f32, ..Said::default() };
        }
        let over = 1.0 / self.weight;
        let most = self.most * over;
        let across = self.across && most > 0.5;
        let trust = self.trust * over;
        let open = if across { 1.0 } else { trust * (CONTEST * (1.0 - most)).min(1.0) };
        let length = norm(self.away);
        let gradient = (length > LEVEL * self.weight).then(|| {
            let away = times(self.away, 1.0 / length);
            (away.map(|x| x as f32), (dot(self.rise, away) * over) as f32)
        });
        let ground = Some((self.height * over, (trust * open) as f32));
        Said { gradient, trust: (trust * (1.0 - open)) as f32, ground }
    }
}

/// From 0 to 1, level at both.
fn smooth(t: f64) -> f64 {
    if t >= 1.0 { 1.0 } else { t * t * (3.0 - 2.0 * t) }
}
