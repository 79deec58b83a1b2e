//! Kinds that the tests add to the registry: honest ones of every reach, and lying ones.

use std::sync::LazyLock;

use orograph::node::Kind;
use orograph::nodes::Registry;
use orograph::prelude::*;

macro_rules! params {
    ($($name:ident { $($field:ident : $ty:ty = $default:expr),* $(,)? })+) => {$(
        /// A kind of the tests.
        #[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub(crate) struct $name { $(/// A parameter.
            pub $field: $ty),* }
        impl Default for $name {
            fn default() -> Self { Self { $($field: $default),* } }
        }
    )+};
}

mod lies;

ports! {
    pub(crate) struct None {}
    pub(crate) struct One {
        /// A field.
        field: Field = Meaning::like("field"),
    }
    pub(crate) struct Land {
        /// Height, in metres.
        field: Field = Meaning::Fixed(Quantity::Elevation),
    }
    pub(crate) struct Share {
        /// A plain number.
        field: Field,
    }
    pub(crate) struct Both {
        /// A field.
        field: Field = Meaning::like("a"),
    }
    pub(crate) struct Two {
        /// A field.
        a: Field,
        /// Another.
        b: Field,
    }
}

params! {
    Waves { height: Metres = Metres(100.0), length: Metres = Metres(700.0), seed: Seed = Seed(1) }
    Sum {}
    Smooth { radius: Metres = Metres(120.0) }
    Spread { amount: Ratio = Ratio(0.5) }
    Dig { depth: Metres = Metres(50.0), narrowest: Metres = Metres(1000.0) }
    Stretch {}
    Copy {}
    NotANumber {}
    Panics {}
    SecretSeed {}
    WrongGrid {}
    WrongQuantity {}
    Peeks {}
    Slow { seconds: Number = Number(5.0) }
    Bytes { file: FilePath = FilePath::default() }
    Either { first: FilePath = FilePath::default(), second: FilePath = FilePath::default() }
    Grumbles {}
    Around { radius: Metres = Metres(500.0) }
    Glances {}
    Hog { share: Ratio = Ratio(1.0) }
}

/// A smooth but busy function of the plane, in exact arithmetic only.
pub(crate) fn waves(x: f64, y: f64, length: f64, seed: u64) -> f32 {
    let s = |v: f64| {
        let t = v - v.floor();
        (t * (1.0 - t) * 4.0) * if v.floor().rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 }
    };
    let k = 1.0 + seed as f64 % 7.0 / 10.0;
    (s(k * x / length) + s(0.7 * y / length + 0.3) + 0.2 * s((x + y) / (length * 0.23))) as f32
}

impl Node for Waves {
    type In = None;
    type Out = Land;
    const META: Meta = Meta::new().reads(Reads::SEED);
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<Land> {
        let seed = cx.seed(self.seed)?;
        let xs = cx.grid.xs();
        let field = cx.fill(Quantity::Elevation, |row, out| {
            for (o, x) in out.iter_mut().zip(&xs) {
                *o = self.height.0 as f32 * waves(*x, row.y, self.length.0, seed);
            }
        })?;
        Ok(Land { field })
    }
}

/// Warns from every row.
impl Node for Grumbles {
    type In = None;
    type Out = Land;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<Land> {
        let field = cx.fill(Quantity::Elevation, |row, _| cx.warn(format!("row {}", row.j % 3)))?;
        Ok(Land { field })
    }
}

impl Node for Sum {
    type In = Two;
    type Out = Both;
    const META: Meta = Meta::new().mixes(&[("field", "a")]);
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, Two { a, b }: Two) -> Result<Both> {
        let (a, b) = (a.crop(&cx.grid), b.crop(&cx.grid));
        let field = cx.fill(a.quantity(), |row, out| {
            for ((o, a), b) in out.iter_mut().zip(a.row(row.j)).zip(b.row(row.j)) {
                *o = a + b;
            }
        })?;
        Ok(Both { field })
    }
}

/// The mean of five points, two of them a radius away each way.
fn cross(field: &Field, col: i64, row: i64, n: i64) -> f32 {
    (field.at(col, row)
        + field.at(col - n, row)
        + field.at(col + n, row)
        + field.at(col, row - n)
        + field.at(col, row + n))
        / 5.0
}

impl Smooth {
    fn mean(&self, cx: &Context<'_>, field: &Field) -> Result<One> {
        let n = (self.radius.0 / cx.grid.cell()).round() as i64;
        let field = cx.fill(field.quantity(), |row, out| {
            for (i, o) in out.iter_mut().enumerate() {
                *o = cross(field, cx.grid.col + i as i64, row.row, n);
            }
        })?;
        Ok(One { field })
    }
}

