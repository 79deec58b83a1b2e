//! Colour ramps: from a number between 0 and 1 to a colour.
//!
//! Ramps run through Oklab \[ottosson2020\], so that the colours between two stops are neither muddy nor banded, and
//! give sRGB-encoded colours, as a picture file holds them.

mod bulk;

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::color::{oklab_from_srgb, srgb_from_oklab};
use crate::units::Ratio;
use crate::widget::Widget;

/// A built-in ramp, or stops of one's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Palette {
    /// Green lowland through straw and brown to white, as a wall map tints heights.
    #[default]
    Hypsometric,
    /// Forest, meadow, bare rock and snow, as a satellite sees a humid range.
    Alpine,
    /// Ground cover by height and slope; without a slope the ground counts as gently sloped.
    Satellite,
    /// Pale sand, ochre and red rock.
    Desert,
    /// Cold rock under ice and snow.
    Arctic,
    /// Basalt, cinder, rust and ash.
    Volcanic,
    /// Deep to shallow water.
    Ocean,
    /// Black to white, in equal steps of the stored value.
    Grey,
    /// Perceptually even violet, green and yellow, for data.
    Viridis,
    /// Blue, white and red: for what has a middle.
    Diverging,
    /// Stops of one's own.
    Custom {
        /// Position and red, green and blue of each stop, all from 0 to 1, the colours sRGB encoded: 255 of a paint
        /// program is 1 here. Two at one position make a hard edge.
        #[schemars(
            length(min = 1, max = 64),
            extend(
                "x-widget" = Widget::Gradient,
                "x-items" = ["position", "red", "green", "blue"],
                "examples" = [[[0.0, 0.1, 0.3, 0.1], [0.6, 0.55, 0.5, 0.45], [1.0, 1.0, 1.0, 1.0]]],
            )
        )]
        stops: Vec<[Ratio; 4]>,
    },
}

impl Palette {
    /// Every built-in ramp with its name in graph files.
    pub const BUILTIN: [(&'static str, Self); 10] = [
        ("hypsometric", Self::Hypsometric),
        ("alpine", Self::Alpine),
        ("satellite", Self::Satellite),
        ("desert", Self::Desert),
        ("arctic", Self::Arctic),
        ("volcanic", Self::Volcanic),
        ("ocean", Self::Ocean),
        ("grey", Self::Grey),
        ("viridis", Self::Viridis),
        ("diverging", Self::Diverging),
    ];

    /// The stops: position and sRGB colour.
    pub fn stops(&self) -> Vec<Stop> {
        let fixed: &[(f32, u32)] = match self {
            Self::Hypsometric => &HYPSOMETRIC,
            Self::Alpine => &ALPINE,
            Self::Desert => &DESERT,
            Self::Arctic => &ARCTIC,
            Self::Volcanic => &VOLCANIC,
            Self::Ocean => &OCEAN,
            Self::Diverging => &DIVERGING,
            Self::Grey => return sampled(|t| [t; 3]),
            Self::Viridis => return sampled(viridis),
            Self::Satellite => return sampled(|t| satellite(t, GENTLE)),
            Self::Custom { stops } => return stops.iter().map(Stop::of).collect(),
        };
        fixed.iter().map(|&(at, hex)| Stop { at, color: srgb_from_hex(hex) }).collect()
    }
}

/// A colour at a place of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Where, from 0 to 1.
    pub at: f32,
    /// Red, green and blue from 0 to 1, sRGB encoded.
    pub color: [f32; 3],
}

impl Stop {
    fn of([at, r, g, b]: &[Ratio; 4]) -> Self {
        Self { at: at.0 as f32, color: [r.0 as f32, g.0 as f32, b.0 as f32] }
    }
}

/// How colours pass from stop to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Blend {
    /// Along a monotone curve without kinks, so that no stop shows as a line.
    #[default]
    Smooth,
    /// In straight lines.
    Linear,
    /// Not at all: each stop's colour holds up to the next.
    Steps,
}

/// Table steps between two stops: far below what an eye or 8 bits can tell.
const STEPS: usize = 64;

/// Entries of the table for a piece: the last is its end.
const PIECE: usize = STEPS + 1;

/// A ramp made ready: colours between stops are read from a table.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// Where each piece of the ramp starts, rising, the first at 0 or before; and one over its length.
    pieces: Vec<(f32, f32)>,
    /// The steps of each piece, and one for the colour at and above the last stop.
    table: Vec<Step>,
}

