//! Orograph: a node-graph terrain tool. This page is the tour of the house.
//!
//! # From a file to a terrain
//! A [`graph::Graph`] is the document: terrain settings, nodes with their inputs, outputs. The [`engine`] makes it a
//! plan and runs it; each node is a struct of the [`nodes`] registry that gives fields on a grid. The [`cli`] writes
//! them with [`files`] or draws them with [`render`].
//!
//! # Values: [`value`], [`mod@ports`], [`units`], [`params`]
//! A [`value::Grid`] is a window of a lattice, and a sample's place comes from its index in the whole lattice: so
//! coincident points of two sizes are one place, to the bit. Fields, vectors and colours are rasters on a grid,
//! cheap to clone. Parameters are structs of unit types; their JSON schema is the only metadata. *Caching:* values
//! are immutable, so that the cache can hand them out.
//!
//! # Nodes: [`node`], [`nodes`], [`context`], [`kit`]
//! A kind declares how far it looks ([`node::Reach`]), what it reads ([`node::Reads`]) and what it costs; it runs in a
//! [`context::Context`] that gives grid, seed, progress and cancellation and nothing else. `kit` holds the numerics
//! that several share. What lies far from a sample may be read on a further window of an input, on the base grid
//! ([`node::Node::views`], [`kit::far`]), so that a wide reach asks no more of a huge build. *Caching:* a node keeps no state; what it did not declare, its context refuses, since the key
//! of its result would not depend on it.
//!
//! # Files that a graph names: [`source`], [`work`]
//! A [`source::SourceFile`] is known by its length and header before its content is read. *Caching:* the content counts
//! by its hash, the name by its last part, and what was decoded stands on a [`source::Shelf`] while there is room.
//!
//! # The document: [`graph`]
//! petgraph inside, canonical JSON outside; edits, validation, migration. What it does not know it keeps. *Caching:*
//! names, places and comments are in no key, so that editing them runs nothing.
//!
//! # Evaluation: [`engine`]
//! From the consumers up: which window of which node on which lattice; what the cache has ends the walk. Global nodes
//! run on the base grid and their results are carried to finer grids. Tasks run side by side within the plan's own
//! account of memory. *Caching:* a key is the hash of kind, version, canonical parameters, input keys, file contents and declared
//! settings; a result adds its grid.
//!
//! # Faces: [`cli`], `editor`, [`files`], [`render`]
//! They hold no state of their own but what a window needs: the editor's document is the graph with its history, and it
//! asks the engine from a thread beside the window. *Caching:* none; a build is the same whether the engine was warm or
//! cold.

pub mod cli;

pub use orograph_core::{
    context, engine, files, graph, kit, node, nodes, params, ports, prelude, render, source, text, units,
    value, whole, work,
};
#[cfg(feature = "editor")]
pub use orograph_editor as editor;
