//! From constraints to terrain.

use rayon::prelude::*;

use crate::kit::diffusion::{self, Guidance, Problem, Solver, renormalise};
use crate::prelude::*;
use crate::value::{Mark, Planes};

/// Spreads the constraints of curves over the terrain: a height that meets them, and amplitude and roughness of noise.
///
/// First the gradient, its direction and its steepness, is spread from the slopes beside the curves; then the height,
/// guided by it [hnaidi2010, section 4.2]. The height of a sample is
/// `laplace · mean of its neighbours + gradient · (neighbour towards the curve + G) + fixed · constraint`, the three
/// weights summing to 1: on plateaus `fixed` is `hold`, on slopes `gradient` is `follow`, elsewhere all is `laplace`.
/// Where slopes of several curves meet and none is much nearer, `fixed` is `follow` instead, at a height between theirs.
/// Of a sample beside the edge of a plateau `fixed` shares with the neighbours beyond, by the distance of the edge.
/// Amplitude and roughness of `multifractal` spread from where curves set them.
///
/// With a `base` it works inside the smoothed strips of the curves only [weiss2015, chapter V]: beyond them, and where
/// curves say nothing, the base stays as it is, to the bit.
///
/// # Differs from the paper
/// With the weights `n_x²`, `n_y²` of the paper a slope of 45° to the axes comes out 41 % too steep; here they are
/// `|n_x|` and `|n_y|` over their sum, and `G = cell · tan θ / (|n_x| + |n_y|)`, which is exact in every direction.
/// Weiss's (9) as printed sets samples outside the strips to 0; what is meant, and done here, is
/// `αE + βG + (1 − α − β)(γL + (1 − γ)H)`, with `G` a height difference over a cell, so a tangent. The two papers use α
/// for opposite things: Weiss's 0.9 on plateaus is a `hold` of 0.9.
///
/// # Limits
/// It runs on the base grid. Half slope and half smoothness is a matter of cells: walls of fewer than about ten base
/// cells dip the land beside them in `converged`; raise `follow` or the base there.
///
/// `paper` and `converged` make two landscapes, and one is no draft of the other. `paper` is fast and not settled far from
/// curves: wide empty land keeps a trace of the coarse grids, on which slopes are thinner than a cell and raise little, so
/// the plateau beside a gorge may lie a hundred metres lower than in `converged`, which is the exact answer, and slower.
///
/// # See also
/// `curve_raster` makes the constraints; `multifractal` takes amplitude and roughness.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Diffuse {
    /// How well the equations are solved.
    pub quality: Quality,
    /// How strictly plateaus keep their height; below 1 they are smoothed a little.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub hold: Ratio,
    /// How strictly slopes keep their angle, against smoothness.
    pub follow: Ratio,
}

/// How well the equations are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// As in the paper: from coarse to fine, some sweeps on each grid. Fast, and not a draft of the other: what lies far
    /// from curves comes out at other heights.
    #[default]
    Paper,
    /// Down to an error of a hundred-thousandth of the range.
    Converged,
}

impl Default for Diffuse {
    fn default() -> Self {
        Self { quality: Quality::default(), hold: Ratio(1.0), follow: Ratio(0.5) }
    }
}

ports! {
    pub struct Inputs {
        /// What curves say about samples.
        constraints: Constraints,
        /// Terrain that is changed inside the smoothed strips of the curves.
        base: Option<Field>,
    }
    pub struct Outputs {
        /// Height, in metres.
        height: Field = Meaning::Fixed(Quantity::Elevation),
        /// Amplitude of noise, in metres; 0 where no curve sets one.
        amplitude: Field = Meaning::Fixed(Quantity::Length),
        /// Roughness of noise, 0 to 1.
        roughness: Field = Meaning::Fixed(Quantity::Mask),
        /// Gradient that guided the height, in metres per metre to the east and south.
        gradient: Vectors,
    }
}

