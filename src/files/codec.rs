//! The table of formats: one row for each kind of height file.
//!
//! Code, tests, pages and fuzzing walk this table. A new format is a new file with its [`Codec`], which says how it is
//! recognised, read and written, and one line in [`codecs!`].

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::{Fault, WriteError, extension_of};
use super::height::HeightFile;
use super::input::{Claim, Input};
use super::sheet::{Sheet, Sink};
use super::write::Written;
use super::{asc, esri, exr, hgt, pfm, png, raw, terragen, tiff, xyz};
use crate::params::did_you_mean;

/// The most bytes at the beginning of a file that identify its kind.
pub(super) const LONGEST_MAGIC: usize = 16;

/// A kind of height file: how it is recognised and read. Its written formats are [`FormatSpec`]s.
pub struct Codec {
    /// The name in messages.
    pub name: &'static str,
    /// The extensions of its files, in lower case; files are written under the first.
    pub extensions: &'static [&'static str],
    /// The possible first bytes of its files; empty where they do not identify the kind.
    pub(super) magic: &'static [&'static [u8]],
    /// Extensions of companions that are read, too, where they exist; `json` is that of the sidecar.
    pub companions: &'static [&'static str],
    /// Whether the header or the length alone give the size; otherwise the claim reads the whole content.
    pub claims_early: bool,
    /// The size that the header claims, which is checked before memory is allocated.
    pub(super) claim: fn(&Input<'_>) -> Result<Claim, Fault>,
    /// Reads the heights. The claim has been checked.
    pub(super) read: fn(&Input<'_>) -> Result<HeightFile, Fault>,
    /// For the table of docs/files.md: what is read.
    pub reads: &'static str,
    /// For the table of docs/files.md: whether heights are metres.
    pub metres: &'static str,
    /// For the table of docs/files.md: where the samples lie.
    pub place: &'static str,
}

/// The description of a written [`Format`].
pub struct FormatSpec {
    /// The name in graphs and on the command line.
    pub name: &'static str,
    /// Whether a name with the extension of the codec means this format; exactly one format of a codec does.
    pub by_extension: bool,
    /// The highest integer of a range, where it holds integers.
    pub levels: Option<f64>,
    /// The allowed numbers of components: fields have one, vectors two, colours three.
    pub channels: &'static [usize],
    /// Whether a file of one channel has a JSON sidecar, for the place, the unit and the range that it cannot hold.
    pub sidecar: bool,
    /// Whether rows may run from south to north, which the file or its sidecar must be able to store.
    pub flips: bool,
    /// Whether the format can mark voids.
    pub voids: bool,
    pub(super) write: fn(&Sheet<'_>, &mut dyn Sink) -> Result<Written, WriteError>,
    /// Nanoseconds for encoding and compressing a number on one core, for plans.
    pub nanoseconds: f64,
    /// For the table of docs/files.md: what it holds.
    pub holds: &'static str,
    /// For the table of docs/files.md: who wants it.
    pub purpose: &'static str,
}

/// Makes the enum of written formats and the list of codecs of one table.
macro_rules! codecs {
    ($($codec:path { $($(#[$doc:meta])* $format:ident = $form:path,)* })*) => {
        /// A format that is written.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Format { $($($(#[$doc])* $format,)*)* }

        const FORMATS: usize = [$($(stringify!($format),)*)*].len();

        impl Format {
            /// Every format, in the order messages list them.
            pub const ALL: [Self; FORMATS] = [$($(Self::$format,)*)*];

            /// The description of the format.
            pub fn form(self) -> &'static FormatSpec {
                match self { $($(Self::$format => &$form,)*)* }
            }

            /// The kind of file of the format.
            pub fn codec(self) -> &'static Codec {
                match self { $($(Self::$format => &$codec,)*)* }
            }
        }

        /// Every kind of file, in the order messages list them.
        static CODECS: &[&Codec] = &[$(&$codec,)*];
    };
}

codecs! {
    png::CODEC {
        /// PNG with 8 bits a channel.
        Png8 = png::EIGHT,
        /// PNG with 16 bits a channel.
        Png16 = png::SIXTEEN,
    }
    tiff::CODEC {
        /// GeoTIFF of 32-bit floats.
        Tiff = tiff::FLOATS,
        /// GeoTIFF of 16-bit integers.
        Tiff16 = tiff::INTEGERS,
    }
    exr::CODEC {
        /// OpenEXR of 32-bit floats.
        Exr = exr::FLOATS,
    }
    raw::CODEC16 {
        /// 16-bit integers without a header, little-endian.
        R16 = raw::INTEGERS,
    }
    raw::CODEC32 {
        /// 32-bit floats without a header, little-endian.
        R32 = raw::FLOATS,
    }
    asc::CODEC {
        /// Esri ASCII grid.
        Asc = asc::TEXT,
    }
    hgt::CODEC {}
    esri::FLT {}
    esri::BIL {}
    pfm::CODEC {}
    terragen::CODEC {}
    xyz::CODEC {}
}

impl Format {
    /// The name in graphs and on the command line.
    pub fn name(self) -> &'static str {
        self.form().name
    }

    /// The extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        self.codec().extension()
    }

    /// The format that an output file's name asks for: 16 bits where PNG is all it says.
    pub fn of_name(name: &str) -> Option<Self> {
        let codec = Codec::of_name(name)?;
        Self::ALL.into_iter().find(|f| f.form().by_extension && f.codec() == codec)
    }

    /// Whether the format holds integers, so that values need a range.
    pub fn is_integer(self) -> bool {
        self.levels().is_some()
    }

    /// The highest integer of a range, where the format holds integers.
    pub fn levels(self) -> Option<f64> {
        self.form().levels
    }

    /// Whether files of the format have a JSON sidecar, for the place, the unit and the range that they cannot hold.
    /// Pictures of colours need none.
    pub fn has_sidecar(self, channels: usize) -> bool {
        channels == 1 && self.form().sidecar
    }

    /// Whether the format can hold values with this number of components: fields have one, vectors two, colours three.
    pub fn takes(self, channels: usize) -> bool {
        self.form().channels.contains(&channels)
    }

    /// The names of all formats that can do something, for advice in messages.
    pub(super) fn which(can: impl Fn(&FormatSpec) -> bool) -> String {
        let names: Vec<_> = Self::ALL.into_iter().filter(|f| can(f.form())).map(Self::name).collect();
        match &names[..] {
            [] => "no format can".into(),
            [one] => format!("{one} can"),
            [first @ .., last] => format!("{} and {last} can", first.join(", ")),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    /// # Errors
    /// A sentence that lists the names, and the nearest.
    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|f| f.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("must be one of {}, got \"{name}\"{}", names.join(", "), did_you_mean(name, names))
        })
    }
}

impl Codec {
    /// Every kind of file, in the order messages list them.
    pub fn all() -> &'static [&'static Self] {
        CODECS
    }

    /// The extension that its files are written under.
    pub fn extension(&self) -> &'static str {
        self.extensions.first().copied().unwrap_or_default()
    }

    /// The extensions of all kinds.
    pub fn all_extensions() -> impl Iterator<Item = &'static str> {
        CODECS.iter().flat_map(|c| c.extensions).copied()
    }

    /// The kind that a file name asks for.
    pub fn of_name(name: &str) -> Option<&'static Self> {
        let extension = extension_of(name)?;
        CODECS.iter().copied().find(|c| c.extensions.contains(&extension.as_str()))
    }

    /// The kind that the first bytes identify.
    pub(super) fn of_content(head: &[u8]) -> Option<&'static Self> {
        CODECS.iter().copied().find(|c| c.magic.iter().any(|m| head.starts_with(m)))
    }

    /// The kind of a file by its name, which its content must not contradict.
    ///
    /// # Errors
    /// Fails when no reader knows the name, or the content is of another kind.
    pub(super) fn of(name: &str, head: &[u8]) -> Result<&'static Self, Fault> {
        let codec = Self::of_name(name).ok_or_else(|| Fault::extension(name))?;
        let content = Self::of_content(head);
        if content.is_some_and(|c| c != codec) || (content.is_none() && !codec.magic.is_empty()) {
            let found = content.map_or("something else", |c| c.name);
            return Err(Fault::Magic { named: codec.name, found });
        }
        Ok(codec)
    }
}

