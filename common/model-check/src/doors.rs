//! Doors: those that no robot can pass and why, those that stand beside their openings, and openings that miss their walls.

use crate::causes::IssueCode;
use crate::evidence::{Found, Subject};
use crate::regions::{Join, Regions, box_metres};
use answers::Situation;
use geometry::{OrientedBox, Point};
use messages::{
    BoxRecord, ClearWidth, DoorPassage, DoorPassageRecord, DoorRecord, NONE, OpeningRecord, Site, element_flags,
    space_flags,
};

/// A doorway that begins higher above its floor, in tenths of a millimetre, has no sill that people build.
const MAX_SILL: i32 = 2_500;
/// A door that stands with less of its width in its opening stands beside it.
const MIN_SHARE_IN_OPENING: f64 = 0.5;
/// A door whose middle lies farther from that of its opening, through the wall, stands beside it: 0.6 m.
const MAX_OFF_THROUGH_WALL: f64 = 6_000.0;
/// An opening that is farther from its wall, along it or in height, misses it: 0.05 m. One that is nearer may have cut the end off.
const OFF_WALL: f64 = 500.0;

/// What is found of all doors and openings.
pub(crate) fn doors(situation: &Situation<'_>, storeys: &[Regions]) -> Vec<Found> {
    let site = situation.site;
    let mut all = closed_doors(situation, storeys);
    for k in 0..site.doors.len() {
        all.extend(beside_its_opening(site, k));
        all.extend(without_room(situation, k));
    }
    for opening in site.openings {
        all.extend(missed_wall(situation, storeys, opening));
    }
    all
}

/// The doors that this robot cannot pass.
fn closed_doors(situation: &Situation<'_>, storeys: &[Regions]) -> Vec<Found> {
    let Situation { site, index, .. } = *situation;
    let robot = &index.head.robot;
    let passages = export::each_door(site, index.doors);
    let mut all = Vec::new();
    for passage in &passages {
        let door = &site.doors[passage.door as usize];
        let Some((code, reason)) = cause_of(situation, passage) else {
            all.extend(one_sided(situation, passage));
            continue;
        };
        let misses = site.openings.get(door.opening as usize).and_then(|opening| how_it_misses(site, opening));
        let words = match misses.filter(|_| code == IssueCode::OpeningMissesWall) {
            Some(how) => format!("its opening {}: {how}", site.text(site.openings[door.opening as usize].global_id)),
            None => export::reason_text(site, robot, passage, reason),
        };
        let assumed = code == IssueCode::DoorTooNarrow && door.clear_width_from.get() == ClearWidth::Assumed;
        let text = if assumed {
            format!("{words}; it is {:.2} m wide overall, 0.10 m less is assumed to be clear", door.overall_width_m)
        } else {
            words
        };
        let mut found = Found::of(code, Subject::Element(door.element as usize), text);
        found.doors.push(passage.door);
        found.joins.extend(joined_by(situation, storeys, passage));
        all.push(found);
    }
    all
}

