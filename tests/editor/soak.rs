//! A day at random; a long one with `OROGRAPH_SOAK=100000 cargo test --test editor soak -- --nocapture`.

use eframe::egui::{Key, Modifiers};
use orograph::kit::hash;

use super::{Window, ground, preset};

/// Edits where nothing else is asked for, and how often they are evaluated to the end.
const EDITS: u64 = 300;
const SETTLE: u64 = 5_000;

#[test]
fn random_edits_end_with_flat_memory_and_can_be_undone() {
    let asked = std::env::var("OROGRAPH_SOAK").ok();
    edits(asked.map_or(EDITS, |text| text.parse().unwrap()));
}

fn edits(count: u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::on(&preset(folder.path()));
    window.settle();
    let (bytes, mut early) = (window.graph().to_bytes(), None);
    for k in 0..count {
        edit(&mut window, k);
        if window.graph().nodes().len() > 60 {
            // Back to a small graph, so that what grows is a leak.
            window.keys(Modifiers::COMMAND, Key::A);
            window.key(Key::Delete);
        }
        if k % SETTLE == SETTLE - 1 {
            window.settle();
            let now = resident();
            let early = *early.get_or_insert(now);
            println!("{k}: {} MB", now >> 20);
            assert!(now < early + (128 << 20), "{k}: {now} bytes, early on {early}");
        }
    }
    window.settle();
    // The history keeps a thousand states.
    if count < 1000 {
        let (_, at) = window.editor().document().states();
        for _ in 0..at {
            window.keys(Modifiers::COMMAND, Key::Z);
        }
        assert_eq!(window.graph().to_bytes(), bytes, "undone to the same bytes");
    }
}

/// One edit; which is up to the counter.
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

/// Bytes of the process that are in memory.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|p| p.parse::<u64>().ok()).unwrap_or(0) * 4096
}
