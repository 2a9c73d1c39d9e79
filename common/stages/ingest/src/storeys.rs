//! Selects the storeys that get a map, and their floor heights.

use crate::floor_levels::{FloorFaces, FloorSampling, REACH, dominant_height};
use crate::floor_samples::{FloorTriangles, STEP};
use geometry::{MultiPolygon, union_of};
use messages::FloorKind;
use std::collections::HashMap;

/// Minimum floor area of a storey with a map.
const MIN_FLOOR_M2: f64 = 1.0;

/// Height above a floor within which bodies are relevant, in tenths of a millimetre.
const BODY_HEIGHT: i32 = 12_500;

/// So many walls that stand at a height enclose something.
const MIN_WALLS: usize = 3;

/// Levels of a file without storeys are at least this far apart.
const MIN_STOREY_HEIGHT: i32 = 20_000;

/// An IfcBuildingStorey, as far as its floor is concerned; heights in tenths of a millimetre in `map`.
#[derive(Debug, Clone)]
pub(crate) struct StoreyCandidate {
    /// Height of its placement, else its elevation.
    pub(crate) placement_z: Option<i32>,
    /// Number of elements that it contains.
    pub(crate) n_elements: usize,
    /// Lowest and highest point of each body that it contains.
    pub(crate) bodies: Vec<[i32; 2]>,
    /// Tops of the floor elements that it contains, footings not counted, from low to high.
    pub(crate) own_floors: Vec<i32>,
    /// Tops of the footings that it contains.
    pub(crate) own_footings: Vec<i32>,
}

/// Inputs of the selection of storeys.
#[derive(Debug)]
pub(crate) struct BuildingInputs<'a> {
    /// Storeys of the files.
    pub(crate) candidates: &'a [StoreyCandidate],
    /// Rooms with a floor, and spaces outdoors; no shafts.
    pub(crate) spaces: &'a [SpaceFloor],
    /// Upward faces of what is floor.
    pub(crate) faces: &'a FloorFaces,
    /// Lowest point of all bodies.
    pub(crate) lowest_body: Option<i32>,
    /// Lowest and highest point of each wall and curtain wall, wherever it is contained.
    pub(crate) walls: &'a [[i32; 2]],
}

/// A space's floor.
#[derive(Debug, Clone)]
pub(crate) struct SpaceFloor {
    pub(crate) polygon: MultiPolygon,
    pub(crate) z: i32,
    pub(crate) area_m2: f64,
    /// Index of the storey that contains it.
    pub(crate) storey: Option<usize>,
    /// True if it is outdoors: it has floor only where something is built.
    pub(crate) is_external: bool,
    /// True if its name says that nothing is there to stand on.
    pub(crate) is_void: bool,
}

/// A storey to be mapped.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapStorey {
    pub(crate) z: i32,
    pub(crate) floor: FloorKind,
    /// The storey it is named after; `None` in a file without storeys.
    pub(crate) named_after: Option<usize>,
    /// The map storey of which it is a level at another height.
    pub(crate) level_of: Option<usize>,
}

/// Outcome of each storey of the files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum StoreyOutcome {
    /// It gave its name to this map storey.
    Mapped(usize),
    /// Its floor coincides with this map storey's.
    Joined(usize),
    /// It has no map.
    NotMapped(&'static str),
}

/// The storeys to be mapped, from low to high, and the outcome of each candidate.
pub(crate) fn map_storeys(building: &BuildingInputs<'_>) -> (Vec<MapStorey>, Vec<StoreyOutcome>) {
    let candidates = building.candidates;
    if candidates.is_empty() {
        return (without_storeys(building), Vec::new());
    }
    let mut found = FloorsFound::new();
    let floors: Vec<FoundFloor> = (0..candidates.len()).map(|k| floor_of(k, building, &mut found)).collect();
    let mut order: Vec<usize> = (0..candidates.len()).filter(|&k| floors[k].is_ok()).collect();
    order.sort_by_key(|&k| (floors[k].map_or(0, |f| f.0), k));
    let mut outcomes: Vec<StoreyOutcome> =
        floors.iter().map(|f| StoreyOutcome::NotMapped(f.err().unwrap_or_default())).collect();
    let mut mapped: Vec<MapStorey> = Vec::new();
    let space_area = |k: usize| building.rooms().filter(|s| s.storey == Some(k)).map(|s| s.area_m2).sum::<f64>();
    for group in order.chunk_by(|&a, &b| floors[b].map_or(0, |f| f.0) - floors[a].map_or(0, |f| f.0) <= STEP) {
        let z_of = |k: usize| floors[k].map_or(0, |f| f.0);
        let better = |&a: &usize, &b: &usize| {
            fits(&candidates[a], z_of(a))
                .cmp(&fits(&candidates[b], z_of(b)))
                .then(space_area(a).total_cmp(&space_area(b)))
                .then(far_from_placement(&candidates[b], z_of(b)).cmp(&far_from_placement(&candidates[a], z_of(a))))
                .then(candidates[a].n_elements.cmp(&candidates[b].n_elements))
                .then(b.cmp(&a))
        };
        let Some(first) = group.iter().copied().max_by(|a, b| better(a, b)) else { continue };
        for &k in group {
            outcomes[k] =
                if k == first { StoreyOutcome::Mapped(mapped.len()) } else { StoreyOutcome::Joined(mapped.len()) };
        }
        if let Ok((z, floor)) = floors[first] {
            mapped.push(MapStorey { z, floor, named_after: Some(first), level_of: None });
        }
    }
    (mapped, outcomes)
}

