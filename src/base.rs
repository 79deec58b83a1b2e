//! The base of Orograph: values, units and the numerics that nodes share. It knows no node, no graph and no file.

pub mod cost;
pub mod error;
pub mod kit;
pub mod name;
pub mod ports;
pub mod units;
pub mod value;
pub mod widget;
pub mod work;
