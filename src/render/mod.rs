//! Shaded pictures of terrain, on the CPU: a [`map`] from above, a [`perspective`] view, a small [`thumbnail`].
//!
//! All light is computed in linear RGB. A picture is made in five steps:
//!
//! 1. *Surface*: the field is brought to the working grid (averaged where the picture is smaller, spline where
//!    it is larger) and scaled by the exaggeration.
//! 2. *Horizons*: sweeps along straight lines keep the convex hull of what lies towards the light and give each
//!    sample the elevation of its horizon, in the direction of the sun (cast shadows with penumbra) and in
//!    sixteen more (the share of the sky that it sees) \[timonen2010\], \[dozier1990\].
//! 3. *Light*: sun and sky come from one single-scattering atmosphere; the colour of the ground times this light is
//!    the light that a sample emits. A map is this light, averaged to pixels.
//! 4. *Rays* (perspective only): rays walk a pyramid of maxima down to bilinear patches, so that silhouettes are
//!    exact; water, cut sides, ground and air are added along the way.
//! 5. *Film*: exposure, a filmic curve, the sRGB encoding.
//!
//! Pictures are the same to the bit for any number of threads.

mod block;
mod camera;
mod horizon;
mod light;
mod map;
mod material;
mod perspective;
mod picture;
mod plane;
mod price;
mod sketch;
mod sky;
mod surface;
mod thumbnail;
mod trace;
mod water;

pub use camera::{Camera, Edge};
pub use map::map;
pub use perspective::perspective;
pub use picture::Picture;
pub use price::{map_cost, perspective_cost};
pub use thumbnail::thumbnail;

use crate::kit::ramp;
use crate::node::{Error, Result};
use crate::value::{Colors, Field};

/// The most pixels along a side of a picture.
pub const MAX_PIXELS: usize = 16_384;
/// The most samples along a side of the grid on which light is computed.
const MAX_WORK: usize = 4096;

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Compass direction that the light comes from, in degrees: 0 north, 90 east.
    pub azimuth: f64,
    /// Height above the horizon, in degrees, 1 to 90.
    pub altitude: f64,
}

/// The colours of the ground where the scene has none of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum GroundPalette {
    /// Woods, meadows, rock and snow by height, slope and shelter: a temperate mountain land from above.
    #[default]
    Satellite,
    /// One warm light grey, which shows only the shape.
    Clay,
    /// A ramp from the lowest to the highest land.
    Ramp(ramp::Palette),
}

impl GroundPalette {
    /// The palette of a name: `satellite`, `clay` or one of [`ramp::Palette::BUILTIN`]; `None` when there is none.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "satellite" => Some(Self::Satellite),
            "clay" => Some(Self::Clay),
            _ => {
                let (_, ramp) = ramp::Palette::BUILTIN.into_iter().find(|(known, _)| *known == name)?;
                Some(Self::Ramp(ramp))
            }
        }
    }

    /// Every name that [`named`](Self::named) takes.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let ramps = ramp::Palette::BUILTIN.into_iter().map(|(name, _)| name).filter(|n| *n != "satellite");
        ["satellite", "clay"].into_iter().chain(ramps)
    }
}

/// A terrain with its light and the options of the picture.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// Elevation, in metres.
    pub height: &'a Field,
    /// Colour of the ground, sRGB from 0 to 1, on the grid of `height`; `None` for the colours of the palette.
    pub color: Option<&'a Colors>,
    /// Height of the water, in metres; ground at or below it is under water.
    pub sea_level: Option<f64>,
    /// The direction of the sun.
    pub sun: Sun,
    /// Factor on heights, 0.01 to 1000; colours still follow the true slope.
    pub exaggeration: f64,
    /// Colours of the ground.
    pub palette: GroundPalette,
    /// Depth of the cast shadows, 0 (none) to 1.
    pub shadow: f64,
    /// Thickness of the air in a perspective, 0 (none) to 10; 1 suits the size of the terrain.
    pub haze: f64,
    /// Exposure, in stops, -10 to 10.
    pub exposure: f64,
    /// Distance in height between contour lines on a map, in metres; every fifth is heavier.
    pub contours: Option<f64>,
}

impl<'a> Scene<'a> {
    /// A field under the light of a clear afternoon: the sun in the north-west, as maps have it.
    pub fn new(height: &'a Field) -> Self {
        Self {
            height,
            color: None,
            sea_level: None,
            sun: Sun { azimuth: 315.0, altitude: 35.0 },
            exaggeration: 1.0,
            palette: GroundPalette::default(),
            shadow: 1.0,
            haze: 1.0,
            exposure: 0.0,
            contours: None,
        }
    }

    /// Refuses a scene that cannot be drawn.
    fn check(&self) -> Result<()> {
        let grid = self.height.grid();
        if grid.cols < 2 || grid.rows < 2 {
            let message =
                format!("needs at least 2 x 2 samples to be drawn, got {} x {}", grid.cols, grid.rows);
            return Err(Error::Input { port: "height".into(), message });
        }
        if let Some(at) = self.height.data().iter().position(|z| !z.is_finite()) {
            let (col, row) = (at % grid.cols, at / grid.cols);
            let message = format!("is not finite at column {col}, row {row}");
            return Err(Error::Input { port: "height".into(), message });
        }
        if let Some(color) = self.color {
            let (c, h) = ([color.grid().cols, color.grid().rows], [grid.cols, grid.rows]);
            if c != h {
                let message = format!(
                    "has {} x {} samples, the height {} x {}; they must stand on one grid",
                    c[0], c[1], h[0], h[1]
                );
                return Err(Error::Input { port: "color".into(), message });
            }
        }
        within("cell", grid.cell(), 1e-9, 1e9)?;
        within("sun azimuth", self.sun.azimuth, -360.0, 720.0)?;
        within("sun altitude", self.sun.altitude, 1.0, 90.0)?;
        within("exaggeration", self.exaggeration, 0.01, 1000.0)?;
        within("shadow", self.shadow, 0.0, 1.0)?;
        within("haze", self.haze, 0.0, 10.0)?;
        within("exposure", self.exposure, -10.0, 10.0)?;
        if let Some(level) = self.sea_level {
            within("sea level", level, -1e7, 1e7)?;
        }
        self.contours.map_or(Ok(()), |step| within("contours", step, 1e-6, 1e7))
    }
}

/// Refuses a number outside its range, NaN included.
fn within(name: &str, value: f64, min: f64, max: f64) -> Result<()> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(Error::Parameter { name: name.into(), message: format!("must be from {min} to {max}, got {value}") })
}

/// Refuses a picture that is empty or too large.
fn picture_side(name: &str, pixels: usize) -> Result<()> {
    within(name, pixels as f64, 1.0, MAX_PIXELS as f64)
}