impl PartialEq for Codec {
    /// Names are unique, which a test holds.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Codec {}

impl fmt::Debug for Codec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Codec({})", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_together() {
        let mut extensions: Vec<_> = Codec::all_extensions().collect();
        let count = extensions.len();
        extensions.sort_unstable();
        extensions.dedup();
        assert_eq!(extensions.len(), count, "two codecs share an extension");
        let mut names: Vec<_> = CODECS.iter().map(|c| c.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), CODECS.len(), "two codecs share a name");
        for codec in CODECS {
            assert!(extensions.iter().all(|e| *e == e.to_ascii_lowercase()));
            let written: Vec<_> = Format::ALL.into_iter().filter(|f| f.codec() == *codec).collect();
            let by_extension = written.iter().filter(|f| f.form().by_extension).count();
            assert_eq!(by_extension, usize::from(!written.is_empty()), "{}", codec.name);
            for magic in codec.magic {
                assert!(magic.len() <= LONGEST_MAGIC);
                assert_eq!(Codec::of_content(magic), Some(*codec), "its first bytes are another's as well");
                assert_eq!(Codec::of_content(&magic[1..]), None);
            }
        }
    }

    /// Names stand in graphs: the table and serde must agree on them, and they must not change.
    #[test]
    fn formats_have_the_names_that_graphs_use() {
        for format in Format::ALL {
            assert_eq!(serde_json::to_value(format).expect("a name"), format.name());
            assert_eq!(format.name().parse(), Ok(format));
        }
        let names = Format::ALL.map(Format::name);
        assert_eq!(names[..8], ["png8", "png16", "tiff", "tiff16", "exr", "r16", "r32", "asc"]);
    }

    #[test]
    fn names_choose_formats() {
        for (name, format) in [
            ("a.png", Some(Format::Png16)),
            ("a.TIFF", Some(Format::Tiff)),
            ("a.raw", Some(Format::R16)),
            ("dir.exr/a", None),
            ("a.hgt", None),
        ] {
            assert_eq!(Format::of_name(name), format, "{name}");
        }
    }
}
