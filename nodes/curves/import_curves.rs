//! Curves from a file.

use crate::files::vectors::geojson::{self, Place};
use crate::files::vectors::svg::{self, Fit};
use crate::files::vectors::{Imported, MAX_FILE, Mapping};
use crate::node::SourceFile;
use crate::prelude::*;
use crate::source::reading;
use crate::value::curves::CurveError;

/// Seconds that a byte of text takes.
const PARSING_SECONDS: f64 = 0.2e-6;

/// Reads lines from an SVG picture or a GeoJSON file as feature curves.
///
/// Of an SVG every path and shape is taken, each subpath as a curve: `path`, `line`, `polyline`, `polygon`, `rect`,
/// `circle`, `ellipse`, also where `use` draws them or an inner `svg` holds them. The page, as large as its `width` and
/// `height` say in px, in, cm, mm, Q, pt, pc, em or ex, else its view box, is laid on the terrain.
/// Of GeoJSON every `LineString` and
/// `MultiLineString` is taken and every ring of a `Polygon` and `MultiPolygon`, with coordinates to the east and north, in
/// metres or the unit of the file's coordinate system: on a terrain that lies on Earth in its own system, else from the
/// terrain's north-west corner.
/// The mapping says which property of a line gives which value of its curve; a list of numbers is spread evenly over the
/// length. In SVG a property is an attribute `data-NAME` or `NAME` of the element, or of the `use` that draws it.
///
/// # Limits
/// What cannot be a curve is left out: points, texts, lines without length, with broken data or on which nothing is set;
/// a warning for each kind says how many and where the first stands, and one that nothing is left. Nothing is reprojected:
/// a file that says it is in degrees or in another coordinate system than the terrain, by `crs` or `coordRefSys` on any of
/// its objects, is refused; `coordRefSys` speaks of `place`, and a `geometry` beside it is in degrees. Of the styles of a
/// picture `display`, `visibility` and transforms count, from attributes and from rules of style sheets for an element, a
/// class, an `id` or `*`; a warning names what else would count, and nothing is clipped. No file beside this one is read.
/// A file may have 64 MiB, 1,048,576 positions and as many elements, 8 MiB of style sheets with 65,536 selectors, and give
/// 65,536 curves; a line may have 16,385 points.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImportCurves {
    /// The file: `.svg`, `.geojson` or `.json`.
    pub file: FilePath,
    /// What the properties of lines become: for each value of the curves where it comes from.
    #[schemars(extend("examples" = [{
        "height": { "property": { "name": "elevation" } }, "left_extent": { "value": { "value": 300 } },
        "right_extent": { "value": { "value": 300 } }, "left_angle": { "property": { "name": "slope", "factor": -1 } },
        "right_angle": { "property": { "name": "slope", "factor": -1 } }, "amplitude": { "z": { "factor": 0.05 } },
    }]))]
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
    // Version 2 reads shapes, `use`, units and rings, and lays the page on the terrain, not the view box: the parameters
    // are as they were. Version 3 reads style sheets and the styles of elements, and the systems of features and geometries.
    const META: Meta = Meta::new()
        .reads(Reads::TERRAIN)
        .keywords(&["svg", "geojson", "vector", "path", "line", "load"])
        .migrations(&[|_| (), |_| ()]);

    fn reach(&self) -> Reach {
        Reach::Gridless
    }

    fn cost(&self, _: &Load<'_>) -> Cost {
        Cost { bytes: 0, seconds: 0.01 }
    }

    fn files(&self) -> Vec<FileRequest> {
        let named = !self.file.0.is_empty();
        named
            .then(|| FileRequest { parameter: "file", name: self.file.0.clone(), optional: false })
            .into_iter()
            .collect()
    }

    fn reading(&self, files: &[std::sync::Arc<SourceFile>]) -> Result<Cost> {
        if files.is_empty() {
            return Err(Error::no_file("file"));
        }
        let content = reading(files);
        if let Some(long) = files.iter().find(|f| f.len() > MAX_FILE as u64) {
            let (file, found) = (long.name().to_owned(), long.len());
            let too_long = CurveError::TooMany { what: "bytes of the file", most: MAX_FILE as u64, found };
            return Err(Error::File { parameter: "file", file, message: too_long.to_string() });
        }
        // The elements of a text and the curves of its numbers are some tens of times as large as the text, and so are the
        // rules of its style sheets. `use` may make of a small picture as much as 65 536 lines take.
        let picture = files.iter().any(|f| f.name().to_ascii_lowercase().ends_with(".svg"));
        let more = if picture { 48 << 20 } else { 1 << 20 };
        let bytes = content.bytes.saturating_mul(40).saturating_add(more);
        Ok(content.and(Cost { bytes, seconds: content.bytes as f64 * PARSING_SECONDS }))
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        if self.file.0.is_empty() {
            return Err(Error::no_file("file"));
        }
        let fault = |message: String| Error::File { parameter: "file", file: self.file.0.clone(), message };
        let file = cx.file(&self.file).ok_or_else(|| fault("not found".into()))?;
        let bytes = cx.stage(0.0, 0.2).read("file", file)?;
        let Imported { curves, warnings } = self.read(&cx.stage(0.2, 1.0), &bytes)?.map_err(|e| match e {
            CurveError::Cancelled => Error::Cancelled,
            other => fault(other.to_string()),
        })?;
        warnings.into_iter().for_each(|warning| cx.warn(warning));
        Ok(Outputs { curves })
    }
}

impl ImportCurves {
    fn read(&self, cx: &Context<'_>, bytes: &[u8]) -> Result<Result<Imported, CurveError>> {
        let terrain = cx.terrain()?;
        let go_on = |share: f32| {
            cx.report(share);
            !cx.work.is_cancelled()
        };
        let lower = self.file.0.to_ascii_lowercase();
        if lower.ends_with(".svg") {
            return Ok(svg::read(bytes, terrain.bounds(), self.fit, &self.mapping, &go_on));
        }
        if !(lower.ends_with(".geojson") || lower.ends_with(".json")) {
            let message = "must end in .svg, .geojson or .json".into();
            return Err(Error::File { parameter: "file", file: self.file.0.clone(), message });
        }
        let place = Place { smooth: self.smooth, spacing: self.spacing.0, ..Place::on(terrain) };
        Ok(geojson::read(bytes, &place, &self.mapping, &go_on))
    }
}
