//! What a reader noticed: one sentence a kind, with a count and the first place.

use std::collections::BTreeMap;

/// Something about a line or element that a person should know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Notice {
    /// The mapping sets nothing on it.
    Bare,
    /// It has fewer than two different positions.
    Pointlike,
    /// A property is not what the mapping needs.
    Property,
    /// A curve may not be like this.
    Unfit,
    /// Its data break off; what came before is kept.
    Broken,
    /// An attribute cannot be read.
    Attribute,
    /// It is no line.
    NoLine,
    /// A feature has no geometry.
    NoGeometry,
    /// It is not what the format says.
    Malformed,
    /// A `use` draws nothing.
    Use,
    /// An entity is not defined in the file.
    Entity,
    /// An entity stands for elements.
    Markup,
    /// A style would say what is drawn, and is not read.
    Style,
    /// Something in a style sheet lacks its end.
    Unclosed,
    /// It lies wholly off the terrain.
    Off,
}

impl Notice {
    /// What one and several of the kind are called, and what became of them.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Bare => [
                "line on which the mapping sets nothing",
                "lines on which the mapping sets nothing",
                "left out",
            ],
            Self::Pointlike => ["line without length", "lines without length", "left out"],
            Self::Property => {
                ["line with an unusable property", "lines with an unusable property", "left out"]
            }
            Self::Unfit => ["line that no curve can follow", "lines that no curve can follow", "left out"],
            Self::Broken => {
                ["element with broken data", "elements with broken data", "taken up to the fault"]
            }
            Self::Attribute => {
                ["element with an unreadable attribute", "elements with an unreadable attribute", "left out"]
            }
            Self::NoLine => ["geometry that is no line", "geometries that are no lines", "left out"],
            Self::NoGeometry => ["feature without geometry", "features without geometry", "left out"],
            Self::Malformed => ["malformed feature", "malformed features", "left out"],
            Self::Use => ["`use` that draws nothing", "`use` that draw nothing", "left out"],
            Self::Entity => ["undefined entity", "undefined entities", "left out"],
            Self::Markup => {
                ["entity that stands for elements", "entities that stand for elements", "left out"]
            }
            Self::Style => ["style that is not read", "styles that are not read", "left out"],
            Self::Unclosed => [
                "part of a style sheet without an end",
                "parts of style sheets without an end",
                "taken to end with the sheet",
            ],
            Self::Off => {
                ["line wholly off the terrain", "lines wholly off the terrain", "taken all the same"]
            }
        }
    }
}

/// Counts of notices, each with the first place.
#[derive(Debug, Default)]
pub(super) struct Tally(BTreeMap<Notice, (usize, String)>);

impl Tally {
    /// Takes up a notice; `place` is asked for the first of a kind alone.
    pub(super) fn add(&mut self, notice: Notice, place: impl FnOnce() -> String) {
        self.0.entry(notice).or_insert_with(|| (0, place())).0 += 1;
    }

    /// Whether nothing was noticed.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The sentences.
    pub(super) fn sentences(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(notice, (count, first))| {
            let [one, many, fate] = notice.words();
            match count {
                1 => format!("1 {one}, {fate}: {first}"),
                _ => format!("{count} {many}, {fate}; the first: {first}"),
            }
        })
    }
}
