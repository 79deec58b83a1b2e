//! Where the samples of a file lie: its own coordinates, and how long a step is on the ground.

use super::epsg::{self, Unit};

/// Semi-major axis of the WGS 84 ellipsoid, in metres.
const SEMI_MAJOR: f64 = 6_378_137.0;
/// Square of its first eccentricity.
const ECCENTRICITY_2: f64 = 0.006_694_379_990_141_33;

/// From sample indices to the coordinates of the file's own system.
///
/// Sample `(i, j)`, columns and rows counted from the north-west, stands at `origin + i · col + j · row`; the first
/// coordinate grows to the east, the second to the north. It is the sample itself that stands there, whether the
/// file means points or the middle of areas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Where sample (0, 0) stands.
    pub origin: [f64; 2],
    /// The step from a column to the next.
    pub col: [f64; 2],
    /// The step from a row to the next.
    pub row: [f64; 2],
}

impl Affine {
    /// Columns to the east and rows to the south, from the north-west sample.
    pub fn upright(origin: [f64; 2], step: [f64; 2]) -> Self {
        Self { origin, col: [step[0], 0.0], row: [0.0, -step[1]] }
    }

    /// Whether columns run to the east and rows to the south, but for what rounding leaves: a thousandth of a cell over
    /// a million samples.
    pub fn is_north_up(&self) -> bool {
        let along = |step: [f64; 2], k: usize| step[1 - k].abs() <= 1e-9 * step[k].abs();
        self.col[0] > 0.0 && self.row[1] < 0.0 && along(self.col, 0) && along(self.row, 1)
    }

    /// Where a sample stands; its indices may be fractions.
    pub fn at(&self, i: f64, j: f64) -> [f64; 2] {
        let axis = |k: usize| self.origin[k] + i * self.col[k] + j * self.row[k];
        [axis(0), axis(1)]
    }

    /// The map from coordinates to sample indices; `None` where the steps do not span a plane.
    pub fn inverse(&self) -> Option<impl Fn([f64; 2]) -> [f64; 2] + Copy + Sync + use<>> {
        let Self { origin, col, row } = *self;
        let det = col[0] * row[1] - col[1] * row[0];
        let finite = origin.iter().chain(&col).chain(&row).all(|v| v.is_finite());
        (finite && det.is_normal()).then_some(move |p: [f64; 2]| {
            let [x, y] = [p[0] - origin[0], p[1] - origin[1]];
            [(x * row[1] - y * row[0]) / det, (col[0] * y - col[1] * x) / det]
        })
    }

    /// Whether it can be a place: finite, and with steps that are some.
    pub(super) fn is_sound(&self) -> bool {
        let mut all = self.origin.iter().chain(&self.col).chain(&self.row);
        all.all(|v| v.is_finite()) && self.col != [0.0; 2] && self.row != [0.0; 2]
    }

    /// Whether columns run along the first coordinate and rows along the second.
    pub fn is_upright(&self) -> bool {
        self.col[1] == 0.0 && self.row[0] == 0.0
    }
}

/// What a sample stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The mean of a cell around it: `AREA_OR_POINT=Area`.
    Area,
    /// The point itself: `AREA_OR_POINT=Point`.
    Point,
}

/// The unit of a file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Units {
    /// Projected, with the length of a unit in metres.
    Length(f64),
    /// Longitude and latitude, in degrees.
    Degrees,
    /// Web Mercator (EPSG:3857): nominal metres that are shorter on the ground away from the equator.
    WebMercator,
}

/// Where the samples of a file lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The file's own coordinates, if it has some.
    pub affine: Option<Affine>,
    /// What a sample stands for.
    pub anchor: Anchor,
    /// EPSG code of the coordinates, if the file names one.
    pub epsg: Option<u32>,
    /// The unit of the coordinates.
    pub units: Units,
    /// Steps from column to column and from row to row on the ground, in metres; those of degrees and of web
    /// Mercator are taken at the middle of the file.
    pub cell: Option<[f64; 2]>,
}

impl Default for Placement {
    fn default() -> Self {
        Self { affine: None, anchor: Anchor::Area, epsg: None, units: Units::Length(1.0), cell: None }
    }
}

impl Placement {
    /// The placement of a grid of some columns and rows whose coordinates are known.
    pub(super) fn new(
        affine: Affine,
        anchor: Anchor,
        epsg: Option<u32>,
        units: Units,
        size: [usize; 2],
    ) -> Self {
        let middle =
            affine.at(size[0].saturating_sub(1) as f64 / 2.0, size[1].saturating_sub(1) as f64 / 2.0);
        let unit = units.ground(middle[1]);
        let step = |v: [f64; 2]| libm::hypot(v[0] * unit[0], v[1] * unit[1]);
        let cell = [step(affine.col), step(affine.row)];
        let sound = cell.iter().all(|c| c.is_finite() && *c > 0.0);
        Self { affine: Some(affine), anchor, epsg, units, cell: sound.then_some(cell) }
    }

