//! Horizons by sweeps: how high the terrain rises around each sample.
//!
//! A sweep runs along parallel lines through the field and keeps the upper convex hull of what lies towards the
//! light; the horizon of a sample is the tangent from it to the hull, found in constant time on average, so that a
//! sweep costs the same however long the shadows are \[timonen2010\].

use super::Sun;
use super::plane::{Plane, resampled};
use crate::node::Result;
use crate::work::Work;

/// Directions in which the sky is looked at.
const DIRECTIONS: usize = 16;
/// Largest side of the grid on which the sky's share is computed; it varies smoothly and is interpolated.
pub(super) const SKY_GRID: usize = 1280;
/// Radius of the sun in a shadow's penumbra, in degrees: about twice the real one.
const SUN_RADIUS: f64 = 0.55;

/// The share of the sun that each sample sees, 0 to 1.
pub(super) fn sun_share(z: &Plane<f32>, cell: f64, sun: Sun, work: &Work<'_>) -> Result<Plane<f32>> {
    let tangent = |degrees: f64| libm::tan(degrees.clamp(0.05, 89.9).to_radians()) as f32;
    let (low, high) = (tangent(sun.altitude - SUN_RADIUS), tangent(sun.altitude + SUN_RADIUS));
    let share = |horizon: f32| {
        let u = ((high - horizon) / (high - low)).clamp(0.0, 1.0);
        u * u * (3.0 - 2.0 * u)
    };
    let azimuth = sun.azimuth.to_radians();
    sweep(z, cell, [libm::sin(azimuth), -libm::cos(azimuth)], share, work)
}

/// What each sample sees of the sky, made ready for any normal.
pub(super) struct SkyView {
    /// The weight of the upward part of the normal, then of its east and south parts.
    parts: Plane<[f32; 3]>,
    /// Steps of this plane in one step of the surface.
    scale: [f64; 2],
}

impl SkyView {
    /// Looks around from every sample. Light from the side of `to_sun` weighs more, as the sky is brighter there.
    pub(super) fn new(z: &Plane<f32>, cell: f64, to_sun: [f64; 2], work: &Work<'_>) -> Result<Self> {
        let size = super::surface::working_grid([z.cols, z.rows], SKY_GRID);
        let coarse;
        let (plane, cell) = if size == [z.cols, z.rows] {
            (z, cell)
        } else {
            coarse = resampled(&work.stage(0.0, 0.1), &z.data, [z.cols, z.rows], size)?;
            (&coarse, cell * z.cols as f64 / size[0] as f64)
        };
        let mut sum = vec![[0.0f32; 3]; plane.data.len()];
        let weights = sector_weights(to_sun);
        for (n, (direction, weight)) in weights.into_iter().enumerate() {
            let at = |k: usize| 0.1 + 0.9 * k as f32 / DIRECTIONS as f32;
            let horizon = sweep(plane, cell, direction, |t| t, &work.stage(at(n), at(n + 1)))?;
            let [east, south] = direction.map(|x| x as f32);
            work.stage(at(n + 1), at(n + 1)).rows(&mut sum, plane.cols, 1, |j, row| {
                for (sum, &tangent) in row.iter_mut().zip(horizon.row(j)) {
                    let [upward, outward] = sector(tangent);
                    sum[0] += weight * upward;
                    sum[1] += weight * outward * east;
                    sum[2] += weight * outward * south;
                }
            })?;
        }
        let scale = [size[0] as f64 / z.cols as f64, size[1] as f64 / z.rows as f64];
        Ok(Self {
            parts: Plane { data: sum, ..Plane { cols: size[0], rows: size[1], data: Vec::new() } },
            scale,
        })
    }

    /// The light of the sky on a surface of this normal, and the share of the sky over level ground; both relative
    /// to open level ground.
    pub(super) fn light(&self, i: usize, j: usize, normal: [f32; 3]) -> [f32; 2] {
        let [up, east, south] = if self.scale == [1.0, 1.0] {
            self.parts.row(j)[i]
        } else {
            let place = |k: usize, scale: f64| (k as f64 + 0.5) * scale - 0.5;
            self.parts.at(place(i, self.scale[0]), place(j, self.scale[1]))
        };
        [(up * normal[2] + east * normal[0] + south * normal[1]).max(0.0), up.clamp(0.0, 1.0)]
    }
}

