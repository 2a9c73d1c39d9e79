//! Which storeys can be walked, and at what height.

use crate::levels::{FloorTriangles, REACH, STEP, Sampling, dominant_height};
use geometry::{MultiPolygon, union_of};
use messages::FloorKind;

/// A storey with less floor than this is not worth a map.
const LEAST_FLOOR_M2: f64 = 1.0;

/// What stands within this height above a floor matters to a robot.
const BODY_HEIGHT: i32 = 12_500;

/// Levels of a file without storeys are at least this far apart.
const LEAST_STOREY_HEIGHT: i32 = 20_000;

/// An IfcBuildingStorey, as far as its floor is concerned; heights in tenths of a millimetre in `map`.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Height of its placement, else its elevation.
    pub(crate) placement_z: Option<i32>,
    /// Number of elements that it contains.
    pub(crate) n_elements: usize,
    /// Lowest and highest point of each body that it contains.
    pub(crate) bodies: Vec<[i32; 2]>,
    /// Top of the lowest floor that it contains: a guess where the placement is missing.
    pub(crate) own_floor: Option<i32>,
}

/// A space's floor.
#[derive(Debug, Clone)]
pub(crate) struct SpaceFloor {
    pub(crate) polygon: MultiPolygon,
    pub(crate) z: i32,
    pub(crate) area_m2: f64,
    /// Index of the storey that contains it.
    pub(crate) storey: Option<usize>,
}

/// A storey to be mapped.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapStorey {
    pub(crate) z: i32,
    pub(crate) floor: FloorKind,
    /// The storey it is named after; `None` in a file without storeys.
    pub(crate) named_after: Option<usize>,
}

/// What became of each candidate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Fate {
    /// It gave its name to this map storey.
    Mapped(usize),
    /// Its floor coincides with this map storey's.
    Joined(usize),
    /// It has no map.
    NotMapped(&'static str),
}

/// The storeys to be mapped, from low to high, and what became of each candidate.
pub(crate) fn map_storeys(
    candidates: &[Candidate],
    spaces: &[SpaceFloor],
    faces: &FloorTriangles,
    lowest_body: Option<i32>,
) -> (Vec<MapStorey>, Vec<Fate>) {
    if candidates.is_empty() {
        return (without_storeys(spaces, faces, lowest_body), Vec::new());
    }
    let bare = faces.is_empty() && spaces.is_empty();
    let floors: Vec<Result<(i32, FloorKind), &'static str>> =
        (0..candidates.len()).map(|k| floor_of(k, candidates, spaces, faces, bare)).collect();
    let mut order: Vec<usize> = (0..candidates.len()).filter(|&k| floors[k].is_ok()).collect();
    order.sort_by_key(|&k| (floors[k].map_or(0, |f| f.0), k));
    let mut fates: Vec<Fate> = floors.iter().map(|f| Fate::NotMapped(f.err().unwrap_or_default())).collect();
    let mut mapped: Vec<MapStorey> = Vec::new();
    let space_area = |k: usize| spaces.iter().filter(|s| s.storey == Some(k)).map(|s| s.area_m2).sum::<f64>();
    for group in order.chunk_by(|&a, &b| floors[b].map_or(0, |f| f.0) - floors[a].map_or(0, |f| f.0) <= STEP) {
        let better = |&a: &usize, &b: &usize| {
            space_area(a)
                .total_cmp(&space_area(b))
                .then(candidates[a].n_elements.cmp(&candidates[b].n_elements))
                .then(b.cmp(&a))
        };
        let Some(first) = group.iter().copied().max_by(|a, b| better(a, b)) else { continue };
        for &k in group {
            fates[k] = if k == first { Fate::Mapped(mapped.len()) } else { Fate::Joined(mapped.len()) };
        }
        if let Ok((z, floor)) = floors[first] {
            mapped.push(MapStorey { z, floor, named_after: Some(first) });
        }
    }
    (mapped, fates)
}

