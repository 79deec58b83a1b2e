//! A mask of the curvatures in a range.

use crate::kit::derivative::{self, Derivative, Gradient, Second};
use crate::kit::math::Band;
use crate::prelude::*;

/// Selects the places whose curvature lies in a range: ridges and bulges are positive, hollows and valleys negative.
///
/// With the first derivatives `p, q` and the second `r, s, t` of the height, taken from the heights `scale` metres
/// to either side and at the corners \[zevenbergen1987\], the curvatures in 1/m are \[evans1980\] \[krcho1973\]
/// - mean: `−((1 + q²) r − 2pqs + (1 + p²) t) / (2 (1 + p² + q²)^1.5)`,
/// - profile: `−(p² r + 2pqs + q² t) / ((p² + q²) (1 + p² + q²)^1.5)`,
/// - tangential: `−(q² r − 2pqs + p² t) / ((p² + q²) (1 + p² + q²)^0.5)`,
/// - plan: `−(q² r − 2pqs + p² t) / (p² + q²)^1.5`.
///
/// A sphere of radius R has mean, profile and tangential curvature 1/R everywhere. The mask is 1 from `low` to
/// `high` and fades to 0 over `soft` beyond either.
///
/// # Limits
/// Where the ground is flat there is no direction of slope: profile and tangential curvature take the value of the
/// mean there, and plan curvature is 0; near by, plan curvature grows without bound.
/// The scale that takes effect is at least one cell of the build, or of the base grid where the build is coarser.
///
/// # See also
/// `select_slope`; `blur` for forms larger than a few cells.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SelectCurvature {
    /// Which curvature.
    pub form: Form,
    /// Lowest curvature that is selected whole.
    #[schemars(range(min = -10.0, max = 10.0), extend("x-soft" = [-0.02, 0.02]))]
    pub low: PerMetre,
    /// Highest curvature that is selected whole.
    #[schemars(range(min = -10.0, max = 10.0), extend("x-soft" = [-0.02, 0.02]))]
    pub high: PerMetre,
    /// Curvature over which the mask fades out beyond the range.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-soft" = [0.0, 0.02]))]
    pub soft: PerMetre,
    /// Distance to either side over which the curvature is taken; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub scale: Option<Metres>,
}

/// A curvature of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// The mean over all directions: ridges and peaks against valleys and pits.
    #[default]
    Mean,
    /// Along the line of steepest descent: where slopes ease or steepen.
    Profile,
    /// Across the line of steepest descent: spurs against gullies.
    Tangential,
    /// Of the contour line on the map: as tangential, stronger the flatter the ground.
    Plan,
}

impl Default for SelectCurvature {
    fn default() -> Self {
        Self {
            form: Form::Mean,
            low: PerMetre(0.004),
            high: PerMetre(10.0),
            soft: PerMetre(0.004),
            scale: None,
        }
    }
}

ports! {
    pub struct Inputs {
        /// Heights whose curvature is taken.
        height: Field,
    }
    pub struct Outputs {
        /// How far each place is selected, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// The curvature in 1/m: positive on ridges, negative in hollows.
        curvature: Field = Meaning::Fixed(Quantity::Curvature),
    }
}

impl Node for SelectCurvature {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zevenbergen1987", "evans1980", "krcho1973"])
        .keywords(&["mask", "convex", "concave", "ridge", "valley", "cavity", "profile", "plan"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        derivative::reach(self.scale)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        derivative::footprint(window, self.scale, terrain.base_cell())
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        derivative::cost(grid, 25.0, 14)
    }

    fn check(&self) -> Result<()> {
        super::select_slope::ordered(self.low.0, self.high.0, "1/m")
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let scale = cx.scale(self.scale)?;
        let derivative = Derivative::new("height", &input.height, &cx.grid, scale)?;
        let curvature = cx.stage(0.0, 0.8).fill(Quantity::Curvature, |row, out| {
            let (first, second) = (derivative.gradient(row.j), derivative.second(row.j));
            match self.form {
                Form::Mean => bend(&first, &second, out, mean),
                Form::Profile => bend(&first, &second, out, profile),
                Form::Tangential => bend(&first, &second, out, tangential),
                Form::Plan => bend(&first, &second, out, plan),
            }
        })?;
        let band = Band::new(self.low.0, self.high.0, self.soft.0);
        let mask = cx.stage(0.8, 1.0).map(&curvature, Quantity::Mask, |c| band.weight(c))?;
        Ok(Outputs { mask, curvature })
    }
}

/// Fills a row with one of the forms.
fn bend(first: &Gradient, second: &Second, out: &mut [f32], form: impl Fn([f32; 2], [f32; 3]) -> f32) {
    let slopes = first.x.iter().zip(&first.y);
    let bends = second.xx.iter().zip(&second.xy).zip(&second.yy);
    for (o, ((&p, &q), ((&r, &s), &t))) in out.iter_mut().zip(slopes.zip(bends)) {
        *o = form([p, q], [r, s, t]);
    }
}

fn mean([p, q]: [f32; 2], [r, s, t]: [f32; 3]) -> f32 {
    let w = 1.0 + p * p + q * q;
    -((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * w * w.sqrt())
}

fn profile([p, q]: [f32; 2], bends @ [r, s, t]: [f32; 3]) -> f32 {
    let g = p * p + q * q;
    let w = 1.0 + g;
    let along = -(p * p * r + 2.0 * p * q * s + q * q * t) / (g * w * w.sqrt());
    if g > FLAT { along } else { mean([p, q], bends) }
}

fn tangential([p, q]: [f32; 2], bends @ [r, s, t]: [f32; 3]) -> f32 {
    let g = p * p + q * q;
    let across = -(q * q * r - 2.0 * p * q * s + p * p * t) / (g * (1.0 + g).sqrt());
    if g > FLAT { across } else { mean([p, q], bends) }
}

fn plan([p, q]: [f32; 2], [r, s, t]: [f32; 3]) -> f32 {
    let g = p * p + q * q;
    let across = -(q * q * r - 2.0 * p * q * s + p * p * t) / (g * g.sqrt());
    if g > FLAT { across } else { 0.0 }
}

/// Squared slope below which the direction of slope is rounding noise and products of it may underflow.
const FLAT: f32 = 1e-20;
