//! What EPSG codes say of units: those of coordinates and of heights that are not metres.

use std::sync::LazyLock;

/// Codes of systems whose unit is not the metre.
const TABLE: &str = include_str!("units.txt");

/// The unit of a coordinate system's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unit {
    /// A length, in metres.
    Length(f64),
    /// Degrees.
    Degrees,
    /// Grads, of which 100 are a right angle.
    Grads,
}

/// The unit that an EPSG code of a unit names.
pub(super) fn unit(code: u16) -> Option<Unit> {
    Some(match code {
        9102 | 9122 => Unit::Degrees,
        9105 => Unit::Grads,
        _ => Unit::Length(metres(code)?),
    })
}

/// Metres of a unit of length, by its EPSG code.
pub(super) fn metres(code: u16) -> Option<f64> {
    Some(match code {
        9001 => 1.0,
        9002 => 0.3048,
        9003 => 1200.0 / 3937.0,
        9005 => 0.304_797_265_4,
        9031 => 1.000_013_596_5,
        9036 => 1000.0,
        9037 => 0.914_391_796_2,
        9039 => 0.201_166_195_164,
        9040 => 0.914_398_414_616_028_7,
        9041 => 0.304_799_471_538_676_2,
        9042 => 20.116_765_121_552_632,
        9062 => 20.116_782_494_375_872,
        9084 => 0.914_398_530_744_440_8,
        9094 => 0.304_799_710_181_508_8,
        9095 => 0.304_800_749_1,
        9098 => 0.201_168,
        9301 => 20.116_756,
        _ => return None,
    })
}

/// The unit of the coordinates of a projected or geographic system; `None` for metres and for codes that are not known.
pub(super) fn horizontal(code: u32) -> Option<Unit> {
    static RANGES: LazyLock<Vec<Range>> = LazyLock::new(|| ranges("horizontal"));
    listed(&RANGES, code).and_then(unit)
}

/// Metres of the unit of a vertical system, where it is not the metre.
pub(super) fn vertical(code: u32) -> Option<f64> {
    static RANGES: LazyLock<Vec<Range>> = LazyLock::new(|| ranges("vertical"));
    listed(&RANGES, code).and_then(metres)
}

/// Whether the heights of a vertical system are depths, which count downwards.
pub(super) fn is_depth(code: u32) -> bool {
    let line = TABLE.lines().find_map(|line| line.strip_prefix("depth"));
    line.is_some_and(|line| line.split_ascii_whitespace().any(|w| holds(w, code)))
}

/// Whether the name of a vertical system is that of one of depths.
pub(super) fn names_depth(name: &str) -> bool {
    let mut words = name.split(|c: char| !c.is_alphanumeric());
    words.any(|w| w.eq_ignore_ascii_case("depth") || w.eq_ignore_ascii_case("depths"))
}

/// What a person should know of depths; `system` is what counts them.
pub(super) fn note_of_depths(system: &str) -> String {
    format!("{system} counts depths downwards: they are turned into heights")
}

/// A range of codes of systems, and the code of their unit.
type Range = (u32, u32, u16);

/// The ranges of a kind, by their first codes; no two of them overlap.
fn ranges(kind: &str) -> Vec<Range> {
    let of_line = |line: &'static str| {
        let mut words = line.strip_prefix(kind)?.split_ascii_whitespace();
        let unit: u16 = words.next()?.parse().ok()?;
        Some(words.filter_map(move |word| range(word).map(|(first, last)| (first, last, unit))))
    };
    let mut all: Vec<Range> = TABLE.lines().filter_map(of_line).flatten().collect();
    all.sort_unstable();
    all
}

/// The code of the unit of a system, where it stands in one of the ranges.
fn listed(ranges: &[Range], code: u32) -> Option<u16> {
    let after = ranges.partition_point(|(first, ..)| *first <= code);
    let (_, last, unit) = ranges.get(after.checked_sub(1)?)?;
    (code <= *last).then_some(*unit)
}

/// The first and the last code of a range, or of a code alone.
fn range(word: &str) -> Option<(u32, u32)> {
    let (first, last) = word.split_once('-').unwrap_or((word, word));
    Some((first.parse().ok()?, last.parse().ok()?))
}

/// Whether a code or a range of codes holds a code.
fn holds(word: &str, code: u32) -> bool {
    range(word).is_some_and(|(first, last)| (first..=last).contains(&code))
}