/// True if the storey's elevation or a floor that it contains is at this height.
fn fits(candidate: &StoreyCandidate, z: i32) -> bool {
    let heights = candidate.placement_z.iter().chain(&candidate.own_floors);
    heights.into_iter().any(|h| (h - z).abs() <= STEP)
}

fn far_from_placement(candidate: &StoreyCandidate, z: i32) -> i32 {
    candidate.placement_z.map_or(i32::MAX, |p| (p - z).abs())
}

impl BuildingInputs<'_> {
    /// Rooms that are not outdoors.
    fn rooms(&self) -> impl Iterator<Item = &SpaceFloor> {
        self.spaces.iter().filter(|s| !s.is_external)
    }

    /// Floor kind of a model without rooms and relevant floor faces: enclosed by walls, if there are any.
    fn kind_if_bare(&self) -> Option<FloorKind> {
        let floor_m2: f64 = self.faces.all().map(plan_area_m2).sum();
        let kind = if !self.walls.is_empty() { FloorKind::AssumedFromEnclosure } else { FloorKind::Missing };
        (self.rooms().next().is_none() && floor_m2 < MIN_FLOOR_M2).then_some(kind)
    }

    /// True if walls stand at a height: they begin near it, and are as high as a storey. Those of foundations are not.
    fn walls_stand_at(&self, z: i32) -> bool {
        self.walls.iter().filter(|w| (w[0] - z).abs() <= REACH && z + MIN_STOREY_HEIGHT < w[1]).count() >= MIN_WALLS
    }

    /// True if footings near a height are the floor of a storey: of one that contains some, or in which bodies begin there.
    fn counts_footings(&self, storey: usize, guess: i32) -> bool {
        let StoreyCandidate { bodies, own_footings, .. } = &self.candidates[storey];
        let stands_here = bodies.iter().any(|b| guess - REACH <= b[0] && b[0] < guess + BODY_HEIGHT);
        stands_here || own_footings.iter().any(|z| (z - guess).abs() <= REACH)
    }
}

/// Height and kind of a floor, or why there is none.
type FoundFloor = Result<(i32, FloorKind), &'static str>;

/// What was found near a height, with footings as floor or without: the buildings of a site may have a storey at it each.
type FloorsFound = HashMap<(i32, bool), FoundFloor>;

/// Height and kind of a storey's floor, or why it has none.
fn floor_of(storey: usize, building: &BuildingInputs<'_>, found: &mut FloorsFound) -> FoundFloor {
    let StoreyCandidate { placement_z: placement, ref bodies, ref own_floors, ref own_footings, .. } =
        building.candidates[storey];
    let lowest = bodies.iter().map(|b| b[0]).min();
    let near_placement = own_heights(storey, building, placement);
    let guess = match placement {
        // A placement far from all its spaces is wrong.
        Some(z) if own_heights(storey, building, None).is_empty() || !near_placement.is_empty() => z,
        _ => {
            let own_floor = own_floors.iter().chain(own_footings).min().copied();
            let spaces = weighted_height(&own_heights(storey, building, None));
            let guesses = [spaces, placement, own_floor, lowest];
            guesses.into_iter().flatten().next().ok_or("it has no placement and contains nothing")?
        }
    };
    if let Some(kind) = building.kind_if_bare() {
        // Where nothing stands at the placement, the lowest body does.
        let reaches_here = |b: &[i32; 2]| b[0] < guess + BODY_HEIGHT && guess + STEP < b[1];
        let stands_here = bodies.iter().any(reaches_here) || building.walls_stand_at(guess);
        let z = if stands_here { Some(guess) } else { lowest };
        return z.map(|z| (z, kind)).ok_or("it contains nothing");
    }
    let mut floor_near = |z: i32| {
        let with_footings = building.counts_footings(storey, z);
        *found.entry((z, with_footings)).or_insert_with(|| floor_near(building, z, with_footings))
    };
    floor_near(guess).or_else(|why| {
        // A bridge's deck lies high above the storey's placement, at which its piers' footings are.
        let is_near = |t: &[[i32; 3]; 3]| t.iter().any(|v| (v[2] - guess).abs() <= REACH);
        let stands_on_footings =
            !building.counts_footings(storey, guess) && building.faces.footings.iter().any(is_near);
        match own_floors.first() {
            Some(z) if stands_on_footings => floor_near(*z),
            _ => Err(why),
        }
    })
}

