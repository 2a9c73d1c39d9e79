//! Counts the elements that are sliced, for those who show progress.

use crate::model::cell_area::slab_above_floor;
use geometry::Slab;
use messages::{ElementRecord, MapStoreyRecord, RobotProfile, Site};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Called with elements sliced and in total, from any thread.
pub type SliceProgress<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// Elements between two calls.
const STEP: usize = 64;

/// Number of elements sliced, of all storeys.
pub(crate) struct SliceCount<'a> {
    done: AtomicUsize,
    total: usize,
    progress: &'a SliceProgress<'a>,
}

impl<'a> SliceCount<'a> {
    pub(crate) fn new(site: &Site<'_>, robot: &RobotProfile, progress: &'a SliceProgress<'a>) -> Self {
        let of_storey = |storey: &MapStoreyRecord| {
            let slab = slab_of(storey, robot);
            site.elements.iter().filter(|element| reaches(element, slab)).count()
        };
        Self { done: AtomicUsize::new(0), total: site.levels().map(|(_, storey)| of_storey(storey)).sum(), progress }
    }

    /// One more.
    pub(crate) fn sliced(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(STEP) || done == self.total {
            (self.progress)(done, self.total);
        }
    }
}

/// The slab of a map storey, in which what stands is an obstacle.
pub(crate) fn slab_of(record: &MapStoreyRecord, robot: &RobotProfile) -> Slab {
    let [lo, hi] = slab_above_floor(robot).map(|h| record.floor_z_tenths + h);
    Slab { lo, hi }
}

/// True if an element has a body that meets a slab.
pub(crate) fn reaches(element: &ElementRecord, slab: Slab) -> bool {
    element.n_parts > 0 && slab.meets(element.min_tenths[2], element.max_tenths[2])
}
