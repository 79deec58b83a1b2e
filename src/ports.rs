//! Typed ports: what a node takes and gives.

use crate::error::{Error, Result};
use crate::name::Name;
use crate::value::{Colors, Field, Object, Quantity, Value, Vectors, WireType};

/// One input or output of a kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name, unique among the inputs or outputs of the kind.
    pub name: Name,
    /// What it carries, one sentence.
    pub doc: Name,
    /// The type of wire that fits.
    pub wire: WireType,
    /// Whether an input must be connected.
    pub required: bool,
    /// What the numbers of an output mean; an input takes any.
    pub meaning: Meaning,
}

/// What says what the numbers of an output mean.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// They mean the same whatever the node is set to and reads.
    Fixed(Quantity),
    /// They mean what those of an input mean; [`Quantity::Number`] where it is not connected.
    Like(Name),
    /// Parameters or several inputs decide: see `Node::quantity`.
    Chosen,
    /// It has no numbers.
    Nothing,
}

impl Meaning {
    /// As [`Meaning::Like`], of a port that a kind names in its source.
    pub const fn like(input: &'static str) -> Self {
        Self::Like(Name::new_static(input))
    }
}

/// The input that every kind gets whose result the engine mixes with its input.
pub const MASK: Port = Port {
    name: Name::new_static("mask"),
    doc: Name::new_static(
        "Where the change applies: 0 keeps the input, 1 takes the result, between mixes the two.",
    ),
    wire: WireType::Field,
    required: false,
    meaning: Meaning::Fixed(Quantity::Mask),
};

/// Values by port name.
#[derive(Clone, Debug, Default)]
pub struct Wires(Vec<(Name, Value)>);

impl Wires {
    /// Adds or replaces the value of a port.
    pub fn put(&mut self, port: impl Into<Name>, value: Value) {
        let port = port.into();
        match self.0.iter_mut().find(|(name, _)| *name == port) {
            Some(slot) => slot.1 = value,
            None => self.0.push((port, value)),
        }
    }

    /// The value of a port.
    pub fn get(&self, port: &str) -> Option<&Value> {
        self.0.iter().find(|(name, _)| *name == port).map(|(_, v)| v)
    }

    /// Takes the value of a port out.
    pub fn take(&mut self, port: &str) -> Option<Value> {
        let i = self.0.iter().position(|(name, _)| *name == port)?;
        Some(self.0.swap_remove(i).1)
    }

    /// All values, in the order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (&Name, &Value)> {
        self.0.iter().map(|(name, v)| (name, v))
    }

    /// Bytes of all samples.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(|(_, v)| v.bytes()).sum()
    }
}

