//! From the bytes of a text file to its text, whatever program wrote it.

use std::borrow::Cow;

/// The text of a file in UTF-8 or UTF-16, with or without a byte order mark; of XML that says so also in Latin-1.
///
/// # Errors
/// Says where the bytes are no text of the encoding.
pub(super) fn text(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => utf8(rest),
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        // Every text of these formats begins with a character of ASCII.
        [b'<' | b'{' | b'[' | b' ' | b'\r' | b'\n', 0, ..] => utf16(bytes, u16::from_le_bytes),
        [0, b'<' | b'{' | b'[' | b' ' | b'\r' | b'\n', ..] => utf16(bytes, u16::from_be_bytes),
        _ if says_latin(bytes) && std::str::from_utf8(bytes).is_err() => {
            Ok(bytes.iter().map(|b| char::from(*b)).collect())
        }
        _ => utf8(bytes),
    }
}

fn utf8(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    let text = std::str::from_utf8(bytes);
    text.map(Cow::Borrowed).map_err(|e| format!("is not UTF-8 text from byte {} on", e.valid_up_to()))
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<Cow<'static, str>, String> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(format!("is UTF-16 text of an odd number of bytes, {}", bytes.len()));
    }
    let characters = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    let text = characters.collect::<Result<String, _>>();
    text.map(Cow::Owned)
        .map_err(|e| format!("is not UTF-16 text: half a pair, {:04x}", e.unpaired_surrogate()))
}

/// Whether the head of an XML file names an encoding whose bytes are the first characters of Unicode.
fn says_latin(bytes: &[u8]) -> bool {
    let head = bytes.get(..bytes.len().min(128)).unwrap_or_default();
    let head = String::from_utf8_lossy(head).to_ascii_lowercase();
    let head = head.split("?>").next().unwrap_or_default();
    head.starts_with("<?xml")
        && ["iso-8859-1", "latin1", "latin-1", "windows-1252"].iter().any(|name| head.contains(name))
}

#[cfg(test)]
mod tests {
    use super::text;

    #[test]
    fn reads_every_encoding_that_programs_write() {
        let told = "{\"é\": \"𝄞\"}";
        let little: Vec<u8> = told.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = told.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
        for bytes in [
            told.as_bytes().to_vec(),
            marked(&[0xEF, 0xBB, 0xBF], told.as_bytes()),
            marked(&[0xFF, 0xFE], &little),
            marked(&[0xFE, 0xFF], &big),
            little.clone(),
            big,
        ] {
            assert_eq!(text(&bytes).as_deref(), Ok(told), "{bytes:?}");
        }
        let latin = b"<?xml version='1.0' encoding='ISO-8859-1'?><a b='\xE9'/>";
        assert!(text(latin).is_ok_and(|t| t.contains("b='é'")));
        for (bytes, message) in [
            (&b"<a b='\xE9'/>"[..], "is not UTF-8 text from byte 6 on"),
            (&little[..little.len() - 1], "is UTF-16 text of an odd number of bytes, 21"),
            (&[0xFF, 0xFE, 0x00, 0xD8][..], "is not UTF-16 text: half a pair, d800"),
        ] {
            assert_eq!(text(bytes), Err(message.to_owned()));
        }
        assert_eq!(text(b"").as_deref(), Ok(""));
    }
}
