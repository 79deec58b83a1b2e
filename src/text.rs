//! Texts of strangers, made fit to be shown.
//!
//! A graph and the files it names are written by anybody: a title may hold the commands of a terminal, marks that turn
//! the direction of writing, characters that nobody sees, or line breaks that add lines of somebody else's wording.
//! [`printable`] shows all of these as escapes and leaves what is meant to be read as it is, in every script;
//! [`printable_json`] does the same for a document that programs read.

use std::borrow::Cow;
use std::fmt::Write as _;

use serde_json::Value as Json;

/// A text as one line in which everything can be seen: what a terminal obeys or nobody sees stands as an escape, such
/// as `\u{1b}` or `\n`. What was made printable once stays as it is.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |out, c| {
        let named = match c {
            '\n' => "\\n",
            '\r' => "\\r",
            '\t' => "\\t",
            _ => return out.extend(c.escape_unicode()),
        };
        out.push_str(named);
    })
}

/// A text of several lines, each of them printable.
pub fn printable_lines(text: &str) -> String {
    text.lines().map(printable).collect::<Vec<_>>().join("\n")
}

/// A JSON text, whose line breaks and spaces between the values are its own, with the escapes of JSON for whatever
/// [`printable`] would escape: the same document.
pub fn printable_json(text: &str) -> Cow<'_, str> {
    escaped(text, |out, c| match c {
        // Inside its texts a serialiser has escaped these already.
        '\n' | '\r' | '\t' => out.push(c),
        _ => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| _ = write!(out, "\\u{unit:04x}")),
    })
}

fn escaped(text: &str, escape: impl Fn(&mut String, char)) -> Cow<'_, str> {
    if text.bytes().all(|b| matches!(b, b' '..=b'~')) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    let mut before = None;
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        if is_seen(before, c, rest.clone().next()) {
            out.push(c);
        } else {
            escape(&mut out, c);
        }
        before = Some(c);
    }
    if out == text { Cow::Borrowed(text) } else { Cow::Owned(out) }
}

/// Whether a character is seen as what it is, between its neighbours.
fn is_seen(before: Option<char>, c: char, after: Option<char>) -> bool {
    match c {
        ' '..='~' => true,
        '\0'..='\u{9f}' => false,
        _ if is_blank(c) => false,
        _ if is_space(c) || is_sign(c) => true,
        '\u{200c}' | '\u{200d}' => joins(before, c, after),
        _ if is_selector(c) => selects(before, c, after),
        _ => has_shape(c),
    }
}

/// Spaces other than the plain one: seen as a gap.
fn is_space(c: char) -> bool {
    matches!(c, '\u{a0}' | '\u{1680}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\u{205f}' | '\u{3000}')
}

/// Letters and marks by their class that have no shape: fillers of Hangul, vowels of Khmer that are not written, the
/// mark that joins graphemes.
fn is_blank(c: char) -> bool {
    let blank = ['\u{34f}', '\u{115f}', '\u{1160}', '\u{17b4}', '\u{17b5}', '\u{3164}', '\u{ffa0}'];
    blank.contains(&c)
}

/// Marks of formatting by their class that have a shape: signs over Arabic, Syriac and Kaithi numbers.
fn is_sign(c: char) -> bool {
    let shown = ['\u{6dd}', '\u{70f}', '\u{890}', '\u{891}', '\u{8e2}', '\u{110bd}', '\u{110cd}'];
    matches!(c, '\u{600}'..='\u{605}') || shown.contains(&c)
}

/// Whether a joiner or non-joiner does its work: between two letters of a script that spells with them, and, the
/// joiner, between two parts of one emoji.
fn joins(before: Option<char>, c: char, after: Option<char>) -> bool {
    let (Some(before), Some(after)) = (before, after) else { return false };
    let emoji = c == '\u{200d}' && (is_symbol(before) || before == '\u{fe0f}') && is_symbol(after);
    emoji || (spells_with_joiners(before) && spells_with_joiners(after))
}

/// Arabic to Mandaic, the scripts of India and its neighbours, Myanmar, Khmer, Mongolian.
fn spells_with_joiners(c: char) -> bool {
    let script = matches!(c,
        '\u{600}'..='\u{dff}' | '\u{1000}'..='\u{109f}' | '\u{1780}'..='\u{18af}' | '\u{1900}'..='\u{1cff}'
        | '\u{a840}'..='\u{a8ff}' | '\u{fb50}'..='\u{fdff}' | '\u{fe70}'..='\u{fefc}' | '\u{11000}'..='\u{11fff}');
    script && has_shape(c)
}

/// Symbols and pictures, among them those that join to one emoji.
fn is_symbol(c: char) -> bool {
    matches!(c, '\u{203c}' | '\u{2049}' | '\u{2190}'..='\u{2bff}' | '\u{3030}' | '\u{303d}' | '\u{3297}' | '\u{3299}'
        | '\u{1f000}'..='\u{1faff}')
}

/// Characters that choose a form of the one before them.
fn is_selector(c: char) -> bool {
    matches!(c, '\u{180b}'..='\u{180d}' | '\u{180f}' | '\u{fe00}'..='\u{fe0f}' | '\u{e0100}'..='\u{e01ef}')
}