impl Node for Diffuse {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["hnaidi2010", "weiss2015"])
        .keywords(&["laplace", "poisson", "multigrid", "interpolate", "spread", "curves", "membrane"])
        .carries(&[("height", "base")])
        .mixes(&[("height", "base")]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let (nanoseconds, fields) = match self.quality {
            Quality::Paper => (150.0, 14.0),
            Quality::Converged => (800.0, 34.0),
        };
        let cost = Cost::per_sample(grid, nanoseconds).with_fields(grid, fields);
        Cost { bytes: cost.bytes + diffusion::scratch(), ..cost }
    }

    fn run(&self, cx: &Context<'_>, Inputs { constraints, base }: Inputs) -> Result<Outputs> {
        let planes = constraints.planes();
        let mut spread = Spread { solver: Solver::new(self.quality.solver()), planes };
        let gradient = spread.gradient(&cx.stage(0.0, 0.45))?;
        let base = base.map(|b| b.crop(&cx.grid));
        let vectors = gradient.as_ref().map_or_else(|| vec![[0.0; 2]; cx.grid.len()], Gradient::vectors);
        // Without slopes the mean of all neighbours serves the edges of plateaus well enough for a fast answer.
        let plain = gradient.is_none() && self.quality == Quality::Paper;
        let guides = if plain { None } else { spread.leaning(gradient) };
        let height = self.height(&mut spread, &cx.stage(0.45, 0.7), guides.as_ref(), base.as_ref())?;
        let [amplitude, roughness] = spread.noise(&cx.stage(0.7, 1.0))?;
        let field = |quantity, data| Field::new(cx.grid, quantity, data);
        Ok(Outputs {
            height: field(Quantity::Elevation, height),
            amplitude: field(Quantity::Length, amplitude),
            roughness: field(Quantity::Mask, roughness),
            gradient: Vectors::new(cx.grid, Quantity::Vector, vectors),
        })
    }
}

impl Diffuse {
    fn height(
        &self,
        spread: &mut Spread<'_>,
        cx: &Context<'_>,
        guides: Option<&Gradient>,
        base: Option<&Field>,
    ) -> Result<Vec<f32>> {
        let planes = spread.planes;
        let weights = |i: usize| self.weights(planes, i, base.map(|b| b.data()[i]));
        let fixed = spread.filled(|i| weights(i).fixed);
        let target = spread.filled(|i| weights(i).target);
        let weight = guides.map(|_| spread.filled(|i| weights(i).gradient));
        let guidance = guides.zip(weight.as_deref()).map(|(Gradient { x, y, steepness }, weight)| Guidance {
            weight,
            x,
            y,
            slope: steepness,
            cell: cx.grid.cell() as f32,
        });
        let (cols, rows) = (cx.grid.cols, cx.grid.rows);
        let problem = Problem { cols, rows, fixed: &fixed, target: &target, guidance, source: None };
        let height = spread.solver.solve(&problem, &cx.work).map_err(refused)?.field;
        [fixed, target].into_iter().chain(weight).for_each(|buffer| spread.solver.keep(buffer));
        Ok(height)
    }

    /// The weights of a sample, and what it is drawn to. With a base, (9) of \[weiss2015\] as it is meant: what the
    /// smoothed strip leaves stays as the base has it.
    fn weights(&self, planes: &Planes, i: usize, base: Option<f32>) -> Weights {
        let mark = planes.marks[i];
        let known = mark & (Mark::Height.bit() | Mark::Edge.bit()) != 0;
        let height = planes.height.as_ref().filter(|_| known).map(|p| p[i]);
        // Where a plateau ends between samples, the neighbours beyond have their share.
        let [x, y] = planes.lean.as_ref().map_or([0.0; 2], |p| p[i]);
        let beyond = (x * x + y * y).sqrt();
        let ground = planes.ground.as_ref().filter(|_| !known).map_or(0.0, |p| p[i]);
        let height = height.or_else(|| planes.height.as_ref().filter(|_| ground > 0.0).map(|p| p[i]));
        let guided = !known && mark & (Mark::Gradient.bit() | Mark::Open.bit()) != 0;
        let follow = self.follow.0 as f32;
        let hold = if known { self.hold.0 as f32 } else { follow * ground };
        let trust = planes.trust.as_ref().map_or(1.0, |p| p[i]);
        let gradient = if guided { follow * trust } else { hold * beyond };
        let hold = hold * (1.0 - beyond);
        let Some(base) = base else {
            return Weights { fixed: hold, target: height.unwrap_or(0.0), gradient };
        };
        let smooth = planes.envelope.as_ref().map_or(0.0, |p| p[i]);
        let kept = (1.0 - hold - gradient) * (1.0 - smooth);
        let target = match height {
            Some(height) => (hold * height + kept * base) / (hold + kept),
            None => base,
        };
        Weights { fixed: hold + kept, target, gradient }
    }
}

/// How much of a sample each equation decides; the rest is smoothness.
struct Weights {
    fixed: f32,
    target: f32,
    gradient: f32,
}

/// What is spread, and what does it.
struct Spread<'a> {
    solver: Solver,
    planes: &'a Planes,
}

/// The gradient on every sample.
struct Gradient {
    /// Direction of length one; none where directions cancel.
    x: Vec<f32>,
    y: Vec<f32>,
    /// Rise along the direction, as a tangent.
    steepness: Vec<f32>,
}

