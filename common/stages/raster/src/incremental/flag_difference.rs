//! Rectangles around the cells whose flags a redraw changed, for each layer that is made of them.
//!
//! Layers are recomputed around these alone: elements of which work begins or ends often leave flags as they were.

use crate::layers::cell_flags::{OF_EDGES, OF_LOCALIZATION, OF_WORK};
use grid::CellRect;

/// Rectangles around the cells whose flags differ, by what is made of these flags.
#[derive(Debug, Default)]
pub(crate) struct FlagDifference {
    pub(crate) of_edges: Vec<CellRect>,
    pub(crate) of_work: Vec<CellRect>,
    pub(crate) of_localization: Vec<CellRect>,
    /// Buffer: flags of a rectangle before it is drawn, row by row.
    before: Vec<u8>,
}

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

    /// Adds a rectangle as a whole: the layers there do not belong to the flags before.
    pub(crate) fn add_whole(&mut self, rect: &CellRect) {
        self.lists().into_iter().for_each(|cells| cells.push(*rect));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::cell_flags::{BASE_FLOOR, BLOCKED, FLOOR, STRUCTURE, WORK};

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
}
