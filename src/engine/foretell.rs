//! Gridless values that are known while a plan is made.
//!
//! The cost of rasterising curves depends on the curves, so that a plan has to know them. Kinds that are declared
//! quick, because their parameters contain their results, run while the plan is made; these values serve only to
//! estimate the costs of nodes that read them. Values that depend on the content of a file are not known then: an
//! evaluation computes them first and plans again.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::cache::Found;
use super::plan::{Role, Stage};
use super::program::{Program, Step};
use crate::node::{Cancel, Context};
use crate::ports::Wires;
use crate::value::{Grid, Value};

/// The known values of gridless steps.
pub(super) struct Foretold<'a> {
    program: &'a Program,
    steps: Vec<Option<Wires>>,
}

impl<'a> Foretold<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        Self { program, steps: vec![None; program.steps.len()] }
    }

    /// Adds a step after the steps that it reads; returns its values where they are known.
    pub(super) fn take(&mut self, i: usize, stage: Stage, found: Option<&Found>) -> Option<&Wires> {
        let Ok(step) = &self.program.steps[i] else { return None };
        if stage == Stage::Gridless && self.steps[i].is_none() {
            self.steps[i] = match found {
                Some(Found::Memory(given, _)) => given.wires().cloned(),
                Some(Found::Disk(_)) => None,
                None => self.run(step),
            };
        }
        self.steps[i].as_ref()
    }

    /// The value at an input of a step, where it is known.
    pub(super) fn input(&self, step: &Step, port: &str) -> Option<Value> {
        let input = step.input(port)?;
        self.steps[input.step].as_ref()?.get(&input.from).cloned()
    }

    /// The values of a quick step. `None` where an input is not known, or where the step fails, which its run in the
    /// evaluation reports.
    fn run(&self, step: &Step) -> Option<Wires> {
        if !step.kind.quick || !step.files.is_empty() {
            return None;
        }
        let inputs = step.inputs.iter().map(|i| Some((i.port.clone(), self.input(step, &i.port)?)));
        let wires: Wires = inputs.collect::<Option<_>>()?;
        let cancel = Cancel::default();
        let cx = Context {
            reads: step.kind.reads,
            ..Context::bare(Grid::NOWHERE, &self.program.terrain, &cancel)
        };
        catch_unwind(AssertUnwindSafe(|| step.node.run(&cx, wires))).ok()?.ok()
    }
}

/// Whether a role is that of a value on which the task itself works.
pub(super) fn is_input(role: &Role) -> bool {
    matches!(role, Role::Input(_))
}