/// Whether a selector stands after a character that has such forms.
fn selects(before: Option<char>, c: char, after: Option<char>) -> bool {
    let Some(before) = before else { return false };
    let ideograph =
        matches!(before, '\u{3400}'..='\u{9fff}' | '\u{f900}'..='\u{faff}' | '\u{20000}'..='\u{3ffff}');
    match c {
        '\u{180b}'..='\u{180f}' => matches!(before, '\u{1820}'..='\u{18aa}'),
        '\u{e0100}'..='\u{e01ef}' => ideograph,
        // A digit in the box of a key.
        '\u{fe0f}' if after == Some('\u{20e3}') => matches!(before, '0'..='9' | '#' | '*'),
        _ => ideograph || is_symbol(before),
    }
}

/// Whether the standard library calls a character printable: neither a control or format character, nor private, nor
/// unassigned. It tells so by what it escapes; marks that combine are escaped only at the start of a text.
fn has_shape(c: char) -> bool {
    let mut text = *b"a\0\0\0\0";
    let length = 1 + c.encode_utf8(&mut text[1..]).len();
    let text = std::str::from_utf8(&text[..length]).unwrap_or_default();
    text.escape_debug().count() == 2
}

/// A JSON value short enough for a message, on one line.
pub fn brief(value: &Json) -> String {
    const LONGEST: usize = 60;
    let mut text = String::new();
    if inline(&mut text, value, LONGEST) {
        return text;
    }
    text.chars().take(LONGEST - 3).chain("...".chars()).collect()
}

/// Writes a value on one line; gives up when the text gets longer than `end` bytes.
pub(crate) fn inline(out: &mut String, value: &Json, end: usize) -> bool {
    match value {
        Json::Object(map) if map.is_empty() => out.push_str("{}"),
        Json::Object(map) => {
            for (i, (key, value)) in map.iter().enumerate() {
                out.push_str(if i == 0 { "{ " } else { ", " });
                out.push_str(&Json::from(key.as_str()).to_string());
                out.push_str(": ");
                if !inline(out, value, end) {
                    return false;
                }
            }
            out.push_str(" }");
        }
        Json::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                out.push_str(if i == 0 { "" } else { ", " });
                if !inline(out, item, end) {
                    return false;
                }
            }
            out.push(']');
        }
        Json::Number(number) => {
            let whole = number.as_f64().filter(|_| number.is_f64()).and_then(whole);
            out.push_str(&whole.map_or_else(|| number.to_string(), |n| n.to_string()));
        }
        other => out.push_str(&other.to_string()),
    }
    out.len() <= end
}

/// Whole floats up to here print as integers and come back exactly: 2^53.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// The integer that a float stands for.
pub(crate) fn whole(value: f64) -> Option<i64> {
    (value == value.trunc() && value.abs() < MAX_EXACT).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_and_what_nobody_sees_is_escaped() {
        for (text, shown) in [
            ("a\u{1b}[31mb\u{7}", "a\\u{1b}[31mb\\u{7}"),
            ("\u{1b}]0;x\u{9c}\u{9b}2J\u{7f}", "\\u{1b}]0;x\\u{9c}\\u{9b}2J\\u{7f}"),
            ("title\nlicense\r\tCC0\u{8}", "title\\nlicense\\r\\tCC0\\u{8}"),
            ("a\u{202e}b\u{2066}c\u{61c}\u{200f}", "a\\u{202e}b\\u{2066}c\\u{61c}\\u{200f}"),
            ("a\u{200b}b\u{feff}\u{2060}\u{ad}", "a\\u{200b}b\\u{feff}\\u{2060}\\u{ad}"),
            ("a\u{200d}b\u{200c}", "a\\u{200d}b\\u{200c}"),
            ("a\u{2028}b\u{2029}\u{85}", "a\\u{2028}b\\u{2029}\\u{85}"),
            ("\u{e0041}\u{e000}\u{3164}\u{34f}", "\\u{e0041}\\u{e000}\\u{3164}\\u{34f}"),
            ("a\u{fe0f}b\u{e0101}\0", "a\\u{fe0f}b\\u{e0101}\\u{0}"),
            // A joiner between letters of a script that needs none, and two in a row.
            ("\u{645}\u{200c}\u{200c}\u{62e}", "\u{645}\\u{200c}\\u{200c}\u{62e}"),
        ] {
            assert_eq!(printable(text), shown);
            assert_eq!(printable(&printable(text)), shown, "once more changes nothing");
        }
    }

    #[test]
    fn letters_of_every_script_stay() {
        for text in [
            "Höhe über dem Meer, ½ m² — “Ausgabe”",
            "Высота рельефа",
            "地形の高さ　標高",
            "ارتفاع الأرض",
            "می\u{200c}خواهم",
            "גובה פני השטח",
            "ऊँचाई क्\u{200d}ष",
            "ශ්\u{200d}රී ලංකා",
            "ความสูง",
            "지형 높이",
            "e\u{301}\u{327} Ångström \u{1100}\u{1161}",
            "⛰\u{fe0f} 👩\u{200d}🚀 1\u{fe0f}\u{20e3}",
            "\u{845b}\u{e0100}城市",
            r#"C:\maps\a "b" 'c'"#,
        ] {
            assert_eq!(printable(text), text);
        }
    }

    #[test]
    fn json_stays_the_same_document() {
        let value = serde_json::json!({ "a\u{202e}": ["\u{1b}[2J\n", "\u{9b}é\u{e0041}", "plain"] });
        for text in [value.to_string(), format!("{value:#}")] {
            let shown = printable_json(&text);
            assert!(
                shown.chars().all(|c| c == '\n' || printable(&c.to_string()).len() == c.len_utf8()),
                "{shown}"
            );
            assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
        }
    }
}
