//! Cutting a window into tiles that share their border samples.

use super::exit::Stop;
use super::job::Tile;
use crate::value::Grid;

#[derive(Debug, clap::Args)]
pub(super) struct TileArgs {
    /// Cuts the terrain into N columns and M rows of tiles that share their border samples
    #[arg(long, value_name = "NxM", conflicts_with = "tile_size")]
    tiles: Option<String>,
    /// Cuts the terrain into tiles of N samples a side, the shared border counted
    #[arg(long, value_name = "N")]
    tile_size: Option<u32>,
    /// Builds only this tile, column and row from 0 in the north-west; repeatable
    #[arg(long, value_name = "I,J")]
    tile: Vec<String>,
}

impl TileArgs {
    /// Whether the terrain is cut, even if into a single tile.
    pub(super) fn is_cut(&self) -> bool {
        self.tiles.is_some() || self.tile_size.is_some()
    }

    /// Whether only some of the tiles are built.
    pub(super) fn is_part(&self) -> bool {
        !self.tile.is_empty()
    }
}

/// The tiles to build; without options, one tile that is the whole window.
pub(super) fn tiles(args: &TileArgs, window: &Grid) -> Result<Vec<Tile>, Stop> {
    if args.is_part() && !args.is_cut() {
        return Err(Stop::usage("--tile names a tile of a cut; say --tiles NxM or --tile-size N with it"));
    }
    let steps = [window.cols as u64 - 1, window.rows as u64 - 1];
    let counts = match (&args.tiles, args.tile_size) {
        (Some(text), _) => {
            let counts = pair(text, 'x').filter(|c| c.iter().all(|n| *n > 0));
            counts.ok_or_else(|| Stop::usage(format!("--tiles takes NxM, as 4x4, got `{text}`")))?
        }
        (None, Some(size)) if size < 2 => {
            return Err(Stop::usage(format!("--tile-size must be at least 2, got {size}")));
        }
        (None, Some(size)) => steps.map(|s| s.div_ceil(u64::from(size - 1))),
        (None, None) => [1, 1],
    };
    let side = args.tile_size.map(|s| u64::from(s - 1));
    for (axis, (n, count)) in steps.into_iter().zip(counts).enumerate() {
        let fits = side.map_or(n % count == 0, |s| n % s == 0) && n / count >= 1;
        if !fits {
            return Err(Stop::usage(uneven(axis, n, count, side)));
        }
    }
    let size = [0, 1].map(|a| steps[a] / counts[a]);
    let all = (0..counts[1]).flat_map(|j| (0..counts[0]).map(move |i| [i, j]));
    let tile = |[i, j]: [u64; 2]| {
        let start = [window.col + (i * size[0]) as i64, window.row + (j * size[1]) as i64];
        let end = [start[0] + size[0] as i64 + 1, start[1] + size[1] as i64 + 1];
        let [col, row, cols, rows] = [i, j, counts[0], counts[1]].map(|n| n as u32);
        let place = crate::files::Tile { col, row, cols, rows };
        Tile { place, grid: Grid::between(window.lattice, start, end) }
    };
    if args.tile.is_empty() {
        return Ok(all.map(tile).collect());
    }
    let one = |text: &String| match pair(text, ',') {
        Some([i, j]) if i < counts[0] && j < counts[1] => Ok(tile([i, j])),
        _ => Err(Stop::usage(format!(
            "--tile takes I,J below {},{} (see --tiles or --tile-size), got `{text}`",
            counts[0], counts[1]
        ))),
    };
    args.tile.iter().map(one).collect()
}

fn pair(text: &str, separator: char) -> Option<[u64; 2]> {
    let (a, b) = text.split_once(separator)?;
    Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
}

/// The message that a cut is uneven, with cuts that are even.
fn uneven(axis: usize, steps: u64, count: u64, side: Option<u64>) -> String {
    let name = ["columns", "rows"][axis];
    let near = |wanted: u64| {
        let fits = |n: &u64| *n >= 1 && steps.is_multiple_of(*n);
        let below = (1..wanted.min(steps + 1)).rev().find(fits);
        let above = (wanted + 1..=steps).find(fits);
        below.into_iter().chain(above)
    };
    let list = |v: Vec<String>| v.join(" or ");
    match side {
        Some(side) => format!(
            "{} {name} of samples cannot be cut evenly into tiles of {}; a tile size of {} can",
            steps + 1,
            side + 1,
            list(near(side).map(|n| (n + 1).to_string()).collect())
        ),
        None => format!(
            "{} {name} of samples cannot be cut into {count} tiles that share their border; {} can",
            steps + 1,
            list(near(count).map(|n| n.to_string()).collect())
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Terrain;

    fn cut(tiles: Option<&str>, tile_size: Option<u32>, tile: &[&str]) -> Result<Vec<Tile>, String> {
        let grid = Terrain::default().grid(1025).unwrap();
        let args = TileArgs {
            tiles: tiles.map(Into::into),
            tile_size,
            tile: tile.iter().map(|t| (*t).into()).collect(),
        };
        super::tiles(&args, &grid).map_err(|s| s.message)
    }

    #[test]
    fn tiles_share_their_border_and_cover_the_window() {
        let tiles = cut(Some("4x2"), None, &[]).unwrap();
        assert_eq!(tiles.len(), 8);
        assert_eq!((tiles[1].grid.col, tiles[1].grid.cols, tiles[1].grid.rows), (256, 257, 513));
        assert_eq!(tiles[7].grid.col_end(), 1025);
        assert_eq!(tiles[7].grid.row_end(), 1025);
        assert_eq!(cut(None, Some(257), &[]).unwrap().len(), 16);
        assert_eq!(cut(None, Some(257), &["3,1"]).unwrap()[0].grid.col, 768);
        assert_eq!(cut(None, None, &[]).unwrap().len(), 1);
        assert!(cut(None, None, &["0,0"]).unwrap_err().contains("--tiles NxM"));
    }

    #[test]
    fn says_which_cuts_are_even() {
        assert!(cut(Some("3x4"), None, &[]).unwrap_err().contains("2 or 4"));
        assert!(cut(None, Some(256), &[]).unwrap_err().contains("129 or 257"));
        for bad in ["", "4", "0x4", "4x", "x", "-1x2", "9999999x1"] {
            assert!(cut(Some(bad), None, &[]).is_err(), "{bad}");
        }
        assert!(cut(Some("4x4"), None, &["4,0"]).is_err());
    }
}
