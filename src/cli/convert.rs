//! `orograph convert`: a height file in another format.

use std::path::{Path, PathBuf};

use cap_std::ambient_authority;
use cap_std::fs::Dir;

use super::args::{parse_finite, parse_positive};
use super::exit::{Exit, Stop, save, tell};
use super::sidecars::spare_sidecars;
use super::{heed, height};
use crate::files::{Codec, Format, HeightFile, WriteError, Writing, encode_file, fill_voids, sidecar_name};
use crate::node::Cancel;
use crate::whole::{self, Known};
use crate::work::Work;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The file to read
    input: PathBuf,
    /// The file to write; its extension chooses the format
    output: PathBuf,
    /// The format to write, where the extension does not say enough
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// Values that the lowest and the highest integer stand for, as LOW,HIGH [default: those of the file]
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true)]
    range: Option<String>,
    /// Cuts off values beyond the range instead of failing
    #[arg(long)]
    clip: bool,
    /// Closes voids smoothly from their border inwards
    #[arg(long)]
    fill: bool,
    /// Writes the rows from south to north
    #[arg(long)]
    flip: bool,
    /// Factor on the heights as they are read: metres a unit of a file that does not say
    #[arg(long, value_name = "METRES", default_value_t = 1.0, value_parser = parse_positive, allow_hyphen_values = true)]
    height_scale: f64,
    /// Metres added to the heights after that
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = parse_finite, allow_hyphen_values = true)]
    height_offset: f64,
    #[command(flatten)]
    read: height::ReadArgs,
    #[command(flatten)]
    memory: height::MemoryArgs,
    /// Replaces the output when it is there
    #[arg(long)]
    overwrite: bool,
}

pub(super) fn run(args: &Args, cancel: &Cancel) -> Result<Exit, Stop> {
    let name = name(&args.output)?;
    let format = format(args.format, &name)?;
    let of_integers = heed::given([("--range", args.range.is_some()), ("--clip", args.clip)]);
    let of_integers = of_integers.filter(|_| !format.is_integer());
    heed::refuse(of_integers, format_args!("formats of integers, which {format} is not"))?;
    let range = args.range.as_deref().map(range).transpose()?;
    let same =
        |a: &Path, b: &Path| a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b);
    if same(&args.input, &args.output) {
        return Err(Stop::usage("the input is never overwritten; name another output"));
    }
    if args.output.symlink_metadata().is_ok() && !args.overwrite {
        return Err(Stop::usage(format!("{} is there already; say --overwrite", args.output.display())));
    }
    if format.has_sidecar(1) {
        spare_sidecars(&args.output, std::slice::from_ref(&args.input), args.overwrite)?;
    }
    let (scale, offset) = (args.height_scale, args.height_offset);
    let fill = args.fill;
    let scaled = move |file| {
        let file = height::scaled(file, scale, offset)?;
        if fill { filled(file) } else { Ok(file) }
    };
    let (reading, budget) = (args.read.reading(&args.input)?, args.memory.budget());
    let file = height::read_with(&args.input, &reading, budget, 0, cancel, scaled)?;
    cancel.check().map_err(|e| Stop::new(Exit::Cancelled, e))?;
    let work = Work::new(cancel);
    let writing = Writing { file: &name, range, clip: args.clip, flip: args.flip, work, ..format.into() };
    let folder = args.output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let cannot =
        |e: std::io::Error| Stop::new(Exit::Failed, format!("cannot open {}: {e}", folder.display()));
    let dir = Dir::open_ambient_dir(folder, ambient_authority()).map_err(cannot)?;
    whole::sweep(&dir, |left| left.is_of(&name));
    let written = whole::write(&dir, &name, Known::Anything, |out| encode_file(&file, &writing, out))
        .map_err(|e| {
            let exit = if matches!(e, WriteError::Cancelled) { Exit::Cancelled } else { Exit::Failed };
            Stop::new(exit, format!("{e}: {}", args.output.display()))
        })?;
    if let Some(sidecar) = &written.sidecar {
        save(&folder.join(sidecar_name(&name)), format!("{sidecar:#}\n").as_bytes())?;
    }
    let coarse = written.range.filter(|_| range.is_none()).and_then(|range| coarse(&file, range));
    file.origin.notes.iter().chain(&written.notes).chain(&coarse).for_each(|n| tell(&format!("note: {n}")));
    Ok(Exit::Done)
}

/// The warning that heights lose their fractions, because the range of the integers was not chosen.
fn coarse(file: &HeightFile, [low, high]: [f64; 2]) -> Option<String> {
    let heights = || file.data.iter().filter(|z| z.is_finite());
    let (lowest, highest) =
        heights().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), z| (a.min(*z), b.max(*z)));
    heights().any(|z| z.fract() != 0.0).then(|| {
        format!(
            "its integers stand for {low} to {high}, and the heights run from {lowest} to {highest}: --range LOW,HIGH gives \
             them finer steps"
        )
    })
}

/// The name of a file that is written.
fn name(path: &Path) -> Result<String, Stop> {
    let name =
        path.file_name().ok_or_else(|| Stop::usage(format!("{} is not a file name", path.display())))?;
    // The name is written to a sidecar, which is text.
    let text = name.to_str().ok_or_else(|| {
        Stop::usage(format!("the name of the output must be text in UTF-8, got `{}`", name.display()))
    })?;
    Ok(text.to_owned())
}

/// The format of the option or of the name, where the two do not contradict each other.
fn format(asked: Option<Format>, name: &str) -> Result<Format, Stop> {
    let Some(format) = asked else {
        let format = Format::of_name(name);
        return format.ok_or_else(|| Stop::usage(format!("`{name}` names no format; say --format")));
    };
    let codec = format.codec();
    let is_raw = |codec: &Codec| codec.extensions.contains(&"r16") || codec.extensions.contains(&"r32");
    let is_any_raw = is_raw(codec) && name.to_ascii_lowercase().ends_with(".raw");
    match Codec::of_name(name).filter(|named| *named != codec && !is_any_raw) {
        None => Ok(format),
        Some(named) => Err(Stop::usage(format!(
            "`{name}` is the name of a file of {}, and --format {format} writes {}; end it in .{}",
            named.name,
            codec.name,
            codec.extension()
        ))),
    }
}

/// The heights without voids.
fn filled(mut file: HeightFile) -> Result<HeightFile, Stop> {
    let (cols, rows) = (file.cols, file.rows);
    let all = || Stop::new(Exit::Input, "nothing but voids: there is no height to fill them with");
    if fill_voids(cols, rows, &mut file.data).ok_or_else(all)? > 0 {
        file.origin.nodata = None;
    }
    Ok(file)
}

fn range(text: &str) -> Result<[f64; 2], Stop> {
    let parsed =
        text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    let upwards = parsed.filter(|[lo, hi]: &[f64; 2]| lo.is_finite() && hi.is_finite() && lo < hi);
    upwards.ok_or_else(|| Stop::usage(format!("--range takes LOW,HIGH with LOW below HIGH, got `{text}`")))
}
