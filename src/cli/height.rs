//! The one way in which commands read a height file: header first, the budget, then the heights.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use clap::ValueEnum;

use super::args::{parse_bytes, parse_finite};
use super::aside::aside;
use super::exit::{Exit, Stop};
use super::heed;
use crate::engine::default_budget;
use crate::files::{
    ByteOrder, Claim, Codec, Companion, Encoding, Fault, HeightFile, Input, LONGEST_SIDECAR, Limits,
    RawSample, Reading, companions, last_name,
};
use crate::node::Cancel;
use crate::source::ReadAt;
use crate::work::Work;

/// Bytes that the program takes beside what it reads.
const PROGRAM: u64 = 48 << 20;

/// How a height file is read.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct ReadArgs {
    /// Reads the colours of a PNG as Terrarium heights
    #[arg(long, conflicts_with = "terrain_rgb")]
    terrarium: bool,
    /// Reads the colours of a PNG as Mapbox Terrain-RGB heights
    #[arg(long)]
    terrain_rgb: bool,
    /// The channel of an OpenEXR file by its name, or the band of a TIFF by its number
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// A number of the file that marks voids, beside the one that the file names
    #[arg(long, value_name = "NUMBER", value_parser = parse_finite, allow_hyphen_values = true)]
    nodata: Option<f64>,
    /// Which byte of a sample of a raw file comes first
    #[arg(long, value_enum)]
    byte_order: Option<Order>,
    /// The type of the samples of a raw file: u8, u16, i16, u32, i32 or f32 [default: u16, of .r32 f32]
    #[arg(long, value_name = "TYPE", value_parser = sample)]
    sample: Option<RawSample>,
    /// Samples in a row of a raw file [default: those of its sidecar, or of a square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    cols: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Order {
    /// The lowest byte first, as on a PC
    Little,
    /// The highest byte first, as on an old Mac
    Big,
}

fn sample(text: &str) -> Result<RawSample, String> {
    let found = RawSample::ALL.into_iter().find(|s| s.name() == text);
    found.ok_or_else(|| format!("must be one of {}", RawSample::ALL.map(RawSample::name).join(", ")))
}

impl ReadArgs {
    /// The options that were given, by name.
    pub(super) fn given(&self) -> impl Iterator<Item = &'static str> {
        let nodata = [("--nodata", self.nodata.is_some())];
        heed::given(self.of_pictures())
            .chain(heed::given(self.of_bands()))
            .chain(heed::given(self.of_raw()))
            .chain(heed::given(nodata))
    }

    fn of_pictures(&self) -> [(&'static str, bool); 2] {
        [("--terrarium", self.terrarium), ("--terrain-rgb", self.terrain_rgb)]
    }

    fn of_bands(&self) -> [(&'static str, bool); 1] {
        [("--channel", self.channel.is_some())]
    }

    fn of_raw(&self) -> [(&'static str, bool); 3] {
        [
            ("--byte-order", self.byte_order.is_some()),
            ("--sample", self.sample.is_some()),
            ("--cols", self.cols.is_some()),
        ]
    }

    /// How a file is read; refuses options that its format does not heed.
    pub(super) fn reading(&self, path: &Path) -> Result<Reading, Stop> {
        let codec = Codec::of_name(&path.to_string_lossy());
        // What no reader knows is refused by name.
        let is_of = |extensions: &[&str]| codec.is_none_or(|c| extensions.contains(&c.extension()));
        let refuse = |given: &mut dyn Iterator<Item = &'static str>, what: &str, extensions: &[&str]| {
            let given = given.filter(|_| !is_of(extensions));
            heed::refuse(given, format_args!("{what}, which {} is not", path.display()))
        };
        refuse(&mut heed::given(self.of_pictures()), "a PNG", &["png"])?;
        let bands = "a file of channels or bands (OpenEXR, TIFF, BIL, PFM)";
        refuse(&mut heed::given(self.of_bands()), bands, &["exr", "tif", "bil", "pfm"])?;
        refuse(&mut heed::given(self.of_raw()), "a raw file", &["r16", "r32"])?;
        Ok(self.as_given())
    }

    /// The same for the readers.
    fn as_given(&self) -> Reading {
        let encoding = match (self.terrarium, self.terrain_rgb) {
            (true, _) => Encoding::Terrarium,
            (_, true) => Encoding::TerrainRgb,
            _ => Encoding::Auto,
        };
        let byte_order = self.byte_order.map(|o| match o {
            Order::Little => ByteOrder::Little,
            Order::Big => ByteOrder::Big,
        });
        let Self { nodata, sample, cols, .. } = *self;
        Reading { encoding, channel: self.channel.clone(), nodata, sample, byte_order, cols }
    }
}

/// The budget of memory of a command that reads a height file.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct MemoryArgs {
    /// Budget of memory, as 8G or 512M [default: three quarters of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    memory: Option<u64>,
}

impl MemoryArgs {
    /// The option where it was given, by name.
    pub(super) fn given(&self) -> Option<&'static str> {
        self.memory.map(|_| "--memory")
    }

    pub(super) fn budget(&self) -> u64 {
        self.memory.unwrap_or_else(default_budget)
    }
}

