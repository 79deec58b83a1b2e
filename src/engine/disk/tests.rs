use std::io::Read;
use std::sync::Arc;

use super::*;
use crate::node::Summary;
use crate::nodes::Registry;
use crate::ports::Wires;
use crate::value::{Field, Quantity, Terrain, Value};

fn key() -> Key {
    let terrain = Terrain::default();
    let registry = Registry::standard();
    let kind = registry.find("constant").expect("a kind");
    let node = kind.parse(&serde_json::Map::new()).expect("defaults");
    let (node, parameters) = (&*node, &kind.digest(&*node));
    crate::engine::key::Parts { kind, node, parameters, terrain: &terrain, inputs: &[], files: &[] }.key()
}

fn grid() -> Grid {
    let lattice = Lattice { origin: [-3.0, 4.5], span: 64.0, intervals: 8 };
    Grid { lattice, col: -1, row: 2, cols: 3, rows: 2 }
}

fn wires() -> Given {
    let data = vec![1.5, -2.0, 0.0, 1e9, 3.25, -0.5];
    let mut wires = Wires::default();
    wires.put("field", Value::Field(Field::new(grid(), Quantity::Slope, data)));
    Given::Wires(wires)
}

fn written(given: &Given) -> Vec<u8> {
    let mut bytes = Vec::new();
    entry::write(&mut bytes, &key(), given).expect("memory takes all");
    assert_eq!(bytes.len() as u64, entry::size(&key(), given).expect("adds up"));
    bytes
}

fn read(bytes: &[u8]) -> io::Result<Given> {
    let registry = Registry::standard();
    let kind = registry.find("constant").expect("a kind");
    entry::read(bytes, bytes.len() as u64, &key(), &grid(), kind)
}

/// The bytes of a file, but for the key, which stands for what the result depends on: who changes them raises the
/// number of the form, so that no program reads another's.
#[cfg(target_endian = "little")]
#[test]
fn the_form_of_a_file_has_its_number() {
    let name = key().to_string();
    let both = [wires(), Given::Summary(Summary(Arc::new([0.5, -7.0])))].map(|given| {
        let text: Vec<u8> = written(&given);
        let at = text.windows(name.len()).position(|w| w == name.as_bytes()).expect("holds its key");
        let body = &text[..text.len() - blake3::OUT_LEN];
        [&body[..at], &body[at + name.len()..]].concat()
    });
    let quantities: Vec<_> = Quantity::ALL.iter().map(|q| q.name()).collect();
    let sum = blake3::hash(&[&both[0][..], &both[1], quantities.join(" ").as_bytes()].concat());
    assert_eq!((entry::FORM, &sum.to_hex()[..16]), (5, "95fb1179b53e9cda"));
    assert!(salt().ends_with("-5"));
}

#[test]
fn what_is_written_is_read() {
    let Given::Wires(back) = read(&written(&wires())).expect("whole") else { panic!("values") };
    let Given::Wires(first) = wires() else { panic!("values") };
    assert_eq!(back.get("field"), first.get("field"));
    let summary = Given::Summary(Summary(Arc::new([1.0, f64::MIN_POSITIVE])));
    assert!(matches!(read(&written(&summary)), Ok(Given::Summary(s)) if s.0[..] == [1.0, f64::MIN_POSITIVE]));
}

/// Every byte matters, and no damage is anything but damage: neither a panic nor memory by the word of a header.
#[test]
fn any_damage_is_noticed() {
    let whole = written(&wires());
    let is_damage = |bytes: &[u8], what: &str| {
        let error = read(bytes).map(drop).expect_err(what);
        assert_eq!(error.kind(), io::ErrorKind::InvalidData, "{what}");
    };
    for i in 0..whole.len() {
        is_damage(&whole[..i], &format!("cut to {i}"));
        for bit in 0..8 {
            let mut bytes = whole.clone();
            bytes[i] ^= 1 << bit;
            is_damage(&bytes, &format!("bit {bit} of byte {i}"));
        }
    }
    is_damage(&[&whole[..], b"x"].concat(), "longer");
}

