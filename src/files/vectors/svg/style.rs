//! Styles, as far as they say whether and where lines are drawn: `style` attributes, and the rules of style sheets whose
//! selectors are an element, a class, an `id`, `*` or several of these about one element.
//!
//! They are taken up once an element, before anything is drawn, so that drawing an element again takes no reading.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::tree::{Node, Tree};
use crate::files::vectors::short;
use crate::files::vectors::tally::{Notice, Tally};
use crate::value::curves::CurveError;

/// Properties that are read.
const READ: [&str; 5] = ["display", "visibility", "transform", "transform-origin", "transform-box"];
/// Properties that place or shape lines, too, and are not read.
const UNREAD: [&str; 12] =
    ["translate", "rotate", "scale", "offset-path", "d", "cx", "cy", "r", "rx", "ry", "x", "y"];
/// Rules at an `@` that say nothing of elements.
const IDLE: [&str; 7] =
    ["charset", "namespace", "font-face", "page", "keyframes", "-webkit-keyframes", "counter-style"];
/// Most rules about several things of one element at once, as `path.a`.
const MAX_COMPOUNDS: usize = 64;
/// Longest value of a property, in bytes.
const MAX_VALUE: usize = 256;

/// What styles say of the elements of a tree.
#[derive(Debug, Default)]
pub(super) struct Looks {
    each: Vec<Look>,
    moves: BTreeMap<usize, Moves>,
}

/// What styles say of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Look {
    /// It is not drawn, with all in it.
    pub(super) hidden: bool,
    /// Whether its lines show; none where it is as outside.
    pub(super) visible: Option<bool>,
}

/// How styles move an element.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Moves {
    /// The value of `transform`, which counts before the attribute.
    pub(super) transform: Option<String>,
    pub(super) origin: Option<String>,
    /// The value of `transform-box`.
    pub(super) frame: Option<String>,
}

impl Looks {
    /// Those of all elements, by their attributes and the style sheets of the picture.
    ///
    /// # Errors
    /// When the work was asked to stop.
    pub(super) fn of(
        tree: &Tree<'_>,
        css: &str,
        tally: &mut Tally,
        go_on: impl Fn() -> Result<(), CurveError>,
    ) -> Result<Self, CurveError> {
        let css = without_comments(css);
        let sheet = Sheet::of(&css, tally);
        let mut looks = Self::default();
        for index in 0..tree.len() {
            go_on()?;
            let values = sheet.values(&tree.node(index), tally);
            let fits = |said: &&Value<'_>| said.value.len() <= MAX_VALUE;
            let value = |name: &str| values.get(name).filter(fits).map(|said| said.value.to_owned());
            if let Some(long) = values.values().find(|said| !fits(said)) {
                tally.add(Notice::Style, || format!("a value of {} bytes", long.value.len()));
            }
            looks.each.push(look(&values));
            let (transform, origin) = (value("transform"), value("transform-origin"));
            let moves = Moves { transform, origin, frame: value("transform-box") };
            if moves != Moves::default() {
                looks.moves.insert(index, moves);
            }
        }
        Ok(looks)
    }

    pub(super) fn look(&self, index: usize) -> Look {
        self.each.get(index).copied().unwrap_or_default()
    }

    pub(super) fn moves(&self, index: usize) -> Option<&Moves> {
        self.moves.get(&index)
    }
}

fn look(values: &Values<'_>) -> Look {
    let word = |name: &str| values.get(name).map(|said| said.value.to_ascii_lowercase());
    let visible = match word("visibility").as_deref() {
        Some("hidden" | "collapse") => Some(false),
        Some("visible") => Some(true),
        _ => None,
    };
    Look { hidden: word("display").as_deref() == Some("none"), visible }
}

/// A value that a style gives, and how much it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Value<'s> {
    value: &'s str,
    /// Whether it is important, then how near it is to the element.
    weight: (bool, u32),
    /// Later ones count before earlier ones.
    order: u32,
}

/// Values by property.
type Values<'s> = BTreeMap<&'static str, Value<'s>>;

/// Takes up a value where none that counts more is there.
fn put<'s>(values: &mut Values<'s>, name: &'static str, said: Value<'s>) {
    let entry = values.entry(name).or_insert(said);
    if (entry.weight, entry.order) <= (said.weight, said.order) {
        *entry = said;
    }
}

/// A part of a selector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Simple<'s> {
    Any,
    Element(&'s str),
    Class(&'s str),
    Id(&'s str),
}

impl Simple<'_> {
    fn weight(self) -> u32 {
        match self {
            Self::Any => 0,
            Self::Element(_) => 1,
            Self::Class(_) => 1 << 8,
            Self::Id(_) => 1 << 16,
        }
    }
}

/// The weight of a `style` attribute, above that of every selector.
const OWN: u32 = u32::MAX;

/// The rules of the style sheets of a picture.
#[derive(Debug, Default)]
struct Sheet<'s> {
    simple: BTreeMap<Simple<'s>, Values<'s>>,
    compound: Vec<(Vec<Simple<'s>>, Values<'s>)>,
}

