//! What a value holds as bytes: equal for equal values, whatever their fields are called.

use orograph::value::curves::{Curve, Rise, Track};
use orograph::value::{Constraints, Curves, Planes, Value};

/// The samples of a raster, the numbers of what is no raster.
pub(crate) fn bytes(value: &Value) -> Vec<u8> {
    match value {
        Value::Object(object) => match (object.get(), object.get()) {
            (Some(curves), _) => of_curves(curves),
            (_, Some(constraints)) => of_constraints(constraints),
            _ => object.save(),
        },
        raster => raster.components().iter().flat_map(|x| x.to_bits().to_le_bytes()).collect(),
    }
}

/// Bytes that parts are written to, each with its length.
#[derive(Default)]
struct Out(Vec<u8>);

impl Out {
    fn part(&mut self, bytes: &[u8]) {
        self.0.extend((bytes.len() as u64).to_le_bytes());
        self.0.extend(bytes);
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        let bytes: Vec<u8> = numbers.into_iter().flat_map(|v| v.to_bits().to_le_bytes()).collect();
        self.part(&bytes);
    }

    fn track<const N: usize>(&mut self, track: &Option<Track<N>>) {
        let keys = track.iter().flat_map(|t| t.keys());
        self.numbers(keys.flat_map(|(u, values)| [*u].into_iter().chain(*values)));
    }

    fn curve(&mut self, curve: &Curve) {
        self.part(curve.name().as_bytes());
        self.numbers(curve.knots().iter().flatten().copied());
        self.part(match curve.rise() {
            Rise::Monotone => b"monotone",
            Rise::Free => b"free",
        });
        let tracks = curve.tracks();
        self.track(&tracks.elevation);
        self.track(&tracks.slope);
        self.track(&tracks.noise);
        self.track(&tracks.envelope);
    }

    fn plane<T: bytemuck::NoUninit>(&mut self, plane: &Option<Vec<T>>) {
        self.part(plane.as_ref().map_or(&[], |p| bytemuck::cast_slice(p)));
    }
}

fn of_curves(curves: &Curves) -> Vec<u8> {
    let mut out = Out::default();
    curves.iter().for_each(|curve| out.curve(curve));
    out.0
}

fn of_constraints(constraints: &Constraints) -> Vec<u8> {
    let mut out = Out::default();
    let Planes { marks, height, lean, direction, steepness, trust, ground, noise, envelope } =
        constraints.planes();
    out.part(marks);
    [height, steepness, trust, ground, envelope].into_iter().for_each(|plane| out.plane(plane));
    [lean, direction, noise].into_iter().for_each(|plane| out.plane(plane));
    out.0
}
