//! Progress on standard error: a bar on a terminal, lines of JSON for programs, or nothing.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use super::exit::{tell, tell_json};
use crate::engine::{Observer, Plan, PlannedTask};
use crate::text::printable;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Mode {
    /// A bar, on a terminal
    Bar,
    /// One line of JSON an event
    Json,
    /// Nothing
    None,
}

/// An observer that shows the progress of one evaluation after the other.
pub(super) struct Progress {
    mode: Mode,
    /// Whether the user chose the mode.
    asked: bool,
    bar: ProgressBar,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    tasks: Vec<PlannedTask>,
    shares: Vec<f32>,
    total: f64,
    running: Vec<usize>,
    label: String,
}

impl Progress {
    pub(super) fn new(mode: Option<Mode>) -> Self {
        let (asked, terminal) = (mode.is_some(), std::io::stderr().is_terminal());
        let mode = mode.unwrap_or(if terminal { Mode::Bar } else { Mode::None });
        let bar = if mode == Mode::Bar { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{elapsed:>5} {bar:30} {percent:>3} % {wide_msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        if mode == Mode::Bar {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Self { mode, asked, bar, state: Mutex::default() }
    }

    /// Sets the label of the next evaluation, such as a tile or a range on the base grid.
    pub(super) fn label(&self, label: impl Into<String>) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).label = label.into();
    }

    /// Prints a message above the bar.
    pub(super) fn say(&self, message: &str) {
        match self.mode {
            Mode::Json => tell_json(&json!({ "event": "message", "text": message })),
            _ => self.bar.suspend(|| tell(message)),
        }
    }

    /// Prints a message about work that is done, unless the mode shows nothing.
    pub(super) fn news(&self, message: &str) {
        match self.mode {
            Mode::None if self.asked => (),
            Mode::Json => tell_json(&json!({ "event": "news", "text": message })),
            _ => self.say(message),
        }
    }

    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }

    fn update(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut state);
        if self.mode != Mode::Bar {
            return;
        }
        let weight = |t: &PlannedTask| if t.cached.is_some() { 0.0 } else { t.cost.seconds };
        let done: f64 = state.tasks.iter().zip(&state.shares).map(|(t, s)| weight(t) * f64::from(*s)).sum();
        let share = if state.total > 0.0 { done / state.total } else { 0.0 };
        self.bar.set_position((share * 1000.0) as u64);
        let names: Vec<_> =
            state.running.iter().filter_map(|&i| Some(state.tasks.get(i)?.node.as_str())).collect();
        let message = format!("{} {}", state.label, names.join(", "));
        self.bar.set_message(printable(&message).into_owned());
    }

    fn line(&self, event: &str, task: usize, rest: serde_json::Value) {
        if self.mode != Mode::Json {
            return;
        }
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(t) = state.tasks.get(task) else { return };
        let mut line =
            json!({ "event": event, "part": state.label, "node": t.node, "stage": t.stage.name() });
        if let (Some(line), Some(rest)) = (line.as_object_mut(), rest.as_object()) {
            line.extend(rest.clone());
        }
        tell_json(&line);
    }
}

impl Observer for Progress {
    fn reading(&self, node: &str, file: &str, share: f32) {
        match self.mode {
            Mode::Bar => {
                self.bar.set_position((share * 1000.0) as u64);
                self.bar.set_message(format!("reads {file}"));
            }
            Mode::Json => {
                tell(&json!({ "event": "reading", "node": node, "file": file, "share": share }).to_string());
            }
            Mode::None => (),
        }
    }

    fn planned(&self, plan: &Plan) {
        self.update(|s| {
            s.tasks = plan.tasks();
            s.shares = vec![0.0; s.tasks.len()];
            s.total = plan.seconds();
            s.running.clear();
        });
    }

    fn started(&self, task: usize) {
        self.update(|s| s.running.push(task));
        self.line("started", task, json!({}));
    }

    fn progress(&self, task: usize, share: f32) {
        self.update(|s| {
            if let Some(slot) = s.shares.get_mut(task) {
                *slot = share;
            }
        });
        self.line("progress", task, json!({ "share": share }));
    }

    fn finished(&self, task: usize, seconds: f64) {
        self.update(|s| {
            s.running.retain(|t| *t != task);
            if let Some(slot) = s.shares.get_mut(task) {
                *slot = 1.0;
            }
        });
        self.line("finished", task, json!({ "seconds": seconds }));
    }
}
