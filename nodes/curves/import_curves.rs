//! Curves from a file.

use crate::files::vectors::svg::Fit;
use crate::files::vectors::{Laying, Mapping};
use crate::node::SourceFile;
use crate::nodes::vector_file;
use crate::prelude::*;

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
        vector_file::request(&self.file)
    }

    fn reading(&self, files: &[std::sync::Arc<SourceFile>]) -> Result<Cost> {
        vector_file::cost(files)
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let laying = Laying { fit: self.fit, smooth: self.smooth, spacing: self.spacing.0 };
        Ok(Outputs { curves: vector_file::read(cx, &self.file, laying, &self.mapping)?.curves })
    }
}
