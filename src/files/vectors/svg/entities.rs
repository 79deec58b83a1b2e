//! Entities of a DOCTYPE: short names for pieces of text, which drawing programs use for their namespaces.
//!
//! Nothing outside the file is ever read, and what entities unfold to is bounded, however they are nested.

use std::borrow::Cow;
use std::collections::BTreeMap;

use quick_xml::escape::{resolve_xml_entity, unescape_with};

/// Most bytes that all entities together unfold to, and all references to them in a file.
const MAX_UNFOLDED: usize = 4 << 20;

/// Entities by name.
#[derive(Debug, Default)]
pub(super) struct Entities {
    values: BTreeMap<String, String>,
    /// Bytes that references may still unfold to.
    left: usize,
}

/// What unfolding references came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unfolded {
    /// A reference has no meaning in this file: it stands for nothing.
    pub(super) unknown: bool,
}

/// What a reference between elements stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Between {
    Text,
    /// Elements.
    Markup,
    /// It has no meaning in this file.
    Nothing,
}

/// The references unfold to more than may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooLong;

impl Entities {
    /// Those that the inner part of a DOCTYPE declares; external ones are left out.
    ///
    /// # Errors
    /// When they unfold to more than may be.
    pub(super) fn declared(doctype: &str) -> Result<Self, TooLong> {
        let mut entities = Self { values: BTreeMap::new(), left: MAX_UNFOLDED };
        for (name, value) in Declarations(doctype) {
            // A name may stand for what was declared before it, never for itself.
            let (value, _) = entities.unfold(value)?;
            entities.left = entities.left.checked_sub(value.len()).ok_or(TooLong)?;
            let value = value.into_owned();
            entities.values.entry(name.to_owned()).or_insert(value);
        }
        entities.left = MAX_UNFOLDED;
        Ok(entities)
    }

    /// What a reference between elements stands for.
    pub(super) fn between(&self, name: &str) -> Between {
        match self.values.get(name) {
            _ if name.starts_with('#') || resolve_xml_entity(name).is_some() => Between::Text,
            Some(value) if value.contains('<') => Between::Markup,
            Some(_) => Between::Text,
            None => Between::Nothing,
        }
    }

    /// A text with its references unfolded; one that is not well formed stays as it is.
    ///
    /// # Errors
    /// When all references so far unfold to more than may be.
    pub(super) fn unfold<'t>(&mut self, raw: &'t str) -> Result<(Cow<'t, str>, Unfolded), TooLong> {
        if !raw.contains('&') {
            return Ok((Cow::Borrowed(raw), Unfolded { unknown: false }));
        }
        let (mut unknown, mut full) = (false, false);
        let resolve = |name: &str| -> Option<&str> {
            let Some(value) = self.values.get(name) else {
                let own = resolve_xml_entity(name);
                unknown |= own.is_none();
                return Some(own.unwrap_or(""));
            };
            match self.left.checked_sub(value.len()) {
                Some(left) => {
                    self.left = left;
                    Some(value)
                }
                None => {
                    full = true;
                    None
                }
            }
        };
        let text = unescape_with(raw, resolve);
        if full {
            return Err(TooLong);
        }
        Ok((text.unwrap_or(Cow::Borrowed(raw)), Unfolded { unknown }))
    }
}

/// Goes through the declarations of entities with a value of their own: name and value as written.
struct Declarations<'t>(&'t str);

impl<'t> Iterator for Declarations<'t> {
    type Item = (&'t str, &'t str);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let start = self.0.find(['<', '"', '\''])?;
            let rest = &self.0[start..];
            if let Some(comment) = rest.strip_prefix("<!--") {
                self.0 = after(comment, "-->");
            } else if let Some(declaration) = rest.strip_prefix("<!ENTITY") {
                let (entity, rest) = entity(declaration);
                self.0 = rest;
                if entity.is_some() {
                    return entity;
                }
            } else if rest.starts_with(['"', '\'']) {
                self.0 = after(&rest[1..], &rest[..1]);
            } else {
                self.0 = &rest[1..];
            }
        }
    }
}

/// What follows the next `mark`, or nothing.
fn after<'t>(text: &'t str, mark: &str) -> &'t str {
    text.split_once(mark).map_or("", |(_, rest)| rest)
}

/// The name and the value of a declaration that has a value, and what follows.
fn entity(declaration: &str) -> (Option<(&str, &str)>, &str) {
    let text = declaration.trim_start();
    let Some((name, rest)) = text.split_once(char::is_whitespace) else { return (None, "") };
    let rest = rest.trim_start();
    // Entities of the DTD itself have a %, external ones a keyword where the value would stand.
    match rest.chars().next() {
        Some(quote @ ('"' | '\'')) if name != "%" => match rest[1..].split_once(quote) {
            Some((value, rest)) => (Some((name, value)), rest),
            None => (None, ""),
        },
        _ => (None, rest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unfold(doctype: &str, text: &str) -> Result<(String, bool), TooLong> {
        let mut entities = Entities::declared(doctype)?;
        entities.unfold(text).map(|(text, unfolded)| (text.into_owned(), unfolded.unknown))
    }

    #[test]
    fn entities_of_the_file_unfold_and_others_stand_for_nothing() {
        let doctype = r#"svg PUBLIC "-//W3C//DTD <!ENTITY no 'x'>" "u" [ <!-- <!ENTITY no "x"> -->
            <!ENTITY ns "http://x/"> <!ENTITY % no "x"> <!ENTITY two '&ns;&ns;'> <!ENTITY self "&self;">
            <!ENTITY passwd SYSTEM "file:///etc/passwd"> ]"#;
        for (text, unfolded, unknown) in [
            ("&ns;a &amp; b &#65;", "http://x/a & b A", false),
            ("&two;", "http://x/http://x/", false),
            ("[&no;]", "[]", true),
            ("[&passwd;]", "[]", true),
            ("[&self;]", "[]", false),
            ("a & b", "a & b", false),
        ] {
            assert_eq!(unfold(doctype, text), Ok((unfolded.into(), unknown)), "{text}");
        }
    }

    #[test]
    fn bombs_are_refused_before_they_take_memory() {
        let mut laughs = String::from("svg [<!ENTITY a0 \"laugh\">");
        for k in 1..40 {
            let all = format!("&a{};", k - 1).repeat(10);
            laughs += &format!("<!ENTITY a{k} \"{all}\">");
        }
        assert_eq!(Entities::declared(&laughs).map(|_| ()), Err(TooLong));
        let large = format!("svg [<!ENTITY a \"{}\">]", "x".repeat(1 << 16));
        assert!(unfold(&large, &"&a;".repeat(60)).is_ok());
        assert_eq!(unfold(&large, &"&a;".repeat(65)), Err(TooLong));
    }
}
