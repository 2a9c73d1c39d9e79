//! Compares a schedule state with the one that is drawn: the cells of which anything may differ.

use super::scene::Scene;
use crate::layers::floor::put;
use crate::model::presence::Look;
use grid::CellRect;
use messages::Phase;

/// Everything of a phase that a grid depends on.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// [`Look`] of every dependent, then whether each space is blocked, then whether there is a plan time.
    pub(crate) looks: Vec<u8>,
    /// Which floor elements are finished.
    pub(crate) finished: Vec<u64>,
}

/// Where a phase differs from what is drawn.
#[derive(Debug, Default)]
pub(crate) struct Difference {
    /// Cells whose facts may differ.
    pub(crate) cells: Vec<CellRect>,
    /// Cells of which the ground may differ.
    pub(crate) ground: Vec<CellRect>,
    /// Cells below which work began or ended.
    pub(crate) work: Vec<CellRect>,
    /// Cells of all work that goes on.
    pub(crate) working: Vec<CellRect>,
    /// Places in `StoreyCut::overhead` of the elements that are worked on.
    pub(crate) worked_on: Vec<u32>,
    /// True if a floor element was finished, or is no longer.
    pub(crate) floor_differs: bool,
    pub(crate) windows: Vec<CellRect>,
}

impl Difference {
    /// Compares a phase with what is drawn, and takes it for drawn; false if nothing looks different.
    pub(crate) fn find(&mut self, seen: &mut Seen, scene: Scene<'_>, phase: &Phase<'_>) -> bool {
        let storey = scene.storey;
        let is_first = seen.looks.is_empty();
        let (n_dependents, n_spaces) = (storey.dependents.len(), storey.spaces.len());
        // Nothing that is drawn looks like this.
        let Seen { looks, finished } = seen;
        looks.resize(n_dependents + n_spaces + 1, u8::MAX);
        self.clear();
        let mut differs = is_first;
        for (dependent, seen) in storey.dependents.iter().zip(&mut *looks) {
            let look = Look::of(phase.effective(dependent.element as usize));
            let before = std::mem::replace(seen, look as u8);
            let overhead = dependent.overhead.filter(|_| look == Look::WorkedOn || before == Look::WorkedOn as u8);
            let work = overhead.and_then(|place| storey.overhead_rect(scene.site, place));
            if look == Look::WorkedOn {
                self.worked_on.extend(dependent.overhead);
                self.working.extend(work);
            }
            if before == look as u8 {
                continue;
            }
            differs = true;
            self.cells.extend(dependent.cells);
            if (before == Look::WorkedOn as u8) != (look == Look::WorkedOn) {
                self.work.extend(work);
            }
            if let Some(place) = dependent.floor_place {
                put(finished, place, look == Look::Built);
                self.ground.extend(dependent.floor);
                self.floor_differs = true;
            }
        }
        for (space, seen) in storey.spaces.iter().zip(&mut looks[n_dependents..]) {
            let blocked = u8::from(phase.is_blocked(space.space as usize));
            if std::mem::replace(seen, blocked) != blocked {
                differs = true;
                self.cells.extend(space.rect);
            }
        }
        let dated = u8::from(phase.head.plan_time().is_some());
        if std::mem::replace(&mut looks[n_dependents + n_spaces], dated) != dated {
            // Without a plan time a storey without floor is not all unknown.
            differs = true;
        }
        let Difference { cells, work, .. } = self;
        cells.extend_from_slice(work);
        differs
    }

    fn clear(&mut self) {
        let lists = [&mut self.cells, &mut self.ground, &mut self.work, &mut self.working];
        lists.into_iter().for_each(Vec::clear);
        self.worked_on.clear();
        self.floor_differs = false;
    }
}
