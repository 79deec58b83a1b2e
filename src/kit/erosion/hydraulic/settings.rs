//! What erosion by water is set to.

/// Parameters of erosion by water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Hours of rain, of all levels together.
    pub hours: f64,
    /// Rain in mm/h where moisture is 1.
    pub rain: f64,
    /// How unevenly rain falls.
    pub showers: Showers,
    /// Evaporation in mm/h at 30 °C; in proportion to the temperature from 0 °C up.
    pub evaporation: f64,
    /// Discharge of all sources together, in m³/s.
    pub source_discharge: f64,
    /// Roughness of beds: Manning's `n`, in s/m^(1/3).
    pub roughness: f64,
    /// Capacity: metres of solid that flow can carry, over discharge per width times slope, in s/m.
    pub capacity: f64,
    /// Speed at which load sinks, in m/s.
    pub settling: f64,
    /// Erodibility of rock as a speed, in m/s.
    pub rock_erodibility: f64,
    /// Erodibility of loose ground as a speed, in m/s.
    pub loose_erodibility: f64,
    /// Wear in metres that halves the erodibility of rock; 0 for never.
    pub hardening: f64,
    /// Most rock that goes anywhere, in metres; 0 for no bound.
    pub most_wear: f64,
    /// Most that is laid down anywhere, in metres; 0 for no bound.
    pub most_deposit: f64,
    /// Tangent of the angle of repose of rock.
    pub rock_repose: f64,
    /// Tangent of the angle of repose of loose ground.
    pub loose_repose: f64,
    /// Width of the largest valleys, in metres: where the ladder of levels starts; infinite for its coarsest level.
    pub feature: f64,
    /// Whether water and load leave over the border.
    pub border: Border,
    /// Whether hollows are full of water at the start.
    pub full_lakes: bool,
    /// Speed that no wave exceeds, in m/s: it sets the length of a step.
    pub celerity: f64,
    /// Length of a step as a part of the time that the fastest wave takes to cross a cell; below 1.
    pub courant: f64,
    /// Seed of the showers.
    pub seed: u64,
}

/// How unevenly rain falls: showers come and go, and their mean is even.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Showers {
    /// Width of a shower, in metres.
    pub size: f64,
    /// How long one lasts, in seconds.
    pub seconds: f64,
    /// How much of the rain falls in showers, 0 to 1.
    pub strength: f64,
}

/// The border of the land.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// Water and load leave.
    Open,
    /// A wall: nothing leaves.
    Closed,
}

impl Default for Settings {
    /// Rain on mountains of some ten kilometres across.
    fn default() -> Self {
        Self {
            hours: 9.0,
            rain: 54.0,
            showers: Showers { size: 2000.0, seconds: 900.0, strength: 0.0 },
            evaporation: 0.0,
            source_discharge: 0.0,
            roughness: 0.05,
            capacity: 60.0,
            settling: 0.05,
            rock_erodibility: 0.008,
            loose_erodibility: 0.03,
            hardening: 0.0,
            most_wear: 0.0,
            most_deposit: 0.0,
            rock_repose: 1.2,
            loose_repose: 0.75,
            feature: f64::INFINITY,
            border: Border::Open,
            full_lakes: true,
            celerity: 10.0,
            courant: 0.7,
            seed: 0,
        }
    }
}

impl Settings {
    /// Longest step on cells of a size in metres, in seconds.
    pub fn longest_step(&self, cell: f64) -> f64 {
        self.courant * cell / self.celerity
    }
}
