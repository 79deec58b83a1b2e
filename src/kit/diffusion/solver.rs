//! One solve after the other, with what they share.

use rayon::prelude::*;

use crate::kit::diffusion::converged::{Prepared, converge, start};
use crate::kit::diffusion::paper::{Extent, cascade};
use crate::kit::diffusion::problem::{HUGE, Problem};
use crate::kit::diffusion::scratch::Scratch;
use crate::kit::diffusion::solve::{Error, Quality, Solution};
use crate::kit::simd::Level;
use crate::work::Work;

/// Solves problems of one size one after the other, with the same buffers: fresh memory costs as much as the work.
pub struct Solver {
    quality: Quality,
    simd: Level,
    scratch: Scratch,
}

impl Solver {
    /// A solver without buffers.
    pub fn new(quality: Quality) -> Self {
        Self::at(quality, Level::best())
    }

    pub(crate) fn at(quality: Quality, simd: Level) -> Self {
        Self { quality, simd, scratch: Scratch::default() }
    }

    /// A buffer for a map of a problem, with whatever values.
    pub fn buffer(&mut self, len: usize) -> Vec<f32> {
        self.scratch.take(len)
    }

    /// Keeps a buffer that is no longer needed for later.
    pub fn keep(&mut self, buffer: Vec<f32>) {
        self.scratch.keep(buffer);
    }

    /// Solves a problem as [`solve`](crate::kit::diffusion::solve) does.
    ///
    /// # Errors
    /// [`Error::Length`] when an array does not fit the grid; [`Error::Cancelled`] when the work was asked to stop.
    pub fn solve(&mut self, problem: &Problem<'_>, work: &Work<'_>) -> Result<Solution, Error> {
        if let Some((array, found)) = problem.misfit() {
            return Err(Error::Length { array, found, expected: problem.len() });
        }
        work.check()?;
        let (extent, guided) = survey(problem, self.simd);
        let problem = Problem { guidance: problem.guidance.filter(|_| guided), ..*problem };
        let shaped = guided || problem.source.is_some_and(|s| s.iter().any(|&s| s != 0.0));
        match extent {
            Some((low, high)) => {
                let extent = Extent { low, high, bounded: !shaped };
                self.run(&problem, extent, &mut None, work)
            }
            None if shaped && problem.len() > 0 => self.anchored(&problem, work),
            None => Ok(Solution::nothing(problem.len())),
        }
    }

    /// Solves for several targets on the same constraints, each of which `fill` writes into a buffer: the problem's
    /// own is not read. Each solution is the same to the bit as by itself; what depends on the constraints alone is
    /// made once where the problem has neither guidance nor source.
    ///
    /// # Errors
    /// As [`Solver::solve`].
    pub fn solve_all(
        &mut self,
        problem: &Problem<'_>,
        targets: usize,
        fill: impl Fn(usize, &mut [f32]),
        work: &Work<'_>,
    ) -> Result<Vec<Solution>, Error> {
        let mut shared = None;
        let mut target = self.buffer(problem.len());
        let mut solutions = Vec::new();
        for k in 0..targets {
            fill(k, &mut target);
            let (part, of) = (k as f32, targets as f32);
            let work = work.stage(part / of, (part + 1.0) / of);
            let problem = Problem { target: &target, ..*problem };
            solutions.push(self.next(&problem, &mut shared, &work)?);
        }
        self.keep(target);
        Ok(solutions)
    }

    fn next(
        &mut self,
        problem: &Problem<'_>,
        shared: &mut Option<Prepared>,
        work: &Work<'_>,
    ) -> Result<Solution, Error> {
        if let Some((array, found)) = problem.misfit() {
            return Err(Error::Length { array, found, expected: problem.len() });
        }
        let unsound = |(&f, &t): (&f32, &f32)| f > 0.0 && (t.is_nan() || t.abs() >= HUGE);
        let plain = problem.guidance.is_none() && problem.source.is_none();
        let converged = matches!(self.quality, Quality::Converged { .. });
        // Which constraints there are depends on the target where that is not sound.
        if !plain || converged && problem.fixed.par_iter().zip(problem.target).any(unsound) {
            return self.solve(problem, work);
        }
        work.check()?;
        match survey(problem, self.simd).0 {
            Some((low, high)) => self.run(problem, Extent { low, high, bounded: true }, shared, work),
            None => Ok(Solution::nothing(problem.len())),
        }
    }

    /// Solves with the border held at zero.
    fn anchored(&mut self, problem: &Problem<'_>, work: &Work<'_>) -> Result<Solution, Error> {
        let (cols, rows) = (problem.cols, problem.rows);
        let border = |k: usize| {
            let (i, j) = (k % cols, k / cols);
            i == 0 || j == 0 || i + 1 == cols || j + 1 == rows
        };
        let fixed: Vec<f32> = (0..problem.len()).map(|k| if border(k) { 1.0 } else { 0.0 }).collect();
        let target = vec![0.0; problem.len()];
        let anchored = Problem { fixed: &fixed, target: &target, ..*problem };
        self.run(&anchored, Extent { low: 0.0, high: 0.0, bounded: false }, &mut None, work)
    }

    /// Solves what has constraints; `prepared` is what was made of the same matrix before.
    fn run(
        &mut self,
        problem: &Problem<'_>,
        extent: Extent,
        prepared: &mut Option<Prepared>,
        work: &Work<'_>,
    ) -> Result<Solution, Error> {
        let (simd, scratch) = (self.simd, &mut self.scratch);
        let solution = match self.quality {
            Quality::Paper => {
                let field = cascade(problem, extent, scratch, simd, work)?;
                Solution { field, cycles: 0, history: Vec::new(), converged: true }
            }
            Quality::Converged { tolerance, cycles } => {
                let field = start(problem, extent, scratch, simd, work)?;
                work.report(0.1);
                let prepared = match prepared {
                    Some(prepared) => prepared,
                    None => prepared.insert(Prepared::new(problem, simd, work)?),
                };
                let found = converge(problem, extent, (tolerance, cycles), prepared, field, work)?;
                let scale = if found.range > 0.0 { 1.0 / found.range } else { 1.0 };
                let history: Vec<f64> = found.history.iter().map(|e| e * scale).collect();
                Solution { field: found.field, cycles: found.cycles, history, converged: found.converged }
            }
        };
        work.report(1.0);
        Ok(solution)
    }
}

/// The least and the largest constraint, none where there are none, and whether guidance has weight.
fn survey(problem: &Problem<'_>, level: Level) -> (Option<(f32, f32)>, bool) {
    let (low, high, guided) = (0..problem.rows)
        .into_par_iter()
        .map(|j| problem.survey(level, j))
        .reduce(|| (HUGE, -HUGE, false), |a, b| (a.0.min(b.0), a.1.max(b.1), a.2 || b.2));
    ((low <= high).then_some((low, high)), guided)
}
