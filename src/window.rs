//! The desktop editor. It is a crate of its own because the program depends on it, so that it cannot be part of the
//! program's package.

// Inside, names are those of the whole house.
use orograph_core::{
    context, engine, files, graph, kit, name, node, nodes, params, ports, render, text, units, value, whole,
    widget, work,
};

mod editor;

pub use editor::*;
