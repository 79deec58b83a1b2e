//! Tests of: files.
