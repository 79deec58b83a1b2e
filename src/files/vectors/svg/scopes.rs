//! Namespaces of XML: which prefixes stand for elements of a picture.

use std::collections::BTreeMap;

const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// What the elements of a namespace are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    /// Of a picture, or of no namespace at all.
    Picture,
    /// Of something else.
    Other,
}

/// The namespaces of prefixes.
#[derive(Debug, Default)]
pub(super) struct Scopes<'t> {
    spaces: BTreeMap<&'t str, Vec<Space>>,
    /// Depth and prefix of what was declared, to be undone.
    declared: Vec<(usize, &'t str)>,
}

impl<'t> Scopes<'t> {
    pub(super) fn declare(&mut self, depth: usize, prefix: &'t str, value: &str) {
        let space = if value == NAMESPACE || value.is_empty() { Space::Picture } else { Space::Other };
        self.spaces.entry(prefix).or_default().push(space);
        self.declared.push((depth, prefix));
    }

    pub(super) fn leave(&mut self, depth: usize) {
        while let Some((_, prefix)) = self.declared.pop_if(|(d, _)| *d == depth) {
            if let Some(spaces) = self.spaces.get_mut(prefix) {
                spaces.pop();
            }
        }
    }

    /// That of a prefix; one that is declared nowhere tells by its name.
    pub(super) fn of(&self, prefix: &str) -> Space {
        let declared = self.spaces.get(prefix).and_then(|spaces| spaces.last().copied());
        let undeclared = if prefix.is_empty() || prefix == "svg" { Space::Picture } else { Space::Other };
        declared.unwrap_or(undeclared)
    }
}
