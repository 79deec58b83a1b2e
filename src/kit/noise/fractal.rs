//! Sums of Perlin noise over octaves.

use super::CHUNK;
use super::lattice::{Columns, Turned, perlin};
use crate::kit::hash;
use crate::kit::simd::{Kernel, Level, exp2, larger, smaller};

/// How octaves add up. Heights are in parts of the amplitude; `w` is the weight of an octave, the weights sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// `Σ w n`: rolling ground alike in valleys and on tops, from −1 to 1.
    Fbm,
    /// `Σ w |n|`: round tops and creased valleys, from 0 to 1.
    Billow {
        /// 1 leaves a crease in the valleys, less rounds it.
        sharpness: f32,
    },
    /// `Σ w c (1 − |n|)²`: crests, from 0 to 1. The factor `c` of an octave is what the one before gave, times the
    /// focus, cut to 0 to 1, so fine crests gather on coarse ones.
    Ridged {
        /// 1 leaves a crease on the crests, less rounds it.
        sharpness: f32,
        /// How soon an octave lets the next one in.
        focus: f32,
    },
    /// `Σ w c (n + base) / (1 + base)`: smooth valleys and rough heights. The factor `c` is the product of the
    /// `n + base` of all octaves before, each time cut to 0 to 1.
    Hybrid {
        /// Height above which detail appears; from 0 to 1 and more.
        base: f32,
    },
    /// `Σ q^k n` with `q = r^(R − 1)`, `r` the lacunarity and `R` the roughness of the sample: not divided by the
    /// sum of weights \[hnaidi2010, section 4.3\].
    Rough,
}

/// Sizes of the octaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Cell of the first octave, in metres.
    pub feature_size: f64,
    /// Number of octaves, at least 1.
    pub octaves: u32,
    /// Ratio of the cells of neighbouring octaves.
    pub lacunarity: f64,
    /// Ratio of the weights of neighbouring octaves.
    pub gain: f64,
}

/// Fractal noise.
#[derive(Clone, Debug)]
pub struct Fractal {
    form: Form,
    octaves: Vec<(Turned, f32)>,
    lacunarity: f64,
    /// Height of 1 part, in metres.
    amplitude: f32,
    /// Height of 0 parts, in metres.
    base: f32,
}

impl Fractal {
    /// Noise of a form, from a seed; heights become `base + amplitude · parts`.
    pub fn new(form: Form, spectrum: Spectrum, seed: u64, base: f64, amplitude: f64) -> Self {
        let Spectrum { feature_size, octaves, lacunarity, gain } = spectrum;
        let (mut size, mut weight, mut sum) = (feature_size, 1.0, 0.0);
        let mut parts = Vec::with_capacity(octaves as usize);
        for k in 0..octaves.max(1) {
            parts.push((Turned::new(size, hash::nth(seed, u64::from(k))), weight));
            sum += weight;
            size /= lacunarity;
            weight *= gain;
        }
        let octaves = parts.into_iter().map(|(turned, w)| (turned, (w / sum) as f32)).collect();
        Self { form, octaves, lacunarity, amplitude: amplitude as f32, base: base as f32 }
    }

    /// Prepares the columns at some x, in metres.
    pub fn over(&self, xs: &[f64]) -> FractalRows<'_> {
        let columns = self.octaves.iter().map(|(turned, _)| turned.columns(xs)).collect();
        FractalRows { noise: self, columns, level: Level::best() }
    }

    /// Bytes that [`over`](Self::over) takes for some columns.
    pub fn bytes(octaves: u32, columns: usize) -> u64 {
        u64::from(octaves) * Columns::bytes(columns)
    }
}

/// Fractal noise on the rows of a grid.
#[derive(Clone, Debug)]
pub struct FractalRows<'a> {
    noise: &'a Fractal,
    columns: Vec<Columns>,
    level: Level,
}

impl FractalRows<'_> {
    /// The same on a given instruction set; the bits do not change.
    pub fn on(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// The heights of a row at y (in metres), one for each x.
    pub fn row(&self, y: f64, out: &mut [f32]) {
        self.rough_row(y, &[], out);
    }

    /// As [`row`](Self::row), with a roughness for each x, which [`Form::Rough`] alone reads; the last one stands for
    /// all that are missing, and 0 for none.
    pub fn rough_row(&self, y: f64, roughness: &[f32], out: &mut [f32]) {
        match self.noise.form {
            Form::Fbm => self.run(y, roughness, out, Plain),
            Form::Billow { sharpness } => self.run(y, roughness, out, Billow(Round::new(sharpness))),
            Form::Ridged { sharpness, focus } => {
                self.run(y, roughness, out, Ridged { round: Round::new(sharpness), focus });
            }
            Form::Hybrid { base } => self.run(y, roughness, out, Hybrid { base, share: 1.0 / (1.0 + base) }),
            Form::Rough => {
                self.run(y, roughness, out, Rough { log2: libm::log2(self.noise.lacunarity) as f32 });
            }
        }
    }

    fn run<R: Rule>(&self, y: f64, roughness: &[f32], out: &mut [f32], rule: R) {
        self.level.run(RowKernel { rows: self, y, roughness, out, rule });
    }
}

