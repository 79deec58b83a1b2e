//! Distances to random points.

use crate::kit::noise::{self, Worley};
use crate::prelude::*;

/// Measures the distance to random points, one in each cell of a turned lattice.
///
/// With the distances `F1` and `F2` to the nearest and second nearest point, in cells, the height is
/// `offset + amplitude · measure`: a rise of `amplitude` over a way of `size` \[worley1996\].
///
/// # Differs from the paper
/// Each cell has exactly one point instead of a random number of them, so cells are more even in size.
///
/// # Limits
/// The search is exact at every jitter and metric. Distances reach 1.41 cells for `f1` (Manhattan 2) and 1.58 for `f2`
/// (Manhattan 2), and rarely pass 1. Creases lie where the nearest point changes, as they should.
///
/// # See also
/// `fractal_noise` makes smooth noise.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CellularNoise {
    /// What is measured.
    pub measure: Measure,
    /// How distance is measured.
    pub metric: Metric,
    /// Size of a cell.
    #[schemars(range(min = 0.1, max = 1.0e6), extend("x-soft" = [20.0, 5000.0], "x-log" = true))]
    pub size: Metres,
    /// How freely a point stands in its cell: 0 in the middle, 1 anywhere.
    pub jitter: Ratio,
    /// Height of a measure of 1.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub amplitude: Metres,
    /// Height that the measure is added to.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [-1000.0, 1000.0]))]
    pub offset: Metres,
    /// Chooses other points.
    pub seed: Seed,
}

/// What cellular noise measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Distance to the nearest point: cones standing on their tips.
    #[default]
    F1,
    /// Distance to the second nearest point.
    F2,
    /// Second less first distance: 0 on the borders of cells, rising inwards.
    F2MinusF1,
    /// A random number from 0 to 1 for each cell: plateaus.
    CellValue,
}

/// How cellular noise measures distance, along the axes of its turned lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// The straight way: round cones.
    #[default]
    Euclidean,
    /// Along the axes: cones with a square foot on its corner.
    Manhattan,
    /// The longer of both axes: cones with a square foot.
    Chebyshev,
}

impl From<Measure> for noise::Measure {
    fn from(measure: Measure) -> Self {
        match measure {
            Measure::F1 => Self::F1,
            Measure::F2 => Self::F2,
            Measure::F2MinusF1 => Self::F2MinusF1,
            Measure::CellValue => Self::CellValue,
        }
    }
}

impl From<Metric> for noise::Metric {
    fn from(metric: Metric) -> Self {
        match metric {
            Metric::Euclidean => Self::Euclidean,
            Metric::Manhattan => Self::Manhattan,
            Metric::Chebyshev => Self::Chebyshev,
        }
    }
}

impl Default for CellularNoise {
    fn default() -> Self {
        Self {
            measure: Measure::F1,
            metric: Metric::Euclidean,
            size: Metres(1000.0),
            jitter: Ratio(1.0),
            amplitude: Metres(300.0),
            offset: Metres(0.0),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Height, in metres.
        field: Field = Meaning::Fixed(Quantity::Elevation),
    }
}

impl Node for CellularNoise {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["worley1996"])
        .keywords(&["worley", "voronoi", "cells", "cracks", "plateau", "cones", "points"])
        .reads(Reads::SEED);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = Worley::bytes(grid.cols) + 8 * grid.cols as u64;
        Cost { bytes, ..Cost::per_sample(grid, 12.0) }
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let seed = cx.seed(self.seed)?;
        let noise = Worley::new(self.size.0, self.jitter.0, seed, self.offset.0, self.amplitude.0)
            .measured(self.metric.into(), self.measure.into());
        let rows = noise.over(&cx.grid.xs());
        Ok(Outputs { field: cx.fill(Quantity::Elevation, |row, out| rows.row(row.y, out))? })
    }
}
