//! Writing: the canonical form, which can be compared and merged line by line, and the atomic save.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde_json::{Map, Value as Json};

use super::parts::{NodeKeys, Part};
use super::{FORMAT, Graph, KindRef, NodeId, settings};
use crate::text::inline;
use crate::whole::{self, Known};

/// The longest line for an object or a list of lists; lists of numbers are never broken.
const COLUMNS: usize = 110;
/// The top-level objects that have one line for each entry, however short they are.
const OPEN: [&str; 4] = ["expose", "nodes", "outputs", "notes"];

impl Graph {
    /// The content of the file: the bytes that were read where nothing has changed since, else the canonical form.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.original.as_ref().map_or_else(|| self.canonical(), |bytes| bytes.to_vec())
    }

    /// The canonical form: fixed order of keys, only parameters that differ from their defaults, short objects and
    /// lists of numbers on one line.
    pub fn canonical(&self) -> Vec<u8> {
        let mut out = String::from("{");
        for (i, (key, value)) in self.document().iter().enumerate() {
            out.push_str(if i == 0 { "\n  " } else { ",\n  " });
            let start = out.len();
            out.push_str(&text(key));
            out.push_str(": ");
            let column = 2 + out.len() - start;
            let open = OPEN.contains(&key.as_str());
            put(&mut out, value, 2, column, open);
        }
        out.push_str("\n}\n");
        out.into_bytes()
    }

    /// Writes the file whole or not at all, and replaces an existing one.
    ///
    /// # Errors
    /// Returns the errors of the file system; an existing file is then unchanged.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        whole::save(path, &self.to_bytes(), Known::Anything)
    }

    fn document(&self) -> Map<String, Json> {
        let mut file = Map::new();
        file.insert("orograph".into(), FORMAT.into());
        file.insert("kinds".into(), self.kind_versions());
        file.append(&mut self.about.give(&Map::new()));
        file.insert("terrain".into(), Json::Object(settings::written(&self.settings)));
        let exposed = self.exposed().map(|(name, e)| (name.to_owned(), Json::Object(e.give(&e.extra))));
        let exposed: Map<String, Json> = exposed.collect();
        if !exposed.is_empty() {
            file.insert("expose".into(), Json::Object(exposed));
        }
        let nodes = self.nodes().map(|id| (self.node(id).name.clone(), self.written_node(id)));
        file.insert("nodes".into(), Json::Object(nodes.collect()));
        let outputs = self.outputs().map(|(name, o)| (name.to_owned(), Json::Object(o.give(&o.extra))));
        file.insert("outputs".into(), Json::Object(outputs.collect()));
        let notes = self.notes().map(|(name, n)| (name.to_owned(), Json::Object(n.give(&n.extra))));
        let notes: Map<String, Json> = notes.collect();
        if !notes.is_empty() {
            file.insert("notes".into(), Json::Object(notes));
        }
        file.extend(self.extra.iter().map(|(k, v)| (k.clone(), v.clone())));
        file
    }

    fn kind_versions(&self) -> Json {
        let mut versions = BTreeMap::new();
        for id in self.nodes() {
            match &self.node(id).kind {
                KindRef::Known(kind) => _ = versions.insert(kind.id.as_str(), Json::from(kind.version)),
                KindRef::Unknown(kind) => {
                    if let Some(written) = self.versions.get(kind) {
                        versions.insert(kind, written.clone());
                    }
                }
            }
        }
        Json::Object(versions.into_iter().map(|(k, v)| (k.to_owned(), v)).collect())
    }

    fn written_node(&self, id: NodeId) -> Json {
        let node = self.node(id);
        let keys =
            NodeKeys { at: node.at, backend: node.backend, bypass: node.bypass, bends: node.bends.clone() };
        let keys = keys.give(&Map::new());
        let mut map = Map::new();
        map.insert("kind".into(), node.kind.id().into());
        map.extend(keys.get("at").map(|at| ("at".to_owned(), at.clone())));
        let inputs = self.written_inputs(id);
        if !inputs.is_empty() {
            map.insert("in".into(), Json::Object(inputs));
        }
        let set = node.changed();
        if !set.is_empty() {
            map.insert("set".into(), Json::Object(set));
        }
        map.extend(keys);
        map.extend(node.extra.iter().map(|(k, v)| (k.clone(), v.clone())));
        Json::Object(map)
    }

    /// The inputs in the order of the kind, then those that the kind does not have, as they were written.
    fn written_inputs(&self, id: NodeId) -> Map<String, Json> {
        let node = self.node(id);
        let mut map = Map::new();
        for port in node.kind().into_iter().flat_map(|k| k.inputs.iter()) {
            let wire = self.source(id, &port.name).map(|s| Json::from(self.source_text(&s)));
            if let Some(value) = wire.or_else(|| node.loose.get(port.name.as_str()).cloned()) {
                map.insert(port.name.to_string(), value);
            }
        }
        map.extend(node.loose.iter().map(|(k, v)| (k.clone(), v.clone())));
        map
    }
}

/// Writes a value that starts at a column. An open object has one line for each entry, however short it is.
fn put(out: &mut String, value: &Json, indent: usize, column: usize, open: bool) {
    let is_list_of_numbers = |v: &Json| v.as_array().is_some_and(|a| a.iter().all(Json::is_number));
    let is_empty = value.as_object().is_some_and(Map::is_empty);
    // One column is for the comma.
    let room = if is_list_of_numbers(value) { usize::MAX } else { COLUMNS.saturating_sub(column + 1) };
    let start = out.len();
    if (!open || is_empty) && inline(out, value, start.saturating_add(room)) {
        return;
    }
    out.truncate(start);
    let line = |out: &mut String, i: usize| {
        out.push_str(if i == 0 { "\n" } else { ",\n" });
        out.extend(std::iter::repeat_n(' ', indent + 2));
    };
    match value {
        Json::Object(map) => {
            out.push('{');
            for (i, (key, value)) in map.iter().enumerate() {
                line(out, i);
                let key = text(key);
                out.push_str(&key);
                out.push_str(": ");
                put(out, value, indent + 2, indent + 4 + key.len(), false);
            }
        }
        Json::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                line(out, i);
                put(out, item, indent + 2, indent + 2, false);
            }
        }
        // Numbers, strings and literals are never broken.
        _ => {
            inline(out, value, usize::MAX);
            return;
        }
    }
    out.push('\n');
    out.extend(std::iter::repeat_n(' ', indent));
    out.push(if value.is_object() { '}' } else { ']' });
}

fn text(text: &str) -> String {
    Json::from(text).to_string()
}
