//! Tests of: filters.
