//! The parts of a `GeoJSON` file, read as leniently as can be: what is not as it should be is kept as what it is, and
//! costs its own line alone.
//!
//! Nothing is kept of what nobody asks for, and a position takes 32 bytes.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::crs::Said;
use crate::files::vectors::{MAX_POSITIONS, Watch, short, too_many};
use crate::value::curves::CurveError;

/// Most values of a file that are kept at once.
const MAX_VALUES: usize = 4 * MAX_POSITIONS;

/// A value of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    Null,
    Flag(bool),
    Number(f64),
    Text(Box<str>),
    /// One to three numbers.
    Position([f64; 3], u8),
    List(Vec<Self>),
    Object,
}

impl Item {
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn list(&self) -> Option<&[Self]> {
        match self {
            Self::List(items) => Some(items),
            _ => None,
        }
    }

    /// Its numbers, where it is a list of nothing else.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::Position(numbers, n) => Some(numbers[..usize::from(*n)].to_vec()),
            Self::List(items) => {
                let number = |item: &Self| if let Self::Number(n) = item { Some(*n) } else { None };
                items.iter().map(number).collect()
            }
            _ => None,
        }
    }

    /// East, north and height, where it is a position.
    pub(super) fn position(&self) -> Option<([f64; 2], Option<f64>)> {
        match self {
            Self::Position(at, n) if *n > 1 => Some(([at[0], at[1]], (*n > 2).then_some(at[2]))),
            Self::List(_) => match self.numbers()?.as_slice() {
                [east, north, up, ..] => Some(([*east, *north], Some(*up))),
                _ => None,
            },
            _ => None,
        }
    }
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => write!(f, "\"{}\"", short(text)),
            Self::Position(numbers, n) => write!(f, "{:?}", &numbers[..usize::from(*n)]),
            Self::List(items) => write!(f, "a list of {}", items.len()),
            Self::Object => f.write_str("an object"),
        }
    }
}

/// A geometry as the file has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Geometry {
    pub(super) kind: Option<Item>,
    pub(super) coordinates: Option<Item>,
    pub(super) geometries: Option<Vec<Member<Self>>>,
    pub(super) lies: Said,
}

/// A feature as the file has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Feature {
    pub(super) geometry: Option<Member<Geometry>>,
    /// The geometry of JSON-FG, which is the one in the file's own system.
    pub(super) place: Option<Member<Geometry>>,
    pub(super) lies: Said,
    /// Those that somebody asks for.
    pub(super) properties: BTreeMap<String, Item>,
    pub(super) id: Option<Item>,
}

/// An object that should be there, or what stands in its place.
#[derive(Clone, Debug)]
pub(super) enum Member<T> {
    Here(T),
    Other(Item),
}

/// What reading a file has at hand.
pub(super) struct ItemContext<'a> {
    pub(super) watch: Watch<'a>,
    /// Names of the properties that somebody asks for.
    pub(super) asked: BTreeSet<String>,
    pub(super) state: RefCell<State>,
}

/// How far reading has come.
#[derive(Debug, Default)]
pub(super) struct State {
    /// Values of lists so far.
    values: usize,
    /// Why it stopped.
    pub(super) stopped: Option<CurveError>,
}

impl ItemContext<'_> {
    /// One more value of a list.
    pub(super) fn count<E: serde::de::Error>(&self) -> Result<(), E> {
        let mut state = self.state.borrow_mut();
        state.values += 1;
        let values = state.values;
        let fits = self.watch.at(values).and_then(|()| too_many("values in the file", MAX_VALUES, values));
        drop(state);
        fits.map_err(|error| self.stop(error))
    }

    /// Notes why reading stops.
    pub(super) fn stop<E: serde::de::Error>(&self, error: CurveError) -> E {
        self.state.borrow_mut().stopped = Some(error);
        E::custom("stopped")
    }
}

/// What is made of a value of the file, whatever it is.
pub(super) trait Take<'de>: Sized {
    type Made;

    fn cx(&self) -> &ItemContext<'_>;

    /// Of what is neither a list nor an object.
    fn other(self, item: Item) -> Self::Made;

    fn list<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Made, A::Error> {
        let item = AnItem(self.cx()).list(list)?;
        Ok(self.other(item))
    }

    fn object<A: MapAccess<'de>>(self, mut object: A) -> Result<Self::Made, A::Error> {
        while object.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(self.other(Item::Object))
    }
}

/// Hands a value of any type on.
pub(super) struct Any<T>(pub(super) T);

impl<'de, T: Take<'de>> DeserializeSeed<'de> for Any<T> {
    type Value = T::Made;
    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<T::Made, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de, T: Take<'de>> Visitor<'de> for Any<T> {
    type Value = T::Made;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }
    fn visit_unit<E>(self) -> Result<T::Made, E> {
        Ok(self.0.other(Item::Null))
    }
    fn visit_bool<E>(self, flag: bool) -> Result<T::Made, E> {
        Ok(self.0.other(Item::Flag(flag)))
    }
    fn visit_f64<E>(self, number: f64) -> Result<T::Made, E> {
        Ok(self.0.other(Item::Number(number)))
    }
    fn visit_i64<E>(self, number: i64) -> Result<T::Made, E> {
        Ok(self.0.other(Item::Number(number as f64)))
    }
    fn visit_u64<E>(self, number: u64) -> Result<T::Made, E> {
        Ok(self.0.other(Item::Number(number as f64)))
    }
    fn visit_str<E>(self, text: &str) -> Result<T::Made, E> {
        let text: String = text.chars().take(256).collect();
        Ok(self.0.other(Item::Text(text.into())))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T::Made, A::Error> {
        self.0.list(list)
    }
    fn visit_map<A: MapAccess<'de>>(self, object: A) -> Result<T::Made, A::Error> {
        self.0.object(object)
    }
}

