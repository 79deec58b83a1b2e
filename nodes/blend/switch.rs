//! One of several fields.

use crate::prelude::*;

/// Takes one of up to eight fields, by number.
///
/// Expose `choice` to let a graph offer variants. The inputs that are not taken are not computed:
/// they have no part in the result.
///
/// # See also
/// `mix` to blend two of them.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Switch {
    /// Which input is taken: 0 for `a`, 1 for `b`, up to 7 for `h`.
    #[schemars(range(min = 0, max = 7), extend("x-unit" = "1"))]
    pub choice: u32,
}

ports! {
    pub struct Inputs {
        /// Taken when `choice` is 0.
        a: Option<Field>,
        /// Taken when `choice` is 1.
        b: Option<Field>,
        /// Taken when `choice` is 2.
        c: Option<Field>,
        /// Taken when `choice` is 3.
        d: Option<Field>,
        /// Taken when `choice` is 4.
        e: Option<Field>,
        /// Taken when `choice` is 5.
        f: Option<Field>,
        /// Taken when `choice` is 6.
        g: Option<Field>,
        /// Taken when `choice` is 7.
        h: Option<Field>,
    }
    pub struct Outputs {
        /// The field that was taken.
        field: Field = Meaning::Chosen,
    }
}

/// The inputs by number.
const NAMES: [&str; 8] = ["a", "b", "c", "d", "e", "f", "g", "h"];

impl Switch {
    /// The name of the input that is taken.
    fn taken(&self) -> &'static str {
        NAMES[self.choice.min(7) as usize]
    }
}

impl Node for Switch {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&["select", "choose", "variant", "if", "branch"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn uses(&self, port: &str) -> bool {
        port == self.taken()
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 0.5)
    }

    fn quantity(&self, _: &str, inputs: Quantities<'_>) -> Quantity {
        inputs(self.taken()).unwrap_or(Quantity::Number)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let Inputs { a, b, c, d, e, f, g, h } = input;
        let port = self.taken();
        let missing = || Error::Input {
            port: port.into(),
            message: format!("is not connected, and `choice` is {}", self.choice),
        };
        let field = [a, b, c, d, e, f, g, h].into_iter().nth(self.choice.min(7) as usize).flatten();
        Ok(Outputs { field: field.ok_or_else(missing)?.crop(&cx.grid) })
    }
}
