//! What numbers mean: one row for each quantity, from which its name, its unit and the way it is carried to other grids
//! follow.

/// How a result on the base grid is carried to other grids (law 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lift {
    /// By a cubic B-spline through the samples, which may swing a little past them.
    Spline,
    /// By the same spline, cut to 0 to 1.
    Share,
    /// Linearly, so that nothing falls below the samples around it.
    Linear,
    /// As vectors that turn: 359 degrees and 1 degree have 0 between them.
    Turning,
    /// By the nearest sample: there is nothing between two names.
    Nearest,
}

struct Row {
    name: &'static str,
    unit: &'static str,
    lift: Lift,
    may_be_negative: bool,
}

macro_rules! quantities {
    ($($(#[$doc:meta])+ $quantity:ident: $name:literal, $unit:literal, $lift:ident, $sign:ident;)+) => {
        /// What the numbers of a field mean: how it is shown, and how it is carried to a finer grid.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Quantity {
            $($(#[$doc])+ $quantity,)+
        }

        impl Quantity {
            /// Every quantity, in declaration order.
            pub const ALL: &'static [Self] = &[$(Self::$quantity),+];

            fn row(self) -> Row {
                match self {
                    $(Self::$quantity => Row {
                        name: $name,
                        unit: $unit,
                        lift: Lift::$lift,
                        may_be_negative: quantities!(@$sign),
                    },)+
                }
            }
        }
    };
    (@signed) => { true };
    (@unsigned) => { false };
}

quantities! {
    /// Height above the datum, in metres.
    Elevation: "elevation", "m", Spline, signed;
    /// A distance or difference of heights, in metres.
    Length: "length", "m", Spline, signed;
    /// A share from 0 to 1.
    Mask: "mask", "1", Share, unsigned;
    /// A compass direction in degrees: 0 north, 90 east.
    Direction: "direction", "deg", Turning, unsigned;
    /// An inclination in degrees.
    Slope: "slope", "deg", Spline, unsigned;
    /// One over a radius, in 1/m.
    Curvature: "curvature", "1/m", Spline, signed;
    /// An area in square metres.
    Area: "area", "m2", Linear, unsigned;
    /// A distance or thickness in metres, nowhere below 0.
    Distance: "distance", "m", Linear, unsigned;
    /// Water that passes in a second, in cubic metres.
    Flow: "flow", "m3/s", Linear, unsigned;
    /// A depth of water in metres.
    Depth: "depth", "m", Linear, unsigned;
    /// How fast something moves, as two components in m/s.
    Velocity: "velocity", "m/s", Linear, signed;
    /// A temperature in degrees Celsius.
    Temperature: "temperature", "degC", Spline, signed;
    /// Rain in millimetres an hour.
    Rain: "rain", "mm/h", Linear, unsigned;
    /// A plain number.
    Number: "number", "1", Spline, signed;
    /// A whole number that names something; never averaged.
    Label: "label", "1", Nearest, signed;
    /// Two components of a vector.
    Vector: "vector", "1", Spline, signed;
    /// Red, green and blue from 0 to 1, sRGB encoded as a picture file holds them.
    Color: "color", "1", Share, unsigned;
}

impl Quantity {
    /// The name used in reports and files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The quantity of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|q| q.name() == name)
    }

    /// The unit symbol; `1` for plain numbers.
    pub fn unit(self) -> &'static str {
        self.row().unit
    }

    /// The name with its unit: `elevation in m`.
    pub fn described(self) -> String {
        match self.unit() {
            "1" => self.name().to_owned(),
            unit => format!("{} in {unit}", self.name()),
        }
    }

    /// How it is carried from the base grid to others.
    pub fn lift(self) -> Lift {
        self.row().lift
    }

    /// Whether numbers below 0 make sense.
    pub fn may_be_negative(self) -> bool {
        self.row().may_be_negative
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_lead_back() {
        for &quantity in Quantity::ALL {
            assert_eq!(Quantity::named(quantity.name()), Some(quantity));
            assert!(!quantity.unit().is_empty(), "{quantity:?}");
        }
    }
}