/// A colour, and what the next has more.
#[derive(Clone, Copy, Debug)]
struct Step {
    color: [f32; 3],
    rise: [f32; 3],
}

impl Ramp {
    /// The built-in ramp of a name; `None` when there is none.
    pub fn builtin(name: &str) -> Option<Self> {
        let (_, palette) = Palette::BUILTIN.iter().find(|(known, _)| *known == name)?;
        Some(Self::of(palette, Blend::Smooth))
    }

    /// The ramp of a palette.
    pub fn of(palette: &Palette, blend: Blend) -> Self {
        match palette {
            Palette::Grey if blend != Blend::Steps => Self::follow(|t| [t; 3]),
            Palette::Viridis if blend != Blend::Steps => Self::follow(viridis),
            Palette::Satellite if blend != Blend::Steps => Self::follow(|t| satellite(t, GENTLE)),
            _ => Self::new(palette.stops(), blend),
        }
    }

    /// A ramp that follows a function instead of stops.
    fn follow(function: impl Fn(f32) -> [f32; 3]) -> Self {
        let mut ramp = Self { pieces: Vec::new(), table: Vec::new() };
        ramp.push(0.0, 1.0, &function);
        ramp.finish(function(1.0))
    }

    /// A ramp through stops, in any order; black when there is none.
    ///
    /// Below the first stop and above the last their colours continue.
    pub fn new(mut stops: Vec<Stop>, blend: Blend) -> Self {
        stops.sort_by(|a, b| a.at.total_cmp(&b.at));
        let mut ramp = Self { pieces: Vec::new(), table: Vec::new() };
        let Some((first, last)) = stops.first().zip(stops.last()) else { return ramp.finish([0.0; 3]) };
        if first.at > 0.0 {
            ramp.push(0.0, first.at, |_| first.color);
        }
        // A run of stops without a hard edge is one curve.
        for run in stops.chunk_by(|a, b| a.at < b.at) {
            let labs: Vec<_> = run.iter().map(|s| oklab_from_srgb(s.color)).collect();
            let slopes = tangents(run, &labs);
            for (i, pair) in run.windows(2).enumerate() {
                let width = pair[1].at - pair[0].at;
                ramp.push(pair[0].at, width, |u| match blend {
                    Blend::Steps => pair[0].color,
                    Blend::Linear => srgb_from_oklab(mix(labs[i], labs[i + 1], u)),
                    Blend::Smooth => {
                        let hermite = |k: usize| {
                            let tangent = [slopes[i][k] * width, slopes[i + 1][k] * width];
                            hermite([labs[i][k], labs[i + 1][k]], tangent, u)
                        };
                        srgb_from_oklab([hermite(0), hermite(1), hermite(2)])
                    }
                });
            }
        }
        ramp.finish(last.color)
    }

    fn push(&mut self, start: f32, width: f32, color: impl Fn(f32) -> [f32; 3]) {
        self.pieces.push((start, 1.0 / width));
        let colors: Vec<_> = (0..PIECE).map(|k| color(k as f32 / STEPS as f32)).collect();
        let next = colors.iter().skip(1).chain(colors.last());
        self.table.extend(colors.iter().zip(next).map(|(&color, next)| Step {
            // A sum with 0 turns −0 into 0, which a step of no length would.
            color: color.map(|v| v + 0.0),
            rise: [next[0] - color[0], next[1] - color[1], next[2] - color[2]],
        }));
    }

    /// Ends a ramp with the colour at and above its last stop, and gives it a piece where it has none.
    fn finish(mut self, last: [f32; 3]) -> Self {
        if self.pieces.is_empty() {
            self.push(0.0, 1.0, |_| last);
        }
        self.table.push(Step { color: last.map(|v| v + 0.0), rise: [0.0; 3] });
        self
    }

    /// The colour at `t`, sRGB encoded, from 0 to 1; `t` is clipped to 0 to 1, NaN counts as 0.
    pub fn color(&self, t: f32) -> [f32; 3] {
        let (mut at, mut step) = ([t], [0]);
        self.find(&mut at, &mut step);
        let (Step { color, rise }, share) = (&self.table[step[0] as usize], at[0]);
        [0, 1, 2].map(|k| color[k] + rise[k] * share)
    }
}