/// Directions with their weights, which sum to 1.
fn sector_weights(to_sun: [f64; 2]) -> [([f64; 2], f32); DIRECTIONS] {
    std::array::from_fn(|n| {
        // Off the axes, where lines run along samples and the smallest step of a terrace would show.
        let angle = (n as f64 + 0.37) / DIRECTIONS as f64 * std::f64::consts::TAU;
        let direction = [libm::cos(angle), libm::sin(angle)];
        let towards = direction[0] * to_sun[0] + direction[1] * to_sun[1];
        (direction, ((1.0 + 0.4 * towards) / DIRECTIONS as f64) as f32)
    })
}

/// One sector of a sky of even brightness above a horizon of some tangent: its weight for the upward part of a
/// normal and for the part towards the sector \[dozier1990, eq. 8\].
fn sector(tangent: f32) -> [f32; 2] {
    let t = tangent.max(-20.0);
    let square = 1.0 / (1.0 + t * t);
    let from_zenith = std::f32::consts::FRAC_PI_2 - arc_tangent(t);
    [square, from_zenith - t * square]
}

/// The arc tangent to 2e-4, in a few multiplications (Abramowitz and Stegun 4.4.49, cut short).
fn arc_tangent(t: f32) -> f32 {
    let a = t.abs();
    let (x, base) = if a > 1.0 { (-1.0 / a, std::f32::consts::FRAC_PI_2) } else { (a, 0.0) };
    let s = x * x;
    let angle =
        base + x * (0.999_866 + s * (-0.330_299_5 + s * (0.180_141 + s * (-0.085_133 + s * 0.020_835_1))));
    if t < 0.0 { -angle } else { angle }
}

/// The tangent of each sample's horizon in a direction (east, south), through `f`.
fn sweep(
    z: &Plane<f32>,
    cell: f64,
    [east, south]: [f64; 2],
    f: impl Fn(f32) -> f32 + Sync,
    work: &Work<'_>,
) -> Result<Plane<f32>> {
    if east.abs() >= south.abs() {
        return sweep_rows(z, cell, south / east, east > 0.0, f, work);
    }
    let turned = z.transposed(&work.stage(0.0, 0.1))?;
    let swept = sweep_rows(&turned, cell, east / south, south > 0.0, f, &work.stage(0.1, 0.9))?;
    swept.transposed(&work.stage(0.9, 1.0))
}

/// A sweep along lines `y = k + shear · x`, |shear| at most 1, towards rising x or towards falling x.
fn sweep_rows(
    z: &Plane<f32>,
    cell: f64,
    shear: f64,
    rising: bool,
    f: impl Fn(f32) -> f32 + Sync,
    work: &Work<'_>,
) -> Result<Plane<f32>> {
    let (cols, rows) = (z.cols, z.rows);
    let drop = shear * (cols - 1) as f64;
    // Lines from the first that touches the field to one past the last.
    let first = (-drop.max(0.0)).floor() as i64 - 1;
    let last = (rows as f64 - drop.min(0.0)).ceil() as i64 + 1;
    let step = (cell * (1.0 + shear * shear).sqrt()) as f32;
    let y_at = |k: i64, x: usize| k as f64 + shear * x as f64;
    let lines = Plane::fill(&work.stage(0.0, 0.8), [cols, (last - first) as usize], |n, out: &mut [f32]| {
        let k = first + n as i64;
        let mut hull: Vec<[f32; 2]> = Vec::with_capacity(64);
        for n in 0..cols {
            let x = if rising { cols - 1 - n } else { n };
            let y = y_at(k, x);
            if y <= -1.0 || y >= rows as f64 {
                continue;
            }
            let y = y.clamp(0.0, (rows - 1) as f64);
            let (j, v) = ((y as usize).min(rows - 2), (y - (y as usize).min(rows - 2) as f64) as f32);
            let height = z.row(j)[x] + v * (z.row(j + 1)[x] - z.row(j)[x]);
            out[x] = f(horizon(&mut hull, [n as f32 * step, height]));
        }
    })?;
    Plane::fill(&work.stage(0.8, 1.0), [cols, rows], |j, out: &mut [f32]| {
        for (x, out) in out.iter_mut().enumerate() {
            let place = j as f64 - shear * x as f64;
            let k = place.floor();
            let v = (place - k) as f32;
            let n = (k as i64 - first) as usize;
            *out = lines.row(n)[x] * (1.0 - v) + lines.row(n + 1)[x] * v;
        }
    })
}

