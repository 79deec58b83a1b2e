//! The hash of parameters in keys: that of the canonical form, as it has been since keys were first kept on disk.

use std::collections::BTreeMap;

use orograph::node::{AnyNode, Kind};
use orograph::nodes::Registry;
use orograph::prelude::*;
use orograph::widget::Widget;
use serde::Serializer;
use serde::ser::{SerializeMap as _, SerializeSeq as _};
use serde_json::{Value as Json, json};

use crate::rig::{sets, shipped};

/// The bytes of a value: numbers by their bits, texts and lists with their lengths.
fn write(value: &Json, out: &mut Vec<u8>) {
    let text = |letter: u8, text: &str, out: &mut Vec<u8>| {
        out.push(letter);
        out.extend((text.len() as u64).to_le_bytes());
        out.extend(text.bytes());
    };
    match value {
        Json::Null => out.push(b'n'),
        Json::Bool(flag) => out.push(if *flag { b't' } else { b'f' }),
        Json::Number(number) if number.is_f64() => {
            out.push(b'd');
            out.extend((number.as_f64().unwrap() + 0.0).to_bits().to_le_bytes());
        }
        Json::Number(number) => text(b'i', &number.to_string(), out),
        Json::String(written) => text(b's', written, out),
        Json::Array(items) => {
            out.push(b'a');
            out.extend((items.len() as u64).to_le_bytes());
            items.iter().for_each(|item| write(item, out));
        }
        Json::Object(members) => {
            out.push(b'o');
            out.extend((members.len() as u64).to_le_bytes());
            for (name, member) in members {
                text(b's', name, out);
                write(member, out);
            }
        }
    }
}

/// The hash of the canonical form, without the names of files.
fn digest(kind: &Kind, node: &dyn AnyNode) -> [u8; 32] {
    let mut json = node.canonical();
    for file in kind.params().iter().filter(|p| p.widget == Some(Widget::File)) {
        json.as_object_mut().unwrap().remove(&file.name);
    }
    let mut bytes = Vec::new();
    write(&json, &mut bytes);
    *blake3::hash(&bytes).as_bytes()
}

#[test]
fn digests_of_all_kinds_are_those_of_the_canonical_form() {
    let mut tried = 0;
    for kind in shipped() {
        let examples = kind.params().iter().filter_map(|p| Some([(p.name.clone(), p.example.clone()?)]));
        let examples = examples.map(|one| one.into_iter().collect());
        for set in sets::all(kind).into_iter().chain(examples) {
            let Ok(node) = kind.parse(&set) else { continue };
            assert_eq!(kind.digest(&*node), digest(kind, &*node), "{}: {}", kind.id, Json::Object(set));
            tried += 1;
        }
    }
    assert!(tried > 1000, "{tried}");
}

#[test]
fn digests_of_many_numbers_are_hashed_block_by_block() {
    let registry = Registry::standard();
    let kind = registry.find("paint_mask").unwrap();
    let path: Vec<f64> = (0..8192).map(|i| f64::from(i) * 0.25 - 77.0).collect();
    let strokes: Vec<_> = (0..13).map(|k| json!({ "path": path, "radius": 60 + k })).collect();
    let set = json!({ "strokes": strokes });
    let node = kind.parse(set.as_object().unwrap()).unwrap();
    assert_eq!(kind.digest(&*node), digest(kind, &*node));
}

/// A node whose lists and maps say how long they are, do not, or lie.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
struct Odd {
    numbers: Vec<f64>,
    mode: u32,
}

impl Serialize for Odd {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self.mode {
            0 => map.serialize_entry("unsaid", &Unsaid(&self.numbers))?,
            1 => map.serialize_entry("numbered", &BTreeMap::from([(7, -0.0), (8, 1.5)]))?,
            _ => map.serialize_entry("lie", &Lie(&self.numbers))?,
        }
        map.serialize_entry("after", &(1_u8, 'x', Some("y"), f64::NAN, 0.5_f32))?;
        map.end()
    }
}

struct Unsaid<'a>(&'a [f64]);

impl Serialize for Unsaid<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(None)?;
        self.0.iter().try_for_each(|n| seq.serialize_element(n))?;
        seq.end()
    }
}

struct Lie<'a>(&'a [f64]);

impl Serialize for Lie<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(Some(self.0.len() + 1))?;
        self.0.iter().try_for_each(|n| seq.serialize_element(n))?;
        seq.end()
    }
}

ports! {
    struct Nothing {}
    struct Out {
        /// A field.
        field: Field,
    }
}

impl Node for Odd {
    type In = Nothing;
    type Out = Out;
    const META: Meta = Meta::new();

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn run(&self, cx: &Context<'_>, _: Nothing) -> Result<Out> {
        Ok(Out { field: Field::constant(cx.grid, Quantity::Number, 0.0) })
    }
}

#[test]
fn digests_of_odd_nodes_are_those_of_the_canonical_form() {
    let kind = Kind::of::<Odd>("test", "odd");
    let numbers: Vec<f64> = (0..20_000).map(f64::from).collect();
    for mode in 0..3 {
        let node = Odd { numbers: numbers.clone(), mode };
        assert_eq!(AnyNode::digest(&node), digest(&kind, &node), "{mode}");
    }
}
