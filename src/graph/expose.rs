//! Exposed parameters: a name and a value for parameters of nodes and settings of the terrain.

use std::collections::{BTreeSet, HashMap};

use serde_json::Value as Json;

use super::bind::{Bind, MAX_STEPS, Owner, split};
use super::parts::{Exposed, Part};
use super::path::Spot;
use super::problem::{Hints, Place, Problem, listed};
use super::validate::name_fault;
use super::{Graph, MAX_NAMED, NodeId, json, settings};
use crate::params::{Param, Shape};

/// An exposed parameter whose binds all resolve.
pub(super) struct Bound {
    pub(super) binds: Vec<Bind>,
    /// The exposed parameter as a parameter; its default is the current value of the first bind.
    pub(super) param: Param,
}

/// The meaning of null as the value of an exposed parameter.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Null {
    /// The value of the first bind is taken over.
    IsTaken,
    /// The value is null.
    IsMeant,
}

/// The exposed parameter to which each bound path, and each part of one, belongs: the first in the file.
#[derive(Default)]
pub(super) struct Owners {
    whole: HashMap<String, usize>,
    part: HashMap<String, usize>,
}

impl Owners {
    /// An exposed parameter before the `i`-th that binds the same parameter, one that contains it or one inside it.
    fn before(&self, i: usize, bind: &str) -> Option<usize> {
        let around = prefixes(bind).filter_map(|p| self.whole.get(p));
        around.chain(self.part.get(bind)).copied().filter(|&owner| owner < i).min()
    }
}

/// The prefixes of a path from its second step on: `a.b`, `a.b.c` and so on.
fn prefixes(bind: &str) -> impl Iterator<Item = &str> {
    let ends = bind.match_indices('.').map(|(i, _)| i).skip(1).chain([bind.len()]);
    ends.map(|end| &bind[..end]).take(MAX_STEPS)
}

impl Graph {
    /// Sets an exposed parameter, a parameter of a node or a setting of the terrain from a text, as `--set` does:
    /// `ruggedness`, `hills.octaves`, `hills.mode.turned.angle`, `terrain.width`.
    ///
    /// # Errors
    /// Fails when there is no such parameter, the text does not fit, or the parameter is exposed under another name.
    pub fn assign(&mut self, name: &str, text: &str) -> Result<(), Problem> {
        let (place, shape) = self.shape_of(name)?;
        let value = shape.parse_text(text).map_err(|message| Problem::error(place, message))?;
        self.assign_json(name, &value)
    }

    /// Sets an exposed parameter, a parameter of a node or a setting of the terrain, as `--vars` does.
    ///
    /// # Errors
    /// Returns the errors of [`assign`](Self::assign).
    pub fn assign_json(&mut self, name: &str, value: &Json) -> Result<(), Problem> {
        if self.exposed_index(name).is_some() {
            return self.set_exposed(name, value.clone());
        }
        let bind = self.find_bind(name, &Hints::new())?;
        self.set_bind(&bind, value.clone())
    }

    /// Sets a parameter of a node; a dotted path names a value inside a mode.
    ///
    /// # Errors
    /// Fails when there is no such parameter, the value does not fit, or the parameter is exposed.
    pub fn set(&mut self, id: NodeId, parameter: &str, value: Json) -> Result<(), Problem> {
        self.live(id)?;
        self.set_bind(&Bind { owner: Owner::Node(id), path: split(parameter) }, value)
    }

    /// Sets a setting of the terrain.
    ///
    /// # Errors
    /// Fails when there is no such setting, the value does not fit, or the setting is exposed. Settings that contradict
    /// each other are reported by [`problems`](Self::problems) and not refused, so that they can be changed one by one.
    pub fn set_terrain(&mut self, setting: &str, value: Json) -> Result<(), Problem> {
        self.set_bind(&Bind { owner: Owner::Terrain, path: split(setting) }, value)
    }

    /// Resets a parameter of a node to its default.
    ///
    /// # Errors
    /// Fails when there is no such parameter, or it is exposed.
    pub fn reset(&mut self, id: NodeId, parameter: &str) -> Result<(), Problem> {
        self.live(id)?;
        self.reset_bind(&Bind { owner: Owner::Node(id), path: split(parameter) })
    }

