//! Compares a revision of a site with the one before, and says what about it an operator has to confirm.

use crate::site_outline::{ElementOutline, GeoreferenceOutline, MapStoreyOutline, SiteOutline, StoreyOutline};
use diagnostics::counted;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Georeferences that differ by less are the same: files round.
const SAME_ORIGIN_M: f64 = 0.05;
const SAME_AXIS: f64 = 1e-5;
const SAME_SCALE: f64 = 1e-7;

/// An element of which a corner moved by more than this lies elsewhere: a decimetre.
const MOVED_TENTHS: u32 = 1_000;

/// A map storey whose floor lies within this is the one of before, whatever its name: a decimetre.
const SAME_FLOOR_TENTHS: u32 = 1_000;

/// A revision may have this many warnings more than twice those of before.
const MORE_WARNINGS: usize = 10;

/// How a revision differs from the site before it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SiteComparison {
    /// Storeys of the earlier site, then those that are new.
    pub storeys: Vec<StoreyDifference>,
    /// Elements by GlobalId.
    pub elements: Difference,
    /// Shared elements of which the body has other bounds.
    pub n_changed: usize,
    /// Shared elements of which the body lies more than a decimetre away.
    pub n_moved: usize,
    /// Rooms by GlobalId.
    pub rooms: Difference,
    /// Names of storeys that had a map and have none.
    pub unmapped: Vec<String>,
    /// Warnings and errors about the files, before and after.
    pub warnings: [usize; 2],
    /// Records that cannot be read, ids that are used again and references to nothing, before and after.
    pub damages: [usize; 2],
    /// True if the model lies elsewhere on earth, or it is no longer, or only now, known where.
    pub other_georeference: bool,
    /// What an operator has to confirm before the revision takes effect; nothing for one that does so by itself.
    pub objections: Vec<String>,
}

/// What came and went of one kind of things.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Difference {
    /// How many there were.
    pub before: usize,
    /// How many there are.
    pub after: usize,
    /// Those that are in both.
    pub shared: usize,
    /// Those that are new.
    pub added: usize,
    /// Those that are gone.
    pub removed: usize,
}

/// How a storey differs. Elements that moved to another storey are neither removed nor added.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoreyDifference {
    /// GlobalId.
    pub global_id: String,
    /// Name, of the revision where it has one.
    pub name: String,
    /// Which of the sites has it.
    pub presence: StoreyPresence,
    /// Its elements; `shared` are those that it had and that the revision has, on any storey.
    pub elements: Difference,
    /// Those of its elements that had a body.
    pub n_bodies: usize,
    /// Those of them that have none any more, or are gone.
    pub n_bodies_lost: usize,
}

/// Which of two sites has a storey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StoreyPresence {
    /// Both.
    Kept,
    /// The revision alone.
    Added,
    /// The earlier site alone.
    Removed,
}

/// True if two sites that share so many of their elements are revisions of one building: at least half of those of the smaller.
pub fn is_same_building(n_shared: usize, n_one: usize, n_other: usize) -> bool {
    2 * n_shared >= n_one.min(n_other)
}

impl SiteComparison {
    /// Compares; the frame of both is the same if they are of one building.
    pub fn of(before: &SiteOutline, after: &SiteOutline) -> Self {
        let shared = || {
            let both = before.elements.iter().filter_map(|(id, old)| Some((old, after.elements.get(id)?)));
            both.filter_map(|(old, new)| Some((old.bounds_tenths?, new.bounds_tenths?)))
        };
        let mut comparison = Self {
            storeys: storeys(before, after),
            elements: Difference::of(&before.elements, &after.elements),
            n_changed: shared().filter(|(old, new)| old != new).count(),
            n_moved: shared().filter(|(old, new)| is_moved(old, new)).count(),
            rooms: Difference::of(&before.rooms, &after.rooms),
            unmapped: unmapped(&before.map_storeys, &after.map_storeys),
            warnings: [before.n_warnings, after.n_warnings],
            damages: [before.n_damages, after.n_damages],
            other_georeference: !is_same_georeference(before.georeference.as_ref(), after.georeference.as_ref()),
            objections: Vec::new(),
        };
        comparison.objections = comparison.objections(shared().count());
        comparison
    }

    /// The comparison of the first revision of a site: it takes effect by itself.
    pub fn of_first(after: &SiteOutline) -> Self {
        Self { objections: Vec::new(), other_georeference: false, ..Self::of(&SiteOutline::default(), after) }
    }

