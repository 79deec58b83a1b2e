//! A picture as something that has a colour and a mask at any place.

use std::sync::Arc;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::decode::{Picture, Pixels};
use crate::kit::color::{linear_from_srgb, srgb_from_linear};
use crate::work::Work;

/// Which numbers of a picture its mask is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Opacity where the picture has some that is not full, else brightness.
    #[default]
    Auto,
    /// Opacity: 1 where the picture has none.
    Alpha,
    /// Brightness of the numbers in the file: of a grey picture the grey value.
    Luminance,
    /// The red number.
    Red,
    /// The green number.
    Green,
    /// The blue number.
    Blue,
}

/// What runs between the pixels of a picture that is drawn out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kernel {
    /// A cubic curve: smooth, and a little crisper than straight lines.
    #[default]
    Cubic,
    /// Straight lines.
    Linear,
    /// Nothing: each pixel is a patch of one colour, for pictures whose colours are names.
    Nearest,
}

impl Kernel {
    /// The weight of a pixel at some distance, in pixels.
    fn weight(self, distance: f64) -> f64 {
        let x = distance.abs();
        match self {
            // Catmull and Rom 1974.
            Self::Cubic if x < 1.0 => 1.0 + x * x * (1.5 * x - 2.5),
            Self::Cubic if x < 2.0 => 2.0 + x * (-4.0 + x * (2.5 - 0.5 * x)),
            Self::Cubic => 0.0,
            Self::Linear => (1.0 - x).max(0.0),
            Self::Nearest => 0.0,
        }
    }

    fn radius(self) -> f64 {
        match self {
            Self::Cubic => 2.0,
            Self::Linear => 1.0,
            Self::Nearest => 0.0,
        }
    }
}

/// How many pixels a sample stands for, across and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSpan(pub [f64; 2]);

impl PixelSpan {
    /// By how much the picture is made smaller first, across and down: whole numbers, so that what is left to the
    /// kernel is less than two pixels.
    pub fn reduction(&self, kernel: Kernel) -> [u32; 2] {
        if kernel == Kernel::Nearest {
            return [1; 2];
        }
        self.0.map(|f| if f.is_finite() { f.clamp(1.0, 1e9) as u32 } else { 1 })
    }
}

/// Share that the colour of a pixel counts with where it is transparent: enough to tell it where nothing else is near.
const TRANSPARENT: f32 = 1.0 / 1024.0;

/// Red, green and blue as light, times a weight; the weight; the mask.
type Texel = [f32; 5];

/// A picture made smaller by whole numbers, with its mask.
#[derive(Debug)]
pub struct Texture {
    /// Pixels of the picture.
    size: [usize; 2],
    /// Pixels that one texel stands for.
    reduction: [u32; 2],
    /// Texels.
    cols: usize,
    rows: usize,
    texels: Texels,
}

/// The texels of a texture.
#[derive(Debug)]
enum Texels {
    /// Those of a picture that is not made smaller are made anew each time: they take five times its memory.
    OfPixels(Reader),
    Kept(Vec<Texel>),
}

/// The texels that a position mixes along a line, and their shares.
#[derive(Clone, Debug)]
struct Taps {
    first: i64,
    weights: Vec<f32>,
}

/// Columns of a window that stands upright on the picture, prepared once for all rows.
#[derive(Debug)]
pub struct TextureColumns {
    taps: Vec<Taps>,
    from: i64,
    to: i64,
}

impl Texture {
    /// The picture made smaller by whole numbers; unfinished where the work was asked to stop.
    pub fn new(picture: &Arc<Picture>, mask: Channel, reduction: [u32; 2], work: &Work<'_>) -> Self {
        let size = [picture.cols, picture.rows];
        // A picture has no more texels than pixels, and one at least.
        let reduction = [0, 1].map(|k| reduction[k].clamp(1, size[k].max(1) as u32));
        let [cols, rows] = [0, 1].map(|k| size[k].div_ceil(reduction[k] as usize));
        let reader = Reader::new(picture.clone(), mask);
        if reduction == [1; 2] {
            return Self { size, reduction, cols, rows, texels: Texels::OfPixels(reader) };
        }
        let mut texels = vec![Texel::default(); cols * rows];
        let [kx, ky] = reduction.map(|k| k as usize);
        texels.par_chunks_mut(cols.max(1)).enumerate().for_each(|(j, out)| {
            if work.is_cancelled() {
                return;
            }
            let share = 1.0 / (kx as f32 * ky as f32);
            for (i, texel) in out.iter_mut().enumerate() {
                // At the border the picture is mirrored, so that every texel stands for as much.
                for y in 0..ky {
                    let line = mirrored(j * ky + y, size[1]) * size[0];
                    for x in 0..kx {
                        let one = reader.texel(line + mirrored(i * kx + x, size[0]));
                        texel.iter_mut().zip(one).for_each(|(sum, v)| *sum += v);
                    }
                }
                texel.iter_mut().for_each(|v| *v *= share);
            }
        });
        Self { size, reduction, cols, rows, texels: Texels::Kept(texels) }
    }