    /// Resets a setting of the terrain to its default.
    ///
    /// # Errors
    /// Fails when there is no such setting, or it is exposed.
    pub fn reset_terrain(&mut self, setting: &str) -> Result<(), Problem> {
        self.reset_bind(&Bind { owner: Owner::Terrain, path: split(setting) })
    }

    /// Exposes parameters under a name. A null value stands for the value of the first of them.
    ///
    /// # Errors
    /// Fails when the name is taken or invalid, a bind does not resolve or is exposed already, the binds differ in
    /// type, or the value does not fit.
    pub fn expose(&mut self, name: &str, exposed: Exposed) -> Result<(), Problem> {
        let bad = |message: String| Err(Problem::error(Place::Exposed(name.to_owned()), message));
        if let Some(fault) = name_fault(name) {
            return bad(fault);
        }
        if self.exposed_index(name).is_some() {
            return bad("is exposed already".to_owned());
        }
        if self.exposed.len() >= MAX_NAMED {
            return bad(format!("would be one more than the limit of {MAX_NAMED}"));
        }
        self.put_exposed(self.exposed.len(), name, exposed, Null::IsTaken)
    }

    /// Changes the binds, the limits and the texts of an exposed parameter.
    ///
    /// # Errors
    /// Fails when there is no exposed parameter of the name, and for the reasons of [`expose`](Self::expose).
    pub fn change_exposed(&mut self, name: &str, exposed: Exposed) -> Result<(), Problem> {
        let i = self.exposed_index(name).ok_or_else(|| self.not_exposed(name))?;
        self.put_exposed(i, name, exposed, Null::IsTaken)
    }

    /// Removes an exposed parameter; the parameters that it bound keep their values.
    ///
    /// # Errors
    /// Fails when there is no exposed parameter of the name.
    pub fn unexpose(&mut self, name: &str) -> Result<Exposed, Problem> {
        let i = self.exposed_index(name).ok_or_else(|| self.not_exposed(name))?;
        let (_, exposed) = self.exposed.remove(i);
        self.settle();
        Ok(exposed)
    }

    /// Sets an exposed parameter and all parameters that it binds.
    ///
    /// # Errors
    /// Fails when there is no exposed parameter of the name, it has a fault, or the value does not fit.
    pub fn set_exposed(&mut self, name: &str, mut value: Json) -> Result<(), Problem> {
        json::tidy(&mut value);
        let i = self.exposed_index(name).ok_or_else(|| self.not_exposed(name))?;
        let exposed = &self.exposed[i].1;
        if json::same(&exposed.value, &value) {
            return Ok(());
        }
        let exposed = Exposed { value, ..exposed.clone() };
        self.put_exposed(i, name, exposed, Null::IsMeant)
    }

    /// An exposed parameter as a parameter: it has the type and unit of its binds, its own range, and its value as the
    /// default.
    ///
    /// # Errors
    /// Fails when there is no exposed parameter of the name, or it has a fault.
    pub fn exposed_param(&self, name: &str) -> Result<Param, Problem> {
        let i = self.exposed_index(name).ok_or_else(|| self.not_exposed(name))?;
        let exposed = &self.exposed[i].1;
        let bound = self.bound(i, name, exposed, &self.owners(), &Hints::new()).map_err(first)?;
        Ok(Param { default: exposed.value.clone(), ..bound.param })
    }

    fn put_exposed(&mut self, i: usize, name: &str, mut exposed: Exposed, null: Null) -> Result<(), Problem> {
        Exposed::forget_known(&mut exposed.extra);
        let mut owners = self.owners();
        // Its own old binds do not count as taken, while those of later exposed parameters do.
        owners.whole.retain(|_, owner| *owner != i);
        owners.part.retain(|_, owner| *owner != i);
        let bound = self.bound(usize::MAX, name, &exposed, &owners, &Hints::new()).map_err(first)?;
        if exposed.value.is_null() && null == Null::IsTaken {
            exposed.value = bound.param.default.clone();
        }
        json::tidy(&mut exposed.value);
        let fits = bound.param.shape.check(&exposed.value);
        fits.map_err(|message| Problem::error(Place::Exposed(name.to_owned()), message))?;
        if exposed.value.is_null() {
            // The file does not write it: it is what the binds have.
            bound.binds.iter().for_each(|bind| self.put_at(bind, Json::Null));
        }
        match self.exposed.get_mut(i) {
            Some(slot) if slot.1 == exposed => return Ok(()),
            Some(slot) => slot.1 = exposed,
            None => self.exposed.push((name.to_owned(), exposed)),
        }
        self.settle();
        Ok(())
    }

