//! Reasons for spaces without waypoints.

use crate::barriers::{Obstacle, portal_text};
use crate::options::MissionPlanOptions;
use messages::{
    DoorPassage, DoorPassageRecord, NONE, NoWaypoint, RobotProfile, ScheduleState, ScheduleStateHead, Site, plan_time,
    space_flags,
};

/// Why a space gets no waypoint.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) why: NoWaypoint,
    /// The reason as text.
    pub(crate) reason: String,
    /// The closed door, or [`NONE`].
    pub(crate) door: u32,
}

impl Refusal {
    pub(crate) fn new(why: NoWaypoint, reason: impl Into<String>) -> Self {
        Self { why, reason: reason.into(), door: NONE }
    }
}

/// Reason why a space gets no waypoint, independent of the map.
pub(crate) fn refused(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    options: &MissionPlanOptions,
    index: usize,
) -> Option<Refusal> {
    let space = &site.spaces[index];
    let closes_at_s = schedule_state.spaces[index].closes_at_s;
    let refusal = |why, reason: &str| Some(Refusal::new(why, reason));
    if space.has(space_flags::METADATA_ONLY) {
        refusal(NoWaypoint::MetadataOnly, "it is a gross area, or made of other spaces")
    } else if space.has(space_flags::EXTERNAL) {
        refusal(NoWaypoint::External, "it is outdoors")
    } else if space.n_rings == 0 {
        refusal(NoWaypoint::NoBody, "it has no body")
    } else if space.has(space_flags::SHAFT) {
        refusal(NoWaypoint::NotMapped, "it is a lift shaft, a riser or a pit")
    } else if space.map_storey == NONE {
        refusal(NoWaypoint::NotMapped, "its floor is on no map storey")
    } else if schedule_state.is_blocked(index) {
        let why = schedule_state.why(index).collect::<Vec<_>>().join(", ");
        refusal(NoWaypoint::Blocked, &format!("it is blocked: {why}"))
    } else if closes_at_s != ScheduleStateHead::NO_TIME {
        let at = plan_time(closes_at_s).map_or(String::new(), |at| format!(" at {at}"));
        refusal(NoWaypoint::Closing, &format!("it will be blocked{at}"))
    } else if !options.wants_storey(space.map_storey) {
        refusal(NoWaypoint::NotAsked, "its storey was not asked for")
    } else if !options.wants_space(site, index) {
        refusal(NoWaypoint::NotAsked, "it was not asked for")
    } else {
        None
    }
}

/// The closed door of a space: of those that the robot cannot pass the one with the lowest index.
pub(crate) fn closed_door(
    site: &Site<'_>,
    robot: &RobotProfile,
    passages: &[DoorPassageRecord],
    space: usize,
) -> Option<Refusal> {
    let leads_there = |p: &&DoorPassageRecord| site.doors[p.door as usize].spaces.contains(&(space as u32));
    let is_closed = |p: &&DoorPassageRecord| p.passage.get().is_closed();
    // A door of another level may also lead there without floor on this level.
    let is_elsewhere = |p: &&DoorPassageRecord| p.passage == DoorPassage::NoFloor;
    let closed = passages.iter().filter(leads_there).filter(is_closed).min_by_key(is_elsewhere)?;
    Some(Refusal { why: NoWaypoint::ClosedDoor, reason: door_text(site, robot, closed, space), door: closed.door })
}

/// Why a space is not reached: the obstacles on the way there, that nearest to it first.
pub(crate) fn behind(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    obstacles: &[Obstacle],
    space: usize,
) -> Option<Refusal> {
    let text = |obstacle: &Obstacle| match obstacle {
        Obstacle::Door(passage) => door_text(site, robot, passage, space),
        Obstacle::Space(other) => {
            let why = schedule_state.why(*other).collect::<Vec<_>>().join(", ");
            format!("the room {} on the way is blocked: {why}", site.text(site.spaces[*other].global_id))
        }
        Obstacle::Portal(kind, element) => portal_text(site, kind.edge_kind(), *element),
        Obstacle::Floor(..) => "the floor on the way is keep-out, or narrower than the robot".to_owned(),
    };
    let reason = obstacles.iter().map(text).collect::<Vec<_>>().join("; ");
    let door = obstacles.iter().find_map(|obstacle| match obstacle {
        Obstacle::Door(passage) => Some(passage.door),
        _ => None,
    });
    let why = if door.is_some() { NoWaypoint::ClosedDoor } else { NoWaypoint::Unreachable };
    (!obstacles.is_empty()).then_some(Refusal { why, reason, door: door.unwrap_or(NONE) })
}

/// A closed door on the way to a space, in words.
fn door_text(site: &Site<'_>, robot: &RobotProfile, closed: &DoorPassageRecord, space: usize) -> String {
    let door = &site.doors[closed.door as usize];
    let element = &site.elements[door.element as usize];
    let needed_m = robot.needed_width_m();
    let why = match closed.passage.get() {
        DoorPassage::CannotOpen if site.text(element.predefined_type) == "TRAPDOOR" => "it is a trapdoor".to_owned(),
        DoorPassage::CannotOpen if site.moving_leaves(door).is_none() => "all its leaves are fixed".to_owned(),
        DoorPassage::CannotOpen => {
            let operation = Some(site.text(door.operation)).filter(|o| !o.is_empty()).unwrap_or("unknown operation");
            format!("this robot does not open it ({operation})")
        }
        DoorPassage::TooNarrow => format!("the robot needs {needed_m:.2} m"),
        DoorPassage::ClosedByResolution => {
            format!("the map's cells leave {:.2} m of it", closed.width_in_map_m)
        }
        DoorPassage::NoFloor => "there is no floor at it".to_owned(),
        DoorPassage::NoOpening => "its wall has no opening".to_owned(),
        DoorPassage::Threshold => "a threshold stands in it".to_owned(),
        DoorPassage::WallUncut => "its wall is not cut by its opening".to_owned(),
        DoorPassage::Obstructed => {
            format!("obstacles leave {:.2} m of it", closed.width_between_obstacles_m)
        }
        DoorPassage::InProgress | DoorPassage::Passable | DoorPassage::Absent => {
            "it is being hung or taken down".to_owned()
        }
    };
    let id = site.text(element.global_id);
    let named = if door.spaces.contains(&(space as u32)) {
        format!("its door {id}")
    } else {
        format!("the door {id} on the way")
    };
    format!("{named} is closed to the robot: {:.2} m clear, {why}", closed.clear_width_m)
}
