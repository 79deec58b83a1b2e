//! Tests of the editor: clicks, drags and typed text, and the document that results.
#![allow(clippy::unwrap_used, reason = "a test stops where something fails")]

#[path = "../it/graph/weighted.rs"]
mod weighted;

mod access;
mod canvas;
mod drawing;
mod files;
mod panels;
mod pictures;
#[path = "../it/rig/skip.rs"]
mod skip;
mod soak;
mod view;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, OutputCommand, PointerButton, Pos2, Rect, Shape, pos2, vec2};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use eframe::wgpu::DeviceType;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use orograph::editor::{Answer, Editor, Setup};
use orograph::engine::Options;
use orograph::graph::Graph;

/// A window with an editor, which exists from the first frame on. The flag says whether a software device draws the
/// window, whose pictures are the same on every machine.
pub(crate) struct Window(Harness<'static, Option<Editor>>, bool);

/// Time after which a condition that does not come about fails a test. A busy machine takes far less for any evaluation.
const PATIENCE: Duration = Duration::from_secs(900);

pub(crate) const PRESET: &str = "graphs/first_light.graph";

/// A copy of a preset in a folder of its own.
pub(crate) fn preset(folder: &Path) -> PathBuf {
    let path = folder.join("first_light.graph");
    std::fs::copy(PRESET, &path).unwrap();
    path
}

impl Window {
    pub(crate) fn empty() -> Self {
        Self::of(Setup { home: None, asker: Box::new(|_, _, _| Answer::known(None)), ..Setup::default() })
    }

    pub(crate) fn on(path: &Path) -> Self {
        let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
        Self::of(Setup { path: Some(path.to_owned()), home: None, asker, ..Setup::default() })
    }

    pub(crate) fn of(setup: Setup) -> Self {
        Self::with(setup, None, 1.0)
    }

    /// A window as at the first start of the program, with a device to draw with.
    pub(crate) fn fresh() -> Self {
        let device = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
        let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
        let setup = Setup { asker, format: Some(device.target_format), ..Setup::default() };
        let mut window = Self::start(setup, Some(device), 1.0);
        window.0.set_size(vec2(960.0, 600.0));
        window.steps(5);
        window
    }

    /// A window on a file, with a memory budget of the engine in bytes.
    pub(crate) fn frugal(path: &Path, memory: u64) -> Self {
        let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
        let options = Options { memory, ..Options::default() };
        Self::of(Setup { path: Some(path.to_owned()), home: None, asker, options, ..Setup::default() })
    }

    /// A window on a file, on a screen with a number of pixels per point.
    pub(crate) fn dense(path: &Path, density: f32) -> Self {
        let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
        let setup = Setup { path: Some(path.to_owned()), home: None, asker, ..Setup::default() };
        Self::with(setup, None, density)
    }

    /// A window on a file, with a device to draw with.
    pub(crate) fn drawn(path: &Path) -> Self {
        let device = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
        let format = Some(device.target_format);
        let asker = Box::new(|_, _: Option<&Path>, _: &_| Answer::known(None));
        let setup = Setup { path: Some(path.to_owned()), home: None, asker, format, ..Setup::default() };
        Self::with(setup, Some(device), 1.0)
    }

    fn with(setup: Setup, device: Option<RenderState>, density: f32) -> Self {
        let mut window = Self::start(setup, device, density);
        if window.0.query_by_label("Empty graph").is_some() {
            window.click("Empty graph");
        }
        window
    }

    fn start(mut setup: Setup, device: Option<RenderState>, density: f32) -> Self {
        let memory = setup.options.memory.min(2 << 30);
        setup.options = Options { threads: 1, memory, ..Options::default() };
        let mut setup = Some(setup);
        let frame = move |ui: &mut eframe::egui::Ui, editor: &mut Option<Editor>| {
            if editor.is_none() {
                *editor = setup.take().map(|setup| Editor::new(ui.ctx(), setup));
            }
            editor.as_mut().unwrap().frame(ui);
        };
        let builder = Harness::builder().with_size([1280.0, 800.0]).with_step_dt(1.0 / 30.0);
        let builder = builder.with_pixels_per_point(density);
        let software = device.as_ref().is_some_and(|d| d.adapter.get_info().device_type == DeviceType::Cpu);
        let builder = match device {
            Some(device) => builder.renderer(WgpuTestRenderer::from_render_state(device)),
            None => builder,
        };
        let mut window = Self(builder.build_ui_state(frame, None), software);
        window.steps(3);
        window
    }

    pub(crate) fn steps(&mut self, n: usize) {
        self.0.run_steps(n);
    }

    pub(crate) fn editor(&self) -> &Editor {
        self.0.state().as_ref().unwrap()
    }

    pub(crate) fn graph(&self) -> &Graph {
        self.editor().document().graph()
    }

    /// The source of an input of a node, as text.
    pub(crate) fn reads(&self, node: &str, input: &str) -> Option<String> {
        let graph = self.graph();
        graph.source(graph.find(node).unwrap(), input).map(|s| graph.source_text(&s))
    }

    pub(crate) fn rect(&self, label: &str) -> Rect {
        self.0.get_by_label(label).rect()
    }

    pub(crate) fn at(&self, label: &str) -> Pos2 {
        self.rect(label).center()
    }

    pub(crate) fn sees(&self, label: &str) -> bool {
        self.0.query_all_by_label_contains(label).next().is_some()
    }

    /// Whether there is a widget with exactly this label.
    pub(crate) fn has(&self, label: &str) -> bool {
        self.0.query_by_label(label).is_some()
    }

    pub(crate) fn click(&mut self, label: &str) {
        self.0.get_by_label(label).click();
        self.steps(3);
    }

    /// Runs a command by its name.
    pub(crate) fn command(&mut self, name: &str) {
        self.keys(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
        self.text(name);
        self.key(Key::Enter);
        self.steps(2);
    }

    /// Shows the map or the relief.
    pub(crate) fn view(&mut self, name: &str) {
        self.0.get_all_by_label(name).next().unwrap().click();
        self.steps(3);
        self.settle();
    }

    pub(crate) fn key(&mut self, key: Key) {
        self.keys(Modifiers::NONE, key);
    }

    pub(crate) fn keys(&mut self, modifiers: Modifiers, key: Key) {
        self.0.key_press_modifiers(modifiers, key);
        self.steps(2);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.0.event(Event::Text(text.to_owned()));
        self.steps(2);
    }

    pub(crate) fn hover(&mut self, at: Pos2) {
        self.0.hover_at(at);
        self.steps(1);
    }

    pub(crate) fn button(&mut self, at: Pos2, pressed: bool) {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        self.0.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        self.steps(1);
    }

    /// Types a number into the field at the right end of a slider.
    pub(crate) fn type_into(&mut self, slider: &str, text: &str) {
        let rect = self.0.get_by_role_and_label(Role::Slider, slider).rect();
        let at = pos2(rect.right() - 14.0, rect.center().y);
        self.hover(at);
        self.button(at, true);
        self.button(at, false);
        self.steps(2);
        self.keys(Modifiers::COMMAND, Key::A);
        self.text(text);
        self.key(Key::Enter);
        self.steps(2);
    }

    /// Presses the button at a place, moves to others and releases it at the last.
    pub(crate) fn drag(&mut self, way: &[Pos2]) {
        self.press_and_move(way);
        self.button(*way.last().unwrap(), false);
        self.steps(2);
    }

    pub(crate) fn press_and_move(&mut self, way: &[Pos2]) {
        self.hover(way[0]);
        self.button(way[0], true);
        for pair in way.windows(2) {
            for k in 1..=4 {
                self.hover(pair[0] + (pair[1] - pair[0]) * (k as f32 / 4.0));
            }
        }
        self.steps(1);
    }

    pub(crate) fn double_click(&mut self, at: Pos2) {
        self.hover(at);
        for _ in 0..2 {
            self.button(at, true);
            self.button(at, false);
        }
        self.steps(2);
    }

    /// A click at a place.
    pub(crate) fn press(&mut self, at: Pos2) {
        self.hover(at);
        self.button(at, true);
        self.button(at, false);
        self.steps(2);
    }

    /// A click of the right button.
    pub(crate) fn secondary(&mut self, at: Pos2) {
        self.hover(at);
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
            self.0.event(Event::PointerButton { pos: at, button, pressed, modifiers });
            self.steps(1);
        }
        self.steps(2);
    }

    /// The text that the last frames put on the clipboard.
    pub(crate) fn copied(&mut self) -> String {
        self.0.event(Event::Copy);
        for _ in 0..3 {
            self.0.step();
            let commands = &self.0.output().platform_output.commands;
            let text = commands.iter().find_map(|c| match c {
                OutputCommand::CopyText(text) => Some(text.clone()),
                _ => None,
            });
            if let Some(text) = text {
                return text;
            }
        }
        panic!("nothing was copied");
    }

    pub(crate) fn paste(&mut self, text: &str) {
        self.0.event(Event::Paste(text.to_owned()));
        self.steps(2);
    }

    /// Adds a node by the search, with its corner near a place.
    pub(crate) fn add(&mut self, at: Pos2, query: &str) {
        self.hover(at);
        self.key(Key::Tab);
        self.text(query);
        self.key(Key::Enter);
    }

    /// Draws frames until everything in sight is evaluated, and the frames that show the result.
    pub(crate) fn settle(&mut self) {
        self.until("everything in sight is evaluated", |window| !window.editor().is_busy());
        self.steps(2);
    }

    /// Draws frames until a condition holds; fails after [`PATIENCE`]. The window is as it was in the frame in which the
    /// condition first held: a dialog that opened in this frame is not yet drawn, see [`appears`](Self::appears).
    pub(crate) fn until(&mut self, condition: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(start.elapsed() < PATIENCE, "{PATIENCE:?} passed before {condition}");
            std::thread::sleep(Duration::from_millis(10));
            self.steps(1);
        }
    }

    /// Draws frames until a widget with this label is there and can be clicked. egui measures a new dialog in its first
    /// frame and places it in the next, where a click finds it.
    pub(crate) fn appears(&mut self, label: &str) {
        self.until(&format!("`{label}` appears"), |window| window.has(label));
        self.steps(2);
    }

    /// Whether the last frame painted a text that contains some words.
    pub(crate) fn paints(&self, words: &str) -> bool {
        fn has(shape: &Shape, words: &str) -> bool {
            match shape {
                Shape::Text(text) => text.galley.text().contains(words),
                Shape::Vec(shapes) => shapes.iter().any(|s| has(s, words)),
                _ => false,
            }
        }
        self.0.output().shapes.iter().any(|clipped| has(&clipped.shape, words))
    }
}

/// A place on the empty canvas of the test window.
pub(crate) fn ground(x: f32, y: f32) -> Pos2 {
    pos2(40.0 + x, 520.0 + y)
}
