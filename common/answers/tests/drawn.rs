//! Answers about buildings that are drawn as text.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../stages/waypoints/tests/support/mod.rs"]
mod support;

use answers::{
    AnswerBasis, Circumstances, FindError, MapUse, Situation, door, find_door, find_place, find_room, may_enter, room,
    way, way_exists,
};
use messages::{MissionPlan, RobotProfile, WaypointKind};
use support::{Archives, House, quick};
use waypoints::{MissionPlanOptions, MissionPlanner, WayEnd};

const GROUND: &str = "
#############################
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#SSSaaaaaaaaaaDbbbbbbbbbbbbb#
#SSSaaaaaaaaaaDbbbbbbbbbbbbb#
#SSSaaaaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaa#bbbbbbbbbbbbb#
#############################";

const UPPER: &str = "
#############################
#ccccccccccccccccccccccccccc#
#ccccccccccccccccccccccccccc#
#SSScccccccccccccccccccccccc#
#SSScccccccccccccccccccccccc#
#SSScccccccccccccccccccccccc#
#ccccccccccccccccccccccccccc#
#ccccccccccccccccccccccccccc#
#ccccccccccccccccccccccccccc#
#############################";

fn circumstances(maps: Option<MapUse>) -> Circumstances {
    Circumstances {
        of: if maps.is_some() { AnswerBasis::RunningSite } else { AnswerBasis::Models },
        models: vec!["drawn.ifc".to_owned()],
        plan_time: None,
        plan_until: None,
        valid_until: None,
        robot: "drawn".to_owned(),
        robot_radius_m: 0.3,
        resolution_m: Some(0.1),
        frame_epoch: 1,
        epochs: None,
        maps,
    }
}

