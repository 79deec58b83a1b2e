//! Heights of river beds.

use super::network;
use crate::kit::rivers::profile::{self, Rise};
use crate::prelude::*;

/// Sets the heights of river beds, from their outlets up.
///
/// `even` is the paper's profile: the length to the outlet times a slope [zhang2016, section IV.C]. `concave` is that of
/// real rivers: slopes go with `area ^ -concavity` \[flint1974\], steep at the sources and flat at the mouth, scaled so that
/// one vertex in a hundred is more than `relief` above its outlet. Outlets keep their height.
///
/// Rivers of one length to the sea are as high, whatever lies between them; so where water of a long way runs beside that
/// of a short one, their divide is a cliff. Then rivers that stand higher over a neighbour than `steepest_side` allows are
/// lowered: the result is the highest that is nowhere over the profile and nowhere steeper between neighbours (those of the
/// Delaunay triangulation). Each river still falls all the way, by a metre in ten kilometres at least.
///
/// # Limits
/// Between two rivers a ridge adds to the slope: `voronoi_ridges` says by how much.
///
/// # See also
/// `tokunaga_rivers` and `infill_rivers` make the rivers, `voronoi_ridges` the divides between them.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RiverProfile {
    /// How beds rise from their outlet.
    pub profile: Profile,
    /// The steepest that the land between two neighbouring rivers may be.
    #[schemars(range(min = 1.0, max = 85.0))]
    pub steepest_side: Degrees,
}

/// How beds rise from their outlet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Profile {
    /// By one slope everywhere.
    Even {
        /// Rise of beds, as a tangent.
        #[schemars(range(min = 0.0001, max = 1.0))]
        slope: Number,
    },
    /// Ever steeper towards the sources.
    Concave {
        /// Exponent of the area; real rivers have 0.3 to 0.6.
        #[schemars(range(min = 0.0, max = 1.0))]
        concavity: Number,
        /// Height of the highest beds over their outlets.
        #[schemars(range(min = 1.0, max = 10_000.0))]
        relief: Metres,
    },
}

impl Default for RiverProfile {
    fn default() -> Self {
        let profile = Profile::Concave { concavity: Number(0.45), relief: Metres(900.0) };
        Self { profile, steepest_side: Degrees(30.0) }
    }
}

ports! {
    pub struct Inputs {
        /// The rivers.
        rivers: Rivers,
    }
    pub struct Outputs {
        /// The rivers with new heights.
        rivers: Rivers,
    }
}

impl Node for RiverProfile {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["zhang2016", "flint1974"]).keywords(&[
        "river",
        "bed",
        "height",
        "long profile",
        "concave",
        "knickpoint",
        "slope",
        "gradient",
    ]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        network::cost(network::vertices(load), 450.0, 8.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers }: Inputs) -> Result<Outputs> {
        let rise = match self.profile {
            Profile::Even { slope } => Rise::Even(slope.0),
            Profile::Concave { concavity, relief } => {
                Rise::Concave { concavity: concavity.0, relief: relief.0 }
            }
        };
        let mut vertices = network::changed(&rivers);
        profile::rise(&mut vertices, rise);
        let steepest = libm::tan(self.steepest_side.0.to_radians());
        profile::limit_sides(&mut vertices, steepest, &cx.work)?;
        Ok(Outputs { rivers: network::made(vertices)? })
    }
}
