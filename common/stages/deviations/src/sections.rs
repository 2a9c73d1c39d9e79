//! Elements of a storey sectioned at lidar height, with a spatial index.

use crate::thresholds::PLANE_M;

use frames::TENTHS_PER_M;
use geometry::{Footprint, MultiPolygon, Slab, footprint};
use grid::Class;
use messages::{ElementRecord, NONE, RobotProfile, ScheduleState, Site, element_flags};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// An element of the storey.
pub(crate) struct ElementSection {
    pub(crate) element: u32,
    /// The section in the lidar's plane.
    pub(crate) section: Footprint,
    /// Footprint within a margin around that plane.
    around: Footprint,
    /// True if it is planned to be there.
    pub(crate) stands: bool,
    pub(crate) kind: LidarKind,
}

/// How a lidar sees an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LidarKind {
    /// Visible and fixed.
    Solid,
    /// Visible but movable.
    Movable,
    Door,
    Glass,
    /// A box instead of its shape.
    StandIn,
}

/// A straight piece of a section's border; the solid lies on its left.
pub(crate) struct Segment {
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    pub(crate) cut: u32,
}

/// The sections of a storey with a spatial index. Points are metres in `map`.
pub(crate) struct Sections {
    pub(crate) cuts: Vec<ElementSection>,
    section: Index,
    around: Index,
}

/// Spatial index of borders and areas, by tile.
struct Index {
    segments: Vec<Segment>,
    /// By tile.
    borders: BTreeMap<[i32; 2], Vec<u32>>,
    areas: BTreeMap<[i32; 2], Vec<u32>>,
}

const TILE_M: f64 = 0.5;
const AREA_TILE_M: f64 = 2.0;

impl Sections {
    /// Cuts all elements that reach into the robot's slab or near to the lidar's plane.
    pub(crate) fn of(
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        robot: &RobotProfile,
        map_storey: usize,
    ) -> Self {
        let floor_z = site.map_storeys[map_storey].floor_z_tenths;
        let height = |m: f64| floor_z.saturating_add(tenths(m));
        let lidar_z = height(robot.lidar_height_m);
        let plane = Slab { lo: lidar_z, hi: lidar_z + 2 };
        let near = Slab { lo: lidar_z - tenths(PLANE_M), hi: lidar_z + tenths(PLANE_M) };
        let [lo, hi] = robot.slab_m().map(height);
        let body = Slab { lo, hi: hi.max(lo + 1) };
        let reaches = |e: &ElementRecord| {
            let meets = |slab: Slab| slab.meets(e.min_tenths[2], e.max_tenths[2]);
            e.n_parts > 0 && (meets(body) || meets(near))
        };
        let of_storey = site.elements.par_iter().enumerate().filter(|(_, e)| reaches(e));
        let cuts: Vec<ElementSection> = of_storey
            .map(|(k, e)| ElementSection {
                element: k as u32,
                section: footprint(site.element_meshes(e), plane),
                around: footprint(site.element_meshes(e), near),
                stands: schedule_state.planned(k).is_obstacle(),
                kind: kind(site, k),
            })
            .collect();
        let section = Index::of(cuts.iter().map(|c| &c.section));
        let around = Index::of(cuts.iter().map(|c| &c.around));
        Self { cuts, section, around }
    }

    /// Elements whose section holds a place.
    pub(crate) fn at(&self, at: [f64; 2]) -> impl Iterator<Item = u32> {
        self.section.areas_at(at).filter(move |cut| contains(&self.cuts[*cut as usize].section.area, at))
    }

    /// True if an opaque element that stands, other than this one, lies there.
    pub(crate) fn covered(&self, at: [f64; 2], own: u32) -> bool {
        self.at(at).any(|cut| cut != own && self.hides(cut))
    }

