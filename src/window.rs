//! The desktop editor, a crate of its own: the program calls it, so that it cannot stand in the program's.

// Inside, names are those of the whole house.
use orograph_core::{
    context, engine, files, graph, kit, name, node, nodes, params, ports, render, text, units, value, whole,
    widget, work,
};

mod editor;

pub use editor::*;
