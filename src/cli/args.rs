//! Arguments that several commands share.

use std::path::PathBuf;

use clap::Args;

use super::exit::Stop;
use super::heed;
use crate::engine::{DEFAULT_CACHE_BYTES, DEFAULT_SECONDS, Keep, Options, default_budget};
use crate::value::{Bounds, Grid, Terrain};

/// A graph and what is changed in it before it is evaluated.
#[derive(Debug, Args)]
pub(super) struct GraphArgs {
    /// The .graph file, - for standard input
    pub graph: PathBuf,
    /// Sets an exposed parameter, `node.parameter` or `terrain.setting`; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Reads such values from a JSON object
    #[arg(long, value_name = "FILE")]
    pub vars: Option<PathBuf>,
    /// Seed of the whole graph
    #[arg(long, allow_hyphen_values = true)]
    pub seed: Option<u32>,
    /// Samples along the longer side of the base grid, on which global nodes run
    #[arg(long, value_name = "N")]
    pub base: Option<u32>,
    /// A folder that the graph may read files from, beside its own; repeatable
    #[arg(long, value_name = "DIR")]
    pub allow: Vec<PathBuf>,
}

impl GraphArgs {
    /// The given options that only graphs have.
    pub(super) fn given(&self) -> impl Iterator<Item = &'static str> {
        heed::given([
            ("--set", !self.set.is_empty()),
            ("--vars", self.vars.is_some()),
            ("--seed", self.seed.is_some()),
            ("--base", self.base.is_some()),
            ("--allow", !self.allow.is_empty()),
        ])
    }

    /// Refuses options that a file of another kind would ignore.
    pub(super) fn refuse<'a>(
        &self,
        what: &str,
        given: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), Stop> {
        heed::refuse(given, format_args!("{what}, which {} is not", self.graph.display()))
    }

    /// Refuses two options for one setting of the terrain.
    pub(super) fn refuse_doubles(&self) -> Result<(), Stop> {
        let short = [("seed", self.seed.is_some()), ("base", self.base.is_some())];
        let is_set = |name: &str| self.set.iter().any(|pair| pair.split('=').next() == Some(name));
        let double = short.into_iter().find(|(name, given)| *given && is_set(&format!("terrain.{name}")));
        match double {
            None => Ok(()),
            Some((name, _)) => {
                Err(Stop::usage(format!("--{name} and --set terrain.{name} set the same; give one of them")))
            }
        }
    }
}

/// The part of the terrain and its resolution.
#[derive(Debug, Args)]
pub(super) struct GridArgs {
    /// Samples along the longer side of the whole terrain [default: the base grid's]
    #[arg(long, value_name = "N")]
    pub size: Option<u32>,
    /// A part of the terrain in metres, west,north,east,south; snapped outwards to the grid
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true)]
    pub region: Option<String>,
}

/// What the engine may use.
#[derive(Debug, Args)]
pub(super) struct EngineArgs {
    /// Worker threads, at most 512 [default: one per processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=512))]
    pub threads: Option<u16>,
    /// Budget of memory, as 8G or 512M [default: three quarters of the machine's]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory: Option<u64>,
    /// Budget of estimated time, in seconds [default: a day]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, allow_hyphen_values = true)]
    pub time: Option<f64>,
    /// Folder that keeps results for later builds; many processes may share it
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Most bytes that folder may keep, as 32G
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub cache_size: Option<u64>,
}

impl EngineArgs {
    /// Refuses options that would be ignored.
    pub(super) fn refuse(&self) -> Result<(), Stop> {
        let given = heed::given([("--cache-size", self.cache_size.is_some() && self.cache.is_none())]);
        heed::refuse(given, "a cache folder; name one with --cache DIR")
    }

    /// The number of worker threads.
    pub(super) fn threads(&self) -> usize {
        let all = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(all, usize::from)
    }

    pub(super) fn options(&self) -> Options {
        Options {
            threads: self.threads(),
            memory: self.memory.unwrap_or_else(default_budget),
            reserve: 0,
            seconds: self.time.unwrap_or(DEFAULT_SECONDS),
            keep: Keep::Lasting,
            cache: self.cache.clone(),
            cache_bytes: self.cache_size.unwrap_or(DEFAULT_CACHE_BYTES),
        }
    }
}

