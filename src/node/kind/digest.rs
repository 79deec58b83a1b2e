//! The hash of a JSON value by what it means: numbers by their bits, texts and lists with their lengths. Texts of numbers
//! take most of the time where a parameter has a hundred thousand of them.

use serde_json::Value as Json;

/// The hash; −0 counts as 0.
pub(super) fn of(value: &Json) -> [u8; 32] {
    let mut bytes = Vec::new();
    write(value, &mut bytes);
    *blake3::hash(&bytes).as_bytes()
}

/// Every part begins with a letter and has its length, so that no two values have the same bytes.
fn write(value: &Json, out: &mut Vec<u8>) {
    match value {
        Json::Null => out.push(b'n'),
        Json::Bool(flag) => out.push(if *flag { b't' } else { b'f' }),
        Json::Number(number) if number.is_f64() => {
            out.push(b'd');
            let bits = (number.as_f64().unwrap_or_default() + 0.0).to_bits();
            out.extend_from_slice(&bits.to_le_bytes());
        }
        Json::Number(number) => text(b'i', &number.to_string(), out),
        Json::String(written) => text(b's', written, out),
        Json::Array(items) => {
            length(b'a', items.len(), out);
            items.iter().for_each(|item| write(item, out));
        }
        Json::Object(members) => {
            length(b'o', members.len(), out);
            for (name, member) in members {
                text(b's', name, out);
                write(member, out);
            }
        }
    }
}

fn text(letter: u8, text: &str, out: &mut Vec<u8>) {
    length(letter, text.len(), out);
    out.extend_from_slice(text.as_bytes());
}

fn length(letter: u8, length: usize, out: &mut Vec<u8>) {
    out.push(letter);
    out.extend_from_slice(&(length as u64).to_le_bytes());
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
