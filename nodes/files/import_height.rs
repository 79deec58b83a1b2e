//! Heights from a file.

use std::sync::Arc;

use crate::files::{
    Affine, Claim, Closing, Companion, Encoding, Fault, Input, Limits, Reading, Relief, Request, Units,
    Watch, apart, companions,
};
use crate::node::SourceFile;
use crate::prelude::*;
use crate::source::HEAD_BYTES;

/// Seconds that decoding a sample takes, with the spline through it.
const DECODING_SECONDS: f64 = 30e-9;

/// Reads heights from a file and places them on the terrain.
///
/// It reads PNG (grey, Terrarium or Terrain-RGB), TIFF and GeoTIFF, OpenEXR, r16 and r32 (with a JSON sidecar), Esri's
/// `.asc`, `.flt` and `.bil`, SRTM `.hgt`, PFM, Terragen `.ter` and lines of `.xyz`. What a reader noticed is a warning.
/// Between the samples of the file runs a cubic spline that meets every one of them; beyond its
/// rectangle the border value continues.
///
/// Height is `value · height_scale + height_offset`. Formats in metres (TIFF, OpenEXR, `.asc`, `.hgt`, Terrarium, and
/// PNG, r16 and r32 whose sidecar gives a range) need neither. In the others a value is the plain number in the file,
/// 0 to 65535 or 0 to 255, and the scale says how many metres a step is.
///
/// Voids of the file come out as a mask and are closed from their border inwards by a smooth membrane.
///
/// # Limits
/// A georeferenced file must be in the coordinate system of the terrain: nothing is reprojected. Degrees and web
/// Mercator are turned to metres at the middle of the file, which serves for a few degrees at most.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportHeight {
    /// The file.
    pub file: FilePath,
    /// Where it goes.
    pub placement: Placing,
    /// Distance between the samples of the file, for placing at true size; none takes what the file says.
    #[schemars(range(min = 0.001, max = 1.0e6), extend("x-soft" = [0.5, 100.0], "x-log" = true))]
    pub cell: Option<Metres>,
    /// Height of one unit of the file.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 10.0]))]
    pub height_scale: Number,
    /// Height of the number 0 of the file.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-1000.0, 1000.0]))]
    pub height_offset: Metres,
    /// How the pixels of a PNG hold heights.
    pub encoding: Encoding,
    /// The channel of an OpenEXR file, by its name, or the band of a TIFF or `.bil`, by its number; empty takes the one
    /// that its name gives away, or the first.
    pub channel: String,
    /// What runs between the samples of the file.
    pub interpolation: Interpolation,
    /// How voids are closed.
    pub fill: Fill,
}

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

/// What runs between the samples of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// A cubic spline: no edges where the file's cells meet.
    #[default]
    Cubic,
    /// Planes: never higher or lower than the samples around.
    Linear,
}

/// How voids are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fill {
    /// With a membrane that hangs from the heights around.
    #[default]
    Smooth,
    /// With one height, the sea's for instance.
    Level {
        /// The height.
        #[serde(default)]
        height: Metres,
    },
}

impl Default for ImportHeight {
    fn default() -> Self {
        Self {
            file: FilePath::default(),
            placement: Placing::default(),
            cell: None,
            height_scale: Number(1.0),
            height_offset: Metres(0.0),
            encoding: Encoding::default(),
            channel: String::new(),
            interpolation: Interpolation::default(),
            fill: Fill::default(),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Heights in metres.
        height: Field,
        /// 1 where the file had no height and one was made up.
        voids: Field,
        /// 1 inside the rectangle of the file, 0 where its border value continues.
        inside: Field,
    }
}

impl Node for ImportHeight {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().reads(Reads::TERRAIN).keywords(&[
        "dem",
        "heightmap",
        "elevation",
        "load",
        "open",
        "geotiff",
        "srtm",
        "terrarium",
        "real",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, grid: &Grid) -> Cost {
        let turned = matches!(self.placement, Placing::TrueSize { rotation, .. } if rotation.0 != 0.0);
        let cost = Cost::per_sample(grid, if turned { 60.0 } else { 8.0 });
        // Prepared columns, and a line of coefficients for each row in work.
        Cost { bytes: grid.cols as u64 * 64 + (1 << 22), ..cost }
    }

    fn files(&self) -> Vec<FileRequest> {
        if self.file.0.is_empty() {
            return Vec::new();
        }
        let request = |name: String, optional| FileRequest { parameter: "file", name, optional };
        let beside = companions(&self.file.0).into_iter().map(|name| request(name, true));
        [request(self.file.0.clone(), false)].into_iter().chain(beside).collect()
    }

    fn reading(&self, files: &[Arc<SourceFile>]) -> Cost {
        let content = Cost::of_reading(files);
        let [file, rest @ ..] = files else { return content };
        // A file that cannot be read takes nothing more: the run says what is wrong with it.
        let small = rest.iter().filter(|f| f.len() <= HEAD_BYTES);
        let beside: Vec<_> = small.filter_map(|f| Some((f.name(), f.head().ok()?))).collect();
        let beside: Vec<_> = beside.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
        let Ok(claim) = claim(file, &beside, &self.reading_as()) else { return content };
        let surface = Relief::bytes(claim.cols, claim.rows, self.interpolation == Interpolation::Cubic);
        let seconds = claim.cols as f64 * claim.rows as f64 * DECODING_SECONDS;
        content.and(Cost { bytes: surface.max(claim.bytes), seconds })
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let relief = self.relief(cx)?;
        let pose = self.pose(cx.terrain()?, &relief)?;
        relief.notes.iter().for_each(|note| cx.warn(note.clone()));
        cx.check()?;
        Ok(Outputs {
            height: self.heights(&cx.stage(0.2, 0.8), &relief, &pose)?,
            voids: mask(&cx.stage(0.8, 0.9), &pose, relief.has_voids(), |u, v| relief.is_void(u, v))?,
            inside: mask(&cx.stage(0.9, 1.0), &pose, true, |u, v| relief.contains(u, v))?,
        })
    }
}

impl ImportHeight {
    /// What the parameters say of the file.
    fn reading_as(&self) -> Reading {
        Reading { encoding: self.encoding, channel: (!self.channel.is_empty()).then(|| self.channel.clone()) }
    }

