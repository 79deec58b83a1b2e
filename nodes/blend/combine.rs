//! Arithmetic of two fields.

use crate::kit::rows::{lerp, zip};
use crate::kit::sample::{finite, fit};
use crate::prelude::*;

/// Puts two fields together, sample by sample: sum, product, higher, lower and their kin.
///
/// `field = a + strength · (mode(a, b) − a)`.
///
/// What comes out has the quantity of `a`; where `a` is a mask and `b` is not, that of `b`. The difference of two
/// heights is a length, the quotient of two fields of one quantity a plain number. Sum, difference, product and
/// power of two masks are masks, cut to 0 to 1.
///
/// # Limits
/// A divisor nearer to zero than 1e-6 counts as 1e-6 of its own sign, so a division by zero gives a large number
/// and not infinity. Results end at ±3e38.
///
/// # See also
/// `mix` goes from one field to another; `remap` brings a field into a range first.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Combine {
    /// What is computed of the two.
    pub mode: Mode,
    /// How much of the result is taken; 0 leaves `a` as it is.
    pub strength: Ratio,
}

/// What [`Combine`] computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The sum, `a + b`.
    #[default]
    Add,
    /// `a − b`.
    Subtract,
    /// `a · b`: a mask scales a field.
    Multiply,
    /// The quotient, `a / b`.
    Divide,
    /// The lower of the two.
    Min,
    /// The higher of the two.
    Max,
    /// The lower of the two, rounded off where they meet.
    SmoothMin {
        /// Difference of the two below which they blend, in their unit.
        #[schemars(range(min = 0.0, max = 1.0e6), extend("x-soft" = [0.0, 200.0]))]
        width: Number,
    },
    /// The higher of the two, rounded off where they meet.
    SmoothMax {
        /// Difference of the two below which they blend, in their unit.
        #[schemars(range(min = 0.0, max = 1.0e6), extend("x-soft" = [0.0, 200.0]))]
        width: Number,
    },
    /// `(a + b) / 2`.
    Average,
    /// `|a − b|`.
    Difference,
    /// `|a|` to the power `b`, with the sign of `a`.
    Power,
}

impl Default for Combine {
    fn default() -> Self {
        Self { mode: Mode::Add, strength: Ratio(1.0) }
    }
}

ports! {
    pub struct Inputs {
        /// First field; with strength 0 the result.
        a: Field,
        /// Second field.
        b: Field,
    }
    pub struct Outputs {
        /// The two together.
        field: Field = Meaning::Chosen,
    }
}

/// Divisors and bases of negative powers are kept this far from zero.
const NEAR_ZERO: f32 = 1e-6;

impl Node for Combine {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().mixes(&[("field", "a")]).keywords(&[
        "add",
        "subtract",
        "multiply",
        "divide",
        "minimum",
        "maximum",
        "union",
        "intersection",
        "blend",
        "math",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, if self.mode == Mode::Power { 40.0 } else { 2.0 })
    }

    fn quantity(&self, _: &str, inputs: Quantities<'_>) -> Quantity {
        let [a, b] = ["a", "b"].map(|port| inputs(port).unwrap_or(Quantity::Number));
        self.quantity_of(a, b)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let quantity = self.quantity_of(input.a.quantity(), input.b.quantity());
        let field = match self.mode {
            Mode::Add => self.apply(cx, &input, quantity, |a, b| a + b),
            Mode::Subtract => self.apply(cx, &input, quantity, |a, b| a - b),
            Mode::Multiply => self.apply(cx, &input, quantity, |a, b| a * b),
            Mode::Divide => self.apply(cx, &input, quantity, |a, b| a / away_from_zero(b)),
            Mode::Min => self.apply(cx, &input, quantity, f32::min),
            Mode::Max => self.apply(cx, &input, quantity, f32::max),
            Mode::SmoothMin { width } => {
                let width = with_quarter(width);
                self.apply(cx, &input, quantity, move |a, b| smooth_min(a, b, width))
            }
            Mode::SmoothMax { width } => {
                let width = with_quarter(width);
                self.apply(cx, &input, quantity, move |a, b| -smooth_min(-a, -b, width))
            }
            Mode::Average => self.apply(cx, &input, quantity, |a, b| a * 0.5 + b * 0.5),
            Mode::Difference => self.apply(cx, &input, quantity, |a, b| (a - b).abs()),
            Mode::Power => self.apply(cx, &input, quantity, signed_power),
        };
        Ok(Outputs { field: field? })
    }
}

impl Combine {
    fn apply(
        &self,
        cx: &Context<'_>,
        input: &Inputs,
        quantity: Quantity,
        f: impl Fn(f32, f32) -> f32 + Sync,
    ) -> Result<Field> {
        let both = [&input.a, &input.b];
        let strength = self.strength.0 as f32;
        let field = match (quantity, self.strength.0) {
            (_, 0.0) => return Ok(input.a.crop(&cx.grid)),
            (Quantity::Mask, _) => zip(&cx.work, &cx.grid, both, quantity, |a, b| {
                fit(Quantity::Mask, lerp(a, finite(f(a, b)), strength))
            }),
            (_, 1.0) => zip(&cx.work, &cx.grid, both, quantity, |a, b| finite(f(a, b))),
            _ => zip(&cx.work, &cx.grid, both, quantity, |a, b| finite(lerp(a, finite(f(a, b)), strength))),
        };
        Ok(field?)
    }

    fn quantity_of(&self, a: Quantity, b: Quantity) -> Quantity {
        match self.mode {
            _ if self.strength.0 == 0.0 => a,
            Mode::Power => a,
            Mode::Divide if a == b => Quantity::Number,
            Mode::Difference if a == Quantity::Elevation && b == a => Quantity::Length,
            _ if a == Quantity::Mask => b,
            _ => a,
        }
    }
}

/// The divisor, kept away from zero on its own side.
#[inline(always)]
fn away_from_zero(b: f32) -> f32 {
    if b < 0.0 { b.min(-NEAR_ZERO) } else { b.max(NEAR_ZERO) }
}

/// The lower of two, a parabola where they differ by less than `width` (Quilez's polynomial smooth minimum);
/// `per_width` is a quarter over it.
#[inline(always)]
fn smooth_min(a: f32, b: f32, [width, per_width]: [f32; 2]) -> f32 {
    let near = (width - (a - b).abs()).max(0.0);
    // A quotient first: the square of a large width has no place in an f32.
    a.min(b) - near * per_width * near
}

/// A width and a quarter over it; over nothing where it is too small to divide by.
fn with_quarter(width: Number) -> [f32; 2] {
    let width = width.0 as f32;
    [width, if width > 1e-30 { 0.25 / width } else { 0.0 }]
}

#[inline(always)]
fn signed_power(a: f32, b: f32) -> f32 {
    let base = if b < 0.0 { a.abs().max(NEAR_ZERO) } else { a.abs() };
    libm::powf(base, b).copysign(a)
}
