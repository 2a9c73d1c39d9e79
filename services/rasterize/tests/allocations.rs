//! The steady loop from schedule state to grids index allocates nothing after one pass through all states; iceoryx2 allocates one
//! block of about 100 bytes per loan.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../../common/stages/raster/tests/support/mod.rs"]
mod support;

use bus::{Bus, CheckedSample, Daemon, Domain, Keeper, Origin, Publisher, Subscriber, Topic, Waiter, topics};
use daemon::{CurrentActivity, Event, Service, SiteConfig};
use grid::Class;
use messages::*;
use rasterize::service::{Rasterize, RasterizeInput};
use support::House;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// The house with furniture, a door, rooms, and floor in two parts.
fn house() -> ArchiveBuffer {
    let mut house = House::new();
    for k in 0..6 {
        let at = 0.3 + 0.5 * f64::from(k);
        house.add(Class::Furniture, [at, 0.5, 0.0], [at + 0.4, 0.9, 1.0]);
    }
    house.slab([-0.2, -1.5], [4.2, -0.2], 0.0);
    house.add(Class::Mep, [1.0, 1.0, 2.2], [2.0, 2.0, 2.4]);
    house.opening(0);
    house.door(0.8, DoorCapability::Swing);
    house.space([0.0, 0.0], [2.0, 3.0]);
    house.space([2.0, 0.0], [4.0, 3.0]);
    house.builder.spaces.iter_mut().for_each(|s| s.map_storey = 0);
    house.site()
}

/// A walk in which every element and every space changes: walls, floor, doors, work overhead.
fn schedule_states(site: &Site<'_>) -> Vec<ArchiveBuffer> {
    let (n, n_spaces) = (site.elements.len(), site.spaces.len());
    let schedule_state = |step: usize| {
        let mut schedule_state = ScheduleStateBuilder::everything_built(site.content_hash(), n, n_spaces);
        schedule_state.head.plan_time_s = step as i64;
        (0..n).for_each(|k| schedule_state.effective[k] = ElementState::ALL[(k * 7 + step) % 5].into());
        (0..n_spaces).for_each(|k| schedule_state.spaces[k].state = SpaceState::ALL[(k + step) % 2].into());
        schedule_state.finish()
    };
    (0..20).map(schedule_state).collect()
}

/// A producer that is looked after whenever something is to come from it.
struct Producer<T> {
    publisher: Publisher<T>,
    waiter: Waiter,
    epoch: u64,
}

impl<T: Topic> Producer<T> {
    fn of(domain: &Domain, daemon: Daemon, topic: T) -> Self {
        let (bus, waiter) = Bus::join(domain, daemon).unwrap();
        Self { publisher: bus.publisher(topic, 1 << 16).unwrap(), waiter, epoch: 0 }
    }

    fn publish(&mut self, archive: &ArchiveBuffer) {
        self.waiter.wait(std::time::Duration::ZERO).unwrap();
        self.epoch += 1;
        let origin = Origin { epoch: self.epoch, frame_epoch: 1, inputs: InputHashes::default() };
        let sent = self.publisher.publish_copy(archive.bytes(), origin).unwrap();
        assert_eq!(sent.n_subscribers, 1, "{:?}", self.publisher.topic());
    }
}

fn take<T: Topic>(subscriber: &Subscriber<T>) -> CheckedSample<T> {
    subscriber.take().unwrap().expect("it was just published").check().unwrap()
}

#[test]
fn a_schedule_state_that_was_seen_before_costs_no_allocation_but_one_of_the_bus_library_per_sample() {
    // As in a daemon: the service lives on a thread of the pool that it works on.
    rayon::ThreadPoolBuilder::new().build().unwrap().install(walk_twice);
}

fn walk_twice() {
    let home = tempfile::tempdir().unwrap();
    let root = tempfile::Builder::new().prefix("alloc").tempdir_in("/dev/shm").unwrap();
    let prefix = format!("ga{:x}_", std::process::id());
    let domain = Domain::shared(&prefix, root.path()).unwrap();
    let keeper = Keeper::start(&domain).unwrap();
    let text = format!("state = \".\"\n[bus]\nprefix = {prefix:?}\nroot = {:?}\n", root.path());
    let config = SiteConfig::parse(&text, home.path()).unwrap();
    let site = house();
    let mut sites = Producer::of(&domain, Daemon::IfcIngest, topics::Site);
    let mut schedule_states_out = Producer::of(&domain, Daemon::ScheduleEval, topics::ScheduleState);
    let (bus, _waiter) = Bus::join(&domain, Daemon::Rasterize).unwrap();
    let (sites_in, schedule_states_in) =
        (bus.subscriber(topics::Site).unwrap(), bus.subscriber(topics::ScheduleState).unwrap());
    let mut service = Rasterize::start(&config, CurrentActivity::default()).unwrap();
    service.attach(&bus).unwrap();
    sites.publish(&site);
    service.handle(Event::Input(RasterizeInput::Site(take(&sites_in)))).unwrap();

    let schedule_states = schedule_states(&Site::open(site.bytes()).unwrap());
    let mut epoch = 0;
    // Allocations and samples of each schedule state.
    let mut walk = || -> Vec<[u64; 2]> {
        let blocks = |archive: &ArchiveBuffer| {
            schedule_states_out.publish(archive);
            let before = dhat::HeapStats::get().total_blocks;
            let done = service.handle(Event::Input(RasterizeInput::ScheduleState(take(&schedule_states_in)))).unwrap();
            let allocations = dhat::HeapStats::get().total_blocks - before;
            let samples = done.published.epoch - std::mem::replace(&mut epoch, done.published.epoch);
            [allocations, samples]
        };
        schedule_states.iter().map(blocks).collect()
    };
    let _profiler = dhat::Profiler::builder().testing().build();
    let first = walk();
    assert!(first.iter().map(|[allocations, _]| allocations).sum::<u64>() > 200, "it makes what is kept: {first:?}");
    let second = walk();
    assert!(second.iter().all(|[allocations, samples]| allocations == samples && *samples == 2), "{second:?}");
    drop((service, bus, sites, schedule_states_out, sites_in, schedule_states_in, keeper));
    // The bus library leaves a few bytes behind.
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&config.bus.prefix) {
            std::fs::remove_file(entry.path()).unwrap();
        }
    }
}