/// Reads a height file with what lies beside it, if that fits the budget with the bytes a sample that the command takes
/// beside the heights.
pub(super) fn read(
    path: &Path,
    reading: &Reading,
    budget: u64,
    bytes_a_sample: u64,
    cancel: &Cancel,
) -> Result<HeightFile, Stop> {
    read_with(path, reading, budget, bytes_a_sample, cancel, Ok)
}

/// The same with work on what was read, which may be left behind like the reading.
pub(super) fn read_with<T: Send + 'static>(
    path: &Path,
    reading: &Reading,
    budget: u64,
    bytes_a_sample: u64,
    cancel: &Cancel,
    work: impl FnOnce(HeightFile) -> Result<T, Stop> + Send + 'static,
) -> Result<T, Stop> {
    let (path, reading, signal) = (path.to_owned(), reading.clone(), cancel.clone());
    aside(cancel, move || work(read_here(&path, &reading, budget, bytes_a_sample, &signal)?))
}

fn read_here(
    path: &Path,
    reading: &Reading,
    budget: u64,
    bytes_a_sample: u64,
    cancel: &Cancel,
) -> Result<HeightFile, Stop> {
    let name = path.to_string_lossy();
    let cannot = |e: io::Error| Stop::new(Exit::Input, format!("cannot read {name}: {e}"));
    let file = Opened::new(path).map_err(cannot)?;
    let names = companions(&name);
    let mut notes = Vec::new();
    let mut small = |name: &String| {
        small(Path::new(name)).unwrap_or_else(|note| {
            notes.push(note);
            None
        })
    };
    let beside: Vec<_> = names.iter().filter_map(|n| Some((n, small(n)?))).collect();
    let companions: Vec<_> = beside.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
    let limits = Limits::default();
    let work = Work::new(cancel);
    let input = Input { name: &name, bytes: &file, companions: &companions, reading, limits: &limits, work };
    let claim = input.claim().map_err(|e| Stop::new(exit(&e.fault), e))?;
    admit(&name, &claim, bytes_a_sample, budget)?;
    let mut file = input.read().map_err(|e| Stop::new(exit(&e.fault), e))?;
    file.origin.notes.extend(notes);
    Ok(file)
}

/// The heights times a factor, plus a summand: `--height-scale` and `--height-offset`.
pub(super) fn scaled(mut file: HeightFile, scale: f64, offset: f64) -> Result<HeightFile, Stop> {
    if (scale, offset) == (1.0, 0.0) {
        return Ok(file);
    }
    file.data.iter_mut().for_each(|z| *z = (f64::from(*z) * scale + offset) as f32);
    if file.data.iter().any(|z| z.is_infinite()) {
        let plus = if offset == 0.0 { String::new() } else { format!(" with --height-offset {offset}") };
        return Err(Stop::usage(format!(
            "--height-scale {scale}{plus} makes heights that are too large to be kept"
        )));
    }
    Ok(file)
}

/// Refuses what the budget has no room for.
fn admit(name: &str, claim: &Claim, bytes_a_sample: u64, budget: u64) -> Result<(), Stop> {
    let more = claim.cols.saturating_mul(claim.rows).saturating_mul(bytes_a_sample);
    let need = claim.bytes.saturating_add(more).saturating_add(PROGRAM);
    if need <= budget {
        return Ok(());
    }
    let mib = |bytes: u64| bytes.div_ceil(1 << 20);
    Err(Stop::new(
        Exit::Budget,
        format!(
            "{} x {} samples need {} MiB of memory, and {} MiB may be used. Raise --memory: {name}",
            claim.cols,
            claim.rows,
            mib(need),
            mib(budget)
        ),
    ))
}

fn exit(fault: &Fault) -> Exit {
    match fault {
        Fault::Cancelled => Exit::Cancelled,
        Fault::NoMemory { .. } => Exit::Budget,
        _ => Exit::Input,
    }
}

/// The content of a small regular file, where there is one; a note of one that is too long.
fn small(path: &Path) -> Result<Option<Vec<u8>>, String> {
    let Some(length) = path.metadata().ok().filter(Metadata::is_file).map(|m| m.len()) else {
        return Ok(None);
    };
    if length > LONGEST_SIDECAR {
        let name = path.to_string_lossy();
        return Err(format!(
            "`{}` is not read: it has {length} bytes, and what stands beside a file has {LONGEST_SIDECAR} at most",
            last_name(&name)
        ));
    }
    Ok(std::fs::read(path).ok())
}

/// A regular file that is read at any place.
struct Opened {
    file: Mutex<File>,
    length: u64,
}

impl Opened {
    fn new(path: &Path) -> io::Result<Self> {
        // A pipe is not opened: that would wait for whoever writes into it.
        if !path.metadata()?.is_file() {
            return Err(io::Error::other("it is no regular file"));
        }
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file: Mutex::new(file), length })
    }
}

impl ReadAt for Opened {
    fn len(&self) -> u64 {
        self.length
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(buffer)
    }
}
