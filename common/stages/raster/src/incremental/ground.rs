//! Brings the ground of a storey to a schedule state: finished floor, what obstacles enclose, open passages.

use super::difference::Difference;
use super::scene::Scene;
use crate::layers::cell_flags::GROUND;
use crate::layers::floor::{FloorPlans, enclosed_floor, sides_with_floor};
use grid::join_rects;
use messages::{FloorKind, Phase, RegionRecord};

/// The ground of a storey as it was drawn last.
#[derive(Debug)]
pub(crate) struct Ground {
    floor_plans: FloorPlans,
    /// True if any cell is ground.
    pub(crate) is_any: bool,
    /// By passage of the storey: true if it is floor too.
    pub(crate) open_passages: Vec<bool>,
    /// Finished floor at other levels.
    pub(crate) regions: Vec<RegionRecord>,
}

impl Ground {
    /// No ground yet.
    pub(crate) fn new(floor_plans: FloorPlans) -> Self {
        Self { floor_plans, is_any: false, open_passages: Vec::new(), regions: Vec::new() }
    }

    /// Brings the ground to the finished floor elements.
    pub(crate) fn lay(
        &mut self,
        facts: &mut [u8],
        difference: &mut Difference,
        finished: &[u64],
        (scene, phase): (Scene<'_>, &Phase<'_>),
        is_first: bool,
    ) {
        let Scene { site, robot, storey } = scene;
        let whole = storey.whole();
        if is_first {
            difference.ground.clear();
            difference.ground.push(whole);
        }
        if is_first || difference.floor_differs {
            let plan = self.floor_plans.of(site, robot, storey, finished);
            self.regions.clone_from(&plan.regions);
            join_rects(&mut difference.ground);
            for rect in &difference.ground {
                rect.rows(whole.width()).for_each(|row| facts[row].iter_mut().for_each(|f| *f &= !GROUND));
                let covered = rect.clip(&plan.runs, whole.width());
                covered.for_each(|cells| facts[cells].iter_mut().for_each(|f| *f |= GROUND));
            }
        }
        if storey.floor_kind == FloorKind::AssumedFromEnclosure {
            enclose(facts, difference, scene, phase);
        }
        if is_first || !difference.ground.is_empty() {
            self.is_any = facts.iter().any(|f| f & GROUND != 0);
        }
        let Difference { cells, ground, .. } = difference;
        cells.extend_from_slice(ground);
    }

    /// Passages of walls that stand, with ground on both sides, are floor too.
    pub(crate) fn open(
        &mut self,
        facts: &[u8],
        difference: &mut Difference,
        (scene, phase): (Scene<'_>, &Phase<'_>),
        is_first: bool,
    ) {
        self.open_passages.resize(scene.storey.passages.len(), false);
        for (passage, open) in scene.storey.passages.iter().zip(&mut self.open_passages) {
            let Some(around) = passage.around else { continue };
            if !is_first && !difference.cells.iter().any(|rect| rect.meets(&around)) {
                continue;
            }
            let is_open = phase.effective(passage.host as usize).is_obstacle()
                && sides_with_floor(&passage.plan, &scene.storey.spec, |i| facts[i] & GROUND != 0) == 2;
            if std::mem::replace(open, is_open) != is_open {
                difference.cells.extend(passage.rect);
            }
        }
    }
}

/// The ground of a storey without floor faces and spaces: what its obstacles enclose.
fn enclose(facts: &mut [u8], difference: &mut Difference, scene: Scene<'_>, phase: &Phase<'_>) {
    let enclosed = enclosed_floor(scene.storey, |element| phase.effective(element as usize).is_obstacle());
    for (facts, inside) in facts.iter_mut().zip(enclosed.cells) {
        *facts = *facts & !GROUND | if inside { GROUND } else { 0 };
    }
    difference.ground.clear();
    difference.ground.push(scene.storey.whole());
}
