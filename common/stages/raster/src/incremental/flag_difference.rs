//! Rectangles around the cells whose flags a redraw changed, for each layer that is made of them.
//!
//! Layers are recomputed around these alone: elements of which work begins or ends often leave flags as they were.

use crate::layers::cell_flags::{DOOR, FLOOR, OF_EDGES, OF_LOCALIZATION, OF_WORK};
use grid::{CellRect, join_rects};

/// Rectangles around the cells whose flags differ, by what is made of these flags.
#[derive(Debug, Default)]
pub(crate) struct FlagDifference {
    pub(crate) of_edges: Vec<CellRect>,
    pub(crate) of_work: Vec<CellRect>,
    pub(crate) of_localization: Vec<CellRect>,
    /// Buffer: flags of a rectangle before it is drawn, row by row.
    before: Vec<u8>,
}

/// Columns and rows of the tiles in which floor and doors are looked for.
const FREE_CELLS: u32 = 128;

/// The flags that each list is about, in the order of [`FlagDifference::lists`].
const MASKS: [u8; 3] = [OF_EDGES, OF_WORK, OF_LOCALIZATION];

impl FlagDifference {
    fn lists(&mut self) -> [&mut Vec<CellRect>; 3] {
        [&mut self.of_edges, &mut self.of_work, &mut self.of_localization]
    }

    /// Nothing differs.
    pub(crate) fn clear(&mut self) {
        self.lists().into_iter().for_each(Vec::clear);
    }

    /// Remembers the flags of a rectangle of a storey, which is drawn next.
    pub(crate) fn begin(&mut self, flags: &[u8], rect: &CellRect, width: usize) {
        self.before.clear();
        rect.rows(width).for_each(|row| self.before.extend_from_slice(&flags[row]));
    }

    /// Adds where the flags of the rectangle are other ones now.
    pub(crate) fn add(&mut self, flags: &[u8], rect: &CellRect, width: usize) {
        let mut around: [Option<CellRect>; 3] = [None; 3];
        let rows = rect.rows(width).zip(self.before.chunks_exact(rect.width().max(1)));
        for ((row, before), y) in rows.zip(rect.min[1]..) {
            let changes = || flags[row.clone()].iter().zip(before).map(|(now, before)| now ^ before);
            // Whole rows at once first: most are the same.
            let any = changes().fold(0, |any, change| any | change);
            for (around, mask) in around.iter_mut().zip(MASKS).filter(|(_, mask)| any & mask != 0) {
                let is_of_mask = |change: u8| change & mask != 0;
                let (Some(first), Some(last)) = (changes().position(is_of_mask), changes().rposition(is_of_mask))
                else {
                    continue;
                };
                let [start, end] = [first, last + 1].map(|column| rect.min[0] + column as u32);
                let here = CellRect { min: [start, y], max: [end, y + 1] };
                *around = Some(around.map_or(here, |around| around.around_both(&here)));
            }
        }
        self.lists().into_iter().zip(around).for_each(|(cells, around)| cells.extend(around));
    }

    /// Replaces all by rectangles around floor and doors: far from them no layer depends on neighbouring cells.
    pub(crate) fn set_to_free(&mut self, flags: &[u8], whole: &CellRect) {
        self.clear();
        let around = &mut self.of_edges;
        for tile in whole.tiles(FREE_CELLS) {
            let any = |row: std::ops::Range<usize>| flags[row].iter().fold(0, |any, flags| any | flags);
            if !tile.rows(whole.width()).any(|row| any(row) & (FLOOR | DOOR) != 0) {
                continue;
            }
            match around.last_mut() {
                Some(left) if (left.min[1], left.max[0]) == (tile.min[1], tile.min[0]) => left.max[0] = tile.max[0],
                _ => around.push(tile),
            }
        }
        join_rects(around);
        self.of_work.extend_from_slice(around);
        self.of_localization.extend_from_slice(around);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::cell_flags::{BASE_FLOOR, BLOCKED, STRUCTURE, WORK};
    use crate::layers::keepout::{Keepout, Margins, keepout_value};
    use crate::layers::localization::{Localization, localization_value};
    use grid::Growth;
    use proptest::prelude::*;

    #[test]
    fn only_flags_that_a_layer_is_made_of_count() {
        let (width, rect) = (8, CellRect { min: [1, 1], max: [7, 4] });
        let mut flags = vec![FLOOR; 8 * 5];
        let mut difference = FlagDifference::default();
        difference.begin(&flags, &rect, width);
        flags[8 + 2] |= WORK;
        flags[2 * 8 + 5] |= WORK | BASE_FLOOR;
        flags[3 * 8 + 6] |= STRUCTURE;
        difference.add(&flags, &rect, width);
        assert!(difference.of_edges.is_empty());
        assert_eq!(difference.of_work, [CellRect { min: [2, 1], max: [6, 3] }]);
        assert_eq!(difference.of_localization, [CellRect { min: [6, 3], max: [7, 4] }]);
        difference.clear();
        difference.begin(&flags, &rect, width);
        flags[8 + 1] |= BLOCKED;
        // Outside of the rectangle.
        flags[7] = 0;
        difference.add(&flags, &rect, width);
        assert_eq!(difference.of_edges, [CellRect { min: [1, 1], max: [2, 2] }]);
        assert!(difference.of_work.is_empty() && difference.of_localization.is_empty());
    }

    /// The layers of flags, with margins of 4 and 6 cells, recomputed in rectangles upon what each cell says alone.
    fn layers(flags: &[u8], whole: CellRect, of_edges: &[CellRect], others: &[CellRect]) -> [Vec<i8>; 2] {
        let margins = Margins { edge_cells: 4.0, work_cells: 6.0 };
        let mut cell_margins = vec![0; flags.len()];
        let mut keepout: Vec<i8> = flags.iter().map(|&f| keepout_value(f, 0)).collect();
        let mut localization: Vec<i8> = flags.iter().map(|&f| localization_value(f, false)).collect();
        let growth = &mut Growth::default();
        let mut mask = Keepout { flags, margins: &mut cell_margins, layer: &mut keepout, whole };
        let grown =
            |rects: &[CellRect], reach| -> Vec<CellRect> { rects.iter().map(|r| r.grown(reach, &whole)).collect() };
        grown(of_edges, margins.edge_reach()).iter().for_each(|tile| mask.edges(growth, margins, tile));
        grown(others, margins.work_reach()).iter().for_each(|tile| mask.work(growth, margins, tile));
        let mut seen = Localization { flags, layer: &mut localization, whole, gap_cells: 3 };
        let reach = seen.reach();
        grown(others, reach).iter().for_each(|tile| seen.draw(growth, tile));
        [keepout, localization]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn far_from_floor_and_doors_layers_are_what_each_cell_says(
            pieces in prop::collection::vec((0u32..400, 0u32..300, 1u32..60, 1u32..60, prop::bits::u8::ANY), 0..10)
        ) {
            let whole = CellRect { min: [0, 0], max: [400, 300] };
            let mut flags = vec![0; whole.n_cells()];
            for (x, y, w, h, of) in pieces {
                let rect = CellRect { min: [x, y], max: [(x + w).min(400), (y + h).min(300)] };
                rect.rows(whole.width()).for_each(|row| flags[row].iter_mut().for_each(|f| *f |= of));
            }
            let mut difference = FlagDifference::default();
            difference.set_to_free(&flags, &whole);
            let found = layers(&flags, whole, &difference.of_edges, &difference.of_localization);
            prop_assert_eq!(found, layers(&flags, whole, &[whole], &[whole]));
        }
    }
}
