//! The parameters that a node of a graph sets, parsed once for as long as they stay the same.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use serde::de::DeserializeOwned;
use serde_json::{Map, Value as Json};

use crate::node::{self, AnyNode, Kind};
use crate::params::packed::{Packed, Record, View};

/// The parameters that a node sets, by name. They are read like a map of JSON. The parsed form is shared by all copies and
/// dropped when a copy is changed.
///
/// They are kept with lists of numbers packed, so that drawings of many thousand numbers take little memory, and a change
/// of one number copies only the list that it stands in. The map is made when somebody reads it.
#[derive(Clone, Debug, Default)]
pub struct Settings(Arc<Kept>);

#[derive(Clone, Debug, Default)]
struct Kept {
    record: Record,
    written: OnceLock<Map<String, Json>>,
    parsed: OnceLock<Parsed>,
}

/// The parsed form of the parameters, for one kind.
#[derive(Clone, Debug)]
struct Parsed {
    kind: Arc<Kind>,
    node: node::Result<Arc<dyn AnyNode>>,
    digest: OnceLock<[u8; 32]>,
}

impl Parsed {
    fn of(kind: &Arc<Kind>, record: &Record) -> Self {
        Self { kind: kind.clone(), node: kind.parse_packed(record), digest: OnceLock::new() }
    }
}

impl Settings {
    /// The node of a kind with these parameters.
    ///
    /// # Errors
    /// Returns the errors of [`Kind::parse`].
    pub(super) fn parse(&self, kind: &Arc<Kind>) -> node::Result<Arc<dyn AnyNode>> {
        self.with(kind, |parsed| parsed.node.clone())
    }

    /// The [digest](Kind::digest) of the node of a kind with these parameters.
    ///
    /// # Errors
    /// Returns the errors of [`Kind::parse`].
    pub(super) fn digest(&self, kind: &Arc<Kind>) -> node::Result<[u8; 32]> {
        self.with(kind, |parsed| {
            let node = parsed.node.as_ref().map_err(Clone::clone)?;
            Ok(*parsed.digest.get_or_init(|| kind.digest(&**node)))
        })
    }

    fn with<T>(&self, kind: &Arc<Kind>, take: impl FnOnce(&Parsed) -> T) -> T {
        let parsed = self.0.parsed.get_or_init(|| Parsed::of(kind, &self.0.record));
        if Arc::ptr_eq(&parsed.kind, kind) {
            take(parsed)
        } else {
            // Another kind asked first; a node has one kind, so that this is never so for long.
            take(&Parsed::of(kind, &self.0.record))
        }
    }

    /// The value of a parameter, if it is set.
    pub fn value(&self, name: &str) -> Option<Json> {
        self.view(name).map(View::json)
    }

    /// A parameter in a type of its own, if it is set. Lists of numbers are read without JSON in between.
    ///
    /// # Errors
    /// Fails when the value does not fit the type.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Option<Result<T, serde_json::Error>> {
        self.0.record.get(name).map(T::deserialize)
    }

    /// Estimated bytes that the parameters take; copies share them.
    pub fn bytes(&self) -> usize {
        self.0.record.bytes()
    }

    /// The parameters with their lists of numbers packed.
    pub(crate) fn record(&self) -> &Record {
        &self.0.record
    }

    /// A parameter that is set, looked at where it stands.
    pub(crate) fn view(&self, name: &str) -> Option<View<'_>> {
        self.0.record.get(name).map(View::from)
    }

    /// A parameter, to be changed. One that is not set is set to a default first.
    pub(super) fn entry(&mut self, name: &str, default: impl FnOnce() -> Json) -> &mut Packed {
        self.change().entry(name, || Packed::from(default()))
    }

    /// Removes a parameter.
    pub(super) fn remove(&mut self, name: &str) {
        self.change().remove(name);
    }

    /// Changes the parameters as a map.
    pub(super) fn edit(&mut self, change: impl FnOnce(&mut Map<String, Json>)) {
        let mut written = self.0.record.json();
        change(&mut written);
        *self = written.into();
    }

    /// The parameters, to be changed: what was made of them is dropped.
    fn change(&mut self) -> &mut Record {
        self.0 = Arc::new(Kept { record: self.0.record.clone(), ..Kept::default() });
        &mut Arc::make_mut(&mut self.0).record
    }
}

impl From<Map<String, Json>> for Settings {
    fn from(written: Map<String, Json>) -> Self {
        Self(Arc::new(Kept { record: written.into(), ..Kept::default() }))
    }
}

impl Deref for Settings {
    type Target = Map<String, Json>;

    fn deref(&self) -> &Self::Target {
        self.0.written.get_or_init(|| self.0.record.json())
    }
}
