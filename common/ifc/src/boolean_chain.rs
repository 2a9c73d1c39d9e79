//! Follows booleans along their first operands, however many there are: a wall may be cut by a thousand planes.

use rustc_hash::FxHashSet;

use crate::kernel::{File, Record};

/// Booleans from the outermost to the innermost, each the first operand of the one before.
pub(crate) struct BooleanChain<'a> {
    pub(crate) booleans: Vec<Record<'a>>,
    /// What the innermost cuts or joins; `None` if it is missing, or one of the booleans.
    pub(crate) base: Option<u32>,
}

impl<'a> BooleanChain<'a> {
    /// The chain that begins with an item, as long as it `goes_on`; an item that is no boolean is the base.
    pub(crate) fn of(file: &File<'a>, item: u32, goes_on: impl Fn(&Record<'a>) -> bool) -> Self {
        let mut chain = Self { booleans: Vec::new(), base: Some(item) };
        let mut met = FxHashSet::default();
        while let Some(id) = chain.base {
            let Some(record) = file.record(id).filter(|record| is_boolean(record) && goes_on(record)) else { break };
            chain.base = record.at(1).reference().filter(|_| met.insert(id));
            chain.booleans.push(record);
        }
        chain
    }
}

/// True for a boolean of two operands.
pub(crate) fn is_boolean(record: &Record<'_>) -> bool {
    record.is("IFCBOOLEANRESULT") || record.is("IFCBOOLEANCLIPPINGRESULT")
}

/// True if a boolean has this operator.
pub(crate) fn has_operator(record: &Record<'_>, operator: &str) -> bool {
    record.at(0).enumeration().is_some_and(|written| written.eq_ignore_ascii_case(operator))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, with_file};

    #[test]
    fn a_chain_ends_at_its_base_and_one_that_bites_its_tail_has_none() {
        let text = file(&format!(
            "{BASICS}#1=IFCBOOLEANRESULT(.UNION.,#2,#110);#2=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#110,#3);
             #3=IFCBOOLEANRESULT(.UNION.,#4,#110);#4=IFCBOOLEANRESULT(.UNION.,#3,#110);"
        ));
        with_file(&text, |file| {
            let ids = |chain: &BooleanChain<'_>| chain.booleans.iter().map(|record| record.id).collect::<Vec<_>>();
            let chain = BooleanChain::of(file, 1, |_| true);
            assert_eq!((ids(&chain), chain.base), (vec![1, 2], Some(110)));
            let unions = BooleanChain::of(file, 1, |record| has_operator(record, "UNION"));
            assert_eq!((ids(&unions), unions.base), (vec![1], Some(2)));
            assert_eq!(BooleanChain::of(file, 3, |_| true).base, None);
        });
    }
}
