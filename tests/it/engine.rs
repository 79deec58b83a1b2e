//! Tests of: engine.