impl Node for Smooth {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new().mixes(&[("field", "field")]);
    fn reach(&self) -> Reach {
        Reach::local(self.radius.0).plus_cells(1)
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        self.mean(cx, &field)
    }
}

/// Like `Smooth`, but says it looks no further than its own point.
impl Node for Peeks {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        Smooth::default().mean(cx, &field)
    }
}

/// Gives a new field that hangs on the whole: the mean mixed into each sample.
impl Node for Spread {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Global
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        let field = field.crop(&cx.grid);
        let mean = field.data().iter().map(|&x| f64::from(x)).sum::<f64>() / field.data().len() as f64;
        let k = self.amount.0 as f32;
        let field = cx.map(&field, field.quantity(), |x: f32| x * (1.0 - k) + mean as f32 * k)?;
        Ok(One { field })
    }
}

/// Changes a field in the western half: lowers what stands above zero there.
impl Node for Dig {
    type In = One;
    type Out = One;
    const META: Meta =
        Meta::new().carries(&[("field", "field")]).mixes(&[("field", "field")]).reads(Reads::TERRAIN);
    fn reach(&self) -> Reach {
        Reach::Global
    }
    fn narrowest(&self) -> Option<f64> {
        Some(self.narrowest.0)
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        let middle = cx.terrain()?.width / 2.0 + cx.terrain()?.origin[0];
        let field = field.crop(&cx.grid);
        let xs = cx.grid.xs();
        let out = cx.fill(field.quantity(), |row, out| {
            for ((o, &z), &x) in out.iter_mut().zip(field.row(row.j)).zip(&xs) {
                *o = if x < middle { z - self.depth.0 as f32 * (1.0 - (x / middle) as f32) } else { z };
            }
        })?;
        Ok(One { field: out })
    }
}

/// Brings a field to 0..1 by its range on the base grid.
impl Node for Stretch {
    type In = Share;
    type Out = Share;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn summary(&self) -> Option<orograph::node::Summarize<Self>> {
        Some(|_, _, input| {
            let (lo, hi) = input.field.range().unwrap_or((0.0, 1.0));
            Ok(Summary([f64::from(lo), f64::from(hi)].into()))
        })
    }
    fn run(&self, cx: &Context<'_>, Share { field }: Share) -> Result<Share> {
        let (lo, hi) = (cx.summary()?.0[0] as f32, cx.summary()?.0[1] as f32);
        Ok(Share { field: cx.map(&field, Quantity::Number, |x: f32| (x - lo) / (hi - lo).max(1e-6))? })
    }
}

impl Node for Copy {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        Ok(One { field: field.crop(&cx.grid) })
    }
}

macro_rules! generator {
    ($($name:ident: |$self:ident, $cx:ident| $body:expr;)+) => {$(
        impl Node for $name {
            type In = None;
            type Out = One;
            const META: Meta = Meta::new();
            fn reach(&self) -> Reach {
                Reach::Point
            }
            fn run(&$self, $cx: &Context<'_>, _: None) -> Result<One> {
                $body
            }
        }
    )+};
}

