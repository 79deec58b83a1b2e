//! The laws, as loops over every kind of the registry: a new kind is covered the moment it exists.
//!
//! Each loop is shown to fail: by a lying kind of `kinds`. Parameter sets, sizes and windows are those of the `rig`.

mod documents;
mod long;
mod machines;
mod presets;
mod random;
mod values;
mod windows;
