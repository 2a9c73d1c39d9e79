//! Samples of a site that belong together, from publishers to the reader.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../bus/tests/common/mod.rs"]
mod common;

use bus::{Bus, Daemon, Keeper, Origin, Publisher, Topic, topics};
use common::{Attended, Fixture, grid, until};
use messages::{
    ArchiveBuffer, ContentHash, GridHead, GridSlotRecord, GridWriter, GridsBuilder, GridsHead, InputHashes,
    MissionPlanBuilder, MissionPlanHead, RobotProfile, ScheduleState, ScheduleStateBuilder, Site, SiteBuilder,
};
use site_view::{SiteSample, SiteSamples, SiteSetReader};

/// Publishes everything that a set consists of.
struct Producers {
    _attended: [Attended; 4],
    sites: Publisher<topics::Site>,
    states: Publisher<topics::ScheduleState>,
    indices: Publisher<topics::Grids>,
    grids: [Publisher<topics::Grid>; 2],
    mission_plans: Publisher<topics::MissionPlan>,
    epoch: u64,
}

impl Producers {
    fn on(fixture: &Fixture) -> Self {
        let join = |daemon| Attended::join(&fixture.domain, daemon);
        let attended = [Daemon::IfcIngest, Daemon::ScheduleEval, Daemon::Rasterize, Daemon::WaypointGen].map(join);
        let [ingest, schedule, rasterize, waypoints] = &attended;
        Self {
            sites: ingest.bus.publisher(topics::Site, 4096).unwrap(),
            states: schedule.bus.publisher(topics::ScheduleState, 4096).unwrap(),
            indices: rasterize.bus.publisher(topics::Grids, 4096).unwrap(),
            grids: [0, 1].map(|slot| rasterize.bus.publisher(grid(slot), 4096).unwrap()),
            mission_plans: waypoints.bus.publisher(topics::MissionPlan, 4096).unwrap(),
            _attended: attended,
            epoch: 0,
        }
    }

    fn origin(&mut self, inputs: InputHashes) -> Origin {
        self.epoch += 1;
        Origin { epoch: self.epoch, frame_epoch: 1, inputs }
    }

    fn publish<T: Topic>(&mut self, which: fn(&Self) -> &Publisher<T>, archive: &ArchiveBuffer, inputs: InputHashes) {
        let origin = self.origin(inputs);
        which(self).publish_copy(archive.bytes(), origin).unwrap();
    }
}

const NONE: InputHashes = {
    let none = ContentHash::NONE;
    InputHashes { site: none, schedule_state: none, grids: none, robot: none, slam_map: none, own: none }
};

fn site(name: &str) -> ArchiveBuffer {
    let mut builder = SiteBuilder::default();
    builder.texts.add(name);
    builder.finish()
}

fn state_of(site: &ArchiveBuffer, plan_time_s: i64) -> ArchiveBuffer {
    let mut builder = ScheduleStateBuilder::everything_built(Site::open(site.bytes()).unwrap().content_hash(), 0, 0);
    builder.head.plan_time_s = plan_time_s;
    builder.finish()
}

fn grid_of(planning: i8) -> ArchiveBuffer {
    let head = GridHead { cell_tenths: 1_000, width: 4, height: 2, ..GridHead::EMPTY };
    let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(8));
    let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
    writer.layers().planning.fill(planning);
    writer.seal();
    buffer
}

fn index_of(state: &ArchiveBuffer, grids: &[&ArchiveBuffer]) -> ArchiveBuffer {
    let state = ScheduleState::open(state.bytes()).unwrap();
    let record = |grid: &&ArchiveBuffer| GridSlotRecord {
        map_storey: 0,
        cell_tenths: 1_000,
        content_hash: messages::Grid::open(grid.bytes()).unwrap().content_hash(),
    };
    let slots: Vec<_> = grids.iter().map(record).collect();
    let head = GridsHead {
        site_hash: state.head.site_hash,
        schedule_state_hash: state.content_hash(),
        plan_time_s: 0,
        robot: RobotProfile::DEFAULT,
    };
    GridsBuilder::of(head, &slots, "default").finish()
}