    /// The place and the shape of the parameter of a name.
    fn shape_of(&self, name: &str) -> Result<(Place, Shape), Problem> {
        if self.exposed_index(name).is_some() {
            return Ok((Place::Exposed(name.to_owned()), self.exposed_param(name)?.shape));
        }
        let hints = Hints::new();
        let bind = self.find_bind(name, &hints)?;
        let place = self.place_of(&bind);
        let spot = self.spot(&bind, &hints).map_err(|message| Problem::error(place.clone(), message))?;
        Ok((place, spot.shape.clone()))
    }

    fn not_exposed(&self, name: &str) -> Problem {
        let names = || self.exposed().map(|(n, _)| n);
        let hint = Hints::new().nearest(name, names());
        let message = format!("is not exposed by this graph; it exposes {}{hint}", listed(names()));
        Problem::error(Place::Exposed(name.to_owned()), message)
    }

    pub(super) fn exposed_index(&self, name: &str) -> Option<usize> {
        self.exposed.iter().position(|(n, _)| n == name)
    }

    pub(super) fn owners(&self) -> Owners {
        let mut owners = Owners::default();
        for (i, (_, exposed)) in self.exposed.iter().enumerate() {
            for bind in &exposed.bind {
                owners.whole.entry(bind.clone()).or_insert(i);
                for part in prefixes(bind) {
                    owners.part.entry(part.to_owned()).or_insert(i);
                }
            }
        }
        owners
    }

    /// The binds of an exposed parameter, and the exposed parameter as a parameter.
    pub(super) fn bound(
        &self,
        i: usize,
        name: &str,
        exposed: &Exposed,
        owners: &Owners,
        hints: &Hints,
    ) -> Result<Bound, Vec<Problem>> {
        let place = || Place::Exposed(name.to_owned());
        let mut faults = Vec::new();
        let mut binds = Vec::new();
        let mut param: Option<Param> = None;
        for text in &exposed.bind {
            match self.bound_one(i, text, owners, hints) {
                Ok((bind, spot)) => {
                    let shape = match &param {
                        None => Some(spot.shape.clone()),
                        Some(so_far) => meet(&so_far.shape, spot.shape),
                    };
                    match shape {
                        Some(shape) => param.get_or_insert_with(|| spot_param(&spot)).shape = shape,
                        None => {
                            let message = format!(
                                "binds `{text}`, whose values are of another kind or range than those before"
                            );
                            faults.push(Problem::error(place(), message));
                        }
                    }
                    binds.push(bind);
                }
                Err(message) => {
                    faults.push(Problem::error(place(), format!("cannot bind `{text}`: {message}")))
                }
            }
        }
        let Some(mut param) = param.filter(|_| faults.is_empty()) else {
            if faults.is_empty() {
                faults.push(Problem::error(place(), "binds nothing"));
            }
            return Err(self.blame_all(faults, name, &binds));
        };
        if let Err(message) = narrow(&mut param.shape, exposed) {
            return Err(self.blame_all(vec![Problem::error(place(), message)], name, &binds));
        }
        param.name = name.to_owned();
        if !exposed.about.is_empty() {
            param.doc.clone_from(&exposed.about);
        }
        Ok(Bound { binds, param })
    }

    fn bound_one(
        &self,
        i: usize,
        text: &str,
        owners: &Owners,
        hints: &Hints,
    ) -> Result<(Bind, Spot<'_>), String> {
        if !text.contains('.') {
            return Err("it must be written as `node.parameter`".to_owned());
        }
        let bind = self.find_bind(text, hints).map_err(|p| p.to_string())?;
        let spot =
            self.spot(&bind, hints).map_err(|message| format!("{}: {message}", self.place_of(&bind)))?;
        if let Some(other) = owners.before(i, text).and_then(|i| self.exposed.get(i)) {
            return Err(format!("it is exposed as `{}` already", other.0));
        }
        Ok((bind, spot))
    }

