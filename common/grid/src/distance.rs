//! Distance transform: squared distance to the nearest marked cell.

use crate::{SparseCells, SparseLayer};

/// Squared distance to the nearest marked cell, for every cell, in cells².
///
/// `marked` is row-major, `width` wide. Without a marked cell all are [`u32::MAX`]. Linear in cells.
///
/// # Source
/// Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8, 2012.
pub fn squared_distances(marked: &[bool], width: usize) -> Vec<u32> {
    let mut out: Vec<u32> = marked.iter().map(|&m| if m { 0 } else { u32::MAX }).collect();
    if out.is_empty() {
        return out;
    }
    // Along columns first, row after row: cells to the next marked one below, then above.
    for cell in width..out.len() {
        out[cell] = out[cell].min(out[cell - width].saturating_add(1));
    }
    for cell in (0..out.len() - width).rev() {
        out[cell] = out[cell].min(out[cell + width].saturating_add(1));
    }
    let mut envelope = Envelope::default();
    for row in out.chunks_exact_mut(width) {
        envelope.square(row);
    }
    out
}

/// [`squared_distances`] as a sparse layer: 0 where all cells of a chunk are marked. They take no room.
pub fn sparse_distances(marked: &[bool], width: usize) -> SparseLayer<u32> {
    let cells = SparseCells::of(marked.len(), |cell| !marked[cell]);
    let mut squared = cells.layer_of(0, |cell| if marked[cell] { 0 } else { u32::MAX });
    let mut row = vec![0; width];
    let mut beside = vec![u32::MAX; width];
    let add_step = |row: &mut [u32], beside: &[u32]| {
        row.iter_mut().zip(beside).for_each(|(cells, beside)| *cells = (*cells).min(beside.saturating_add(1)));
    };
    let firsts = (0..marked.len()).step_by(width.max(1));
    // Along columns: cells to the next marked one below.
    for first in firsts.clone() {
        squared.read(first, &mut row, |cells| cells);
        add_step(&mut row, &beside);
        squared.write(first, &row);
        std::mem::swap(&mut row, &mut beside);
    }
    // Above too; then along rows.
    let mut envelope = Envelope::default();
    beside.fill(u32::MAX);
    for first in firsts.rev() {
        squared.read(first, &mut row, |cells| cells);
        add_step(&mut row, &beside);
        beside.copy_from_slice(&row);
        if row.iter().any(|cells| *cells != 0) {
            envelope.square(&mut row);
            squared.write(first, &row);
        }
    }
    squared
}

/// The nearest marked cell, for every cell; [`u32::MAX`] without a marked cell. Ties are broken the same way each time.
///
/// `marked` is row-major, `width` wide. Linear in cells.
///
/// # Source
/// As for [`squared_distances`].
pub fn nearest_marked(marked: &[bool], width: usize) -> Vec<u32> {
    let height = marked.len().checked_div(width).unwrap_or(0);
    let mut squared: Vec<u32> = marked.iter().map(|&m| if m { 0 } else { u32::MAX }).collect();
    let mut in_row = vec![u32::MAX; squared.len()];
    if squared.is_empty() {
        return in_row;
    }
    let mut envelope = Envelope::default();
    for (row, cells) in squared.chunks_exact_mut(width).enumerate() {
        let first = row * width;
        envelope.of(cells);
        envelope.draw(cells, |squared, cell, nearest, from_nearest| {
            *squared = from_nearest;
            in_row[first + cell] = (first + nearest) as u32;
        });
    }
    let mut out = vec![u32::MAX; squared.len()];
    let mut line = vec![0; height];
    for column in 0..width {
        line.iter_mut().zip(squared[column..].iter().step_by(width)).for_each(|(to, from)| *to = *from);
        envelope.of(&line);
        envelope.draw(&mut line, |_, row, nearest, _| out[row * width + column] = in_row[nearest * width + column]);
    }
    out
}

/// The lower envelope of the squared distances along a line of cells; its buffer serves for many.
#[derive(Default)]
struct Envelope {
    parabolas: Vec<Parabola>,
}

/// Squared distances to a marked cell beside the line.
#[derive(Clone, Copy)]
struct Parabola {
    /// Where the envelope begins to be this one.
    from: f64,
    /// Its cell on the line, and the squared distance there.
    at: u32,
    value: u32,
    /// That distance and the square of the cell's number: what parabolas are compared by.
    height: f64,
}

