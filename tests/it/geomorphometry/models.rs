//! Real elevation models, where the machine has them: against the figures that another program measured, and the table
//! of this one.

use std::path::{Path, PathBuf};

use orograph::files::{Limits, read_height};
use orograph::kit::geomorphometry::{Figures, Land};
use orograph::work::Work;
use serde_json::{Value as Json, json};

use crate::rig;
use crate::rig::skip::skip;

/// A model of the index, or a coarser one made of it.
struct Model {
    name: String,
    file: String,
    cell: Option<f64>,
    scale: f64,
    sea: Option<f64>,
    target: Option<f64>,
    /// What the other program measured.
    want: Json,
}

fn folder(test: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/dem");
    let folder = std::env::var_os("OROGRAPH_DEM").map_or_else(beside, PathBuf::from);
    if folder.join("metrics.json").is_file() {
        return Some(folder);
    }
    let at = folder.display();
    skip(test, &format!("no elevation models at {at}; set OROGRAPH_DEM to their folder"), &folder);
    None
}

fn list(folder: &Path) -> Vec<Model> {
    let read = |name: &str| -> Vec<Json> {
        serde_json::from_slice(&std::fs::read(folder.join(name)).expect("reads")).expect("parses")
    };
    let index = read("index.json");
    let model = |want: Json| {
        let name = want["name"].as_str().expect("a name").to_owned();
        let (file, target) =
            name.split_once('@').map_or((&*name, None), |(file, target)| (file, Some(target)));
        let entry = index.iter().find(|entry| entry["file"] == file).expect("the index has it");
        // What has a georeference says its cell itself.
        let cell = entry["cell_m"].as_f64().filter(|_| file.ends_with(".png"));
        Model {
            file: file.to_owned(),
            cell,
            scale: entry["zscale"].as_f64().unwrap_or(1.0),
            sea: entry["sea"].as_f64(),
            target: target.and_then(|t| t.trim_end_matches('m').parse().ok()),
            name: name.clone(),
            want,
        }
    };
    let is_read = |model: &Model| [".nc", ".npz"].iter().all(|end| !model.file.ends_with(end));
    read("metrics.json").into_iter().map(model).filter(is_read).collect()
}

