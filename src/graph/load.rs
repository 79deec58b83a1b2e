//! Reading a file. A file that is no graph at all is an error; faults inside a graph are kept and reported as problems.

use std::io::Read as _;
use std::path::Path;

use std::sync::Arc;

use serde_json::{Map, Value as Json};

use super::canvas::Note;
use super::migrate::{self, FORMAT_STEPS, FormatStep};
use super::parts::{About, Exposed, GraphNode, KindRef, NodeKeys, Output, Part};
use super::problem::{Hints, Place, Problem};
use super::{Graph, json};
use crate::node::{Kind, Migration};
use crate::nodes::Registry;
use crate::text::brief;

/// The most bytes of a file.
pub const MAX_FILE: u64 = 16 << 20;
/// The most nodes in a graph.
pub const MAX_NODES: usize = 20_000;
/// The most outputs, and the most exposed parameters, in a graph.
pub const MAX_NAMED: usize = 1000;

/// Why a file cannot be opened as a graph. The caller adds which file it was.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file system refuses.
    #[error("the file cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// It is a folder, a pipe or a device.
    #[error("this is not a regular file")]
    NotAFile,
    /// It is too large.
    #[error("the file has {size} bytes, the limit is {limit}")]
    TooLarge {
        /// Its size.
        size: u64,
        /// The largest size.
        limit: u64,
    },
    /// Its bytes are not a text.
    #[error("the file is not UTF-8 text: byte {offset}, in line {line}")]
    NotUtf8 {
        /// The first byte that is wrong, from 0.
        offset: usize,
        /// Its line, from 1.
        line: usize,
    },
    /// There is nothing in it.
    #[error("the file is empty")]
    Empty,
    /// It ends too soon.
    #[error("the file ends in the middle, at line {line} column {column}: was it cut off?")]
    Truncated {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// It is not JSON, has a key twice, or is past a limit.
    #[error("the file cannot be parsed: {message}, line {line} column {column}")]
    Syntax {
        /// What is wrong.
        message: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// It is JSON, but no graph.
    #[error("this is not a graph: it has no key `orograph` with the version of its format")]
    NotAGraph,
    /// Its version makes no sense.
    #[error("`orograph`, the version of the format, must be a whole number from 1 to {current}, got {found}")]
    BadVersion {
        /// What it says.
        found: String,
        /// The newest format that can be read.
        current: u64,
    },
    /// It was written by a later version.
    #[error(
        "the file was written by a newer version of Orograph: it has format {found}, this version reads up to {current}"
    )]
    NewerVersion {
        /// Its format.
        found: u64,
        /// The newest format that can be read.
        current: u64,
    },
    /// A part of it is not what it should be.
    #[error("`{path}` {message}")]
    Structure {
        /// Which part.
        path: String,
        /// What is wrong with it.
        message: String,
    },
    /// It has too many of something.
    #[error("the file has {found} {what}, the limit is {limit}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        found: usize,
        /// The most there may be.
        limit: usize,
    },
}

impl Graph {
    /// Opens a file. Its size and type are checked before it is read.
    ///
    /// # Errors
    /// Fails when the file cannot be read or is no graph.
    pub fn open(path: &Path, registry: &Registry) -> Result<Self, LoadError> {
        let limited =
            |size| if size > MAX_FILE { Err(LoadError::TooLarge { size, limit: MAX_FILE }) } else { Ok(()) };
        // The type is checked before the file is opened, because opening a pipe blocks until there is a writer.
        let meta = std::fs::metadata(path)?;
        if !meta.is_file() {
            return Err(LoadError::NotAFile);
        }
        limited(meta.len())?;
        let mut bytes = Vec::with_capacity(meta.len() as usize);
        std::fs::File::open(path)?.take(MAX_FILE + 1).read_to_end(&mut bytes)?;
        Self::from_bytes(&bytes, registry)
    }

    /// Reads the content of a file.
    ///
    /// # Errors
    /// Fails when it is not JSON, is of a newer format, or lacks the structure of a graph. Other faults are kept and
    /// reported by [`problems`](Self::problems).
    pub fn from_bytes(bytes: &[u8], registry: &Registry) -> Result<Self, LoadError> {
        Self::read(bytes, registry, FORMAT_STEPS)
    }