    /// Bytes that the texture of a picture of some size takes.
    pub fn bytes(cols: u64, rows: u64, reduction: [u32; 2]) -> u64 {
        if reduction == [1; 2] {
            return TABLE_BYTES;
        }
        let part = |n: u64, k: u32| n.div_ceil(u64::from(k.max(1)));
        let texels = part(cols, reduction[0]).saturating_mul(part(rows, reduction[1]));
        texels.saturating_mul(size_of::<Texel>() as u64).saturating_add(TABLE_BYTES)
    }

    /// The taps of a position in pixels from the middle of the first one.
    fn taps(&self, axis: usize, position: f64, footprint: PixelSpan, kernel: Kernel) -> Taps {
        let last = (self.size[axis].max(1) - 1) as f64;
        let k = f64::from(self.reduction[axis]);
        let position = if position.is_finite() { position.clamp(0.0, last) } else { 0.0 };
        let p = (position + 0.5) / k - 0.5;
        if kernel == Kernel::Nearest {
            return Taps { first: (p + 0.5).floor() as i64, weights: vec![1.0] };
        }
        let scale = (footprint.0[axis] / k).clamp(1.0, 2.0);
        let radius = kernel.radius() * scale;
        let first = (p - radius).ceil() as i64;
        let count = ((p + radius).floor() as i64 - first + 1).max(1);
        let weights: Vec<f64> =
            (first..first + count).map(|i| kernel.weight((i as f64 - p) / scale)).collect();
        let sum: f64 = weights.iter().sum();
        Taps { first, weights: weights.into_iter().map(|w| (w / sum) as f32).collect() }
    }

    /// A texel; beyond the border its column and row go on.
    fn texel(&self, i: i64, j: i64) -> Texel {
        let (i, j) = (i.clamp(0, self.cols as i64 - 1), j.clamp(0, self.rows as i64 - 1));
        let k = j as usize * self.cols + i as usize;
        match &self.texels {
            Texels::OfPixels(reader) => reader.texel(k),
            Texels::Kept(texels) => texels[k],
        }
    }

    /// Prepares the columns of a window at positions in pixels from the middle of the westernmost one.
    pub fn columns(
        &self,
        positions: impl Iterator<Item = f64>,
        footprint: PixelSpan,
        kernel: Kernel,
    ) -> TextureColumns {
        let taps: Vec<Taps> = positions.map(|p| self.taps(0, p, footprint, kernel)).collect();
        let reach =
            |(from, to): (i64, i64), t: &Taps| (from.min(t.first), to.max(t.first + t.weights.len() as i64));
        let (from, to) = taps.iter().fold((i64::MAX, i64::MIN), reach);
        TextureColumns { taps, from, to: to.max(from) }
    }