    /// The surface of the file, made once however many tiles and nodes ask.
    fn relief(&self, cx: &Context<'_>) -> Result<Arc<Relief>> {
        let name = &self.file.0;
        if name.is_empty() {
            return Err(Error::Parameter { name: "file".into(), message: "no file chosen".into() });
        }
        let fault = |message: String| Error::File { parameter: "file", file: name.clone(), message };
        let file = cx.file(&self.file).ok_or_else(|| fault("not found".into()))?;
        let names = companions(name);
        let mut found = Vec::new();
        for name in &names {
            if let Some(file) = cx.file(&FilePath(name.clone())) {
                found.push((name, beside(cx, file)?));
            }
        }
        let companions: Vec<_> = found.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
        let reading = self.reading_as();
        let (scale, offset) = (self.height_scale.0, self.height_offset.0);
        let closing = match self.fill {
            Fill::Smooth => Closing::Smooth,
            Fill::Level { height } if scale != 0.0 => Closing::Level(((height.0 - offset) / scale) as f32),
            Fill::Level { .. } => Closing::Level(0.0),
        };
        let way = Request {
            name,
            companions: &companions,
            reading: &reading,
            closing,
            cubic: self.interpolation == Interpolation::Cubic,
        };
        file.decoded(&way.identity(), || {
            let limits = Limits::default();
            let bytes = cx.stage(0.01, 0.2).read("file", file)?;
            // Under a lock of the shelf, where a worker must not pick up other work.
            let watch = Watch { cancel: Some(cx.cancel), progress: None };
            let relief = apart(|| Relief::new(&way, &bytes, &limits, watch)).map_err(|e| match e.fault {
                Fault::Cancelled => Error::Cancelled,
                other => fault(other.to_string()),
            })?;
            let held = relief.held_bytes();
            Ok((relief, held))
        })
    }

    /// How world coordinates become positions in the file.
    fn pose(&self, terrain: &Terrain, relief: &Relief) -> Result<Pose> {
        let last = [(relief.cols - 1) as f64, (relief.rows - 1) as f64];
        match self.placement {
            Placing::Stretch => Ok(Pose {
                origin: terrain.origin,
                start: [0.0, 0.0],
                x: [last[0] / terrain.width, 0.0],
                y: [0.0, last[1] / terrain.depth],
            }),
            Placing::TrueSize { x, y, rotation } => {
                let [dx, dy] = match self.cell {
                    Some(cell) => [cell.0; 2],
                    None => relief.placement.cell.ok_or_else(|| {
                        self.bad("cell", "must be set: the file does not say how far apart its samples are")
                    })?,
                };
                let [sin, cos] = sin_cos(rotation.0);
                let [ox, oy] = terrain.origin;
                Ok(Pose {
                    origin: [ox + terrain.width / 2.0 + x.0, oy + terrain.depth / 2.0 + y.0],
                    start: [last[0] / 2.0, last[1] / 2.0],
                    x: [cos / dx, -sin / dy],
                    y: [sin / dx, cos / dy],
                })
            }
            Placing::Georeference => self.georeferenced(terrain, relief),
        }
    }