    pub(super) fn read(bytes: &[u8], registry: &Registry, steps: &[FormatStep]) -> Result<Self, LoadError> {
        if bytes.len() as u64 > MAX_FILE {
            return Err(LoadError::TooLarge { size: bytes.len() as u64, limit: MAX_FILE });
        }
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let offset = e.valid_up_to();
            LoadError::NotUtf8 { offset, line: 1 + bytes[..offset].iter().filter(|b| **b == b'\n').count() }
        })?;
        // Some editors write a byte order mark before UTF-8.
        let parsed = json::read(text.strip_prefix('\u{feff}').unwrap_or(text))?;
        let mut file = object(parsed, "the file")?;
        migrate::upgrade(&mut file, steps)?;
        let mut graph = Self::with_registry(registry.clone());
        graph.fill(file)?;
        graph.original = Some(bytes.into());
        Ok(graph)
    }

    fn fill(&mut self, mut file: Map<String, Json>) -> Result<(), LoadError> {
        file.shift_remove("orograph");
        self.about = About::take(&mut file);
        self.versions = part(&mut file, "kinds")?;
        self.settings = part(&mut file, "terrain")?;
        let exposed = named(part(&mut file, "expose")?, "expose", "exposed parameters", MAX_NAMED)?;
        let nodes = named(part(&mut file, "nodes")?, "nodes", "nodes", MAX_NODES)?;
        let outputs = named(part(&mut file, "outputs")?, "outputs", "outputs", MAX_NAMED)?;
        let notes = named(part(&mut file, "notes")?, "notes", "notes", MAX_NAMED)?;
        self.extra = file;
        for (name, written) in nodes {
            let node = self.node_of(name, written)?;
            self.put_node(node);
        }
        for (name, mut written) in outputs {
            let mut output = Output::take(&mut written);
            output.extra = written;
            self.outputs.push((name, output));
        }
        for (name, mut written) in notes {
            let mut note = Note::take(&mut written);
            note.extra = written;
            self.notes.push((name, note));
        }
        let mut says_null = Vec::new();
        for (name, mut written) in exposed {
            says_null.push(written.contains_key("value"));
            let mut exposed = Exposed::take(&mut written);
            exposed.extra = written;
            self.exposed.push((name, exposed));
        }
        self.migrate_kinds();
        self.link();
        self.apply_exposed(&says_null);
        self.look_at_settings();
        Ok(())
    }

    fn node_of(&self, name: String, mut written: Map<String, Json>) -> Result<GraphNode, LoadError> {
        let bad = |message: String| LoadError::Structure { path: format!("nodes.{name}.kind"), message };
        let kind = match written.shift_remove("kind") {
            Some(Json::String(kind)) => kind,
            Some(other) => return Err(bad(format!("must be the name of a kind, got {}", brief(&other)))),
            None => return Err(bad("is missing".to_owned())),
        };
        let known = self.registry.find(&kind).filter(|k| self.version_of(k).is_ok()).cloned();
        let mut object = |key: &str| match written.get(key) {
            Some(Json::Object(_)) => match written.shift_remove(key) {
                Some(Json::Object(map)) => map,
                _ => Map::new(),
            },
            _ => Map::new(),
        };
        let (loose, set) = (object("in"), object("set").into());
        let NodeKeys { at, backend, bypass, bends } = NodeKeys::take(&mut written);
        let kind = known.map_or(KindRef::Unknown(kind), KindRef::Known);
        Ok(GraphNode { name, kind, set, at, backend, bypass, bends, extra: written, loose })
    }

    /// The version of a kind in the file.
    ///
    /// # Errors
    /// Returns a message when the version is invalid, or newer than that of this program.
    pub(super) fn version_of(&self, kind: &Kind) -> Result<u32, String> {
        let current = kind.version;
        let Some(written) = self.versions.get(kind.id.as_str()) else { return Ok(current) };
        match written.as_u64() {
            Some(v) if (1..=u64::from(current)).contains(&v) => Ok(v as u32),
            Some(v) if v > u64::from(current) => Err(format!(
                "is of kind `{}` in version {v}, this version of Orograph has version {current}; it is kept as it is",
                kind.id
            )),
            _ => Err(format!(
                "is of kind `{}`, whose version under `kinds` must be a whole number from 1 to {current}, got {}",
                kind.id,
                brief(written)
            )),
        }
    }

    /// Migrates parameters, and the exposed parameters that bind them, to the versions of this program.
    fn migrate_kinds(&mut self) {
        let mut kinds: Vec<Arc<Kind>> = self.nodes().filter_map(|id| self.node(id).kind().cloned()).collect();
        kinds.sort_unstable_by(|a, b| a.id.cmp(&b.id));
        kinds.dedup_by(|a, b| a.id == b.id);
        let mut old: Vec<(&str, &[Migration])> = Vec::new();
        for kind in &kinds {
            let version = self.version_of(kind).unwrap_or(kind.version);
            if self.versions.shift_remove(kind.id.as_str()).is_none() && version > 1 {
                let message = format!(
                    "the file does not say under `kinds` which version of `{}` it means; it is read as version {version}",
                    kind.id
                );
                self.load_warnings.push(Problem::warning(Place::Graph, message));
            }
            let steps = kind.migrations.get(version as usize - 1..).unwrap_or_default();
            if !steps.is_empty() {
                old.push((kind.id.as_str(), steps));
            }
        }
        if old.is_empty() {
            return;
        }
        let steps = |kind: &KindRef| old.iter().find(|(id, _)| *id == kind.id()).map(|(_, steps)| *steps);
        let mut exposed = std::mem::take(&mut self.exposed);
        for (_, exposed) in &mut exposed {
            self.migrate_exposed(exposed, steps);
        }
        self.exposed = exposed;
        for id in self.sequence.clone() {
            let node = &mut self.dag[id];
            if let Some(steps) = node.kind().and_then(|_| steps(&node.kind)) {
                node.set.edit(|set| {
                    migrate::parameters(set, steps);
                    set.values_mut().for_each(json::tidy);
                });
            }
        }
    }

    fn migrate_exposed<'s>(
        &self,
        exposed: &mut Exposed,
        steps: impl Fn(&KindRef) -> Option<&'s [Migration]>,
    ) {
        let before = exposed.clone();
        for bind in &mut exposed.bind {
            let mut parts = bind.split('.');
            let Some(id) = parts.next().and_then(|name| self.find(name)) else { continue };
            let node = self.node(id);
            let Some(steps) = node.kind().and_then(|_| steps(&node.kind)) else { continue };
            let path: Vec<String> = parts.map(str::to_owned).collect();
            let follow = |value: &Json| migrate::follow(&node.set, steps, &path, value);
            // Without a value of its own, the node's tells where the parameter went, or any number does.
            let own = path.first().and_then(|p| node.set.get(p)).filter(|_| path.len() == 1);
            let probes = [Some(&before.value), own, Some(&Json::from(1))];
            let Some((new, value)) = probes.into_iter().flatten().find_map(follow) else { continue };
            *bind = std::iter::once(node.name.clone()).chain(new).collect::<Vec<_>>().join(".");
            if !before.value.is_null() {
                exposed.value = value;
                json::tidy(&mut exposed.value);
            }
            let number =
                |limit: f64| follow(&Json::from(limit)).and_then(|(_, v)| v.as_f64()).unwrap_or(limit);
            (exposed.min, exposed.max) = (before.min.map(number), before.max.map(number));
        }
    }

    /// Writes the values of exposed parameters to their binds. A null takes over the value of the first bind instead,
    /// except where `says_null` says that the file means null.
    pub(super) fn apply_exposed(&mut self, says_null: &[bool]) {
        let hints = Hints::none();
        let owners = self.owners();
        for i in 0..self.exposed.len() {
            let (name, exposed) = &self.exposed[i];
            let Ok(bound) = self.bound(i, name, exposed, &owners, &hints) else { continue };
            let says_null =
                || says_null.get(i) == Some(&true) && bound.param.shape.check(&Json::Null).is_ok();
            if exposed.value.is_null() && !says_null() {
                self.exposed[i].1.value = bound.param.default.clone();
            }
            let (name, value) = (self.exposed[i].0.clone(), self.exposed[i].1.value.clone());
            if bound.param.shape.check(&value).is_err() {
                continue;
            }
            for bind in &bound.binds {
                if let Some(written) = self.written_at(bind).filter(|w| !w.equals(&value, json::same)) {
                    let (written, used) = (brief(&written.json()), brief(&value));
                    let message =
                        format!("is written as {written}, but exposed as `{name}` with {used}, which counts");
                    let note = Problem::warning(self.place_of(bind), message);
                    self.load_warnings.push(note);
                }
                self.put_at(bind, value.clone());
            }
        }
    }
}

fn object(json: Json, path: &str) -> Result<Map<String, Json>, LoadError> {
    match json {
        Json::Object(map) => Ok(map),
        other => {
            let message = format!("must be an object, got {}", brief(&other));
            Err(LoadError::Structure { path: path.to_owned(), message })
        }
    }
}

/// A part of the file; empty where the file does not have it.
fn part(file: &mut Map<String, Json>, key: &str) -> Result<Map<String, Json>, LoadError> {
    file.shift_remove(key).map_or_else(|| Ok(Map::new()), |json| object(json, key))
}

type Entries = Vec<(String, Map<String, Json>)>;

/// The entries of a part, each of which is an object.
fn named(
    part: Map<String, Json>,
    path: &str,
    what: &'static str,
    limit: usize,
) -> Result<Entries, LoadError> {
    if part.len() > limit {
        return Err(LoadError::TooMany { what, found: part.len(), limit });
    }
    let entry = |(name, json)| object(json, &format!("{path}.{name}")).map(|map| (name, map));
    part.into_iter().map(entry).collect()
}
