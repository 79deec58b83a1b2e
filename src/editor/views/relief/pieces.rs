//! The choice of the pieces of the terrain that are drawn: near pieces are fine, far ones are coarse, and those out of
//! sight are left out.

use glam::{Mat4, Vec3, Vec4};

use super::orbit::Orbit;

/// Number of quads along the side of a piece.
pub(crate) const SIDE: u32 = 32;

/// A piece, by its first sample and the stride between the corners of its quads.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Piece {
    pub(crate) col: f32,
    pub(crate) row: f32,
    pub(crate) stride: f32,
}

/// The data on which the choice of pieces depends. Lengths are in metres from the middle of the terrain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    pub(crate) to_screen: Mat4,
    pub(crate) eye: Vec3,
    pub(crate) cols: u32,
    pub(crate) rows: u32,
    /// The place of sample (0, 0).
    pub(crate) corner: [f32; 2],
    pub(crate) cell: f32,
    /// Lowest and highest point.
    pub(crate) heights: [f32; 2],
    /// Height of the view, in pixels.
    pub(crate) pixels: f32,
    /// Pixels that a quad may cover before its piece is divided.
    pub(crate) coarseness: f32,
}

/// The pieces to draw.
pub(crate) fn pieces(sight: &Sight) -> Vec<Piece> {
    let mut found = Vec::new();
    let longest = sight.cols.max(sight.rows).max(2) - 1;
    let mut stride = 1;
    while stride * SIDE < longest {
        stride *= 2;
    }
    let mut stack = vec![(0, 0, stride)];
    while let Some((col, row, stride)) = stack.pop() {
        if col + 1 >= sight.cols || row + 1 >= sight.rows {
            continue;
        }
        let (low, high) = bounds(sight, col, row, stride);
        if !is_seen(&sight.to_screen, low, high) {
            continue;
        }
        let nearest = sight.eye.clamp(low, high);
        let quad = stride as f32 * sight.cell;
        let pixels = Orbit::share(quad, nearest.distance(sight.eye)) * sight.pixels;
        if stride > 1 && pixels > sight.coarseness {
            let half = stride / 2;
            let step = half * SIDE;
            stack.extend(
                [(col, row), (col + step, row), (col, row + step), (col + step, row + step)]
                    .map(|(c, r)| (c, r, half)),
            );
        } else {
            found.push(Piece { col: col as f32, row: row as f32, stride: stride as f32 });
        }
    }
    found
}

fn bounds(sight: &Sight, col: u32, row: u32, stride: u32) -> (Vec3, Vec3) {
    let at = |c: u32, r: u32, z: f32| {
        let (c, r) = (c.min(sight.cols - 1) as f32, r.min(sight.rows - 1) as f32);
        Vec3::new(sight.corner[0] + c * sight.cell, sight.corner[1] + r * sight.cell, z)
    };
    let (end_col, end_row) = (col + stride * SIDE, row + stride * SIDE);
    (at(col, row, sight.heights[0]), at(end_col, end_row, sight.heights[1]))
}

/// Whether a box may be visible: not all of its corners are beyond the same side of the screen.
fn is_seen(to_screen: &Mat4, low: Vec3, high: Vec3) -> bool {
    let corner = |k: usize| {
        let pick = |bit: usize, a: f32, b: f32| if k >> bit & 1 == 0 { a } else { b };
        let at = Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
        *to_screen * at.extend(1.0)
    };
    let corners: [Vec4; 8] = std::array::from_fn(corner);
    let beyond: [fn(&Vec4) -> bool; 5] =
        [|c| c.x < -c.w, |c| c.x > c.w, |c| c.y < -c.w, |c| c.y > c.w, |c| c.z < 0.0];
    !beyond.iter().any(|side| corners.iter().all(side))
}

