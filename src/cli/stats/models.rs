//! Figures of real land, as this program measures them.

use std::sync::LazyLock;

/// A row a model and a column a figure, whose head is its place in the JSON; `-` where the model has none. The page
/// `docs/stats.md` says what the models are and whose they are; a test renews the table.
const TABLE: &str = include_str!("models.tsv");
/// How many times larger or smaller the cell of a model may be than that of what is held against it.
const WIDEST: f64 = 1.6;

/// An elevation model of real land.
#[derive(Debug)]
struct Model {
    name: &'static str,
    cell: f64,
    /// In the order of the columns.
    figures: Vec<Option<f64>>,
}

static ALL: LazyLock<(Vec<&'static str>, Vec<Model>)> = LazyLock::new(|| {
    let mut lines = TABLE.lines().map(|line| line.split('\t'));
    let columns = lines.next().map_or_else(Vec::new, |head| head.skip(2).collect());
    let model = |mut row: std::str::Split<'static, char>| {
        let (name, cell) = (row.next()?, row.next()?.parse().ok()?);
        Some(Model { name, cell, figures: row.map(|text| text.parse().ok()).collect() })
    };
    (columns, lines.filter_map(model).collect())
});

/// The models whose cells are about as large as some others.
#[derive(Clone, Debug)]
pub(super) struct Models(Vec<&'static Model>);

impl Models {
    pub(super) fn near(cell: f64) -> Self {
        let is_near = |model: &&Model| (model.cell / cell).max(cell / model.cell) <= WIDEST;
        Self(ALL.1.iter().filter(is_near).collect())
    }

    pub(super) fn all() -> Self {
        Self(ALL.1.iter().collect())
    }

    pub(super) fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|model| model.name).collect()
    }

    /// The lowest and the highest cell, in metres.
    pub(super) fn cells(&self) -> Option<[f64; 2]> {
        range(self.0.iter().map(|model| model.cell))
    }

    /// The lowest and the highest of a figure; none where fewer than two models have it.
    pub(super) fn range(&self, figure: &str) -> Option<[f64; 2]> {
        let column = ALL.0.iter().position(|id| *id == figure)?;
        let found = self.0.iter().filter_map(|model| *model.figures.get(column)?);
        if found.clone().count() < 2 { None } else { range(found) }
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, v| Some(range.map_or([v, v], |[lo, hi]: [f64; 2]| [lo.min(v), hi.max(v)])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_whole() {
        let (columns, models) = &*ALL;
        assert!(models.len() >= 20 && columns.len() >= 25, "{} x {}", models.len(), columns.len());
        for model in models {
            assert_eq!(model.figures.len(), columns.len(), "{}", model.name);
            assert!(model.cell >= 1.0 && model.figures.iter().flatten().count() > 15, "{}", model.name);
        }
        // The sea is known beside the figures.
        let figures: Vec<_> = columns.iter().filter(|id| **id != "/sea").collect();
        assert_eq!(figures, super::super::table::compared_ids().iter().collect::<Vec<_>>());
    }

    #[test]
    fn land_is_held_against_models_of_its_cell() {
        let names = Models::near(30.0).names();
        assert!(names.contains(&"bigtujunga.tif") && !names.contains(&"greenriver.tif"), "{names:?}");
        let [low, high] = Models::near(30.0).range("/slope/p50").expect("a range");
        assert!(low > 5.0 && low < high && high < 45.0, "{low} to {high}");
        assert!(Models::near(2000.0).names().is_empty() && Models::near(2000.0).cells().is_none());
        assert_eq!(Models::near(30.0).range("/slope"), None);
    }
}