/// Metres of a unit of length by the word that people and programs use for it.
pub(super) fn metres_of_word(word: &str) -> Option<f64> {
    let plain: String = word.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase();
    Some(match plain.as_str() {
        "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "ft" | "foot" | "feet" | "internationalfoot" | "internationalfeet" | "footinternational" => 0.3048,
        "ussurveyfoot" | "ussurveyfeet" | "surveyfoot" | "usft" | "ftus" | "footus" | "usfoot" | "usfeet"
        | "ussft" | "sft" => 1200.0 / 3937.0,
        "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => 1000.0,
        "dm" | "decimetre" | "decimetres" | "decimeter" | "decimeters" => 0.1,
        "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => 0.01,
        "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => 0.001,
        "yd" | "yard" | "yards" => 0.9144,
        "fathom" | "fathoms" => 1.8288,
        _ => return None,
    })
}

/// Metres of the unit that a word names. A word that is not known earns a note: `of` is what the unit is of.
pub(super) fn unit_of(of: &str, word: &str, notes: &mut Vec<String>) -> Option<f64> {
    let metres = metres_of_word(word);
    if metres.is_none() && !word.is_empty() {
        notes.push(format!("the unit of {of}, \"{word}\", is not known: it is taken for metres"));
    }
    metres
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_the_units_of_the_registry() {
        let us_foot = Some(Unit::Length(1200.0 / 3937.0));
        for (code, unit) in [
            (2227, us_foot),
            (6529, us_foot),
            (32664, us_foot),
            (2222, Some(Unit::Length(0.3048))),
            (20050, Some(Unit::Length(0.3048))),
            (4326, Some(Unit::Degrees)),
            (4269, Some(Unit::Degrees)),
            (6318, Some(Unit::Degrees)),
            (7844, Some(Unit::Degrees)),
            (4807, Some(Unit::Grads)),
            (22300, Some(Unit::Length(1000.0))),
            (32611, None),
            (3857, None),
            // A geocentric system: metres.
            (4978, None),
            (1, None),
        ] {
            assert_eq!(horizontal(code), unit, "EPSG:{code}");
        }
        assert_eq!(vertical(6360), Some(1200.0 / 3937.0));
        assert_eq!(vertical(8228), Some(0.3048));
        assert_eq!(vertical(5703), None);
        assert!([5715, 5336, 5706, 6357, 8051, 10_372].into_iter().all(is_depth));
        assert!([5703, 5714, 6360, 5773, 3855].into_iter().all(|code| !is_depth(code)));
        assert!(names_depth("MSL depth (ft)") && names_depth("Depth") && !names_depth("EGM96 height"));
    }

    #[test]
    fn every_line_of_the_table_is_understood() {
        let mut codes = 0;
        for line in TABLE.lines().filter(|l| !l.starts_with('#') && !l.starts_with("depth")) {
            let mut words = line.split_ascii_whitespace();
            assert!(matches!(words.next(), Some("horizontal" | "vertical")), "{line}");
            assert!(words.next().and_then(|w| w.parse().ok()).is_some_and(|c| unit(c).is_some()), "{line}");
            codes += words.clone().count();
            assert!(words.all(|w| w.split('-').all(|n| n.parse::<u32>().is_ok())), "{line}");
        }
        assert!(codes > 800, "{codes}");
        for kind in ["horizontal", "vertical"] {
            let all = ranges(kind);
            assert!(all.windows(2).all(|two| two[0].0 <= two[0].1 && two[0].1 < two[1].0), "{kind}: {all:?}");
        }
    }

    #[test]
    fn words_are_units() {
        assert_eq!(metres_of_word("US survey foot"), Some(1200.0 / 3937.0));
        assert_eq!(metres_of_word("us-ft"), Some(1200.0 / 3937.0));
        assert_eq!(metres_of_word("ft (US)"), metres_of_word("ftUS"));
        assert_eq!(metres_of_word("Foot"), Some(0.3048));
        assert_eq!(metres_of_word("Foot (International)"), Some(0.3048));
        assert_eq!(metres_of_word("metre"), Some(1.0));
        assert_eq!(metres_of_word("furlong"), None);
        assert_eq!(metres_of_word(""), None);
        let mut notes = Vec::new();
        assert_eq!(unit_of("this", "", &mut notes), None);
        assert_eq!(unit_of("this", "ft", &mut notes), Some(0.3048));
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(unit_of("this", "furlong", &mut notes), None);
        assert_eq!(notes, ["the unit of this, \"furlong\", is not known: it is taken for metres"]);
    }
}