impl Gradient {
    /// In metres per metre to the east and south.
    fn vectors(&self) -> Vec<[f32; 2]> {
        let both = self.x.par_iter().zip(&self.y).zip(&self.steepness);
        both.map(|((x, y), steep)| [x * steep, y * steep]).collect()
    }

    fn nowhere(n: usize) -> Self {
        Self { x: vec![0.0; n], y: vec![0.0; n], steepness: vec![0.0; n] }
    }
}

impl Spread<'_> {
    /// Direction and steepness, spread from where curves say them; none where no curve does.
    fn gradient(&mut self, cx: &Context<'_>) -> Result<Option<Gradient>> {
        let planes = self.planes;
        let (Some(direction), Some(steep)) = (&planes.direction, &planes.steepness) else {
            return Ok(None);
        };
        let fill = |k: usize, out: &mut [f32]| match k {
            2 => fill(out, |i| steep[i]),
            axis => fill(out, |i| direction[i][axis]),
        };
        let [mut x, mut y, steepness] = self.solve_all(cx, Mark::Gradient, fill)?;
        renormalise(&mut x, &mut y);
        Ok(Some(Gradient { x, y, steepness }))
    }

    /// The gradient as guidance: at the edges of plateaus level and towards them, so that a sample beside an edge takes
    /// its share of the neighbours beyond.
    fn leaning(&self, gradient: Option<Gradient>) -> Option<Gradient> {
        let Some(lean) = &self.planes.lean else { return gradient };
        let mut guides = gradient.unwrap_or_else(|| Gradient::nowhere(lean.len()));
        let Gradient { x, y, steepness } = &mut guides;
        let all = x.par_iter_mut().zip(y).zip(steepness).zip(lean);
        all.with_min_len(1 << 14).filter(|(_, lean)| **lean != [0.0; 2]).for_each(
            |(((x, y), steep), lean)| {
                (*x, *y, *steep) = (-lean[0], -lean[1], 0.0);
            },
        );
        Some(guides)
    }

    /// Amplitude and roughness, spread from where curves say them.
    fn noise(&mut self, cx: &Context<'_>) -> Result<[Vec<f32>; 2]> {
        let Some(noise) = &self.planes.noise else {
            return Ok([vec![0.0; cx.grid.len()], vec![0.0; cx.grid.len()]]);
        };
        let found = self.solve_all(cx, Mark::Noise, |k, out| fill(out, |i| noise[i][k]))?;
        let [mut amplitude, mut roughness] = found;
        amplitude.par_iter_mut().for_each(|v| *v = v.max(0.0));
        roughness.par_iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
        Ok([amplitude, roughness])
    }

    /// Spreads several things that are known where samples are marked.
    fn solve_all<const N: usize>(
        &mut self,
        cx: &Context<'_>,
        mark: Mark,
        target: impl Fn(usize, &mut [f32]),
    ) -> Result<[Vec<f32>; N]> {
        let marks = &self.planes.marks;
        let fixed = self.filled(|i| f32::from(u8::from(marks[i] & mark.bit() != 0)));
        let (cols, rows) = (cx.grid.cols, cx.grid.rows);
        let problem = Problem { cols, rows, fixed: &fixed, target: &[], guidance: None, source: None };
        let solutions = self.solver.solve_all(&problem, N, target, &cx.work).map_err(refused)?;
        self.solver.keep(fixed);
        let mut fields = solutions.into_iter().map(|s| s.field);
        Ok(std::array::from_fn(|_| fields.next().unwrap_or_default()))
    }

    /// A plane made sample by sample, in a buffer of the solver.
    fn filled(&mut self, f: impl Fn(usize) -> f32 + Send + Sync) -> Vec<f32> {
        let mut out = self.solver.buffer(self.planes.marks.len());
        fill(&mut out, f);
        out
    }
}

impl Quality {
    fn solver(self) -> diffusion::Quality {
        match self {
            Self::Paper => diffusion::Quality::Paper,
            Self::Converged => diffusion::Quality::CONVERGED,
        }
    }
}

fn refused(error: diffusion::Error) -> Error {
    match error {
        diffusion::Error::Cancelled => Error::Cancelled,
        misfit => Error::Input { port: "constraints".into(), message: misfit.to_string() },
    }
}

/// Makes a plane sample by sample.
fn fill(out: &mut [f32], f: impl Fn(usize) -> f32 + Send + Sync) {
    out.par_iter_mut().with_min_len(1 << 14).enumerate().for_each(|(i, o)| *o = f(i));
}
