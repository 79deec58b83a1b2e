//! Winding rivers.

use super::network;
use crate::kit::rivers::meander::{Meander, meander};
use crate::prelude::*;

/// Makes straight rivers wind.
///
/// Links longer than `piece` are halved again and again. The point between the halves stands on a smooth way through the
/// vertices around it \[dyn1987\], so that bends are round and tributaries turn downstream where they join, and from there
/// aside by chance, by `strength` times the length that is halved \[fournier1982\]. No two links come to touch: a point
/// without room moves less, and a link without room stays straight.
///
/// New vertices have the area and the width of the vertex upstream, and heights in proportion; `river_profile`, which
/// follows, sets heights again, since winding rivers are longer.
///
/// # Limits
/// At most four million links.
///
/// # See also
/// `tokunaga_rivers`, `infill_rivers`, `river_profile`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeanderRivers {
    /// Standard deviation of how far points move aside, as a share of the length that is halved.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-soft" = [0.0, 0.25]))]
    pub strength: Ratio,
    /// Links longer than this are halved. Two cells of the base grid show all that is there.
    #[schemars(range(min = 0.1, max = 1_000_000.0), extend("x-soft" = [10.0, 500.0], "x-log" = true))]
    pub piece: Metres,
    /// Draws what is left to chance.
    pub seed: Seed,
}

impl Default for MeanderRivers {
    fn default() -> Self {
        Self { strength: Ratio(0.1), piece: Metres(50.0), seed: Seed(0) }
    }
}

ports! {
    pub struct Inputs {
        /// The rivers.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// The rivers with more vertices.
        rivers: Rivers,
    }
}

impl Node for MeanderRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().reads(Reads::SEED).cite(&["dyn1987", "fournier1982"]).keywords(&[
        "river",
        "wind",
        "sinuous",
        "bend",
        "smooth",
        "midpoint displacement",
    ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        // Of a network that is not known: rivers two pieces apart everywhere, more than anybody draws.
        let dense = || load.terrain.width * load.terrain.depth / (2.0 * self.piece.0 * self.piece.0);
        let pieces = load.object::<Rivers>("rivers").map_or_else(dense, |rivers| self.links(&rivers));
        network::cost(pieces.min(network::MAX_LINKS), 250.0, 6.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers }: Inputs) -> Result<Outputs> {
        let links = self.links(&rivers);
        if links > network::MAX_LINKS {
            let message = format!("asks for about {links:.0} links; at most {:.0}", network::MAX_LINKS);
            return Err(Error::Parameter { name: "piece".into(), message });
        }
        let how = Meander { strength: self.strength.0, piece: self.piece.0, seed: cx.seed(self.seed)? };
        let vertices = meander(rivers.vertices(), how, &cx.work)?;
        let (rivers, _) = Rivers::sorted(&vertices).map_err(network::of_fault)?;
        Ok(Outputs { rivers })
    }
}

impl MeanderRivers {
    /// About how many links come of it: halves are between half a piece and a piece long, and a winding way is longer.
    fn links(&self, rivers: &Rivers) -> f64 {
        let long = |(upper, lower): (usize, usize)| {
            let [a, b] = [upper, lower].map(|i| rivers.vertices()[i].at);
            (2.2 * libm::hypot(a[0] - b[0], a[1] - b[1]) / self.piece.0).max(1.0)
        };
        rivers.links().map(long).sum()
    }
}