/// A header with a right sum may say anything.
#[test]
fn a_lying_header_is_damage() {
    let whole = written(&wires());
    let (magic, start) = (15, 23);
    let length =
        <[u8; 8]>::try_from(&whole[magic..start]).map(u64::from_le_bytes).expect("eight bytes") as usize;
    let header = std::str::from_utf8(&whole[start..start + length]).expect("text");
    let samples = &whole[start + length..whole.len() - blake3::OUT_LEN];
    let with = |header: &str| {
        let length = (header.len() as u64).to_le_bytes();
        let body = [&whole[..magic], &length, header.as_bytes(), samples].concat();
        [&body[..], blake3::hash(&body).as_bytes()].concat()
    };
    assert!(read(&with(header)).is_ok());
    let huge = u64::MAX;
    for (from, to) in [
        ("\"components\":6".to_owned(), format!("\"components\":{huge}")),
        ("\"components\":6".to_owned(), format!("\"components\":{}", huge / 4 + 7)),
        ("\"components\":6".to_owned(), "\"components\":5".to_owned()),
        ("\"summary\":null".to_owned(), format!("\"summary\":{}", huge / 8 + 1)),
        ("[-1,2,3,2]".to_owned(), format!("[{},2,3,2]", i64::MIN)),
        ("[-1,2,3,2]".to_owned(), format!("[-1,{},3,2]", i64::MAX)),
        ("[-1,2,3,2]".to_owned(), format!("[-1,2,{huge},{huge}]")),
        ("[-1,2,3,2]".to_owned(), "[-1,2,6,1]".to_owned()),
        ("64.0".to_owned(), "65.0".to_owned()),
        ("\"slope\"".to_owned(), "\"steepness\"".to_owned()),
        ("\"field\"".to_owned(), "\"feeld\"".to_owned()),
    ] {
        let lie = header.replace(&from, &to);
        assert_ne!(lie, header, "{from}");
        assert_eq!(read(&with(&lie)).map(drop).expect_err(&to).kind(), io::ErrorKind::InvalidData, "{to}");
    }
}

/// Found by fuzzing: numbers that are not finite, under a right sum.
#[test]
fn what_is_not_finite_is_damage() {
    let summary = Given::Summary(Summary(Arc::new([0.5, -7.0])));
    for (given, number) in
        [(wires(), f32::NAN.to_ne_bytes().to_vec()), (summary, f64::INFINITY.to_ne_bytes().to_vec())]
    {
        let mut bytes = written(&given);
        let end = bytes.len() - blake3::OUT_LEN;
        bytes[end - number.len()..end].copy_from_slice(&number);
        let sum = blake3::hash(&bytes[..end]);
        bytes[end..].copy_from_slice(sum.as_bytes());
        assert_eq!(read(&bytes).map(drop).expect_err("no result").kind(), io::ErrorKind::InvalidData);
    }
}

/// A disk that fails says nothing about the file: only damage removes it.
#[test]
fn passing_faults_are_told_from_damage() {
    struct Fails(usize, Vec<u8>);
    impl Read for Fails {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            if self.0 >= 40 {
                return Err(io::Error::other("a disk that fails"));
            }
            let n = out.len().min(40 - self.0);
            out[..n].copy_from_slice(&self.1[self.0..self.0 + n]);
            self.0 += n;
            Ok(n)
        }
    }
    let whole = written(&wires());
    let registry = Registry::standard();
    let kind = registry.find("constant").expect("a kind");
    let size = whole.len() as u64;
    let error = entry::read(Fails(0, whole), size, &key(), &grid(), kind).map(drop).expect_err("fails");
    assert_eq!(error.to_string(), "a disk that fails");

    let folder = tempfile::tempdir().expect("a folder");
    let disk = Disk::open(folder.path(), 1 << 20).expect("opens");
    disk.put(&key(), &grid(), &wires());
    let path = disk.find(&key(), &grid()).expect("was written");
    assert!(disk.get(&path, &key(), &grid(), kind).is_ok());
    fs::remove_file(&path).expect("is there");
    fs::create_dir(&path).expect("a folder in its place");
    assert!(disk.get(&path, &key(), &grid(), kind).is_err() && path.is_dir());
    fs::remove_dir(&path).expect("is empty");
    fs::write(&path, "damaged").expect("writes");
    assert_eq!(disk.find(&key(), &grid()), None, "it is not tried again");
    assert!(disk.get(&path, &key(), &grid(), kind).is_err() && !path.exists(), "damage is removed");
    disk.put(&key(), &grid(), &wires());
    assert!(disk.find(&key(), &grid()).is_some(), "what this process wrote itself can be used");
}