    fn georeferenced(&self, terrain: &Terrain, relief: &Relief) -> Result<Pose> {
        let no = |message: &str| self.bad("placement", message);
        let geo = terrain.geo.ok_or_else(|| {
            no("is by georeference, and the terrain has no `geo`: it lies nowhere on Earth")
        })?;
        let place = relief.placement;
        let affine: Affine =
            place.affine.ok_or_else(|| no("is by georeference, and the file has no coordinates"))?;
        match place.epsg {
            Some(epsg) if epsg == geo.epsg => (),
            Some(epsg) => {
                let (want, hint) = (geo.epsg, "reproject it, or place it at true size");
                return Err(no(&format!(
                    "is by georeference: the file is in EPSG:{epsg}, the terrain in EPSG:{want}; {hint}"
                )));
            }
            None => return Err(no("is by georeference, and the file names no EPSG code")),
        }
        if !matches!(place.units, Units::Length(1.0) | Units::WebMercator) {
            return Err(no("is by georeference, and the file's coordinates are not in metres"));
        }
        let inverse = affine
            .inverse()
            .ok_or_else(|| no("is by georeference, and the file's coordinates span no plane"))?;
        // The map is linear: three points tell it.
        let start = inverse([geo.east, geo.north]);
        let (east, south) = (affine_step(&affine, [1.0, 0.0]), affine_step(&affine, [0.0, -1.0]));
        Ok(Pose { origin: terrain.origin, start, x: east, y: south })
    }

    fn bad(&self, name: &str, message: &str) -> Error {
        Error::Parameter { name: name.into(), message: message.into() }
    }

    fn heights(&self, cx: &Context<'_>, relief: &Relief, pose: &Pose) -> Result<Field> {
        let (scale, offset) = (self.height_scale.0, self.height_offset.0);
        let plain = scale == 1.0 && offset == 0.0;
        let to_metres = |out: &mut [f32]| {
            if !plain {
                out.iter_mut().for_each(|v| *v = (f64::from(*v) * scale + offset) as f32);
            }
        };
        let xs = cx.grid.xs();
        if pose.is_upright() {
            let columns = relief.columns(xs.iter().map(|x| pose.at(*x, pose.origin[1])[0]));
            return cx.fill(Quantity::Elevation, |row, out| {
                relief.row(&columns, pose.at(pose.origin[0], row.y)[1], out);
                to_metres(out);
            });
        }
        cx.fill(Quantity::Elevation, |row, out| {
            for (o, x) in out.iter_mut().zip(&xs) {
                let [u, v] = pose.at(*x, row.y);
                *o = relief.height(u, v);
            }
            to_metres(out);
        })
    }
}

/// What the header of a file claims.
fn claim(file: &SourceFile, companions: &[Companion<'_>], reading: &Reading) -> Result<Claim, String> {
    let opened = file.open().map_err(|e| e.to_string())?;
    let (name, limits, watch) = (file.name(), &Limits::default(), Watch::default());
    let input = Input { name, bytes: &*opened, companions, reading, limits, watch };
    input.claim().map_err(|e| e.fault.to_string())
}

/// The content of a file beside another one, which is a page of text at most.
fn beside(cx: &Context<'_>, sidecar: &SourceFile) -> Result<Vec<u8>> {
    let (len, file) = (sidecar.len(), sidecar.name().to_owned());
    if len > HEAD_BYTES {
        let message =
            format!("as a file beside another one must have {HEAD_BYTES} bytes at most, it has {len}");
        return Err(Error::File { parameter: "file", file, message });
    }
    cx.stage(0.0, 0.01).read("file", sidecar)
}

/// From world coordinates to positions in a file, in steps from its north-west sample.
struct Pose {
    /// A place in the world.
    origin: [f64; 2],
    /// Its position in the file.
    start: [f64; 2],
    /// How the position changes with a metre to the east.
    x: [f64; 2],
    /// How the position changes with a metre to the south.
    y: [f64; 2],
}

impl Pose {
    fn is_upright(&self) -> bool {
        self.x[1] == 0.0 && self.y[0] == 0.0
    }

    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let (x, y) = (x - self.origin[0], y - self.origin[1]);
        [self.start[0] + x * self.x[0] + y * self.y[0], self.start[1] + x * self.x[1] + y * self.y[1]]
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

/// A mask of where something holds.
fn mask(cx: &Context<'_>, pose: &Pose, ever: bool, holds: impl Fn(f64, f64) -> bool + Sync) -> Result<Field> {
    let xs = cx.grid.xs();
    cx.fill(Quantity::Mask, |row, out| {
        if ever {
            for (o, x) in out.iter_mut().zip(&xs) {
                let [u, v] = pose.at(*x, row.y);
                *o = f32::from(u8::from(holds(u, v)));
            }
        }
    })
}