fn measured(folder: &Path, model: &Model) -> Json {
    let bytes = std::fs::read(folder.join(&model.file)).expect("the index names files that are there");
    let file = read_height(&model.file, &bytes, None, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
    let own = || file.placement.cell.map(|[x, y]| (x * y).sqrt());
    // `carrizo.tif` has no coordinate system; its cell is in the index.
    let cell = model.cell.or_else(own).unwrap_or_else(|| model.want["cell_m"].as_f64().expect("a cell"));
    let heights = file.data.iter().map(|z| (f64::from(*z) * model.scale) as f32).collect();
    let land = Land::new(file.cols, file.rows, cell, heights);
    let side = model.target.map_or(1, |target| land.block(target));
    let land = land.averaged(side);
    let land = model.sea.map_or(land.clone(), |sea| land.above_sea(sea));
    json!(Figures::of(&land, None, &Work::default()).unwrap().expect("some land"))
}

/// Figures that are the same to 1 %, and those of networks to 3 %: here, there, and what is next to nothing.
const SAME: [(&str, &str, f64, f64); 31] = [
    ("/hypsometry/integral", "/hypsometry/HI", 0.01, 0.0),
    ("/hypsometry/robust_integral", "/hypsometry/HI_robust", 0.01, 0.0),
    ("/hypsometry/skewness", "/hypsometry/skew", 0.01, 1e-3),
    ("/hypsometry/deviation", "/std", 0.01, 0.0),
    ("/spectrum/beta", "/spectrum/beta_2d", 0.01, 0.0),
    ("/spectrum/beta_fine", "/spectrum/beta_fine", 0.01, 0.0),
    ("/spectrum/beta_coarse", "/spectrum/beta_coarse", 0.01, 0.0),
    ("/spectrum/finest_power", "/spectrum/hf_ratio", 0.01, 0.0),
    ("/spectrum/stripes_east_west", "/spectrum/stripe_y", 0.01, 0.0),
    ("/spectrum/stripes_north_south", "/spectrum/stripe_x", 0.01, 0.0),
    ("/slope/mean", "/slope/mean", 0.01, 0.0),
    ("/slope/p5", "/slope/p5", 0.01, 0.0),
    ("/slope/p50", "/slope/p50", 0.01, 0.0),
    ("/slope/p95", "/slope/p95", 0.01, 0.0),
    ("/slope/p99", "/slope/p99", 0.01, 0.0),
    ("/curvature/0/skewness", "/curvature/sigma1/skew", 0.01, 2e-3),
    ("/curvature/1/skewness", "/curvature/sigma2/skew", 0.01, 5e-3),
    ("/aspect/m4", "/aspect/m4", 0.01, 1e-3),
    ("/aspect/m8", "/aspect/m8", 0.01, 1e-3),
    ("/depressions/pits_per_1000", "/drainage/pits_per_1000", 0.01, 0.0),
    ("/depressions/filled", "/drainage/filled_frac", 0.01, 1e-4),
    ("/depressions/filled_or_level", "/drainage/flat_or_filled_frac", 0.01, 1e-4),
    ("/channels/concavity_unfilled/value", "/drainage/theta_unfilled", 0.03, 0.0),
    ("/channels/hack/value", "/drainage/hack_h", 0.03, 0.0),
    ("/channels/relative_density", "/drainage/dd_norm", 0.03, 0.0),
    ("/channels/straight_run", "/drainage/straight_run", 0.03, 0.0),
    ("/channels/filled", "/drainage/channel_filled_frac", 0.03, 1e-3),
    ("/network/bifurcation_ratio", "/drainage/R_B", 0.03, 0.0),
    ("/network/length_ratio", "/drainage/R_L", 0.03, 0.0),
    ("/network/area_ratio", "/drainage/R_A", 0.03, 0.0),
    // Of 23 models 20 are within 3 %: which of two ways water takes over a flat decides where some branches join.
    ("/network/side_branches/0", "/drainage/T_k/0", 0.035, 0.0),
];

#[test]
fn figures_of_models_are_those_that_were_measured() {
    let Some(folder) = folder("figures_of_models_are_those_that_were_measured") else { return };
    let all = rig::part(list(&folder), 6, "models");
    let mut wrong = Vec::new();
    for model in &all {
        let found = measured(&folder, model);
        for (here, there, share, nothing) in SAME {
            let number = |of: &Json, id: &str| of.pointer(id).and_then(Json::as_f64);
            let (got, want) = (number(&found, here), number(&model.want, there));
            let is_same = match (got, want) {
                (Some(got), Some(want)) => (got - want).abs() <= share * want.abs() + nothing,
                (got, want) => got.is_some() == want.is_some(),
            };
            if !is_same {
                wrong.push(format!("{}: {here} is {got:?}, not {want:?}", model.name));
            }
        }
    }
    assert!(all.len() >= 3 && wrong.is_empty(), "of {} models:\n{}", all.len(), wrong.join("\n"));
}

/// The table that `orograph stats` holds land against: a row a model, a column a figure, whose head is its place in the
/// JSON.
const TABLE: &str = "src/cli/stats/models.tsv";

/// A number as the table holds it.
fn short(value: Option<f64>) -> String {
    let digits = value.and_then(|value| format!("{value:.3e}").parse::<f64>().ok());
    digits.map_or_else(|| "-".to_owned(), |value| value.to_string())
}

/// `OROGRAPH_BLESS=1` writes the table anew, of all models and with the columns that it has.
#[test]
fn the_table_of_models_is_what_is_measured() {
    let Some(folder) = folder("the_table_of_models_is_what_is_measured") else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(TABLE);
    let table = std::fs::read_to_string(&path).unwrap();
    let head = table.lines().next().expect("a head");
    let row = |model: &Model| {
        let found = measured(&folder, model);
        let figures = head.split('\t').skip(1).map(|id| {
            let id = if id == "cell" { "/cell" } else { id };
            short(found.pointer(id).and_then(Json::as_f64))
        });
        std::iter::once(model.name.clone()).chain(figures).collect::<Vec<_>>().join("\t")
    };
    // What repeats its neighbours on purpose says nothing of land.
    let real = list(&folder).into_iter().filter(|model| model.file != "srtm90.tif");
    if std::env::var_os("OROGRAPH_BLESS").is_some() {
        let rows: Vec<String> = real.map(|model| row(&model)).collect();
        std::fs::write(&path, format!("{head}\n{}\n", rows.join("\n"))).unwrap();
        return;
    }
    for model in rig::part(real.collect(), 7, "table of models") {
        let found = row(&model);
        let held = table.lines().find(|line| line.starts_with(&format!("{}\t", model.name)));
        for (found, held) in found.split('\t').skip(1).zip(held.expect("a row").split('\t').skip(1)) {
            let close = |a: f64, b: f64| (a - b).abs() <= 2e-3 * b.abs() + 1e-6;
            let is_same = match (found.parse(), held.parse()) {
                (Ok(found), Ok(held)) => close(found, held),
                _ => found == held,
            };
            assert!(is_same, "{}: {found}, not {held}; OROGRAPH_BLESS=1 renews {TABLE}", model.name);
        }
    }
}
