//! Where a raster of a file goes on the terrain: shared by all kinds that read one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::picture::PixelSpan;
use super::place::{Affine, Placement, Units};
use crate::node::{Context, Error, Result};
use crate::units::{Degrees, Metres};
use crate::value::{Field, Quantity, Terrain};

/// Where a file goes on the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Placing {
    /// Over the whole terrain, each axis by itself.
    #[default]
    Stretch,
    /// Where its coordinates say, in the coordinate system of the terrain.
    Georeference,
    /// At its own size.
    TrueSize {
        /// Where its middle lies east of the middle of the terrain.
        #[serde(default)]
        x: Metres,
        /// Where its middle lies south of the middle of the terrain.
        #[serde(default)]
        y: Metres,
        /// How far it is turned clockwise, seen from above.
        #[serde(default)]
        rotation: Degrees,
    },
}

/// A raster to place: how many samples it has, and where its file says that they lie.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Samples in a row.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Where they lie by the word of the file.
    pub placement: Placement,
    /// Distance between the samples by a person's word.
    pub cell: Option<Metres>,
}

/// By how much one axis may be stretched more than the other before it is worth a word.
const UNEQUAL: f64 = 0.01;

impl Placing {
    /// How world coordinates become positions in the file.
    ///
    /// # Errors
    /// When the file or the terrain does not say what the placing needs.
    pub fn pose(&self, terrain: &Terrain, raster: &Placed) -> Result<Pose> {
        let last = [raster.cols, raster.rows].map(|n| n.saturating_sub(1) as f64);
        match *self {
            Self::Stretch => Ok(Pose {
                origin: terrain.origin,
                start: [0.0, 0.0],
                x: [last[0] / terrain.width, 0.0],
                y: [0.0, last[1] / terrain.depth],
            }),
            Self::TrueSize { x, y, rotation } => {
                let [dx, dy] = raster.steps().ok_or_else(|| {
                    bad("cell", "must be set: the file does not say how far apart its samples are".into())
                })?;
                let [sin, cos] = sin_cos(rotation.0);
                let [ox, oy] = terrain.origin;
                Ok(Pose {
                    origin: [ox + terrain.width / 2.0 + x.0, oy + terrain.depth / 2.0 + y.0],
                    start: [last[0] / 2.0, last[1] / 2.0],
                    x: [cos / dx, -sin / dy],
                    y: [sin / dx, cos / dy],
                })
            }
            Self::Georeference => georeferenced(terrain, &raster.placement),
        }
    }

    /// What a person should know of a raster that is placed otherwise than its file says.
    pub fn warnings(&self, terrain: &Terrain, raster: &Placed) -> impl Iterator<Item = String> + use<> {
        let turned =
            raster.placement.affine.filter(|affine| *self != Self::Georeference && !affine.is_north_up());
        let turned = turned.map(|_| {
            "by its own coordinates the file lies turned or mirrored on the map, and it is placed as its rows stand; \
             `placement` \"georeference\" places it as it lies"
                .to_owned()
        });
        self.unequal(terrain, raster).into_iter().chain(turned)
    }

    /// How much more one axis is stretched than the other.
    fn unequal(&self, terrain: &Terrain, raster: &Placed) -> Option<String> {
        if *self != Self::Stretch || raster.cols < 2 || raster.rows < 2 {
            return None;
        }
        let steps = raster.steps().unwrap_or([1.0, 1.0]);
        let extent = [(raster.cols - 1) as f64 * steps[0], (raster.rows - 1) as f64 * steps[1]];
        let [x, y] = [terrain.width / extent[0], terrain.depth / extent[1]];
        let factor = x.max(y) / x.min(y);
        if !factor.is_finite() || factor <= 1.0 + UNEQUAL {
            return None;
        }
        let (more, less) = if x > y { ("to the east", "south") } else { ("to the south", "east") };
        let own = match raster.steps() {
            Some(_) => format!("it is {:.1} x {:.1} m", extent[0], extent[1]),
            None => format!("it has {} x {} samples, taken for square ones", raster.cols, raster.rows),
        };
        Some(format!(
            "the file is stretched {factor:.2} times as much {more} as to the {less}: {own}, the terrain {} x {} m; \
             `orograph fit` makes a terrain that fits",
            terrain.width, terrain.depth
        ))
    }
}

impl Placed {
    /// Steps from column to column and from row to row, in metres.
    pub fn steps(&self) -> Option<[f64; 2]> {
        self.cell.map(|c| [c.0; 2]).or(self.placement.cell)
    }

    /// Whether a position lies between the samples at the border, or on them.
    pub fn contains(&self, u: f64, v: f64) -> bool {
        let within = |p: f64, n: usize| (-SNAP..=n.saturating_sub(1) as f64 + SNAP).contains(&p);
        within(u, self.cols) && within(v, self.rows)
    }
}

/// How near a position must come to a sample to be that sample, in steps.
pub(super) const SNAP: f64 = 1e-6;