    /// True if a border of such an element, which is not this one's own, is at most this far away, or it lies there.
    pub(crate) fn is_others(&self, at: [f64; 2], within_m: f64, is_own: impl Fn(u32) -> bool) -> bool {
        let is_other = |cut: u32| !is_own(cut) && self.hides(cut);
        let near = |s: &&Segment| is_other(s.cut) && distance(s, at) <= within_m;
        self.section.segments_near(at, within_m).any(|s| near(&s)) || self.at(at).any(is_other)
    }

    /// True if a door or a window is at most this far from a place.
    pub(crate) fn is_opening(&self, at: [f64; 2], within_m: f64) -> bool {
        let fills = |cut: u32| matches!(self.cuts[cut as usize].kind, LidarKind::Glass | LidarKind::Door);
        let near = |s: &&Segment| fills(s.cut) && distance(s, at) <= within_m;
        self.around.segments_near(at, within_m).any(|s| near(&s)) || self.at(at).any(fills)
    }

    /// True if any element, in any state, is at most this far from a point near the lidar's plane.
    pub(crate) fn explains(&self, at: [f64; 2], within_m: f64) -> bool {
        self.around.segments_near(at, within_m).any(|s| distance(s, at) <= within_m)
            || self.around.areas_at(at).any(|cut| contains(&self.cuts[cut as usize].around.area, at))
    }

    /// The same of one element.
    pub(crate) fn explained_by(&self, cut: u32, at: [f64; 2], within_m: f64) -> bool {
        let mut near = self.around.segments_near(at, within_m).filter(|s| s.cut == cut);
        near.any(|s| distance(s, at) <= within_m) || contains(&self.cuts[cut as usize].around.area, at)
    }

    /// Thickness of an element behind a point of its border along an inward unit direction; at most `most_m`.
    pub(crate) fn thickness(&self, at: [f64; 2], into: [f64; 2], own: u32, most_m: f64) -> f64 {
        let crossings = self.crossings(at, into, most_m).filter(|(cut, t)| *cut == own && *t > 1e-4);
        crossings.map(|(_, t)| t).fold(most_m, f64::min)
    }

    /// Where a line from a place along a unit direction crosses borders of elements: in which depth, up to `most_m`.
    /// Some of them more than once.
    pub(crate) fn crossings(&self, at: [f64; 2], into: [f64; 2], most_m: f64) -> impl Iterator<Item = (u32, f64)> {
        let middle = [0, 1].map(|k| at[k] + into[k] * most_m / 2.0);
        self.section.segments_near(middle, most_m / 2.0).filter_map(move |s| Some((s.cut, crossing(s, at, into)?)))
    }

    fn hides(&self, cut: u32) -> bool {
        let other = &self.cuts[cut as usize];
        other.stands && !matches!(other.kind, LidarKind::Glass | LidarKind::Door)
    }
}

impl ElementSection {
    /// True if it may be a part of a wall that a lidar sees as one.
    pub(crate) fn can_be_leaf(&self) -> bool {
        self.kind == LidarKind::Solid && !self.section.area.0.is_empty()
    }
}

