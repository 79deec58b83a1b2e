//! Edits of a graph that the editor offers. Each is one change of the document and is independent of the screen.

use std::collections::BTreeSet;

use serde_json::Value as Json;

use crate::graph::{Grafted, Graph, LoadError, NodeId, Note, Place, Problem, Source};
use crate::name::Name;
use crate::node::Kind;
use crate::nodes::Registry;
use crate::value::WireType;

/// The fixed end of a wire whose other end is being dragged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// An output; the other end is to be an input.
    From(Source),
    /// An input; the other end is to be an output.
    To(NodeId, Name),
}

impl End {
    /// The type of the wire.
    pub(crate) fn wire(&self, graph: &Graph) -> Option<WireType> {
        match self {
            Self::From(source) => graph.wire_type(source),
            Self::To(id, input) => Some(graph.get(*id)?.kind()?.input(input)?.wire),
        }
    }

    /// The first port of a kind that can be the other end.
    pub(crate) fn port_of<'k>(&self, graph: &Graph, kind: &'k Kind) -> Option<&'k Name> {
        let wire = self.wire(graph)?;
        let ports = match self {
            Self::From(_) => &kind.inputs,
            Self::To(..) => &kind.outputs,
        };
        ports.iter().find(|p| p.wire == wire).map(|p| &p.name)
    }
}

/// Adds a node of a kind, with its middle at a place, joined to a wire's end where one is given.
pub(crate) fn add(graph: &mut Graph, kind: &Kind, at: [f64; 2], end: Option<End>) -> Result<NodeId, Problem> {
    let name = graph.free_name(&kind.id);
    let id = graph.add(&name, &kind.id)?;
    graph.move_to(id, at)?;
    if let Some(end) = end
        && let Some(port) = end.port_of(graph, kind)
    {
        match end {
            End::From(source) => graph.connect(source.node, &source.port, id, port)?,
            End::To(node, input) => graph.connect(id, port, node, &input)?,
        }
    }
    Ok(id)
}

/// Adds nodes one after another, each joined to the one before.
pub(crate) fn add_chain(graph: &mut Graph, at: [f64; 2], kinds: &[&str]) -> Result<Vec<NodeId>, Problem> {
    let mut all = Vec::new();
    let mut end = None;
    for (k, id) in kinds.iter().enumerate() {
        let unknown = || Problem::error(Place::Graph, format!("there is no kind `{id}`"));
        let kind = graph.registry().find(id).cloned().ok_or_else(unknown)?;
        let new = add(graph, &kind, [at[0] + 280.0 * k as f64, at[1]], end)?;
        end = kind.outputs.first().map(|p| End::From(Source { node: new, port: p.name.clone() }));
        all.push(new);
    }
    Ok(all)
}

/// The input and the output by which a node fits between a source and an input of the node `to`; `None` where it does
/// not fit.
pub(crate) fn between(graph: &Graph, id: NodeId, source: &Source, to: NodeId) -> Option<[Name; 2]> {
    let kind = graph.get(id)?.kind()?;
    let wire = graph.wire_type(source)?;
    let output = kind.outputs.iter().find(|p| p.wire == wire)?;
    // The input that the node changes comes first, then its other inputs.
    let changed = kind.bridge(&output.name).and_then(|name| kind.input(name));
    let input = changed.into_iter().chain(&kind.inputs).find(|p| p.wire == wire)?;
    let strangers = id != source.node && id != to;
    strangers.then(|| [input.name.clone(), output.name.clone()])
}

/// Puts a node into a wire.
pub(crate) fn insert(
    graph: &mut Graph,
    id: NodeId,
    source: &Source,
    to: NodeId,
    port: &str,
) -> Result<(), Problem> {
    let Some([input, output]) = between(graph, id, source, to) else {
        let name = graph.get(id).map_or(String::new(), |n| n.name.clone());
        return Err(Problem::error(Place::Node(name), "does not fit into this wire"));
    };
    graph.connect(source.node, &source.port, id, &input)?;
    graph.connect(id, &output, to, port)
}

