//! Style sheets as text: rules, selectors about one element, and declarations.
//!
//! Each function goes through its text once. A string without an end ends with its line and a block with its sheet, as in
//! browsers.

use std::borrow::Cow;

/// Most different parts of a selector, as the two of `path.a`.
const MAX_PARTS: usize = 8;

/// A rule as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rule<'s> {
    /// Selectors, or what a rule at an `@` begins with.
    pub(super) head: &'s str,
    /// What stands in its braces, where it has some.
    pub(super) block: Option<&'s str>,
    /// Whether it ends before the end of the sheet.
    pub(super) is_closed: bool,
}

/// The rules of a sheet without comments.
pub(super) fn rules(text: &str) -> impl Iterator<Item = Rule<'_>> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (rule, after) = rule(rest)?;
        rest = after;
        Some(rule)
    })
}

/// The next rule, and what follows it.
fn rule(text: &str) -> Option<(Rule<'_>, &str)> {
    let text = text.trim_start();
    let text = text.strip_prefix("<!--").or(text.strip_prefix("-->")).unwrap_or(text).trim_start();
    if text.is_empty() {
        return None;
    }
    let is_at = text.starts_with('@');
    let end = outside(text, |c| c == '{' || (is_at && c == ';'));
    let (head, rest) = text.split_at(end.unwrap_or(text.len()));
    let head = head.trim_end();
    let Some(inner) = rest.strip_prefix('{') else {
        return Some((Rule { head, block: None, is_closed: is_at }, rest.get(1..).unwrap_or_default()));
    };
    let close = outside(inner, |c| c == '}');
    let (block, after) = match close {
        Some(close) => (&inner[..close], &inner[close + 1..]),
        None => (inner, ""),
    };
    Some((Rule { head, block: Some(block), is_closed: close.is_some() }, after))
}

/// A declaration as it is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Declaration<'s> {
    pub(super) name: &'s str,
    pub(super) value: &'s str,
    pub(super) important: bool,
}

impl Declaration<'_> {
    /// Which of some properties it sets.
    pub(super) fn among(&self, properties: &[&str]) -> Option<usize> {
        properties.iter().position(|name| self.name.eq_ignore_ascii_case(name))
    }

    /// Whether a block stands in it that speaks of some properties: a rule inside of a rule, or one that lacks its end.
    pub(super) fn holds_rule_of(&self, properties: &[&str]) -> bool {
        [self.name, self.value].iter().any(|text| text.contains('{'))
            && (speaks_of(self.name, properties) || speaks_of(self.value, properties))
    }
}

/// The declarations of a block or a `style` attribute.
pub(super) fn declarations(block: &str) -> impl Iterator<Item = Declaration<'_>> {
    parts(block, ';').filter_map(|text| {
        let (name, value) = text.split_once(':')?;
        let (value, important) = match value.rsplit_once('!') {
            Some((value, word)) if word.trim().eq_ignore_ascii_case("important") => (value, true),
            _ => (value, false),
        };
        Some(Declaration { name: name.trim(), value: value.trim(), important })
    })
}

/// Whether one of some words stands in a text.
pub(super) fn speaks_of(text: &str, words: &[&str]) -> bool {
    let mut all = text.split(|c: char| !c.is_alphanumeric() && !matches!(c, '-' | '_'));
    all.any(|found| words.iter().any(|word| found.eq_ignore_ascii_case(word)))
}

/// A part of a selector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Simple<'s> {
    Any,
    Element(&'s str),
    Class(&'s str),
    Id(&'s str),
}

impl Simple<'_> {
    /// How much a selector of this part alone counts.
    pub(super) fn weight(self) -> u32 {
        match self {
            Self::Any => 0,
            Self::Element(_) => 1,
            Self::Class(_) => 1 << 8,
            Self::Id(_) => 1 << 16,
        }
    }
}

/// A selector about one element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Selector<'s> {
    /// Its parts, each once, in their order.
    pub(super) parts: Vec<Simple<'s>>,
    /// How much it counts: parts that stand in it again count again.
    pub(super) weight: u32,
}

/// The selectors of a rule.
pub(super) fn selectors(head: &str) -> impl Iterator<Item = &str> {
    parts(head, ',').map(str::trim)
}