/// The steepest rise from a point to the hull of the points before it, to which the point is then added; 0 where
/// nothing rises above the level.
fn horizon(hull: &mut Vec<[f32; 2]>, point: [f32; 2]) -> f32 {
    let rise = |from: &[f32; 2]| (from[1] - point[1]) / (point[0] - from[0]);
    let mut steepest = hull.last().map_or(0.0, rise);
    // A top that lies below the way to the one behind it is hidden from this point and from all that follow.
    while let Some(next) =
        hull.len().checked_sub(2).map(|below| rise(&hull[below])).filter(|&r| r >= steepest)
    {
        hull.pop();
        steepest = next;
    }
    hull.push(point);
    steepest.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::surface::Surface;
    use super::*;
    use crate::context::Cancel;
    use crate::kit::hash::unit;

    fn rough(cols: usize, rows: usize) -> Plane<f32> {
        let data = (0..cols * rows).map(|i| (unit(3, i as u64) * 40.0) as f32).collect();
        Plane { cols, rows, data }
    }

    #[test]
    fn hull_finds_the_horizon_of_brute_force() {
        let mut hull = Vec::new();
        let points: Vec<[f32; 2]> = (0..500).map(|i| [i as f32, (unit(1, i) * 100.0) as f32]).collect();
        for (i, &point) in points.iter().enumerate() {
            let rises = points[..i].iter().map(|p| (p[1] - point[1]) / (point[0] - p[0]));
            let want = rises.fold(0.0f32, f32::max);
            assert_eq!(horizon(&mut hull, point), want, "at {i}");
        }
    }

    #[test]
    fn sweeps_along_the_axes_match_brute_force() {
        let cancel = Cancel::default();
        let z = rough(23, 17);
        for (east, south) in [(1i64, 0i64), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1)] {
            let length = ((east * east + south * south) as f64).sqrt();
            let direction = [east as f64 / length, south as f64 / length];
            let found = sweep(&z, 5.0, direction, |t| t, &Work::new(&cancel)).unwrap();
            for (j, i) in (0..17i64).flat_map(|j| (0..23i64).map(move |i| (j, i))) {
                let mut want = 0.0f32;
                for n in 1.. {
                    let (x, y) = (i + n * east, j + n * south);
                    if !(0..23).contains(&x) || !(0..17).contains(&y) {
                        break;
                    }
                    let rise = z.row(y as usize)[x as usize] - z.row(j as usize)[i as usize];
                    want = want.max(rise / (n as f64 * length * 5.0) as f32);
                }
                let got = found.row(j as usize)[i as usize];
                // On the diagonal a line's last sample may lie half outside, where the border continues.
                assert!(
                    (got - want).abs() < 1e-4 * (1.0 + want),
                    "({east}, {south}) at ({i}, {j}): {got}, not {want}"
                );
            }
        }
    }

    #[test]
    fn a_plane_sees_the_sky_that_its_slope_leaves() {
        // An endless plane of slope S sees (1 + cos S) / 2 of an even sky; ours ends, far from its middle.
        let cancel = Cancel::default();
        let (n, slope) = (201, 0.7f32);
        let data = (0..n * n).map(|i| (i % n) as f32 * slope).collect();
        let z = Plane { cols: n, rows: n, data };
        let view = SkyView::new(&z, 1.0, [0.0, 0.0], &Work::new(&cancel)).unwrap();
        let [light, _] = view.light(n / 2, n / 2, Surface::normal(&z, 1.0, n / 2, n / 2));
        let want = 0.5 + 0.5 / (1.0 + slope * slope).sqrt();
        assert!((light - want).abs() < 0.01, "{light}, not {want}");
    }

    #[test]
    fn level_ground_sees_all_and_a_pit_little() {
        let cancel = Cancel::default();
        let work = Work::new(&cancel);
        let mut z = Plane { cols: 65, rows: 65, data: vec![0.0f32; 65 * 65] };
        let open = SkyView::new(&z, 1.0, [0.6, 0.3], &work).unwrap().light(32, 32, [0.0, 0.0, 1.0]);
        assert!((open[0] - 1.0).abs() < 1e-3, "{open:?}");
        z.data.iter_mut().for_each(|z| *z = 50.0);
        z.data[32 * 65 + 32] = 0.0;
        let pit = SkyView::new(&z, 1.0, [0.6, 0.3], &work).unwrap().light(32, 32, [0.0, 0.0, 1.0]);
        assert!(pit[0] < 0.01, "{pit:?}");
    }
}
