//! Values of parameters in little memory.
//!
//! A value of JSON takes 72 bytes, so that the 100,000 numbers of a painted mask take 7 MB, and every movement of a hand
//! copied them for the history, checked them and read them anew. [`Packed`] keeps a number in 8 bytes, and copies share
//! lists and objects until one of them is changed, so that a movement costs what it moves.

use std::sync::Arc;

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{Deserializer, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Error, Map, Value as Json};

use super::{Param, Shape, check_all};
use crate::node::Result as Checked;
use crate::text::whole;

/// A value of a parameter, equal to one of JSON.
#[derive(Clone, Debug)]
pub(crate) enum Packed {
    /// A list of numbers. Whole ones are integers in JSON.
    Numbers(Arc<[f64]>),
    /// A list in which a list of numbers occurs.
    List(Arc<Vec<Self>>),
    /// An object in which a list of numbers occurs.
    Record(Record),
    /// Any other value.
    Other(Json),
}

/// Members of an object, in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record(Arc<Vec<(String, Packed)>>);

impl From<Json> for Packed {
    fn from(json: Json) -> Self {
        match json {
            Json::Array(items) => Self::list(items),
            Json::Object(members) => {
                let record = Record::from(members);
                let is_other = |(_, value): &(_, Self)| matches!(value, Self::Other(_));
                if record.0.iter().all(is_other) {
                    Self::Other(Json::Object(record.into_json()))
                } else {
                    Self::Record(record)
                }
            }
            other => Self::Other(other),
        }
    }
}

impl From<Map<String, Json>> for Record {
    fn from(members: Map<String, Json>) -> Self {
        Self(Arc::new(members.into_iter().map(|(name, value)| (name, Packed::from(value))).collect()))
    }
}

impl Packed {
    fn list(items: Vec<Json>) -> Self {
        if items.is_empty() {
            return Self::Other(Json::Array(items));
        }
        if let Some(numbers) = items.iter().map(number_of).collect::<Option<Vec<f64>>>() {
            return Self::Numbers(numbers.into());
        }
        let items: Vec<_> = items.into_iter().map(Self::from).collect();
        if items.iter().all(|item| matches!(item, Self::Other(_))) {
            return Self::Other(Json::Array(items.into_iter().map(Self::into_json).collect()));
        }
        Self::List(Arc::new(items))
    }

    /// The value in JSON.
    pub(crate) fn json(&self) -> Json {
        match self {
            Self::Numbers(numbers) => Json::Array(numbers.iter().copied().map(json_of).collect()),
            Self::List(items) => Json::Array(items.iter().map(Self::json).collect()),
            Self::Record(record) => Json::Object(record.json()),
            Self::Other(json) => json.clone(),
        }
    }

    fn into_json(self) -> Json {
        match self {
            Self::Other(json) => json,
            packed => packed.json(),
        }
    }

    /// Estimated bytes that it takes.
    fn bytes(&self) -> usize {
        match self {
            Self::Numbers(numbers) => WORD + size_of_val(&**numbers),
            Self::List(items) => WORD + items.iter().map(Self::bytes).sum::<usize>(),
            Self::Record(record) => record.bytes(),
            Self::Other(json) => bytes_of(json),
        }
    }
}

/// Estimated bytes of a number, a word or a list in JSON.
const WORD: usize = 40;

fn bytes_of(json: &Json) -> usize {
    match json {
        Json::Array(items) => WORD + items.iter().map(bytes_of).sum::<usize>(),
        Json::Object(members) => WORD + members.values().map(|v| 2 * WORD + bytes_of(v)).sum::<usize>(),
        Json::String(text) => WORD + text.len(),
        Json::Null | Json::Bool(_) | Json::Number(_) => WORD,
    }
}

impl Record {
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &Packed)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The member of a name.
    pub(crate) fn get(&self, name: &str) -> Option<&Packed> {
        self.iter().find(|(n, _)| *n == name).map(|(_, value)| value)
    }

    /// The member of a name, to be changed; where there is none, one is added.
    pub(crate) fn entry(&mut self, name: &str, new: impl FnOnce() -> Packed) -> &mut Packed {
        let members = Arc::make_mut(&mut self.0);
        let place = members.iter().position(|(n, _)| n == name).unwrap_or_else(|| {
            members.push((name.to_owned(), new()));
            members.len() - 1
        });
        &mut members[place].1
    }

    /// Estimated bytes that it takes.
    pub(crate) fn bytes(&self) -> usize {
        WORD + self.iter().map(|(_, value)| 2 * WORD + value.bytes()).sum::<usize>()
    }

    /// Removes the member of a name.
    pub(crate) fn remove(&mut self, name: &str) {
        Arc::make_mut(&mut self.0).retain(|(n, _)| n != name);
    }

    /// The object in JSON.
    pub(crate) fn json(&self) -> Map<String, Json> {
        self.iter().map(|(name, value)| (name.to_owned(), value.json())).collect()
    }

    fn into_json(self) -> Map<String, Json> {
        let members = Arc::unwrap_or_clone(self.0);
        members.into_iter().map(|(name, value)| (name, value.into_json())).collect()
    }
}

