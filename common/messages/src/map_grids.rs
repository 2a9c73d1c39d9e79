//! Grids of all map storeys, each viewed while it is worked on: they need not be dense in memory all at once.

use crate::content_hash::ContentHash;
use crate::grid_archive::{Grid, GridHead};
use crate::packed_grid::HeldGrid;

/// The grids of map storeys, in their order.
pub trait MapGrids: Sync {
    /// Number of grids.
    fn count(&self) -> usize;

    /// Specification and slab of a grid.
    fn head(&self, at: usize) -> &GridHead;

    /// Hash of the content of a grid.
    fn content_hash(&self, at: usize) -> ContentHash;

    /// Calls `work` once with the view of a grid, which may be unpacked for that.
    fn view(&self, at: usize, work: &mut dyn FnMut(&Grid<'_>));
}

impl dyn MapGrids + '_ {
    /// The result of work on the view of a grid.
    pub fn with<T>(&self, at: usize, work: impl FnOnce(&Grid<'_>) -> T) -> T {
        let (mut work, mut result) = (Some(work), None);
        self.view(at, &mut |grid| result = work.take().map(|work| work(grid)));
        result.expect("a grid is viewed once")
    }

    /// Specification and slab of each grid.
    pub fn heads(&self) -> impl Iterator<Item = &GridHead> {
        (0..self.count()).map(|at| self.head(at))
    }

    /// The results of work on the view of each grid, one after the other.
    pub fn each<T>(&self, mut work: impl FnMut(&Grid<'_>) -> T) -> impl Iterator<Item = T> {
        (0..self.count()).map(move |at| self.with(at, &mut work))
    }
}

/// Some of the grids of a site.
pub struct ChosenGrids<'a> {
    all: &'a dyn MapGrids,
    /// Places among all.
    chosen: Vec<usize>,
}

impl<'a> ChosenGrids<'a> {
    /// Those for whose heads `is_chosen` is true.
    pub fn of(all: &'a dyn MapGrids, is_chosen: impl Fn(&GridHead) -> bool) -> Self {
        let chosen = (0..all.count()).filter(|&at| is_chosen(all.head(at))).collect();
        Self { all, chosen }
    }
}

impl MapGrids for ChosenGrids<'_> {
    fn count(&self) -> usize {
        self.chosen.len()
    }

    fn head(&self, at: usize) -> &GridHead {
        self.all.head(self.chosen[at])
    }

    fn content_hash(&self, at: usize) -> ContentHash {
        self.all.content_hash(self.chosen[at])
    }

    fn view(&self, at: usize, work: &mut dyn FnMut(&Grid<'_>)) {
        self.all.view(self.chosen[at], work);
    }
}

impl MapGrids for &[Grid<'_>] {
    fn count(&self) -> usize {
        self.len()
    }

    fn head(&self, at: usize) -> &GridHead {
        self[at].head
    }

    fn content_hash(&self, at: usize) -> ContentHash {
        self[at].content_hash()
    }

    fn view(&self, at: usize, work: &mut dyn FnMut(&Grid<'_>)) {
        work(&self[at]);
    }
}

impl MapGrids for Vec<Grid<'_>> {
    fn count(&self) -> usize {
        self.len()
    }

    fn head(&self, at: usize) -> &GridHead {
        self[at].head
    }

    fn content_hash(&self, at: usize) -> ContentHash {
        self[at].content_hash()
    }

    fn view(&self, at: usize, work: &mut dyn FnMut(&Grid<'_>)) {
        work(&self[at]);
    }
}

impl MapGrids for Vec<&HeldGrid> {
    fn count(&self) -> usize {
        self.len()
    }

    fn head(&self, at: usize) -> &GridHead {
        self[at].head()
    }

    fn content_hash(&self, at: usize) -> ContentHash {
        self[at].content_hash()
    }

    fn view(&self, at: usize, work: &mut dyn FnMut(&Grid<'_>)) {
        self[at].view(work);
    }
}
