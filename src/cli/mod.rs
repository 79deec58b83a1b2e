//! The command line: one file a command. Results go to files and standard output, everything else to standard error.

mod args;
mod aside;
mod build;
mod check;
mod convert;
mod exit;
mod fit;
mod folder;
mod heed;
mod height;
mod info;
mod job;
mod nodes;
mod open;
mod plan;
mod progress;
mod render;
mod report;
mod reserve;
mod shared;
mod sidecars;
mod tiles;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use serde_json::json;

pub use exit::Exit;

use crate::node::Cancel;
use crate::nodes::Registry;
use crate::text::printable;

/// A node-graph terrain tool: evaluates .graph files to height fields, pictures and reports.
#[derive(Debug, Parser)]
#[command(name = "orograph", version, arg_required_else_help = true, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Evaluates the graph's outputs and writes them
    Build(Box<build::Args>),
    /// Validates a graph; prints every error and warning
    Check(check::Args),
    /// Prints title, terrain, exposed parameters and outputs of a graph, or what a height file holds
    Info(info::Args),
    /// Prints what a build would run: node, grid, effective resolution, memory, time, cached or not
    Plan(plan::Args),
    /// Prints the node reference
    Nodes(nodes::Args),
    /// Prints the JSON schema of .graph files, for editors that validate
    Schema,
    /// Writes graphs in canonical form
    Fmt(check::FmtArgs),
    /// Converts a height file to another format
    Convert(convert::Args),
    /// Sets width, depth and base of a graph's terrain so that a height file fits it
    Fit(Box<fit::Args>),
    /// Draws a shaded picture of a graph's output or of a height file
    Render(Box<render::Args>),
    /// Opens the editor
    #[cfg(feature = "editor")]
    Edit {
        /// The graph to open
        graph: Option<std::path::PathBuf>,
    },
    /// Prints a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

impl Command {
    /// Whether the result on standard output is JSON; errors are then JSON, too.
    fn prints_json(&self) -> bool {
        match self {
            Self::Check(args) => args.json,
            Self::Info(args) => args.json,
            Self::Plan(args) => args.json,
            Self::Nodes(args) => args.json,
            _ => false,
        }
    }

    /// Whether the command writes no file, so that it can be abandoned when it is cancelled.
    fn writes_nothing(&self) -> bool {
        match self {
            Self::Check(_) | Self::Info(_) | Self::Plan(_) => true,
            Self::Fmt(args) => args.check,
            Self::Fit(args) => args.dry_run,
            _ => false,
        }
    }

    fn is_editor(&self) -> bool {
        #[cfg(feature = "editor")]
        return matches!(self, Self::Edit { .. });
        #[cfg(not(feature = "editor"))]
        false
    }
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let words = words(std::env::args_os().collect());
    let cli = match Cli::try_parse_from(&words) {
        Ok(cli) => cli,
        Err(e) => return refuse(e, &words).into(),
    };
    let json = cli.command.prints_json();
    if let Some(unknown) = crate::kit::simd::Level::unknown() {
        exit::tell(&format!("warning: {unknown}"));
    }
    let cancel = Cancel::default();
    // The editor ends at a signal; its unsaved work is stored for the next start.
    if !cli.command.is_editor() {
        stop_at_signals(cancel.clone());
    }
    let result = if cli.command.writes_nothing() {
        let signal = cancel.clone();
        aside::aside(&cancel, move || run(cli, &signal))
    } else {
        run(cli, &cancel)
    };
    match result {
        Ok(exit) => exit.into(),
        Err(stop) => {
            exit::tell(&format!("error: {}", stop.message));
            if json && !stop.printed {
                // An error of printing is ignored, because the exit code reports the failure.
                let _ = exit::print_json(&json!({ "error": stop.message, "exit": stop.exit.code() }));
            }
            stop.exit.into()
        }
    }
}

/// Prints why the command line was refused, or the help or the version where it asks for one.
fn refuse(error: clap::Error, words: &[OsString]) -> Exit {
    if !error.use_stderr() {
        let _ = error.print();
        return Exit::Done;
    }
    // The message quotes the arguments, so that it is made again from printable ones.
    let shown: Vec<_> = words.iter().map(|w| printable(&w.to_string_lossy()).into_owned()).collect();
    let asks_for_json = asks_for_json(&shown);
    let said = match Cli::try_parse_from(shown) {
        Err(shown) if shown.use_stderr() => {
            let _ = shown.print();
            shown.to_string()
        }
        // Arguments that are not UTF-8 can be valid in their printable form.
        _ => {
            exit::tell(error.to_string().trim_end());
            error.to_string()
        }
    };
    if asks_for_json {
        let _ = exit::print_json(&json!({ "error": fault(&said), "exit": Exit::Usage.code() }));
    }
    Exit::Usage
}

/// Whether arguments that are no valid command line ask for JSON.
fn asks_for_json(words: &[String]) -> bool {
    words.iter().take_while(|word| *word != "--").any(|word| word == "--json")
}

/// The fault of a command line, without the lines on its usage.
fn fault(said: &str) -> &str {
    let said = said.split("\n\nUsage:").next().unwrap_or_default();
    let said = said.split("\n\nFor more information").next().unwrap_or_default().trim();
    said.strip_prefix("error: ").unwrap_or(said)
}

/// Cancels the work at the first signal and ends the process at the second.
fn stop_at_signals(cancel: Cancel) {
    let second = std::sync::atomic::AtomicBool::new(false);
    // Without a handler the process ends at Ctrl+C, which loses nothing, because files are written whole or not at all.
    let _ = ctrlc::set_handler(move || {
        cancel.cancel();
        if second.swap(true, std::sync::atomic::Ordering::SeqCst) {
            std::process::exit(Exit::Cancelled.code());
        }
    });
}

/// The arguments; a graph alone, or none where there is a display, means the editor.
fn words(mut words: Vec<OsString>) -> Vec<OsString> {
    if !cfg!(feature = "editor") {
        return words;
    }
    let is_graph = |word: &OsString| std::path::Path::new(word).extension().is_some_and(|e| e == "graph");
    let screen = !cfg!(target_os = "linux")
        || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    match &words[..] {
        [_] if screen => words.push("edit".into()),
        [_, graph] if is_graph(graph) => words.insert(1, "edit".into()),
        _ => (),
    }
    words
}

fn run(cli: Cli, cancel: &Cancel) -> Result<Exit, exit::Stop> {
    let registry = Registry::standard();
    match cli.command {
        Command::Build(args) => build::run(&args, &registry, cancel),
        Command::Check(args) => check::run(&args, &registry),
        Command::Info(args) => info::run(&args, &registry, cancel),
        Command::Plan(args) => plan::run(&args, &registry, cancel),
        Command::Nodes(args) => nodes::run(&args, &registry),
        Command::Schema => {
            let schema = crate::graph::schema(&registry);
            exit::print_json(&schema)
        }
        Command::Fmt(args) => check::fmt(&args, &registry),
        Command::Convert(args) => convert::run(&args, cancel),
        Command::Fit(args) => fit::run(&args, &registry, cancel),
        Command::Render(args) => render::run(&args, &registry, cancel),
        #[cfg(feature = "editor")]
        Command::Edit { graph } => {
            crate::editor::run(graph).map(|()| Exit::Done).map_err(|e| exit::Stop::new(Exit::Device, e))
        }
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "orograph", &mut script);
            exit::print(&String::from_utf8_lossy(&script))
        }
    }
}
