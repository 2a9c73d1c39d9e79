//! Findings of single checks, and issues made of them: elements grouped by cause, with their effect in words and figures.

use crate::causes::{IssueCode, IssueKind};
use crate::document::{AffectedRoom, Effect, Issue, IssueElement, Place};
use crate::regions::Join;
use answers::{ElementRef, RoomRef};
use diagnostics::counted;
use export::rounded;
use frames::metres;
use messages::{NONE, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Elements of an issue that are listed; the rest is counted.
const MAX_LISTED: usize = 500;

/// What one check found in one place.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) code: IssueCode,
    pub(crate) kind: IssueKind,
    pub(crate) subject: Subject,
    /// What is wrong with it; empty where the code says all.
    pub(crate) text: String,
    /// Where, if it is not where the subject is.
    pub(crate) place: Option<Place>,
    /// Doors of the site that are closed or misplaced for it.
    pub(crate) doors: Vec<u32>,
    /// Spaces of the site that are wrong on the maps for it.
    pub(crate) rooms: Vec<u32>,
    /// Area that is wrong on the maps, rooms that cannot be reached not counted; 0 for none.
    pub(crate) area_m2: f64,
    /// What would be joined without it.
    pub(crate) joins: Vec<Join>,
}

/// What an issue is about.
#[derive(Debug, Clone)]
pub(crate) enum Subject {
    Element(usize),
    Space(usize),
    /// Of the files.
    Storey(usize),
    MapStorey(u32),
    /// Something with these: GlobalId, entity, name.
    Named([String; 3]),
}

impl Found {
    pub(crate) fn of(code: IssueCode, subject: Subject, text: impl Into<String>) -> Self {
        let (kind, text) = (code.kind(), text.into());
        let (doors, rooms, joins) = (Vec::new(), Vec::new(), Vec::new());
        Self { code, kind, subject, text, place: None, doors, rooms, area_m2: 0.0, joins }
    }

    /// The same where maps are right all the same.
    pub(crate) fn without_effect_on_maps(self) -> Self {
        Self { kind: IssueKind::Data, ..self }
    }
}

/// Elements with one cause, and what is out of reach for them.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) code: IssueCode,
    pub(crate) kind: IssueKind,
    pub(crate) found: Vec<Found>,
    /// Spaces that are out of reach for it.
    pub(crate) unreachable: BTreeSet<u32>,
    pub(crate) unreachable_m2: f64,
}

/// By code and kind, in the order of codes.
pub(crate) fn grouped(all: Vec<Found>) -> Vec<Group> {
    let mut groups: BTreeMap<(IssueKind, IssueCode), Vec<Found>> = BTreeMap::new();
    for found in all {
        groups.entry((found.kind, found.code)).or_default().push(found);
    }
    let group = |((kind, code), found)| {
        let (unreachable, unreachable_m2) = (BTreeSet::new(), 0.0);
        Group { code, kind, found, unreachable, unreachable_m2 }
    };
    groups.into_iter().map(group).collect()
}

impl Group {
    /// What decides which is worse: whether maps change, then the area and the rooms, the doors, the number.
    pub(crate) fn weight(&self) -> (std::cmp::Reverse<IssueKind>, f64, usize) {
        let area_m2 = self.unreachable_m2 + self.found.iter().map(|found| found.area_m2).sum::<f64>();
        let doors: usize = self.found.iter().map(|found| found.doors.len()).sum();
        (std::cmp::Reverse(self.kind), area_m2 + 5.0 * self.unreachable.len() as f64 + doors as f64, self.found.len())
    }

    /// The issue for people and programs.
    pub(crate) fn issue(&self, site: &Site<'_>) -> Issue {
        let effect = self.effect(site);
        let n = self.found.len();
        let [one, many] = self.code.phrases();
        let what = format!("{n} {}", if n == 1 { one } else { many });
        let title = if effect.text.is_empty() { what } else { format!("{what}: {}", effect.text) };
        Issue {
            code: self.code.name(),
            kind: self.kind.name(),
            title,
            cause: self.code.why(),
            advice: self.code.advice(),
            effect,
            n,
            elements: self.found.iter().take(MAX_LISTED).map(|found| found.element(site)).collect(),
        }
    }

