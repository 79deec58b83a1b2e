//! The parameters that a node of a graph sets, parsed once for as long as they stay the same.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

use serde_json::{Map, Value as Json};

use crate::node::{self, AnyNode, Kind};

/// The parameters that a node sets, by name. They are read and changed like a map. The parsed form is shared by all
/// copies and dropped when a copy is changed.
#[derive(Clone, Debug, Default)]
pub struct Settings(Arc<Kept>);

#[derive(Clone, Debug, Default)]
struct Kept {
    written: Map<String, Json>,
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
    fn of(kind: &Arc<Kind>, written: &Map<String, Json>) -> Self {
        Self { kind: kind.clone(), node: kind.parse(written), digest: OnceLock::new() }
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
        let parsed = self.0.parsed.get_or_init(|| Parsed::of(kind, &self.0.written));
        if Arc::ptr_eq(&parsed.kind, kind) {
            take(parsed)
        } else {
            // Another kind asked first; a node has one kind, so that this is never so for long.
            take(&Parsed::of(kind, &self.0.written))
        }
    }
}

impl From<Map<String, Json>> for Settings {
    fn from(written: Map<String, Json>) -> Self {
        Self(Arc::new(Kept { written, parsed: OnceLock::new() }))
    }
}

impl Deref for Settings {
    type Target = Map<String, Json>;

    fn deref(&self) -> &Self::Target {
        &self.0.written
    }
}

impl DerefMut for Settings {
    fn deref_mut(&mut self) -> &mut Self::Target {
        let kept = Arc::make_mut(&mut self.0);
        kept.parsed = OnceLock::new();
        &mut kept.written
    }
}
