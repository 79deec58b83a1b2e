//! Curves from a file.

use crate::kit::curves::import::geojson::{self, Place};
use crate::kit::curves::import::svg::{self, Fit};
use crate::kit::curves::import::{Imported, Mapping};
use crate::node::SourceFile;
use crate::prelude::*;
use crate::value::curves::CurveError;

/// Seconds that a byte of text takes.
const PARSING_SECONDS: f64 = 0.2e-6;

/// Reads lines from an SVG picture or a GeoJSON file as feature curves.
///
/// Of an SVG every path, line, polyline and polygon is taken; its view box is laid on the terrain. Of GeoJSON every
/// `LineString` and `MultiLineString` is taken, with coordinates in metres to the east and north: on a terrain that
/// lies on Earth in its own coordinate system, else from the terrain's north-west corner. The mapping says which
/// property of a line gives which value of its curve; a list of numbers is spread evenly over the length. In SVG a
/// property is an attribute `data-NAME` or `NAME`.
///
/// # Limits
/// A line of which nothing is set is left out, and so is what is no line; a warning says how many. Coordinates are taken for metres: a file in degrees must be
/// projected first, or all its lines lie within some hundred metres.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportCurves {
    /// The file: `.svg`, `.geojson` or `.json`.
    pub file: FilePath,
    /// What the properties of lines become.
    pub mapping: Mapping,
    /// How a picture comes to lie on the terrain.
    pub fit: Fit,
    /// Whether a curve is smooth through the positions of GeoJSON, rather than straight from each to the next.
    pub smooth: bool,
    /// Positions of GeoJSON nearer to the one before than this are left out.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub spacing: Metres,
}

impl Default for ImportCurves {
    fn default() -> Self {
        Self {
            file: FilePath::default(),
            mapping: Mapping::default(),
            fit: Fit::default(),
            smooth: true,
            spacing: Metres(0.0),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// The curves, in the order of the file.
        curves: Curves,
    }
}

impl Node for ImportCurves {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().reads(Reads::TERRAIN).keywords(&["svg", "geojson", "vector", "path", "line", "load"]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, _: &Grid) -> Cost {
        Cost { bytes: 0, seconds: 0.01 }
    }

    fn files(&self) -> Vec<FileRequest> {
        let named = !self.file.0.is_empty();
        named
            .then(|| FileRequest { parameter: "file", name: self.file.0.clone(), optional: false })
            .into_iter()
            .collect()
    }

    fn reading(&self, files: &[std::sync::Arc<SourceFile>]) -> Cost {
        let content = Cost::of_reading(files);
        // The tree of a text and the curves of its numbers: some tens of times as large as the text.
        let bytes = content.bytes.saturating_mul(32).saturating_add(1 << 20);
        content.and(Cost { bytes, seconds: content.bytes as f64 * PARSING_SECONDS })
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        if self.file.0.is_empty() {
            return Err(Error::Parameter { name: "file".into(), message: "no file chosen".into() });
        }
        let fault = |message: String| Error::File { parameter: "file", file: self.file.0.clone(), message };
        let file = cx.file(&self.file).ok_or_else(|| fault("not found".into()))?;
        let bytes = cx.stage(0.0, 0.2).read("file", file)?;
        let text = std::str::from_utf8(&bytes).map_err(|e| fault(format!("is not UTF-8 text: {e}")))?;
        let read = self.read(cx, text)?;
        let Imported { curves, warnings } = read.map_err(|e| fault(e.to_string()))?;
        warnings.into_iter().for_each(|warning| cx.warn(warning));
        Ok(Outputs { curves })
    }
}

impl ImportCurves {
    fn read(&self, cx: &Context<'_>, text: &str) -> Result<Result<Imported, CurveError>> {
        let terrain = cx.terrain()?;
        let lower = self.file.0.to_ascii_lowercase();
        if lower.ends_with(".svg") {
            return Ok(svg::read(text, terrain.bounds(), self.fit, &self.mapping));
        }
        if !(lower.ends_with(".geojson") || lower.ends_with(".json")) {
            let message = "must end in .svg, .geojson or .json".into();
            return Err(Error::File { parameter: "file", file: self.file.0.clone(), message });
        }
        let place = Place {
            origin: terrain.geo.map_or([0.0, 0.0], |g| [g.east, g.north]),
            at: terrain.origin,
            smooth: self.smooth,
            spacing: self.spacing.0,
        };
        Ok(geojson::read(text, &place, &self.mapping))
    }
}
