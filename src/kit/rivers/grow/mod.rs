//! Networks that grow on a map from lines, generation by generation, without crossings \[zhang2016, section IV\].
//!
//! A line from an estuary to a place inland becomes a network of depth `length / longer side · max_depth`, equation (3),
//! rounded and at least 1. Its first link is exterior. In each step exterior links, and then interior ones, are divided
//! into the pieces of their generators where they lie, the new points moved sideways. Then the branches of the step
//! sprout: two at the end of what was an exterior link, at the branch angle to either side, the others at twice that
//! angle, on alternating sides.
//!
//! # Differs from the paper
//! Drawn by the rules alone a network crosses itself: 308 times, and 486 times a node stands on another, with φ 2 and
//! depth 7. Here a branch tries its own angle, then up to 45° to either side, then lengths down to 55 %, and takes what is
//! clear of all other links; a branch without any such place is left out. A main stem alternates its sides, and its lengths
//! are scaled, so that it ends where the line does if nothing is in its way.

mod divide;
mod near;
mod sprout;
mod stem;

use super::branching::Branching;
use super::chance::Chance;
use super::link_grid::LinkGrid;
use crate::kit::hash::{mix, nth};
use crate::kit::predicates::{Point, segments_touch};
use crate::value::{Bounds, RiverFault, RiverVertex, Rivers};
use crate::work::{Cancelled, Work};
use sprout::Sprout;
use stem::Stem;

/// A line that a network grows along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The estuary.
    pub from: Point,
    /// The place inland.
    pub to: Point,
}

impl Line {
    /// Its length, in metres.
    pub fn length(&self) -> f64 {
        libm::hypot(self.to[0] - self.from[0], self.to[1] - self.from[1])
    }

    /// The depth of its network, equation (3): its share of the longer side of the terrain times the greatest depth.
    pub fn depth(&self, bounds: Bounds, max_depth: u32) -> u32 {
        let share = self.length() / bounds.width().max(bounds.depth());
        (libm::round(share * f64::from(max_depth)) as u32).max(1)
    }
}

/// How networks grow.
#[derive(Clone, Copy)]
pub struct Growth<'a> {
    /// The terrain. Networks stay inside.
    pub bounds: Bounds,
    /// How links branch.
    pub branching: Branching,
    /// Depth of a network as long as the longer side of the terrain.
    pub max_depth: u32,
    /// Angle θ of the branches at the end of a link, in radians; others have twice that.
    pub angle: f64,
    /// Share of interior links that are lengthened (rule FF) instead of branching.
    pub lengthen: f64,
    /// How far the points that divide a link move sideways, in shares of the pieces.
    pub wander: f64,
    /// How far links keep from others, in shares of the link length of their step.
    pub clearance: f64,
    /// Draws what is left to chance.
    pub seed: u64,
    /// Where rivers may run.
    pub is_land: &'a (dyn Fn(Point) -> bool + Sync),
}

/// Networks on a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grown {
    /// Places of the vertices.
    pub at: Vec<Point>,
    /// The vertex downstream of each, in no order.
    pub down: Vec<Option<u32>>,
    /// Branches that the rules ask for.
    pub asked: usize,
    /// Branches that found no place.
    pub left_out: usize,
    /// Lines whose first link would cross that of an earlier line, by number.
    pub crossing: Vec<usize>,
}

impl Growth<'_> {
    /// The mean number of links that lines ask for.
    pub fn links(&self, lines: &[Line]) -> f64 {
        let of = |line: &Line| self.branching.links(line.depth(self.bounds, self.max_depth), self.lengthen);
        lines.iter().map(of).sum()
    }

    /// Grows a network along each line.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn grow(&self, lines: &[Line], work: &Work<'_>) -> Result<Grown, Cancelled> {
        let mut map = Map::new(self, lines);
        let depth = map.stems.iter().map(|stem| stem.depth).max().unwrap_or(1);
        // A step has so many times more links than the one before, and takes as much longer.
        let ratio = self.branching.bifurcation();
        let share = |step: u32| (step..depth).fold(1.0, |share, _| share / ratio) as f32;
        for step in 2..=depth {
            map.step(step, &work.stage(share(step - 1), share(step)))?;
        }
        Ok(map.grown)
    }
}

impl Grown {
    /// The vertices downstream first, river after river. Heights, areas and widths are open.
    ///
    /// # Errors
    /// When they are no network, which is a bug.
    pub fn vertices(&self) -> Result<Vec<RiverVertex>, RiverFault> {
        let vertex =
            |(&at, &down): (&Point, &Option<u32>)| RiverVertex { at, down, ..RiverVertex::default() };
        let vertices: Vec<RiverVertex> = self.at.iter().zip(&self.down).map(vertex).collect();
        Ok(Rivers::sorted(&vertices)?.0.vertices().to_vec())
    }
}

/// What a link is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    /// The vertex is an outlet and has none.
    Outlet,
    /// It starts at a source.
    Exterior,
    /// It has been interior for so many steps, its own the first.
    Interior(u32),
}

