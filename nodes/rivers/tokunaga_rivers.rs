//! Self-similar river networks along lines.

use super::network;
use crate::kit::rivers::branching::Branching;
use crate::kit::rivers::drainage;
use crate::kit::rivers::grow::{Growth, Line};
use crate::prelude::*;
use crate::value::{Bounds, RiverVertex};

/// Grows river networks along straight lines, each from an estuary to a place inland.
///
/// A line becomes a network of depth `length / longer side of the terrain · max_depth`, rounded and at least 1
/// \[zhang2016, equation (3)\]. Its first link is exterior: it starts at a source. In each step every link is replaced by a
/// generator. An exterior one becomes φ interior links in a row, with a branch between each two and two at the end; an
/// interior one gets R branches, with `R = P (φ - 1)` and `P = (1 + √(1 + 4φ)) / 2φ` (1). Links are `Pφ` times shorter in
/// each step (2). Branches at the end leave by the branch angle θ, others by 2θ, on alternating sides. φ 2 gives a
/// dendritic network, larger ones a featherlike one.
///
/// The network grows generation by generation on the map. Interior links are divided where they lie, the new points moved
/// sideways (`wander`). A branch tries its own angle, then up to 45° to either side, then lengths down to 55 %, and takes
/// what keeps the most room; one that would come nearer to another link than `clearance` allows is left out, and a warning
/// counts those. No two links cross. Lengths are scaled so that a main stem with nothing in its way ends where its line
/// does.
///
/// With φ the means of Tokunaga's side branches are `T_1 = φ - 1` and `T_k = R φ (R + 1)^(k - 2)`, and Horton's bifurcation
/// ratio is `φ + 1 + R`: 4 for φ 2, 5.54 for 3, 6.92 for 4. `statistics` takes `T_k = a c^(k - 1)` \[peckham1995\] instead,
/// and holds it exactly in the mean: exterior links take generator 1 + a, an interior link in its j-th step as one
/// `R_j = a c^j / (1 + a (1 + c + … + c^(j - 1)))`. Fractions of a generator are probabilities. Real networks have a from
/// 0.65 to 1.4 and c from 1.3 to 3.8.
///
/// Beds rise from their estuary by `slope`; `river_profile` sets better heights. The area that drains through a vertex is
/// that of the Voronoi cells upstream inside the terrain, the width of a river grows with its root \[leopold1953\].
///
/// # Differs from the paper
/// Generator k of an interior link has k + 1 interior and k exterior links (`F[++G]F`); the printed `F[-G]F[-G][+G]` makes
/// a joint of four, and exterior links are no longer one more than interior ones. (2) is printed as `(1/P·φ)^(t-1)` and
/// means `(Pφ)^-(t-1)`. Tokunaga's law holds for φ 2 only (a 1, c 2). Drawn by the rules alone a network crosses itself.
///
/// # Limits
/// At most four million links. Land far from the lines stays empty: `infill_rivers` fills it.
///
/// # See also
/// `infill_rivers`, `river_profile` and `voronoi_ridges` follow.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TokunagaRivers {
    /// East and south of the estuary of each line, then of the place inland, inside the terrain. Where it is not set, one
    /// line runs from the middle of the southern border most of the way to the north.
    #[schemars(extend(
        "x-widget" = Widget::Lines,
        "x-items" = ["east", "south", "east", "south"],
        "examples" = [[[4096, 8192, 4096, 900], [0, 2500, 2900, 1800]]],
    ))]
    pub lines: Option<Vec<[Metres; 4]>>,
    /// How links branch.
    pub branching: BranchingRule,
    /// Depth of a network as long as the longer side of the terrain. A step has about `φ + 1 + R` times as many links.
    #[schemars(range(min = 1, max = 12), extend("x-soft" = [2, 9], "x-unit" = "1"))]
    pub max_depth: u32,
    /// Angle θ between the two branches at the end of a link and the link itself; other branches have twice that.
    #[schemars(range(min = 5.0, max = 80.0))]
    pub angle: Degrees,
    /// Share of interior links that are lengthened in a step (rule FF) instead of branching.
    pub lengthen: Ratio,
    /// How far the points that divide a link move sideways, as a share of the pieces: one standard deviation.
    #[schemars(range(min = 0.0, max = 0.3))]
    pub wander: Ratio,
    /// How far links keep from others, as a share of the link length of their step.
    #[schemars(range(min = 0.05, max = 0.6))]
    pub clearance: Ratio,
    /// Rise of beds from the estuary, as a tangent.
    #[schemars(range(min = 0.0001, max = 1.0), extend("x-soft" = [0.001, 0.1]))]
    pub slope: Number,
    /// Height of beds at estuaries. Where it is not set, the sea level, or 0 without a sea.
    #[schemars(range(min = -10_000.0, max = 10_000.0), extend("x-soft" = [-100.0, 1000.0]))]
    pub estuary: Option<Metres>,
    /// Width of a river that drains a square kilometre.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.5, 20.0]))]
    pub width: Metres,
    /// Draws what is left to chance.
    pub seed: Seed,
}