    fn effect(&self, site: &Site<'_>) -> Effect {
        let own_m2: f64 = self.found.iter().map(|found| found.area_m2).sum();
        let doors: BTreeSet<u32> = self.found.iter().flat_map(|found| found.doors.iter().copied()).collect();
        let mut rooms: BTreeSet<u32> = self.found.iter().flat_map(|found| found.rooms.iter().copied()).collect();
        let mut words = Vec::new();
        if !self.unreachable.is_empty() {
            let n = counted(self.unreachable.len(), "room");
            words.push(format!("{n} unreachable, {:.1} m2", self.unreachable_m2));
        } else if self.unreachable_m2 >= 0.05 {
            words.push(format!("{:.1} m2 of floor unreachable", self.unreachable_m2));
        }
        if own_m2 >= 0.005 {
            words.push(format!("{own_m2:.1} m2 {}", self.area_words()));
        }
        let is_of_doors = self.code.name().starts_with("door");
        if !doors.is_empty() && !is_of_doors {
            words.push(counted(doors.len(), "door"));
        }
        let is_of_rooms = self.code.name().starts_with("room");
        if self.unreachable.is_empty() && !rooms.is_empty() && !is_of_rooms {
            words.push(format!("at {}", counted(rooms.len(), "room")));
        }
        rooms.extend(&self.unreachable);
        let room = |&space: &u32| {
            let RoomRef { global_id, name } = RoomRef::of(site, space as usize);
            let area_m2 = rounded(site.spaces[space as usize].area_m2);
            AffectedRoom { global_id, name, area_m2, unreachable: self.unreachable.contains(&space) }
        };
        let area_m2 = own_m2 + self.unreachable_m2;
        Effect {
            text: words.join("; "),
            area_m2: (area_m2 >= 0.005).then(|| rounded(area_m2)),
            doors: doors.iter().map(|&door| ElementRef::of(site, site.doors[door as usize].element as usize)).collect(),
            rooms: rooms.iter().map(room).collect(),
        }
    }

    /// What is the matter with the area of an issue.
    fn area_words(&self) -> &'static str {
        match self.code {
            IssueCode::FloorAssumed | IssueCode::StoreyFloorAssumed => "assumed",
            IssueCode::FloorGap | IssueCode::RoomWithoutFloor => "without floor",
            IssueCode::RoomsOverlap => "in two rooms",
            IssueCode::FloorWithoutRoom => "without a room",
            IssueCode::RoomNotMapped | IssueCode::StoreyNotMapped => "on no map",
            IssueCode::GeometryFailed => "drawn as boxes",
            IssueCode::RoomWithoutDoor | IssueCode::RoomUnreachable | IssueCode::RoomBehind => "out of reach",
            _ => "affected",
        }
    }
}

