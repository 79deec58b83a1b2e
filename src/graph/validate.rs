//! Validation: all errors and warnings of a graph, in the order of the file.

use std::collections::HashMap;

use serde_json::{Map, Value as Json};

use super::canvas::Note;
use super::parts::{About, Exposed, GraphNode, KindRef, NodeKeys, Output, Part, faults};
use super::problem::{Hints, Place, Problem, Severity, listed};
use super::{Graph, NodeId, Source, settings};
use crate::node::{Error, Kind, Reads};
use crate::text::brief;
use crate::value::WireType;
use crate::whole::is_device;

/// The most bytes in the name of a node, an output or an exposed parameter.
const MAX_NAME: usize = 64;
/// Top-level keys of the file that later versions will read.
const RESERVED: [&str; 2] = ["inputs", "graphs"];
/// Prefixes of kinds that later versions will know: graphs as nodes.
const RESERVED_KINDS: [&str; 2] = ["graph:", "file:"];

/// The fault of the name of an exposed parameter.
pub(super) fn name_fault(name: &str) -> Option<String> {
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let good = (1..=MAX_NAME).contains(&name.len()) && name.chars().all(fits);
    (!good).then(|| format!("must have a name of 1 to {MAX_NAME} of the characters a to z, 0 to 9 and _"))
}

/// The fault of the name of a node.
pub(super) fn node_name_fault(name: &str) -> Option<String> {
    let reserved = || "cannot have the name of the terrain's settings".to_owned();
    name_fault(name).or_else(|| (name == "terrain").then(reserved))
}

/// The fault of the name of an output, which becomes the name of a file.
pub(super) fn output_name_fault(name: &str) -> Option<String> {
    let device = || "has a name that Windows keeps for a device".to_owned();
    name_fault(name).or_else(|| is_device(name).then(device))
}

impl Graph {
    /// All errors and warnings: first of the graph and its terrain, then of exposed parameters, nodes and outputs in
    /// the order of the file, then cycles, twins and others that concern several places.
    pub fn problems(&self) -> Vec<Problem> {
        let hints = Hints::new();
        let mut found = self.load_warnings.clone();
        found.extend(self.extra_problems(&hints));
        found.extend(settings::faults(&self.settings, &hints));
        found.extend(self.exposed_problems(&hints));
        for id in self.nodes() {
            let faults = self.node_problems(id, &hints);
            found.extend(faults.into_iter().map(|p| p.of(id)));
        }
        found.extend(self.cycles());
        found.extend(self.output_problems(&hints));
        found.extend(self.note_problems(&hints));
        found.extend(self.twins());
        if self.outputs.is_empty() {
            found.push(Problem::warning(Place::Graph, "has no outputs, so that nothing would be built"));
        }
        found
    }

    fn extra_problems(&self, hints: &Hints) -> Vec<Problem> {
        let (reserved, rest): (Map<_, _>, Map<_, _>) = self
            .extra
            .iter()
            .map(|(k, v)| (k.clone(), v.clone()))
            .partition(|(key, _)| RESERVED.contains(&key.as_str()));
        let kept = |key: &String| format!("`{key}` is not yet supported by this version, and kept as it is");
        let mut found: Vec<_> =
            reserved.keys().map(|key| Problem::warning(Place::Graph, kept(key))).collect();
        let parts = ["kinds", "terrain", "expose", "nodes", "outputs", "notes"];
        found.extend(placed(faults(About::keys(), &parts, &rest, hints), &Place::Graph));
        found
    }

    pub(super) fn exposed_problems(&self, hints: &Hints) -> Vec<Problem> {
        let owners = self.owners();
        let mut found = Vec::new();
        for (i, (name, exposed)) in self.exposed.iter().enumerate() {
            let place = Place::Exposed(name.clone());
            found.extend(name_fault(name).map(|fault| Problem::error(place.clone(), fault)));
            found.extend(placed(faults(Exposed::keys(), &[], &exposed.extra, hints), &place));
            if exposed.extra.contains_key("bind") {
                continue;
            }
            match self.bound(i, name, exposed, &owners, hints) {
                Err(faults) => found.extend(faults),
                Ok(bound) => {
                    if let Err(message) = bound.param.shape.check(&exposed.value) {
                        found.extend(self.blame_all(
                            vec![Problem::error(place, message)],
                            name,
                            &bound.binds,
                        ));
                    }
                }
            }
        }
        found
    }