/// The corners of a piece (column, row, and 1 for the lower edge of a skirt) and the triangles between them. Skirts
/// hang down along the border and close the cracks between pieces of different strides.
pub(crate) fn grid() -> (Vec<[f32; 3]>, Vec<u16>) {
    let side = SIDE as u16;
    let wide = side + 1;
    let mut corners: Vec<[f32; 3]> =
        (0..wide * wide).map(|k| [f32::from(k % wide), f32::from(k / wide), 0.0]).collect();
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [u16; 4]| triangles.extend([a, c, b, b, c, d]);
    for row in 0..side {
        for col in 0..side {
            let at = row * wide + col;
            quad([at, at + 1, at + wide, at + wide + 1]);
        }
    }
    let edges: [fn(u16, u16) -> [u16; 2]; 4] = [|k, _| [k, 0], |k, s| [k, s], |k, _| [0, k], |k, s| [s, k]];
    for edge in edges {
        for k in 0..side {
            let ends = [k, k + 1].map(|k| edge(k, side));
            let first = corners.len() as u16;
            corners.extend(ends.map(|[c, r]| [f32::from(c), f32::from(r), 1.0]));
            let above = ends.map(|[c, r]| r * wide + c);
            quad([above[0], above[1], first, first + 1]);
        }
    }
    (corners, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight(size: u32, coarseness: f32) -> Sight {
        let orbit = Orbit { distance: 0.5, pitch: 20.0, ..Orbit::default() };
        Sight {
            to_screen: orbit.projection(1.6, 8192.0),
            eye: orbit.eye() * 8192.0,
            cols: size,
            rows: size,
            corner: [-4096.0; 2],
            cell: 8192.0 / (size - 1) as f32,
            heights: [-500.0, 500.0],
            pixels: 800.0,
            coarseness,
        }
    }

    #[test]
    fn pieces_cover_the_terrain_once() {
        for size in [2, 3, 33, 34, 100, 257, 1000, 4097] {
            let mut sight = sight(size, 3.0);
            // Everything is in sight.
            sight.to_screen = Mat4::from_scale(Vec3::splat(1e-6)) * Mat4::from_translation(Vec3::splat(1.0));
            let found = pieces(&sight);
            let quads: f64 = found
                .iter()
                .map(|p| {
                    let span = |from: f32, n: u32| {
                        let end = (from + p.stride * SIDE as f32).min((n - 1) as f32);
                        f64::from(end - from)
                    };
                    span(p.col, size) * span(p.row, size)
                })
                .sum();
            let side = f64::from(size - 1);
            assert_eq!(quads, side * side, "{size}");
        }
    }

    #[test]
    fn near_pieces_are_finer_and_their_number_is_bounded() {
        let fine = pieces(&sight(4097, 2.5));
        let strides: Vec<f32> = fine.iter().map(|p| p.stride).collect();
        let (least, most) = strides.iter().fold((f32::MAX, 0.0f32), |(a, b), s| (a.min(*s), b.max(*s)));
        assert!(least < most, "{least} {most}");
        assert!(fine.len() < 1500, "{}", fine.len());
        assert!(pieces(&sight(4097, 8.0)).len() < fine.len());
    }

    #[test]
    fn what_is_behind_the_eye_is_not_drawn() {
        let mut sight = sight(1025, 3.0);
        let whole = pieces(&sight).len();
        let orbit =
            Orbit { target: Vec3::new(0.4, 0.0, 0.0), azimuth: 270.0, distance: 0.2, ..Orbit::default() };
        sight.to_screen = orbit.projection(1.6, 8192.0);
        sight.eye = orbit.eye() * 8192.0;
        let part = pieces(&sight);
        assert!(
            !part.is_empty() && part.iter().all(|p| p.col + p.stride * 32.0 > 600.0),
            "{whole}: {part:?}"
        );
    }

    #[test]
    fn the_triangles_of_a_piece_stay_inside_it() {
        let (corners, triangles) = grid();
        assert_eq!(triangles.len() as u32, 6 * (SIDE * SIDE + 4 * SIDE));
        assert!(triangles.iter().all(|i| usize::from(*i) < corners.len()));
    }
}
