//! The numbers that a step of one level works with.

use super::Settings;
use super::water::SIDE;

/// Depth in metres below which water does not run.
pub(super) const THINNEST: f32 = 1e-4;

/// How fast deep water falls to the level of the sea: a metre of depth closes a fifth of the difference in a second.
const SEA: f64 = 0.2;

/// Gravity, in m/s².
const GRAVITY: f64 = 9.81;

/// What a step needs of settings, cell size and length of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Consts {
    /// Whether rain falls.
    pub(super) rains: bool,
    /// Length of the step, in seconds.
    pub(super) dt: f32,
    /// Square of the celerity cap.
    pub(super) celerity: f32,
    pub(super) gravity: f32,
    /// `Δt n²`.
    pub(super) friction: f32,
    pub(super) per_fastest: f32,
    pub(super) thinnest: f32,
    /// `Δt / L` along an axis and along a diagonal.
    pub(super) per_length: [f32; 2],
    /// Depth that a flow of 1 m²/s over one edge takes from a cell.
    pub(super) share: f32,
    /// Capacity in metres of solid of flow times drop, along an axis and along a diagonal.
    pub(super) power: [f32; 2],
    /// Metres that load sinks in a step; that loose ground and rock give.
    pub(super) settling: f32,
    pub(super) loose: f32,
    pub(super) rock: f32,
    /// 1 / (wear in metres that halves the erodibility of rock), 0 for never.
    pub(super) per_hardening: f32,
    pub(super) most_wear: f32,
    pub(super) most_deposit: f32,
    /// Level of the sea; lower than any land where there is none.
    pub(super) sea: f32,
    pub(super) sea_rate: f32,
}

impl Consts {
    pub(super) fn new(s: &Settings, cell: f64, dt: f64, sea: Option<f32>) -> Self {
        let side = f64::from(SIDE);
        let diagonal = cell * std::f64::consts::SQRT_2;
        let power = |length: f64| (s.capacity * side / length) as f32;
        let bound = |metres: f64| if metres > 0.0 { metres.min(1e9) as f32 } else { 1e9 };
        Self {
            rains: true,
            dt: dt as f32,
            celerity: (s.celerity * s.celerity) as f32,
            gravity: GRAVITY as f32,
            friction: (dt * s.roughness * s.roughness) as f32,
            per_fastest: (1.0 / s.celerity) as f32,
            thinnest: THINNEST,
            per_length: [(dt / cell) as f32, (dt / diagonal) as f32],
            share: (dt / cell * side) as f32,
            power: [power(cell), power(diagonal)],
            settling: (s.settling * dt) as f32,
            loose: (s.loose_erodibility * dt) as f32,
            rock: (s.rock_erodibility * dt) as f32,
            per_hardening: if s.hardening > 0.0 { (1.0 / s.hardening) as f32 } else { 0.0 },
            most_wear: bound(s.most_wear),
            most_deposit: bound(s.most_deposit),
            sea: sea.unwrap_or(f32::MIN),
            sea_rate: (SEA * dt) as f32,
        }
    }
}