/// The cause that matters most, and the reason of the map for it; `None` if the door is open.
fn cause_of(situation: &Situation<'_>, passage: &DoorPassageRecord) -> Option<(IssueCode, DoorPassage)> {
    let site = situation.site;
    let reasons: Vec<DoorPassage> = passage.closed_by().collect();
    let door = &site.doors[passage.door as usize];
    let misses = !reasons.is_empty() && misses_wall(site, door.opening);
    let code = |reason: &DoorPassage| {
        let code = match reason {
            DoorPassage::InProgress => IssueCode::DoorInWork,
            // Whatever lies where the opening is: the door is not there.
            _ if misses => IssueCode::OpeningMissesWall,
            DoorPassage::NoOpening => IssueCode::DoorWithoutOpening,
            DoorPassage::WallUncut => IssueCode::WallNotCut,
            DoorPassage::NoFloor => IssueCode::DoorWithoutFloor,
            DoorPassage::Obstructed if is_lift(site, passage.obstacle) => IssueCode::DoorOfLift,
            DoorPassage::Obstructed => IssueCode::DoorObstructed,
            DoorPassage::Threshold if rise(site, passage) > MAX_SILL => IssueCode::DoorAboveFloor,
            DoorPassage::Threshold => IssueCode::DoorWithSill,
            DoorPassage::CannotOpen => IssueCode::DoorNotOpened,
            DoorPassage::TooNarrow => IssueCode::DoorTooNarrow,
            DoorPassage::ClosedByResolution => IssueCode::DoorNeedsResolution,
            DoorPassage::Passable | DoorPassage::Absent => return None,
        };
        Some((code, *reason))
    };
    let found: Vec<_> = reasons.iter().filter_map(code).collect();
    let order = |code: IssueCode| match code {
        IssueCode::DoorInWork => 0,
        IssueCode::OpeningMissesWall => 1,
        IssueCode::DoorWithoutOpening => 2,
        IssueCode::WallNotCut => 3,
        IssueCode::DoorAboveFloor => 4,
        IssueCode::DoorWithoutFloor => 5,
        IssueCode::DoorObstructed => 6,
        _ => 7,
    };
    found.into_iter().min_by_key(|(code, _)| order(*code))
}

fn is_lift(site: &Site<'_>, obstacle: u32) -> bool {
    site.elements.get(obstacle as usize).is_some_and(|element| element.has(element_flags::VERTICAL))
}

/// How far its opening begins above the floor of its storey.
fn rise(site: &Site<'_>, passage: &DoorPassageRecord) -> i32 {
    let opening = site.openings.get(site.doors[passage.door as usize].opening as usize);
    let floor = site.map_storeys.get(passage.map_storey as usize);
    opening.zip(floor).map_or(0, |(opening, floor)| opening.bottom_z_tenths - floor.floor_z_tenths)
}

/// The parts of floor on the two sides of a door.
fn joined_by(situation: &Situation<'_>, storeys: &[Regions], passage: &DoorPassageRecord) -> Option<Join> {
    let site = situation.site;
    let grid = situation.grids.heads().position(|head| head.map_storey == passage.map_storey)?;
    let door = &site.doors[passage.door as usize];
    // An opening elsewhere leads nowhere: what counts is where the door stands.
    let way = if misses_wall(site, door.opening) { own_way(site, door)? } else { passage.way };
    let mut parts = storeys[grid].beside(&way);
    parts.sort_unstable();
    parts.dedup();
    (parts.len() > 1).then_some(Join { grid, parts })
}

/// The plan of a door's own body, along its width.
fn own_way(site: &Site<'_>, door: &DoorRecord) -> Option<BoxRecord> {
    let element = &site.elements[door.element as usize];
    let points: Vec<Point> =
        site.element_meshes(element).flat_map(|mesh| mesh.vertices.iter().map(|v| [v[0], v[1]])).collect();
    let body = OrientedBox::smallest_around(&points)?;
    let is_along = body.half[0] >= body.half[1];
    let [axis, half] = if is_along { [body.axis, body.half] } else { [body.across(), [body.half[1], body.half[0]]] };
    Some(BoxRecord { centre: body.centre, axis, half })
}

/// A door between two rooms that has floor on one side alone.
fn one_sided(situation: &Situation<'_>, passage: &DoorPassageRecord) -> Option<Found> {
    let site = situation.site;
    let door = &site.doors[passage.door as usize];
    let is_inner = door.spaces.iter().all(|space| {
        site.spaces.get(*space as usize).is_some_and(|s| !s.has(space_flags::EXTERNAL) && !s.has(space_flags::SHAFT))
    });
    let is_known = passage.passage == DoorPassage::Passable && passage.sides_with_floor < 2;
    // Of a room that has no floor at all, the room is told.
    let has_floor = |space: &u32| {
        let why = situation.mission_plan.spaces[*space as usize].why;
        why != messages::NoWaypoint::NoFloor && why != messages::NoWaypoint::NotMapped
    };
    (is_inner && is_known && door.spaces.iter().all(has_floor)).then(|| {
        let text = "there is floor on one side of it only".to_owned();
        let mut found = Found::of(IssueCode::DoorWithoutFloor, Subject::Element(door.element as usize), text);
        found.doors.push(passage.door);
        found
    })
}

