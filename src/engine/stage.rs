//! The work of one task: its inputs from the results of other tasks, the node's run or the lift, the mixing by a mask,
//! and the check of what came out.

use std::sync::Arc;

use super::cache::Given;
use super::outputs::Outputs;
use super::plan::{Role, Stage, Task};
use super::program::{Input, Step};
use super::{lift, mix};
use crate::name::Name;
use crate::node::{Context, Error, Result};
use crate::ports::{MASK, Wires};
use crate::value::{Grid, Quantity, Value};

/// The results that a task needs, with what each is for.
pub(super) type Needs<'a> = [(Role, &'a Arc<Given>)];

/// Does the work of a task.
///
/// # Errors
/// Returns the error of the node, or of an output that is missing, of another type, on another grid or not finite.
pub(super) fn perform(cx: &Context<'_>, task: &Task, step: &Step, needs: &Needs<'_>) -> Result<Given> {
    let (node, kind) = (&step.node, &*step.kind);
    let mut own = Wires::default();
    for (role, given) in needs {
        if let (Role::Input(i), Some(wires)) = (role, given.wires()) {
            put(&mut own, &step.inputs[*i], wires)?;
        }
    }
    let mut out = match task.stage {
        Stage::Summary => return node.summarize(cx, own).map(Given::Summary),
        Stage::Gridless | Stage::Base | Stage::Run => node.run(cx, own)?,
        Stage::Lift => lifted(cx, step, task.read, needs)?,
    };
    let made = if task.stage == Stage::Lift { task.read } else { Outputs::all(kind) };
    check(&task.grid, step, made, &out)?;
    if !matches!(task.stage, Stage::Gridless | Stage::Base) && !kind.mixes.is_empty() {
        let fine = fine_inputs(step, needs)?;
        if let Some(Value::Field(mask)) = fine.get(&MASK.name) {
            mix::mix(cx, &kind.mixes, &fine, mask, &mut out)?;
        }
    }
    Ok(Given::Wires(out))
}

/// Adds an input to the wires of a step.
fn put(wires: &mut Wires, input: &Input, given: &Wires) -> Result<()> {
    wires.put(input.port.clone(), read(input, given)?.clone());
    Ok(())
}

/// The value that an input reads from the outputs of its source.
fn read<'a>(input: &Input, given: &'a Wires) -> Result<&'a Value> {
    given.get(&input.from).ok_or_else(|| Error::Missing { port: input.port.clone() })
}

/// The inputs on the windows that the node asked for beside the footprint.
pub(super) fn views(step: &Step, needs: &Needs<'_>) -> Result<Vec<(Name, Value)>> {
    let mut views = Vec::new();
    for (role, given) in needs {
        if let (Role::View(i), Some(wires)) = (role, given.wires()) {
            let input = &step.inputs[*i];
            views.push((input.port.clone(), read(input, wires)?.clone()));
        }
    }
    Ok(views)
}

/// The inputs on the grid of the output, which the result is mixed with or carried onto.
fn fine_inputs(step: &Step, needs: &Needs<'_>) -> Result<Wires> {
    let mut fine = Wires::default();
    for (role, given) in needs {
        if let (Role::Fine(i), Some(wires)) = (role, given.wires()) {
            put(&mut fine, &step.inputs[*i], wires)?;
        }
    }
    Ok(fine)
}

/// The outputs of a global node that are read, lifted or carried to the grid of the consumer.
fn lifted(cx: &Context<'_>, step: &Step, read: Outputs, needs: &Needs<'_>) -> Result<Wires> {
    let base = needs.iter().find_map(|(role, g)| if *role == Role::Base { g.wires() } else { None });
    let base = base.ok_or_else(|| Error::Output {
        port: Name::default(),
        message: "was not computed on the base grid".into(),
    })?;
    let fine = fine_inputs(step, needs)?;
    let mut out = Wires::default();
    for (port, after) in base.iter().filter(|(port, _)| read.has(&step.kind, port)) {
        let carried = step.kind.carries.iter().find(|(output, _)| output == port).map(|(_, input)| input);
        let before = carried.and_then(|input| {
            needs.iter().find_map(|(role, g)| match role {
                Role::Before(i) if step.inputs[*i].port == *input => g.wires()?.get(&step.inputs[*i].from),
                _ => None,
            })
        });
        let value = match (before, carried.and_then(|input| fine.get(input))) {
            (Some(before), Some(fine)) => lift::carry(cx, fine, before, after)?,
            _ => lift::lift(cx, after)?,
        };
        out.put(port.clone(), value);
    }
    Ok(out)
}

/// Checks that every output in `made` exists, on the grid of the task, of its type and quantity, and finite (law 8).
fn check(grid: &Grid, step: &Step, made: Outputs, out: &Wires) -> Result<()> {
    for port in made.ports(&step.kind) {
        let bad = |message: String| Err(Error::Output { port: port.name.clone(), message });
        match out.get(&port.name) {
            None if port.required => return bad("is missing".into()),
            None => (),
            Some(value) if value.wire_type() != port.wire => {
                return bad(format!("is {}, not {}", value.wire_type().name(), port.wire.name()));
            }
            Some(value) if value.grid().is_some_and(|g| g != grid) => {
                return bad(format!("stands on {:?}, not on {grid:?}", value.grid()));
            }
            Some(value) if value.quantity() != step.quantity(&port.name) => {
                let named = |q: Option<Quantity>| q.map_or("nothing", Quantity::name);
                let (got, said) = (named(value.quantity()), named(step.quantity(&port.name)));
                return bad(format!("is {got}, and the kind says {said}"));
            }
            Some(Value::Object(object)) => {
                if let Some(fault) = object.fault() {
                    return bad(fault);
                }
            }
            Some(value) => {
                if let Some((col, row)) = value.first_not_finite() {
                    return Err(Error::NotFinite { port: port.name.clone(), col, row });
                }
            }
        }
    }
    Ok(())
}