/// Heights of the floors of a storey's spaces with their areas, from low to high; those near a height, if one is given.
fn own_heights(storey: usize, building: &BuildingInputs<'_>, near: Option<i32>) -> Vec<(i32, f64)> {
    let is_own = |s: &&SpaceFloor| s.storey == Some(storey) && near.is_none_or(|z| (s.z - z).abs() <= REACH);
    let mut heights: Vec<(i32, f64)> = building.rooms().filter(is_own).map(|s| (s.z, s.area_m2)).collect();
    heights.sort_by_key(|h| h.0);
    heights
}

/// Height and kind of the floor near a height, or why there is none.
fn floor_near(building: &BuildingInputs<'_>, guess: i32, with_footings: bool) -> FoundFloor {
    let near: Vec<&SpaceFloor> = building.rooms().filter(|s| (s.z - guess).abs() <= REACH).collect();
    let rooms = union_of(near.iter().map(|s| &s.polygon));
    let footings = with_footings.then_some(&building.faces.footings);
    let lists: Vec<&FloorTriangles> = std::iter::once(&building.faces.slabs).chain(footings).collect();
    let sampling = FloorSampling::new(&lists, guess, &rooms);
    let level = sampling.as_ref().and_then(|s| s.level(guess));
    if rooms.is_empty() {
        return match level {
            Some(level) if level.area_m2 >= MIN_FLOOR_M2 => Ok((level.z, FloorKind::Built)),
            _ if building.walls_stand_at(guess) => Ok((guess, FloorKind::AssumedFromEnclosure)),
            _ => Err("there is no floor within 0.5 m of it, no space, and no walls stand on it"),
        };
    }
    match level {
        Some(level) if sampling.is_some_and(|s| s.share() >= 0.5) => Ok((level.z, FloorKind::Built)),
        _ => {
            let mut heights: Vec<(i32, f64)> = near.iter().map(|s| (s.z, s.area_m2)).collect();
            heights.sort_by_key(|h| h.0);
            weighted_height(&heights).map(|z| (z, FloorKind::AssumedFromSpaces)).ok_or("its spaces have no floor")
        }
    }
}

/// The height that most area has, of heights sorted from low to high.
fn weighted_height(heights: &[(i32, f64)]) -> Option<i32> {
    let sums = heights.chunk_by(|a, b| a.0 == b.0).map(|same| (same[0].0, same.iter().map(|h| h.1).sum::<f64>()));
    sums.fold(None, |best: Option<(i32, f64)>, h| if best.is_none_or(|b| h.1 > b.1) { Some(h) } else { best })
        .map(|b| b.0)
}

/// Levels of a file without storeys: where much floor lies, else where spaces stand, else the lowest body.
fn without_storeys(building: &BuildingInputs<'_>) -> Vec<MapStorey> {
    let map_storey = |z: i32, floor: FloorKind| MapStorey { z, floor, named_after: None, level_of: None };
    if let Some(kind) = building.kind_if_bare() {
        return building.lowest_body.map(|z| map_storey(z, kind)).into_iter().collect();
    }
    let faces = || building.faces.all().map(|t| ((t[0][2] + t[1][2] + t[2][2]) / 3, plan_area_m2(t)));
    let has_floor = faces().map(|face| face.1).sum::<f64>() >= MIN_FLOOR_M2;
    let mut rest: Vec<(i32, f64)> =
        if has_floor { faces().collect() } else { building.rooms().map(|s| (s.z, s.area_m2)).collect() };
    let mut levels: Vec<(i32, f64)> = Vec::new();
    rest.sort_by_key(|r| r.0);
    while let Some(z) = dominant_by_area(&rest) {
        let area = rest.iter().filter(|r| (r.0 - z).abs() <= STEP).map(|r| r.1).sum::<f64>();
        if area < MIN_FLOOR_M2 || levels.first().is_some_and(|l| area < l.1 / 4.0) {
            break;
        }
        levels.push((z, area));
        rest.retain(|r| (r.0 - z).abs() >= MIN_STOREY_HEIGHT);
    }
    let kind = if has_floor { FloorKind::Built } else { FloorKind::AssumedFromSpaces };
    let mut mapped: Vec<MapStorey> = levels.iter().map(|l| map_storey(l.0, kind)).collect();
    mapped.sort_by_key(|m| m.z);
    mapped
}