/// Networks while they grow. A link has the number of its upper vertex.
struct Map<'a> {
    growth: &'a Growth<'a>,
    grown: Grown,
    role: Vec<Role>,
    /// The line of each link.
    line: Vec<u32>,
    stems: Vec<Stem>,
    grid: LinkGrid,
    chance: Chance,
    /// Links near the place that is looked at.
    near: Vec<u32>,
}

impl<'a> Map<'a> {
    /// The first links of all lines.
    fn new(growth: &'a Growth<'a>, lines: &[Line]) -> Self {
        let mut map = Self {
            growth,
            grown: Grown::default(),
            role: Vec::new(),
            line: Vec::new(),
            stems: Vec::new(),
            grid: LinkGrid::new(growth.bounds, f64::INFINITY, 0),
            chance: Chance::new(mix(growth.seed)),
            near: Vec::new(),
        };
        for (number, line) in lines.iter().enumerate() {
            let side = if nth(growth.seed, number as u64) & 1 == 0 { 1.0 } else { -1.0 };
            let depth = line.depth(growth.bounds, growth.max_depth);
            let stems = [side, -side].map(|side| Stem::new(growth, line, depth, side));
            let free = stems.into_iter().find(|stem| map.is_first_free(line.from, stem));
            if free.is_none() {
                map.grown.crossing.push(number);
            }
            // A line without room keeps its number, and no link.
            let mut stem = free.unwrap_or(stems[0]);
            if free.is_none() {
                stem.depth = 0;
            } else {
                let outlet = map.add(line.from, None, Role::Outlet, number as u32);
                stem.tip = map.add(stem.first_end, Some(outlet), Role::Exterior, number as u32);
            }
            map.stems.push(stem);
        }
        map
    }

    /// Whether the first link of a stem touches no other.
    fn is_first_free(&self, from: Point, stem: &Stem) -> bool {
        let own = [from, stem.first_end];
        let touches = |link: usize| self.segment(link).is_some_and(|other| segments_touch(own, other));
        !(0..self.role.len()).any(touches)
    }

    fn add(&mut self, at: Point, down: Option<u32>, role: Role, line: u32) -> u32 {
        self.grown.at.push(at);
        self.grown.down.push(down);
        self.role.push(role);
        self.line.push(line);
        self.role.len() as u32 - 1
    }

    /// The ends of a link, the upper one first.
    fn segment(&self, link: usize) -> Option<[Point; 2]> {
        self.grown.down[link].map(|down| [self.grown.at[link], self.grown.at[down as usize]])
    }

    /// Whether a place is inside the terrain, so far from its border, and on land.
    fn is_inside(&self, [x, y]: Point, margin: f64) -> bool {
        let Bounds { min, max } = self.growth.bounds;
        let fits = |v: f64, i: usize| v >= min[i] + margin && v <= max[i] - margin;
        fits(x, 0) && fits(y, 1) && (self.growth.is_land)([x, y])
    }

    /// Divides all links and lets the branches of a step sprout.
    fn step(&mut self, step: u32, work: &Work<'_>) -> Result<(), Cancelled> {
        let longest = self.stems.iter().filter(|stem| stem.depth >= step).map(|stem| stem.length(step));
        self.grid = LinkGrid::new(self.growth.bounds, longest.fold(0.0, f64::max), self.role.len());
        let links: Vec<u32> =
            (0..self.role.len() as u32).filter(|&i| self.role[i as usize] != Role::Outlet).collect();
        for &link in &links {
            if let Some(segment) = self.segment(link as usize) {
                self.grid.put(link, segment);
            }
        }
        let grows = |map: &Self, link: u32| map.stems[map.line[link as usize] as usize].depth >= step;
        let (exterior, interior): (Vec<u32>, Vec<u32>) = links
            .into_iter()
            .filter(|&link| grows(self, link))
            .partition(|&link| self.role[link as usize] == Role::Exterior);
        let mut sprouts = Vec::with_capacity(3 * exterior.len());
        let count = exterior.len() + interior.len();
        for (done, link) in exterior.into_iter().chain(interior).enumerate() {
            if done % 1024 == 0 {
                work.step(0.3 * done as f32 / count as f32)?;
            }
            self.divide(link, step, &mut sprouts);
        }
        // Stems first, so that little is in their way.
        let (stems, others): (Vec<Sprout>, Vec<Sprout>) =
            sprouts.into_iter().partition(|sprout| sprout.is_stem);
        let count = stems.len() + others.len();
        for (done, sprout) in stems.into_iter().chain(others).enumerate() {
            if done % 1024 == 0 {
                work.step(0.3 + 0.7 * done as f32 / count as f32)?;
            }
            self.sprout(sprout, step);
        }
        Ok(())
    }
}

/// The place at an angle and a distance from another.
fn beyond([x, y]: Point, angle: f64, distance: f64) -> Point {
    [x + distance * libm::cos(angle), y + distance * libm::sin(angle)]
}