/// The number that a packed list can have for a value: one that is written in one way.
pub(crate) fn number_of(json: &Json) -> Option<f64> {
    let number = json.as_f64()?;
    (whole(number).is_some() != json.is_f64()).then_some(number)
}

fn json_of(number: f64) -> Json {
    whole(number).map_or_else(|| Json::from(number), Json::from)
}

/// A value that is looked at where it stands, packed or not.
#[derive(Clone, Copy, Debug)]
pub(crate) enum View<'a> {
    /// A value of JSON.
    Json(&'a Json),
    /// A list of numbers.
    Numbers(&'a [f64]),
    /// A number of such a list.
    Number(f64),
    /// A packed list.
    List(&'a [Packed]),
    /// A packed object.
    Record(&'a Record),
}

impl<'a> From<&'a Json> for View<'a> {
    fn from(json: &'a Json) -> Self {
        Self::Json(json)
    }
}

impl<'a> From<&'a Packed> for View<'a> {
    fn from(packed: &'a Packed) -> Self {
        match packed {
            Packed::Numbers(numbers) => Self::Numbers(numbers),
            Packed::List(items) => Self::List(items),
            Packed::Record(record) => Self::Record(record),
            Packed::Other(json) => Self::Json(json),
        }
    }
}

impl<'a> View<'a> {
    /// The member of an object.
    pub(crate) fn member(self, name: &str) -> Option<Self> {
        match self {
            Self::Json(json) => json.get(name).map(Self::Json),
            Self::Record(record) => record.get(name).map(Self::from),
            Self::Numbers(_) | Self::Number(_) | Self::List(_) => None,
        }
    }

    /// The item of a list.
    pub(crate) fn item(self, i: usize) -> Option<Self> {
        match self {
            Self::Json(json) => json.get(i).map(Self::Json),
            Self::Numbers(numbers) => numbers.get(i).copied().map(Self::Number),
            Self::List(items) => items.get(i).map(Self::from),
            Self::Number(_) | Self::Record(_) => None,
        }
    }

    /// The number of items, where it is a list.
    pub(crate) fn items(self) -> Option<usize> {
        match self {
            Self::Json(json) => json.as_array().map(Vec::len),
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::List(items) => Some(items.len()),
            Self::Number(_) | Self::Record(_) => None,
        }
    }

    /// The name of the mode that is chosen: a text, or the first name of an object.
    pub(crate) fn mode(self) -> Option<&'a str> {
        match self {
            Self::Json(Json::String(name)) => Some(name),
            Self::Json(json) => json.as_object()?.keys().next().map(String::as_str),
            Self::Record(record) => record.iter().next().map(|(name, _)| name),
            Self::Numbers(_) | Self::Number(_) | Self::List(_) => None,
        }
    }

    /// The value in JSON.
    pub(crate) fn json(self) -> Json {
        match self {
            Self::Json(json) => json.clone(),
            Self::Numbers(numbers) => Json::Array(numbers.iter().copied().map(json_of).collect()),
            Self::Number(number) => json_of(number),
            Self::List(items) => Json::Array(items.iter().map(Packed::json).collect()),
            Self::Record(record) => Json::Object(record.json()),
        }
    }

    /// Whether it equals a value of JSON, given when two of JSON are equal.
    pub(crate) fn equals(self, other: &Json, equal: fn(&Json, &Json) -> bool) -> bool {
        if let Some(len) = self.items().filter(|_| !matches!(self, Self::Json(_))) {
            let all =
                || (0..len).all(|i| self.item(i).zip(other.get(i)).is_some_and(|(a, b)| a.equals(b, equal)));
            return other.as_array().is_some_and(|items| items.len() == len) && all();
        }
        match self {
            Self::Json(json) => equal(json, other),
            Self::Record(record) => {
                let same = |(name, value): (&str, &Packed)| {
                    other.get(name).is_some_and(|other| View::from(value).equals(other, equal))
                };
                other.as_object().is_some_and(|o| o.len() == record.0.len()) && record.iter().all(same)
            }
            other_view => equal(&other_view.json(), other),
        }
    }
}

/// Checks all values that are set.
///
/// # Errors
/// Returns the errors of [`check_all`].
pub(crate) fn check(params: &[Param], set: &Record) -> Checked<()> {
    if fits_all(params, set) { Ok(()) } else { check_all(params, &set.json()) }
}

