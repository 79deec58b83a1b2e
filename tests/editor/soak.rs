//! Random edits, at the end of which memory has not grown and everything can be undone. 300 edits run by default, 20,000
//! with `OROGRAPH_BREADTH=1`, and any number with `OROGRAPH_SOAK=100000 cargo test --test editor soak -- --nocapture`.

use std::path::Path;

use eframe::egui::{Key, Modifiers};
use orograph::kit::hash;

use super::{Window, ground, preset};

/// Number of edits by default, and with `OROGRAPH_BREADTH`.
const EDITS: [u64; 2] = [300, 20_000];
/// Edits between two measurements of memory. The graph is evaluated to the end before each.
const BETWEEN: u64 = 50;
/// Memory budget of the engine, in bytes: small, so that the first edits fill its caches and later growth is a leak.
const BUDGET: u64 = 256 << 20;
/// Bytes by which memory may exceed the first measurement, for what the allocator holds back.
const SLACK: u64 = 16 << 20;
/// Further bytes for each edit since then, and the most edits that count: the history holds a thousand states.
const STATE: u64 = 64 << 10;
const STATES: u64 = 1000;

/// Set in the process that measures.
const ALONE: &str = "OROGRAPH_SOAK_ALONE";

/// The memory of a process is that of all tests which run in it, so this one runs in a process of its own.
#[test]
fn random_edits_end_with_flat_memory_and_can_be_undone() {
    if std::env::var_os(ALONE).is_none() {
        let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
        alone.args(["--exact", "soak::random_edits_end_with_flat_memory_and_can_be_undone", "--nocapture"]);
        let done = alone.env(ALONE, "1").output().unwrap();
        let said = [done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(done.status.success(), "{}", said.concat());
        assert!(said[0].contains("1 passed"), "the test was run: {}", said[0]);
        print!("{}", said[0]);
        return;
    }
    let breadth = std::env::var_os("OROGRAPH_BREADTH").is_some_and(|v| !v.is_empty() && v != "0");
    let asked = std::env::var("OROGRAPH_SOAK").ok().map(|text| text.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let memory = edits(&preset(folder.path()), asked.unwrap_or(EDITS[usize::from(breadth)]));
    assert!(memory.len() > 2 && memory[0] > 0, "memory was measured: {memory:?}");
    assert_eq!(first_excess(&memory), None, "{memory:?}");
}

#[test]
fn memory_growth_is_found() {
    let with_leak = |bytes: u64| -> Vec<u64> { (0..6).map(|k| (100 << 20) + k * BETWEEN * bytes).collect() };
    assert_eq!(first_excess(&with_leak(STATE)), None);
    assert_eq!(first_excess(&with_leak(256 << 10)), Some(2));
    // A run that is so long that the history is full may not grow any further.
    let long: Vec<u64> = (0..100).map(|k| (100 << 20) + k * BETWEEN * STATE).collect();
    assert!(first_excess(&long).is_some());
}

/// The index of the first measurement of memory that exceeds the first one by more than is allowed for the edits between
/// them.
fn first_excess(memory: &[u64]) -> Option<usize> {
    let allowed = |i: usize| memory[0] + SLACK + STATE * STATES.min(i as u64 * BETWEEN);
    (0..memory.len()).find(|i| memory[*i] > allowed(*i))
}

/// Makes `count` random edits and undoes them; returns the bytes in memory after every [`BETWEEN`] edits.
fn edits(path: &Path, count: u64) -> Vec<u64> {
    let mut window = Window::frugal(path, BUDGET);
    window.settle();
    let (bytes, mut memory) = (window.graph().to_bytes(), Vec::new());
    for k in 0..count {
        edit(&mut window, k);
        if window.graph().nodes().len() > 60 {
            // The graph is made small again, so that memory which keeps growing is a leak.
            window.keys(Modifiers::COMMAND, Key::A);
            window.key(Key::Delete);
        }
        if k % BETWEEN == BETWEEN - 1 {
            window.settle();
            memory.push(resident());
            println!("{k}: {} MB", resident() >> 20);
        }
    }
    window.settle();
    // The history holds a thousand states, so that longer runs cannot be undone to the first.
    if count < 1000 {
        let (_, at) = window.editor().document().states();
        for _ in 0..at {
            window.keys(Modifiers::COMMAND, Key::Z);
        }
        assert_eq!(window.graph().to_bytes(), bytes, "undone to the same bytes");
    }
    memory
}

/// Makes the random edit with the number `k`.
fn edit(window: &mut Window, k: u64) {
    let dice = |n: u64| hash::nth(17, k * 8 + n);
    let place = ground((dice(1) % 880) as f32, (dice(2) % 220) as f32);
    match dice(0) % 10 {
        0 | 1 => {
            const KINDS: [&str; 6] = ["fractal_noise", "blur", "combine", "terrace", "clamp", "select_slope"];
            window.add(place, KINDS[(dice(3) % 6) as usize]);
        }
        2 | 3 => {
            let to = ground((dice(3) % 880) as f32, (dice(4) % 220) as f32);
            window.drag(&[place, to]);
            window.key(Key::Escape);
        }
        4 => window.keys(Modifiers::COMMAND, Key::Z),
        5 => window.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z),
        6 => {
            window.keys(Modifiers::COMMAND, Key::D);
        }
        7 => window.key(Key::B),
        8 => window.key(Key::Delete),
        _ => {
            window.hover(place);
            window.button(place, true);
            window.button(place, false);
            window.key(Key::L);
        }
    }
}

/// The bytes of this process that are in memory.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|p| p.parse::<u64>().ok()).unwrap_or(0) * 4096
}