#[test]
fn a_set_is_there_when_all_that_belongs_together_is_and_only_then() {
    let fixture = Fixture::shared();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    let mut out = Producers::on(&fixture);
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    let mut reader = SiteSetReader::of(&bus).unwrap();

    let (first, later) = (site("first"), site("later"));
    let [early, late] = [1, 2].map(|plan_time_s| state_of(&first, plan_time_s));
    let [ground, upper, changed] = [0, -1, 100].map(grid_of);
    out.publish(|p| &p.grids[0], &ground, NONE);
    out.publish(|p| &p.grids[1], &upper, NONE);
    out.publish(|p| &p.indices, &index_of(&early, &[&ground, &upper]), NONE);
    out.publish(|p| &p.states, &early, NONE);
    out.publish(|p| &p.sites, &first, NONE);
    let mut wait_for = |reader: &mut SiteSetReader, what: &str, is_it: &dyn Fn(&SiteSetReader) -> bool| {
        until(&mut waiter, what, || {
            reader.take().unwrap();
            is_it(reader).then_some(())
        });
    };
    let plan_time_s = |reader: &SiteSetReader| reader.set().map(|set| set.state.view().head.plan_time_s);
    wait_for(&mut reader, "the first set", &|r| plan_time_s(r) == Some(1));
    let set = reader.set().unwrap();
    assert_eq!((set.grids.len(), set.mission_plan.is_some()), (2, false));

    // A mission plan of other grids has no part in it.
    let index_hash = set.index.content_hash();
    let state_hash = set.state.content_hash();
    let mission_plan = MissionPlanBuilder::new(
        MissionPlanHead { site_hash: set.site.content_hash(), ..bytemuck::Zeroable::zeroed() },
        0,
    );
    let mission_plan = mission_plan.finish();
    out.publish(|p| &p.mission_plans, &mission_plan, InputHashes { grids: ContentHash::from_bits(7), ..NONE });
    wait_for(&mut reader, "the mission plan of others", &|r| r.samples().mission_plan().is_some());
    assert!(reader.set().unwrap().mission_plan.is_none());
    out.publish(|p| &p.mission_plans, &mission_plan, InputHashes { grids: index_hash, ..NONE });
    wait_for(&mut reader, "the mission plan", &|r| r.set().is_some_and(|set| set.mission_plan.is_some()));

    // A newer state: there is no set until its index is there, and a storey that did not change is not sent again.
    out.publish(|p| &p.states, &late, NONE);
    wait_for(&mut reader, "the later state", &|r| r.set().is_none());
    let state = reader.state().unwrap();
    assert!(state.made(&InputHashes {
        site: state.site.content_hash(),
        schedule_state: state.state.content_hash(),
        ..NONE
    }));
    assert!(!state.made(&InputHashes { site: state.site.content_hash(), schedule_state: state_hash, ..NONE }));
    out.publish(|p| &p.indices, &index_of(&late, &[&changed, &upper]), NONE);
    out.publish(|p| &p.grids[0], &changed, NONE);
    wait_for(&mut reader, "the later set", &|r| plan_time_s(r) == Some(2));
    assert!(reader.set().unwrap().mission_plan.is_none(), "it was made from the grids before");

    // Another site: neither set nor state, and its index is not that of the site.
    out.publish(|p| &p.sites, &later, NONE);
    wait_for(&mut reader, "another site", &|r| r.state().is_none());
    assert!(reader.set().is_none());
    let samples = reader.samples();
    assert!(samples.index().is_some() && samples.index_of(samples.site().unwrap()).is_none());
}

#[test]
fn samples_that_are_taken_back_give_way_to_newer_ones() {
    let fixture = Fixture::shared();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    let mut out = Producers::on(&fixture);
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    let states = bus.raw_subscriber(bus::TopicName::ScheduleState).unwrap();
    let grids = bus.raw_subscriber(bus::TopicName::Grid(grid(1).0)).unwrap();
    let mut seen = |out: &mut Producers, samples: &mut SiteSamples, plan_time_s: i64| {
        out.publish(|p| &p.states, &state_of(&site("site"), plan_time_s), NONE);
        let sample = until(&mut waiter, "the state", || states.take().unwrap());
        samples.insert(SiteSample::check(sample).unwrap().unwrap());
        out.publish(|p| &p.grids[1], &grid_of(plan_time_s as i8), NONE);
        let sample = until(&mut waiter, "the grid", || grids.take().unwrap());
        samples.insert(SiteSample::check(sample).unwrap().unwrap());
    };
    let (mut earlier, mut newer, mut none) = (SiteSamples::default(), SiteSamples::default(), SiteSamples::default());
    seen(&mut out, &mut earlier, 1);
    seen(&mut out, &mut newer, 2);
    let of = |samples: &SiteSamples| samples.grid(grid(1).0).map(|grid| grid.view().planning[0]);
    newer.take_back(earlier);
    assert_eq!(of(&newer), Some(2));
    none.take_back(newer);
    assert_eq!((of(&none), none.grid(grid(0).0).is_some()), (Some(2), false));
}
