//! Robots of a site on the bus: each has topics, heartbeats and commands of its own, and what is the site's is that of all.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use bus::{Bus, CommandError, Daemon, Domain, DomainError, InProcessBus, Keeper, PortError, Reply, RobotName, topics};
use common::{Attended, Fixture, eventually, origin, publish, sample_of, until};
use messages::{ArchiveBuffer, ContentHash, GridsBuilder, GridsHead, RobotProfile, StatusRecord};

fn name(text: &str) -> RobotName {
    text.parse().unwrap()
}

/// The bus as the site has it, and as each of two robots does.
fn two_robots(fixture: &Fixture) -> [Domain; 3] {
    let site = fixture.domain.clone().with_robots([name("scan"), name("lift")]).unwrap();
    let [lift, scan] = ["lift", "scan"].map(|robot| site.clone().of_robot(name(robot)).unwrap());
    [site, lift, scan]
}

fn index(robot_name: &str) -> ArchiveBuffer {
    let head = GridsHead {
        site_hash: ContentHash::from_bits(3),
        schedule_state_hash: ContentHash::from_bits(4),
        plan_time_s: 0,
        robot: RobotProfile::DEFAULT,
    };
    GridsBuilder::of(head, &[], robot_name).finish()
}

#[test]
fn each_robot_has_topics_of_its_own_and_those_of_the_site_are_for_all() {
    let fixture = Fixture::shared();
    let [site, lift, scan] = two_robots(&fixture);
    let _keeper = Keeper::start(&site).unwrap();
    let evaluation = Attended::join(&site, Daemon::ScheduleEval);
    let states = evaluation.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&states, 7, 3);
    // Two daemons of one kind, each the only one of its robot.
    let drawing = [&lift, &scan].map(|domain| Attended::join(domain, Daemon::Rasterize));
    let indices = drawing.each_ref().map(|daemon| daemon.bus.publisher(topics::Grids, 4096).unwrap());
    let second = Attended::join(&lift, Daemon::Rasterize);
    let taken = second.bus.publisher(topics::Grids, 4096).map(drop).unwrap_err().to_string();
    assert!(taken.contains("robots/lift/grids"), "{taken}");
    for (index_of, (robot, epoch)) in indices.iter().zip([("lift", 11), ("scan", 22)]) {
        index_of.publish_copy(index(robot).bytes(), origin(epoch)).unwrap();
    }
    for (domain, robot, epoch) in [(&lift, "lift", 11), (&scan, "scan", 22)] {
        let (bus, mut waiter) = Bus::join(domain, Daemon::Groundplan).unwrap();
        let (index, state) = (bus.subscriber(topics::Grids).unwrap(), bus.subscriber(topics::ScheduleState).unwrap());
        let sample = sample_of(&mut waiter, &index, epoch);
        assert_eq!(sample.check().unwrap().view().robot_name, robot);
        sample_of(&mut waiter, &state, 7);
    }
    // The death of one robot's publisher is none of the other's business.
    let [of_lift, of_scan] = indices;
    drop(of_scan);
    of_lift.publish_copy(index("lift").bytes(), origin(12)).unwrap();
    let (bus, mut waiter) = Bus::join(&lift, Daemon::Groundplan).unwrap();
    sample_of(&mut waiter, &bus.subscriber(topics::Grids).unwrap(), 12);
}

#[test]
fn commands_and_heartbeats_go_to_the_robot_that_is_meant() {
    let fixture = Fixture::shared();
    let [site, lift, scan] = two_robots(&fixture);
    let _keeper = Keeper::start(&site).unwrap();
    let [(of_lift, mut waiter), (of_scan, _)] =
        [&lift, &scan].map(|domain| Bus::join(domain, Daemon::Groundplan).unwrap());
    let served = Attended::join(&lift, Daemon::Rasterize);
    let server = served.bus.command_server().unwrap();
    let open = of_lift.command_client(Daemon::Rasterize).unwrap().send(b"draw").unwrap();
    let command = eventually("the command", || server.take().unwrap());
    command.done(b"drawn").unwrap();
    let reply = until(&mut waiter, "the reply", || open.take().unwrap());
    assert_eq!(reply, Reply::Done(b"drawn".to_vec()));
    let refused = of_scan.command_client(Daemon::Rasterize).unwrap().send(b"draw").map(drop);
    assert!(matches!(refused, Err(CommandError::NotServed { daemon: Daemon::Rasterize })), "{refused:?}");

    let evaluation = Attended::join(&site, Daemon::ScheduleEval);
    let readers = [&of_lift, &of_scan].map(|bus| bus.status_reader().unwrap());
    let writers = [&served.bus, &evaluation.bus].map(|bus| bus.status_writer().unwrap());
    assert!(writers.iter().all(|writer| writer.send(bytemuck::Zeroable::zeroed())));
    let heard = |reader: &bus::StatusReader| {
        let mut daemons = Vec::new();
        while let Some(StatusRecord { daemon, .. }) = reader.take().unwrap() {
            daemons.extend(Daemon::from_id(daemon));
        }
        daemons
    };
    assert_eq!(heard(&readers[0]), [Daemon::ScheduleEval, Daemon::Rasterize]);
    assert_eq!(heard(&readers[1]), [Daemon::ScheduleEval]);
}