/// Height and kind of a storey's floor, or why it has none.
fn floor_of(
    storey: usize,
    candidates: &[Candidate],
    spaces: &[SpaceFloor],
    faces: &FloorTriangles,
    bare: bool,
) -> Result<(i32, FloorKind), &'static str> {
    let own_heights = |near: Option<i32>| {
        let mut heights: Vec<(i32, f64)> = spaces
            .iter()
            .filter(|s| s.storey == Some(storey) && near.is_none_or(|z| (s.z - z).abs() <= REACH))
            .map(|s| (s.z, s.area_m2))
            .collect();
        heights.sort_by_key(|h| h.0);
        heights
    };
    let placement = candidates[storey].placement_z;
    let lowest = candidates[storey].bodies.iter().map(|b| b[0]).min();
    let guess = match placement {
        // A placement far from all its spaces is wrong.
        Some(z) if own_heights(None).is_empty() || !own_heights(Some(z)).is_empty() => z,
        _ => {
            let guesses = [weighted_height(&own_heights(None)), placement, candidates[storey].own_floor, lowest];
            guesses.into_iter().flatten().next().ok_or("it has no placement and contains nothing")?
        }
    };
    if bare {
        // Where nothing stands at the placement, the lowest body does.
        let stands_here = candidates[storey].bodies.iter().any(|b| b[0] < guess + BODY_HEIGHT && guess + STEP < b[1]);
        let z = if stands_here { Some(guess) } else { lowest };
        return z.map(|z| (z, FloorKind::AssumedFromEnclosure)).ok_or("it contains nothing");
    }
    let near: Vec<&SpaceFloor> = spaces.iter().filter(|s| (s.z - guess).abs() <= REACH).collect();
    let rooms = union_of(near.iter().map(|s| &s.polygon));
    let sampling = Sampling::new(faces, guess, &rooms);
    let level = sampling.as_ref().and_then(|s| s.level(guess));
    if rooms.is_empty() {
        return match level {
            Some(level) if level.area_m2 >= LEAST_FLOOR_M2 => Ok((level.z, FloorKind::Built)),
            _ => Err("there is no floor within 0.5 m of it and no space"),
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
fn without_storeys(spaces: &[SpaceFloor], faces: &FloorTriangles, lowest_body: Option<i32>) -> Vec<MapStorey> {
    let mut levels: Vec<(i32, f64)> = Vec::new();
    let mut rest: Vec<(i32, f64)> = if faces.is_empty() {
        spaces.iter().map(|s| (s.z, s.area_m2)).collect()
    } else {
        faces.iter().map(|t| ((t[0][2] + t[1][2] + t[2][2]) / 3, plan_area_m2(t))).collect()
    };
    rest.sort_by_key(|r| r.0);
    while let Some(z) = dominant_by_area(&rest) {
        let area = rest.iter().filter(|r| (r.0 - z).abs() <= STEP).map(|r| r.1).sum::<f64>();
        if area < LEAST_FLOOR_M2 || levels.first().is_some_and(|l| area < l.1 / 4.0) {
            break;
        }
        levels.push((z, area));
        rest.retain(|r| (r.0 - z).abs() >= LEAST_STOREY_HEIGHT);
    }
    let kind = if faces.is_empty() { FloorKind::AssumedFromSpaces } else { FloorKind::Built };
    let mut mapped: Vec<MapStorey> =
        levels.iter().map(|l| MapStorey { z: l.0, floor: kind, named_after: None }).collect();
    mapped.sort_by_key(|m| m.z);
    if mapped.is_empty() && faces.is_empty() && spaces.is_empty() {
        let floor = FloorKind::AssumedFromEnclosure;
        mapped.extend(lowest_body.map(|z| MapStorey { z, floor, named_after: None }));
    }
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

    fn storey(z: i32, n_elements: usize) -> Candidate {
        Candidate { placement_z: Some(z), n_elements, bodies: vec![[z, z + 25_000]], own_floor: None }
    }

    fn space(side: i32, z: i32, storey: usize) -> SpaceFloor {
        let polygon = union(&[vec![[0, 0], [side, 0], [side, side], [0, side]]], FillRule::NonZero);
        SpaceFloor { area_m2: polygon.area_m2(), polygon, z, storey: Some(storey) }
    }

    #[test]
    fn the_floor_is_the_slabs_top_and_not_the_placement() {
        let (mapped, fates) = map_storeys(&[storey(0, 5)], &[space(80_000, 0, 0)], &square(0, 100_000, 2_000), None);
        assert_eq!(mapped, [MapStorey { z: 2_000, floor: FloorKind::Built, named_after: Some(0) }]);
        assert_eq!(fates, [Fate::Mapped(0)]);
    }

    #[test]
    fn storeys_whose_floors_coincide_are_one_named_after_the_spaces() {
        let candidates = [storey(-2_000, 50), storey(0, 5), storey(28_000, 1)];
        let (mapped, fates) = map_storeys(&candidates, &[space(80_000, 0, 1)], &square(0, 100_000, 0), None);
        assert_eq!(mapped.len(), 1);
        assert_eq!(fates[..2], [Fate::Joined(0), Fate::Mapped(0)]);
        assert!(matches!(fates[2], Fate::NotMapped(_)));
    }

    #[test]
    fn a_storey_without_slabs_is_assumed_from_its_spaces() {
        let (mapped, _) = map_storeys(&[storey(0, 5)], &[space(80_000, 300, 0)], &square(0, 10_000, 0), None);
        assert_eq!(mapped, [MapStorey { z: 300, floor: FloorKind::AssumedFromSpaces, named_after: Some(0) }]);
    }

    #[test]
    fn without_floor_or_spaces_anywhere_storeys_that_hold_something_are_assumed() {
        let empty = Candidate { placement_z: Some(30_000), n_elements: 0, bodies: vec![], own_floor: None };
        let (mapped, fates) = map_storeys(&[storey(0, 5), empty], &[], &Vec::new(), Some(0));
        assert_eq!(mapped[0].floor, FloorKind::AssumedFromEnclosure);
        assert_eq!(fates[1], Fate::NotMapped("it contains nothing"));
    }

    #[test]
    fn bodies_far_above_an_undefined_storey_are_mapped_where_they_stand() {
        let undefined =
            Candidate { placement_z: Some(0), n_elements: 1, bodies: vec![[29_000, 31_000]], own_floor: None };
        let (mapped, _) = map_storeys(&[undefined], &[], &Vec::new(), Some(29_000));
        assert_eq!(mapped[0].z, 29_000);
    }

    #[test]
    fn a_placement_far_from_its_spaces_is_not_believed() {
        let mut faces = square(0, 100_000, 0);
        faces.extend(square(0, 100_000, 30_000));
        let (mapped, _) = map_storeys(&[storey(0, 5)], &[space(80_000, 30_000, 0)], &faces, None);
        assert_eq!(mapped[0].z, 30_000);
    }

    #[test]
    fn a_storey_without_a_placement_is_found_by_its_floor() {
        let lost = Candidate { placement_z: None, n_elements: 9, bodies: vec![[-3_000, 0]], own_floor: Some(1_000) };
        let (mapped, _) = map_storeys(&[lost], &[], &square(0, 100_000, 1_000), Some(-3_000));
        assert_eq!(mapped, [MapStorey { z: 1_000, floor: FloorKind::Built, named_after: Some(0) }]);
    }

    #[test]
    fn a_file_without_storeys_has_the_levels_of_its_floors() {
        let mut faces = square(0, 100_000, 0);
        faces.extend(square(0, 90_000, 30_000));
        faces.extend(square(0, 20_000, 10_000));
        let (mapped, _) = map_storeys(&[], &[], &faces, None);
        assert_eq!(mapped.iter().map(|m| m.z).collect::<Vec<_>>(), [0, 30_000]);
    }
}
