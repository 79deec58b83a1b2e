//! The hash of parameters by what they mean: numbers by their bits, texts and lists with their lengths. Texts of numbers
//! would take most of the time where a parameter has a hundred thousand of them, and so would their values of JSON, so that
//! a node is written straight into the bytes that are hashed.

use serde::ser::{self, Error as _, Serialize, Serializer};
use serde_json::{Error, Value as Json};

/// The hash of a value; −0 counts as 0.
pub(super) fn of(value: &Json) -> [u8; 32] {
    // A value of JSON can always be written: its keys are texts and its numbers finite.
    of_node(value).unwrap_or_default()
}

/// The hash of the JSON value that a node is written as.
///
/// # Errors
/// Fails where a map has keys that are no texts, and where a list has not the length that it says.
pub(super) fn of_node<T: Serialize + ?Sized>(node: &T) -> Result<[u8; 32], Error> {
    let mut sheet = Sheet { bytes: Vec::new(), hasher: blake3::Hasher::new(), waiting: 0 };
    node.serialize(Writer(&mut sheet))?;
    sheet.hasher.update(&sheet.bytes);
    Ok(*sheet.hasher.finalize().as_bytes())
}

/// What was written and not yet hashed.
struct Sheet {
    bytes: Vec<u8>,
    hasher: blake3::Hasher,
    /// The number of lists and objects around it whose length has still to be written.
    waiting: usize,
}

/// Bytes that are hashed at once: enough for the widest registers, and little enough for the nearest cache.
const BLOCK: usize = 1 << 15;

impl Sheet {
    /// Hashes whole blocks, which bounds the memory that a long list takes.
    fn turn(&mut self) {
        if self.bytes.len() >= BLOCK && self.waiting == 0 {
            self.hasher.update(&self.bytes);
            self.bytes.clear();
        }
    }
}

/// Writes a value. Every part begins with a letter and has its length, so that no two values have the same bytes.
struct Writer<'a>(&'a mut Sheet);

impl<'a> Writer<'a> {
    fn text(self, letter: u8, text: &str) {
        length(letter, text.len(), &mut self.0.bytes);
        self.0.bytes.extend_from_slice(text.as_bytes());
    }

    /// Begins a list or an object. A length that is not known is written at its end.
    fn open(self, letter: u8, len: Option<usize>) -> Open<'a> {
        let place = self.0.bytes.len() + 1;
        length(letter, len.unwrap_or(0), &mut self.0.bytes);
        self.0.waiting += usize::from(len.is_none());
        Open { sheet: self.0, told: len.ok_or(place), len: 0 }
    }

    /// Begins an object with one member.
    fn variant(self, name: &str) -> Self {
        length(b'o', 1, &mut self.0.bytes);
        Writer(&mut *self.0).text(b's', name);
        self
    }
}

fn length(letter: u8, length: usize, out: &mut Vec<u8>) {
    out.push(letter);
    out.extend_from_slice(&(length as u64).to_le_bytes());
}

/// A list or an object that is being written.
struct Open<'a> {
    sheet: &'a mut Sheet,
    /// The length that was written, or the place where it has to be.
    told: Result<usize, usize>,
    /// The number of items or members so far.
    len: usize,
}

impl Open<'_> {
    fn item<T: Serialize + ?Sized>(&mut self, item: &T) -> Result<(), Error> {
        self.len += 1;
        item.serialize(Writer(self.sheet))?;
        self.sheet.turn();
        Ok(())
    }

    fn member<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Result<(), Error> {
        Writer(self.sheet).text(b's', name);
        self.item(value)
    }

    fn close(self) -> Result<(), Error> {
        match self.told {
            Ok(told) if told == self.len => Ok(()),
            Ok(_) => Err(Error::custom("a list has not the length that it said")),
            Err(place) => {
                let len = (self.len as u64).to_le_bytes();
                self.sheet.bytes[place..place + len.len()].copy_from_slice(&len);
                self.sheet.waiting -= 1;
                Ok(())
            }
        }
    }
}

impl<'a> Serializer for Writer<'a> {
    type Ok = ();
    type Error = Error;
    type SerializeSeq = Open<'a>;
    type SerializeTuple = Open<'a>;
    type SerializeTupleStruct = Open<'a>;
    type SerializeTupleVariant = Open<'a>;
    type SerializeMap = Open<'a>;
    type SerializeStruct = Open<'a>;
    type SerializeStructVariant = Open<'a>;

    fn serialize_bool(self, v: bool) -> Result<(), Error> {
        self.0.bytes.push(if v { b't' } else { b'f' });
        Ok(())
    }

    fn serialize_i8(self, v: i8) -> Result<(), Error> {
        self.serialize_i64(v.into())
    }

    fn serialize_i16(self, v: i16) -> Result<(), Error> {
        self.serialize_i64(v.into())
    }