#[test]
fn who_names_no_robot_of_several_has_what_is_the_sites_alone() {
    let fixture = Fixture::shared();
    let [site, lift, _] = two_robots(&fixture);
    let _keeper = Keeper::start(&site).unwrap();
    let refused = Bus::join(&site, Daemon::Rasterize).map(drop).unwrap_err();
    assert!(matches!(&refused, DomainError::NoRobotNamed { robots, .. } if robots == "lift, scan"), "{refused}");
    let (bus, _waiter) = Bus::join(&site, Daemon::Groundplan).unwrap();
    bus.subscriber(topics::Site).unwrap();
    bus.command_client(Daemon::ScheduleEval).unwrap();
    for refused in [bus.subscriber(topics::Grids).map(drop), bus.command_client(Daemon::SlamAlign).map(drop)] {
        assert!(
            matches!(&refused, Err(PortError::NoRobotNamed { robots, .. }) if robots == "lift, scan"),
            "{refused:?}"
        );
    }
    let unknown = site.clone().of_robot(name("crane")).unwrap_err().to_string();
    assert!(unknown.contains("no robot `crane`: it has lift, scan"), "{unknown}");
    let twice = site.clone().with_robots(["lift", "lift"].map(name)).map(drop);
    assert!(matches!(twice, Err(DomainError::RobotTwice { .. })), "{twice:?}");
    let many = site.with_robots(["a", "b", "c", "d", "e"].map(name)).map(drop);
    assert!(matches!(many, Err(DomainError::ManyRobots { n_robots: 5 })), "{many:?}");
    // The unnamed robot's topics are not there.
    let (unnamed, _waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    assert!(matches!(unnamed.subscriber(topics::Grids).map(drop), Err(PortError::Missing { .. })));
    drop(lift);
}

#[test]
fn a_keeper_that_died_is_followed_by_one_with_the_same_robots() {
    let fixture = Fixture::shared();
    let [site, lift, _] = two_robots(&fixture);
    let keeper = Keeper::start(&site).unwrap();
    let drawing = Attended::join(&lift, Daemon::Rasterize);
    let indices = drawing.bus.publisher(topics::Grids, 4096).unwrap();
    indices.publish_copy(index("lift").bytes(), origin(1)).unwrap();
    let generation = keeper.generation();
    drop(keeper);
    let keeper = Keeper::start(&site).unwrap();
    assert!(keeper.generation() > generation);
    let (bus, _waiter) = Bus::join(&lift, Daemon::Rasterize).unwrap();
    bus.publisher(topics::Grids, 4096).unwrap();
}

#[test]
fn robots_inside_one_process_are_as_apart_as_in_shared_memory() {
    let site = InProcessBus::new();
    let [lift, scan] = ["lift", "scan"].map(|robot| Bus::in_process_of_robot(&site, Daemon::Rasterize, name(robot)));
    let states = Bus::in_process(&site, Daemon::ScheduleEval).publisher(topics::ScheduleState, 4096).unwrap();
    publish(&states, 7, 3);
    let indices = lift.publisher(topics::Grids, 4096).unwrap();
    indices.publish_copy(index("lift").bytes(), origin(1)).unwrap();
    scan.publisher(topics::Grids, 4096).unwrap();
    let epoch_of = |bus: &Bus| bus.subscriber(topics::Grids).unwrap().take().unwrap().map(|s| s.header().epoch);
    assert_eq!([&lift, &scan, &Bus::in_process(&site, Daemon::Groundplan)].map(epoch_of), [Some(1), None, None]);
    for bus in [&lift, &scan] {
        assert_eq!(bus.subscriber(topics::ScheduleState).unwrap().take().unwrap().unwrap().header().epoch, 7);
    }
    let reader = scan.status_reader().unwrap();
    assert!(lift.status_writer().unwrap().send(bytemuck::Zeroable::zeroed()));
    assert!(reader.take().unwrap().is_none());
    assert!(scan.status_writer().unwrap().send(bytemuck::Zeroable::zeroed()));
    assert!(reader.take().unwrap().is_some());
}
