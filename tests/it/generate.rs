//! Tests of: generate.