/// Slope, in degrees, of ground of which nothing else is known.
const GENTLE: f32 = 12.0;

/// The colour of natural ground by height and slope, as a satellite sees a temperate range: fields and forest,
/// meadows, rock where it is steep, scree, and snow where it is high and not too steep. sRGB encoded.
///
/// `height_share` runs from 0 in the valleys to 1 on the summits, `slope_degrees` from 0 to 90; both are clipped.
/// Adding a little noise to either breaks the bands up as vegetation does.
pub fn satellite(height_share: f32, slope_degrees: f32) -> [f32; 3] {
    const ROWS: usize = 181;
    const COLS: usize = 257;
    static TABLE: LazyLock<Vec<[f32; 3]>> = LazyLock::new(|| {
        let ground = |i: usize| {
            let (row, col) = (i / COLS, i % COLS);
            ground(col as f32 / (COLS - 1) as f32, row as f32 / (ROWS - 1) as f32 * 90.0)
        };
        (0..ROWS * COLS).map(ground).collect()
    });
    let place = |share: f32, count: usize| {
        let at = if share > 0.0 { share.min(1.0) } else { 0.0 } * (count - 1) as f32;
        let k = (at as usize).min(count - 2);
        (k, at - k as f32)
    };
    let (row, v) = place(slope_degrees / 90.0, ROWS);
    let (col, u) = place(height_share, COLS);
    let at = row * COLS + col;
    let north = mix(TABLE[at], TABLE[at + 1], u);
    mix(north, mix(TABLE[at + COLS], TABLE[at + COLS + 1], u), v)
}

/// What [`satellite`] tabulates.
fn ground(height: f32, slope: f32) -> [f32; 3] {
    let lab = |hex| oklab_from_srgb(srgb_from_hex(hex));
    let rise = |lo: f32, hi: f32, x: f32| {
        let u = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
        u * u * (3.0 - 2.0 * u)
    };
    let (plain, forest, meadow, heath) = (lab(0x7b8452), lab(0x43562f), lab(0x707448), lab(0x86795a));
    let (rock, pale_rock, scree, snow) = (lab(0x6a625a), lab(0x8d877f), lab(0x9b9183), lab(0xf4f6f9));
    // Green by height: fields where it is low and flat, forest, alpine meadow, then heath and scree.
    let flat = 1.0 - rise(3.0, 12.0, slope);
    let mut color = mix(forest, plain, flat * (1.0 - rise(0.08, 0.24, height)));
    color = mix(color, meadow, rise(0.30, 0.50, height));
    color = mix(color, heath, rise(0.46, 0.62, height));
    color = mix(color, scree, rise(0.58, 0.74, height));
    // Soil holds on gentler slopes only, the higher the thinner.
    let hold = 34.0 - 12.0 * rise(0.25, 0.85, height);
    let stone = mix(rock, pale_rock, rise(0.35, 0.85, height));
    color = mix(color, stone, rise(hold - 6.0, hold + 9.0, slope));
    // Snow needs height and slides off walls; high flats keep it lower down.
    let line = 0.74 + 0.10 * rise(20.0, 45.0, slope);
    let snowed = rise(line - 0.07, line + 0.07, height) * (1.0 - rise(42.0, 60.0, slope));
    srgb_from_oklab(mix(color, snow, snowed))
}

/// Sixteen even pieces of a function.
fn sampled(f: impl Fn(f32) -> [f32; 3]) -> Vec<Stop> {
    (0..=16).map(|i| i as f32 / 16.0).map(|at| Stop { at, color: f(at) }).collect()
}

/// Matplotlib's viridis as a polynomial of degree 6 in each channel \[zucker2019\].
fn viridis(t: f32) -> [f32; 3] {
    const C: [[f32; 3]; 7] = [
        [0.277_727_33, 0.005_407_344_6, 0.334_099_8],
        [0.105_093_04, 1.404_613_5, 1.384_590_2],
        [-0.330_861_84, 0.214_847_56, 0.095_095_16],
        [-4.634_230_6, -5.799_101, -19.332_441],
        [6.228_27, 14.179_933, 56.690_55],
        [4.776_385, -13.745_145, -65.353_03],
        [-5.435_456, 4.645_852_6, 26.312_435],
    ];
    let channel = |k: usize| C.iter().rev().fold(0.0, |sum, c| sum * t + c[k]).clamp(0.0, 1.0);
    [channel(0), channel(1), channel(2)]
}

