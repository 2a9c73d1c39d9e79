//! Every space without a centre has a reason.

mod support;

use messages::{NONE, NoWaypoint, RobotProfile, SpaceRecord, WaypointKind, space_flags};
use support::{House, Planned, quick};
use waypoints::{MissionPlanOptions, Start};

/// Two rooms with a door of a metre between them.
const TWO_ROOMS: &str = "
#####################
#aaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaa#bbbbbbbb#
#####################";

fn quick_centres() -> MissionPlanOptions {
    MissionPlanOptions { kinds: [WaypointKind::Centre].into(), ..quick() }
}

/// What becomes of room b after a change; room a has its centre all the same.
fn why_b(change: impl Fn(&mut House)) -> (NoWaypoint, String) {
    let mut house = House::drawn(&[TWO_ROOMS]);
    change(&mut house);
    let planned = house.planned(&quick_centres());
    assert_eq!(planned.why('a'), (NoWaypoint::Has, String::new()));
    assert_eq!(planned.centre('b').is_none(), planned.why('b').0 != NoWaypoint::Has);
    planned.why('b')
}

fn because(why: NoWaypoint, reason: &str) -> (NoWaypoint, String) {
    (why, reason.to_owned())
}

#[test]
fn an_open_room_behind_an_open_door_has_a_centre() {
    assert_eq!(why_b(|_| {}), because(NoWaypoint::Has, ""));
}

#[test]
fn what_the_model_says_of_a_space_is_a_reason() {
    let record = |change: fn(&mut SpaceRecord)| {
        why_b(|house| {
            house.spaces.insert('b', change);
        })
    };
    assert_eq!(
        record(|s| s.flags = space_flags::METADATA_ONLY),
        because(NoWaypoint::MetadataOnly, "it is a gross area, or made of other spaces")
    );
    assert_eq!(record(|s| s.flags = space_flags::EXTERNAL), because(NoWaypoint::External, "it is outdoors"));
    assert_eq!(record(|s| s.n_rings = 0), because(NoWaypoint::NoBody, "it has no body"));
    assert_eq!(record(|s| s.map_storey = NONE), because(NoWaypoint::NotMapped, "its floor is on no map storey"));
}

#[test]
fn a_space_that_is_nowhere_drawn_has_no_body() {
    let mut house = House::drawn(&[TWO_ROOMS]);
    house.spaces.insert('n', |_| {});
    assert_eq!(house.planned(&quick_centres()).why('n').0, NoWaypoint::NoBody);
}

#[test]
fn a_blocked_space_says_why_and_a_closing_one_when() {
    let blocked = why_b(|house| {
        house.blocked.insert('b', "task:screed");
    });
    assert_eq!(blocked, because(NoWaypoint::Blocked, "it is blocked: task:screed"));
    let closing = why_b(|house| {
        // 2024-03-04, ten to eight in the morning.
        house.closing.insert('b', 1_709_538_600);
    });
    assert_eq!(closing.0, NoWaypoint::Closing);
    assert!(closing.1.starts_with("it will be blocked at 2024-03-04T07:50"), "{}", closing.1);
}

#[test]
fn a_space_that_was_not_asked_for_says_so() {
    let options = MissionPlanOptions { spaces: vec!["a".to_owned()], ..quick_centres() };
    let planned = House::drawn(&[TWO_ROOMS]).planned(&options);
    assert_eq!(planned.why('b'), because(NoWaypoint::NotAsked, "it was not asked for"));
}

