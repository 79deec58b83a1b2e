//! Colours and a mask from a picture.

use std::sync::Arc;

use crate::files::{
    Channel, Kernel, Limits, Mixture, Picture, PictureClaim, PixelSpan, Placed, Placement, Placing, Pose,
    Texture, apart,
};
use crate::node::SourceFile;
use crate::prelude::*;
use crate::source::Stream;
use crate::source::reading;
use crate::value::{Raster, Sample};

/// Reads colours and a mask from a picture and lays them on the terrain.
///
/// It reads PNG, JPEG, WebP, BMP, TGA and the merged image of a PSD or PSB. It is placed as a height file is: the
/// middles of its outermost pixels lie on the border of its rectangle, and beyond it the border goes on. Where a sample
/// of the terrain stands for more than one pixel, it gets the mean of them, of colours as light; where the picture is
/// drawn out, a cubic curve runs from pixel to pixel.
///
/// The mask is opacity or brightness, as the numbers of the file have it: a grey picture of 8 or 16 bits that was
/// painted as a mask, or written by an output, comes back as it was.
///
/// # Limits
/// Colours are taken for sRGB: a profile in the file is not looked at, and neither is the note of a camera that it was
/// held upright. A PSD must be in RGB, greyscale, duotone or indexed colours; its first channel beside the colours is its
/// opacity. Below the base cell a picture is averaged only on grids that are finer than the base grid, so that a mask
/// picks the same places at every size.
///
/// # See also
/// `import_height` for heights, `colorize` for colours by height.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportPicture {
    /// The picture.
    pub file: FilePath,
    /// Where it goes.
    pub placement: PicturePlacing,
    /// What the mask is made of.
    pub mask: Channel,
    /// What runs between its pixels where it is drawn out.
    pub interpolation: Kernel,
}

