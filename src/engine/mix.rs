//! Mixing a result with its input by a mask, the same for every kind.

use crate::name::Name;
use crate::node::{Context, Error, Result};
use crate::ports::Wires;
use crate::value::{Field, Raster, Sample, Value};

/// Replaces each mixed output by `input + mask · (output − input)`; 0 gives the input and 1 the output, bit for bit.
pub(super) fn mix(
    cx: &Context<'_>,
    pairs: &[(Name, Name)],
    inputs: &Wires,
    mask: &Field,
    outputs: &mut Wires,
) -> Result<()> {
    for (output, input) in pairs {
        let (Some(before), Some(after)) = (inputs.get(input), outputs.get(output)) else { continue };
        let mixed = match (before, after) {
            (Value::Field(a), Value::Field(b)) => Value::Field(between(cx, a, b, mask)?),
            (Value::Vectors(a), Value::Vectors(b)) => Value::Vectors(between(cx, a, b, mask)?),
            (Value::Colors(a), Value::Colors(b)) => Value::Colors(between(cx, a, b, mask)?),
            _ => {
                let message = format!("cannot be mixed with input `{input}`: they are of different types");
                return Err(Error::Output { port: output.clone(), message });
            }
        };
        outputs.put(output.clone(), mixed);
    }
    Ok(())
}

fn between<T: Sample>(
    cx: &Context<'_>,
    before: &Raster<T>,
    after: &Raster<T>,
    mask: &Field,
) -> Result<Raster<T>> {
    let (before, after, mask) = (before.crop(&cx.grid), after.crop(&cx.grid), mask.crop(&cx.grid));
    cx.fill(after.quantity(), |row, out: &mut [T]| {
        let (a, b, m) = (before.row(row.j), after.row(row.j), mask.row(row.j));
        let (out, a, b) = (bytemuck::cast_slice_mut(out), bytemuck::cast_slice(a), bytemuck::cast_slice(b));
        for (i, &m) in m.iter().enumerate() {
            for k in i * T::CHANNELS..(i + 1) * T::CHANNELS {
                out[k] = lerp(a[k], b[k], m);
            }
        }
    })
}

fn lerp(a: f32, b: f32, m: f32) -> f32 {
    if m <= 0.0 {
        a
    } else if m >= 1.0 {
        b
    } else {
        a * (1.0 - m) + b * m
    }
}
