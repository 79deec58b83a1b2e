//! Kinds that break a law each, so that the loop over it is seen to fail.

use std::time::Duration;

use cpu_time::ThreadTime;
use orograph::kit::simd::Level;
use orograph::node::Kind;
use orograph::prelude::*;

use super::{None, One, waves};

ports! {
    pub(crate) struct Told {
        /// It.
        field: Field,
    }
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Mute {
    silent: f64,
    /// Goes on for ever.
    endless: f64,
    /// What is told as it should be.
    told: Ratio,
    /// How loud it is.
    mode: Volume,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Volume {
    #[default]
    Loud,
    /// Hardly to be heard.
    Quiet { level: f64 },
}

params! {
    Frames {}
    Weighs {}
    Cells {}
    Edgy {}
    Crowd {}
    Lanes {}
    Deaf {}
    GoesOn {}
}

macro_rules! lies {
    ($($(#[$doc:meta])* $name:ident, $in:ty, $reach:expr => |$cx:ident, $input:ident| $body:expr;)+) => {$(
        $(#[$doc])*
        impl Node for $name {
            type In = $in;
            type Out = One;
            const META: Meta = Meta::new();
            fn reach(&self) -> Reach {
                $reach
            }
            fn run(&self, $cx: &Context<'_>, $input: $in) -> Result<One> {
                Ok(One { field: $body })
            }
        }
    )+};
}

lies! {
    /// Takes the border of its window for an edge.
    Frames, One, Reach::Point => |cx, input| {
        let (field, last) = (input.field.crop(&cx.grid), cx.grid.cols - 1);
        cx.fill(input.field.quantity(), |row, out| {
            out.copy_from_slice(field.row(row.j));
            out[last] = 0.0;
        })?
    };
    /// Hangs on how much it is given.
    Weighs, One, Reach::local(50.0) => |cx, input| {
        let n = input.field.grid().len() as f32;
        cx.map(&input.field, input.field.quantity(), |x: f32| x / n)?
    };
    /// Says that it is a point kind, and hangs on the cell.
    Cells, None, Reach::Point => |cx, _input| {
        Field::constant(cx.grid, Quantity::Number, cx.grid.cell() as f32)
    };
    /// Fades towards the edge of the terrain and does not say that it reads it.
    Edgy, One, Reach::Point => |cx, input| {
        let (field, xs) = (input.field.crop(&cx.grid), cx.grid.xs());
        let end = cx.world.bounds().max[0];
        cx.fill(input.field.quantity(), |row, out| {
            for ((o, z), x) in out.iter_mut().zip(field.row(row.j)).zip(&xs) {
                *o = z * (1.0 - x / end).clamp(0.0, 1.0) as f32;
            }
        })?
    };
    /// Hangs on how many threads there are.
    Crowd, None, Reach::Point => |cx, _input| {
        Field::constant(cx.grid, Quantity::Number, rayon::current_num_threads() as f32)
    };
    /// Hangs on the instruction set.
    Lanes, None, Reach::Point => |cx, _input| {
        Field::constant(cx.grid, Quantity::Number, Level::best().name().len() as f32)
    };
    /// Works for half a second of the processor, and neither looks nor tells.
    Deaf, None, Reach::Point => |cx, _input| {
        work(Duration::from_millis(500));
        Field::constant(cx.grid, Quantity::Number, waves(1.0, 2.0, 3.0, 4))
    };
    /// Looks and tells, and heeds nothing.
    GoesOn, None, Reach::Point => |cx, _input| {
        for k in 0..100 {
            work(Duration::from_millis(5));
            cx.report(k as f32 / 100.0);
            let _ = cx.check();
        }
        Field::constant(cx.grid, Quantity::Number, 0.0)
    };
}

/// Keeps the processor busy.
fn work(time: Duration) {
    let begun = ThreadTime::now();
    while begun.elapsed() < time {
        std::hint::black_box(waves(1.0, 2.0, 3.0, 4));
    }
}

impl Node for Mute {
    type In = None;
    type Out = Told;
    const META: Meta = Meta::new();
    fn reach(&self) -> Reach {
        Reach::Point
    }
    fn run(&self, cx: &Context<'_>, _: None) -> Result<Told> {
        Ok(Told { field: Field::constant(cx.grid, Quantity::Number, 0.0) })
    }
}

pub(super) fn kinds() -> Vec<Kind> {
    vec![
        Kind::of::<Mute>("test", "mute"),
        Kind::of::<Frames>("test", "frames"),
        Kind::of::<Weighs>("test", "weighs"),
        Kind::of::<Cells>("test", "cells"),
        Kind::of::<Edgy>("test", "edgy"),
        Kind::of::<Crowd>("test", "crowd"),
        Kind::of::<Lanes>("test", "lanes"),
        Kind::of::<Deaf>("test", "deaf"),
        Kind::of::<GoesOn>("test", "goes_on"),
    ]
}