    fn serialize_i32(self, v: i32) -> Result<(), Error> {
        self.serialize_i64(v.into())
    }

    fn serialize_i64(self, v: i64) -> Result<(), Error> {
        self.text(b'i', &v.to_string());
        Ok(())
    }

    fn serialize_u8(self, v: u8) -> Result<(), Error> {
        self.serialize_u64(v.into())
    }

    fn serialize_u16(self, v: u16) -> Result<(), Error> {
        self.serialize_u64(v.into())
    }

    fn serialize_u32(self, v: u32) -> Result<(), Error> {
        self.serialize_u64(v.into())
    }

    fn serialize_u64(self, v: u64) -> Result<(), Error> {
        self.text(b'i', &v.to_string());
        Ok(())
    }

    fn serialize_f32(self, v: f32) -> Result<(), Error> {
        self.serialize_f64(v.into())
    }

    fn serialize_f64(self, v: f64) -> Result<(), Error> {
        // JSON has null for what is no finite number.
        if !v.is_finite() {
            return self.serialize_unit();
        }
        let mut bytes = [b'd'; 9];
        bytes[1..].copy_from_slice(&(v + 0.0).to_bits().to_le_bytes());
        self.0.bytes.extend_from_slice(&bytes);
        Ok(())
    }

    fn serialize_char(self, v: char) -> Result<(), Error> {
        self.serialize_str(v.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, v: &str) -> Result<(), Error> {
        self.text(b's', v);
        Ok(())
    }

    fn serialize_bytes(self, v: &[u8]) -> Result<(), Error> {
        v.serialize(self)
    }

    fn serialize_none(self) -> Result<(), Error> {
        self.serialize_unit()
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Error> {
        self.0.bytes.push(b'n');
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Error> {
        self.serialize_unit()
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Result<(), Error> {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Error> {
        value.serialize(self.variant(variant))
    }

    fn serialize_seq(self, len: Option<usize>) -> Result<Open<'a>, Error> {
        Ok(self.open(b'a', len))
    }

    fn serialize_tuple(self, len: usize) -> Result<Open<'a>, Error> {
        Ok(self.open(b'a', Some(len)))
    }

    fn serialize_tuple_struct(self, _: &'static str, len: usize) -> Result<Open<'a>, Error> {
        Ok(self.open(b'a', Some(len)))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Open<'a>, Error> {
        Ok(self.variant(variant).open(b'a', Some(len)))
    }

    fn serialize_map(self, len: Option<usize>) -> Result<Open<'a>, Error> {
        Ok(self.open(b'o', len))
    }

    fn serialize_struct(self, _: &'static str, len: usize) -> Result<Open<'a>, Error> {
        Ok(self.open(b'o', Some(len)))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Open<'a>, Error> {
        Ok(self.variant(variant).open(b'o', Some(len)))
    }
}

/// Lists of all types.
macro_rules! lists {
    ($($of:ident $item:ident),+) => {$(
        impl ser::$of for Open<'_> {
            type Ok = ();
            type Error = Error;

            fn $item<T: Serialize + ?Sized>(&mut self, item: &T) -> Result<(), Error> {
                self.item(item)
            }

            fn end(self) -> Result<(), Error> {
                self.close()
            }
        }
    )+};
}
lists!(
    SerializeSeq serialize_element,
    SerializeTuple serialize_element,
    SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field
);

/// Objects whose names are in the source.
macro_rules! objects {
    ($($of:ident),+) => {$(
        impl ser::$of for Open<'_> {
            type Ok = ();
            type Error = Error;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, v: &T) -> Result<(), Error> {
                self.member(name, v)
            }

            fn end(self) -> Result<(), Error> {
                self.close()
            }
        }
    )+};
}
objects!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Open<'_> {
    type Ok = ();
    type Error = Error;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Error> {
        let start = self.sheet.bytes.len();
        key.serialize(Writer(self.sheet))?;
        // JSON writes other keys as texts; such a map is hashed as it stands there.
        if self.sheet.bytes.get(start) == Some(&b's') {
            Ok(())
        } else {
            Err(Error::custom("a key is no text"))
        }
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Error> {
        self.item(value)
    }

    fn end(self) -> Result<(), Error> {
        self.close()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn one_value_has_one_hash_and_two_values_have_two() {
        assert_eq!(of(&json!({ "a": -0.0 })), of(&json!({ "a": 0.0 })));
        let all = [
            json!(null),
            json!(false),
            json!(0),
            json!(0.0),
            json!("0"),
            json!([]),
            json!({}),
            json!(["a", "b"]),
            json!(["ab"]),
            json!([["a"], "b"]),
            json!([["a", "b"]]),
            json!({ "a": "b" }),
            json!({ "ab": "" }),
            json!(1.0),
            json!(1.000_000_000_000_000_2),
        ];
        for (i, one) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| of(one) != of(other)), "{one}");
        }
    }
}
