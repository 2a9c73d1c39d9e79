//! Tells which bodies are meshed in a process of their own, because nothing bounds what the kernel may need for them.

use rustc_hash::FxHashMap;

use crate::boolean_chain::BooleanChain;
use crate::bounding_boxes::mapped_items;
use crate::kernel::File;

/// Longest chain of booleans, and deepest nesting of other items, of a body that is meshed in this process.
const CHAIN_MAX: usize = 64;
const DEPTH_MAX: usize = 16;

/// Items of which the work and the faces follow from the numbers of their records.
const BOUNDED: [&str; 17] = [
    "IFCEXTRUDEDAREASOLID",
    "IFCFACETEDBREP",
    "IFCFACETEDBREPWITHVOIDS",
    "IFCFACEBASEDSURFACEMODEL",
    "IFCSHELLBASEDSURFACEMODEL",
    "IFCTRIANGULATEDFACESET",
    "IFCTRIANGULATEDIRREGULARNETWORK",
    "IFCPOLYGONALFACESET",
    "IFCHALFSPACESOLID",
    "IFCBOXEDHALFSPACE",
    "IFCPOLYGONALBOUNDEDHALFSPACE",
    "IFCBLOCK",
    "IFCRECTANGULARPYRAMID",
    "IFCRIGHTCIRCULARCONE",
    "IFCRIGHTCIRCULARCYLINDER",
    "IFCSPHERE",
    "IFCBOUNDINGBOX",
];

/// Tells bounded items from others.
pub(crate) struct Bounds<'f, 'a> {
    file: &'f File<'a>,
    /// Mapped items are used many times.
    known: FxHashMap<u32, bool>,
}

impl<'f, 'a> Bounds<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self { file, known: FxHashMap::default() }
    }

    /// True if the kernel's work for all these items is bounded by the numbers of their records.
    pub(crate) fn hold(&mut self, items: &[u32]) -> bool {
        items.iter().all(|&item| self.holds(item, 0))
    }

    fn holds(&mut self, item: u32, depth: usize) -> bool {
        if let Some(known) = self.known.get(&item) {
            return *known;
        }
        let holds = depth <= DEPTH_MAX && self.is_bounded(item, depth);
        self.known.insert(item, holds);
        holds
    }

    fn is_bounded(&mut self, item: u32, depth: usize) -> bool {
        // What is not there is no work.
        let Some(record) = self.file.record(item) else { return true };
        let keyword = record.keyword.to_ascii_uppercase();
        match keyword.as_str() {
            "IFCMAPPEDITEM" => mapped_items(self.file, item)
                .collect::<Vec<u32>>()
                .into_iter()
                .all(|inner| self.holds(inner, depth + 1)),
            "IFCCSGSOLID" => record.at(0).reference().is_none_or(|tree| self.holds(tree, depth + 1)),
            "IFCBOOLEANRESULT" | "IFCBOOLEANCLIPPINGRESULT" => {
                let BooleanChain { booleans, base } = BooleanChain::of(self.file, item, |_| true);
                let operands = booleans.iter().filter_map(|boolean| boolean.at(2).reference()).chain(base);
                booleans.len() <= CHAIN_MAX
                    && operands.collect::<Vec<u32>>().into_iter().all(|id| self.holds(id, depth + 1))
            }
            keyword => BOUNDED.contains(&keyword),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, with_file};

    fn hold(records: &str) -> bool {
        with_file(&file(&format!("{BASICS}{records}")), |file| Bounds::new(file).hold(&[1]))
    }

    #[test]
    fn faces_and_extrusions_are_bounded_also_in_maps_and_booleans() {
        assert!(hold(
            "#1=IFCBOOLEANRESULT(.DIFFERENCE.,#2,#110);#2=IFCMAPPEDITEM(#3,#4);#3=IFCREPRESENTATIONMAP(#102,#120);"
        ));
        assert!(hold("#1=IFCCSGSOLID(#2);#2=IFCSPHERE(#102,1.);"));
        assert!(!hold("#1=IFCBOOLEANRESULT(.DIFFERENCE.,#110,#2);#2=IFCADVANCEDBREP(#3);"));
        assert!(!hold("#1=IFCSWEPTDISKSOLID(#2,0.1,$,$,$);"));
    }

    #[test]
    fn nesting_without_measure_is_not_bounded() {
        let chain = |n: usize| {
            let link = |k: usize| format!("#{k}=IFCBOOLEANRESULT(.UNION.,#{},#110);", if k < n { k + 1 } else { 110 });
            (1..=n).map(link).collect::<String>()
        };
        assert!(hold(&chain(60)) && !hold(&chain(90)));
        assert!(!hold("#1=IFCCSGSOLID(#2);#2=IFCCSGSOLID(#1);"));
    }
}