    /// Only the length of a step is known.
    pub(super) fn of_cell(cell: [f64; 2]) -> Self {
        Self { cell: Some(cell), anchor: Anchor::Point, ..Self::default() }
    }

    /// Extent from the first to the last sample on the ground, in metres.
    pub fn extent(&self, cols: usize, rows: usize) -> Option<[f64; 2]> {
        self.cell.map(|[x, y]| [x * cols.saturating_sub(1) as f64, y * rows.saturating_sub(1) as f64])
    }
}

/// The farthest latitude that a file may have, in degrees: the pole, with a degree for the cell around the last sample.
pub(super) const FARTHEST_NORTH: f64 = 90.0 + 1.0;

impl Units {
    /// The units of an EPSG code, where the code alone tells.
    pub(super) fn of_epsg(epsg: u32) -> Option<Self> {
        match epsg {
            3857 | 3785 | 900_913 | 102_100 | 102_113 => Some(Self::WebMercator),
            _ if epsg::horizontal(epsg) == Some(Unit::Degrees) => Some(Self::Degrees),
            _ => None,
        }
    }

    /// What coordinates without a system are: degrees when they fit the globe and step by less than a tenth of a
    /// unit, as no height model in metres does.
    pub(super) fn guess(affine: &Affine, size: [usize; 2]) -> Self {
        let far = affine.at(size[0] as f64, size[1] as f64);
        // Longitudes go from -180 to 180 or from 0 to 360, with a degree for the cell around the last sample.
        let on_globe = |p: [f64; 2]| p[0].abs() <= 361.0 && p[1].abs() <= FARTHEST_NORTH;
        let small = affine.col[0].abs() < 0.1 && affine.row[1].abs() < 0.1;
        if small && on_globe(affine.origin) && on_globe(far) { Self::Degrees } else { Self::Length(1.0) }
    }

    /// Metres on the ground for one unit to the east and one to the north, at a second coordinate.
    fn ground(self, north: f64) -> [f64; 2] {
        match self {
            Self::Length(metres) => [metres, metres],
            Self::Degrees => {
                let [east, north] = radii(north.clamp(-90.0, 90.0).to_radians());
                [east.to_radians(), north.to_radians()]
            }
            Self::WebMercator => {
                let half = std::f64::consts::FRAC_PI_2;
                let latitude = 2.0 * libm::atan(libm::exp(north / SEMI_MAJOR)) - half;
                let [east, north] = radii(latitude);
                let shrink = libm::cos(latitude);
                [east / SEMI_MAJOR, north * shrink / SEMI_MAJOR]
            }
        }
    }
}

/// Metres for one radian of longitude and of latitude on the ellipsoid, at a latitude in radians.
fn radii(latitude: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(latitude);
    let w2 = 1.0 - ECCENTRICITY_2 * sin * sin;
    let normal = SEMI_MAJOR / w2.sqrt();
    [normal * cos, normal * (1.0 - ECCENTRICITY_2) / w2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_has_its_length() {
        // Kilometres, as the encyclopaedias print them for WGS 84.
        for (latitude, east, north) in [
            (0.0, 111.320, 110.574),
            (15.0, 107.550, 110.649),
            (30.0, 96.486, 110.852),
            (45.0, 78.847, 111.132),
            (60.0, 55.800, 111.412),
            (75.0, 28.902, 111.618),
            (90.0, 0.0, 111.694),
        ] {
            let [e, n] = Units::Degrees.ground(latitude).map(|m| m / 1000.0);
            assert!((e - east).abs() < 6e-4 && (n - north).abs() < 6e-4, "{latitude}: {e}, {n}");
        }
    }

    #[test]
    fn web_mercator_shrinks_away_from_the_equator() {
        let [e, n] = Units::WebMercator.ground(0.0);
        assert!((e - 1.0).abs() < 1e-12 && (n - 0.993_305_62).abs() < 1e-6);
        // 36.1 degrees north: the Grand Canyon.
        let [e, _] = Units::WebMercator.ground(4_313_000.0);
        assert!((e - 0.8088).abs() < 5e-4, "{e}");
    }

    #[test]
    fn the_inverse_undoes_the_map() {
        let a = Affine { origin: [500.0, -20.0], col: [3.0, 1.0], row: [0.5, -2.0] };
        let back = a.inverse().expect("spans a plane");
        let [i, j] = back(a.at(7.25, -3.5));
        assert!((i - 7.25).abs() < 1e-12 && (j + 3.5).abs() < 1e-12);
        assert!(Affine { row: [3.0, 1.0], ..a }.inverse().is_none());
    }
}