#[inline(always)]
fn mix(a: [f32; 3], b: [f32; 3], u: f32) -> [f32; 3] {
    [a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * u, a[2] + (b[2] - a[2]) * u]
}

/// The cubic with given values and derivatives at 0 and 1.
fn hermite(value: [f32; 2], tangent: [f32; 2], u: f32) -> f32 {
    let rise = value[1] - value[0];
    let c = 3.0 * rise - 2.0 * tangent[0] - tangent[1];
    let d = tangent[0] + tangent[1] - 2.0 * rise;
    value[0] + u * (tangent[0] + u * (c + u * d))
}

/// Derivatives at the stops that make a curve without kinks and without overshoot \[fritsch1980\]: the harmonic
/// mean of the slopes beside a stop, 0 at a turning point.
fn tangents(stops: &[Stop], labs: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let secant = |i: usize, k: usize| (labs[i + 1][k] - labs[i][k]) / (stops[i + 1].at - stops[i].at);
    let last = stops.len() - 1;
    let tangent = |i: usize, k: usize| match (i.checked_sub(1), i < last) {
        (None, false) => 0.0,
        (None, true) => secant(i, k),
        (Some(before), false) => secant(before, k),
        (Some(before), true) => {
            let (a, b) = (secant(before, k), secant(i, k));
            if a * b <= 0.0 { 0.0 } else { 2.0 * a * b / (a + b) }
        }
    };
    (0..=last).map(|i| [tangent(i, 0), tangent(i, 1), tangent(i, 2)]).collect()
}

fn srgb_from_hex(hex: u32) -> [f32; 3] {
    [16, 8, 0].map(|shift| f32::from((hex >> shift) as u8) / 255.0)
}

const HYPSOMETRIC: [(f32, u32); 8] = [
    (0.00, 0x5c8f6c),
    (0.12, 0x86a978),
    (0.27, 0xbcc78f),
    (0.43, 0xe4dcab),
    (0.58, 0xd6b889),
    (0.74, 0xb38a68),
    (0.88, 0xbfada2),
    (1.00, 0xfaf8f5),
];

const ALPINE: [(f32, u32); 8] = [
    (0.00, 0x3b4d2a),
    (0.18, 0x44582f),
    (0.36, 0x6d7744),
    (0.50, 0x8b8260),
    (0.64, 0x7f766b),
    (0.78, 0x9c9690),
    (0.86, 0xdde1e6),
    (1.00, 0xfbfcfe),
];

const DESERT: [(f32, u32); 7] = [
    (0.00, 0xecd9b0),
    (0.20, 0xe0bd85),
    (0.40, 0xcb935c),
    (0.58, 0xae6743),
    (0.74, 0x8a4b38),
    (0.88, 0xa8755a),
    (1.00, 0xe2c7a8),
];

const ARCTIC: [(f32, u32); 6] = [
    (0.00, 0x2a3a44),
    (0.20, 0x51656f),
    (0.40, 0x8ea5b1),
    (0.60, 0xc3d4dd),
    (0.80, 0xe6eff4),
    (1.00, 0xffffff),
];

const VOLCANIC: [(f32, u32); 7] = [
    (0.00, 0x1a1b1f),
    (0.22, 0x2d2b2d),
    (0.42, 0x4b3b36),
    (0.60, 0x7a4636),
    (0.76, 0xa46a4a),
    (0.88, 0xb79d86),
    (1.00, 0xdfd9d1),
];

const OCEAN: [(f32, u32); 6] = [
    (0.00, 0x0b1d3a),
    (0.30, 0x143f6b),
    (0.58, 0x1f6f9b),
    (0.80, 0x4aa3b8),
    (0.93, 0x8fd0c9),
    (1.00, 0xcdebd9),
];

const DIVERGING: [(f32, u32); 7] = [
    (0.00, 0x153e73),
    (0.18, 0x2f74b0),
    (0.36, 0x9cc4dd),
    (0.50, 0xf5f3ef),
    (0.64, 0xefb89a),
    (0.82, 0xc4553f),
    (1.00, 0x7a1523),
];

#[cfg(test)]
mod tests;