/// A door whose body does not stand in the opening that it fills.
fn beside_its_opening(site: &Site<'_>, k: usize) -> Option<Found> {
    let door = &site.doors[k];
    let element = &site.elements[door.element as usize];
    let opening = site.openings.get(door.opening as usize).filter(|opening| opening.plan.half[0] > 0.0)?;
    if element.n_parts == 0 || element.has(element_flags::BOUNDING_BOX) || how_it_misses(site, opening).is_some() {
        return None;
    }
    let plan = opening.plan.to_box();
    let points: Vec<Point> =
        site.element_meshes(element).flat_map(|mesh| mesh.vertices.iter().map(|v| [v[0], v[1]])).collect();
    let body = OrientedBox::around(points, plan.axis)?;
    let off = [body.centre[0] - plan.centre[0], body.centre[1] - plan.centre[1]];
    let across = plan.across();
    let along = (off[0] * plan.axis[0] + off[1] * plan.axis[1]).abs();
    let through = (off[0] * across[0] + off[1] * across[1]).abs();
    let shared = (body.half[0] + plan.half[0] - along).clamp(0.0, 2.0 * body.half[0].min(plan.half[0]));
    let share = shared / (2.0 * body.half[0].min(plan.half[0])).max(1.0);
    // Leaves that stand open reach far out of the wall: what counts is how far beyond its body and its wall the middle is.
    let is_through = through > body.half[1] + plan.half[1] && through > MAX_OFF_THROUGH_WALL;
    let below = opening.bottom_z_tenths.max(element.min_tenths[2]);
    let above = opening.top_z_tenths.min(element.max_tenths[2]);
    let height = (element.max_tenths[2] - element.min_tenths[2]).max(1);
    let is_in_height = f64::from(above - below) >= MIN_SHARE_IN_OPENING * f64::from(height);
    if share >= MIN_SHARE_IN_OPENING && !is_through && is_in_height {
        return None;
    }
    let far = if !is_in_height {
        format!("{:.2} m in height", box_metres(f64::from(element.min_tenths[2] - opening.bottom_z_tenths).abs()))
    } else {
        format!("{:.2} m", box_metres(libm::hypot(along, through)))
    };
    let text = format!("it stands {far} from the opening {} that it fills", site.text(opening.global_id));
    let mut found = Found::of(IssueCode::DoorBesideOpening, Subject::Element(door.element as usize), text);
    found.doors.push(k as u32);
    found.rooms.extend(door.spaces.iter().filter(|space| **space != NONE));
    Some(found)
}

/// A door on a storey with rooms that has none on either side.
fn without_room(situation: &Situation<'_>, k: usize) -> Option<Found> {
    let site = situation.site;
    let door = &site.doors[k];
    let is_room = |space: &messages::SpaceRecord| {
        space.map_storey == door.map_storey && !space.has(space_flags::METADATA_ONLY) && space.n_rings > 0
    };
    let has_rooms = door.map_storey != NONE && site.spaces.iter().any(is_room);
    // Doors of cabinets, facades and roofs are at no height of a floor.
    let passage = situation.index.doors.iter().find(|passage| passage.door as usize == k)?;
    let is_plain = matches!(passage.passage.get(), DoorPassage::Passable) && passage.sides_with_floor > 0;
    (has_rooms && is_plain && door.spaces == [NONE; 2])
        .then(|| Found::of(IssueCode::DoorWithoutRoom, Subject::Element(door.element as usize), ""))
}

/// True if an opening lies outside of the wall that it voids, or only touches it.
fn misses_wall(site: &Site<'_>, opening: u32) -> bool {
    site.openings.get(opening as usize).is_some_and(|opening| how_it_misses(site, opening).is_some())
}

