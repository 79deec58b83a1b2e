//! The cache folder: shared, warm for the next process, and safe against damage (law 7).

use std::path::Path;

use orograph::engine::{Engine, Files, Options};
use orograph::value::Grid;
use serde_json::json;

use super::{bits, chain, engine, evaluate, field, graph, grid, ran};

fn with_cache(folder: &Path) -> Engine {
    let options = Options { threads: 2, cache: Some(folder.to_owned()), ..Options::default() };
    Engine::new(&options, Files::default()).unwrap()
}

fn cache_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    files
}

#[test]
fn cache_folders_serve_the_next_engine() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let cold = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 257));
    let warm = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 257));
    assert_eq!(ran(&warm), [""; 0]);
    assert_eq!(warm.tasks[0].cached, Some("disk"));
    assert_eq!(bits(&field(&cold, 0)), bits(&field(&warm, 0)));
}

#[test]
fn cache_folders_serve_parts_of_their_windows() {
    let folder = tempfile::tempdir().unwrap();
    // Both read `hills`, one of them further around: what `hills` is asked for hangs on which of them runs.
    let wide_and_near = |radius: f64| {
        graph(json!({
            "hills": { "kind": "waves", "set": { "height": 200, "seed": 7 } },
            "wide": { "kind": "smooth", "set": { "radius": 400 }, "in": { "field": "hills.field" } },
            "near": { "kind": "smooth", "set": { "radius": radius }, "in": { "field": "hills.field" } },
            "end": { "kind": "sum", "in": { "a": "wide.field", "b": "near.field" } },
        }))
    };
    let first = wide_and_near(100.0);
    let window = Grid { col: 20, row: 10, cols: 33, rows: 33, ..grid(&first, 129) };
    evaluate(&with_cache(folder.path()), &first, "end", window);
    let second = wide_and_near(150.0);
    let warm = evaluate(&with_cache(folder.path()), &second, "end", window);
    assert_eq!(ran(&warm), ["end", "near"]);
    let cold = evaluate(&engine(2), &second, "end", window);
    assert_eq!(bits(&field(&warm, 0)), bits(&field(&cold, 0)));
}

#[test]
fn cache_folders_with_damaged_files_are_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let cold = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    for (i, path) in cache_files(folder.path()).into_iter().enumerate() {
        let mut bytes = std::fs::read(&path).unwrap();
        match i % 4 {
            0 => bytes.truncate(bytes.len() / 2),
            1 => bytes.clear(),
            2 => *bytes.last_mut().unwrap() ^= 1,
            _ => {
                let middle = bytes.len() / 2;
                bytes[middle] ^= 0x40;
            }
        }
        std::fs::write(&path, bytes).unwrap();
    }
    let again = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    assert_eq!(bits(&field(&cold, 0)), bits(&field(&again, 0)));
    assert!(ran(&again).contains(&"end"));
    let warm = evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129));
    assert_eq!(ran(&warm), [""; 0], "the folder is whole again");
}

#[test]
fn cache_folders_are_shared_by_many_engines() {
    let folder = tempfile::tempdir().unwrap();
    let g = chain();
    let alone = bits(&field(&evaluate(&engine(1), &g, "end", grid(&g, 129)), 0));
    std::thread::scope(|scope| {
        let run = || {
            (0..5)
                .map(|_| bits(&field(&evaluate(&with_cache(folder.path()), &g, "end", grid(&g, 129)), 0)))
                .collect::<Vec<_>>()
        };
        let all: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        for one in all.into_iter().flat_map(|t| t.join().unwrap()) {
            assert_eq!(one, alone);
        }
    });
    let left = cache_files(folder.path());
    assert!(left.iter().all(|p| !p.file_name().unwrap().to_string_lossy().starts_with(".tmp")), "{left:?}");
}
