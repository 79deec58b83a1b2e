//! Rays against the height field.
//!
//! A pyramid of maxima lets a ray leap over whatever lies below it \[tevs2008\]; where it comes down to one cell it
//! is cut with the bilinear patch between the four samples in closed form, so that what is seen, outlines included,
//! is exactly that surface.

use super::plane::Plane;
use crate::node::Result;
use crate::work::Work;

/// A half line. Origin and direction in metres: east, south, up from the north-west sample; the direction has length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) origin: [f64; 3],
    pub(super) direction: [f64; 3],
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.origin[k] + t * self.direction[k])
    }
}

/// Where a ray meets the surface: the distance, and the place in steps from the north-west sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    pub(super) t: f64,
    pub(super) u: f64,
    pub(super) v: f64,
}

/// Heights with their pyramid of maxima.
pub(super) struct Tracer<'a> {
    z: &'a Plane<f32>,
    cell: f64,
    /// Maxima of single cells, of 2 x 2 of them, and so on to one.
    levels: Vec<Plane<f32>>,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(z: &'a Plane<f32>, cell: f64, work: &Work<'_>) -> Result<Self> {
        let mut levels = vec![Plane::fill(work, [z.cols - 1, z.rows - 1], |j, out: &mut [f32]| {
            let (top, bottom) = (z.row(j), z.row(j + 1));
            for (i, out) in out.iter_mut().enumerate() {
                *out = top[i].max(top[i + 1]).max(bottom[i]).max(bottom[i + 1]);
            }
        })?];
        while let Some(fine) = levels.last().filter(|l| l.cols > 1 || l.rows > 1) {
            let size = [fine.cols.div_ceil(2), fine.rows.div_ceil(2)];
            let coarse = Plane::fill(work, size, |j, out: &mut [f32]| {
                let rows = [fine.row(2 * j), fine.row((2 * j + 1).min(fine.rows - 1))];
                for (i, out) in out.iter_mut().enumerate() {
                    let (a, b) = (2 * i, (2 * i + 1).min(fine.cols - 1));
                    *out = rows[0][a].max(rows[0][b]).max(rows[1][a]).max(rows[1][b]);
                }
            })?;
            levels.push(coarse);
        }
        Ok(Self { z, cell, levels })
    }

    /// The highest of all samples.
    pub(super) fn highest(&self) -> f64 {
        self.levels.last().map_or(0.0, |level| f64::from(level.data[0]))
    }

    /// The height between samples, in steps from the north-west one; the border continues.
    pub(super) fn height(&self, u: f64, v: f64) -> f64 {
        f64::from(self.z.at(u, v))
    }

    /// The part of a ray over the field, from `start` on: where it enters and leaves the rectangle.
    pub(super) fn over(&self, ray: &Ray, start: f64) -> Option<[f64; 2]> {
        let (mut enter, mut leave) = (start, f64::INFINITY);
        for (k, count) in [self.z.cols, self.z.rows].into_iter().enumerate() {
            let (o, d, far) = (ray.origin[k], ray.direction[k], (count - 1) as f64 * self.cell);
            if d.abs() < 1e-12 {
                if !(0.0..=far).contains(&o) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-o / d, (far - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter < leave).then_some([enter, leave])
    }

    /// Where a ray first meets the surface from above, from `start` on; a ray that comes in below the surface
    /// meets it where it comes in.
    pub(super) fn hit(&self, ray: &Ray, start: f64) -> Option<Hit> {
        let [mut enter, mut leave] = self.over(ray, start)?;
        let (o, d) = (ray.origin[2], ray.direction[2]);
        let top = self.highest();
        if d < 0.0 {
            enter = enter.max((top - o) / d);
        } else if d > 0.0 {
            leave = leave.min((top - o) / d);
        } else if o > top {
            return None;
        }
        (enter <= leave).then(|| Walk::new(self, ray, enter, leave).run()).flatten()
    }
}

/// A ray on its way through the cells.
struct Walk<'a> {
    tracer: &'a Tracer<'a>,
    origin: [f64; 3],
    /// Steps per metre along the columns and rows, metres per metre upwards.
    slope: [f64; 3],
    /// The cell it is in, on the finest level.
    cell: [i64; 2],
    t: f64,
    end: f64,
}

impl<'a> Walk<'a> {
    fn new(tracer: &'a Tracer<'a>, ray: &Ray, start: f64, end: f64) -> Self {
        let per = 1.0 / tracer.cell;
        let origin = [ray.origin[0] * per, ray.origin[1] * per, ray.origin[2]];
        let slope = [ray.direction[0] * per, ray.direction[1] * per, ray.direction[2]];
        let last = [tracer.z.cols as i64 - 2, tracer.z.rows as i64 - 2];
        let cell = [0, 1].map(|k: usize| ((origin[k] + start * slope[k]).floor() as i64).clamp(0, last[k]));
        Self { tracer, origin, slope, cell, t: start, end }
    }

    fn run(mut self) -> Option<Hit> {
        let levels = &self.tracer.levels;
        let mut level = levels.len() - 1;
        loop {
            let block = self.cell.map(|c| c >> level);
            let (exit, axis) = self.exit(block, level);
            let low = (self.origin[2] + self.t * self.slope[2]).min(self.origin[2] + exit * self.slope[2]);
            let plane = &levels[level];
            if low <= f64::from(plane.row(block[1] as usize)[block[0] as usize]) {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                if let Some(hit) = self.patch(exit) {
                    return Some(hit);
                }
            }
            if exit >= self.end || !self.step(block, level, exit, axis) {
                return None;
            }
            level = (level + 1).min(levels.len() - 1);
        }
    }

