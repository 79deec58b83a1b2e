//! Tests of: graph.