/// The value as it is.
#[derive(Clone, Copy)]
pub(super) struct AnItem<'a>(pub(super) &'a ItemContext<'a>);

impl<'de> Take<'de> for AnItem<'_> {
    type Made = Item;

    fn cx(&self) -> &ItemContext<'_> {
        self.0
    }

    fn other(self, item: Item) -> Item {
        item
    }

    fn list<A: SeqAccess<'de>>(self, mut list: A) -> Result<Item, A::Error> {
        let (mut numbers, mut n) = ([0.0; 3], 0);
        let mut items = Vec::new();
        while let Some(item) = list.next_element_seed(Any(self))? {
            match item {
                Item::Number(number) if items.is_empty() && n < numbers.len() => {
                    numbers[n] = number;
                    n += 1;
                }
                item => {
                    if items.is_empty() {
                        items.extend(numbers[..n].iter().map(|number| Item::Number(*number)));
                    }
                    self.0.count::<A::Error>()?;
                    items.push(item);
                }
            }
        }
        Ok(if items.is_empty() && n > 0 { Item::Position(numbers, n as u8) } else { Item::List(items) })
    }
}

/// A member of an object whose value is still to be read.
pub(super) struct Next<'a, A> {
    pub(super) cx: &'a ItemContext<'a>,
    pub(super) key: &'a str,
    pub(super) object: &'a mut A,
}

impl<A> Next<'_, A> {
    /// The value as it is.
    pub(super) fn item<'de>(self) -> Result<Item, A::Error>
    where
        A: MapAccess<'de>,
    {
        self.object.next_value_seed(Any(AnItem(self.cx)))
    }

    /// The value as an object.
    pub(super) fn object<'de, T: Object>(self) -> Result<Member<T>, A::Error>
    where
        A: MapAccess<'de>,
    {
        self.object.next_value_seed(An::of(self.cx))
    }

    /// Leaves the value out.
    pub(super) fn skip<'de>(self) -> Result<(), A::Error>
    where
        A: MapAccess<'de>,
    {
        self.object.next_value::<IgnoredAny>().map(drop)
    }
}

/// An object that is taken up member by member.
pub(super) trait Object: Default {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error>;
}

/// An object, or what stands in its place.
pub(super) struct An<'a, T>(pub(super) &'a ItemContext<'a>, pub(super) PhantomData<T>);

impl<'a, T> An<'a, T> {
    pub(super) fn of(cx: &'a ItemContext<'a>) -> Any<Self> {
        Any(Self(cx, PhantomData))
    }
}

impl<'de, T: Object> Take<'de> for An<'_, T> {
    type Made = Member<T>;

    fn cx(&self) -> &ItemContext<'_> {
        self.0
    }

    fn other(self, item: Item) -> Member<T> {
        Member::Other(item)
    }

    fn object<A: MapAccess<'de>>(self, mut object: A) -> Result<Member<T>, A::Error> {
        let mut new = T::default();
        while let Some(key) = object.next_key::<Cow<'_, str>>()? {
            new.member(Next { cx: self.0, key: &key, object: &mut object })?;
        }
        Ok(Member::Here(new))
    }
}

impl Object for Geometry {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        match next.key {
            "type" => self.kind = Some(next.item()?),
            "coordinates" => self.coordinates = Some(next.item()?),
            "geometries" => self.geometries = next.object.next_value_seed(Any(Geometries(next.cx)))?,
            _ => self.lies.member(next)?,
        }
        Ok(())
    }
}

impl Object for Feature {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        match next.key {
            "geometry" => self.geometry = Some(next.object()?),
            "place" => self.place = Some(next.object()?),
            "id" => self.id = Some(next.item()?),
            "properties" => match next.object::<Properties>()? {
                Member::Here(Properties(asked)) => self.properties = asked,
                Member::Other(_) => self.properties.clear(),
            },
            _ => self.lies.member(next)?,
        }
        Ok(())
    }
}

/// The properties that somebody asks for.
#[derive(Clone, Debug, Default)]
pub(super) struct Properties(pub(super) BTreeMap<String, Item>);

impl Object for Properties {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        if !next.cx.asked.contains(next.key) {
            return next.skip();
        }
        let name = next.key.to_owned();
        self.0.insert(name, next.item()?);
        Ok(())
    }
}

/// The list of a collection; `None` where it is no list.
struct Geometries<'a>(&'a ItemContext<'a>);

impl<'de> Take<'de> for Geometries<'_> {
    type Made = Option<Vec<Member<Geometry>>>;

    fn cx(&self) -> &ItemContext<'_> {
        self.0
    }

    fn other(self, _: Item) -> Self::Made {
        None
    }

    fn list<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Made, A::Error> {
        let mut all = Vec::new();
        while let Some(geometry) = list.next_element_seed(An::of(self.0))? {
            self.0.count::<A::Error>()?;
            all.push(geometry);
        }
        Ok(Some(all))
    }
}
