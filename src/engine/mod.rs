//! Evaluates graphs.
