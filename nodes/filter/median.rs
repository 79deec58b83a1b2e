//! Median filter.

use crate::kit::median;
use crate::prelude::*;

/// Takes the middle value of the surroundings: removes spikes, pits and noise and keeps edges.
///
/// Each value becomes the median of the samples within `radius` of it, its own included \[huang1979\].
///
/// # Limits
/// A radius below a cell does nothing. Up to 32 cells each sample has its exact median; above, every second, third, …
/// point of the lattice has, and a smooth surface, nowhere beyond the values it joins, runs between them. Above 128
/// cells every second, third, … sample of the disk is counted. So the time for a sample does not grow without end.
/// The rougher a field is within the radius, the more its median is a matter of the size of the build; where the radius
/// is many base cells wide it is not.
///
/// # See also
/// `blur` smooths edges as well, and is much faster.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Median {
    /// Radius of the disk, rim included.
    #[schemars(range(min = 0.0, max = 2000.0), extend("x-soft" = [0.0, 100.0]))]
    pub radius: Metres,
}

impl Default for Median {
    fn default() -> Self {
        Self { radius: Metres(24.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to filter.
        field: Field,
    }
    pub struct Outputs {
        /// Filtered field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Median {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["huang1979"]).mixes(&[("field", "field")]).keywords(&[
        "despeckle",
        "denoise",
        "spikes",
        "rank",
    ]);

    fn reach(&self) -> Reach {
        Reach::local(self.radius.0)
    }

    fn footprint(&self, _: &str, window: &Grid, _: &Terrain) -> Grid {
        median::footprint(*window, self.radius.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = median::scratch(grid, self.radius.0);
        Cost { bytes, ..Cost::per_sample(grid, median::nanoseconds(grid, self.radius.0)) }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        Ok(Outputs { field: median::disk(&cx.work, &input.field, cx.grid, self.radius.0)? })
    }
}
