//! Orograph is a node-graph terrain tool. This crate holds its engine and its nodes, the command line and the editor.
//!
//! A graph becomes a file in four steps: read the document, find the output, evaluate it on a grid, write the value.
//!
//! ```
//! use orograph::engine::{Engine, Files, Options, Unobserved, Want};
//! use orograph::files::{Format, WriteJob, encode};
//! use orograph::graph::Graph;
//! use orograph::nodes::Registry;
//! use orograph::work::Cancel;
//!
//! let text = r#"{
//!   "orograph": 1,
//!   "terrain": { "width": 4096, "depth": 2048 },
//!   "nodes": { "hills": { "kind": "fractal_noise", "set": { "amplitude": 300, "seed": 4 } } },
//!   "outputs": { "height": { "from": "hills.field" } }
//! }"#;
//! let graph = Graph::from_bytes(text.as_bytes(), &Registry::standard())?;
//! let source = graph.output_source("height")?;
//! // The whole terrain, with 65 samples along its longer side.
//! let grid = graph.terrain().grid(65)?;
//! // `Files::default()` allows no file: this graph names none.
//! let engine = Engine::new(&Options::default(), Files::default())?;
//! let want = Want { node: source.node, port: source.port, grid };
//! let evaluation = engine.evaluate(&graph, &[want], &Unobserved, &Cancel::default())?;
//! let value = evaluation.values[0].clone()?;
//! assert_eq!((grid.cols, grid.rows), (65, 33));
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("height.exr");
//! let mut file = std::fs::File::create(&path)?;
//! encode(&WriteJob::new(&value, Format::Exr, graph.terrain(), grid), &mut file)?;
//! # assert!(std::fs::metadata(&path)?.len() > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Graph::open`](graph::Graph::open) reads a graph from a path, and [`engine::Files::allow_folder`] lets its nodes
//! read files from a folder. The rest of this page is a tour of the crate from the bottom to the top. Each section ends
//! with what the module means for caching.
//!
//! # From a file to a terrain
//! A [`graph::Graph`] is the document: the settings of the terrain, the nodes with their inputs, the outputs. The
//! [`engine`] turns it into a plan and runs the plan. Each node is a struct from the [`nodes`] registry that computes
//! values on a grid. The [`cli`] writes the values with [`files`] or draws them with [`render`].
//!
//! # Values: [`value`], [`mod@ports`], [`units`], [`params`]
//! A [`value::Grid`] is a window of a lattice. The position of a sample comes from its index in the whole lattice, so
//! points that two sizes share have the same position, to the bit. Fields, vectors and colours are rasters on a grid
//! and are cheap to clone; what is no raster is an [`value::Object`] that says all of itself in one place. A port says
//! what the numbers of its output mean, so that this is known before anything runs. Parameters are structs of unit
//! types; their JSON schema is the only metadata. *Caching:*
//! values are immutable, so the cache can hand out the same value many times.
//!
//! # Nodes: [`node`], [`nodes`], [`context`], [`kit`]
//! A kind of node declares how far it looks ([`node::Reach`]), what it reads ([`node::Reads`]) and what it costs
//! ([`node::Cost`]). It runs in a [`context::Context`], which gives it the grid, the seed, progress and cancellation,
//! and nothing else. [`kit`] holds the numerics that several kinds share. A kind that looks far may read its input on a
//! further window of the base grid ([`node::Node::views`], [`kit::far`]), so that its memory does not grow with the
//! size of the build. *Caching:* a node keeps no state. The context refuses what the kind did not declare, because the
//! key of the result would not depend on it.
//!
//! # Long work: [`work`]
//! [`work::Work`] is how long work is watched and stopped: it carries the [`work::Cancel`] switch, the progress of each
//! stage, and warnings for a person. Nodes, [`kit`], [`files`] and [`render`] share this one type. *Caching:* a warning
//! may depend only on what the result depends on, so that it can be repeated for a result that is still in memory.
//!
//! # Files that a graph names: [`source`]
//! A [`source::SourceFile`] gives its length and its header before its content is read. *Caching:* a key contains the
//! hash of the content and the last part of the name. What a node decodes from a file stays on a [`source::Shelf`]
//! while there is room.
//!
//! # The document: [`graph`]
//! A petgraph in memory and canonical JSON on disk, with edits, validation and migration. Whatever the program does not
//! know in a file, it keeps. *Caching:* no key contains a name, a position on the canvas or a comment, so editing those
//! runs nothing. Parameters are parsed when they change; copies of a graph share them, down to the lists of numbers in
//! them, so that a movement of a hand costs what it moves.
//!
//! # Evaluation: [`engine`]
//! The plan is made from the consumers up: which window of which node is needed, on which lattice. A result that the
//! cache already has ends the walk. Global nodes run on the base grid, and their results are carried to finer grids: a
//! change of a field is added to it there, with as much of its finer detail as [`node::Node::keep`] says.
//! Tasks run side by side within the memory that the plan allows. *Caching:* the key of a node is a hash of its kind
//! and version, its canonical parameters, the keys of its inputs, the content of its files, and the settings that its
//! kind declares to read. The key of a result adds the grid. Keys, plans and evaluations of one graph share its program,
//! and the program of a changed graph takes over the nodes that nothing changed for.
//!
//! # Faces: [`cli`], `editor`, [`files`], [`render`]
//! The command line and the editor hold no state beyond what a window needs: the editor's document is a graph with its
//! history, and a thread beside the window asks the engine. [`whole`] writes every file whole or not at all. *Caching:*
//! none here; a build gives the same result whether the engine starts warm or cold.

pub mod cli;

pub use orograph_core::{
    context, cost, engine, error, files, graph, kit, name, node, nodes, params, ports, prelude, render,
    source, text, units, value, whole, widget, work,
};
#[cfg(feature = "editor")]
pub use orograph_editor as editor;