fn in_situation<T>(house: &House, circumstances: &Circumstances, work: impl FnOnce(&Situation<'_>) -> T) -> T {
    Archives::of(house).with(&MissionPlanOptions { kinds: [WaypointKind::Centre].into(), ..quick() }, |input| {
        let bytes = MissionPlanner::default().plan(input);
        let mission_plan = MissionPlan::open(bytes.bytes()).unwrap();
        work(&Situation {
            site: input.site,
            schedule_state: input.schedule_state,
            index: input.index,
            grids: input.grids,
            mission_plan: &mission_plan,
            timeline: None,
            circumstances,
        })
    })
}

fn with<T>(house: &House, work: impl FnOnce(&Situation<'_>) -> T) -> T {
    in_situation(house, &circumstances(None), work)
}

#[test]
fn a_way_says_its_legs_or_what_is_missing() {
    let mut house = House::drawn(&[GROUND, UPPER]);
    house.robot = RobotProfile { climbs_stairs: 1, ..RobotProfile::DEFAULT };
    let answer = |house: &House| {
        with(house, |situation| {
            let [from, to] = ["b", "c"].map(|name| find_place(situation.site, name).unwrap());
            let answer = way(situation, &from, &to);
            assert_eq!(answer.exists, way_exists(situation, from.end, to.end));
            answer
        })
    };
    let there = answer(&house);
    assert_eq!(there.legs.iter().map(|leg| leg.kind).collect::<Vec<_>>(), ["floor", "stair", "floor"]);
    assert_eq!((there.legs[1].storey, there.legs[1].to_storey), (0, 1));
    assert_eq!(there.legs[0].doors[0].element.global_id, "door-0");
    assert_eq!(there.legs[0].rooms.iter().map(|room| room.label()).collect::<Vec<_>>(), ["b", "a"]);
    assert!(there.legs.windows(2).all(|legs| legs[0].points_m.last() == legs[1].points_m.first()), "{there:?}");
    let text = there.text();
    assert!(text.starts_with("way from b on Storey 0 to c on Storey 1: "), "{text}");
    assert!(text.contains("of the model drawn.ifc, not of a running site"), "{text}");

    house.absent.insert('S');
    let none = answer(&house);
    assert_eq!((none.exists, none.length_m, none.legs.len(), none.missing.len()), (false, None, 0, 1));
    let missing = &none.missing[0];
    assert_eq!((missing.kind, missing.code, missing.global_id.as_deref()), ("stair", "not_built", Some("IfcStair-S")));
    assert!(none.text().contains("stair IfcStair-S (IfcStair-S): it is not built"), "{}", none.text());
    house.absent.clear();
    house.robot.climbs_stairs = 0;
    assert_eq!(answer(&house).missing[0].code, "not_used");
    house.blocked.insert('c', "private");
    let codes: Vec<&str> = answer(&house).missing.iter().map(|missing| missing.code).collect();
    assert_eq!(codes, ["blocked", "not_used"]);
}

#[test]
fn a_room_says_whether_it_may_be_entered_and_why_not() {
    let mut house = House::drawn(&[GROUND]);
    let answer = |house: &House, name: &str| {
        with(house, |situation| {
            let space = find_room(situation.site, name).unwrap();
            let answer = room(situation, space);
            assert_eq!(answer.may_enter, may_enter(situation.mission_plan, space));
            answer
        })
    };
    let open = answer(&house, "a");
    assert_eq!((open.may_enter, open.state, open.access, &open.why_not), (Some(true), "open", Some("reached"), &None));
    assert_eq!(open.doors[0].leads_to.as_ref().unwrap().label(), "b");
    house.blocked.insert('a', "task:T");
    let closed = answer(&house, "a");
    assert_eq!((closed.may_enter, closed.state, closed.access), (Some(false), "blocked", Some("closed")));
    assert_eq!(closed.closed_by[0].task.as_ref().unwrap().global_id, "T");
    house.blocked.clear();
    let far = House::drawn(&[&GROUND.replace('D', "X")]);
    let rooms = ["a", "b"].map(|name| answer(&far, name));
    let kept_out = rooms.iter().find(|room| room.may_enter == Some(false)).unwrap();
    assert_eq!((kept_out.access, kept_out.closed_door.as_deref()), (Some("no_way"), Some("door-0")));
    assert!(kept_out.why_not.as_ref().unwrap().contains("door-0"));
    let outdoors =
        |house: &mut House| house.spaces.insert('b', |space| space.flags = messages::space_flags::METADATA_ONLY);
    outdoors(&mut house);
    let gross = with(&house, |situation| room(situation, 1));
    assert_eq!((gross.may_enter, gross.access, gross.why_not.is_some()), (None, None, true));
}

#[test]
fn a_door_says_what_it_needs_and_what_it_has() {
    let answer = |house: &House| with(house, |situation| door(situation, find_door(situation.site, "DOOR-0").unwrap()));
    let open = answer(&House::drawn(&[GROUND]));
    assert_eq!((open.can_pass, open.passage, open.reasons.len()), (Some(true), Some("passable"), 0));
    assert_eq!((open.rooms.len(), open.needed_width_m, open.clear_width_m), (2, 0.7, 0.9));
    let closed = answer(&House::drawn(&[&GROUND.replace('D', "X")]));
    assert_eq!((closed.can_pass, closed.reasons[0].code), (Some(false), "operation"));
    assert!(
        closed.text().contains("this robot cannot pass it: this robot does not open REVOLVING"),
        "{}",
        closed.text()
    );
}

#[test]
fn maps_that_may_not_be_used_are_said_to_be_so() {
    let why_not = Some("rasterize has missed 3 heartbeats".to_owned());
    let stale = circumstances(Some(MapUse { may_be_used: false, why_not }));
    let text = in_situation(&House::drawn(&[GROUND]), &stale, |situation| room(situation, 0).text());
    assert!(text.contains("the maps may not be used: rasterize has missed 3 heartbeats"), "{text}");
    assert!(!stale.may_be_used() && circumstances(None).may_be_used());
}

#[test]
fn names_find_one_thing_or_say_what_is_near() {
    with(&House::drawn(&[GROUND, UPPER]), |situation| {
        let site = situation.site;
        assert_eq!((find_room(site, " B ").unwrap(), find_room(site, "space-b").unwrap()), (1, 1));
        let unknown = find_room(site, "space-d").unwrap_err();
        assert!(unknown.to_string().contains("nearest"), "{unknown}");
        assert!(matches!(find_door(site, "door-7"), Err(FindError::Unknown(_))));
        let end = |words: &str| find_place(site, words).map(|place| place.end);
        let WayEnd::Point { map_storey, at } = end("1.5,2,1").unwrap() else { panic!() };
        assert_eq!((map_storey, at.x_m(), at.y_m()), (1, 1.5, 2.0));
        assert_eq!(end("1.5, 2, storey 1").unwrap(), end("1.5,2,1").unwrap());
        for words in ["1.5,2", "1.5,2,cellar", "1.5,2,7"] {
            let unknown = end(words).unwrap_err().to_string();
            assert!(unknown.contains("0 \"Storey 0\", 1 \"Storey 1\""), "{unknown}");
        }
        assert!(matches!(end("1.5,inf,0"), Err(FindError::Unknown(_))));
    });
    with(&House::drawn(&[GROUND]), |situation| {
        let place = find_place(situation.site, "1.5,2").unwrap();
        assert!(matches!(place.end, WayEnd::Point { map_storey: 0, .. }), "the only storey");
    });
}
