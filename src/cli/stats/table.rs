//! Figures as a person reads them.

use serde_json::{Value as Json, json};

use super::models::Models;

/// A figure: where it stands in the JSON, what it is called, the factor and the unit it is printed with.
struct Row {
    id: &'static str,
    label: &'static str,
    factor: f64,
    unit: &'static str,
    /// Whether land of any place can be held against that of another.
    is_compared: bool,
}

const fn row(
    id: &'static str,
    label: &'static str,
    factor: f64,
    unit: &'static str,
    is_compared: bool,
) -> Row {
    Row { id, label, factor, unit, is_compared }
}

/// A figure of one place alone.
const fn own(id: &'static str, label: &'static str, unit: &'static str) -> Row {
    row(id, label, 1.0, unit, false)
}

/// A figure without a unit.
const fn number(id: &'static str, label: &'static str) -> Row {
    row(id, label, 1.0, "", true)
}

/// A figure in degrees.
const fn degrees(id: &'static str, label: &'static str) -> Row {
    row(id, label, 1.0, "°", true)
}

/// A share of the whole.
const fn share(id: &'static str, label: &'static str) -> Row {
    row(id, label, 100.0, "%", true)
}

/// All rows, group by group.
const GROUPS: [(&str, &[Row]); 8] = [
    (
        "heights",
        &[
            own("/hypsometry/lowest", "lowest", "m"),
            own("/hypsometry/highest", "highest", "m"),
            own("/hypsometry/relief", "relief", "m"),
            own("/hypsometry/mean", "mean", "m"),
            own("/hypsometry/deviation", "standard deviation", "m"),
            number("/hypsometry/skewness", "skewness"),
            number("/hypsometry/integral", "hypsometric integral"),
            number("/hypsometry/robust_integral", "the same from 0.5 to 99.5 %"),
        ],
    ),
    (
        "spectrum (power ~ wavenumber^-β)",
        &[
            number("/spectrum/beta", "β from 4 cells to a quarter"),
            number("/spectrum/beta_fine", "β from 3 to 12 cells"),
            number("/spectrum/beta_coarse", "β from 12 cells to a quarter"),
            own("/spectrum/hurst", "Hurst exponent", ""),
            number("/spectrum/finest_power", "power of the finest waves"),
            number("/spectrum/stripes_east_west", "stripes from west to east"),
            number("/spectrum/stripes_north_south", "stripes from north to south"),
        ],
    ),
    (
        "slope",
        &[
            degrees("/slope/mean", "mean"),
            degrees("/slope/p5", "5th percentile"),
            degrees("/slope/p50", "median"),
            degrees("/slope/p95", "95th percentile"),
            degrees("/slope/p99", "99th percentile"),
            share("/slope/steeper_than_35", "steeper than 35°"),
            share("/slope/flatter_than_half", "flatter than 0.5°"),
        ],
    ),
    (
        "directions of slopes (0 where there is none)",
        &[
            number("/aspect/m1", "m1, one way"),
            number("/aspect/m2", "m2, grain"),
            number("/aspect/m4", "m4, axes of the grid"),
            number("/aspect/m8", "m8, multiples of 45°"),
        ],
    ),
    (
        "curvature (above 0: valleys are sharper than ridges)",
        &[
            number("/curvature/0/skewness", "skewness, σ 1 cell"),
            number("/curvature/1/skewness", "skewness, σ 2 cells"),
            number("/curvature/2/skewness", "skewness, σ 4 cells"),
        ],
    ),
    (
        "depressions",
        &[
            number("/depressions/pits_per_1000", "pits for 1000 cells"),
            share("/depressions/filled", "filled"),
            share("/depressions/filled_or_level", "filled or level"),
            own("/depressions/mean_depth", "mean depth", "m"),
            own("/depressions/p99_depth", "99th percentile of depth", "m"),
        ],
    ),
    (
        "channels",
        &[
            row("/channels/threshold", "drained area from", 1e-6, "km²", false),
            share("/channels/filled", "on filled ground"),
            number("/channels/concavity/value", "concavity θ"),
            number("/channels/concavity_unfilled/value", "θ of ground not filled"),
            number("/channels/hack/value", "Hack's exponent"),
            own("/channels/density", "density", "km/km²"),
            number("/channels/relative_density", "density · √area"),
            number("/channels/channel_axis_share", "share along the axes"),
            number("/channels/straight_run", "steps without a turn"),
        ],
    ),
    (
        "network",
        &[
            number("/network/bifurcation_ratio", "bifurcation ratio R_B"),
            number("/network/length_ratio", "length ratio R_L"),
            number("/network/area_ratio", "area ratio R_A"),
            number("/network/side_branches/0", "side branches T_1"),
            number("/network/side_branches/1", "side branches T_2"),
            number("/network/side_branches/2", "side branches T_3"),
            number("/network/tokunaga/a", "Tokunaga's a"),
            number("/network/tokunaga/c", "Tokunaga's c"),
        ],
    ),
];

fn rows() -> impl Iterator<Item = &'static Row> {
    GROUPS.iter().flat_map(|(_, rows)| rows.iter())
}

