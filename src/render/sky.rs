//! The atmosphere: colours of sun, sky and distant air from one model.
//!
//! A plane-parallel clear atmosphere scatters the sunlight once, by molecules and by haze; the closed form of that
//! integral is \[chandrasekhar1960, §1\]'s first order. Light that was scattered more often is added as a
//! bluish share that grows with the length of the way through the air, fitted by eye. Radiance is in units in
//! which the sun above the atmosphere gives an irradiance of 1.

use super::Sun;

/// Optical depth of the whole atmosphere straight up, for red, green and blue, of the molecules …
const MOLECULES: [f64; 3] = [0.044, 0.096, 0.228];
/// … and of the haze of a clear day.
const HAZE: [f64; 3] = [0.070, 0.074, 0.080];
/// How far forward the haze scatters (the asymmetry of Henyey and Greenstein).
const FORWARD: f64 = 0.74;
/// The sun's radius as drawn, in degrees: three times the real one, which a picture would not show.
const DISC: f64 = 0.8;

/// How bright level ground comes out of the exposure, in units of its reflectance.
const BRIGHTNESS: f64 = 1.35;
/// How much brighter the sky is shown than it is: a picture of land is exposed for the land.
const SKY_BRIGHTNESS: f64 = 1.7;
/// Entries of the table of far air: it is a smooth function.
const AIR: usize = 512;
/// Height above the horizon of the air before far land.
const AIR_UP: f64 = 0.05;

/// East, south and up.
pub(super) type Direction = [f64; 3];

/// The lit atmosphere.
#[derive(Clone, Debug)]
pub(super) struct Sky {
    /// Towards the sun.
    pub(super) to_sun: Direction,
    /// Light of the sun on a surface that faces it.
    pub(super) sunlight: [f32; 3],
    /// Light of the whole sky on level ground.
    pub(super) skylight: [f32; 3],
    sun_mass: f64,
    /// Exposure and white balance.
    gain: [f64; 3],
    /// The light of far air by the cosine of the angle to the sun, from -1 to 1.
    air: Vec<[f32; 3]>,
}

impl Sky {
    /// The sky with an exposure (in stops) under which level ground of some reflectance looks that bright.
    pub(super) fn new(sun: Sun, stops: f64) -> Self {
        let (azimuth, altitude) = (sun.azimuth.to_radians(), sun.altitude.to_radians());
        let up = libm::sin(altitude);
        let flat = libm::cos(altitude);
        let to_sun = [flat * libm::sin(azimuth), -flat * libm::cos(azimuth), up];
        let sun_mass = air_mass(up);
        let mut sky = Self {
            to_sun,
            sunlight: [0.0; 3],
            skylight: [0.0; 3],
            sun_mass,
            gain: [1.0; 3],
            air: Vec::new(),
        };
        let sunlight = transmitted(sky.sun_mass);
        let skylight = sky.irradiance();
        let total: [f64; 3] = std::array::from_fn(|k| sunlight[k] * (0.45 + 0.55 * up) + skylight[k]);
        let grey = 0.2126 * total[0] + 0.7152 * total[1] + 0.0722 * total[2];
        // The eye takes the light for nearly white: half of its cast is taken out.
        let exposure = BRIGHTNESS * std::f64::consts::PI / grey * libm::exp2(stops);
        sky.gain = total.map(|x| exposure * (grey / x).sqrt());
        let matt =
            |light: [f64; 3]| std::array::from_fn(|k| (light[k] * sky.gain[k] / std::f64::consts::PI) as f32);
        (sky.sunlight, sky.skylight) = (matt(sunlight), matt(skylight));
        sky.air = (0..=AIR).map(|n| sky.far_air(n as f64 * 2.0 / AIR as f64 - 1.0)).collect();
        sky
    }

    /// The radiance of the sky in a direction of length 1; below the horizon that of the horizon.
    pub(super) fn radiance(&self, direction: Direction) -> [f32; 3] {
        let along = dot(direction, self.to_sun);
        let mut light = self.shown(self.scattered(direction[2].max(0.0), along));
        // The disc itself, with an edge of a tenth of its radius.
        let edge = libm::cos(DISC.to_radians());
        if direction[2] > 0.0 && along > edge {
            let disc = (((along - edge) / (1.0 - edge) * 5.0).min(1.0) * 8.0) as f32;
            for (light, sun) in light.iter_mut().zip(self.sunlight) {
                *light += disc * sun;
            }
        }
        light
    }

    /// The colour that far land takes on in a direction.
    pub(super) fn airlight(&self, direction: Direction) -> [f32; 3] {
        let flat = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt().max(1e-6);
        let level = (1.0 - AIR_UP * AIR_UP).sqrt() / flat;
        let along = dot([direction[0] * level, direction[1] * level, AIR_UP], self.to_sun).clamp(-1.0, 1.0);
        let x = (along + 1.0) * 0.5 * AIR as f64;
        let k = (x as usize).min(AIR - 1);
        let u = (x - k as f64) as f32;
        std::array::from_fn(|c| self.air[k][c] + u * (self.air[k + 1][c] - self.air[k][c]))
    }