/// Where a picture goes on the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PicturePlacing {
    /// Over the whole terrain, each axis by itself.
    #[default]
    Stretch,
    /// At a size of its own.
    TrueSize {
        /// Distance between its pixels.
        #[serde(default = "one_metre")]
        #[schemars(range(min = 0.001, max = 1.0e6), extend("x-soft" = [0.1, 100.0], "x-log" = true))]
        cell: Metres,
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

fn one_metre() -> Metres {
    Metres(1.0)
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Colours, sRGB encoded.
        colors: Colors,
        /// Opacity or brightness, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
        /// 1 inside the rectangle of the picture, 0 where its border goes on.
        inside: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for ImportPicture {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().reads(Reads::TERRAIN.and(Reads::BASE)).keywords(&[
        "image",
        "texture",
        "photo",
        "satellite",
        "colour",
        "color",
        "splat",
        "mask",
        "alpha",
        "png",
        "jpeg",
        "psd",
        "load",
        "open",
    ]);

    fn reach(&self) -> Reach {
        // A sample is the mean of the picture around it.
        Reach::local(0.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let cost = Cost::per_sample(grid, if self.is_turned() { 900.0 } else { 250.0 });
        // Prepared columns, and a line of texels for each row in work.
        Cost { bytes: grid.cols as u64 * 192 + (1 << 22), ..cost }
    }

    fn files(&self) -> Vec<FileRequest> {
        let named = !self.file.0.is_empty();
        let request = || FileRequest { parameter: "file", name: self.file.0.clone(), optional: false };
        named.then(request).into_iter().collect()
    }

    fn reading(&self, files: &[Arc<SourceFile>]) -> Result<Cost> {
        let read = reading(files);
        let Some(file) = files.first() else { return Err(Error::no_file("file")) };
        let opened = file.open().map_err(|e| e.of("file", file.name()))?;
        let claim = PictureClaim::of(file.name(), &mut Stream::new(&*opened), &Limits::default());
        let claim = claim.map_err(|e| self.fault(e.fault.to_string()))?;
        let pixels = claim.cols.saturating_mul(claim.rows);
        // Smaller pictures of it take less than half as many texels, and one of them stands at a time.
        let texture = Texture::bytes(claim.cols, claim.rows, [1, 2]);
        Ok(read.and(Cost { bytes: claim.bytes().saturating_add(texture), seconds: pixels as f64 * 3e-8 }))
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let picture = self.picture(cx)?;
        let terrain = cx.terrain()?;
        let (placing, cell) = self.placing();
        let raster = Placed { cols: picture.cols, rows: picture.rows, placement: Placement::default(), cell };
        let pose = placing.pose(terrain, &raster)?;
        placing.warnings(terrain, &raster).for_each(|warning| cx.warn(warning));
        picture.notes.iter().for_each(|note| cx.warn(note.clone()));
        // As the base grid reads it on all coarser grids, too: a mask picks the same places at every size.
        let footprint = pose.footprint(cx.grid.cell().min(cx.base_cell()?));
        let texture = self.texture(cx, &picture, footprint)?;
        cx.check()?;
        let (colors, mask) = self.draw(&cx.stage(0.5, 0.95), &texture, &pose, footprint)?;
        let inside = pose.mask(&cx.stage(0.95, 1.0), true, |u, v| raster.contains(u, v))?;
        Ok(Outputs { colors, mask, inside })
    }
}

impl ImportPicture {
    fn placing(&self) -> (Placing, Option<Metres>) {
        match self.placement {
            PicturePlacing::Stretch => (Placing::Stretch, None),
            PicturePlacing::TrueSize { cell, x, y, rotation } => {
                (Placing::TrueSize { x, y, rotation }, Some(cell))
            }
        }
    }

    fn is_turned(&self) -> bool {
        matches!(self.placement, PicturePlacing::TrueSize { rotation, .. } if rotation.0 != 0.0)
    }

    fn source<'a>(&self, cx: &Context<'a>) -> Result<&'a Arc<SourceFile>> {
        if self.file.0.is_empty() {
            return Err(Error::no_file("file"));
        }
        cx.file(&self.file).ok_or_else(|| self.fault("not found".into()))
    }

    fn fault(&self, message: String) -> Error {
        Error::File { parameter: "file", file: self.file.0.clone(), message }
    }

    /// The pixels, read once however many tiles and nodes ask.
    fn picture(&self, cx: &Context<'_>) -> Result<Arc<Picture>> {
        let file = self.source(cx)?;
        file.decoded(b"picture", || {
            let bytes = cx.stage(0.0, 0.2).read("file", file)?;
            let picture = Picture::read(&self.file.0, &bytes, &Limits::default(), &cx.work);
            cx.check()?;
            let picture = picture.map_err(|e| self.fault(e.fault.to_string()))?;
            let held = picture.bytes();
            Ok((picture, held))
        })
    }

    /// The pixels made smaller, for a footprint.
    fn texture(
        &self,
        cx: &Context<'_>,
        picture: &Arc<Picture>,
        footprint: PixelSpan,
    ) -> Result<Arc<Texture>> {
        let reduction = footprint.reduction(self.interpolation);
        let way = format!("texture {:?} {reduction:?}", self.mask);
        self.source(cx)?.decoded(way.as_bytes(), || {
            let made = apart(|| Texture::new(picture, self.mask, reduction, &cx.work));
            cx.check()?;
            Ok((made, Texture::bytes(picture.cols as u64, picture.rows as u64, reduction)))
        })
    }

    fn draw(
        &self,
        cx: &Context<'_>,
        texture: &Texture,
        pose: &Pose,
        footprint: PixelSpan,
    ) -> Result<(Colors, Field)> {
        let colors =
            self.fill(&cx.stage(0.0, 0.7), Quantity::Color, texture, pose, footprint, |m| m.color())?;
        let mask = self.fill(&cx.stage(0.7, 1.0), Quantity::Mask, texture, pose, footprint, |m| m.mask())?;
        Ok((colors, mask))
    }

    fn fill<T: Sample>(
        &self,
        cx: &Context<'_>,
        quantity: Quantity,
        texture: &Texture,
        pose: &Pose,
        footprint: PixelSpan,
        of: impl Fn(&Mixture<'_>) -> T + Sync,
    ) -> Result<Raster<T>> {
        let (kernel, xs) = (self.interpolation, cx.grid.xs());
        if pose.is_upright() {
            let positions = xs.iter().map(|x| pose.at(*x, pose.origin[1])[0]);
            let columns = texture.columns(positions, footprint, kernel);
            return cx.fill(quantity, |row, out| {
                texture.row(&columns, pose.at(pose.origin[0], row.y)[1], footprint, kernel, out, &of);
            });
        }
        cx.fill(quantity, |row, out| {
            for (o, x) in out.iter_mut().zip(&xs) {
                *o = texture.at(pose.at(*x, row.y), footprint, kernel, &of);
            }
        })
    }
}
