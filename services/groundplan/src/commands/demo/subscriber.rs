//! A subscriber of the demo: it has the newest maps, and measures how long a request takes until new ones are there.

use super::look::Look;
use super::processes::{Processes, stopped};
use crate::failure::Failure;
use crate::wait::Expectation;
use bus::{Bus, Daemon, Subscriber, Waiter, topics};
use daemon::{Answer, Client, ScheduleRequest};
use messages::{ContentHash, Grids};
use site_view::SiteSetReader;
use std::time::{Duration, Instant};

/// Interval at which processes are looked at while nothing comes.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Timeout of new maps.
const TIMEOUT: Duration = Duration::from_secs(300);

/// A client of the bus that follows the maps, and sends requests.
pub(super) struct MapSubscriber {
    reader: SiteSetReader,
    indices: Subscriber<topics::Grids>,
    client: Client<ScheduleRequest>,
    waiter: Waiter,
}

impl MapSubscriber {
    /// On a bus.
    ///
    /// # Errors
    /// The bus refuses.
    pub(super) fn of(bus: &Bus, waiter: Waiter) -> Result<Self, Failure> {
        let reader = SiteSetReader::of(bus).map_err(Failure::work)?;
        let indices = bus.subscriber(topics::Grids).map_err(Failure::work)?;
        let client = Client::of(bus).map_err(Failure::work)?;
        Ok(Self { reader, indices, client, waiter })
    }

    /// The maps, once site, schedule state and grids are there that belong together: of a schedule state if one is named, with the mission
    /// plan if it is wanted.
    ///
    /// # Errors
    /// They do not come, with the reason; a stop.
    pub(super) fn look(
        &mut self,
        processes: &mut Processes,
        state: Option<ContentHash>,
        with_mission_plan: bool,
    ) -> Result<Look, Failure> {
        let maker = if with_mission_plan { Daemon::WaypointGen } else { Daemon::Rasterize };
        let mut expectation = Expectation::of(processes.config(), maker);
        loop {
            self.reader.take().map_err(Failure::work)?;
            let set = self.reader.set().filter(|set| state.is_none_or(|state| set.state.content_hash() == state));
            if let Some(set) = set.filter(|set| !with_mission_plan || set.mission_plan.is_some()) {
                return Ok(Look::of(&set.views().map_err(Failure::work)?));
            }
            expectation.check()?;
            self.wait(processes)?;
        }
    }

    /// Sends a request, and waits until the index of the maps of its schedule state is here: the schedule state, and how long that took from
    /// the request on.
    ///
    /// # Errors
    /// A request that is refused, no new maps, a stop.
    pub(super) fn change(
        &mut self,
        processes: &mut Processes,
        request: &ScheduleRequest,
    ) -> Result<(ContentHash, Duration), Failure> {
        while self.indices.take().map_err(Failure::work)?.is_some() {}
        let begun = Instant::now();
        let open = self.client.send(request).map_err(Failure::work)?;
        let (mut state, mut arrived): (Option<ContentHash>, Vec<(ContentHash, Duration)>) = (None, Vec::new());
        loop {
            // The maps may be here before the answer.
            while let Some(index) = self.indices.take().map_err(Failure::work)? {
                let elapsed = begun.elapsed();
                arrived.push((Grids::open(index.bytes())?.head.schedule_state_hash, elapsed));
            }
            if state.is_none()
                && let Some(Answer::Done(answer)) = open.take().map_err(Failure::work)?
            {
                state = Some(answer.state.content_hash);
            }
            if let Some(found) = arrived.iter().find(|(hash, _)| Some(*hash) == state) {
                return Ok(*found);
            }
            if begun.elapsed() > TIMEOUT {
                return Err(Failure::work("no new maps have come"));
            }
            self.wait(processes)?;
        }
    }

    fn wait(&mut self, processes: &mut Processes) -> Result<(), Failure> {
        let wake = self.waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        if wake.stopped {
            return Err(stopped());
        }
        if wake.timed_out() {
            processes.check()?;
        }
        Ok(())
    }
}
