//! The settings of the terrain: their schema, and the terrain made of them.

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde_json::{Map, Value as Json};

use super::problem::{Hints, Place, Problem, listed};
use crate::params::{self, Param};
use crate::value::{Geo, MAX_BASE, MAX_EXTENT, MIN_SIZE, Terrain};
use crate::widget::Widget;

/// What the settings may be; a [`Terrain`] is made of them.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields, rename = "Settings")]
#[allow(
    dead_code,
    reason = "only its schema is used: for checks, for `--set` and for the schema that is published"
)]
pub(super) struct TerrainSettings {
    /// North-west corner, x to the east and y to the south.
    #[schemars(inner(range(min = -1.0e8, max = 1.0e8)), extend("x-unit" = "m"))]
    origin: [f64; 2],
    /// East-west extent.
    #[schemars(range(min = 1.0, max = MAX_EXTENT), extend("x-unit" = "m"))]
    width: f64,
    /// North-south extent.
    #[schemars(range(min = 1.0, max = MAX_EXTENT), extend("x-unit" = "m"))]
    depth: f64,
    /// Height of the water; null where the land is dry however low it lies.
    #[schemars(range(min = -1.0e5, max = 1.0e5), extend("x-unit" = "m"))]
    sea_level: Option<f64>,
    /// Seed of the whole graph; every random choice mixes it in.
    #[schemars(range(min = 0, max = 4_294_967_295_u32), extend("x-unit" = "1", "x-widget" = Widget::Seed))]
    seed: u32,
    /// Samples along the longer side of the base grid, on which global nodes run.
    #[schemars(range(min = MIN_SIZE, max = MAX_BASE), extend("x-unit" = "1"))]
    base: u32,
    /// Where the terrain lies on Earth, if it does.
    geo: Option<GeoSettings>,
}

/// The projected coordinates of the north-west corner.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[allow(dead_code, reason = "only its schema is used, as that of `TerrainSettings`")]
struct GeoSettings {
    /// EPSG code of a projected coordinate system in metres.
    #[schemars(range(min = 1, max = 999_999))]
    epsg: u32,
    /// Easting of the corner.
    #[schemars(range(min = -1.0e9, max = 1.0e9), extend("x-unit" = "m"))]
    east: f64,
    /// Northing of the corner.
    #[schemars(range(min = -1.0e9, max = 1.0e9), extend("x-unit" = "m"))]
    north: f64,
}

/// The settings of a terrain as parameters: `origin`, `width`, `depth`, `sea_level`, `seed`, `base` and `geo`.
pub fn terrain_params() -> &'static [Param] {
    static PARAMS: LazyLock<Vec<Param>> = LazyLock::new(|| {
        let mut defaults = serde_json::to_value(Terrain::default()).unwrap_or(Json::Null);
        super::json::tidy(&mut defaults);
        params::of_schema(&schemars::schema_for!(TerrainSettings).to_value(), &defaults)
    });
    &PARAMS
}

/// The terrain made of settings. Settings that do not fit, or contradict each other, have their defaults instead, so
/// that the terrain never has a [`Terrain::fault`]; [`faults`] reports them.
pub(super) fn terrain(settings: &Map<String, Json>) -> Terrain {
    let mut terrain = read(settings);
    let default = Terrain::default();
    while let Some((name, _)) = terrain.fault() {
        match name {
            "base" if terrain.base != default.base => terrain.base = default.base,
            "geo" if terrain.geo.is_some() => terrain.geo = None,
            _ => return default,
        }
    }
    terrain
}

/// The terrain made of the settings that fit by themselves.
fn read(settings: &Map<String, Json>) -> Terrain {
    let mut terrain = Terrain::default();
    for param in terrain_params() {
        let Some(value) = settings.get(&param.name).filter(|v| param.shape.check(v).is_ok()) else {
            continue;
        };
        let number = || value.as_f64().unwrap_or_default();
        let whole = || value.as_u64().unwrap_or_default() as u32;
        match param.name.as_str() {
            "origin" => terrain.origin = serde_json::from_value(value.clone()).unwrap_or_default(),
            "width" => terrain.width = number(),
            "depth" => terrain.depth = number(),
            "sea_level" => terrain.sea_level = value.as_f64(),
            "seed" => terrain.seed = whole(),
            "base" => terrain.base = whole(),
            _ => terrain.geo = serde_json::from_value::<Option<Geo>>(value.clone()).unwrap_or_default(),
        }
    }
    terrain
}

/// The problems of the settings.
pub(super) fn faults(settings: &Map<String, Json>, hints: &Hints) -> Vec<Problem> {
    let mut found = Vec::new();
    let names = || terrain_params().iter().map(|p| p.name.as_str());
    for param in terrain_params() {
        let Some(value) = settings.get(&param.name) else { continue };
        let fault = param.shape.check(value).and_then(|()| match param.name.as_str() {
            "geo" => serde_json::from_value::<Option<Geo>>(value.clone())
                .map(drop)
                .map_err(|e| format!("cannot be read: {e}; it needs epsg, east and north")),
            _ => Ok(()),
        });
        found.extend(fault.err().map(|message| Problem::error(Place::Terrain(param.name.clone()), message)));
    }
    for name in settings.keys().filter(|name| names().all(|known| known != *name)) {
        let (known, hint) = (listed(names()), hints.nearest(name, names()));
        let message = format!("is not known and kept as it is; known are {known}{hint}");
        found.push(Problem::warning(Place::Terrain(name.clone()), message));
    }
    if found.iter().all(|p| !p.is_error())
        && let Some((name, message)) = read(settings).fault()
    {
        found.push(Problem::error(Place::Terrain(name.to_owned()), message));
    }
    found
}

/// The settings to write: all known ones with their values or defaults, then the unknown ones.
pub(super) fn written(settings: &Map<String, Json>) -> Map<String, Json> {
    let value = |p: &Param| settings.get(&p.name).unwrap_or(&p.default).clone();
    let all = terrain_params().iter().map(|p| (p.name.clone(), value(p)));
    let mut map: Map<String, Json> = all.collect();
    map.extend(settings.iter().map(|(k, v)| (k.clone(), v.clone())));
    map.retain(|name, v| name != "geo" || !v.is_null());
    map
}