/// The height around which most area lies within a step, of heights sorted from low to high.
fn dominant_by_area(sorted: &[(i32, f64)]) -> Option<i32> {
    // Areas in square decimetres stand for that many samples.
    let samples: Vec<i32> = sorted
        .iter()
        .flat_map(|&(z, area)| std::iter::repeat_n(z, (area * 100.0).clamp(1.0, 10_000.0) as usize))
        .collect();
    dominant_height(&samples, samples.first().copied()?)
}

fn plan_area_m2(t: &[[i32; 3]; 3]) -> f64 {
    let d = |k: usize, i: usize| f64::from(t[k][i]) - f64::from(t[0][i]);
    (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)) / 2.0 / 1e8
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, union};

    fn square(x: i32, side: i32, z: i32) -> FloorTriangles {
        vec![[[x, 0, z], [x + side, 0, z], [x + side, side, z]], [[x, 0, z], [x + side, side, z], [x, side, z]]]
    }

    fn storey(z: i32, n_elements: usize) -> StoreyCandidate {
        let bodies = vec![[z, z + 25_000]];
        StoreyCandidate { placement_z: Some(z), n_elements, bodies, own_floors: vec![], own_footings: vec![] }
    }

    /// What is mapped of a building with walls whose floor is slabs.
    fn mapped(
        candidates: &[StoreyCandidate],
        spaces: &[SpaceFloor],
        slabs: FloorTriangles,
    ) -> (Vec<MapStorey>, Vec<StoreyOutcome>) {
        let faces = FloorFaces { slabs, ..FloorFaces::default() };
        let lowest_body = candidates.iter().flat_map(|c| &c.bodies).map(|b| b[0]).min();
        let walls: Vec<[i32; 2]> = candidates.iter().flat_map(|c| c.bodies.iter().copied()).collect();
        map_storeys(&BuildingInputs { candidates, spaces, faces: &faces, lowest_body, walls: &walls })
    }

    fn space(side: i32, z: i32, storey: usize) -> SpaceFloor {
        let polygon = union(&[vec![[0, 0], [side, 0], [side, side], [0, side]]], FillRule::NonZero);
        SpaceFloor { area_m2: polygon.area_m2(), polygon, z, storey: Some(storey), is_external: false, is_void: false }
    }

    #[test]
    fn the_floor_is_the_slabs_top_and_not_the_placement() {
        let (mapped, outcomes) = mapped(&[storey(0, 5)], &[space(80_000, 0, 0)], square(0, 100_000, 2_000));
        assert_eq!(mapped, [MapStorey { z: 2_000, floor: FloorKind::Built, named_after: Some(0), level_of: None }]);
        assert_eq!(outcomes, [StoreyOutcome::Mapped(0)]);
    }

    #[test]
    fn storeys_whose_floors_coincide_are_one_named_after_the_spaces() {
        let candidates = [storey(-2_000, 50), storey(0, 5), storey(28_000, 1)];
        let (mapped, outcomes) = mapped(&candidates, &[space(80_000, 0, 1)], square(0, 100_000, 0));
        assert_eq!(mapped.len(), 1);
        assert_eq!(outcomes[..2], [StoreyOutcome::Joined(0), StoreyOutcome::Mapped(0)]);
        assert!(matches!(outcomes[2], StoreyOutcome::NotMapped(_)));
    }

    #[test]
    fn a_storey_without_slabs_is_assumed_from_its_spaces() {
        let (mapped, _) = mapped(&[storey(0, 5)], &[space(80_000, 300, 0)], square(0, 10_000, 0));
        assert_eq!(
            mapped,
            [MapStorey { z: 300, floor: FloorKind::AssumedFromSpaces, named_after: Some(0), level_of: None }]
        );
    }

    #[test]
    fn without_floor_or_spaces_anywhere_storeys_that_hold_something_are_assumed() {
        let empty = StoreyCandidate { bodies: vec![], ..storey(30_000, 0) };
        let (mapped, outcomes) = mapped(&[storey(0, 5), empty], &[], vec![]);
        assert_eq!(mapped[0].floor, FloorKind::AssumedFromEnclosure);
        assert_eq!(outcomes[1], StoreyOutcome::NotMapped("it contains nothing"));
    }

    #[test]
    fn bodies_far_above_an_undefined_storey_are_mapped_where_they_stand() {
        let undefined = StoreyCandidate { bodies: vec![[29_000, 31_000]], ..storey(0, 1) };
        let (mapped, _) = mapped(&[undefined], &[], vec![]);
        assert_eq!(mapped[0].z, 29_000);
    }

    #[test]
    fn a_placement_far_from_its_spaces_is_not_believed() {
        let mut faces = square(0, 100_000, 0);
        faces.extend(square(0, 100_000, 30_000));
        let (mapped, _) = mapped(&[storey(0, 5)], &[space(80_000, 30_000, 0)], faces);
        assert_eq!(mapped[0].z, 30_000);
    }

    #[test]
    fn a_storey_without_a_placement_is_found_by_its_floor() {
        let bodies = vec![[-3_000, 0]];
        let lost = StoreyCandidate { placement_z: None, bodies, own_floors: vec![1_000], ..storey(0, 9) };
        let (mapped, _) = mapped(&[lost], &[], square(0, 100_000, 1_000));
        assert_eq!(mapped, [MapStorey { z: 1_000, floor: FloorKind::Built, named_after: Some(0), level_of: None }]);
    }

    #[test]
    fn a_file_without_storeys_has_the_levels_of_its_floors() {
        let mut faces = square(0, 100_000, 0);
        faces.extend(square(0, 90_000, 30_000));
        faces.extend(square(0, 20_000, 10_000));
        let (mapped, _) = mapped(&[], &[], faces);
        assert_eq!(mapped.iter().map(|m| m.z).collect::<Vec<_>>(), [0, 30_000]);
    }
    #[test]
    fn a_storey_takes_the_name_whose_elevation_or_slab_fits() {
        let ceiling = StoreyCandidate { n_elements: 90, ..storey(28_000, 90) };
        let floor = storey(30_480, 2);
        let (mapped, outcomes) = mapped(&[ceiling.clone(), floor], &[], square(0, 100_000, 30_480));
        assert_eq!((mapped[0].named_after, &outcomes[0]), (Some(1), &StoreyOutcome::Joined(0)));
        let own_slab = StoreyCandidate { own_floors: vec![30_480], ..ceiling };
        let (mapped, _) = super::tests::mapped(&[own_slab, storey(29_500, 2)], &[], square(0, 100_000, 30_480));
        assert_eq!(mapped[0].named_after, Some(0));
    }

    #[test]
    fn a_footing_below_a_bridge_is_no_floor_of_its_superstructure() {
        let foundation = StoreyCandidate { own_footings: vec![0], bodies: vec![[-8_000, 0]], ..storey(0, 2) };
        let superstructure =
            StoreyCandidate { own_floors: vec![60_000], bodies: vec![[52_000, 60_000]], ..storey(0, 3) };
        let slabs = square(0, 100_000, 60_000);
        let faces = FloorFaces { slabs, footings: square(0, 40_000, 0) };
        let mapped = |candidates: &[StoreyCandidate]| {
            let building = BuildingInputs { candidates, spaces: &[], faces: &faces, lowest_body: None, walls: &[] };
            map_storeys(&building).0.iter().map(|m| (m.z, m.named_after)).collect::<Vec<_>>()
        };
        assert_eq!(mapped(&[superstructure.clone(), foundation]), [(0, Some(1)), (60_000, Some(0))]);
        let without_deck = StoreyCandidate { own_floors: vec![], ..superstructure };
        assert_eq!(mapped(&[without_deck]), []);
    }

    #[test]
    fn a_survey_marker_does_not_decide_that_a_model_has_floor() {
        let (mapped, _) = mapped(&[storey(0, 5)], &[], square(50_000, 700, 0));
        assert_eq!(mapped[0].floor, FloorKind::AssumedFromEnclosure);
        let (mapped, _) = super::tests::mapped(&[], &[space(80_000, 300, 0)], square(50_000, 700, 0));
        assert_eq!((mapped[0].z, mapped[0].floor), (300, FloorKind::AssumedFromSpaces));
    }

    #[test]
    fn without_walls_and_spaces_there_is_no_floor() {
        let candidates = [storey(0, 5)];
        let faces = FloorFaces::default();
        let building =
            BuildingInputs { candidates: &candidates, spaces: &[], faces: &faces, lowest_body: Some(0), walls: &[] };
        assert_eq!(map_storeys(&building).0[0].floor, FloorKind::Missing);
        assert_eq!(map_storeys(&BuildingInputs { candidates: &[], ..building }).0[0].floor, FloorKind::Missing);
    }
}