    fn objections(&self, n_bodies: usize) -> Vec<String> {
        let Difference { before, after, shared, .. } = self.elements;
        let is_other = !is_same_building(shared, before, after);
        let other = is_other
            .then(|| format!("it shares {shared} of {} with the site in force", counted(before.min(after), "element")));
        let earth = self.other_georeference.then(|| "it has another georeference".to_owned());
        // Of another building nothing else is worth a word.
        let is_moved = !is_other && 2 * self.n_moved > n_bodies;
        let moved =
            is_moved.then(|| format!("{} of {n_bodies} shared elements lie more than 0.1 m from before", self.n_moved));
        let rest = if is_other { Vec::new() } else { self.losses() };
        other.into_iter().chain(earth).chain(moved).chain(rest).collect()
    }

    /// What a revision of a building seldom loses, and a file that is not whole does.
    fn losses(&self) -> Vec<String> {
        let most = |storey: &StoreyDifference| {
            let StoreyDifference { name, elements, n_bodies, n_bodies_lost, .. } = storey;
            if 2 * elements.removed > elements.before {
                let of = counted(elements.before, "element");
                return Some(format!("it removes {} of {of} of storey {name}", elements.removed));
            }
            let lost = || format!("{n_bodies_lost} of {n_bodies} elements of storey {name} that had a body have none");
            (2 * n_bodies_lost > *n_bodies).then(lost)
        };
        let unmapped = self.unmapped.iter().map(|name| format!("storey {name} has no map any more"));
        let [before, after] = self.warnings;
        let warnings = (after > 2 * before + MORE_WARNINGS)
            .then(|| format!("it has {}, the site in force has {before}", counted(after, "warning")));
        let [before, after] = self.damages;
        let damages = (after > before).then(|| {
            format!(
                "{} of it cannot be read, have an id that is used again, or refer to what is not there; in the site in force {before}",
                counted(after, "record")
            )
        });
        self.storeys.iter().filter_map(most).chain(unmapped).chain(warnings).chain(damages).collect()
    }
}

/// Map storeys of before that have none of their name and storey, nor one at their height.
fn unmapped(before: &[MapStoreyOutline], after: &[MapStoreyOutline]) -> Vec<String> {
    let is_kept = |old: &&MapStoreyOutline| {
        after.iter().any(|new| {
            let is_same = new.global_id == old.global_id && new.name == old.name;
            is_same || new.floor_z_tenths.abs_diff(old.floor_z_tenths) <= SAME_FLOOR_TENTHS
        })
    };
    before.iter().filter(|old| !is_kept(old)).map(|old| old.name.clone()).collect()
}

impl Difference {
    fn of<T>(before: &BTreeMap<String, T>, after: &BTreeMap<String, T>) -> Self {
        let shared = before.keys().filter(|id| after.contains_key(*id)).count();
        let (before, after) = (before.len(), after.len());
        Self { before, after, shared, added: after - shared, removed: before - shared }
    }
}

/// Storeys by GlobalId.
fn storeys(before: &SiteOutline, after: &SiteOutline) -> Vec<StoreyDifference> {
    let at = |outline: &SiteOutline, id: &str| outline.storeys.iter().position(|s| s.global_id == id);
    let difference = |storey: &StoreyOutline| {
        let [old, new] = [before, after].map(|outline| at(outline, &storey.global_id));
        let is_on = |element: &ElementOutline, k: Option<usize>| k.is_some() && element.storey.map(|s| s as usize) == k;
        let (mut elements, mut n_bodies, mut n_bodies_lost) = (Difference::default(), 0, 0);
        for (id, element) in before.elements.iter().filter(|(_, e)| is_on(e, old)) {
            elements.before += 1;
            let same = after.elements.get(id);
            elements.shared += usize::from(same.is_some());
            let has_body = |element: &ElementOutline| element.bounds_tenths.is_some();
            n_bodies += usize::from(has_body(element));
            n_bodies_lost += usize::from(has_body(element) && !same.is_some_and(has_body));
        }
        elements.removed = elements.before - elements.shared;
        for (id, _) in after.elements.iter().filter(|(_, e)| is_on(e, new)) {
            elements.after += 1;
            elements.added += usize::from(!before.elements.contains_key(id));
        }
        let name = new.map_or(&storey.name, |k| &after.storeys[k].name).clone();
        let presence = match (old, new) {
            (Some(_), Some(_)) => StoreyPresence::Kept,
            (None, _) => StoreyPresence::Added,
            (_, None) => StoreyPresence::Removed,
        };
        StoreyDifference { global_id: storey.global_id.clone(), name, presence, elements, n_bodies, n_bodies_lost }
    };
    let new = after.storeys.iter().filter(|s| at(before, &s.global_id).is_none());
    before.storeys.iter().chain(new).map(difference).collect()
}