generator! {
    NotANumber: |self, cx| Ok(One { field: cx.fill(Quantity::Number, |row, out| {
        out[0] = if row.j == 3 { f32::NAN } else { 0.0 };
    })? });
    Panics: |self, _cx| panic!("the kind has a bug");
    SecretSeed: |self, cx| { let s = cx.seed(Seed(1))? as f32; Ok(One { field: Field::constant(cx.grid, Quantity::Number, s) }) };
    WrongQuantity: |self, cx| Ok(One { field: Field::constant(cx.grid, Quantity::Slope, 0.0) });
    WrongGrid: |self, cx| Ok(One { field: Field::constant(cx.grid.grow_cells(1), Quantity::Number, 0.0) });
    Slow: |self, cx| {
        let end = std::time::Instant::now() + std::time::Duration::from_secs_f64(self.seconds.0);
        while std::time::Instant::now() < end {
            cx.check()?;
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        Ok(One { field: Field::constant(cx.grid, Quantity::Number, 0.0) })
    };
}

/// The change of a field over its radius to the east and west: near things on the build's lattice, far ones on the base
/// grid's.
impl Node for Around {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new().reads(Reads::BASE);
    fn reach(&self) -> Reach {
        Reach::local(self.radius.0)
    }
    fn footprint(&self, _: &str, window: &Grid, _: &Terrain) -> Grid {
        *window
    }
    fn views(&self, _: &str, window: &Grid, terrain: &Terrain) -> Vec<Grid> {
        let base = Grid::covering(terrain.base_lattice(), window.bounds());
        vec![base, base.grow_metres(self.radius.0)]
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        let (under, far): (Field, Field) = (cx.view("field", 0)?, cx.view("field", 1)?);
        let base = cx.base_lattice()?;
        assert!(under.grid().lattice == base && far.grid().contains(under.grid()), "the list's order");
        let reach = (self.radius.0 / base.cell()) as i64;
        let xs = cx.grid.xs();
        let field = field.crop(&cx.grid);
        let out = cx.fill(field.quantity(), |row, out: &mut [f32]| {
            for ((o, &x), here) in out.iter_mut().zip(&xs).zip(field.row(row.j)) {
                let [c, r] = base.steps(x, row.y).map(|v| v.floor() as i64);
                *o = here - 0.5 * (far.at(c - reach, r) + far.at(c + reach, r));
            }
        })?;
        Ok(One { field: out })
    }
}

/// Looks at the base grid and does not say so.
impl Node for Glances {
    type In = One;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::local(0.0)
    }
    fn views(&self, _: &str, _: &Grid, terrain: &Terrain) -> Vec<Grid> {
        vec![terrain.base_grid()]
    }
    fn run(&self, cx: &Context<'_>, One { field }: One) -> Result<One> {
        let _: Field = cx.view("field", 0)?;
        Ok(One { field: field.crop(&cx.grid) })
    }
}

/// Uses four fields of scratch memory and says so, or only in part.
impl Node for Hog {
    type In = None;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 1.0).with_fields(grid, 4.0 * self.share.0)
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<One> {
        let scratch = vec![1.0f32; cx.grid.len() * 4];
        let field = cx.fill(Quantity::Number, |row, out| out.fill(scratch[row.j]))?;
        Ok(One { field })
    }
}

/// The number of bytes of a file.
impl Node for Bytes {
    type In = None;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn files(&self) -> Vec<FileRequest> {
        vec![FileRequest { parameter: "file", name: self.file.0.clone(), optional: false }]
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<One> {
        let file = cx.file(&self.file).ok_or(Error::Undeclared { what: "file" })?;
        let n = cx.read("file", file)?.len();
        Ok(One { field: Field::constant(cx.grid, Quantity::Number, n as f32) })
    }
}

/// How many of two files are there.
impl Node for Either {
    type In = None;
    type Out = One;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn files(&self) -> Vec<FileRequest> {
        let request =
            |parameter, name: &FilePath| FileRequest { parameter, name: name.0.clone(), optional: true };
        vec![request("first", &self.first), request("second", &self.second)]
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<One> {
        let there = |name: &FilePath, weight: f32| if cx.file(name).is_some() { weight } else { 0.0 };
        let sum = there(&self.first, 1.0) + there(&self.second, 2.0);
        Ok(One { field: Field::constant(cx.grid, Quantity::Number, sum) })
    }
}

/// The standard kinds and those of this file.
pub(crate) fn registry() -> Registry {
    static KINDS: LazyLock<Registry> = LazyLock::new(|| {
        let mut kinds = vec![
            Kind::of::<Waves>("test", "waves"),
            Kind::of::<Sum>("test", "sum"),
            Kind::of::<Smooth>("test", "smooth"),
            Kind::of::<Spread>("test", "spread"),
            Kind::of::<Dig>("test", "dig"),
            Kind::of::<Stretch>("test", "stretch"),
            Kind::of::<Copy>("test", "copy"),
            Kind::of::<NotANumber>("test", "not_a_number"),
            Kind::of::<Panics>("test", "panics"),
            Kind::of::<SecretSeed>("test", "secret_seed"),
            Kind::of::<WrongGrid>("test", "wrong_grid"),
            Kind::of::<WrongQuantity>("test", "wrong_quantity"),
            Kind::of::<Peeks>("test", "peeks"),
            Kind::of::<Slow>("test", "slow"),
            Kind::of::<Bytes>("test", "bytes"),
            Kind::of::<Either>("test", "either"),
            Kind::of::<Hog>("test", "hog"),
            Kind::of::<Grumbles>("test", "grumbles"),
            Kind::of::<Around>("test", "around"),
            Kind::of::<Glances>("test", "glances"),
        ];
        kinds.extend(lies::kinds());
        Registry::standard().with(kinds)
    });
    KINDS.clone()
}