impl<'s> Sheet<'s> {
    fn of(css: &'s str, tally: &mut Tally) -> Self {
        let mut sheet = Self::default();
        let (mut rest, mut order) = (css, 0);
        while let Some((rule, after)) = rule(rest) {
            rest = after;
            order += 1;
            match rule {
                Rule::At(text) => at_rule(text, tally),
                Rule::Block(selectors, block) => sheet.take(selectors, block, order, tally),
            }
        }
        sheet
    }

    fn take(&mut self, selectors: &'s str, block: &'s str, order: u32, tally: &mut Tally) {
        let said: Vec<_> = declarations(block).collect();
        if let Some(said) = said.iter().find(|said| UNREAD.contains(&said.name)) {
            tally.add(Notice::Style, || format!("`{}` of the style sheet", said.name));
        }
        let read = |said: &Declaration<'s>| Some((said.read()?, said.value, said.important));
        let said: Vec<_> = said.iter().filter_map(read).collect();
        if said.is_empty() {
            return;
        }
        for selector in parts(selectors, ',') {
            let parts = simples(selector).filter(|p| p.len() == 1 || self.compound.len() < MAX_COMPOUNDS);
            let Some(parts) = parts else {
                tally.add(Notice::Style, || {
                    format!("the rules of `{}` in the style sheet", short(selector.trim()))
                });
                continue;
            };
            let weight = parts.iter().fold(0_u32, |sum, part| sum.saturating_add(part.weight()));
            let mut values = Values::new();
            for &(name, value, important) in &said {
                put(&mut values, name, Value { value, weight: (important, weight), order });
            }
            match parts.as_slice() {
                [one] => {
                    let known = self.simple.entry(*one).or_default();
                    values.into_iter().for_each(|(name, said)| put(known, name, said));
                }
                _ => self.compound.push((parts, values)),
            }
        }
    }

    /// What holds for an element: its attributes, the rules that name it, and its own style, by what counts more.
    fn values<'n>(&'n self, node: &Node<'n>, tally: &mut Tally) -> Values<'n> {
        let mut values = Values::new();
        for name in ["display", "visibility", "transform-origin"] {
            if let Some(value) = node.attribute(name) {
                put(&mut values, name, Value { value: value.trim(), weight: (false, 0), order: 0 });
            }
        }
        for said in self.rules(node) {
            said.iter().for_each(|(name, said)| put(&mut values, name, *said));
        }
        for said in declarations(node.attribute("style").unwrap_or_default()) {
            if UNREAD.contains(&said.name) {
                let what = || format!("`{}` in the style of {}", said.name, node.place());
                tally.add(Notice::Style, what);
            }
            if let Some(name) = said.read() {
                let weight = (said.important, OWN);
                put(&mut values, name, Value { value: said.value, weight, order: 0 });
            }
        }
        values
    }

    /// The rules that name an element.
    fn rules<'n>(&'n self, node: &Node<'n>) -> Vec<&'n Values<'n>> {
        if self.simple.is_empty() && self.compound.is_empty() {
            return Vec::new();
        }
        let classes = node.attribute("class").unwrap_or_default().split_ascii_whitespace().map(Simple::Class);
        let id = node.attribute("id").map(Simple::Id);
        let own = [Simple::Any, Simple::Element(node.name())].into_iter().chain(id).chain(classes);
        let own: BTreeSet<Simple<'n>> = own.collect();
        let simple = own.iter().filter_map(|part| self.simple.get(part));
        let compound = self.compound.iter().filter(|(parts, _)| parts.iter().all(|part| own.contains(part)));
        simple.chain(compound.map(|(_, values)| values)).collect()
    }
}

/// A declaration as it is written.
#[derive(Clone, Copy, Debug)]
struct Declaration<'s> {
    name: &'s str,
    value: &'s str,
    important: bool,
}

impl Declaration<'_> {
    /// The name, where the property is read.
    fn read(&self) -> Option<&'static str> {
        READ.into_iter().find(|name| self.name.eq_ignore_ascii_case(name))
    }
}

/// The declarations of a block or a `style` attribute.
fn declarations(block: &str) -> impl Iterator<Item = Declaration<'_>> {
    parts(block, ';').filter_map(|text| {
        let (name, value) = text.split_once(':')?;
        let (value, important) = match value.rsplit_once('!') {
            Some((value, word)) if word.trim().eq_ignore_ascii_case("important") => (value, true),
            _ => (value, false),
        };
        Some(Declaration { name: name.trim(), value: value.trim(), important })
    })
}

/// The parts of a selector about one element; none where it is another one.
fn simples(selector: &str) -> Option<Vec<Simple<'_>>> {
    let selector = selector.trim();
    let known = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '#' | '*');
    if selector.is_empty() || !selector.chars().all(known) {
        return None;
    }
    let mut found = Vec::new();
    let mut rest = selector;
    while !rest.is_empty() {
        let first = rest.chars().next()?.len_utf8();
        let end = rest[first..].find(['.', '#', '*']).map_or(rest.len(), |at| first + at);
        let (part, after) = rest.split_at(end);
        found.push(match (part.as_bytes().first()?, part.get(1..)) {
            (b'*', Some("")) => Simple::Any,
            (b'.', Some(name)) if !name.is_empty() => Simple::Class(name),
            (b'#', Some(name)) if !name.is_empty() => Simple::Id(name),
            (b'*' | b'.' | b'#', _) => return None,
            _ => Simple::Element(part),
        });
        rest = after;
    }
    Some(found)
}