    fn node_problems(&self, id: NodeId, hints: &Hints) -> Vec<Problem> {
        let node = self.node(id);
        let place = || Place::Node(node.name.clone());
        let mut found = Vec::new();
        found.extend(node_name_fault(&node.name).map(|fault| Problem::error(place(), fault)));
        let keys = faults(NodeKeys::keys(), &["in", "set", "kind"], &node.extra, hints);
        if !keys.is_empty() {
            found.extend(placed(keys, &place()));
        }
        match &node.kind {
            KindRef::Unknown(kind) => found.push(Problem::error(place(), self.unknown_kind(kind, hints))),
            KindRef::Known(kind) => {
                found.extend(parameter_problems(node, kind, hints));
                found.extend(self.input_problems(id, kind, hints));
            }
        }
        found
    }

    fn unknown_kind(&self, kind: &str, hints: &Hints) -> String {
        if let Some(known) = self.registry.find(kind) {
            return self.version_of(known).err().unwrap_or_default();
        }
        if RESERVED_KINDS.iter().any(|prefix| kind.starts_with(prefix)) {
            return format!(
                "is of kind `{kind}`: graphs as nodes are not yet supported by this version; it is kept as it is"
            );
        }
        let hint = hints.nearest(kind, self.registry.iter().map(|k| k.id.as_str()));
        format!("is of kind `{kind}`, which is not known, and kept as it is{hint}")
    }

    fn input_problems(&self, id: NodeId, kind: &Kind, hints: &Hints) -> Vec<Problem> {
        let node = self.node(id);
        let place = |port: &str| Place::Input { node: node.name.clone(), port: port.to_owned() };
        let uses = |port: &str| node.parse().ok().is_none_or(|n| kind.uses(&*n, port));
        let mut found = Vec::new();
        for port in kind.inputs.iter() {
            if let Some(written) = node.loose.get(port.name.as_str()) {
                let want = port.wire.name();
                let message = match written.as_str().map(|text| (text, self.resolve(text))) {
                    None => format!("must be written as `node.port`, got {}", brief(written)),
                    Some((text, Err(miss))) => self.explain(text, &miss, hints),
                    Some((text, Ok(source))) => {
                        let got = self.wire_type(&source).map_or("nothing", |w| w.name());
                        format!("takes {want}, but `{text}` gives {got}")
                    }
                };
                let problem = if uses(&port.name) { Problem::error } else { Problem::warning };
                found.push(problem(place(&port.name), message));
            } else if port.required && uses(&port.name) {
                match self.source(id, &port.name) {
                    None => found.push(Problem::error(place(&port.name), "must be connected")),
                    Some(source) if self.passed(source.clone()).is_none() => {
                        found.push(Problem::error(place(&port.name), self.nothing_passed(&source)));
                    }
                    Some(_) => (),
                }
            }
        }
        for (name, _) in node.loose.iter().filter(|(name, _)| kind.input(name).is_none()) {
            let names = || kind.inputs.iter().map(|p| p.name.as_str());
            let (all, hint) = (listed(names()), hints.nearest(name, names()));
            let message = format!("`{}` has no such input; it has {all}{hint}", kind.id);
            found.push(Problem::error(place(name), message));
        }
        found
    }

    /// The message that a value comes from bypassed nodes that have nothing to pass on.
    pub(super) fn nothing_passed(&self, source: &Source) -> String {
        format!("reads `{}`, which is bypassed and has nothing to pass on", self.source_text(source))
    }

    fn note_problems(&self, hints: &Hints) -> Vec<Problem> {
        let problems = |(name, note): (&str, &Note)| {
            let place = Place::Note(name.to_owned());
            let fault = name_fault(name).map(|fault| Problem::warning(place.clone(), fault));
            // A fault of a note is only a warning.
            let keys = placed(faults(Note::keys(), &[], &note.extra, hints), &place).into_iter();
            let soft = |problem: Problem| Problem { severity: Severity::Warning, ..problem };
            fault.into_iter().chain(keys.map(soft)).collect::<Vec<_>>()
        };
        self.notes().flat_map(problems).collect()
    }

    fn output_problems(&self, hints: &Hints) -> Vec<Problem> {
        let mut found = Vec::new();
        let mut seen: HashMap<String, &str> = HashMap::new();
        for (name, output) in self.outputs() {
            found.extend(self.output_faults(name, output, hints));
            if let Some(other) = seen.insert(name.to_lowercase(), name) {
                let message = format!("has the name of the output `{other}` but for upper and lower case");
                found.push(Problem::error(Place::Output(name.to_owned()), message));
            }
        }
        found
    }

