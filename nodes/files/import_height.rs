//! Heights from a file.

use std::sync::Arc;

pub use crate::files::Placing;
use crate::files::{
    ByteOrder, Claim, Closing, Codec, Companion, Encoding, Fault, Input, LONGEST_SIDECAR, Limits, Pose,
    RawSample, Reading, Relief, Request, apart, companions, last_name,
};
use crate::node::SourceFile;
use crate::prelude::*;
use crate::source::reading;
use crate::work::Work;

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
/// Voids of the file come out as a mask and are closed from their border inwards by a smooth membrane. Where the file
/// does not name the number that marks them, `nodata` does. Raw files are samples and nothing else: what they are is
/// said by `sample`, `byte_order` and `cols`, or by a sidecar.
///
/// A file of other proportions than the terrain is distorted when it is stretched over it; by more than one per cent, a
/// warning says so. `orograph fit` makes a terrain that fits.
///
/// # Limits
/// A georeferenced file must be in the coordinate system of the terrain: nothing is reprojected. Degrees and web
/// Mercator are turned to metres at the middle of the file, which serves for a few degrees at most.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportHeight {
    /// The height file.
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
    /// A number of the file that marks voids, beside the one that the file names.
    #[schemars(range(min = -3.5e38, max = 3.5e38), extend("x-soft" = [-32768.0, 65535.0]))]
    pub nodata: Option<Number>,
    /// The type of the samples of a raw file; none takes what its sidecar says, or its extension.
    pub sample: Option<RawSample>,
    /// Which byte of a sample of a raw file comes first; none takes what its sidecar says, or the lowest.
    pub byte_order: Option<ByteOrder>,
    /// Samples in a row of a raw file; none takes what its sidecar says, or those of a square.
    #[schemars(range(min = 1, max = 262_144), extend("x-unit" = "1", "x-soft" = [1, 8193]))]
    pub cols: Option<u32>,
    /// What runs between the samples of the file.
    pub interpolation: Interpolation,
    /// How voids are closed.
    pub fill: Fill,
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
            nodata: None,
            sample: None,
            byte_order: None,
            cols: None,
            interpolation: Interpolation::default(),
            fill: Fill::default(),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Heights in metres.
        height: Field = Meaning::Fixed(Quantity::Elevation),
        /// 1 where the file had no height and one was made up.
        voids: Field = Meaning::Fixed(Quantity::Mask),
        /// 1 inside the rectangle of the file, 0 where its border value continues.
        inside: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for ImportHeight {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().reads(Reads::TERRAIN).migrations(&[same]).keywords(&[
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

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
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

    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost> {
        let content = reading(files);
        let [file, rest @ ..] = files else { return Err(Error::no_file("file")) };
        let late = Codec::of_name(file.name()).is_some_and(|c| !c.claims_early);
        if late && file.known_hash().is_none() {
            return Ok(content);
        }
        let small = rest.iter().filter(|f| f.len() <= LONGEST_SIDECAR);
        let beside: Vec<_> = small.filter_map(|f| Some((f.name(), f.head().ok()?))).collect();
        let beside: Vec<_> = beside.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
        let claim = || claim(file, &beside, &self.reading_as());
        // The size that a pass over the whole content gives is kept on the shelf, since a command plans more than once. It is
        // the same whatever lies beside the file and however its numbers are read.
        let claim = if late {
            file.decoded(b"claim", || Ok((claim()?, size_of::<Claim>() as u64))).map(|claim| *claim)
        } else {
            claim()
        };
        let claim = claim.map_err(|message| self.fault(message))?;
        let surface = Relief::bytes(claim.cols, claim.rows, self.interpolation == Interpolation::Cubic);
        let seconds = claim.cols as f64 * claim.rows as f64 * DECODING_SECONDS;
        Ok(content.and(Cost { bytes: surface.max(claim.bytes), seconds }))
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let relief = self.relief(cx)?;
        let terrain = cx.terrain()?;
        let raster = relief.placed(self.cell);
        let pose = self.placement.pose(terrain, &raster)?;
        self.placement.warnings(terrain, &raster).for_each(|warning| cx.warn(warning));
        relief.notes.iter().for_each(|note| cx.warn(note.clone()));
        if !relief.metres && self.height_scale.0 == 1.0 && self.height_offset.0 == 0.0 {
            let file = &self.file.0;
            cx.warn(format!(
                "`{file}` does not say what its numbers are: they are taken for metres; `height_scale` and `height_offset` \
                 make metres of others"
            ));
        }
        cx.check()?;
        Ok(Outputs {
            height: self.heights(&cx.stage(0.2, 0.8), &relief, &pose)?,
            voids: pose.mask(&cx.stage(0.8, 0.9), relief.has_voids(), |u, v| relief.is_void(u, v))?,
            inside: pose.mask(&cx.stage(0.9, 1.0), true, |u, v| raster.contains(u, v))?,
        })
    }
}

impl ImportHeight {
    /// What the parameters say of the file.
    pub fn reading_as(&self) -> Reading {
        Reading {
            encoding: self.encoding,
            channel: (!self.channel.is_empty()).then(|| self.channel.clone()),
            nodata: self.nodata.map(|n| n.0),
            sample: self.sample,
            byte_order: self.byte_order,
            cols: self.cols.map(u64::from),
        }
    }

    /// What is wrong with the file.
    fn fault(&self, message: String) -> Error {
        Error::File { parameter: "file", file: self.file.0.clone(), message }
    }

    /// The surface of the file, made once however many tiles and nodes ask.
    fn relief(&self, cx: &Context<'_>) -> Result<Arc<Relief>> {
        let name = &self.file.0;
        if name.is_empty() {
            return Err(Error::no_file("file"));
        }
        let fault = |message: String| self.fault(message);
        let file = cx.file(&self.file).ok_or_else(|| fault("not found".into()))?;
        let names = companions(name);
        let mut found = Vec::new();
        for name in &names {
            if let Some(file) = cx.file(&FilePath(name.clone()))
                && let Some(bytes) = beside(cx, file)?
            {
                found.push((name, bytes));
            }
        }
        let companions: Vec<_> = found.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
        let (scale, offset) = (self.height_scale.0, self.height_offset.0);
        let closing = match self.fill {
            Fill::Smooth => Closing::Smooth,
            Fill::Level { height } if scale != 0.0 => Closing::Level(((height.0 - offset) / scale) as f32),
            Fill::Level { .. } => Closing::Level(0.0),
        };
        let reading = self.reading_as();
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
            let work = cx.work.quiet();
            let relief = apart(|| Relief::new(&way, &bytes, &limits, work)).map_err(|e| match e.fault {
                Fault::Cancelled => Error::Cancelled,
                other => fault(other.to_string()),
            })?;
            let held = relief.held_bytes();
            Ok((relief, held))
        })
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
    let (name, limits, work) = (file.name(), &Limits::default(), Work::default());
    let input = Input { name, bytes: &*opened, companions, reading, limits, work };
    input.claim().map_err(|e| e.fault.to_string())
}

/// The content of a file beside another one, which is a page of text at most.
fn beside(cx: &Context<'_>, file: &SourceFile) -> Result<Option<Vec<u8>>> {
    let (len, name) = (file.len(), last_name(file.name()));
    if len > LONGEST_SIDECAR {
        cx.warn(format!("`{name}` is not read: it has {len} bytes, and what stands beside a file has {LONGEST_SIDECAR} at most"));
        return Ok(None);
    }
    cx.stage(0.0, 0.01).read("file", file).map(Some)
}

/// Version 2 believes a sidecar of the file alone and reads more of what files say: the parameters stay.
fn same(_: &mut serde_json::Map<String, serde_json::Value>) {}