impl Found {
    fn element(&self, site: &Site<'_>) -> IssueElement {
        let some = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
        let storey_name = |storey: u32| {
            let record = site.storeys.get(storey as usize)?;
            some(site.text(record.name)).or_else(|| some(site.text(record.global_id)))
        };
        let map_storey_name = |map_storey: u32| some(site.text(site.map_storeys.get(map_storey as usize)?.name));
        let place = self.place.clone().or_else(|| self.subject.place(site));
        let on_map = || map_storey_name(place.as_ref()?.storey?);
        let [global_id, ifc_type, name, storey] = match &self.subject {
            Subject::Element(k) => {
                let record = &site.elements[*k];
                let texts =
                    [record.global_id, record.ifc_type, record.name].map(|text| Some(site.text(text).to_owned()));
                let [id, ifc_type, name] = texts;
                [id, ifc_type, name, storey_name(record.storey).or_else(on_map)]
            }
            Subject::Space(k) => {
                let record = &site.spaces[*k];
                let name = export::space_name(site, *k as u32);
                let id = site.text(record.global_id).to_owned();
                [Some(id), Some("IfcSpace".to_owned()), name, storey_name(record.storey).or_else(on_map)]
            }
            Subject::Storey(k) => {
                let record = &site.storeys[*k];
                let [id, name] = [record.global_id, record.name].map(|text| Some(site.text(text).to_owned()));
                [id, Some("IfcBuildingStorey".to_owned()), name, None]
            }
            Subject::MapStorey(k) => {
                let record = &site.map_storeys[*k as usize];
                let [id, name] = [record.global_id, record.name].map(|text| Some(site.text(text).to_owned()));
                [id, Some("IfcBuildingStorey".to_owned()), name, None]
            }
            Subject::Named([id, ifc_type, name]) => {
                [Some(id.clone()), Some(ifc_type.clone()), Some(name.clone()), None]
            }
        };
        IssueElement {
            global_id: global_id.unwrap_or_default(),
            ifc_type: ifc_type.unwrap_or_default(),
            name: name.filter(|name| !name.is_empty()),
            storey,
            text: self.text.clone(),
            place,
        }
    }
}

impl Subject {
    /// Where it is.
    fn place(&self, site: &Site<'_>) -> Option<Place> {
        match self {
            Self::Element(k) => place_of_element(site, *k),
            Self::Space(k) => place_of_space(site, *k),
            Self::MapStorey(k) => {
                let record = &site.map_storeys[*k as usize];
                let [x0, y0, x1, y1] = record.bounds_tenths.map(|c| rounded(metres(c)));
                let z_m = rounded(metres(record.floor_z_tenths));
                Some(Place { storey: Some(*k), bounds_m: [[x0, y0], [x1, y1]], z_m })
            }
            Self::Storey(k) => {
                let map_storey = site.storeys[*k].map_storey;
                (map_storey != NONE).then(|| Self::MapStorey(map_storey).place(site)).flatten()
            }
            Self::Named(_) => None,
        }
    }
}

/// Where an element with a body is.
pub(crate) fn place_of_element(site: &Site<'_>, element: usize) -> Option<Place> {
    let record = &site.elements[element];
    if record.n_parts == 0 {
        return None;
    }
    let [low, high] = [record.min_tenths, record.max_tenths];
    let bounds_m = [low, high].map(|[x, y, _]| [x, y].map(|c| rounded(metres(c))));
    let own = site.doors.get(record.door as usize).map(|door| door.map_storey).filter(|storey| *storey != NONE);
    let storey = own.or_else(|| storey_at(site, low[2], high[2]));
    Some(Place { storey, bounds_m, z_m: rounded(metres(low[2])) })
}

/// Where a room with a floor is.
pub(crate) fn place_of_space(site: &Site<'_>, space: usize) -> Option<Place> {
    let record = &site.spaces[space];
    let bounds = site.floor_polygon(record).bounds()?;
    let bounds_m = [bounds.min, bounds.max].map(|p| p.map(|c| rounded(metres(c))));
    let z_m = rounded(metres(record.floor_z_tenths));
    Some(Place { storey: (record.map_storey != NONE).then_some(record.map_storey), bounds_m, z_m })
}

/// The map storey that shows heights from `low` to `high` first: the lowest whose first metre above the floor they meet, else the
/// highest below them.
pub(crate) fn storey_at(site: &Site<'_>, low: i32, high: i32) -> Option<u32> {
    let meets = |z: i32| low < z + 10_000 && z + 500 < high;
    let shown = site.levels().filter(|(_, storey)| meets(storey.floor_z_tenths));
    let shown = shown.min_by_key(|(_, storey)| storey.floor_z_tenths);
    let below = || site.levels().filter(|(_, s)| s.floor_z_tenths <= low + 500).max_by_key(|(_, s)| s.floor_z_tenths);
    shown.or_else(below).map(|(k, _)| k as u32)
}
