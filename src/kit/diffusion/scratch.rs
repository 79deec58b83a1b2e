//! Buffers that go from one piece of work to the next: fresh memory costs more than the work that is done on it.

use std::sync::{Mutex, PoisonError};

use crate::kit::diffusion::paper::Tile;

/// Buffers that wait for work.
#[derive(Default)]
pub(crate) struct Scratch {
    grids: Vec<Vec<f32>>,
    tiles: Mutex<Vec<Tile>>,
}

impl Scratch {
    /// A buffer of a length, with whatever values.
    pub(crate) fn take(&mut self, len: usize) -> Vec<f32> {
        let fitting = self.grids.iter().enumerate().filter(|(_, v)| v.len() >= len);
        let smallest = fitting.min_by_key(|(_, v)| v.len()).map(|(k, _)| k);
        match smallest {
            // A much larger one would be cut, and lost to those that need it.
            Some(k) if self.grids[k].len() <= len.saturating_mul(2) => {
                let mut found = self.grids.swap_remove(k);
                found.truncate(len);
                found
            }
            _ => vec![0.0; len],
        }
    }

    /// Keeps a buffer for later.
    pub(crate) fn keep(&mut self, buffer: Vec<f32>) {
        if !buffer.is_empty() {
            self.grids.push(buffer);
        }
    }

    /// Lets all buffers go.
    pub(crate) fn clear(&mut self) {
        self.grids.clear();
    }

    pub(crate) fn take_tile(&self) -> Tile {
        self.tiles.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(crate) fn keep_tile(&self, tile: Tile) {
        self.tiles.lock().unwrap_or_else(PoisonError::into_inner).push(tile);
    }
}
