//! The registry: every node kind, one line each, in folders by family.
//!
//! A line `family { file: Struct }` declares the module `nodes/family/file.rs` and registers its kind under the
//! name of the file; `family with shared` declares a module that its kinds share.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use crate::name::Name;
use crate::node::Kind;
use crate::params::did_you_mean;

pub(crate) mod vector_file;

macro_rules! registry {
    ($($(#[$doc:meta])* $family:ident $(with $shared:ident)? { $($file:ident : $kind:ident),* $(,)? })+) => {
        $($(#[$doc])* pub mod $family {
            $(pub mod $shared;)?
            $(pub mod $file;)*
        })+
        static STANDARD: LazyLock<Registry> = LazyLock::new(|| Registry::of([
            $($(Kind::of::<$family::$file::$kind>(stringify!($family), stringify!($file)),)*)+
        ]));
    };
}

registry! {
    /// Makes fields from nothing.
    generate {
        cellular_noise: CellularNoise,
        constant: Constant,
        fractal_noise: FractalNoise,
        gradient: Gradient,
        multifractal: Multifractal,
    }

    /// Reads heights and pictures from files.
    files {
        import_height: ImportHeight,
        import_picture: ImportPicture,
    }

    /// Draws, reads and changes feature curves, and makes land of them.
    curves with short {
        cliff: Cliff,
        crack: Crack,
        curve_raster: CurveRaster,
        diffuse: Diffuse,
        diffuse_points: DiffusePoints,
        feature_curves: FeatureCurves,
        hill: Hill,
        import_curves: ImportCurves,
        merge_curves: MergeCurves,
        ridge_line: RidgeLine,
        river_bed: RiverBed,
        transform_curves: TransformCurves,
    }

    /// Makes land of rivers, and follows water over any land.
    rivers with network {
        carve_rivers: CarveRivers,
        curves_from_rivers: CurvesFromRivers,
        draw_ridges: DrawRidges,
        draw_rivers: DrawRivers,
        enrich: Enrich,
        extract_ridges: ExtractRidges,
        extract_rivers: ExtractRivers,
        fill_depressions: FillDepressions,
        flow_routing: FlowRouting,
        import_rivers: ImportRivers,
        infill_rivers: InfillRivers,
        lakes: Lakes,
        meander_rivers: MeanderRivers,
        river_profile: RiverProfile,
        rivers_from_curves: RiversFromCurves,
        skeleton_raster: SkeletonRaster,
        tokunaga_rivers: TokunagaRivers,
        voronoi_ridges: VoronoiRidges,
        water_depth: WaterDepth,
        watersheds: Watersheds,
        wetness: Wetness,
    }

    /// Lets land rise and wear.
    erosion {
        hydraulic_erosion: HydraulicErosion,
        stream_power: StreamPower,
        thermal_erosion: ThermalErosion,
    }

    /// Puts two fields together.
    blend {
        combine: Combine,
        mix: Mix,
        mix_colors: MixColors,
        poisson_blend: PoissonBlend,
        switch: Switch,
    }

    /// Changes a field.
    filter {
        blur: Blur,
        clamp: Clamp,
        curve: Curve,
        edge_falloff: EdgeFalloff,
        equalize: Equalize,
        invert: Invert,
        median: Median,
        remap: Remap,
        sharpen: Sharpen,
        terrace: Terrace,
        transform: Transform,
        warp: Warp,
    }

    /// Finds places by height, slope, direction, form or hand, and shows them.
    select {
        colorize: Colorize,
        distance: Distance,
        expand: Expand,
        hillshade: Hillshade,
        normals: Normals,
        occlusion: Occlusion,
        paint_mask: PaintMask,
        select_aspect: SelectAspect,
        select_curvature: SelectCurvature,
        select_height: SelectHeight,
        select_slope: SelectSlope,
    }
}

/// The kinds that a graph may use; cheap to clone.
#[derive(Clone, Debug)]
pub struct Registry(Arc<BTreeMap<Name, Arc<Kind>>>);

impl Registry {
    /// The kinds of this program.
    pub fn standard() -> Self {
        STANDARD.clone()
    }

    /// A registry of some kinds; of two with one name the later stays.
    pub fn of(kinds: impl IntoIterator<Item = impl Into<Arc<Kind>>>) -> Self {
        Self(Arc::default()).with(kinds)
    }

    /// This registry and some kinds more.
    #[must_use]
    pub fn with(mut self, kinds: impl IntoIterator<Item = impl Into<Arc<Kind>>>) -> Self {
        let named = kinds.into_iter().map(Into::into).map(|kind: Arc<Kind>| (kind.id.clone(), kind));
        Arc::make_mut(&mut self.0).extend(named);
        self
    }

    /// The kind of a name.
    pub fn find(&self, id: &str) -> Option<&Arc<Kind>> {
        self.0.get(id)
    }

    /// All kinds, by name.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<Kind>> {
        self.0.values()
    }

    /// "; did you mean `x`?" for the kind of the nearest name, or nothing when none is near.
    pub fn suggest(&self, id: &str) -> String {
        did_you_mean(id, self.0.keys().map(Name::as_str))
    }
}
