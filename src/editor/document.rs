//! The document on the desk: the graph with its history and its file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::history::{History, State};
use crate::graph::{Graph, LoadError, Problem};
use crate::nodes::Registry;
use crate::whole::{self, Known};

/// A graph being edited. Every change goes through [`edit`](Self::edit), so that it can be undone.
#[derive(Debug)]
pub struct Document {
    history: History,
    path: Option<PathBuf>,
    /// The state that the file holds.
    saved: Option<u64>,
    /// The bytes that were last read from the file or written to it: tells a changed file from ours.
    on_disk: Option<Arc<[u8]>>,
    problems: (u64, Arc<[Problem]>),
}

impl Document {
    /// An empty graph without a file.
    pub fn untitled(registry: &Registry) -> Self {
        Self::of(Graph::with_registry(registry.clone()), None, "New graph")
    }

    /// Opens a file.
    ///
    /// # Errors
    /// When it is not a graph.
    pub fn open(path: &Path, registry: &Registry) -> Result<Self, LoadError> {
        let graph = Graph::open(path, registry)?;
        let bytes = graph.to_bytes();
        let mut document = Self::of(graph, Some(path.to_owned()), "Opened");
        document.on_disk = Some(bytes.into());
        Ok(document)
    }

    /// A graph that is in no file yet: a preset to start from.
    pub fn adopted(graph: Graph, label: &str) -> Self {
        Self { saved: None, ..Self::of(graph, None, label) }
    }

    /// Work that was kept from a crash. The file it belongs to is ours to write only while it holds what it held then;
    /// `known` tells, and none is what an older version kept.
    pub fn recovered(graph: Graph, path: Option<PathBuf>, known: Option<&str>) -> Self {
        let found = path.as_ref().and_then(|path| std::fs::read(path).ok());
        let ours = |found: &Vec<u8>| known.is_none_or(|known| known == mark(found));
        // What is not ours is as if something else had been read.
        let on_disk = found.map(|found| if ours(&found) { found.into() } else { Arc::from([]) });
        Self { saved: None, on_disk, ..Self::of(graph, path, "Recovered") }
    }

    /// What the file held when it was last read or written, in short.
    pub fn known(&self) -> Option<String> {
        self.on_disk.as_deref().map(mark)
    }

    fn of(graph: Graph, path: Option<PathBuf>, label: &str) -> Self {
        let problems = (0, graph.problems().into());
        Self { history: History::new(graph, label), path, saved: Some(0), on_disk: None, problems }
    }

    /// The graph as it is now.
    pub fn graph(&self) -> &Graph {
        &self.history.current().graph
    }

    /// The graph as it is now, to be handed to other threads.
    pub fn shared(&self) -> Arc<Graph> {
        self.history.current().graph.clone()
    }

    /// Which state it is in; another after each change, the same again after undo.
    pub fn state(&self) -> u64 {
        self.history.current().id
    }

    /// The file.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// What people call it: the name of its file, without the extension.
    pub fn name(&self) -> String {
        let stem = self.path.as_ref().and_then(|p| p.file_stem());
        stem.map_or_else(|| "untitled".to_owned(), |s| s.to_string_lossy().into_owned())
    }

    /// Whether it differs from its file.
    pub fn is_unsaved(&self) -> bool {
        self.saved != Some(self.state())
    }

    /// What is wrong with the graph.
    pub fn problems(&self) -> &[Problem] {
        &self.problems.1
    }

    /// Changes the graph; a refused or empty change leaves no trace.
    ///
    /// # Errors
    /// Those of the change.
    pub fn edit<T>(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        self.change(label, None, change)
    }

    /// Changes the graph as part of a gesture, as dragging a slider: all changes of one gesture are undone at once.
    ///
    /// # Errors
    /// Those of the change.
    pub fn gesture<T>(
        &mut self,
        label: &str,
        gesture: &str,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        self.change(label, Some(gesture), change)
    }

    /// Ends a gesture: the next change is undone by itself.
    pub fn rest(&mut self) {
        self.history.rest();
    }

    fn change<T>(
        &mut self,
        label: &str,
        gesture: Option<&str>,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let mut graph = self.graph().clone();
        let before = graph.edits();
        let given = change(&mut graph)?;
        if graph.edits() != before {
            self.history.push(label, gesture, graph);
            self.look();
        }
        Ok(given)
    }

    /// Takes the last change back; false where there is none.
    pub fn undo(&mut self) -> bool {
        self.history.undo() && self.look()
    }

    /// Does what was undone again; false where there is nothing.
    pub fn redo(&mut self) -> bool {
        self.history.redo() && self.look()
    }

    /// Goes to a state of the history by its place in [`states`](Self::states).
    pub fn go(&mut self, to: usize) -> bool {
        self.history.go(to) && self.look()
    }

    /// What undo and redo would do, where they would do something.
    pub fn undo_labels(&self) -> [Option<&str>; 2] {
        [self.history.undo_label(), self.history.redo_label()]
    }

    /// What led to each state, oldest first, and which state is shown.
    pub fn states(&self) -> (Vec<&str>, usize) {
        let (states, at) = self.history.list();
        (states.map(|s: &State| s.label.as_str()).collect(), at)
    }