impl Index {
    fn of<'a>(sections: impl Iterator<Item = &'a Footprint>) -> Self {
        let mut index = Self { segments: Vec::new(), borders: BTreeMap::new(), areas: BTreeMap::new() };
        for (section, cut) in sections.zip(0..) {
            for ring in section.area.rings() {
                let next = ring.iter().cycle().skip(1);
                ring.iter().zip(next).for_each(|(a, b)| index.add(cut, metres(*a), metres(*b)));
            }
            section.lines.iter().for_each(|[a, b]| index.add(cut, metres(*a), metres(*b)));
            if let Some(bounds) = section.area.bounds() {
                let (min, max) = (metres(bounds.min), metres(bounds.max));
                for tile in tiles(min, max, AREA_TILE_M) {
                    index.areas.entry(tile).or_default().push(cut);
                }
            }
        }
        index
    }

    fn add(&mut self, cut: u32, from: [f64; 2], to: [f64; 2]) {
        let number = self.segments.len() as u32;
        let (min, max) = ([0, 1].map(|k| from[k].min(to[k])), [0, 1].map(|k| from[k].max(to[k])));
        let segment = Segment { from, to, cut };
        for tile in tiles(min, max, TILE_M) {
            let middle = tile.map(|t| (f64::from(t) + 0.5) * TILE_M);
            // A long slanted piece is not in most tiles of its box.
            if distance(&segment, middle) <= TILE_M {
                self.borders.entry(tile).or_default().push(number);
            }
        }
        self.segments.push(segment);
    }

    /// Pieces of borders in the tiles around a place; some more than once.
    fn segments_near(&self, at: [f64; 2], within_m: f64) -> impl Iterator<Item = &Segment> {
        let tiles = tiles(at.map(|c| c - within_m), at.map(|c| c + within_m), TILE_M);
        tiles.filter_map(|tile| self.borders.get(&tile)).flatten().map(|s| &self.segments[*s as usize])
    }

    fn areas_at(&self, at: [f64; 2]) -> impl Iterator<Item = u32> {
        let tile = at.map(|c| (c / AREA_TILE_M).floor() as i32);
        self.areas.get(&tile).into_iter().flatten().copied()
    }
}

/// How a lidar sees an element of the site.
fn kind(site: &Site<'_>, element: usize) -> LidarKind {
    let record = &site.elements[element];
    let is_door = |index: u32| index != NONE && site.elements[index as usize].class() == Class::Door;
    match record.class() {
        Class::Door => LidarKind::Door,
        _ if is_door(record.whole) => LidarKind::Door,
        Class::Window => LidarKind::Glass,
        _ if record.has(element_flags::GLASS) => LidarKind::Glass,
        _ if record.has(element_flags::BOUNDING_BOX) => LidarKind::StandIn,
        Class::Furniture => LidarKind::Movable,
        _ => LidarKind::Solid,
    }
}

fn tenths(metres: f64) -> i32 {
    frames::tenths(metres).unwrap_or(i32::MAX / 4)
}

pub(crate) fn metres(p: [i32; 2]) -> [f64; 2] {
    p.map(frames::metres)
}

fn contains(area: &MultiPolygon, at: [f64; 2]) -> bool {
    area.contains(at.map(|c| c * f64::from(TENTHS_PER_M)))
}

fn tiles(min: [f64; 2], max: [f64; 2], side_m: f64) -> impl Iterator<Item = [i32; 2]> {
    let [lo, hi] = [min, max].map(|p| p.map(|c| (c / side_m).floor() as i32));
    (lo[1]..=hi[1]).flat_map(move |y| (lo[0]..=hi[0]).map(move |x| [x, y]))
}

/// From a point to a straight piece.
fn distance(s: &Segment, p: [f64; 2]) -> f64 {
    let d = [s.to[0] - s.from[0], s.to[1] - s.from[1]];
    let to = [p[0] - s.from[0], p[1] - s.from[1]];
    let squared = d[0] * d[0] + d[1] * d[1];
    let part = if squared > 0.0 { ((to[0] * d[0] + to[1] * d[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(to[0] - part * d[0], to[1] - part * d[1])
}

/// Distance from a point along a unit direction to a segment.
fn crossing(s: &Segment, from: [f64; 2], direction: [f64; 2]) -> Option<f64> {
    let d = [s.to[0] - s.from[0], s.to[1] - s.from[1]];
    let cross = direction[0] * d[1] - direction[1] * d[0];
    let to = [s.from[0] - from[0], s.from[1] - from[1]];
    let along = (to[0] * d[1] - to[1] * d[0]) / cross;
    let part = (to[0] * direction[1] - to[1] * direction[0]) / cross;
    (cross.abs() > 1e-12 && (0.0..=1.0).contains(&part)).then_some(along)
}
