//! Graphs made by chance: any bytes become a graph of shipped kinds, wired and set as the kinds allow.
//!
//! The tests and the fuzz target `evaluate` share this file.

use orograph::graph::{Graph, NodeId};
use orograph::node::Kind;
use orograph::nodes::Registry;
use orograph::params::{Choice, Param, Shape};
use orograph::widget::Widget;
use serde_json::{Map, Value as Json, json};

/// Most nodes of a graph.
const MOST_NODES: usize = 12;
/// Kinds that need no input.
const SOURCES: [&str; 4] = ["fractal_noise", "feature_curves", "paint_mask", "cellular_noise"];
/// Most items of a list.
const MOST_ITEMS: usize = 6;

/// Choices read from bytes; when they are used up, always the first.
pub(super) struct Chance<'a> {
    bytes: &'a [u8],
}

impl<'a> Chance<'a> {
    /// Choices that some bytes make.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    fn byte(&mut self) -> u8 {
        self.bytes.split_off_first().copied().unwrap_or(0)
    }

    /// A number below another.
    pub(super) fn below(&mut self, count: usize) -> usize {
        let wide = u16::from_le_bytes([self.byte(), if count > 256 { self.byte() } else { 0 }]);
        usize::from(wide) % count.max(1)
    }

    fn one<'b, T>(&mut self, of: &'b [T]) -> Option<&'b T> {
        of.get(self.below(of.len()))
    }

    /// A number from 0 to 1, both among them.
    fn share(&mut self) -> f64 {
        f64::from(u16::from_le_bytes([self.byte(), self.byte()])) / f64::from(u16::MAX)
    }

    /// A graph whose last nodes are the likely ones to be asked for.
    pub(super) fn graph(&mut self) -> Graph {
        let mut graph = Graph::new();
        let sides = [[1000.0, 1000.0], [4096.0, 2048.0], [10.0, 300.0], [2e5, 1e5]];
        let [width, depth] = sides[self.below(sides.len())];
        let base = [33, 17, 20, 65][self.below(4)];
        for (name, value) in [("width", json!(width)), ("depth", json!(depth)), ("base", json!(base))] {
            // A side that is no whole number of cells is refused: the graph is then as it was.
            let _ = graph.set_terrain(name, value);
        }
        // There is no file that a graph by chance may name.
        let reads = |kind: &Kind| kind.params().iter().any(|p| p.widget == Some(Widget::File));
        let kinds: Vec<_> = Registry::standard().iter().filter(|k| !reads(k)).cloned().collect();
        for i in 0..=self.below(MOST_NODES) {
            let Some(kind) = self.one(&kinds) else { break };
            let Ok(node) = graph.add(&format!("n{i}"), &kind.id) else { break };
            self.set(&mut graph, node);
            if !self.wire(&mut graph, node) {
                // Nothing fits yet: a kind that needs nothing takes its place.
                let _ = graph.remove(node);
                let _ = graph.add(&format!("n{i}"), SOURCES[self.below(SOURCES.len())]);
            }
        }
        graph
    }

    fn set(&mut self, graph: &mut Graph, node: NodeId) {
        let params: Vec<Param> = graph.node(node).kind().map(|k| k.params().to_vec()).unwrap_or_default();
        for param in params {
            if self.below(3) == 1 {
                let value = self.value(&param.shape, &param.default, 0);
                let _ = graph.set(node, &param.name, value);
            }
        }
    }

    /// Connects all inputs that must be and most others to an output of an earlier node that fits; whether all that
    /// must be are.
    fn wire(&mut self, graph: &mut Graph, node: NodeId) -> bool {
        let Some(kind) = graph.node(node).kind().cloned() else { return false };
        let mut whole = true;
        let earlier: Vec<NodeId> = graph.nodes().filter(|&n| n != node).collect();
        for input in kind.inputs.iter() {
            let fits = |&from: &NodeId| {
                let outputs = graph.node(from).kind().map(|k| k.outputs.clone()).unwrap_or_default();
                outputs.into_iter().map(move |o| (from, o.name)).collect::<Vec<_>>()
            };
            let mut fitting: Vec<_> = earlier.iter().flat_map(fits).collect();
            fitting.retain(|(from, output)| graph.can_connect(*from, output, node, &input.name).is_ok());
            if !input.required && self.below(4) == 3 {
                continue;
            }
            match self.one(&fitting) {
                Some((from, output)) => whole &= graph.connect(*from, output, node, &input.name).is_ok(),
                None => whole &= !input.required,
            }
        }
        whole
    }

    /// A value that a parameter may have: an end of its range, somewhere in it, near its default, the default.
    fn value(&mut self, shape: &Shape, default: &Json, depth: usize) -> Json {
        match shape {
            Shape::Number { min, max, integer } => self.number([*min, *max], *integer, default),
            Shape::Flag => json!(self.below(2) == 1),
            Shape::Optional(inner) if self.below(4) > 0 => self.value(inner, default, depth),
            Shape::Optional(_) => Json::Null,
            Shape::Choice(modes) => self.one(modes).cloned().map_or(Json::Null, |m| self.mode(&m, depth)),
            Shape::List { item, min, max } => {
                let count = (min + self.below(MOST_ITEMS)).min(*max);
                // A list in a list in a list is long enough.
                let count = if depth > 3 { *min } else { count };
                (0..count).map(|_| self.value(item, &Json::Null, depth + 1)).collect()
            }
            Shape::Tuple(items) => items.iter().map(|s| self.value(s, &Json::Null, depth + 1)).collect(),
            Shape::Record(fields) => Json::Object(self.fields(fields, depth)),
            Shape::Text { .. } | Shape::Unknown => default.clone(),
        }
    }

    fn number(&mut self, [min, max]: [f64; 2], integer: bool, default: &Json) -> Json {
        let usual = default.as_f64().unwrap_or((0.0_f64).clamp(min, max));
        let number = match self.below(6) {
            0 => usual,
            1 => min,
            2 => max,
            3 => min + (max - min) * self.share(),
            4 => (usual * (4.0 * self.share())).clamp(min, max),
            _ => (1000.0 * self.share()).clamp(min, max),
        };
        if integer { json!(number as i64) } else { json!(number) }
    }

    fn mode(&mut self, mode: &Choice, depth: usize) -> Json {
        if mode.fields.is_empty() {
            return json!(mode.name);
        }
        json!({ mode.name.clone(): self.fields(&mode.fields, depth) })
    }

    fn fields(&mut self, fields: &[Param], depth: usize) -> Map<String, Json> {
        let mut all = Map::new();
        for field in fields {
            if field.required || self.below(3) == 1 {
                all.insert(field.name.clone(), self.value(&field.shape, &field.default, depth + 1));
            }
        }
        all
    }
}
