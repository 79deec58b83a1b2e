//! Rivers from a file.

use crate::files::vectors::svg::Fit;
use crate::files::vectors::{FileLine, Laying, Property, Wanted};
use crate::kit::curves::flatten::flatten;
use crate::kit::flow::join::Polyline;
use crate::nodes::vector_file;
use crate::prelude::*;
use crate::value::Curve;
use crate::value::curves::{ConstraintPoint, Noise, Rise};
use crate::value::rivers::MAX_VERTICES;
use crate::value::rivers::written::{self, WrittenRiver};

use super::network;

/// How far straight links may lie from a bent line, in metres.
const TOLERANCE: f64 = 1.0;

/// Reads lines from an SVG picture or a GeoJSON file as a river network.
///
/// Every line is a river, whatever is known of it; which lines are taken and where they come to lie is that of
/// `import_curves`. The end of a line that comes within `snap` of another joins it, at its nearest place; all other ends
/// are outlets. Beds have the third coordinates of GeoJSON, or 0 where there are none, and fall all the way.
///
/// A file that a build wrote of rivers has the numbers of the vertices, the areas and the widths as properties: the
/// network comes back as it was, and nothing is joined. In SVG the heights are lost.
///
/// In other files the area that drains through a vertex is that of the Voronoi cells upstream inside the terrain, and a
/// river is `width · √(A / 1 km²)` wide \[leopold1953\]. `river_profile` gives beds heights.
///
/// # Limits
/// A file may have 64 MiB and 1,048,576 positions. Rivers that would run in a circle are left apart: of those that close
/// it, the one that stands last keeps its end as an outlet.
///
/// # See also
/// `import_curves`, `rivers_from_curves`, `extract_rivers`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportRivers {
    /// The file: `.svg`, `.geojson` or `.json`.
    pub file: FilePath,
    /// How a picture comes to lie on the terrain.
    pub fit: Fit,
    /// Which way the lines run.
    pub direction: LineDirection,
    /// Distance within which the end of a river joins another.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 200.0]))]
    pub snap: Metres,
    /// Width of a river that drains a square kilometre.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 50.0]))]
    pub width: Metres,
}

/// Which way the lines of a file of rivers run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LineDirection {
    /// From source to mouth, as maps have them.
    #[default]
    Downstream,
    /// From mouth to source.
    Upstream,
    /// Each from its higher end to its lower.
    ByHeight,
}

impl Default for ImportRivers {
    fn default() -> Self {
        Self {
            file: FilePath::default(),
            fit: Fit::default(),
            direction: LineDirection::default(),
            snap: Metres(30.0),
            width: Metres(4.0),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// The network.
        rivers: Rivers,
    }
}

impl Node for ImportRivers {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .reads(Reads::TERRAIN)
        .cite(&["leopold1953"])
        .keywords(&["river", "stream", "network", "geojson", "svg", "vector", "osm", "load"]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, _: &Load<'_>) -> Cost {
        Cost { bytes: 0, seconds: 0.01 }
    }

    fn files(&self) -> Vec<FileRequest> {
        vector_file::request(&self.file)
    }

    fn reading(&self, files: &[std::sync::Arc<crate::node::SourceFile>]) -> Result<Cost> {
        vector_file::cost(files)
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let laying = Laying { fit: self.fit, smooth: false, spacing: 0.0 };
        let wanted = Wanted::Lines(&written::NAMES);
        let lines = vector_file::read(&cx.stage(0.0, 0.6), &self.file, laying, wanted)?.lines;
        let rivers = match written::network(lines.iter().map(as_written)) {
            Some(vertices) => network::made(vertices)?,
            None => self.joined(&cx.stage(0.6, 1.0), &lines)?,
        };
        Ok(Outputs { rivers })
    }
}

impl ImportRivers {
    /// A network of lines whose ends join others.
    fn joined(&self, cx: &Context<'_>, lines: &[FileLine]) -> Result<Rivers> {
        let mut left = MAX_VERTICES;
        let mut ways = Vec::with_capacity(lines.len());
        for (n, line) in lines.iter().enumerate() {
            cx.work.step(0.3 * n as f32 / lines.len() as f32)?;
            let mut corners = corners(line, left).map_err(|message| self.fault(message))?;
            left -= corners.len();
            let [first, last] = [corners.first(), corners.last()].map(|c| c.map_or(0.0, |c| c[2]));
            let turned = match self.direction {
                LineDirection::Downstream => false,
                LineDirection::Upstream => true,
                LineDirection::ByHeight => first < last,
            };
            if turned {
                corners.reverse();
            }
            ways.push(Polyline(corners));
        }
        network::of_lines(&cx.stage(0.3, 1.0), &ways, [self.snap, self.width], |message| self.fault(message))
    }

    fn fault(&self, message: String) -> Error {
        Error::File { parameter: "file", file: self.file.0.clone(), message }
    }
}

/// The corners of a line with their heights, as many as may be.
fn corners(line: &FileLine, most: usize) -> Result<Vec<[f64; 3]>, String> {
    // A curve says something; what does not matter here.
    let noise = Some(Noise { amplitude: 0.0, roughness: 0.0 });
    let point = ConstraintPoint { noise, ..ConstraintPoint::default() };
    let curve = Curve::new(String::new(), line.knots.clone(), &[point], Rise::default());
    let curve = curve.map_err(|fault| format!("line `{}` {fault}", line.name))?;
    let flat = flatten(&curve, TOLERANCE, most);
    let flat = flat.ok_or_else(|| format!("its lines have more than {MAX_VERTICES} corners"))?;
    Ok(flat.iter().map(|vertex| [vertex.at[0], vertex.at[1], line.height(vertex.u)]).collect())
}

/// A line as a build wrote it: positions, heights and the properties of the file.
fn as_written(line: &FileLine) -> WrittenRiver<'_> {
    let list = |name: &str| line.properties.get(name).map(Property::numbers).unwrap_or_default();
    WrittenRiver {
        at: line.knots.iter().step_by(3).copied().collect(),
        heights: line.heights.iter().map(|&(_, height)| height).collect(),
        numbers: list(written::VERTEX),
        areas: list(written::AREA),
        widths: list(written::WIDTH),
    }
}