/// A selector taken apart; none where it is not about one element alone, or has more than a few different parts.
pub(super) fn selector(text: &str) -> Option<Selector<'_>> {
    let known = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '#' | '*');
    if text.is_empty() || !text.chars().all(known) {
        return None;
    }
    let mut parts = Vec::new();
    // Of ids, classes and elements; no number of the ones weighs more than one of the others.
    let mut counts = [0_u32; 3];
    let mut rest = text;
    while !rest.is_empty() {
        let first = rest.chars().next()?.len_utf8();
        let end = rest[first..].find(['.', '#', '*']).map_or(rest.len(), |at| first + at);
        let (part, after) = rest.split_at(end);
        let (part, kind) = match (part.as_bytes().first()?, part.get(1..)) {
            (b'*', Some("")) => (Simple::Any, None),
            (b'.', Some(name)) if !name.is_empty() => (Simple::Class(name), Some(1)),
            (b'#', Some(name)) if !name.is_empty() => (Simple::Id(name), Some(0)),
            (b'*' | b'.' | b'#', _) => return None,
            _ => (Simple::Element(part), Some(2)),
        };
        if let Some(kind) = kind {
            counts[kind] = (counts[kind] + 1).min(255);
        }
        if !parts.contains(&part) {
            parts.push(part);
        }
        if parts.len() > MAX_PARTS {
            return None;
        }
        rest = after;
    }
    parts.sort_unstable();
    Some(Selector { parts, weight: counts.iter().fold(0, |sum, count| (sum << 8) | count) })
}

/// Whether a sheet for some media holds on a screen; none where that depends on more than the medium.
pub(super) fn is_for_screen(media: &str) -> Option<bool> {
    let one = |query: &str| {
        let lower = query.trim().to_ascii_lowercase();
        let query = lower.strip_prefix("only ").unwrap_or(&lower).trim();
        let (medium, condition) = query.split_once([' ', '(']).unwrap_or((query, ""));
        match medium {
            "all" | "screen" => condition.is_empty().then_some(true),
            "" | "not" => None,
            _ => Some(false),
        }
    };
    if media.trim().is_empty() {
        return Some(true);
    }
    // One that holds is enough, and one that is not known leaves the others open.
    let (mut holds, mut is_known) = (false, true);
    for query in media.split(',').map(one) {
        holds |= query == Some(true);
        is_known &= query.is_some();
    }
    (holds || is_known).then_some(holds)
}

/// The parts of a text between separators, without those in strings and brackets.
fn parts(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest?;
        let end = outside(text, |c| c == separator);
        rest = end.and_then(|end| text.get(end + separator.len_utf8()..));
        Some(&text[..end.unwrap_or(text.len())])
    })
}

/// Where the first character of a kind stands outside of strings and brackets.
fn outside(text: &str, is_it: impl Fn(char) -> bool) -> Option<usize> {
    let (mut strings, mut depth) = (Strings::default(), 0_usize);
    for (at, c) in text.char_indices() {
        if strings.hold(c) {
            continue;
        }
        match c {
            _ if depth == 0 && is_it(c) => return Some(at),
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ => (),
        }
    }
    None
}

/// Whether the characters of a text stand in strings.
#[derive(Debug, Default)]
struct Strings {
    /// The quote that ends the one that is open.
    open: Option<char>,
    /// Whether the character before was a `\`.
    escaped: bool,
}

impl Strings {
    /// Whether the next character belongs to a string, or is written with a `\`.
    fn hold(&mut self, c: char) -> bool {
        if self.escaped {
            // An end of line may be two characters.
            self.escaped = c == '\r';
            return true;
        }
        match (self.open, c) {
            (_, '\\') => self.escaped = true,
            (Some(_), '\n' | '\x0c') => self.open = None,
            (Some(open), _) if c == open => self.open = None,
            (None, '"' | '\'') => self.open = Some(c),
            (open, _) => return open.is_some(),
        }
        true
    }
}

/// A sheet without its comments, and what stands in one that has no end.
pub(super) fn without_comments(css: &str) -> (Cow<'_, str>, &str) {
    let Some(mut start) = comment(css) else { return (Cow::Borrowed(css), "") };
    let mut plain = String::with_capacity(css.len());
    let mut rest = css;
    loop {
        plain.push_str(&rest[..start]);
        plain.push(' ');
        let inside = &rest[start + 2..];
        let Some((_, after)) = inside.split_once("*/") else { return (Cow::Owned(plain), inside) };
        rest = after;
        let Some(next) = comment(rest) else { break };
        start = next;
    }
    plain.push_str(rest);
    (Cow::Owned(plain), "")
}

