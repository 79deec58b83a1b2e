//! Colour spaces: sRGB as picture files hold it, linear light, and Oklab, in which equal steps look equal.

/// Linear light from an sRGB-encoded component, 0 to 1 (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f32) -> f32 {
    let v = f64::from(encoded);
    (if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }) as f32
}

/// The sRGB encoding of a component of linear light, clipped to 0 to 1 (IEC 61966-2-1).
pub fn srgb_from_linear(light: f32) -> f32 {
    let v = f64::from(light.clamp(0.0, 1.0));
    (if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 }) as f32
}

/// Lightness and two colour axes of Oklab from linear light \[ottosson2020\].
pub fn oklab_from_linear([r, g, b]: [f32; 3]) -> [f32; 3] {
    let l = libm::cbrtf(0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b);
    let m = libm::cbrtf(0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b);
    let s = libm::cbrtf(0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b);
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// Linear light from Oklab; components may leave 0 to 1 where the colour is outside sRGB \[ottosson2020\].
pub fn linear_from_oklab([lightness, a, b]: [f32; 3]) -> [f32; 3] {
    let cube = |x: f32| x * x * x;
    let l = cube(lightness + 0.396_337_78 * a + 0.215_803_76 * b);
    let m = cube(lightness - 0.105_561_346 * a - 0.063_854_17 * b);
    let s = cube(lightness - 0.089_484_18 * a - 1.291_485_5 * b);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

/// Oklab from an sRGB-encoded colour.
pub fn oklab_from_srgb(color: [f32; 3]) -> [f32; 3] {
    oklab_from_linear(color.map(linear_from_srgb))
}

/// The sRGB encoding of an Oklab colour, clipped to what sRGB can show.
pub fn srgb_from_oklab(lab: [f32; 3]) -> [f32; 3] {
    linear_from_oklab(lab).map(srgb_from_linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_has_the_published_pairs() {
        // Table of pairs XYZ -> Oklab in Ottosson's post, and the primaries as CSS Color 4 lists them.
        for (srgb, lab) in [
            ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.62796, 0.22486, 0.12585]),
            ([0.0, 1.0, 0.0], [0.86644, -0.23389, 0.17950]),
            ([0.0, 0.0, 1.0], [0.45201, -0.03246, -0.31153]),
        ] {
            let found = oklab_from_srgb(srgb);
            for k in 0..3 {
                assert!((found[k] - lab[k]).abs() < 1e-4, "{srgb:?}: {found:?} is not {lab:?}");
            }
        }
    }

    #[test]
    fn encodings_invert_each_other() {
        for i in 0..=255u8 {
            let v = f32::from(i) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(v)) - v).abs() < 1e-6);
            let color = [v, 1.0 - v, 0.5 * v];
            let back = srgb_from_oklab(oklab_from_srgb(color));
            for k in 0..3 {
                assert!((back[k] - color[k]).abs() < 2e-3, "{color:?} came back as {back:?}");
            }
        }
    }
}
