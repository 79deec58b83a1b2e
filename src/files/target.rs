//! The engines that outputs are meant for: what they take, and what a person must type there.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::codec::Format;
use crate::params::did_you_mean;

/// An engine that an output is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Unreal Engine landscapes: 16-bit PNG or r16, 32768 is height zero.
    Unreal,
    /// Unity terrains: RAW16, the southernmost row first.
    Unity,
    /// Terrain3D for Godot: OpenEXR in metres.
    Godot,
}

/// Vertices along a side of the landscapes that Unreal recommends.
const UNREAL_SIDES: [usize; 5] = [505, 1009, 2017, 4033, 8129];
/// Vertices along a side that Unity's terrains take: 2ⁿ + 1.
const UNITY_SIDES: [usize; 8] = [33, 65, 129, 257, 513, 1025, 2049, 4097];
/// Integer that Unreal takes for height zero.
const UNREAL_ZERO: f64 = 32768.0;
/// Centimetres of a step at a Z scale of 1 in Unreal.
const UNREAL_STEP: f64 = 1.0 / 128.0;

impl Target {
    /// Every target.
    pub const ALL: [Self; 3] = [Self::Unreal, Self::Unity, Self::Godot];

    /// The name in graphs and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreal => "unreal",
            Self::Unity => "unity",
            Self::Godot => "godot",
        }
    }

    /// The format it is given where none is asked for.
    pub fn format(self) -> Format {
        match self {
            Self::Unreal => Format::Png16,
            Self::Unity => Format::R16,
            Self::Godot => Format::Exr,
        }
    }

    /// Whether it can open a format.
    pub fn takes(self, format: Format) -> bool {
        match self {
            Self::Unreal => matches!(format, Format::Png16 | Format::R16),
            Self::Unity => format == Format::R16,
            Self::Godot => matches!(format, Format::Exr | Format::R16 | Format::Png8 | Format::Png16),
        }
    }

    /// Whether it wants the southernmost row first.
    pub fn flip(self) -> bool {
        self == Self::Unity
    }

    /// The range for heights from one value to another, where none is asked for and the format needs one.
    ///
    /// For Unreal the integer 32768 stands for exactly 0 m, so that nothing has to be moved there; for the others
    /// the range is what the heights take.
    pub fn range(self, [lo, hi]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Unreal => {
                let step = (lo.abs() / UNREAL_ZERO).max(hi.abs() / (65535.0 - UNREAL_ZERO)).max(1e-6);
                [-step * UNREAL_ZERO, step * (65535.0 - UNREAL_ZERO)]
            }
            Self::Unity | Self::Godot => [lo, if hi > lo { hi } else { lo + 1.0 }],
        }
    }

    /// What a person must type there for a file of a range and a cell.
    pub(super) fn notes(
        self,
        range: Option<[f64; 2]>,
        cell: [f64; 2],
        [cols, rows]: [usize; 2],
    ) -> Vec<String> {
        let [dx, dy] = cell;
        let (east, south) = (dx * (cols - 1) as f64, dy * (rows - 1) as f64);
        let spacing = if dx == dy {
            short(dx)
        } else {
            format!("{} x {}, and it takes square cells", short(dx), short(dy))
        };
        match (self, range) {
            (Self::Unreal, Some([lo, hi])) => {
                let step = (hi - lo) / 65535.0;
                let [x, y] = [short(dx * 100.0), short(dy * 100.0)];
                let scale = if x == y { format!("X = Y = {x}") } else { format!("X = {x}, Y = {y}") };
                vec![format!(
                    "Unreal: scale {scale}, Z = {}; location Z = {}",
                    short(step * 100.0 / UNREAL_STEP),
                    short((lo + step * UNREAL_ZERO) * 100.0)
                )]
            }
            (Self::Unity, Some([lo, hi])) => vec![format!(
                "Unity: {cols} x {rows}, 16 bit, Windows byte order; terrain size X = {}, Z = {}, Y = {}; position Y = {}",
                short(east),
                short(south),
                short(hi - lo),
                short(lo)
            )],
            (Self::Godot, None) => {
                vec![format!("Terrain3D: import scale 1, offset 0; vertex spacing {spacing}")]
            }
            (Self::Godot, Some([lo, hi])) => vec![format!(
                "Terrain3D: height range {} to {}; vertex spacing {spacing}",
                short(lo),
                short(hi)
            )],
            (Self::Unreal | Self::Unity, None) => Vec::new(),
        }
    }
}

impl FromStr for Target {
    type Err = String;

    /// # Errors
    /// A sentence that lists the names, and the nearest.
    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("must be one of {}, got \"{name}\"{}", names.join(", "), did_you_mean(name, names))
        })
    }
}

/// A number with at most six decimals.
fn short(v: f64) -> String {
    let text = format!("{v:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// What an engine will not like about a file, as sentences; none when it takes it as it is.
pub fn target_warnings(target: Target, format: Format, cols: usize, rows: usize) -> Vec<String> {
    let unfit = format!("{} cannot open {format}; it takes {}", target.name(), target.format());
    let unfit = (!target.takes(format)).then_some(unfit);
    unfit.into_iter().chain(size_warning(target, cols, rows)).collect()
}

/// What an engine will not like about a size.
fn size_warning(target: Target, cols: usize, rows: usize) -> Option<String> {
    let list = |sides: &[usize]| sides.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    match target {
        Target::Unreal if [cols, rows].iter().any(|n| !UNREAL_SIDES.contains(n)) => Some(format!(
            "Unreal will not take {cols} x {rows} samples as they are; it takes sides of {}",
            list(&UNREAL_SIDES)
        )),
        Target::Unity if cols != rows || !UNITY_SIDES.contains(&cols) => Some(format!(
            "Unity will not take {cols} x {rows} samples as they are; it takes squares with sides of {}",
            list(&UNITY_SIDES)
        )),
        Target::Unreal | Target::Unity | Target::Godot => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unreal_zero_is_zero() {
        for heights in [[-10.0, 300.0], [-500.0, 20.0], [0.0, 0.0]] {
            let [lo, hi] = Target::Unreal.range(heights);
            assert!(lo <= heights[0] && hi >= heights[1]);
            assert!((lo + (hi - lo) / 65535.0 * 32768.0).abs() < 1e-9);
        }
    }

    /// The example of Unreal's landscape guide: a range of 512 m is a Z scale of 100.
    #[test]
    fn unreal_scale_is_that_of_its_guide() {
        let step = 512.0 / 65536.0;
        let notes = Target::Unreal.notes(Some([-256.0, 256.0 - step]), [1.0; 2], [1009, 1009]);
        assert_eq!(notes, ["Unreal: scale X = Y = 100, Z = 100; location Z = 0"]);
    }

    #[test]
    fn sizes_that_will_not_do_are_named() {
        assert!(target_warnings(Target::Unreal, Format::Png16, 1009, 2017).is_empty());
        assert!(target_warnings(Target::Unreal, Format::Png16, 1025, 1025)[0].contains("1009"));
        assert!(target_warnings(Target::Unity, Format::R16, 1025, 1025).is_empty());
        assert!(target_warnings(Target::Unity, Format::R16, 1025, 513)[0].contains("squares"));
        assert!(target_warnings(Target::Unity, Format::R16, 1009, 1009)[0].contains("1025"));
        assert!(target_warnings(Target::Godot, Format::Exr, 7, 9).is_empty());
        assert!(target_warnings(Target::Unreal, Format::Exr, 1009, 1009)[0].contains("png16"));
    }
}