/// How links branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BranchingRule {
    /// By the generators of the paper.
    Generator {
        /// Generator φ of exterior links.
        #[schemars(range(min = 1, max = 8), extend("x-unit" = "1"))]
        phi: u8,
    },
    /// By Tokunaga's law: of each lower order c times as many side branches.
    Statistics {
        /// Side branches of the next lower order that a stream has, a.
        #[schemars(range(min = 0.0, max = 6.0))]
        a: Number,
        /// How many times more there are of each lower order, c.
        #[schemars(range(min = 0.5, max = 6.0))]
        c: Number,
    },
}

impl Default for TokunagaRivers {
    fn default() -> Self {
        Self {
            lines: None,
            branching: BranchingRule::Generator { phi: 2 },
            max_depth: 6,
            angle: Degrees(35.0),
            lengthen: Ratio(0.0),
            wander: Ratio(0.12),
            clearance: Ratio(0.38),
            slope: Number(0.02),
            estuary: None,
            width: Metres(2.5),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Where rivers may run: from one half up. Everywhere where it is not connected.
        land: Option<Field>,
    }
    pub struct Outputs {
        /// The networks, in the order of the lines.
        rivers: Rivers,
    }
}

impl Node for TokunagaRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .reads(Reads::TERRAIN.and(Reads::SEED))
        .cite(&["zhang2016", "peckham1995", "leopold1953"])
        .keywords(&[
            "river",
            "stream",
            "network",
            "tributary",
            "drainage",
            "l-system",
            "dendritic",
            "horton",
        ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let lines = self.drawn(load.terrain);
        let links = self.growth(load.terrain.bounds(), 0, &|_| true).links(&lines).min(network::MAX_LINKS);
        network::cost(links, 600.0, 12.0)
    }

    fn check(&self) -> Result<()> {
        for (i, line) in self.lines.iter().flatten().enumerate() {
            let [x, y, east, south] = line.map(|v| v.0);
            if (x, y) == (east, south) {
                return Err(wrong(format!("line {i} has no length; it starts and ends at {x}, {y}")));
            }
        }
        let starts = self.lines.as_deref().unwrap_or_default();
        let mut sorted: Vec<(f64, f64, usize)> =
            starts.iter().enumerate().map(|(i, line)| (line[0].0, line[1].0, i)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let twin = sorted.windows(2).find(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1));
        match twin {
            Some([(x, y, i), (_, _, j)]) => {
                Err(wrong(format!("line {j} starts where line {i} does, at {x}, {y}")))
            }
            _ => Ok(()),
        }
    }

    fn run(&self, cx: &Context<'_>, Inputs { land }: Inputs) -> Result<Outputs> {
        let terrain = cx.terrain()?;
        let bounds = terrain.bounds();
        let lines = self.drawn(terrain);
        if let Some((i, place)) = outside(&lines, bounds) {
            return Err(wrong(format!("line {i} must lie inside the terrain, got {place:?}")));
        }
        let is_land = |at: [f64; 2]| {
            land.as_ref().is_none_or(|land| {
                let [col, row] = land.grid().nearest(at);
                land.data()[row * land.grid().cols + col] >= 0.5
            })
        };
        let growth = self.growth(bounds, cx.seed(self.seed)?, &is_land);
        let links = growth.links(&lines);
        if links > network::MAX_LINKS {
            let message = format!(
                "asks for about {links:.0} links with these lines; at most {:.0}",
                network::MAX_LINKS
            );
            return Err(Error::Parameter { name: "max_depth".into(), message });
        }
        if lines.is_empty() {
            cx.warn("there is no line, so there is no river");
            return Ok(Outputs { rivers: Rivers::default() });
        }
        let grown = growth.grow(&lines, &cx.work.stage(0.0, 0.7))?;
        for i in &grown.crossing {
            cx.warn(format!("line {i} is left out, since its first link would cross that of another line"));
        }
        if grown.left_out > 0 {
            cx.warn(format!("{} of {} branches are left out for want of room", grown.left_out, grown.asked));
        }
        let mut vertices = grown.vertices().map_err(network::of_fault)?;
        self.rise(&mut vertices, terrain);
        drainage::drain(&mut vertices, bounds, self.width.0, &cx.work.stage(0.7, 1.0))?;
        Ok(Outputs { rivers: network::made(vertices)? })
    }
}

impl TokunagaRivers {
    /// The lines, or the one that stands for none being set.
    fn drawn(&self, terrain: &Terrain) -> Vec<Line> {
        match &self.lines {
            Some(lines) => lines
                .iter()
                .map(|line| line.map(|v| v.0))
                .map(|[x, y, east, south]| Line { from: [x, y], to: [east, south] })
                .collect(),
            None => {
                let ([x, y], middle) = (terrain.origin, terrain.width / 2.0);
                let [from, to] = [1.0, 0.12].map(|share| [x + middle, y + share * terrain.depth]);
                vec![Line { from, to }]
            }
        }
    }

