//! Subscriptions of the watch beside the maps: heartbeats, the newest schedule state, the newest index of grids.

use crate::failure::Failure;
use bus::{Bus, Daemon, Stamp, StatusReader, Subscriber, topics};
use site_view::Freshness;

/// Subscriptions of a generation of the bus.
pub(super) struct Subscriptions {
    heartbeats: StatusReader,
    schedule_states: Subscriber<topics::ScheduleState>,
    indices: Subscriber<topics::Grids>,
}

impl Subscriptions {
    /// # Errors
    /// A topic that cannot be opened.
    pub(super) fn to(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self {
            heartbeats: bus.status_reader().map_err(Failure::work)?,
            schedule_states: bus.subscriber(topics::ScheduleState).map_err(Failure::work)?,
            indices: bus.subscriber(topics::Grids).map_err(Failure::work)?,
        })
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged.
    pub(super) fn take(&self, freshness: &mut Freshness) -> Result<(), Failure> {
        while let Some(record) = self.heartbeats.take().map_err(Failure::work)? {
            if let Some(daemon) = Daemon::from_id(record.daemon) {
                freshness.on_heartbeat(Stamp::now(), daemon);
            }
        }
        if let Some(sample) = self.schedule_states.take().map_err(Failure::work)? {
            let state = sample.check().map_err(Failure::work)?;
            freshness.on_schedule_state(Stamp::now(), state.content_hash(), state.view().head);
        }
        if let Some(sample) = self.indices.take().map_err(Failure::work)? {
            let index = sample.check().map_err(Failure::work)?;
            freshness.on_index(Stamp::now(), index.view().head, index.view().slots.to_vec());
        }
        Ok(())
    }
}