/// Removes nodes and notes; with `bridge`, the input that a removed node changed is wired to what read the node.
pub(crate) fn remove(
    graph: &mut Graph,
    nodes: &BTreeSet<NodeId>,
    notes: &BTreeSet<String>,
    bridge: bool,
) -> Result<(), Problem> {
    for &id in nodes {
        if bridge {
            graph.remove_bridged(id)?;
        } else {
            graph.remove(id)?;
        }
    }
    notes.iter().try_for_each(|name| graph.remove_note(name).map(drop))
}

/// Moves nodes and notes, and the bends of wires between moved nodes.
pub(crate) fn shift(
    graph: &mut Graph,
    nodes: &BTreeSet<NodeId>,
    notes: &BTreeSet<String>,
    by: [f64; 2],
) -> Result<(), Problem> {
    let moved = |at: [f64; 2]| [at[0] + by[0], at[1] + by[1]];
    for &id in nodes {
        graph.move_to(id, moved(graph.node(id).at))?;
        let inner = graph.inputs(id).filter(|(_, s)| nodes.contains(&s.node));
        let inner: Vec<Name> = inner.map(|(input, _)| input.clone()).collect();
        for input in inner {
            let bends = graph.bends(id, &input).iter().map(|at| moved(*at)).collect::<Vec<_>>();
            graph.set_bends(id, &input, bends)?;
        }
    }
    for name in notes {
        if let Some(note) = graph.note(name) {
            let note = Note { at: moved(note.at), ..note.clone() };
            graph.change_note(name, note)?;
        }
    }
    Ok(())
}

/// The exposed parameter that sets a parameter of a node.
pub(crate) fn exposed_as<'g>(graph: &'g Graph, id: NodeId, param: &str) -> Option<&'g str> {
    let bind = format!("{}.{param}", graph.get(id)?.name);
    graph.exposed().find(|(_, e)| e.bind.contains(&bind)).map(|(name, _)| name)
}

/// Sets a parameter of nodes, through the exposed parameter where it is bound to one.
pub(crate) fn set(graph: &mut Graph, ids: &[NodeId], param: &str, value: Json) -> Result<(), Problem> {
    let exposed = ids.first().and_then(|id| exposed_as(graph, *id, param)).map(str::to_owned);
    match exposed {
        Some(name) => graph.set_exposed(&name, value),
        None => ids.iter().try_for_each(|id| graph.set(*id, param, value.clone())),
    }
}

/// Bypasses nodes, or ends the bypass where all of them are bypassed.
pub(crate) fn toggle_bypass(graph: &mut Graph, nodes: &BTreeSet<NodeId>) -> Result<(), Problem> {
    let all = nodes.iter().all(|id| graph.get(*id).is_some_and(|n| n.bypass));
    nodes.iter().try_for_each(|id| graph.set_bypass(*id, !all))
}

/// The text that copying puts on the clipboard: a graph of the nodes and notes.
pub(crate) fn copied(graph: &Graph, nodes: &BTreeSet<NodeId>, notes: &BTreeSet<String>) -> Option<String> {
    if nodes.is_empty() && notes.is_empty() {
        return None;
    }
    let nodes: Vec<_> = nodes.iter().copied().collect();
    let notes: Vec<_> = notes.iter().cloned().collect();
    String::from_utf8(graph.fragment(&nodes, &notes).to_bytes()).ok()
}

/// Reads a text from the clipboard: a graph, or a part of one.
///
/// # Errors
/// Fails when the text is no graph.
pub(crate) fn readable(text: &str, registry: &Registry) -> Result<Graph, LoadError> {
    Graph::from_bytes(text.trim().as_bytes(), registry)
}