    /// The problems of an exposed parameter, with at least one for each node and each setting of the terrain that it
    /// sets, because none of them can be used while the value has a fault.
    pub(super) fn blame_all(&self, mut faults: Vec<Problem>, name: &str, binds: &[Bind]) -> Vec<Problem> {
        let Some(fault) = faults.first().cloned() else { return faults };
        let mut nodes = BTreeSet::new();
        for bind in binds {
            match bind.owner {
                Owner::Node(id) => _ = nodes.insert(id),
                Owner::Terrain => {
                    let message = format!("is exposed as `{name}`, which has a fault: it {}", fault.message);
                    faults.push(Problem::error(self.place_of(bind), message));
                }
            }
        }
        let mut nodes = nodes.into_iter();
        let Some(one) = nodes.next() else { return faults };
        faults.iter_mut().filter(|f| matches!(f.place, Place::Exposed(_))).for_each(|f| f.node = Some(one));
        for id in nodes {
            let message = format!("{}; it sets `{}` too", fault.message, self.node(id).name);
            faults.push(Problem { message, ..fault.clone() }.of(id));
        }
        faults
    }

    /// Brings everything in line after an edit: wires that resolve now, exposed values, the terrain.
    pub(super) fn settle(&mut self) {
        self.link();
        self.apply_exposed(&[]);
        self.look_at_settings();
        self.touch();
    }

    /// Makes the terrain, and notes what of it and of the exposed parameters cannot be used.
    pub(super) fn look_at_settings(&mut self) {
        self.terrain = settings::terrain(&self.settings);
        let hints = Hints::none();
        let faults =
            settings::faults(&self.settings, &hints).into_iter().chain(self.exposed_problems(&hints));
        self.blocking_problems = faults.filter(Problem::is_error).collect();
    }

    pub(super) fn live(&self, id: NodeId) -> Result<(), Problem> {
        let gone = || Problem::error(Place::Graph, "has no such node any more");
        self.get(id).map(drop).ok_or_else(gone)
    }
}

fn first(faults: Vec<Problem>) -> Problem {
    faults.into_iter().next().unwrap_or_else(|| Problem::error(Place::Graph, "cannot be changed"))
}

fn spot_param(spot: &Spot<'_>) -> Param {
    let mut default = spot.value.json();
    json::tidy(&mut default);
    Param { shape: spot.shape.clone(), default, ..spot.param.clone() }
}

/// The values that fit both; `None` when the two are of different kinds or have no value in common.
fn meet(a: &Shape, b: &Shape) -> Option<Shape> {
    match (a, b) {
        (Shape::Number { min, max, integer }, Shape::Number { min: low, max: high, integer: whole }) => {
            let (min, max) = (min.max(*low), max.min(*high));
            (min <= max).then_some(Shape::Number { min, max, integer: *integer || *whole })
        }
        (Shape::Text { max_length: a }, Shape::Text { max_length: b }) => {
            Some(Shape::Text { max_length: *a.min(b) })
        }
        (Shape::Optional(a), Shape::Optional(b)) => Some(Shape::Optional(Box::new(meet(a, b)?))),
        (Shape::Optional(a), b) | (b, Shape::Optional(a)) => meet(a, b),
        (a, b) => (a == b).then(|| a.clone()),
    }
}

/// Narrows the range to the limits of an exposed parameter.
fn narrow(shape: &mut Shape, exposed: &Exposed) -> Result<(), String> {
    if exposed.min.is_none() && exposed.max.is_none() {
        return Ok(());
    }
    match shape {
        Shape::Optional(inner) => narrow(inner, exposed),
        Shape::Number { min, max, .. } => {
            let low = exposed.min.map_or(*min, |m| m.max(*min));
            let high = exposed.max.map_or(*max, |m| m.min(*max));
            if low > high {
                return Err(format!(
                    "allows no value: `min` and `max` give {} to {}, and its parameters take {min} to {max}",
                    exposed.min.unwrap_or(*min),
                    exposed.max.unwrap_or(*max)
                ));
            }
            (*min, *max) = (low, high);
            Ok(())
        }
        _ => Err("has `min` or `max`, but its values are no numbers".to_owned()),
    }
}
