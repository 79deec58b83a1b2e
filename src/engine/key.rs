//! Keys: content hashes that name results (law 7).
//!
//! The key of a node depends on its kind and version, the digest of its parameters in canonical form, the keys of its
//! inputs, and those settings of terrain and seed that its kind declares to read. For each file of the node it depends
//! on the parameter, the last part of the file's name and the content, or on its absence. The key of a result adds the
//! lattice. Names, places on the canvas and comments are in neither.

use std::fmt;

use crate::name::Name;
use crate::node::{AnyNode, FileRequest, Kind, Reach, Reads};
use crate::source::last_name;
use crate::value::{Lattice, Terrain};

/// A content hash.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key([u8; 32]);

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// The hash of everything on which a result depends. Every part is written with its length, so that different parts
/// never give the same bytes.
struct Hasher(Vec<u8>);

impl Hasher {
    fn new(what: &str) -> Self {
        // A key has a few hundred bytes, which are hashed quickest at once.
        let mut hasher = Self(Vec::with_capacity(512));
        hasher.part(what.as_bytes());
        hasher
    }

    fn part(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        self.0.extend_from_slice(bytes);
    }

    fn number(&mut self, value: f64) {
        // −0 and 0 are equal and must give one key; adding 0 turns −0 into 0.
        self.0.extend_from_slice(&(value + 0.0).to_bits().to_le_bytes());
    }

    fn integer(&mut self, value: i64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn lattice(&mut self, lattice: &Lattice) {
        self.number(lattice.origin[0]);
        self.number(lattice.origin[1]);
        self.number(lattice.span);
        self.integer(i64::from(lattice.intervals));
    }

    fn finish(self) -> Key {
        Key(*blake3::hash(&self.0).as_bytes())
    }
}

/// The parts of the key of a node.
pub(super) struct Parts<'a> {
    pub kind: &'a Kind,
    pub node: &'a dyn AnyNode,
    /// The digest of the parameters, see [`Kind::digest`].
    pub parameters: &'a [u8; 32],
    pub terrain: &'a Terrain,
    /// For each input, the port, the key of the source node and the port of the source.
    pub inputs: &'a [(Name, Key, Name)],
    /// For each file, the request and the hash of the content; `None` where the file is absent.
    pub files: &'a [(FileRequest, Option<[u8; 32]>)],
}

impl Parts<'_> {
    /// The key of the node, which does not depend on the grid.
    pub(super) fn key(&self) -> Key {
        let Parts { kind, node, parameters, terrain, inputs, files } = self;
        let mut h = Hasher::new("node");
        h.part(kind.id.as_bytes());
        h.integer(i64::from(kind.version));
        h.part(*parameters);
        for (port, key, from) in *inputs {
            h.part(port.as_bytes());
            h.part(&key.0);
            h.part(from.as_bytes());
        }
        for (index, (request, content)) in files.iter().enumerate() {
            h.part(b"file");
            h.part(request.parameter.as_bytes());
            h.integer(index as i64);
            // The extension chooses the reader, and in some formats the name has the place of the file on Earth.
            h.part(last_name(&request.name).as_bytes());
            h.part(content.as_ref().map_or(&[][..], |hash| &hash[..]));
        }
        let (reads, reach) = (kind.reads, node.reach());
        if reads.has(Reads::SEED) {
            h.part(b"seed");
            h.integer(i64::from(terrain.seed));
        }
        if reads.has(Reads::TERRAIN) {
            h.part(b"terrain");
            let b = terrain.bounds();
            [b.min[0], b.min[1], b.max[0], b.max[1]].into_iter().for_each(|v| h.number(v));
            match terrain.sea_level {
                Some(level) => h.number(level),
                None => h.part(b"dry"),
            }
            if let Some(geo) = terrain.geo {
                h.integer(i64::from(geo.epsg));
                h.number(geo.east);
                h.number(geo.north);
            }
        }
        let base_fields = || kind.inputs.iter().any(|p| p.wire.is_raster());
        let whole = match reach {
            Reach::Global => true,
            Reach::Gridless => base_fields(),
            Reach::Point | Reach::Local(_) => node.needs_summary(),
        };
        if whole || reads.has(Reads::BASE) || reads.has(Reads::TERRAIN) {
            h.part(b"base");
            h.integer(i64::from(terrain.base));
        }
        // The apron, at which local windows end, and the base grid depend on the rectangle of the terrain.
        if whole || matches!(reach, Reach::Local(_)) || reads.has(Reads::BASE) {
            h.part(b"bounds");
            let b = terrain.bounds();
            [b.min[0], b.min[1], b.max[0], b.max[1]].into_iter().for_each(|v| h.number(v));
        }
        h.finish()
    }
}

impl Key {
    /// The key of the results of a stage on any window of a lattice; a result on a window contains those on its parts.
    pub(super) fn on(&self, stage: &str, lattice: &Lattice) -> Self {
        let mut h = Hasher::new(stage);
        h.part(&self.0);
        h.lattice(lattice);
        h.finish()
    }
}