    /// What lies at some columns at one position down the rows; beyond the border its pixels go on.
    pub fn row<T>(
        &self,
        columns: &TextureColumns,
        v: f64,
        footprint: PixelSpan,
        kernel: Kernel,
        out: &mut [T],
        of: impl Fn(&Mixture<'_>) -> T,
    ) {
        let y = self.taps(1, v, footprint, kernel);
        let width = usize::try_from(columns.to.saturating_sub(columns.from)).unwrap_or(0);
        let mut line = vec![Texel::default(); width];
        for (j, weight) in (y.first..).zip(&y.weights) {
            for (sum, i) in line.iter_mut().zip(columns.from..) {
                sum.iter_mut().zip(self.texel(i, j)).for_each(|(s, t)| *s += t * weight);
            }
        }
        for (o, taps) in out.iter_mut().zip(&columns.taps) {
            let part = &line[(taps.first - columns.from) as usize..][..taps.weights.len()];
            *o = of(&Mixture { sum: mix(part, &taps.weights), texture: self, taps: [taps, &y] });
        }
    }

    /// What lies at a position in pixels from the middle of the north-west one.
    pub fn at<T>(
        &self,
        [u, v]: [f64; 2],
        footprint: PixelSpan,
        kernel: Kernel,
        of: impl Fn(&Mixture<'_>) -> T,
    ) -> T {
        let (x, y) = (self.taps(0, u, footprint, kernel), self.taps(1, v, footprint, kernel));
        let mut sum = Texel::default();
        // First down, then across, as `row` does.
        for (i, weight) in (x.first..).zip(&x.weights) {
            let mut column = Texel::default();
            for (j, weight) in (y.first..).zip(&y.weights) {
                column.iter_mut().zip(self.texel(i, j)).for_each(|(s, t)| *s += t * weight);
            }
            sum.iter_mut().zip(column).for_each(|(s, t)| *s += t * weight);
        }
        of(&Mixture { sum, texture: self, taps: [&x, &y] })
    }
}

/// What lies at a place: pixels, mixed.
#[derive(Debug)]
pub struct Mixture<'a> {
    sum: Texel,
    texture: &'a Texture,
    taps: [&'a Taps; 2],
}

impl Mixture<'_> {
    /// The colour, sRGB encoded.
    pub fn color(&self) -> [f32; 3] {
        let [r, g, b, weight, _] = self.sum;
        if weight >= TRANSPARENT / 2.0 {
            return [r, g, b].map(|light| srgb_from_linear(light / weight));
        }
        // Negative shares of the cubic kernel left nothing: what is transparent has the colour of the pixel there.
        let [i, j] = self.taps.map(|t| t.first + t.weights.len() as i64 / 2);
        let [r, g, b, weight, _] = self.texture.texel(i, j);
        [r, g, b].map(|light| srgb_from_linear(light / weight.max(TRANSPARENT)))
    }

    /// The mask.
    pub fn mask(&self) -> f32 {
        self.sum[4].clamp(0.0, 1.0)
    }
}

/// An index in a line of `n`, or as far inside its end as it lies beyond.
fn mirrored(i: usize, n: usize) -> usize {
    if i < n { i } else { (2 * (n - 1)).saturating_sub(i) }
}

fn mix(part: &[Texel], weights: &[f32]) -> Texel {
    let mut sum = Texel::default();
    for (texel, weight) in part.iter().zip(weights) {
        sum.iter_mut().zip(texel).for_each(|(s, t)| *s += t * weight);
    }
    sum
}

/// Bytes of the longest table of light.
const TABLE_BYTES: u64 = 4 << 16;

/// Makes texels of pixels.
#[derive(Debug)]
struct Reader {
    picture: Arc<Picture>,
    mask: Channel,
    /// Light by the number in the file.
    light: Vec<f32>,
}

impl Reader {
    fn new(picture: Arc<Picture>, mask: Channel) -> Self {
        let levels: usize = match &picture.pixels {
            Pixels::Eight(_) => 255,
            Pixels::Sixteen(_) => 65535,
        };
        let light = (0..=levels).map(|v| linear_from_srgb((v as f64 / levels as f64) as f32)).collect();
        let mask = match mask {
            Channel::Auto if picture.has_alpha => Channel::Alpha,
            Channel::Auto => Channel::Luminance,
            other => other,
        };
        Self { picture, mask, light }
    }

    fn texel(&self, k: usize) -> Texel {
        let (levels, pixel) = match &self.picture.pixels {
            Pixels::Eight(p) => (255.0, p[k].map(u16::from)),
            Pixels::Sixteen(p) => (65535.0, p[k]),
        };
        let [r, g, b, alpha] = pixel.map(|v| f32::from(v) / levels);
        let weight = alpha.max(TRANSPARENT);
        let light = |c: usize| self.light[usize::from(pixel[c])] * weight;
        let mask = match self.mask {
            Channel::Auto | Channel::Alpha => alpha,
            Channel::Red => r,
            Channel::Green => g,
            Channel::Blue => b,
            // Of grey the very number, not the sum of its shares.
            Channel::Luminance if r == g && g == b => r,
            // Shares of ITU-R BT.709.
            Channel::Luminance => 0.2126 * r + 0.7152 * g + 0.0722 * b,
        };
        [light(0), light(1), light(2), weight, mask]
    }
}