/// Adds the nodes and notes of `part`, moved so that their upper left corner is at `at`.
pub(crate) fn paste(graph: &mut Graph, part: &Graph, at: [f64; 2]) -> Result<Grafted, Problem> {
    let places = part.nodes().map(|id| part.node(id).at).chain(part.notes().map(|(_, n)| n.at));
    let corner = places.fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    let offset = [0, 1].map(|k| if corner[k].is_finite() { at[k] - corner[k] } else { 0.0 });
    graph.graft(part, offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph() -> (Graph, [NodeId; 3]) {
        let mut graph = Graph::new();
        let hills = graph.add("hills", "fractal_noise").expect("adds");
        let soft = graph.add("soft", "blur").expect("adds");
        let steps = graph.add("steps", "terrace").expect("adds");
        graph.connect(hills, "field", steps, "field").expect("fits");
        (graph, [hills, soft, steps])
    }

    #[test]
    fn inserts_and_removes_with_a_bridge() {
        let (mut graph, [hills, soft, steps]) = graph();
        let source = Source { node: hills, port: "field".into() };
        insert(&mut graph, soft, &source, steps, "field").expect("fits");
        assert_eq!(graph.source(soft, "field"), Some(source.clone()));
        assert_eq!(graph.source(steps, "field").map(|s| s.node), Some(soft));
        remove(&mut graph, &BTreeSet::from([soft]), &BTreeSet::new(), true).expect("removes");
        assert_eq!(graph.source(steps, "field"), Some(source));
    }

    #[test]
    fn adds_with_a_wire() {
        let (mut graph, [hills, _, steps]) = graph();
        let registry = graph.registry().clone();
        let kind = registry.find("clamp").expect("a kind");
        let end = End::From(Source { node: hills, port: "field".into() });
        let clamp = add(&mut graph, kind, [5.0, 6.0], Some(end)).expect("adds");
        assert_eq!(graph.source(clamp, "field").map(|s| s.node), Some(hills));
        let end = End::To(steps, "mask".into());
        let slope = registry.find("select_slope").expect("a kind");
        let slope = add(&mut graph, slope, [0.0; 2], Some(end)).expect("adds");
        assert_eq!(graph.source(steps, "mask").map(|s| s.node), Some(slope));
    }

    #[test]
    fn copies_keep_inner_wires_and_get_free_names() {
        let (mut graph, [hills, soft, steps]) = graph();
        graph.connect(steps, "field", soft, "field").expect("fits");
        let chosen = BTreeSet::from([steps, soft]);
        let text = copied(&graph, &chosen, &BTreeSet::new()).expect("a text");
        let part = readable(&text, graph.registry()).expect("a graph");
        let new = paste(&mut graph, &part, [100.0, 50.0]).expect("pastes");
        let [soft_2, steps_2] = new.nodes[..] else { panic!("two nodes") };
        assert_eq!(graph.node(soft_2).name, "soft_2");
        assert_eq!(graph.source(soft_2, "field").map(|s| s.node), Some(steps_2));
        assert_eq!(graph.source(steps_2, "field"), None, "the wire from outside stays outside");
        assert_eq!(graph.consumers(hills).count(), 1);
        assert_eq!(graph.node(soft_2).at, [100.0, 50.0]);
    }

    #[test]
    fn leaves_out_what_changes_a_field_and_nothing_else() {
        let (mut graph, [hills, _, steps]) = graph();
        toggle_bypass(&mut graph, &BTreeSet::from([steps])).expect("can be left out");
        let out = Source { node: steps, port: "field".into() };
        assert_eq!(graph.passed(out.clone()), Some(Source { node: hills, port: "field".into() }));
        assert!(toggle_bypass(&mut graph, &BTreeSet::from([hills])).is_err());
        toggle_bypass(&mut graph, &BTreeSet::from([steps])).expect("is taken in");
        assert_eq!(graph.passed(out.clone()), Some(out));
    }
}