    /// The air before land has less glow than the sky, since the land hides most of it.
    fn far_air(&self, along: f64) -> [f32; 3] {
        let (bright, even) = (self.scattered(AIR_UP, along.min(0.9)), self.scattered(AIR_UP, 0.0));
        self.shown(std::array::from_fn(|k| 0.45 * bright[k] + 0.55 * even[k]))
    }

    fn shown(&self, light: [f64; 3]) -> [f32; 3] {
        std::array::from_fn(|k| (light[k] * self.gain[k] * SKY_BRIGHTNESS) as f32)
    }

    fn scattered(&self, up: f64, along_sun: f64) -> [f64; 3] {
        let (view, sun) = (air_mass(up).min(14.0), self.sun_mass);
        let molecules = 0.75 * (1.0 + along_sun * along_sun);
        let g = FORWARD;
        let lobe = 1.0 + g * g - 2.0 * g * along_sun;
        let haze = (1.0 - g * g) / (lobe * lobe.sqrt());
        std::array::from_fn(|k| {
            let depth = MOLECULES[k] + HAZE[k];
            let phase = (molecules * MOLECULES[k] + haze * HAZE[k]) / depth;
            let path = if (view - sun).abs() < 1e-3 {
                depth * view * libm::exp(-depth * sun)
            } else {
                view / (view - sun) * (libm::exp(-depth * sun) - libm::exp(-depth * view))
            };
            let again = [0.21, 0.245, 0.375][k] * (1.0 - libm::exp(-1.6 * depth * view));
            (phase * path + again * libm::exp(-0.6 * depth * sun)) / (4.0 * std::f64::consts::PI)
        })
    }

    /// The light of the sky on level ground: the integral of radiance over the hemisphere.
    fn irradiance(&self) -> [f64; 3] {
        const RINGS: usize = 12;
        const SECTORS: usize = 24;
        let mut sum = [0.0; 3];
        for ring in 0..RINGS {
            // Rings of equal weight of the cosine: sin² of the angle from the zenith is even.
            let up = (1.0 - (ring as f64 + 0.5) / RINGS as f64).sqrt();
            let flat = (1.0 - up * up).sqrt();
            for sector in 0..SECTORS {
                let angle = (sector as f64 + 0.5) / SECTORS as f64 * std::f64::consts::TAU;
                let direction = [flat * libm::cos(angle), flat * libm::sin(angle), up];
                let light = self.scattered(up, dot(direction, self.to_sun));
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += light * std::f64::consts::PI / (RINGS * SECTORS) as f64;
                }
            }
        }
        sum
    }
}

pub(super) fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The way through the air in units of the way straight up \[kasten1989\].
fn air_mass(up: f64) -> f64 {
    let degrees = libm::asin(up.clamp(0.0, 1.0)).to_degrees();
    1.0 / (up + 0.50572 * libm::pow(degrees + 6.07995, -1.6364))
}

fn transmitted(mass: f64) -> [f64; 3] {
    std::array::from_fn(|k| libm::exp(-(MOLECULES[k] + 0.6 * HAZE[k]) * mass))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(altitude: f64) -> Sky {
        Sky::new(Sun { azimuth: 90.0, altitude }, 0.0)
    }

    #[test]
    fn the_sun_stands_where_the_compass_says() {
        let [east, south, up] = sky(30.0).to_sun;
        assert!((up - 0.5).abs() < 1e-12 && east > 0.86 && south.abs() < 1e-12);
        let north = Sky::new(Sun { azimuth: 0.0, altitude: 30.0 }, 0.0);
        assert!(north.to_sun[1] < -0.86);
    }

    #[test]
    fn sky_is_blue_above_pale_at_the_horizon_and_bright_at_the_sun() {
        let sky = sky(40.0);
        let zenith = sky.radiance([0.0, 0.0, 1.0]);
        let horizon = sky.radiance([-1.0, 0.0, 0.0]);
        assert!(zenith[2] > 1.6 * zenith[0], "{zenith:?}");
        let blueness = |light: [f32; 3]| light[2] / light[0];
        assert!(blueness(horizon) < 0.8 * blueness(zenith), "{horizon:?} {zenith:?}");
        assert!(horizon[1] > zenith[1], "{horizon:?} {zenith:?}");
        let (a, b) = (libm::cos(0.6), libm::sin(0.6));
        assert!(sky.radiance([a, 0.0, b])[1] > 1.5 * sky.radiance([-a, 0.0, b])[1]);
    }

    #[test]
    fn a_low_sun_is_warmer() {
        let warmth = |altitude| sky(altitude).sunlight[0] / sky(altitude).sunlight[2];
        assert!(warmth(5.0) > 1.5 * warmth(30.0) && warmth(30.0) > warmth(80.0));
    }
}