fn bad(name: &str, message: String) -> Error {
    Error::Parameter { name: name.into(), message }
}

fn georeferenced(terrain: &Terrain, place: &Placement) -> Result<Pose> {
    let no = |message: &str| bad("placement", format!("is by georeference, and {message}"));
    let geo = terrain.geo.ok_or_else(|| no("the terrain has no `geo`: it lies nowhere on Earth"))?;
    let affine = place.affine.ok_or_else(|| no("the file has no coordinates"))?;
    match place.epsg {
        Some(epsg) if epsg == geo.epsg => (),
        Some(epsg) => {
            let (want, hint) = (geo.epsg, "reproject it, or place it at true size");
            return Err(bad(
                "placement",
                format!("is by georeference: the file is in EPSG:{epsg}, the terrain in EPSG:{want}; {hint}"),
            ));
        }
        None => return Err(no("the file names no EPSG code")),
    }
    if !matches!(place.units, Units::Length(1.0) | Units::WebMercator) {
        return Err(no("the file's coordinates are not in metres"));
    }
    let inverse = affine.inverse().ok_or_else(|| no("the file's coordinates span no plane"))?;
    // The map is linear: three points tell it.
    let start = inverse([geo.east, geo.north]);
    let (east, south) = (affine_step(&affine, [1.0, 0.0]), affine_step(&affine, [0.0, -1.0]));
    Ok(Pose { origin: terrain.origin, start, x: east, y: south })
}

/// From world coordinates to positions in a file, in steps from its north-west sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// A place in the world.
    pub origin: [f64; 2],
    /// Its position in the file.
    pub start: [f64; 2],
    /// How the position changes with a metre to the east.
    pub x: [f64; 2],
    /// How the position changes with a metre to the south.
    pub y: [f64; 2],
}

impl Pose {
    /// Whether columns of the world are columns of the file.
    pub fn is_upright(&self) -> bool {
        self.x[1] == 0.0 && self.y[0] == 0.0
    }

    /// How many samples of the file a cell of some metres covers, across and down.
    pub fn footprint(&self, cell: f64) -> PixelSpan {
        PixelSpan([0, 1].map(|k| libm::hypot(self.x[k], self.y[k]) * cell))
    }

    /// The position of a place.
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let (x, y) = (x - self.origin[0], y - self.origin[1]);
        [self.start[0] + x * self.x[0] + y * self.y[0], self.start[1] + x * self.x[1] + y * self.y[1]]
    }

    /// A mask of where something holds of the position in the file; 0 everywhere where it never does.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when the work was asked to stop.
    pub fn mask(
        &self,
        cx: &Context<'_>,
        ever: bool,
        holds: impl Fn(f64, f64) -> bool + Sync,
    ) -> Result<Field> {
        let xs = cx.grid.xs();
        cx.fill(Quantity::Mask, |row, out| {
            if ever {
                for (o, x) in out.iter_mut().zip(&xs) {
                    let [u, v] = self.at(*x, row.y);
                    *o = f32::from(u8::from(holds(u, v)));
                }
            }
        })
    }
}

/// How the position in a file changes along a step of its coordinates.
fn affine_step(a: &Affine, [x, y]: [f64; 2]) -> [f64; 2] {
    let det = a.col[0] * a.row[1] - a.col[1] * a.row[0];
    [(x * a.row[1] - y * a.row[0]) / det, (a.col[0] * y - a.col[1] * x) / det]
}

/// Sine and cosine of an angle in degrees, exact for quarter turns.
fn sin_cos(degrees: f64) -> [f64; 2] {
    match degrees.rem_euclid(360.0) {
        0.0 => [0.0, 1.0],
        90.0 => [1.0, 0.0],
        180.0 => [0.0, -1.0],
        270.0 => [-1.0, 0.0],
        other => {
            let (sin, cos) = libm::sincos(other.to_radians());
            [sin, cos]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_lies_turned_is_told() {
        let terrain = Terrain { width: 300.0, depth: 200.0, ..Terrain::default() };
        let warnings = |placing: Placing, col: [f64; 2], row: [f64; 2]| {
            let affine = Some(Affine { origin: [0.0; 2], col, row });
            let placement = Placement { affine, cell: Some([10.0; 2]), ..Placement::default() };
            placing.warnings(&terrain, &Placed { cols: 31, rows: 21, placement, cell: None }).count()
        };
        assert_eq!(warnings(Placing::Stretch, [10.0, 0.0], [0.0, -10.0]), 0);
        assert_eq!(warnings(Placing::Stretch, [-10.0, 0.0], [0.0, -10.0]), 1, "mirrored");
        assert_eq!(warnings(Placing::Stretch, [8.0, 6.0], [6.0, -8.0]), 1, "turned");
        assert_eq!(warnings(Placing::Georeference, [8.0, 6.0], [6.0, -8.0]), 0);
    }
}