impl<N: Into<Name>> FromIterator<(N, Value)> for Wires {
    fn from_iter<I: IntoIterator<Item = (N, Value)>>(values: I) -> Self {
        Self(values.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }
}

/// A Rust type that can travel on a wire.
pub trait Wire: Sized {
    /// The type of wire.
    const WIRE: WireType;
    /// Whether an input of this type must be connected.
    const REQUIRED: bool = true;
    /// What the numbers of an output of this type mean where its port does not say.
    const MEANING: Meaning;
    /// Unwraps the value of a port.
    ///
    /// # Errors
    /// When the value is missing or of another type.
    fn take(port: &'static str, value: Option<Value>) -> Result<Self>;
    /// Wraps it; `None` for an absent optional output.
    fn give(self) -> Option<Value>;
}

impl<T: Object> Wire for T {
    const WIRE: WireType = WireType::Object(T::TYPE);
    const MEANING: Meaning = Meaning::Nothing;
    fn take(port: &'static str, value: Option<Value>) -> Result<Self> {
        let value = value.ok_or_else(|| Error::Missing { port: port.into() })?;
        let wrong = || Error::WireType { port: port.into(), want: Self::WIRE, got: value.wire_type() };
        value.object().cloned().ok_or_else(wrong)
    }
    fn give(self) -> Option<Value> {
        Some(self.into())
    }
}

macro_rules! wire {
    ($($name:ident: $meaning:expr),+ $(,)?) => {$(
        impl Wire for $name {
            const WIRE: WireType = WireType::$name;
            const MEANING: Meaning = $meaning;
            fn take(port: &'static str, value: Option<Value>) -> Result<Self> {
                match value {
                    Some(Value::$name(v)) => Ok(v),
                    Some(other) => Err(Error::WireType { port: port.into(), want: Self::WIRE, got: other.wire_type() }),
                    None => Err(Error::Missing { port: port.into() }),
                }
            }
            fn give(self) -> Option<Value> {
                Some(Value::$name(self))
            }
        }
    )+};
}
wire! {
    Field: Meaning::Fixed(Quantity::Number),
    Vectors: Meaning::Fixed(Quantity::Vector),
    Colors: Meaning::Fixed(Quantity::Color),
}

impl<T: Wire> Wire for Option<T> {
    const WIRE: WireType = T::WIRE;
    const REQUIRED: bool = false;
    const MEANING: Meaning = T::MEANING;
    fn take(port: &'static str, value: Option<Value>) -> Result<Self> {
        value.map(|v| T::take(port, Some(v))).transpose()
    }
    fn give(self) -> Option<Value> {
        self.and_then(T::give)
    }
}

/// A set of ports with a typed value for each: write it with [`ports!`](crate::ports!).
pub trait Ports: Sized {
    /// The ports, in declaration order.
    const PORTS: &'static [Port];
    /// Takes the values out of the wires.
    ///
    /// # Errors
    /// When a required value is missing or one is of the wrong type.
    fn take(wires: &mut Wires) -> Result<Self>;
    /// Puts the values on wires.
    fn give(self) -> Wires;
}

/// Declares port sets: structs whose fields are ports and whose doc comments document them. A field behind the type of
/// an output says what its numbers mean: `field: Field = Meaning::like("field")`.
#[macro_export]
macro_rules! ports {
    ($($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[doc = $doc:literal])+ $port:ident : $ty:ty $(= $meaning:expr)?),* $(,)?
    })+) => {$(
        $(#[$meta])*
        #[doc = concat!("Ports: `", stringify!($name), "`.")]
        $vis struct $name { $($(#[doc = $doc])+ pub $port: $ty),* }

        impl $crate::ports::Ports for $name {
            const PORTS: &'static [$crate::ports::Port] = &[$($crate::ports::Port {
                name: $crate::name::Name::new_static(stringify!($port)),
                doc: $crate::name::Name::new_static(concat!($($doc),+).trim_ascii()),
                wire: <$ty as $crate::ports::Wire>::WIRE,
                required: <$ty as $crate::ports::Wire>::REQUIRED,
                meaning: $crate::meaning!($ty $(= $meaning)?),
            }),*];
            #[allow(unused_variables, reason = "a kind without inputs takes nothing from the wires")]
            fn take(wires: &mut $crate::ports::Wires) -> $crate::error::Result<Self> {
                Ok(Self {
                    $($port: <$ty as $crate::ports::Wire>::take(stringify!($port), wires.take(stringify!($port)))?),*
                })
            }
            fn give(self) -> $crate::ports::Wires {
                [$((stringify!($port), <$ty as $crate::ports::Wire>::give(self.$port))),*]
                    .into_iter()
                    .filter_map(|(name, value): (&'static str, Option<$crate::value::Value>)| Some((name, value?)))
                    .collect()
            }
        }
    )+};
}

/// What an output says of its numbers, or what its type says.
#[doc(hidden)]
#[macro_export]
macro_rules! meaning {
    ($ty:ty) => {
        <$ty as $crate::ports::Wire>::MEANING
    };
    ($ty:ty = $meaning:expr) => {
        $meaning
    };
}
