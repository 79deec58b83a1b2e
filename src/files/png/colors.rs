//! Heights in the three channels of a colour picture, and what tells them from a picture of something else.

use super::super::height::Encoding;

/// What Terrarium adds to a height, in metres.
const TERRARIUM_OFFSET: f64 = 32768.0;
/// Height of the number 0 in Mapbox's Terrain-RGB, in metres.
const TERRAIN_RGB_ZERO: f64 = -10_000.0;
/// Heights on Earth, in metres, with room: what makes sense as Terrarium.
const ON_EARTH: [f64; 2] = [-12_000.0, 9_500.0];

/// The number that red, green and blue are the digits of.
pub(super) fn number([r, g, b]: [u8; 3]) -> u32 {
    u32::from(r) << 16 | u32::from(g) << 8 | u32::from(b)
}

/// Metres of a pixel's number.
pub(super) fn metres(number: u32, encoding: Encoding) -> f32 {
    let n = f64::from(number);
    // 24 bits fit an f32: Terrarium heights are exact.
    match encoding {
        Encoding::TerrainRgb => (TERRAIN_RGB_ZERO + n / 10.0) as f32,
        _ => (n / 256.0 - TERRARIUM_OFFSET) as f32,
    }
}

/// The number that Terrarium metres stand for.
fn number_of(height: f32) -> u32 {
    ((f64::from(height) + TERRARIUM_OFFSET) * 256.0) as u32
}

/// Red, green and blue of Terrarium metres.
pub(super) fn color_of(height: f32) -> [u8; 3] {
    let [_, r, g, b] = number_of(height).to_be_bytes();
    [r, g, b]
}

/// Pairs of neighbours, and what they say.
#[derive(Clone, Copy, Debug, Default)]
struct Pairs {
    /// Red differs.
    coarse: u64,
    /// Of those, the heights differ by less than half a step of red.
    carried: u64,
    /// Red is the same, green differs.
    fine: u64,
    /// Sum of the differences of blue over those.
    blue: u64,
}

/// Why a colour picture, read as Terrarium, is none; `None` where it seems to be one.
///
/// Where a height passes a multiple of 256 m, red goes up by one and green falls from its highest to its lowest value:
/// a digit is carried. In a picture of something else the channels go up and down together. Where red is the same all
/// over, blue tells: as the last digit it is 0 or jumps from pixel to pixel.
pub(super) fn doubt(cols: usize, heights: &[f32]) -> Option<String> {
    let off = |v: &&f32| !v.is_nan() && !(ON_EARTH[0]..=ON_EARTH[1]).contains(&f64::from(**v));
    if let Some(v) = heights.iter().find(off) {
        return Some(format!("as a Terrarium tile it would be {v} m high"));
    }
    let mut pairs = Pairs::default();
    for (j, row) in heights.chunks_exact(cols.max(1)).enumerate() {
        row.iter().zip(&row[1..]).for_each(|(a, b)| pairs.take(*a, *b));
        if j > 0 {
            let above = &heights[(j - 1) * cols..][..cols];
            above.iter().zip(row).for_each(|(a, b)| pairs.take(*a, *b));
        }
    }
    let channels = if pairs.coarse > 0 {
        // A tenth is far more than a photograph has, and far less than a tile.
        10 * pairs.carried < pairs.coarse
    } else {
        let blue = |v: &f32| v.is_nan() || color_of(*v)[2] == 0;
        let jumps = pairs.fine > 0 && pairs.blue / pairs.fine >= 24;
        !jumps && !heights.iter().all(blue)
    };
    channels.then(|| "its channels are not the digits of heights".into())
}

impl Pairs {
    fn take(&mut self, a: f32, b: f32) {
        if a.is_nan() || b.is_nan() {
            return;
        }
        let ([r, g, blue], [r2, g2, blue2]) = (color_of(a), color_of(b));
        if r != r2 {
            self.coarse += 1;
            self.carried += u64::from((a - b).abs() < 128.0);
        } else if g != g2 {
            self.fine += 1;
            self.blue += u64::from(blue.abs_diff(blue2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(cols: usize, rows: usize, pixel: impl Fn(usize, usize) -> [u8; 3]) -> Vec<f32> {
        (0..cols * rows).map(|k| metres(number(pixel(k % cols, k / cols)), Encoding::Terrarium)).collect()
    }

    #[test]
    fn numbers_come_back() {
        for color in [[128, 0, 0], [127, 255, 255], [136, 77, 128], [163, 1, 2]] {
            assert_eq!(color_of(metres(number(color), Encoding::Terrarium)), color);
        }
        // The sample of Mapbox's own page.
        assert_eq!(metres(number([1, 134, 160]), Encoding::TerrainRgb), 0.0);
        assert_eq!(metres(number([1, 212, 192]), Encoding::TerrainRgb), 2000.0);
    }

    #[test]
    fn tiles_are_believed() {
        let tile = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
            (0..64 * 64).map(|k| f((k % 64) as f32, (k / 64) as f32)).collect()
        };
        let hills = |x: f32, y: f32| 700.0 + 300.0 * libm::sinf(x / 9.0) * libm::cosf(y / 7.0);
        for (name, heights) in [
            ("hills", tile(&hills)),
            ("hills in whole metres", tile(&|x, y| hills(x, y).round())),
            ("a plain", tile(&|x, y| 20.0 + x / 7.0 + y / 11.0)),
            ("the sea", tile(&|_, _| 0.0)),
            ("steep", tile(&|x, y| 3000.0 + 45.0 * x + 30.0 * y)),
        ] {
            let exact: Vec<f32> = heights.iter().map(|v| (v * 256.0).floor() / 256.0).collect();
            assert_eq!(doubt(64, &exact), None, "{name}");
        }
    }

    #[test]
    fn pictures_are_not() {
        let sepia = |x: usize, y: usize| {
            let v = (x + y) as f32 / 2.0;
            [100.0 + 0.6 * v, 80.0 + 0.5 * v, 60.0 + 0.4 * v].map(|c| c as u8)
        };
        let noise = |x: usize, y: usize| {
            let v = crate::kit::hash::nth(3, (y * 64 + x) as u64);
            [110 + (v % 20) as u8, 100 + (v % 23) as u8, 90 + (v % 19) as u8]
        };
        for (name, heights) in [
            ("sepia", read(64, 64, sepia)),
            ("noise", read(64, 64, noise)),
            ("green and blue", read(64, 64, |x, y| [128, 2 * x as u8, 60 + y as u8])),
            ("one colour", read(64, 64, |_, _| [150, 100, 50])),
            ("too dark", read(64, 64, |_, _| [10, 100, 50])),
        ] {
            assert!(doubt(64, &heights).is_some(), "{name}");
        }
    }
}
