//! Strict JSON: duplicate keys, deep nesting and too many values are errors with their place.

use std::cell::Cell;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value as Json};

use super::LoadError;
use crate::text::whole;

/// The most bytes of a key.
const MAX_KEY: usize = 256;
/// The most bytes of a string.
const MAX_TEXT: usize = 1 << 16;
/// The most values in a file; each takes up to 72 bytes in memory, and as few as two in the file.
const MAX_VALUES: usize = 1_000_000;

/// Reads a text. Whole numbers become integers in whatever form they are written, since JSON has one type of number.
///
/// # Errors
/// Fails when the text is no JSON or exceeds a limit; the error has the line and the column.
pub fn read(text: &str) -> Result<Json, LoadError> {
    // A byte order mark, as some editors on Windows leave it.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim_ascii().is_empty() {
        return Err(LoadError::Empty);
    }
    let left = Cell::new(MAX_VALUES);
    let mut reader = serde_json::Deserializer::from_str(text);
    let json = Any { path: None, left: &left }.deserialize(&mut reader);
    json.and_then(|json| reader.end().map(|()| json)).map_err(|e| explain(&e, text))
}

/// Turns whole floats into integers, as [`read`] does.
pub(super) fn tidy(json: &mut Json) {
    match json {
        Json::Number(n) if n.is_f64() => {
            if let Some(whole) = n.as_f64().and_then(whole) {
                *json = Json::from(whole);
            }
        }
        Json::Array(items) => items.iter_mut().for_each(tidy),
        Json::Object(map) => map.values_mut().for_each(tidy),
        _ => (),
    }
}

/// Whether two values are equal; numbers are compared by value.
pub(super) fn same(a: &Json, b: &Json) -> bool {
    match (a, b) {
        (Json::Number(a), Json::Number(b)) => {
            if a.is_f64() || b.is_f64() {
                a.as_f64() == b.as_f64()
            } else {
                a == b
            }
        }
        (Json::Array(a), Json::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Json::Object(a), Json::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(k, v)| b.get(k).is_some_and(|w| same(v, w)))
        }
        _ => a == b,
    }
}

fn explain(error: &serde_json::Error, text: &str) -> LoadError {
    let (line, column) = (error.line(), error.column());
    if error.is_eof() {
        return LoadError::Truncated { line, column };
    }
    let full = error.to_string();
    let plain = full.rsplit_once(" at line ").map_or(full.as_str(), |(head, _)| head);
    let message = match (plain, word_at(text, line, column)) {
        ("recursion limit exceeded", _) => "it is nested more than 127 levels deep".to_owned(),
        ("expected value" | "expected ident" | "invalid number", Some(word)) => {
            let number = matches!(word.to_ascii_lowercase().as_str(), "nan" | "inf" | "infinity");
            let wanted = if number { "a number in JSON" } else { "a value; texts stand in quotes" };
            format!("`{word}` is not {wanted}")
        }
        (other, _) => other.to_owned(),
    };
    LoadError::Syntax { message, line, column }
}

/// The unquoted word at a line and column of a text.
fn word_at(text: &str, line: usize, column: usize) -> Option<&str> {
    let bytes = text.lines().nth(line.checked_sub(1)?)?.as_bytes();
    let at = column.checked_sub(1)?.min(bytes.len().checked_sub(1)?);
    // Where a minus was read, the word begins after it.
    let at = if bytes[at] == b'-' { at + 1 } else { at };
    let start = bytes[..at].iter().rposition(|b| !b.is_ascii_alphanumeric()).map_or(0, |i| i + 1);
    let word = bytes[start..].split(|b| !b.is_ascii_alphanumeric()).next()?;
    let starts_well = word.first().is_some_and(u8::is_ascii_alphabetic) && word.len() <= 40;
    starts_well.then(|| std::str::from_utf8(word).ok()).flatten()
}

/// The path of a value in the document, as a linked list on the stack.
#[derive(Clone, Copy)]
struct Path<'a> {
    up: Option<&'a Self>,
    step: PathStep<'a>,
}

#[derive(Clone, Copy)]
enum PathStep<'a> {
    Key(&'a str),
    Item(usize),
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(up) = self.up {
            write!(f, "{up}.")?;
        }
        match self.step {
            PathStep::Key(key) => write!(f, "{key}"),
            PathStep::Item(i) => write!(f, "{i}"),
        }
    }
}

/// Reads any value at a path.
#[derive(Clone, Copy)]
struct Any<'a> {
    path: Option<&'a Path<'a>>,
    left: &'a Cell<usize>,
}

impl<'a> Any<'a> {
    fn below<'b>(self, path: &'b Path<'b>) -> Any<'b>
    where
        'a: 'b,
    {
        Any { path: Some(path), left: self.left }
    }

    fn shown(self) -> String {
        self.path.map_or("the file".to_owned(), |p| format!("`{p}`"))
    }

    fn count<E: serde::de::Error>(self) -> Result<(), E> {
        match self.left.get().checked_sub(1) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(E::custom(format!("the file holds more than {MAX_VALUES} values"))),
        }
    }
}

impl<'de> DeserializeSeed<'de> for Any<'_> {
    type Value = Json;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Json, D::Error> {
        self.count()?;
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Any<'_> {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::from(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::from(value))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Json, E> {
        Ok(match whole(value) {
            Some(whole) => Json::from(whole),
            None => Number::from_f64(value).map_or(Json::Null, Json::Number),
        })
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Json, E> {
        if value.len() > MAX_TEXT {
            let (at, found) = (self.shown(), value.len());
            return Err(E::custom(format!("{at} is a text of {found} bytes, the limit is {MAX_TEXT}")));
        }
        Ok(Json::from(value))
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Json, A::Error> {
        let mut list = Vec::new();
        loop {
            let path = Path { up: self.path, step: PathStep::Item(list.len()) };
            match items.next_element_seed(self.below(&path))? {
                Some(item) => list.push(item),
                None => return Ok(Json::Array(list)),
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Json, A::Error> {
        let mut map = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if key.len() > MAX_KEY {
                let (at, found) = (self.shown(), key.len());
                let message = format!("{at} has a key of {found} bytes, the limit is {MAX_KEY}");
                return Err(A::Error::custom(message));
            }
            let path = Path { up: self.path, step: PathStep::Key(&key) };
            if map.contains_key(&key) {
                return Err(A::Error::custom(format!("`{path}` is written twice")));
            }
            let value = entries.next_value_seed(self.below(&path))?;
            map.insert(key, value);
        }
        Ok(Json::Object(map))
    }
}