    fn growth<'a>(
        &self,
        bounds: Bounds,
        seed: u64,
        is_land: &'a (dyn Fn([f64; 2]) -> bool + Sync),
    ) -> Growth<'a> {
        let branching = match self.branching {
            BranchingRule::Generator { phi } => Branching::Generator(phi),
            BranchingRule::Statistics { a, c } => Branching::Statistics { a: a.0, c: c.0 },
        };
        Growth {
            bounds,
            branching,
            max_depth: self.max_depth,
            angle: self.angle.0.to_radians(),
            lengthen: self.lengthen.0,
            wander: self.wander.0,
            clearance: self.clearance.0,
            seed,
            is_land,
        }
    }

    /// Beds that rise from their estuary by the slope.
    fn rise(&self, vertices: &mut [RiverVertex], terrain: &Terrain) {
        let estuary = self.estuary.map_or(terrain.sea_level.unwrap_or(0.0), |height| height.0);
        for vertex in vertices.iter_mut() {
            vertex.height = estuary;
        }
        crate::kit::rivers::profile::rise(vertices, crate::kit::rivers::profile::Rise::Even(self.slope.0));
    }
}

/// The first line with an end outside the terrain.
fn outside(lines: &[Line], bounds: Bounds) -> Option<(usize, [f64; 2])> {
    let is_inside = |at: [f64; 2]| (0..2).all(|k| (bounds.min[k]..=bounds.max[k]).contains(&at[k]));
    let ends = lines.iter().enumerate().flat_map(|(i, line)| [(i, line.from), (i, line.to)]);
    ends.into_iter().find(|(_, at)| !is_inside(*at))
}

fn wrong(message: String) -> Error {
    Error::Parameter { name: "lines".into(), message }
}
