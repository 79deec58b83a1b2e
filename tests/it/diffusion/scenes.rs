//! Problems for the tests.

use orograph::kit::diffusion::{Guidance, Problem};

/// The maps of a problem, owned.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) cols: usize,
    pub(crate) rows: usize,
    pub(crate) fixed: Vec<f32>,
    pub(crate) target: Vec<f32>,
    /// Weight, x, y, slope.
    pub(crate) guidance: Option<[Vec<f32>; 4]>,
    pub(crate) source: Option<Vec<f32>>,
    pub(crate) cell: f32,
}

impl Scene {
    pub(crate) fn empty(cols: usize, rows: usize) -> Self {
        let n = cols * rows;
        Self {
            cols,
            rows,
            fixed: vec![0.0; n],
            target: vec![0.0; n],
            guidance: None,
            source: None,
            cell: 1.0,
        }
    }

    pub(crate) fn problem(&self) -> Problem<'_> {
        let guidance = self.guidance.as_ref().map(|[weight, x, y, slope]| Guidance {
            weight,
            x,
            y,
            slope,
            cell: self.cell,
        });
        Problem {
            cols: self.cols,
            rows: self.rows,
            fixed: &self.fixed,
            target: &self.target,
            guidance,
            source: self.source.as_deref(),
        }
    }

    pub(crate) fn fix(&mut self, i: usize, j: usize, weight: f32, value: f32) {
        (self.fixed[j * self.cols + i], self.target[j * self.cols + i]) = (weight, value);
    }

    /// A line of constraints one cell wide, with a height that changes along it.
    pub(crate) fn line(&mut self, a: (f32, f32), b: (f32, f32), heights: (f32, f32)) {
        let steps = 3 * self.cols.max(self.rows);
        for k in 0..=steps {
            let t = k as f32 / steps as f32;
            let x = ((a.0 + (b.0 - a.0) * t) * (self.cols - 1) as f32).round() as usize;
            let y = ((a.1 + (b.1 - a.1) * t) * (self.rows - 1) as f32).round() as usize;
            self.fix(x, y, 1.0, heights.0 + (heights.1 - heights.0) * t);
        }
    }

    /// Guidance that leads away from the constraints, falling, as far as `reach` cells.
    pub(crate) fn guide(&mut self, weight: f32, reach: f32, slope: f32) {
        let n = self.cols * self.rows;
        let held: Vec<usize> = (0..n).filter(|&k| self.fixed[k] > 0.0).collect();
        let mut maps: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; n]);
        for k in (0..n).filter(|&k| self.fixed[k] == 0.0) {
            let at = |q: usize| ((q % self.cols) as f32, (q / self.cols) as f32);
            let (x, y) = at(k);
            let near = held
                .iter()
                .map(|&q| (x - at(q).0, y - at(q).1))
                .min_by(|a, b| (a.0 * a.0 + a.1 * a.1).total_cmp(&(b.0 * b.0 + b.1 * b.1)));
            let Some((dx, dy)) = near else { continue };
            let d = (dx * dx + dy * dy).sqrt();
            if d < reach {
                maps[0][k] = weight;
                (maps[1][k], maps[2][k]) = (dx / d, dy / d);
                maps[3][k] = -slope * (1.0 - d / reach);
            }
        }
        self.guidance = Some(maps);
    }

    /// A few thin lines, a point and an island.
    pub(crate) fn curves(cols: usize, rows: usize) -> Self {
        let mut s = Self::empty(cols, rows);
        s.line((0.1, 0.2), (0.7, 0.35), (800.0, 950.0));
        s.line((0.3, 0.9), (0.35, 0.45), (400.0, 300.0));
        s.line((0.8, 0.6), (0.95, 0.98), (100.0, 120.0));
        s.line((0.6, 0.7), (0.6, 0.8), (700.0, 700.0));
        s.line((0.6, 0.8), (0.7, 0.8), (700.0, 700.0));
        s.line((0.7, 0.8), (0.7, 0.7), (700.0, 700.0));
        s.line((0.7, 0.7), (0.6, 0.7), (700.0, 700.0));
        s.fix(cols / 20, rows - 1 - rows / 9, 1.0, 1500.0);
        s
    }

    /// The curves with guidance away from them.
    pub(crate) fn guided(cols: usize, rows: usize) -> Self {
        let mut s = Self::curves(cols, rows);
        s.cell = 20.0;
        s.guide(0.5, cols as f32 / 7.0, 0.6);
        s
    }
}
