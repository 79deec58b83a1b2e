//! Tributaries in empty land.

use super::network;
use crate::kit::rivers::drainage;
use crate::kit::rivers::infill::Infill;
use crate::prelude::*;

/// Adds tributaries in empty land, until no place is farther than a spacing from a river.
///
/// Land that no river drains becomes facets, spikes and flats. New vertices stand on a jittered lattice wherever no river
/// is nearer than three quarters of the spacing, and in the gaps that remain. The Delaunay triangulation joins them to each
/// other and to the rivers; a search takes a tree from it, the shortest links first, straight ones before those that turn,
/// and none that crosses a river. Links longer than the spacing are divided.
///
/// What is nearer to the border drains over it, to outlets four spacings outside of the terrain, so that no frame shows.
/// These outlets stand higher than the given ones, by `rim` times their distance.
///
/// Areas and widths are those of the whole network, water from outside the terrain included. Heights of what is added go
/// on as steeply as the rivers do; `river_profile` sets better ones.
///
/// # Limits
/// At most four million vertices. Spacings below eight cells of the base grid make texture, not valleys, and earn a
/// warning. An empty network stays empty.
///
/// # See also
/// `tokunaga_rivers` makes the rivers, `river_profile` sets their heights.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct InfillRivers {
    /// How far from a river no place is.
    #[schemars(range(min = 1.0, max = 1_000_000.0), extend("x-soft" = [50.0, 2000.0]))]
    pub spacing: Metres,
    /// By how much outlets outside the border are higher than the given ones, as a tangent over their distance.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-soft" = [0.0, 0.1]))]
    pub rim: Number,
    /// Width of a river that drains a square kilometre.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.5, 20.0]))]
    pub width: Metres,
    /// Draws what is left to chance.
    pub seed: Seed,
}

impl Default for InfillRivers {
    fn default() -> Self {
        Self { spacing: Metres(300.0), rim: Number(0.03), width: Metres(2.5), seed: Seed(0) }
    }
}

ports! {
    pub struct Inputs {
        /// The rivers.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// The rivers and those that were added.
        rivers: Rivers,
    }
}

impl Node for InfillRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .reads(Reads::TERRAIN.and(Reads::SEED).and(Reads::BASE))
        .cite(&["zhang2016"])
        .keywords(&["river", "tributary", "fill", "network", "drainage", "empty", "density"]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let rivers = load.object::<Rivers>("rivers").unwrap_or_default();
        let most = self.infill(load.terrain, 0).vertices(rivers.vertices()).min(network::MAX_LINKS);
        network::cost(most, 500.0, 14.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers }: Inputs) -> Result<Outputs> {
        if rivers.is_empty() {
            return Ok(Outputs { rivers });
        }
        let infill = self.infill(cx.terrain()?, cx.seed(self.seed)?);
        let most = infill.vertices(rivers.vertices());
        if most > network::MAX_LINKS {
            let message = format!(
                "asks for about {most:.0} vertices on this terrain; at most {:.0}",
                network::MAX_LINKS
            );
            return Err(Error::Parameter { name: "spacing".into(), message });
        }
        let least = 8.0 * cx.base_cell()?;
        if self.spacing.0 < least {
            cx.warn(format!(
                "`spacing` is {} m; below eight cells of the base grid, {least} m, rivers make texture, not valleys",
                self.spacing.0
            ));
        }
        let filled = infill.fill(rivers.vertices(), &cx.work.stage(0.0, 0.7))?;
        if filled.unreached > 0 {
            cx.warn(format!("{} places stay without a river, shut in by others", filled.unreached));
        }
        // River after river, as the other kinds give them: what is near is then near in memory, too.
        let sorted = Rivers::sorted(&filled.vertices).map_err(network::of_fault)?.0;
        let mut vertices = network::changed(&sorted);
        drainage::drain(&mut vertices, infill.filled_bounds(), self.width.0, &cx.work.stage(0.7, 1.0))?;
        Ok(Outputs { rivers: network::made(vertices)? })
    }
}

impl InfillRivers {
    fn infill(&self, terrain: &Terrain, seed: u64) -> Infill {
        Infill { bounds: terrain.bounds(), spacing: self.spacing.0, rim: self.rim.0, seed }
    }
}