    /// Where the ray leaves a block, and through which pair of sides.
    fn exit(&self, block: [i64; 2], level: usize) -> (f64, usize) {
        let side = |k: usize| {
            if self.slope[k] == 0.0 {
                return f64::INFINITY;
            }
            let line = (block[k] + i64::from(self.slope[k] > 0.0)) << level;
            (line as f64 - self.origin[k]) / self.slope[k]
        };
        let (u, v) = (side(0), side(1));
        let (exit, axis) = if u <= v { (u, 0) } else { (v, 1) };
        (exit.clamp(self.t, self.end.max(self.t)), axis)
    }

    /// Moves on to the next block; false when that is outside.
    fn step(&mut self, block: [i64; 2], level: usize, exit: f64, axis: usize) -> bool {
        let other = 1 - axis;
        let count = [self.tracer.z.cols as i64 - 1, self.tracer.z.rows as i64 - 1];
        self.cell[axis] =
            if self.slope[axis] > 0.0 { (block[axis] + 1) << level } else { (block[axis] << level) - 1 };
        let place = (self.origin[other] + exit * self.slope[other]).floor() as i64;
        let (low, high) = (block[other] << level, ((block[other] + 1) << level) - 1);
        // Rounding must not lead back: the walk would never end.
        let (low, high) = match self.slope[other] > 0.0 {
            true => (self.cell[other].max(low), high),
            false => (low, self.cell[other].min(high)),
        };
        self.cell[other] = place.clamp(low, high.min(count[other] - 1).max(low));
        self.t = exit;
        (0..count[axis]).contains(&self.cell[axis])
    }

    /// Cuts the ray with the bilinear patch of the cell it is in.
    fn patch(&self, exit: f64) -> Option<Hit> {
        let z = self.tracer.z;
        let [i, j] = self.cell.map(|c| c as usize);
        let (top, bottom) = (z.row(j), z.row(j + 1));
        let corner = [top[i], top[i + 1], bottom[i], bottom[i + 1]].map(f64::from);
        let (across, down) = (corner[1] - corner[0], corner[2] - corner[0]);
        let twist = corner[3] - corner[2] - across;
        let x = self.origin[0] + self.t * self.slope[0] - i as f64;
        let y = self.origin[1] + self.t * self.slope[1] - j as f64;
        let [du, dv, dz] = self.slope;
        // The height of the ray over the patch is c + b s + a s² after a way s.
        let c = self.origin[2] + self.t * dz - (corner[0] + across * x + down * y + twist * x * y);
        let s = if c <= 0.0 {
            0.0
        } else {
            let b = dz - (across * du + down * dv + twist * (x * dv + y * du));
            first_root(-twist * du * dv, b, c).filter(|&s| s <= exit - self.t)?
        };
        let t = self.t + s;
        Some(Hit { t, u: self.origin[0] + t * du, v: self.origin[1] + t * dv })
    }
}

/// The smallest positive root of `a s² + b s + c` with `c` positive.
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let inside = b * b - 4.0 * a * c;
    if inside < 0.0 {
        return None;
    }
    // The stable form: the sum has no cancellation.
    let q = -0.5 * (b + inside.sqrt().copysign(b));
    let roots = [q / a, c / q];
    roots.into_iter().filter(|s| s.is_finite() && *s >= 0.0).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Cancel;
    use crate::kit::hash::unit;

    #[test]
    fn rays_meet_what_small_steps_meet() {
        let cancel = Cancel::default();
        let data = (0..37 * 29).map(|i| (unit(5, i) * 60.0) as f32).collect();
        let z = Plane { cols: 37, rows: 29, data };
        let tracer = Tracer::new(&z, 10.0, &Work::new(&cancel)).unwrap();
        let mut hits = 0;
        for n in 0..400u64 {
            let random = |k| unit(9, n * 8 + k);
            let origin = [random(0) * 360.0, random(1) * 280.0, 61.0 + random(2) * 30.0];
            let way = [random(3) - 0.5, random(4) - 0.5, -0.05 - 0.4 * random(5)];
            let length = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
            let ray = Ray { origin, direction: way.map(|x| x / length) };
            let marched = (0..200_000).map(|k| f64::from(k) * 0.01).find(|&t| {
                let [x, y, height] = ray.at(t);
                let inside = (0.0..=360.0).contains(&x) && (0.0..=280.0).contains(&y);
                inside && height <= tracer.height(x / 10.0, y / 10.0)
            });
            match (marched, tracer.hit(&ray, 0.0)) {
                (Some(want), Some(hit)) => {
                    assert!((hit.t - want).abs() < 0.02, "ray {n}: {hit:?}, not {want}");
                    hits += 1;
                }
                (None, None) => (),
                other => panic!("ray {n}: {other:?}"),
            }
        }
        assert!(hits > 250, "{hits}");
    }

    #[test]
    fn rays_from_outside_and_along_the_axes() {
        let cancel = Cancel::default();
        let z = Plane { cols: 3, rows: 3, data: vec![0.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 0.0] };
        let tracer = Tracer::new(&z, 1.0, &Work::new(&cancel)).unwrap();
        let hit = |origin, direction| tracer.hit(&Ray { origin, direction }, 0.0);
        let east = hit([-5.0, 1.0, 4.0], [1.0, 0.0, 0.0]).unwrap();
        assert!((east.u - 0.5).abs() < 1e-9 && (east.t - 5.5).abs() < 1e-9, "{east:?}");
        let down = hit([1.0, 1.0, 20.0], [0.0, 0.0, -1.0]).unwrap();
        assert!((down.t - 12.0).abs() < 1e-9, "{down:?}");
        assert_eq!(hit([-5.0, 1.0, 8.1], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([1.0, 1.0, 9.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(hit([-5.0, 9.0, 4.0], [1.0, 0.0, 0.0]), None);
    }
}