impl GridArgs {
    /// The grid of the whole terrain, and the window of it that is asked for.
    pub(super) fn grids(&self, terrain: &Terrain) -> Result<(Grid, Grid), Stop> {
        let whole = terrain
            .grid(self.size.unwrap_or(terrain.base))
            .map_err(|e| Stop::usage(format!("--size: {e}")))?;
        let Some(text) = &self.region else { return Ok((whole, whole)) };
        let bounds = region(text).ok_or_else(|| {
            Stop::usage(format!("--region takes four numbers in metres, west,north,east,south, got `{text}`"))
        })?;
        let window = Grid::covering(whole.lattice, bounds).intersection(&whole);
        if window.cols < 2 || window.rows < 2 {
            let b = terrain.bounds();
            return Err(Stop::usage(format!(
                "--region {text} holds fewer than two samples each way; the terrain goes from {:?} to {:?} m in cells of {} m",
                b.min,
                b.max,
                whole.cell()
            )));
        }
        Ok((whole, window))
    }
}

fn region(text: &str) -> Option<Bounds> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|t| t.trim().parse().ok()).collect();
    match numbers?.as_slice() {
        &[x0, y0, x1, y1] if [x0, y0, x1, y1].iter().all(|v| v.is_finite()) && x0 < x1 && y0 < y1 => {
            Some(Bounds { min: [x0, y0], max: [x1, y1] })
        }
        _ => None,
    }
}

/// Parses a number of bytes such as 1048576, 512M, 8G or 1.5T.
pub(super) fn parse_bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit.to_ascii_lowercase().trim_end_matches("ib").trim_end_matches('b') {
        "" => 1.0,
        "k" => 1024.0,
        "m" => 1024.0 * 1024.0,
        "g" => 1024.0 * 1024.0 * 1024.0,
        "t" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
        _ => return Err(format!("`{unit}` is not a unit of bytes; use K, M, G or T")),
    };
    let value: f64 = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    let bytes = value * factor;
    if (1.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err(format!("must be at least one byte, got `{text}`"))
    }
}

/// Parses seconds, a number from 0 on.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|v: &f64| v.is_finite() && *v >= 0.0);
    value.ok_or_else(|| format!("must be a number of seconds, 0 or more, got `{text}`"))
}

/// Parses a length or a factor, a number above 0.
pub(super) fn parse_positive(text: &str) -> Result<f64, String> {
    const RANGE: std::ops::RangeInclusive<f64> = 1e-9..=1e9;
    let value = text.trim().parse().ok().filter(|v| RANGE.contains(v));
    value.ok_or_else(|| format!("must be a number above 0, at most {:e}, got `{text}`", RANGE.end()))
}

/// Parses a finite number.
pub(super) fn parse_finite(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| format!("must be a number, got `{text}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_seconds() {
        assert_eq!(parse_seconds(" 1.5e3"), Ok(1500.0));
        for bad in ["", "nan", "NaN", "inf", "-inf", "1e400", "-1", "-0.5", "1s"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn reads_bytes() {
        assert_eq!(parse_bytes("512M"), Ok(512 << 20));
        assert_eq!(parse_bytes("1.5 GiB"), Ok(3 << 29));
        assert_eq!(parse_bytes("4096"), Ok(4096));
        for bad in ["", "G", "-1G", "0", "8X", "1e30"] {
            assert!(parse_bytes(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn reads_factors() {
        assert_eq!(parse_positive("0.3048"), Ok(0.3048));
        assert_eq!(parse_finite("-1e3"), Ok(-1000.0));
        for bad in ["", "0", "-0", "-1", "nan", "inf", "1e300", "1e-30", "x"] {
            assert!(parse_positive(bad).is_err(), "{bad}");
        }
        for bad in ["", "nan", "-inf", "x"] {
            assert!(parse_finite(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn reads_regions() {
        assert!(region("0,0,10,20").is_some());
        for bad in ["", "0,0,10", "0,0,0,0", "5,0,1,9", "a,b,c,d", "0,0,inf,9", "0,0,1,2,3"] {
            assert!(region(bad).is_none(), "{bad}");
        }
    }
}