    /// The faults of an output by itself.
    pub(super) fn output_faults(&self, name: &str, output: &Output, hints: &Hints) -> Vec<Problem> {
        let place = Place::Output(name.to_owned());
        let error = |message: String| Problem::error(place.clone(), message);
        let mut found: Vec<Problem> = output_name_fault(name).map(error).into_iter().collect();
        found.extend(placed(faults(Output::keys(), &[], &output.extra, hints), &place));
        if output.from.is_empty() && !output.extra.contains_key("from") {
            found.push(error("needs `from`, the output of a node as `node.port`".to_owned()));
        } else if !output.extra.contains_key("from") {
            match self.resolve(&output.from) {
                Err(miss) => found.push(error(self.explain(&output.from, &miss, hints))),
                Ok(source) => {
                    let wire = self.wire_type(&source);
                    found.extend(wire.and_then(|wire| unfit(output, wire)).map(error));
                    if self.passed(source.clone()).is_none() {
                        found.push(error(self.nothing_passed(&source)));
                    }
                }
            }
        }
        if let Some([low, high]) = output.range
            && !(low.is_finite() && high.is_finite() && low < high)
        {
            found.push(error(format!("`range` must be a lower and a higher number, got [{low}, {high}]")));
        }
        found
    }

    /// Warnings about random nodes that are equal in everything; most often one is a copy with the same seed.
    fn twins(&self) -> Vec<Problem> {
        let mut seen: HashMap<(&str, String), NodeId> = HashMap::new();
        let mut found = Vec::new();
        for id in self.nodes() {
            let node = self.node(id);
            let random = |k: &Kind| k.reads.has(Reads::SEED) && k.param("seed").is_some();
            let Some(kind) = node.kind().filter(|k| random(k)) else { continue };
            match seen.entry((kind.id.as_str(), Json::Object(node.changed()).to_string())) {
                std::collections::hash_map::Entry::Vacant(slot) => _ = slot.insert(id),
                std::collections::hash_map::Entry::Occupied(first) => {
                    let other = &self.node(*first.get()).name;
                    let message =
                        format!("is that of `{other}`, and all other parameters are the same: twins");
                    let place = Place::Parameter { node: node.name.clone(), parameter: "seed".to_owned() };
                    found.push(Problem::warning(place, message).of(id));
                }
            }
        }
        found
    }
}

fn parameter_problems(node: &GraphNode, kind: &Kind, hints: &Hints) -> Vec<Problem> {
    let Err(error) = node.parse() else { return Vec::new() };
    let place = |name: &str| Place::Parameter { node: node.name.clone(), parameter: name.to_owned() };
    let mut found = Vec::new();
    for param in kind.params() {
        let fault = node.set.get(&param.name).and_then(|value| param.shape.check(value).err());
        found.extend(fault.map(|message| Problem::error(place(&param.name), message)));
    }
    let names = || kind.params().iter().map(|p| p.name.as_str());
    for name in node.set.keys().filter(|name| kind.param(name).is_none()) {
        let (all, hint) = (listed(names()), hints.nearest(name, names()));
        let message = format!("is not one of this kind's: {all}{hint}");
        found.push(Problem::error(place(name), message));
    }
    if found.is_empty() {
        found.push(match error {
            Error::Parameter { name, message } => Problem::error(place(&name), message),
            other => Problem::error(Place::Node(node.name.clone()), other.to_string()),
        });
    }
    found
}

fn placed(faults: Vec<(Severity, String)>, place: &Place) -> Vec<Problem> {
    let problem = |(severity, message)| Problem { severity, ..Problem::error(place.clone(), message) };
    faults.into_iter().map(problem).collect()
}

/// What is wrong with writing a value of a type as an output says.
fn unfit(output: &Output, wire: WireType) -> Option<String> {
    let (from, name) = (&output.from, wire.name());
    if !wire.is_output() {
        return Some(format!("`from` must be a field, vectors, colours or lines, `{from}` is {name}"));
    }
    let format = output.format.filter(|f| f.holds_lines() == wire.is_raster())?;
    let holds = if format.holds_lines() { "lines" } else { "samples on a grid" };
    Some(format!("`format` {format} holds {holds}, `{from}` is {name}"))
}