/// The figures that are held against real land.
#[cfg(test)]
pub(super) fn compared_ids() -> Vec<&'static str> {
    rows().filter(|row| row.is_compared).map(|row| row.id).collect()
}

/// Where a figure stands to a range.
fn verdict(value: f64, [low, high]: [f64; 2]) -> &'static str {
    if value < low {
        "below"
    } else if value > high {
        "above"
    } else {
        "inside"
    }
}

/// Each figure that real land has a range of, and where it stands to it, for programs.
pub(super) fn compared(figures: &Json, models: &Models) -> Json {
    let rows = rows().filter_map(|row| {
        let (value, range) = (figures.pointer(row.id)?.as_f64()?, models.range(row.id)?);
        Some(json!({ "figure": row.id, "value": value, "range": range, "is": verdict(value, range) }))
    });
    Json::Array(rows.collect())
}

/// The columns of the page.
const LABEL: usize = 32;
const VALUE: usize = 16;
const RANGE: usize = 22;

/// The figures in groups, with the ranges of real land.
pub(super) fn lines(title: &str, figures: &Json, models: &Models) -> Vec<String> {
    let mut lines = vec![format!("figures of {title}"), size(figures), String::new()];
    let real = match (models.cells(), models.names().len()) {
        (Some([low, high]), count) => {
            format!("{count} real models, cells of {} to {} m", short(low), short(high))
        }
        (None, _) => "no real model has cells of about this size".to_owned(),
    };
    lines.push(format!("{:LABEL$}{:VALUE$}{real}", "", "here"));
    for (group, rows) in GROUPS {
        let found: Vec<String> = rows.iter().filter_map(|row| line(row, figures, models)).collect();
        if !found.is_empty() {
            lines.push(String::new());
            lines.push(group.to_owned());
            lines.extend(found);
        }
    }
    lines.extend(orders(figures));
    lines
}

/// What was measured: cells, extent, land and sea; or vertices and lengths.
fn size(figures: &Json) -> String {
    let number = |id: &str| figures.pointer(id).and_then(Json::as_f64);
    let [cols, rows, cell, land] =
        ["/samples/0", "/samples/1", "/cell", "/land"].map(|id| number(id).unwrap_or_default());
    let kilometres = |metres: f64| short(metres / 1000.0);
    if let [Some(vertices), Some(outlets), Some(length), Some(longest)] =
        ["/vertices", "/outlets", "/length", "/longest"].map(number)
    {
        let (length, longest) = (kilometres(length), kilometres(longest));
        return format!(
            "{vertices} vertices, {outlets} outlets, {length} km of rivers, the longest {longest} km"
        );
    }
    let sea = number("/sea").map_or_else(String::new, |level| format!(", sea at {} m", short(level)));
    let (cell_text, land) = (short(cell), short(100.0 * land));
    let (wide, deep) = (kilometres(cols * cell), kilometres(rows * cell));
    format!("{cols} x {rows} cells of {cell_text} m, {wide} x {deep} km, land {land} %{sea}")
}

fn line(row: &Row, figures: &Json, models: &Models) -> Option<String> {
    let value = figures.pointer(row.id)?.as_f64()?;
    let printed = |value: f64| short(value * row.factor);
    let unit =
        if row.unit.is_empty() || row.unit == "°" { row.unit.to_owned() } else { format!(" {}", row.unit) };
    let here = format!("{}{unit}", printed(value));
    let range = models.range(row.id).filter(|_| row.is_compared);
    let (real, verdict) = range.map_or_else(Default::default, |range| {
        let verdict = verdict(value, range);
        (
            format!("{} to {}{unit}", printed(range[0]), printed(range[1])),
            if verdict == "inside" { "" } else { verdict },
        )
    });
    let label = format!("  {}", row.label);
    Some(format!("{label:LABEL$}{here:VALUE$}{real:RANGE$}{verdict}").trim_end().to_owned())
}

/// The streams of each order.
fn orders(figures: &Json) -> Option<String> {
    let orders = figures.pointer("/network/orders")?.as_array()?;
    let of = |order: &Json| Some(order.get("streams")?.as_u64()?.to_string());
    let streams: Vec<String> = orders.iter().filter_map(of).collect();
    Some(format!("{:LABEL$}{}", "  streams of order 1, 2, …", streams.join(", ")))
}

/// A number with four significant digits, without zeros at its end.
fn short(value: f64) -> String {
    let Ok(rounded) = format!("{value:.3e}").parse::<f64>() else { return value.to_string() };
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let found = [0.0, 1234.56, -0.123_456, 1e9, 0.5, 99.999].map(short);
        assert_eq!(found, ["0", "1235", "-0.1235", "1e9", "0.5", "100"]);
    }

    #[test]
    fn a_figure_outside_of_its_range_is_marked() {
        let found = [0.5, 1.0, 2.0, 2.1].map(|value| verdict(value, [1.0, 2.0]));
        assert_eq!(found, ["below", "inside", "inside", "above"]);
    }
}
