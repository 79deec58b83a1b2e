//! The one way in which commands read a height file: header first, the budget, then the heights.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::args::parse_bytes;
use super::exit::{Exit, Stop};
use crate::engine::default_budget;
use crate::files::{
    Claim, Companion, Encoding, Fault, HeightFile, Input, Limits, Reading, Watch, companions,
};
use crate::node::Cancel;
use crate::source::ReadAt;

/// Bytes that the program takes beside what it reads.
const PROGRAM: u64 = 48 << 20;
/// Longest file beside a height file that is read, in bytes.
const LONGEST_COMPANION: u64 = 1 << 20;

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
}

impl ReadArgs {
    /// The options that were given, by name.
    pub(super) fn given(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            ("--terrarium", self.terrarium),
            ("--terrain-rgb", self.terrain_rgb),
            ("--channel", self.channel.is_some()),
        ];
        given.into_iter().filter_map(|(name, given)| given.then_some(name))
    }

    fn reading(&self) -> Reading {
        let encoding = match (self.terrarium, self.terrain_rgb) {
            (true, _) => Encoding::Terrarium,
            (_, true) => Encoding::TerrainRgb,
            _ => Encoding::Auto,
        };
        Reading { channel: self.channel.clone(), ..encoding.into() }
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
    args: &ReadArgs,
    budget: u64,
    bytes_a_sample: u64,
    cancel: &Cancel,
) -> Result<HeightFile, Stop> {
    let name = path.to_string_lossy();
    let cannot = |e: io::Error| Stop::new(Exit::Input, format!("cannot read {name}: {e}"));
    let file = Opened::new(path).map_err(cannot)?;
    let names = companions(&name);
    let beside: Vec<_> = names.iter().filter_map(|n| Some((n, small(Path::new(n))?))).collect();
    let companions: Vec<_> = beside.iter().map(|(name, bytes)| Companion { name, bytes }).collect();
    let (reading, limits) = (args.reading(), Limits::default());
    let watch = Watch { cancel: Some(cancel), ..Watch::default() };
    let input = Input {
        name: &name,
        bytes: &file,
        companions: &companions,
        reading: &reading,
        limits: &limits,
        watch,
    };
    let claim = input.claim().map_err(|e| Stop::new(exit(&e.fault), e))?;
    admit(&name, &claim, bytes_a_sample, budget)?;
    input.read().map_err(|e| Stop::new(exit(&e.fault), e))
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

/// The content of a small regular file, where there is one.
fn small(path: &Path) -> Option<Vec<u8>> {
    let length = path.metadata().ok().filter(Metadata::is_file)?.len();
    if length > LONGEST_COMPANION { None } else { std::fs::read(path).ok() }
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