/// How an opening misses its wall; `None` if it does not, or voids no wall.
fn how_it_misses(site: &Site<'_>, opening: &OpeningRecord) -> Option<&'static str> {
    let wall = site.elements.get(opening.host as usize).filter(|host| host.n_parts > 0)?;
    let is_wall = site.is_a(wall, "IfcWall");
    let has_body = opening.bottom_z_tenths < opening.top_z_tenths;
    if !is_wall || !has_body || wall.has(element_flags::BOUNDING_BOX) {
        return None;
    }
    let [bottom, top] = [wall.min_tenths[2], wall.max_tenths[2]];
    let in_height = top.min(opening.top_z_tenths) - bottom.max(opening.bottom_z_tenths);
    if f64::from(in_height) < -OFF_WALL {
        return Some("it lies above or below its wall");
    }
    let points: Vec<Point> =
        site.element_meshes(wall).flat_map(|mesh| mesh.vertices.iter().map(|v| [v[0], v[1]])).collect();
    let smallest = OrientedBox::smallest_around(&points)?;
    let is_thin = smallest.half[0].min(smallest.half[1]) <= 7_500.0;
    match (opening.plan.half[0] > 0.0, opening.is_in_wall()) {
        (false, _) => is_thin.then_some("it lies beside its wall"),
        (true, false) => Some("it only touches its wall"),
        (true, true) => {
            let plan = opening.plan.to_box();
            let wall = OrientedBox::around(points, plan.axis)?;
            let off = [plan.centre[0] - wall.centre[0], plan.centre[1] - wall.centre[1]];
            let along = (off[0] * plan.axis[0] + off[1] * plan.axis[1]).abs();
            (along - wall.half[0] - plan.half[0] > OFF_WALL).then_some("it lies beyond the end of its wall")
        }
    }
}

/// An opening that misses its wall, unless the door that fills it is closed for that: then it is told with the door.
fn missed_wall(situation: &Situation<'_>, storeys: &[Regions], opening: &OpeningRecord) -> Option<Found> {
    let site = situation.site;
    let how = how_it_misses(site, opening)?;
    let filling = site.elements.get(opening.filling as usize);
    let door = filling.map(|filling| filling.door).filter(|door| *door != NONE);
    let passage = |door: u32| export::each_door(site, situation.index.doors).into_iter().find(|p| p.door == door);
    let wall = site.text(site.elements[opening.host as usize].global_id);
    match door {
        Some(door) => {
            let passage = passage(door);
            if passage
                .as_ref()
                .is_some_and(|p| cause_of(situation, p).is_some_and(|(c, _)| c == IssueCode::OpeningMissesWall))
            {
                return None;
            }
            let text = format!("its opening {}: {how} {wall}", site.text(opening.global_id));
            let element = site.doors[door as usize].element as usize;
            let mut found = Found::of(IssueCode::OpeningMissesWall, Subject::Element(element), text);
            found.doors.push(door);
            // The wall is cut where the door stands, or the door stands in the hole of another wall.
            let is_open = passage.as_ref().is_some_and(|p| p.passage == DoorPassage::Passable);
            found.joins.extend(passage.and_then(|p| joined_by(situation, storeys, &p)));
            Some(if is_open { found.without_effect_on_maps() } else { found })
        }
        None => {
            let text = match filling {
                Some(filling) => format!("{how} {wall}; it is filled by {}", site.text(filling.global_id)),
                None => format!("{how} {wall}"),
            };
            let [id, name] =
                [opening.global_id, site.elements[opening.host as usize].name].map(|t| site.text(t).to_owned());
            let subject = Subject::Named([id, "IfcOpeningElement".to_owned(), format!("of wall {name}")]);
            let mut found = Found::of(IssueCode::OpeningMissesWall, subject, text);
            found.place = crate::evidence::place_of_element(site, opening.host as usize);
            // What was to be open stays closed: a room that cannot be reached for that is told itself.
            Some(found.without_effect_on_maps())
        }
    }
}
