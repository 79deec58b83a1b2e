//! Typed ports: what a node takes and gives.

use crate::node::{Error, Result};
use crate::value::{Colors, Constraints, Curves, Field, Value, Vectors, WireType};

/// One input or output of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name, unique among the inputs or outputs of the kind.
    pub name: &'static str,
    /// What it carries, one sentence.
    pub doc: &'static str,
    /// The type of wire that fits.
    pub wire: WireType,
    /// Whether an input must be connected.
    pub required: bool,
}

/// The input that every kind gets whose result the engine mixes with its input.
pub const MASK: Port = Port {
    name: "mask",
    doc: "Where the change applies: 0 keeps the input, 1 takes the result, between mixes the two.",
    wire: WireType::Field,
    required: false,
};

/// Values by port name.
#[derive(Clone, Debug, Default)]
pub struct Wires(Vec<(&'static str, Value)>);

impl Wires {
    /// Adds or replaces the value of a port.
    pub fn put(&mut self, port: &'static str, value: Value) {
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
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.0.iter().map(|(name, v)| (*name, v))
    }

    /// Bytes of all samples.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(|(_, v)| v.bytes()).sum()
    }
}

impl FromIterator<(&'static str, Value)> for Wires {
    fn from_iter<I: IntoIterator<Item = (&'static str, Value)>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

/// A Rust type that can travel on a wire.
pub trait Wire: Sized {
    /// The type of wire.
    const WIRE: WireType;
    /// Whether an input of this type must be connected.
    const REQUIRED: bool = true;
    /// Unwraps the value of a port.
    ///
    /// # Errors
    /// When the value is missing or of another type.
    fn take(port: &'static str, value: Option<Value>) -> Result<Self>;
    /// Wraps it; `None` for an absent optional output.
    fn give(self) -> Option<Value>;
}

macro_rules! wire {
    ($($name:ident),+) => {$(
        impl Wire for $name {
            const WIRE: WireType = WireType::$name;
            fn take(port: &'static str, value: Option<Value>) -> Result<Self> {
                match value {
                    Some(Value::$name(v)) => Ok(v),
                    Some(other) => Err(Error::WireType { port, want: Self::WIRE, got: other.wire_type() }),
                    None => Err(Error::Missing { port }),
                }
            }
            fn give(self) -> Option<Value> {
                Some(Value::$name(self))
            }
        }
    )+};
}
wire!(Field, Vectors, Colors, Curves, Constraints);

impl<T: Wire> Wire for Option<T> {
    const WIRE: WireType = T::WIRE;
    const REQUIRED: bool = false;
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

/// Declares port sets: structs whose fields are ports and whose doc comments document them.
#[macro_export]
macro_rules! ports {
    ($($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[doc = $doc:literal])+ $port:ident : $ty:ty),* $(,)?
    })+) => {$(
        $(#[$meta])*
        #[doc = concat!("Ports: `", stringify!($name), "`.")]
        $vis struct $name { $($(#[doc = $doc])+ pub $port: $ty),* }

        impl $crate::ports::Ports for $name {
            const PORTS: &'static [$crate::ports::Port] = &[$($crate::ports::Port {
                name: stringify!($port),
                doc: concat!($($doc),+).trim_ascii(),
                wire: <$ty as $crate::ports::Wire>::WIRE,
                required: <$ty as $crate::ports::Wire>::REQUIRED,
            }),*];
            #[allow(unused_variables, reason = "a kind without inputs takes nothing from the wires")]
            fn take(wires: &mut $crate::ports::Wires) -> $crate::node::Result<Self> {
                Ok(Self {
                    $($port: <$ty as $crate::ports::Wire>::take(stringify!($port), wires.take(stringify!($port)))?),*
                })
            }
            fn give(self) -> $crate::ports::Wires {
                [$((stringify!($port), <$ty as $crate::ports::Wire>::give(self.$port))),*]
                    .into_iter()
                    .filter_map(|(name, value): (_, Option<$crate::value::Value>)| Some((name, value?)))
                    .collect()
            }
        }
    )+};
}