/// Where the first comment begins: in a string there is none.
fn comment(css: &str) -> Option<usize> {
    let mut strings = Strings::default();
    let mut begins = |(at, c): (usize, char)| !strings.hold(c) && css[at..].starts_with("/*");
    css.char_indices().find(|found| begins(*found)).map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selectors_about_one_element_are_taken_apart() {
        use Simple as S;
        for (text, want) in [
            ("*", Some((vec![S::Any], 0))),
            ("path", Some((vec![S::Element("path")], 1))),
            (".st0", Some((vec![S::Class("st0")], 1 << 8))),
            ("#é-1", Some((vec![S::Id("é-1")], 1 << 16))),
            (
                "path.b.a#c",
                Some((vec![S::Element("path"), S::Class("a"), S::Class("b"), S::Id("c")], 0x1_0201)),
            ),
            ("é.a", Some((vec![S::Element("é"), S::Class("a")], 0x101))),
            ("*.a", Some((vec![S::Any, S::Class("a")], 0x100))),
            // What stands again counts again, and is looked for once.
            (".a.a", Some((vec![S::Class("a")], 0x200))),
            ("g > path", None),
            ("g path", None),
            ("a:hover", None),
            ("[id]", None),
            (".", None),
            ("", None),
            (".a\\31", None),
            (".a.b.c.d.e.f.g.h.i", None),
        ] {
            let want = want.map(|(parts, weight)| Selector { parts, weight });
            assert_eq!(selector(text), want, "{text}");
        }
        let many = selector(&".a".repeat(1000)).map(|s| (s.parts.len(), s.weight));
        assert_eq!(many, Some((1, 0xff00)), "classes never weigh more than an id");
    }

    #[test]
    fn declarations_stand_between_semicolons_outside_of_strings() {
        let text = "font:'a;display:none'; src: url(data:x;display:none);;Display : none !IMPORTANT; bad";
        let all: Vec<_> = declarations(text).map(|d| (d.name, d.value, d.important)).collect();
        assert_eq!(all.len(), 3, "{all:?}");
        assert_eq!(all[2], ("Display", "none", true));
    }

    /// What lacks its end ends where it does in browsers.
    #[test]
    fn strings_end_with_their_line_and_blocks_with_their_sheet() {
        let told =
            |text: &'static str| rules(text).map(|r| (r.head, r.block, r.is_closed)).collect::<Vec<_>>();
        assert_eq!(
            told("a{b} @c d; @e{f{g}}"),
            [("a", Some("b"), true), ("@c d", None, true), ("@e", Some("f{g}"), true)]
        );
        assert_eq!(told("a{b:'c}\n} d{e}"), [("a", Some("b:'c}\n"), true), ("d", Some("e"), true)]);
        assert_eq!(
            told("a{b:'c\\\r\n}'} d{e}").len(),
            2,
            "a string goes on after a `\\` at the end of a line"
        );
        assert_eq!(told("a{b:\"c}\" d"), [("a", Some("b:\"c}\" d"), false)]);
        assert_eq!(told("a{b c{d}"), [("a", Some("b c{d}"), false)]);
        assert_eq!(told("a b"), [("a b", None, false)]);
        for text in
            ["{", "}", "@", "@import", "@media{", "a}b{c", "'", "\\", "é{", "a,{}", "<!-- -->", "\\\r"]
        {
            let all: Vec<_> = rules(text).flat_map(|r| declarations(r.block.unwrap_or(r.head))).collect();
            assert!(all.is_empty(), "{text}: {all:?}");
        }
    }

    #[test]
    fn comments_are_taken_out_of_what_is_no_string() {
        for (css, plain, swallowed) in [
            ("a/* b */c", "a c", ""),
            ("a/* ' */c/**/", "a c ", ""),
            ("a'/*'b", "a'/*'b", ""),
            ("a'/*\n/*'*/b", "a'/*\n b", ""),
            ("a/*/b", "a ", "/b"),
            ("a/*é", "a ", "é"),
            ("é/", "é/", ""),
        ] {
            assert_eq!(without_comments(css), (Cow::Borrowed(plain), swallowed), "{css}");
        }
    }

    #[test]
    fn media_hold_fail_or_depend() {
        for (media, holds) in [
            ("", Some(true)),
            ("all", Some(true)),
            ("print, Screen", Some(true)),
            ("only screen", Some(true)),
            ("print", Some(false)),
            ("print and (min-width:1px)", Some(false)),
            ("screen and (min-width:1px)", None),
            ("print, (min-width:1px)", None),
            ("screen, (min-width:1px)", Some(true)),
            ("not print", None),
        ] {
            assert_eq!(is_for_screen(media), holds, "{media}");
        }
    }
}