#[test]
fn a_space_without_floor_says_so() {
    // A stair hole takes all of it; what it is written in capitals for.
    let planned = House::drawn(&["
##################
#aaaaaaaa#BBBBBBB#
#aaaaaaaa#BBBBBBB#
#aaaaaaaa#BBBBBBB#
#aaaaaaaa#BBBBBBB#
#aaaaaaaa#BBBBBBB#
##################"])
    .planned(&quick_centres());
    assert_eq!(planned.why('b'), because(NoWaypoint::NoFloor, "it has no floor at the level of its map storey"));
}

#[test]
fn a_space_whose_floor_is_that_of_another_one_names_it() {
    let mut house = House::drawn(&["
##############
#aaaaaaaaaaaa#
#aaaaaaaaaaaa#
#aaaaaaaaaaaa#
#aaaaFFFaaaaa#
#aaaaFFFaaaaa#
#aaaaaaaaaaaa#
#aaaaaaaaaaaa#
#aaaaaaaaaaaa#
##############"]);
    // Every cell is of one space only, and its centroid is under furniture.
    house.overlaid.insert('n', 'a');
    let planned = house.planned(&quick_centres());
    let reason = "its floor is that of the space space-a, which lies over it";
    assert_eq!(planned.why('n'), because(NoWaypoint::Shared, reason));
    assert!(planned.centre('a').is_some());
}

#[test]
fn a_space_under_keep_out_says_so() {
    // A letter holds the name; the rest of the room is keep-out, and so is that letter's furniture.
    let planned = House::drawn(&["
##################
#aaaaaaaaDb~~~~~~#
#aaaaaaaaD~~~~~~~#
#aaaaaaaaD~~~~~~~#
#aaaaaaaaD~~~~~~~#
#aaaaaaaaD~~~~~~~#
##################"
        .replace('b', "B")
        .as_str()])
    .planned(&quick_centres());
    assert_eq!(planned.why('b'), because(NoWaypoint::Keepout, "all of it is keep-out"));
}

#[test]
fn a_space_full_of_things_says_so() {
    let planned = House::drawn(&["
##################
#aaaaaaaa#FFFFFFF#
#aaaaaaaa#FFFFFFF#
#aaaaaaaa#FFFFFFF#
#aaaaaaaa#FFFFFFB#
#aaaaaaaa#FFFFFFF#
##################"])
    .planned(&quick_centres());
    assert_eq!(planned.why('b'), because(NoWaypoint::TooNarrow, "what stands in it leaves no free place"));
}

#[test]
fn a_door_that_the_robot_cannot_open_is_named_with_its_operation() {
    let drawing = TWO_ROOMS.replace('D', "X");
    let planned = House::drawn(&[&drawing]).planned(&quick_centres());
    assert_eq!(
        planned.why('b'),
        because(
            NoWaypoint::ClosedDoor,
            "its door door-0 is closed to the robot: 0.90 m clear, this robot does not open it (REVOLVING)"
        )
    );
}

#[test]
fn the_same_door_is_closed_to_a_wider_robot() {
    let wide = |house: &mut House| house.robot = RobotProfile { radius_m: 0.41, ..RobotProfile::DEFAULT };
    let (why, reason) = why_b(wide);
    assert_eq!(why, NoWaypoint::ClosedDoor);
    assert_eq!(reason, "its door door-0 is closed to the robot: 0.90 m clear, the robot needs 0.92 m");
}

/// What the plan says of the way to a space.
fn access(planned: &Planned, space: char) -> (Option<&'static str>, String) {
    let place = planned.archives.names.iter().position(|name| *name == space).expect("the plan has the space");
    let mission_plan = planned.mission_plan();
    (mission_plan.spaces[place].access.get().name(), mission_plan.access_reason(place).to_owned())
}

#[test]
fn a_space_is_open_to_the_robot_only_where_a_way_leads() {
    let mut house = House::drawn(&[TWO_ROOMS]);
    assert_eq!(access(&house.planned(&quick_centres()), 'b'), (Some("reached"), String::new()));
    house.blocked.insert('b', "private");
    assert_eq!(access(&house.planned(&quick_centres()), 'b'), (Some("closed"), String::new()));
    let closed = House::drawn(&[&TWO_ROOMS.replace('D', "X")]);
    let reason = "its door door-0 is closed to the robot: 0.90 m clear, this robot does not open it (REVOLVING)";
    assert_eq!(access(&closed.planned(&quick_centres()), 'b'), (Some("no_way"), reason.to_owned()));
    // Also of a room that nobody asked for, and of one that is outdoors.
    let asked = MissionPlanOptions { spaces: vec!["a".to_owned()], ..quick_centres() };
    let planned = closed.planned(&asked);
    assert_eq!((access(&planned, 'b'), planned.space('b').door), ((Some("no_way"), reason.to_owned()), 0));
    assert_eq!(planned.why('b').0, NoWaypoint::NotAsked);
    let mut outdoors = House::drawn(&[TWO_ROOMS]);
    outdoors.spaces.insert('b', |s| s.flags = space_flags::EXTERNAL);
    assert_eq!(access(&outdoors.planned(&quick_centres()), 'b').0, Some("reached"));
    outdoors.spaces.insert('b', |s| s.flags = space_flags::METADATA_ONLY);
    assert_eq!(access(&outdoors.planned(&quick_centres()), 'b').0, None);
}

/// Three rooms in a row.
const THREE_ROOMS: &str = "
##############################
#aaaaaaaaaa#bbbbbbbb#cccccccc#
#aaaaaaaaaa#bbbbbbbb#cccccccc#
#aaaaaaaaaa#bbbbbbbb#cccccccc#
#aaaaaaaaaaXbbbbbbbbDcccccccc#
#aaaaaaaaaaXbbbbbbbbDcccccccc#
#aaaaaaaaaaXbbbbbbbbDcccccccc#
#aaaaaaaaaaXbbbbbbbbDcccccccc#
#aaaaaaaaaaXbbbbbbbbDcccccccc#
#aaaaaaaaaa#bbbbbbbb#cccccccc#
#aaaaaaaaaa#bbbbbbbb#cccccccc#
##############################";

#[test]
fn a_room_behind_another_one_names_what_closes_the_way_there() {
    let start = Some(Start { storey: 0, x_m: 0.5, y_m: 0.5 });
    let options = MissionPlanOptions { start, ..quick_centres() };
    let planned = House::drawn(&[THREE_ROOMS]).planned(&options);
    let reason =
        "the door door-1 on the way is closed to the robot: 0.90 m clear, this robot does not open it (REVOLVING)";
    assert_eq!(planned.why('c'), because(NoWaypoint::ClosedDoor, reason));
    assert_eq!(access(&planned, 'c'), (Some("no_way"), reason.to_owned()));
    let mut blocked = House::drawn(&[&THREE_ROOMS.replace('X', "D")]);
    blocked.blocked.insert('b', "task:screed");
    let planned = blocked.planned(&options);
    let reason = "the room space-b on the way is blocked: task:screed";
    assert_eq!(planned.why('c'), because(NoWaypoint::Unreachable, reason));
}
