//! Sets of outputs of a kind, such as those that are read.

use crate::node::Kind;
use crate::ports::Port;

/// A set of outputs of one kind, with one bit for each in the order of declaration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Outputs(u64);

impl Outputs {
    /// The set of the output of this name; empty where the kind has no such output.
    pub(super) fn one(kind: &Kind, name: &str) -> Self {
        Self(kind.outputs.iter().position(|p| p.name == name).map_or(0, bit))
    }

    /// The set of all outputs.
    pub(super) fn all(kind: &Kind) -> Self {
        Self((0..kind.outputs.len()).map(bit).fold(0, |all, one| all | one))
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the set contains all of `other`.
    pub(super) fn covers(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    pub(super) fn has(self, kind: &Kind, name: &str) -> bool {
        let one = Self::one(kind, name);
        one.0 != 0 && self.covers(one)
    }

    /// The ports in the set, in the order of declaration.
    pub(super) fn ports(self, kind: &Kind) -> impl Iterator<Item = &Port> {
        kind.outputs.iter().enumerate().filter(move |(i, _)| self.0 & bit(*i) != 0).map(|(_, p)| p)
    }
}

/// Kinds have few outputs; from the 64th on they share a bit and are read together.
fn bit(i: usize) -> u64 {
    1 << i.min(63)
}