/// A rule of a style sheet.
enum Rule<'s> {
    /// One that begins with `@`.
    At(&'s str),
    /// Selectors, and what holds for what they name.
    Block(&'s str, &'s str),
}

/// The next rule, and what follows it.
fn rule(text: &str) -> Option<(Rule<'_>, &str)> {
    let text = text.trim_start();
    let text = text.strip_prefix("<!--").or(text.strip_prefix("-->")).unwrap_or(text).trim_start();
    if text.is_empty() {
        return None;
    }
    let is_at = text.starts_with('@');
    let end = outside(text, |c| c == '{' || (is_at && c == ';')).unwrap_or(text.len());
    let (head, rest) = text.split_at(end);
    let Some(inner) = rest.strip_prefix('{') else {
        let after = rest.get(1..).unwrap_or_default();
        return Some((if is_at { Rule::At(head) } else { Rule::Block("", "") }, after));
    };
    let close = outside(inner, |c| c == '}').unwrap_or(inner.len());
    let (block, after) = (&inner[..close], inner.get(close + 1..).unwrap_or_default());
    let whole = &text[..end + 1 + close];
    Some((if is_at { Rule::At(whole) } else { Rule::Block(head.trim(), block) }, after))
}

/// Tells of a rule at an `@` that would say what is drawn.
fn at_rule(text: &str, tally: &mut Tally) {
    let name = text[1..].split(|c: char| !c.is_alphanumeric() && c != '-').next().unwrap_or_default();
    let says = name.eq_ignore_ascii_case("import") || READ.iter().any(|property| text.contains(property));
    if says && !IDLE.iter().any(|idle| name.eq_ignore_ascii_case(idle)) {
        tally.add(Notice::Style, || format!("`@{}` in the style sheet", short(name)));
    }
}

/// The parts of a text between separators, without those in quotes and brackets.
fn parts(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest?;
        let end = outside(text, |c| c == separator);
        rest = end.and_then(|end| text.get(end + separator.len_utf8()..));
        Some(&text[..end.unwrap_or(text.len())])
    })
}

/// Where the first character of a kind stands outside of quotes and brackets.
fn outside(text: &str, is_it: impl Fn(char) -> bool) -> Option<usize> {
    let (mut quote, mut depth, mut escaped) = (None, 0_usize, false);
    for (at, c) in text.char_indices() {
        if std::mem::take(&mut escaped) {
            continue;
        }
        match (quote, c) {
            (_, '\\') => escaped = true,
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) => (),
            _ if depth == 0 && is_it(c) => return Some(at),
            (None, '"' | '\'') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
            _ => (),
        }
    }
    None
}

fn without_comments(css: &str) -> Cow<'_, str> {
    if !css.contains("/*") {
        return Cow::Borrowed(css);
    }
    let mut plain = String::with_capacity(css.len());
    let mut rest = css;
    while let Some((before, comment)) = rest.split_once("/*") {
        plain.push_str(before);
        plain.push(' ');
        rest = comment.split_once("*/").map_or("", |(_, after)| after);
    }
    plain.push_str(rest);
    Cow::Owned(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selectors_about_one_element_are_taken_apart() {
        use Simple as S;
        for (text, want) in [
            ("*", Some(vec![S::Any])),
            (" path ", Some(vec![S::Element("path")])),
            (".st0", Some(vec![S::Class("st0")])),
            ("#é-1", Some(vec![S::Id("é-1")])),
            ("path.a.b#c", Some(vec![S::Element("path"), S::Class("a"), S::Class("b"), S::Id("c")])),
            ("é.a", Some(vec![S::Element("é"), S::Class("a")])),
            ("*.a", Some(vec![S::Any, S::Class("a")])),
            ("g > path", None),
            ("g path", None),
            ("a:hover", None),
            ("[id]", None),
            (".", None),
            ("", None),
            (".a\\31", None),
        ] {
            assert_eq!(simples(text), want, "{text}");
        }
    }

    #[test]
    fn declarations_stand_between_semicolons_outside_of_quotes() {
        let text = "font:'a;display:none'; src: url(data:x;display:none);;Display : none !IMPORTANT; bad";
        let all: Vec<_> = declarations(text).map(|d| (d.name, d.value, d.important)).collect();
        assert_eq!(all.len(), 3, "{all:?}");
        assert_eq!(all[2], ("Display", "none", true));
    }

    #[test]
    fn no_text_is_a_hang_or_a_panic() {
        for text in
            ["{", "}", "@", "@import", "@media{", "a{", "a}b{display:none", "'", "\\", "é{", "/*", "a,{}"]
        {
            let mut tally = Tally::default();
            let plain = without_comments(text);
            Sheet::of(&plain, &mut tally);
        }
    }
}
