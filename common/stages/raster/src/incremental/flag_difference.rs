//! Where flags differ after cells were drawn again: layers are recomputed around these cells alone. What is worked on, or is finished,
//! often has the flags that it had.

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

impl FlagDifference {
    /// Nothing differs.
    pub(crate) fn clear(&mut self) {
        [&mut self.of_edges, &mut self.of_work, &mut self.of_localization].into_iter().for_each(Vec::clear);
    }

    /// Remembers the flags of a rectangle of a storey, which is drawn next.
    pub(crate) fn begin(&mut self, flags: &[u8], rect: &CellRect, width: usize) {
        self.before.clear();
        rect.rows(width).for_each(|row| self.before.extend_from_slice(&flags[row]));
    }

    /// Adds where the flags of the rectangle are other ones now.
    pub(crate) fn add(&mut self, flags: &[u8], rect: &CellRect, width: usize) {
        let Self { of_edges, of_work, of_localization, before } = self;
        of_edges.extend(differing(before, flags, rect, width, OF_EDGES));
        of_work.extend(differing(before, flags, rect, width, OF_WORK));
        of_localization.extend(differing(before, flags, rect, width, OF_LOCALIZATION));
    }

    /// Adds a rectangle as a whole: the layers there do not belong to the flags before.
    pub(crate) fn add_whole(&mut self, rect: &CellRect) {
        [&mut self.of_edges, &mut self.of_work, &mut self.of_localization]
            .into_iter()
            .for_each(|cells| cells.push(*rect));
    }
}

/// The smallest rectangle around the cells in which these flags differ.
fn differing(before: &[u8], flags: &[u8], rect: &CellRect, width: usize, mask: u8) -> Option<CellRect> {
    let mut around: Option<CellRect> = None;
    for ((row, before), y) in rect.rows(width).zip(before.chunks_exact(rect.width().max(1))).zip(rect.min[1]..) {
        let now = &flags[row];
        // Whole rows at once first: most are the same.
        if now.iter().zip(before).fold(0, |any, (now, before)| any | (now ^ before)) & mask == 0 {
            continue;
        }
        let mut columns =
            (rect.min[0]..).zip(now.iter().zip(before)).filter(|(_, (now, before))| (*now ^ *before) & mask != 0);
        let Some((first, _)) = columns.next() else { continue };
        let last = columns.last().map_or(first, |(column, _)| column);
        let here = CellRect { min: [first, y], max: [last + 1, y + 1] };
        around = Some(around.map_or(here, |around| around.around_both(&here)));
    }
    around
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
