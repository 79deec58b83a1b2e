//! The document: a graph with its history and its file.

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
    /// The number of the state that was last read from the file or written to it.
    saved: Option<u64>,
    /// The bytes that were last read from the file or written to it, to tell when another program has changed it.
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
    /// Fails when the bytes are no graph, or the file cannot be read.
    pub fn open(path: &Path, registry: &Registry) -> Result<Self, LoadError> {
        let graph = Graph::open(path, registry)?;
        let bytes = graph.to_bytes();
        let mut document = Self::of(graph, Some(path.to_owned()), "Opened");
        document.on_disk = Some(bytes.into());
        Ok(document)
    }

    /// A document without a file, made from a graph such as a preset.
    pub fn adopted(graph: Graph, label: &str) -> Self {
        Self { saved: None, ..Self::of(graph, None, label) }
    }

    /// A document made from unsaved work of a session that crashed. It may be saved to its file only while this still
    /// has the content that it had then; `hash` is the [`file_hash`](Self::file_hash) of that time. Older versions
    /// stored none, and then the file may be written.
    pub fn recovered(graph: Graph, path: Option<PathBuf>, hash: Option<&str>) -> Self {
        let found = path.as_ref().and_then(|path| std::fs::read(path).ok());
        let ours = |found: &Vec<u8>| hash.is_none_or(|hash| hash == hash_of(found));
        // Other bytes than those of the file make saving fail with `Changed`.
        let on_disk = found.map(|found| if ours(&found) { found.into() } else { Arc::from([]) });
        Self { saved: None, on_disk, ..Self::of(graph, path, "Recovered") }
    }

    /// The hash of what the file held when it was last read or written.
    pub fn file_hash(&self) -> Option<String> {
        self.on_disk.as_deref().map(hash_of)
    }

    fn of(graph: Graph, path: Option<PathBuf>, label: &str) -> Self {
        let problems = (0, graph.problems().into());
        Self { history: History::new(graph, label), path, saved: Some(0), on_disk: None, problems }
    }

    /// The graph in its current state.
    pub fn graph(&self) -> &Graph {
        &self.history.current().graph
    }

    /// The graph in its current state, to be shared with other threads.
    pub fn shared(&self) -> Arc<Graph> {
        self.history.current().graph.clone()
    }

    /// The number of the current state. Each change has a new number; undo restores the old one.
    pub fn state(&self) -> u64 {
        self.history.current().id
    }

    /// The file of the document, if it has one.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The name of the file without its extension, or `untitled`.
    pub fn name(&self) -> String {
        let stem = self.path.as_ref().and_then(|p| p.file_stem());
        stem.map_or_else(|| "untitled".to_owned(), |s| s.to_string_lossy().into_owned())
    }

    /// Whether the document differs from its file.
    pub fn is_unsaved(&self) -> bool {
        self.saved != Some(self.state())
    }

    /// The errors and warnings of the graph.
    pub fn problems(&self) -> &[Problem] {
        &self.problems.1
    }

    /// Changes the graph. A refused change, or one that changes nothing, leaves graph and history as they were.
    ///
    /// # Errors
    /// Returns the problem for which the change was refused.
    pub fn edit<T>(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        self.change(label, None, change)
    }

    /// Changes the graph as part of a gesture, such as dragging a slider. All changes of a gesture are undone at once.
    ///
    /// # Errors
    /// Returns the problem for which the change was refused.
    pub fn gesture<T>(
        &mut self,
        label: &str,
        gesture: &str,
        change: impl FnOnce(&mut Graph) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        self.change(label, Some(gesture), change)
    }

    /// Ends a gesture, so that the next change is undone by itself.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
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
            self.find_problems();
        }
        Ok(given)
    }

    /// Undoes the last change; returns false where there is none.
    pub fn undo(&mut self) -> bool {
        self.history.undo() && self.find_problems()
    }

    /// Makes the change again that was undone last; returns false where there is none.
    pub fn redo(&mut self) -> bool {
        self.history.redo() && self.find_problems()
    }

    /// Makes the state at an index of [`states`](Self::states) the current one; returns false where there is none.
    pub fn go(&mut self, to: usize) -> bool {
        self.history.go(to) && self.find_problems()
    }

    /// The names of the changes that undo and redo would make, where there are some.
    pub fn undo_labels(&self) -> [Option<&str>; 2] {
        [self.history.undo_label(), self.history.redo_label()]
    }

    /// The name of the change that led to each state, oldest first, and the index of the current state.
    pub fn states(&self) -> (Vec<&str>, usize) {
        let (states, at) = self.history.list();
        (states.map(|s: &State| s.label.as_str()).collect(), at)
    }

    fn find_problems(&mut self) -> bool {
        let state = self.state();
        if self.problems.0 != state {
            self.problems = (state, self.graph().problems().into());
        }
        true
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// Returns the errors of the file system, and [`Changed`](crate::whole::Changed) when another program has changed
    /// the document's own file since it was read or written. The document then stays unsaved.
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
        self.end_gesture();
        Ok(())
    }

    /// The bytes of the file, where another program has changed it since it was last read or written.
    pub fn foreign_change(&self) -> Option<Vec<u8>> {
        let (path, known) = (self.path.as_ref()?, self.on_disk.as_ref()?);
        let found = std::fs::read(path).ok()?;
        (*found != **known).then_some(found)
    }

    /// Replaces the graph by the one that another program wrote to the file, as a change that can be undone.
    ///
    /// # Errors
    /// Fails when the bytes are no graph, or the file cannot be read.
    pub fn reload(&mut self, bytes: Vec<u8>) -> Result<(), LoadError> {
        let graph = Graph::from_bytes(&bytes, self.graph().registry())?;
        self.history.push("Reload from disk", None, graph);
        self.saved = Some(self.state());
        self.on_disk = Some(bytes.into());
        self.find_problems();
        Ok(())
    }

    /// Keeps the document although another program has written these bytes to its file; the next save replaces them.
    pub fn keep_mine(&mut self, on_disk: Vec<u8>) {
        self.on_disk = Some(on_disk.into());
        self.saved = None;
    }
}

/// The hash of the content of a file, in hexadecimal.
fn hash_of(bytes: &[u8]) -> String {
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
        // Saving to another file works, and saving here once the user has decided so.
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
        let hash = lost.file_hash();
        let back = |hash: Option<&str>| {
            let mut back = Document::recovered(lost.graph().clone(), Some(path.clone()), hash);
            assert!(back.is_unsaved());
            back.save(&path).map_err(|e| whole::Changed::is(&e))
        };
        back(hash.as_deref()).expect("as it was");
        back(None).expect("an older version kept no hash_of");
        std::fs::write(&path, "theirs").expect("writes");
        assert_eq!(back(hash.as_deref()), Err(true));
        std::fs::remove_file(&path).expect("removes");
        back(hash.as_deref()).expect("is gone");
    }
}
