//! Tests of: select.