impl Envelope {
    /// Makes squared distances in two dimensions of a row of distances along columns: between two marked cells nothing beyond them is
    /// nearer.
    fn square(&mut self, row: &mut [u32]) {
        let mut from = 0;
        while let Some(first) = row[from..].iter().position(|cells| *cells != 0) {
            let first = from + first;
            let end = row[first..].iter().position(|cells| *cells == 0).map_or(row.len(), |n| first + n);
            let last = (end + 1).min(row.len());
            self.square_gap(&mut row[first.saturating_sub(1)..last]);
            from = end;
        }
    }

    /// The same between two marked cells. Of equal distances beside each other those at the ends are taken into the envelope: of the
    /// others each is the least at its own cell alone.
    fn square_gap(&mut self, gap: &mut [u32]) {
        self.parabolas.clear();
        let mut at = 0;
        for equal in gap.chunk_by_mut(|a, b| a == b) {
            let last = at + equal.len() as u32 - 1;
            if equal[0] != u32::MAX {
                let squared = equal[0].saturating_mul(equal[0]);
                equal.fill(squared);
                self.add(at, squared);
                if last > at {
                    self.add(last, squared);
                }
            }
            at = last + 1;
        }
        self.draw(gap, |own, _, _, squared| *own = (*own).min(squared));
    }

    /// Takes the envelope of squared distances beside a line.
    fn of(&mut self, values: &[u32]) {
        self.parabolas.clear();
        for (at, &value) in (0..).zip(values).filter(|(_, value)| **value != u32::MAX) {
            self.add(at, value);
        }
    }

    /// Takes the squared distance beside a cell into the envelope of those before it.
    fn add(&mut self, at: u32, value: u32) {
        let number = f64::from(at);
        let height = f64::from(value) + number * number;
        let mut from = f64::NEG_INFINITY;
        while let Some(before) = self.parabolas.last() {
            let above = height - before.height;
            // Mostly the parabola before is that of the cell before: a division less.
            let n = at - before.at;
            from = if n == 1 { above * 0.5 } else { above / (2.0 * f64::from(n)) };
            if from > before.from {
                break;
            }
            self.parabolas.pop();
            from = f64::NEG_INFINITY;
        }
        self.parabolas.push(Parabola { from, at, value, height });
    }

    /// Calls `set` with the value of every cell of a line, its number, that of the nearest cell and the squared distance to it.
    fn draw(&self, cells: &mut [u32], mut set: impl FnMut(&mut u32, usize, usize, u32)) {
        let mut done = 0;
        for (k, parabola) in self.parabolas.iter().enumerate() {
            let next = self.parabolas.get(k + 1).filter(|next| next.from < cells.len() as f64);
            let end = next.map_or(cells.len(), |next| if next.from < 0.0 { 0 } else { next.from as usize + 1 });
            let Parabola { at, value, .. } = *parabola;
            for (q, cell) in (done as u32..).zip(cells.get_mut(done..end).unwrap_or_default()) {
                let off = q.abs_diff(at);
                set(cell, q as usize, at as usize, value.saturating_add(off.wrapping_mul(off)));
            }
            done = done.max(end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn without_a_marked_cell_everything_is_far() {
        assert_eq!(squared_distances(&[false; 6], 3), [u32::MAX; 6]);
        assert!(squared_distances(&[], 0).is_empty());
    }

    proptest! {
        #[test]
        fn distances_agree_with_trying_every_cell(width in 1..12usize, marked in prop::collection::vec(prop::bool::weighted(0.2), 1..100)) {
            let marked = &marked[..marked.len() / width * width];
            let at = |i: usize| ((i % width) as i64, (i / width) as i64);
            let found = squared_distances(marked, width);
            let layer = sparse_distances(marked, width);
            prop_assert!((0..marked.len()).all(|cell| layer[cell] == found[cell]));
            for (i, d) in found.iter().enumerate() {
                let slow = (0..marked.len()).filter(|&j| marked[j])
                    .map(|j| (at(i).0 - at(j).0).pow(2) + (at(i).1 - at(j).1).pow(2)).min();
                prop_assert_eq!(i64::from(*d), slow.unwrap_or(i64::from(u32::MAX)));
                let nearest = nearest_marked(marked, width)[i] as usize;
                match slow {
                    None => prop_assert_eq!(nearest, u32::MAX as usize),
                    Some(d) => {
                        prop_assert!(marked[nearest]);
                        prop_assert_eq!((at(i).0 - at(nearest).0).pow(2) + (at(i).1 - at(nearest).1).pow(2), d);
                    }
                }
            }
        }
    }
}
