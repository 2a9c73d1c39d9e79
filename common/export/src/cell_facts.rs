//! Colours of cells by what is known of each: they are looked up, not decided cell by cell.

use crate::image::Rgb;
use grid::Class;

/// The class of each cell, and facts about it.
pub(crate) struct CellFacts {
    /// The class, and a bit for each fact.
    keys: Vec<u16>,
    n_facts: usize,
}

/// Bits of a class in a key.
const CLASS_BITS: usize = 4;
const N_CLASSES: usize = 1 << CLASS_BITS;
const _: () = assert!(Class::ALL.len() <= N_CLASSES);

impl CellFacts {
    /// By the numbers of the classes; a number of no class has no class.
    pub(crate) fn of_classes(classes: &[u8]) -> Self {
        let keys = classes.iter().map(|&class| u16::from(class.min(N_CLASSES as u8 - 1))).collect();
        Self { keys, n_facts: 0 }
    }

    /// With one more fact, of each cell.
    pub(crate) fn with(mut self, is_so: impl Iterator<Item = bool>) -> Self {
        let bit = CLASS_BITS + self.n_facts;
        self.keys.iter_mut().zip(is_so).for_each(|(key, is_so)| *key |= u16::from(is_so) << bit);
        self.n_facts += 1;
        self
    }

    /// The colour of each cell, from its class and its facts in the order in which they were told.
    pub(crate) fn pixels<const N: usize>(self, colour: impl Fn(Option<Class>, [bool; N]) -> Rgb) -> Vec<Rgb> {
        debug_assert_eq!(self.n_facts, N);
        let colour_of = |key: usize| {
            let facts = std::array::from_fn(|k| key >> (CLASS_BITS + k) & 1 == 1);
            colour(Class::ALL.get(key % N_CLASSES).copied(), facts)
        };
        let colours: Vec<Rgb> = (0..N_CLASSES << N).map(colour_of).collect();
        self.keys.into_iter().map(|key| colours[usize::from(key)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_colour_of_its_class_and_of_its_own_facts() {
        let colour = |class: Option<Class>, [first, second]: [bool; 2]| {
            [class.map_or(u8::MAX, Class::id), u8::from(first), u8::from(second)]
        };
        let [none, wall, no_class] = [Class::None.id(), Class::Wall.id(), 200];
        let facts = CellFacts::of_classes(&[none, wall, wall, no_class]);
        let facts = facts.with([false, true, false, true].into_iter()).with([true, false, false, true].into_iter());
        assert_eq!(facts.pixels(colour), [[none, 0, 1], [wall, 1, 0], [wall, 0, 0], [u8::MAX, 1, 1]]);
    }
}
