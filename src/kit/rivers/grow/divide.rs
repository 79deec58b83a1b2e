//! Links become the pieces of their generators, where they lie.

use super::sprout::Sprout;
use super::{Map, Role};
use crate::kit::predicates::Point;
use crate::kit::rivers::gap::{Room, is_clear};

/// How far the points that divide a link move, against what they would: less where there is no room.
const MOVES: [f64; 3] = [1.0, 0.5, 0.0];
/// How near a moved piece may come to others, in shares of the clearance of a branch.
const PIECE: f64 = 0.27;

impl Map<'_> {
    /// Divides a link and collects the branches that its generator adds.
    pub(super) fn divide(&mut self, link: u32, step: u32, sprouts: &mut Vec<Sprout>) {
        let i = link as usize;
        let (line, Some(down)) = (self.line[i], self.grown.down[i]) else { return };
        let role = self.role[i];
        let growth = self.growth;
        let (side_branches, age) = match role {
            Role::Outlet => return,
            Role::Exterior => (self.chance.whole(growth.branching.exterior()).max(1) - 1, 0),
            Role::Interior(_) if self.chance.unit() < growth.lengthen => (0, 1),
            Role::Interior(age) => (self.chance.whole(growth.branching.interior(age)), age),
        };
        if role == Role::Exterior {
            self.extend(link, down, step);
        }
        let direction = self.direction(i);
        let joints = self.divided(link, down, side_branches, step);
        let mut side = self.chance.sign();
        let mut below = down;
        for joint in joints {
            let vertex = self.add(joint, Some(below), Role::Interior(age + 1), line);
            self.grid.put(vertex, [joint, self.grown.at[below as usize]]);
            let angle = direction + side * 2.0 * growth.angle;
            sprouts.push(Sprout { foot: vertex, angle, line, is_stem: false });
            (side, below) = (-side, vertex);
        }
        self.grown.down[i] = Some(below);
        self.grid.put(link, [self.grown.at[i], self.grown.at[below as usize]]);
        self.role[i] = Role::Interior(age + 1);
        if role == Role::Exterior {
            self.fork(link, step, sprouts);
        }
    }

    /// The two branches at the end of what was an exterior link. One of them goes on as the tip of a stem.
    fn fork(&mut self, link: u32, step: u32, sprouts: &mut Vec<Sprout>) {
        let line = self.line[link as usize];
        let stem = self.stems[line as usize];
        let is_stem = stem.tip == link;
        let direction = if is_stem { stem.heading(step - 1) } else { self.direction(link as usize) };
        let side = if is_stem { stem.side(step) } else { 1.0 };
        for (side, is_stem) in [(side, is_stem), (-side, false)] {
            sprouts.push(Sprout { foot: link, angle: direction + side * self.growth.angle, line, is_stem });
        }
    }

    /// The direction of a link up the river, in radians.
    fn direction(&self, link: usize) -> f64 {
        let Some([to, from]) = self.segment(link) else { return 0.0 };
        libm::atan2(to[1] - from[1], to[0] - from[0])
    }

    /// Draws an exterior link out to the length of all its pieces, or halfway, where there is room.
    fn extend(&mut self, link: u32, down: u32, step: u32) {
        let i = link as usize;
        let [from, tip] = [self.grown.at[down as usize], self.grown.at[i]];
        let now = libm::hypot(tip[0] - from[0], tip[1] - from[1]);
        let stem = self.stems[self.line[i] as usize];
        let (wanted, length) = (stem.divided_length(self.growth, step), stem.length(step));
        let keep = self.growth.clearance * length;
        let is_stem = stem.tip == link;
        for longer in [wanted, (wanted + now) / 2.0] {
            // A link of just that length needs no room.
            if longer <= now * (1.0 + 1e-9) || now <= 0.0 {
                return;
            }
            let end = [0, 1].map(|k| from[k] + (tip[k] - from[k]) * (longer / now));
            let others = self.segments_near(&[tip, end], keep, |map, other| map.is_at(other, link));
            let margin = if is_stem { 0.0 } else { 0.5 * length };
            if self.is_inside(end, margin) && Room::just(keep).of(tip, end, &others).is_some() {
                self.grown.at[i] = end;
                self.grid.put(link, [end, from]);
                return;
            }
        }
    }

    /// The points that divide a link evenly, from its lower end up, moved sideways as far as there is room.
    fn divided(&mut self, link: u32, down: u32, count: u32, step: u32) -> Vec<Point> {
        let [from, to] = [self.grown.at[down as usize], self.grown.at[link as usize]];
        let pieces = f64::from(count + 1);
        let along = [0, 1].map(|k| (to[k] - from[k]) / pieces);
        let moves: Vec<f64> = (0..count).map(|_| self.chance.bell().clamp(-2.0, 2.0)).collect();
        if count == 0 {
            return Vec::new();
        }
        let joints = |scale: f64| -> Vec<Point> {
            let joint = |(k, aside): (usize, &f64)| {
                let (k, aside) = (k as f64 + 1.0, aside * scale);
                [from[0] + k * along[0] - aside * along[1], from[1] + k * along[1] + aside * along[0]]
            };
            moves.iter().enumerate().map(joint).collect()
        };
        let stem = self.stems[self.line[link as usize] as usize];
        let keep = PIECE * self.growth.clearance * stem.length(step);
        for scale in MOVES.map(|scale| scale * self.growth.wander) {
            let moved = joints(scale);
            // Unmoved points lie on the link, which is clear.
            if scale == 0.0 || self.is_way_clear(link, down, &moved, keep) {
                return moved;
            }
        }
        joints(0.0)
    }

    /// Whether a way along a link keeps a distance from others. Links that join it at an end may be near there.
    fn is_way_clear(&mut self, link: u32, down: u32, joints: &[Point], keep: f64) -> bool {
        let [from, to] = [self.grown.at[down as usize], self.grown.at[link as usize]];
        let way: Vec<Point> = std::iter::once(from).chain(joints.iter().copied()).chain([to]).collect();
        let last = way.len() - 2;
        (0..=last).all(|k| {
            let piece = [way[k], way[k + 1]];
            let is_joined = |map: &Self, other: u32| {
                other == link || k == 0 && map.is_at(other, down) || k == last && map.is_at(other, link)
            };
            let others = self.segments_near(&piece, keep, is_joined);
            is_clear(piece, &others, keep)
        })
    }
}