    fn look(&mut self) -> bool {
        let state = self.state();
        if self.problems.0 != state {
            self.problems = (state, self.graph().problems().into());
        }
        true
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// Those of the file system, and [`Changed`](crate::whole::Changed) when the document's own file was changed by
    /// others since it was read or written; the document is then as unsaved as before.
    pub fn save(&mut self, path: &Path) -> std::io::Result<()> {
        let bytes = self.graph().to_bytes();
        let known = match &self.on_disk {
            Some(on_disk) if self.path() == Some(path) => Known::Bytes(on_disk),
            _ => Known::Anything,
        };
        whole::save(path, &bytes, known)?;
        self.path = Some(path.to_owned());
        self.saved = Some(self.state());
        self.on_disk = Some(bytes.into());
        self.rest();
        Ok(())
    }

    /// What the file holds, if it is not what was last read or written: somebody else changed it.
    pub fn foreign_change(&self) -> Option<Vec<u8>> {
        let (path, known) = (self.path.as_ref()?, self.on_disk.as_ref()?);
        let found = std::fs::read(path).ok()?;
        (*found != **known).then_some(found)
    }

    /// Takes over what somebody else wrote to the file, as a change that can be undone.
    ///
    /// # Errors
    /// When it is not a graph.
    pub fn reload(&mut self, bytes: Vec<u8>) -> Result<(), LoadError> {
        let graph = Graph::from_bytes(&bytes, self.graph().registry())?;
        self.history.push("Reload from disk", None, graph);
        self.saved = Some(self.state());
        self.on_disk = Some(bytes.into());
        self.look();
        Ok(())
    }

    /// Keeps what is on the desk although the file says something else.
    pub fn keep_mine(&mut self, on_disk: Vec<u8>) {
        self.on_disk = Some(on_disk.into());
        self.saved = None;
    }
}

/// What tells one content of a file from another.
fn mark(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        Document::untitled(&Registry::standard())
    }

    #[test]
    fn undoes_to_the_same_bytes() {
        let bytes = include_bytes!("../../graphs/first_light.graph");
        let graph = Graph::from_bytes(bytes, &Registry::standard()).expect("a graph");
        let mut document = Document::of(graph, None, "Opened");
        document.edit("Add", |g| g.add("hills_too", "fractal_noise")).expect("adds");
        for wide in [4096.0, 2048.0] {
            document.gesture("Width", "width", |g| g.set_terrain("width", wide.into())).expect("sets");
        }
        assert_eq!(document.states().0.len(), 3, "a gesture is one state");
        assert!(document.is_unsaved() && document.undo() && document.undo() && !document.undo());
        assert_eq!(document.graph().to_bytes(), *bytes);
        assert!(!document.is_unsaved());
        assert!(document.redo() && document.redo() && !document.redo());
        assert_eq!(document.graph().terrain().width, 2048.0);
    }

    #[test]
    fn a_refused_change_leaves_no_trace() {
        let mut document = document();
        document.edit("Add", |g| g.add("a", "blur")).expect("adds");
        let refused = document.edit("Both", |g| {
            g.add("b", "blur")?;
            g.add("b", "blur")
        });
        assert!(refused.is_err() && document.graph().find("b").is_none());
        assert_eq!(document.states().0.len(), 2);
        document.edit("Nothing", |g| g.move_to(g.find("a").expect("a"), [0.0; 2])).expect("moves");
        assert_eq!(document.states().0.len(), 2);
    }

    #[test]
    fn sees_what_others_write() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.graph");
        let mut document = document();
        document.edit("Add", |g| g.add("a", "blur")).expect("adds");
        document.save(&path).expect("saves");
        assert!(!document.is_unsaved() && document.foreign_change().is_none());
        let other = Graph::new();
        other.save(&path).expect("saves");
        let found = document.foreign_change().expect("a change");
        document.reload(found).expect("a graph");
        assert!(document.graph().find("a").is_none() && !document.is_unsaved());
        assert!(document.undo() && document.graph().find("a").is_some() && document.is_unsaved());
    }

    #[test]
    fn does_not_write_over_what_others_wrote() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.graph");
        let mut document = document();
        document.edit("Add", |g| g.add("a", "blur")).expect("adds");
        document.save(&path).expect("saves");
        std::fs::write(&path, "theirs").expect("writes");
        document.edit("Add", |g| g.add("b", "blur")).expect("adds");
        let refused = document.save(&path).expect_err("was changed");
        assert!(whole::Changed::is(&refused) && document.is_unsaved());
        assert_eq!(std::fs::read(&path).expect("reads"), b"theirs");
        // Elsewhere it may go, and here once its user has said so.
        document.save(&folder.path().join("b.graph")).expect("saves");
        document.path = Some(path.clone());
        document.keep_mine(b"theirs".to_vec());
        document.save(&path).expect("saves");
        assert_ne!(std::fs::read(&path).expect("reads"), b"theirs");
    }

    #[test]
    fn recovered_work_knows_whether_its_file_was_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.graph");
        let mut lost = document();
        lost.edit("Add", |g| g.add("a", "blur")).expect("adds");
        lost.save(&path).expect("saves");
        let known = lost.known();
        let back = |known: Option<&str>| {
            let mut back = Document::recovered(lost.graph().clone(), Some(path.clone()), known);
            assert!(back.is_unsaved());
            back.save(&path).map_err(|e| whole::Changed::is(&e))
        };
        back(known.as_deref()).expect("as it was");
        back(None).expect("an older version kept no mark");
        std::fs::write(&path, "theirs").expect("writes");
        assert_eq!(back(known.as_deref()), Err(true));
        std::fs::remove_file(&path).expect("removes");
        back(known.as_deref()).expect("is gone");
    }
}