fn is_moved(old: &[[i32; 3]; 2], new: &[[i32; 3]; 2]) -> bool {
    let corners = old.as_flattened().iter().zip(new.as_flattened());
    // Both corners move: a wall that grew at one end lies where it was.
    let is_far = |(a, b): (&i32, &i32)| a.abs_diff(*b) > MOVED_TENTHS;
    let [low, high] = [0, 3].map(|from| corners.clone().skip(from).take(3).any(is_far));
    low && high
}

fn is_same_georeference(old: Option<&GeoreferenceOutline>, new: Option<&GeoreferenceOutline>) -> bool {
    let (Some(old), Some(new)) = (old, new) else { return old.is_none() && new.is_none() };
    let is_near = |old: &[f64], new: &[f64], by: f64| old.iter().zip(new).all(|(a, b)| (a - b).abs() <= by);
    old.crs == new.crs
        && is_near(&old.origin_m, &new.origin_m, SAME_ORIGIN_M)
        && is_near(&old.x_axis, &new.x_axis, SAME_AXIS)
        && is_near(&old.scale, &new.scale, SAME_SCALE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Elements by their number: on storey `n / 100`, a metre apart.
    fn outline(elements: impl IntoIterator<Item = u32>) -> SiteOutline {
        let storey = |k: u32| StoreyOutline { global_id: format!("s{k}"), name: format!("Level {k}") };
        let element = |n: u32| {
            let x = n as i32 * 10_000;
            let bounds_tenths = Some([[x, 0, 0], [x + 2_000, 40_000, 30_000]]);
            (format!("e{n:04}"), ElementOutline { storey: Some(n / 100), bounds_tenths })
        };
        SiteOutline {
            georeference: None,
            storeys: (0..2).map(storey).collect(),
            elements: elements.into_iter().map(element).collect(),
            rooms: BTreeMap::new(),
            map_storeys: (0..2).map(|k| map_storey(&format!("Level {k}"), k * 30_000)).collect(),
            n_warnings: 0,
            n_damages: 0,
        }
    }

    fn map_storey(name: &str, floor_z_tenths: i32) -> MapStoreyOutline {
        MapStoreyOutline { global_id: name.to_lowercase(), name: name.to_owned(), floor_z_tenths }
    }

    fn objections(before: &SiteOutline, after: &SiteOutline) -> Vec<String> {
        SiteComparison::of(before, after).objections
    }

    #[test]
    fn a_revision_that_adds_removes_and_changes_some_elements_takes_effect_by_itself() {
        let before = outline((0..10).chain(100..110));
        let mut after = outline((2..14).chain(100..110));
        after.elements.get_mut("e0003").unwrap().bounds_tenths = Some([[30_000, 0, 0], [32_000, 90_000, 30_000]]);
        let comparison = SiteComparison::of(&before, &after);
        assert_eq!(comparison.elements, Difference { before: 20, after: 22, shared: 18, added: 4, removed: 2 });
        assert_eq!((comparison.n_changed, comparison.n_moved), (1, 0), "it grew at one end");
        let ground = &comparison.storeys[0];
        assert_eq!(ground.elements, Difference { before: 10, after: 12, shared: 8, added: 4, removed: 2 });
        assert_eq!(comparison.storeys[1].presence, StoreyPresence::Kept);
        assert_eq!(comparison.objections, Vec::<String>::new());
    }

    #[test]
    fn another_building_waits() {
        assert_eq!(objections(&outline(0..10), &outline(6..16)), ["it shares 4 of 10 elements with the site in force"]);
        assert_eq!(objections(&outline(0..10), &outline(0..5)).len(), 0, "half of a storey may go");
    }

    #[test]
    fn a_revision_that_removes_most_of_a_storey_waits() {
        let before = outline((0..10).chain(100..110));
        assert_eq!(
            objections(&before, &outline((0..10).chain(100..104))),
            ["it removes 6 of 10 elements of storey Level 1"]
        );
        let mut renumbered = before.clone();
        // Everything is on the ground floor now: nothing is gone.
        renumbered.elements.values_mut().for_each(|e| e.storey = Some(0));
        assert_eq!(objections(&before, &renumbered), Vec::<String>::new());
    }

    #[test]
    fn a_revision_that_takes_the_bodies_of_most_of_a_storey_waits() {
        let before = outline((0..10).chain(100..110));
        let mut after = before.clone();
        after
            .elements
            .iter_mut()
            .filter(|(id, _)| *id >= &"e0104".to_owned())
            .for_each(|(_, e)| e.bounds_tenths = None);
        assert_eq!(objections(&before, &after), ["6 of 10 elements of storey Level 1 that had a body have none"]);
    }

    #[test]
    fn a_revision_without_the_map_of_a_storey_waits_and_one_that_renames_or_raises_it_does_not() {
        let before = outline(0..10);
        let with = |map_storeys: Vec<MapStoreyOutline>| SiteOutline { map_storeys, ..before.clone() };
        let ground = || map_storey("Level 0", 0);
        assert_eq!(objections(&before, &with(vec![ground()])), ["storey Level 1 has no map any more"]);
        for upper in [map_storey("First floor", 30_500), map_storey("Level 1", 36_000)] {
            assert_eq!(objections(&before, &with(vec![ground(), upper])), Vec::<String>::new());
        }
    }

    #[test]
    fn a_revision_with_many_more_warnings_or_with_damaged_records_waits() {
        let before = SiteOutline { n_warnings: 5, n_damages: 1, ..outline(0..10) };
        let with = |n_warnings, n_damages| SiteOutline { n_warnings, n_damages, ..before.clone() };
        assert_eq!(objections(&before, &with(20, 1)), Vec::<String>::new());
        assert_eq!(objections(&before, &with(21, 1)), ["it has 21 warnings, the site in force has 5"]);
        let damaged = objections(&before, &with(6, 2));
        assert!(damaged.len() == 1 && damaged[0].starts_with("2 records of it cannot be read"), "{damaged:?}");
    }

    #[test]
    fn a_model_that_lies_elsewhere_waits() {
        let before = outline(0..10);
        let mut after = before.clone();
        for [low, high] in after.elements.values_mut().flat_map(|e| &mut e.bounds_tenths) {
            (low[1], high[1]) = (low[1] + 5_000, high[1] + 5_000);
        }
        assert_eq!(objections(&before, &after), ["10 of 10 shared elements lie more than 0.1 m from before"]);
    }

    #[test]
    fn another_georeference_waits_and_a_rounded_one_does_not() {
        let georeference = |east_m: f64| {
            let (crs, x_axis, scale) = ("EPSG:28992".to_owned(), [1.0, 0.0], [1.0; 3]);
            Some(GeoreferenceOutline { crs, origin_m: [east_m, 4e5, 0.0], x_axis, scale })
        };
        let check = |old: Option<GeoreferenceOutline>, new: Option<GeoreferenceOutline>, n_objections: usize| {
            let [before, after] = [old, new].map(|g| SiteOutline { georeference: g, ..outline(0..4) });
            assert_eq!(objections(&before, &after).len(), n_objections, "{before:?} {after:?}");
        };
        check(georeference(1e5), georeference(1e5 + 0.001), 0);
        check(georeference(1e5), georeference(1e5 + 1.0), 1);
        check(georeference(1e5), None, 1);
        check(None, georeference(1e5), 1);
        check(None, None, 0);
    }

    #[test]
    fn the_first_site_never_waits() {
        let first = SiteComparison::of_first(&outline(0..10));
        assert_eq!((first.elements.added, first.objections.len()), (10, 0));
    }

    proptest! {
        #[test]
        fn counts_add_up_and_the_same_site_never_waits(
            before in prop::collection::btree_set(0u32..200, 0..40),
            after in prop::collection::btree_set(0u32..200, 0..40),
        ) {
            let (before, after) = (outline(before), outline(after));
            let comparison = SiteComparison::of(&before, &after);
            let each = comparison.storeys.iter().map(|s| s.elements);
            for d in each.clone().chain([comparison.elements]) {
                prop_assert_eq!(d.shared + d.removed, d.before);
                prop_assert!(d.added <= d.after);
            }
            prop_assert_eq!(each.map(|d| d.removed).sum::<usize>(), comparison.elements.removed);
            let same = SiteComparison::of(&before, &before);
            prop_assert!(same.objections.is_empty() && same.n_changed == 0);
        }
    }
}
