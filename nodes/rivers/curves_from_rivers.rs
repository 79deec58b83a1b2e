//! Feature curves along rivers.

use crate::kit::paint::thinned;
use crate::prelude::*;
use crate::value::curves::{ConstraintPoint, Curve, Elevation, Envelope, MAX_POINTS, Rise, Slope, smooth};
use crate::value::rivers::RiverVertex;

/// Makes feature curves of rivers: each river is a curve from its source to where it joins another or ends, at the height
/// of its bed.
///
/// At a confluence the river of the higher order goes on, of those the one that drains more land, and the other ends in it.
/// Points along the way are left out where the line stays within `tolerance` of them \[douglas1973\]; through the others
/// goes a smooth curve. Its plateau is as wide as the river; with `banks` the ground rises from there at an angle that
/// fades to nothing over an extent, as the short forms of curves do \[hnaidi2010\].
///
/// # Limits
/// Rivers of more than 4000 points become several curves, one beginning where the other ends.
///
/// # See also
/// `curve_raster` and `diffuse` make land of them.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CurvesFromRivers {
    /// Least Strahler order of the rivers that become curves.
    #[schemars(range(min = 1, max = 32), extend("x-unit" = "1", "x-soft" = [1, 6]))]
    pub least_order: u32,
    /// How far the curve may lie from the line of the river.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 50.0]))]
    pub tolerance: Metres,
    /// The ground beside the rivers.
    pub banks: Banks,
}

/// The ground beside a river.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Banks {
    /// The curves say nothing about it.
    #[default]
    Unset,
    /// It rises on both sides.
    Rising {
        /// How far it rises from the edge of the river.
        #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 500.0]))]
        extent: Metres,
        /// Its angle at the edge of the river.
        #[schemars(range(min = 0.0, max = 80.0))]
        angle: Degrees,
        /// How far beyond that it is smoothed into other land.
        #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 500.0]))]
        blend: Metres,
    },
}

impl Default for CurvesFromRivers {
    fn default() -> Self {
        Self { least_order: 1, tolerance: Metres(5.0), banks: Banks::Unset }
    }
}

ports! {
    pub struct Inputs {
        /// The network.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// A curve for each river.
        curves: Curves,
    }
}

impl Node for CurvesFromRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["hnaidi2010", "douglas1973"]).keywords(&[
        "feature curves",
        "spline",
        "stream",
        "convert",
        "trace",
    ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let vertices = load.object::<Rivers>("rivers").map_or(0, |rivers| rivers.len()) as u64;
        // Lists of rivers, and of curves some hundred bytes a point.
        Cost { bytes: (1 << 20) + 400 * vertices, seconds: 1e-5 + vertices as f64 * 1e-6 }
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers }: Inputs) -> Result<Outputs> {
        let vertices = rivers.vertices();
        let tributaries = rivers.tributaries();
        let counts = |&i: &usize| u32::from(vertices[i].order) >= self.least_order;
        let main = |i: usize| tributaries.main(i, vertices).filter(counts);
        let mut curves = Vec::new();
        for mouth in (0..vertices.len()).filter(counts) {
            if mouth % 1024 == 0 {
                cx.work.step(mouth as f32 / vertices.len() as f32)?;
            }
            if rivers.down(mouth).is_some_and(|down| main(down) == Some(mouth)) {
                continue;
            }
            let mut way: Vec<usize> = std::iter::successors(Some(mouth), |&i| main(i)).collect();
            way.reverse();
            way.extend(rivers.down(mouth));
            self.along(&way.iter().map(|&i| vertices[i]).collect::<Vec<_>>(), curves.len(), &mut curves)?;
        }
        Ok(Outputs { curves: Curves::new(curves).map_err(Error::of_curves)? })
    }
}

impl CurvesFromRivers {
    /// Adds the curves along the vertices of a river, from the source down.
    fn along(
        &self,
        river: &[RiverVertex],
        number: usize,
        curves: &mut Vec<std::sync::Arc<Curve>>,
    ) -> Result<()> {
        let places: Vec<[f64; 2]> = river.iter().map(|vertex| vertex.at).collect();
        let kept = thinned(&places, self.tolerance.0);
        // Of the vertices at the kept places, in order; a place that repeats the one before is left out.
        let mut next = river.iter();
        let mut line: Vec<&RiverVertex> = kept.iter().filter_map(|at| next.find(|v| v.at == *at)).collect();
        line.dedup_by_key(|vertex| vertex.at);
        for part in Parts(&line) {
            let points: Vec<[f64; 2]> = part.iter().map(|vertex| vertex.at).collect();
            let fault = |e: crate::value::curves::Fault| Error::Input {
                port: "rivers".into(),
                message: format!("river {number} makes no curve: it {e}"),
            };
            let knots = smooth::through(&points).map_err(fault)?;
            let curve =
                Curve::new("", knots.clone(), &self.points(part, &knots), Rise::Monotone).map_err(fault)?;
            curves.push(curve.into());
        }
        Ok(())
    }

    fn points(&self, line: &[&RiverVertex], knots: &[[f64; 2]]) -> Vec<ConstraintPoint> {
        let shares = crate::value::curves::bezier::shares(knots);
        let mut points: Vec<ConstraintPoint> = Vec::new();
        for (vertex, u) in line.iter().zip(shares) {
            let elevation = Elevation { height: vertex.height, radius: f64::from(vertex.width) / 2.0 };
            if points.last().is_none_or(|point| point.u < u) {
                points.push(ConstraintPoint { u, elevation: Some(elevation), ..ConstraintPoint::default() });
            }
        }
        if let (Banks::Rising { extent, angle, blend }, Some(first)) = (self.banks, points.first_mut()) {
            first.slope = Some(Slope {
                left_extent: extent.0,
                right_extent: extent.0,
                left_angle: angle.0,
                right_angle: angle.0,
            });
            first.envelope = (blend.0 > 0.0).then_some(Envelope { left: blend.0, right: blend.0 });
        }
        points
    }
}

/// The parts of a line, each of as many points as a curve holds, and each beginning where the one before ends; none of a
/// line without length.
struct Parts<'a, 'b>(&'a [&'b RiverVertex]);

impl<'a, 'b> Iterator for Parts<'a, 'b> {
    type Item = &'a [&'b RiverVertex];

    fn next(&mut self) -> Option<Self::Item> {
        const MOST: usize = MAX_POINTS - 96;
        if self.0.len() < 2 {
            return None;
        }
        let count = self.0.len().min(MOST);
        let part = &self.0[..count];
        self.0 = &self.0[count - 1..];
        Some(part)
    }
}
