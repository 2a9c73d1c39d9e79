//! Bodies of elements that touch along their sides: a wall with its leafs and linings, which a lidar sees as one.

use crate::sections::{Sections, metres};
use crate::thresholds::{LEAF_GAP_M, LEAF_SHARE, SAMPLE_M};
use std::collections::BTreeMap;

/// Elements of one body, by cut: each names the first of its body.
pub(crate) struct WallBodies {
    body: Vec<u32>,
    n_members: Vec<u32>,
}

impl WallBodies {
    /// Joins what touches along a large share of its border.
    pub(crate) fn of(sections: &Sections) -> Self {
        let mut body: Vec<u32> = (0..sections.cuts.len() as u32).collect();
        for cut in 0..sections.cuts.len() as u32 {
            for other in touched(sections, cut) {
                let (from, to) = (body[cut as usize], body[other as usize]);
                let (low, high) = (from.min(to), from.max(to));
                body.iter_mut().filter(|b| **b == high).for_each(|b| *b = low);
            }
        }
        let mut n_members = vec![0; body.len()];
        body.iter().for_each(|b| n_members[*b as usize] += 1);
        Self { body, n_members }
    }

    /// The body of an element.
    pub(crate) fn body(&self, cut: u32) -> u32 {
        self.body[cut as usize]
    }

    /// All elements of its body, itself included.
    pub(crate) fn members(&self, cut: u32) -> impl Iterator<Item = u32> + '_ {
        let body = self.body(cut);
        self.body.iter().zip(0..).filter(move |(b, _)| **b == body).map(|(_, cut)| cut)
    }

    /// True if it touches others along its sides.
    pub(crate) fn is_shared(&self, cut: u32) -> bool {
        self.n_members[self.body(cut) as usize] > 1
    }
}

/// Elements of the same kind and state that an element touches along that share of its own border.
fn touched(sections: &Sections, cut: u32) -> Vec<u32> {
    let own = &sections.cuts[cut as usize];
    if !own.can_be_leaf() {
        return Vec::new();
    }
    let mut counts = BTreeMap::<u32, usize>::new();
    let mut n = 0u32;
    for ring in own.section.area.rings() {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (a, b) = (metres(*a), metres(*b));
            let length_m = libm::hypot(b[0] - a[0], b[1] - a[1]);
            let steps = (length_m / SAMPLE_M).ceil() as usize;
            for k in 0..steps {
                let part = (k as f64 + 0.5) / steps as f64;
                let place = |out_m: f64| {
                    [
                        a[0] + (b[0] - a[0]) * part + (b[1] - a[1]) / length_m * out_m,
                        a[1] + (b[1] - a[1]) * part - (b[0] - a[0]) / length_m * out_m,
                    ]
                };
                n += 1;
                let mut beside: Vec<u32> =
                    [0.002, LEAF_GAP_M].into_iter().flat_map(|out_m| sections.at(place(out_m))).collect();
                beside.sort_unstable();
                beside.dedup();
                beside.into_iter().for_each(|other| *counts.entry(other).or_default() += 1);
            }
        }
    }
    let is_leaf = |other: u32| {
        let with = &sections.cuts[other as usize];
        other != cut && with.can_be_leaf() && with.stands == own.stands
    };
    counts
        .into_iter()
        .filter(|(other, count)| is_leaf(*other) && *count as f64 >= LEAF_SHARE * f64::from(n))
        .map(|(o, _)| o)
        .collect()
}