/// Whether all members fit; where not, the check in JSON has the last word and says what is wrong.
fn fits_all(params: &[Param], set: &Record) -> bool {
    let shape = |name: &str| params.iter().find(|p| p.name == name).map(|p| &p.shape);
    set.iter().all(|(name, value)| shape(name).is_some_and(|shape| fits(shape, value)))
}

fn fits(shape: &Shape, value: &Packed) -> bool {
    match (shape, value) {
        (shape, Packed::Other(json)) => shape.check(json).is_ok(),
        (Shape::Optional(inner), value) => fits(inner, value),
        (Shape::List { item, min, max }, Packed::Numbers(numbers)) => {
            (*min..=*max).contains(&numbers.len()) && fit(item, numbers)
        }
        (Shape::List { item, min, max }, Packed::List(items)) => {
            (*min..=*max).contains(&items.len()) && items.iter().all(|v| fits(item, v))
        }
        (Shape::Tuple(shapes), Packed::Numbers(numbers)) => {
            shapes.len() == numbers.len() && shapes.iter().zip(&**numbers).all(|(s, n)| fit(s, &[*n]))
        }
        (Shape::Tuple(shapes), Packed::List(items)) => {
            shapes.len() == items.len() && shapes.iter().zip(&**items).all(|(s, v)| fits(s, v))
        }
        (Shape::Record(fields), Packed::Record(record)) => fits_all(fields, record),
        _ => false,
    }
}

/// Whether all numbers fit. They are counted, because the processor compares several at once where none ends the loop.
fn fit(shape: &Shape, numbers: &[f64]) -> bool {
    let Shape::Number { min, max, integer } = shape else { return false };
    let out = numbers.iter().filter(|n| **n < *min || **n > *max).count();
    out == 0 && (!integer || numbers.iter().all(|n| whole(*n).is_some()))
}

/// A number of a list, for serde.
#[derive(Clone, Copy)]
struct Number(f64);

impl<'de> IntoDeserializer<'de, Error> for Number {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Number {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        json_of(self.0).deserialize_any(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_f64(self.0)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct
        map struct enum identifier ignored_any
    }
}

impl<'de> IntoDeserializer<'de, Error> for &'de Packed {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for &'de Packed {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Packed::Numbers(numbers) => {
                let mut items = SeqDeserializer::new(numbers.iter().map(|n| Number(*n)));
                let value = visitor.visit_seq(&mut items)?;
                items.end().map(|()| value)
            }
            Packed::List(list) => {
                let mut items = SeqDeserializer::new(list.iter());
                let value = visitor.visit_seq(&mut items)?;
                items.end().map(|()| value)
            }
            Packed::Record(record) => record.deserialize_any(visitor),
            Packed::Other(json) => json.deserialize_any(visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Packed::Other(Json::Null) => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    /// A mode with a list in it is rare and short, so that it may take the way through JSON.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self {
            Packed::Other(json) => json.deserialize_enum(name, variants, visitor),
            packed => packed.json().deserialize_enum(name, variants, visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

impl<'de> Deserializer<'de> for &'de Record {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let mut members = MapDeserializer::new(self.iter());
        let value = visitor.visit_map(&mut members)?;
        members.end().map(|()| value)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize as _;
    use serde_json::json;

    use super::*;

    #[test]
    fn a_packed_value_is_the_value() {
        let all = [
            json!(null),
            json!([]),
            json!([1, 2.5, -3]),
            json!([1.0, 2.5]),
            json!([-0.0]),
            json!([9_007_199_254_740_993_i64]),
            json!([u64::MAX, 1e300]),
            json!([[1, 2], [], ["a", { "b": [3.5] }], { "c": 1 }]),
            json!({ "path": [1, 2], "radius": 3, "name": "x", "none": null }),
            json!({ "mode": { "turned": { "angle": 3.0, "far": [1] } } }),
        ];
        for json in all {
            let packed = Packed::from(json.clone());
            assert_eq!(packed.json().to_string(), json.to_string());
            assert!(View::from(&packed).equals(&json, |a, b| a == b), "{json}");
            assert!(!View::from(&packed).equals(&json!([1, "other"]), |a, b| a == b), "{json}");
            let read = Json::deserialize(&packed);
            assert_eq!(read.ok(), Some(json));
        }
    }

    #[test]
    fn lists_of_numbers_take_little_room() {
        let numbers: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.5).collect();
        let whole = |v: &f64| if v.fract() == 0.0 { json!(*v as i64) } else { json!(v) };
        let list: Vec<Json> = numbers.iter().map(whole).collect();
        let packed = Packed::from(json!([{ "path": list }]));
        assert!(packed.bytes() < 9000, "{}", packed.bytes());
    }
}
