//! The finished picture: exposure, film curve, encoding.

use std::sync::LazyLock;

use crate::kit::color::srgb_from_linear;
use crate::node::{Error, Result};

/// A picture of 8 bits a channel, sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue, `width · height` of them.
    pub rgb: Vec<[u8; 3]>,
}

impl Picture {
    /// The colour of a pixel; the nearest one beyond the border.
    pub fn at(&self, column: usize, row: usize) -> [u8; 3] {
        self.rgb[row.min(self.height - 1) * self.width + column.min(self.width - 1)]
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// When width, height and pixels do not belong together.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let fault = |e: png::EncodingError| Error::Output { port: "picture".into(), message: e.to_string() };
        let side = |pixels: usize| {
            u32::try_from(pixels).map_err(|_| Error::Output {
                port: "picture".into(),
                message: format!("has {pixels} pixels along a side, a PNG at most {}", u32::MAX),
            })
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width)?, side(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header().map_err(fault)?;
        writer.write_image_data(bytemuck::cast_slice(&self.rgb)).map_err(fault)?;
        writer.finish().map_err(fault)?;
        Ok(bytes)
    }
}

/// Steps of the tables below; both are smooth in the square root of light, so that interpolation is exact to
/// far less than one level of 255.
const STEPS: usize = 2048;
/// Brightest light that the film tells apart; white is reached long before.
const BRIGHTEST: f32 = 16.0;

/// What the film shows of light: a straight middle, a soft toe, a shoulder that rolls off to white.
///
/// The curve of \[uchimura2017\], with a toe that is a little harder than a straight line.
fn film_curve(light: f64) -> f64 {
    const START: f64 = 0.20;
    const LENGTH: f64 = 0.36;
    const TOE: f64 = 1.12;
    let shoulder = START + (1.0 - START) * LENGTH;
    let toe = START * libm::pow(light / START, TOE);
    let rolled = 1.0 - (1.0 - shoulder) * libm::exp(-(light - shoulder) / (1.0 - shoulder));
    let rise = |lo: f64, hi: f64| {
        let u = ((light - lo) / (hi - lo)).clamp(0.0, 1.0);
        u * u * (3.0 - 2.0 * u)
    };
    let (in_toe, in_shoulder) = (1.0 - rise(0.0, START), if light > shoulder { 1.0 } else { 0.0 });
    toe * in_toe + light * (1.0 - in_toe - in_shoulder) + rolled * in_shoulder
}

fn read(table: &[f32], light: f32, brightest: f32) -> f32 {
    let x = (light.clamp(0.0, brightest) / brightest).sqrt() * STEPS as f32;
    let k = (x as usize).min(STEPS - 1);
    table[k] + (table[k + 1] - table[k]) * (x - k as f32)
}

fn table(brightest: f32, f: impl Fn(f32) -> f32) -> Vec<f32> {
    let root = |k: usize| k as f32 / STEPS as f32;
    (0..=STEPS).map(|k| f(root(k) * root(k) * brightest)).collect()
}

/// Linear light of the scene to linear light of the screen, 0 to 1.
pub(super) fn developed(light: [f32; 3]) -> [f32; 3] {
    static FILM: LazyLock<Vec<f32>> =
        LazyLock::new(|| table(BRIGHTEST, |light| film_curve(f64::from(light)) as f32));
    // Very bright colours run to white as they do on film, instead of clipping to a garish hue.
    let bright = light[0].max(light[1]).max(light[2]);
    let bleach = ((bright - 0.8) / 6.0).clamp(0.0, 0.6);
    light.map(|x| read(&FILM, x + (bright - x) * bleach, BRIGHTEST))
}

/// Linear light of the screen to 8 bits; `dither` from -0.5 to 0.5 levels keeps smooth skies from banding.
pub(super) fn encoded(screen: [f32; 3], dither: f32) -> [u8; 3] {
    static SRGB: LazyLock<Vec<f32>> = LazyLock::new(|| table(1.0, srgb_from_linear));
    screen.map(|x| (read(&SRGB, x, 1.0) * 255.0 + 0.5 + dither).clamp(0.0, 255.0) as u8)
}

/// An even-looking pattern from -0.5 to 0.5, without clumps.
pub(super) fn dither(column: usize, row: usize) -> f32 {
    // Interleaved gradient noise [jimenez2014].
    let a = 0.067_110_56 * column as f64 + 0.005_837_15 * row as f64;
    let b = 52.982_918_9 * (a - a.floor());
    (b - b.floor()) as f32 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn film_rises_from_black_to_white_without_jumps() {
        let mut before = 0.0;
        for i in 0..=20_000 {
            let now = film_curve(f64::from(i) / 2000.0);
            assert!(now >= before && now - before < 1e-3, "at {i}: {before} to {now}");
            before = now;
        }
        assert_eq!(film_curve(0.0), 0.0);
        assert!(before > 0.999 && before <= 1.0);
    }

    #[test]
    fn encoding_hits_every_level() {
        for level in 0..=255u8 {
            let light = crate::kit::color::linear_from_srgb(f32::from(level) / 255.0);
            assert_eq!(encoded([light; 3], 0.0), [level; 3]);
        }
    }

    #[test]
    fn png_comes_back_as_it_was() {
        let rgb = (0..35u8).map(|i| [i, 2 * i, 255 - i]).collect();
        let picture = Picture { width: 7, height: 5, rgb };
        let bytes = picture.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!((reader.info().width, reader.info().height), (7, 5));
        assert_eq!(pixels, bytemuck::cast_slice::<_, u8>(&picture.rgb));
    }
}