/// How one octave joins those before it.
trait Rule: Copy {
    /// Whether the rule carries a factor from octave to octave.
    const CARRIES: bool;
    /// The ratio of the factors, for a rule that reads roughness.
    #[inline(always)]
    fn ratio(self, _roughness: f32) -> f32 {
        0.0
    }
    /// The new sum and factor; the first octave gets 0 and 1.
    fn join(self, noise: f32, weight: f32, sum: f32, factor: f32, ratio: f32) -> (f32, f32);
}

#[derive(Clone, Copy)]
struct Plain;
impl Rule for Plain {
    const CARRIES: bool = false;
    #[inline(always)]
    fn join(self, noise: f32, weight: f32, sum: f32, factor: f32, _: f32) -> (f32, f32) {
        (sum + weight * noise, factor)
    }
}

/// The absolute value with its crease rounded by a parabola.
#[derive(Clone, Copy)]
struct Round {
    width: f32,
    half: f32,
}

impl Round {
    fn new(sharpness: f32) -> Self {
        let width = 1.0 - sharpness.clamp(0.0, 1.0);
        Self { width, half: if width > 0.0 { 0.5 / width } else { 0.0 } }
    }

    #[inline(always)]
    fn abs(self, x: f32) -> f32 {
        let x = x.abs();
        let near = smaller(x, self.width);
        (x - near) + near * near * self.half
    }
}

#[derive(Clone, Copy)]
struct Billow(Round);
impl Rule for Billow {
    const CARRIES: bool = false;
    #[inline(always)]
    fn join(self, noise: f32, weight: f32, sum: f32, factor: f32, _: f32) -> (f32, f32) {
        (sum + weight * self.0.abs(noise), factor)
    }
}

#[derive(Clone, Copy)]
struct Ridged {
    round: Round,
    focus: f32,
}
impl Rule for Ridged {
    const CARRIES: bool = true;
    #[inline(always)]
    fn join(self, noise: f32, weight: f32, sum: f32, factor: f32, _: f32) -> (f32, f32) {
        let crest = 1.0 - self.round.abs(noise);
        let signal = crest * crest * factor;
        (sum + weight * signal, smaller(signal * self.focus, 1.0))
    }
}

#[derive(Clone, Copy)]
struct Hybrid {
    base: f32,
    share: f32,
}
impl Rule for Hybrid {
    const CARRIES: bool = true;
    #[inline(always)]
    fn join(self, noise: f32, weight: f32, sum: f32, factor: f32, _: f32) -> (f32, f32) {
        let signal = (noise + self.base) * factor;
        (sum + weight * self.share * signal, smaller(larger(signal, 0.0), 1.0))
    }
}

#[derive(Clone, Copy)]
struct Rough {
    log2: f32,
}
impl Rule for Rough {
    const CARRIES: bool = true;
    #[inline(always)]
    fn ratio(self, roughness: f32) -> f32 {
        exp2((smaller(larger(roughness, 0.0), 1.0) - 1.0) * self.log2)
    }
    #[inline(always)]
    fn join(self, noise: f32, _: f32, sum: f32, factor: f32, ratio: f32) -> (f32, f32) {
        (sum + factor * noise, factor * ratio)
    }
}

/// A row, chunk by chunk, octave by octave, with sums and factors in local arrays.
struct RowKernel<'a, R> {
    rows: &'a FractalRows<'a>,
    y: f64,
    roughness: &'a [f32],
    out: &'a mut [f32],
    rule: R,
}

impl<R: Rule> Kernel for RowKernel<'_, R> {
    #[inline(always)]
    fn run(self) {
        let Self { rows, y, roughness, out, rule } = self;
        let noise = rows.noise;
        let mut ratios = [0.0; CHUNK];
        for (c, out) in out.chunks_mut(CHUNK).enumerate() {
            let (mut sums, mut factors) = ([0.0; CHUNK], [1.0; CHUNK]);
            if R::CARRIES {
                let given = roughness.get(c * CHUNK..).unwrap_or_default();
                ratios.fill(roughness.last().copied().unwrap_or(0.0));
                for (ratio, &given) in ratios.iter_mut().zip(given) {
                    *ratio = given;
                }
                for ratio in &mut ratios {
                    *ratio = rule.ratio(*ratio);
                }
            }
            for ((turned, weight), columns) in noise.octaves.iter().zip(&rows.columns) {
                let places = columns.block(c * CHUNK, CHUNK).on(turned.row(y));
                let state = sums.iter_mut().zip(&mut factors).zip(&ratios);
                for ((cell, at), ((sum, factor), &ratio)) in places.zip(state) {
                    let (s, f) = rule.join(perlin(cell, at), *weight, *sum, *factor, ratio);
                    *sum = s;
                    if R::CARRIES {
                        *factor = f;
                    }
                }
            }
            for (out, sum) in out.iter_mut().zip(&sums) {
                *out = noise.base + noise.amplitude * sum;
            }
        }
    }
}
