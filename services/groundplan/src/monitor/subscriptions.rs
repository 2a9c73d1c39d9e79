//! Subscriptions of the monitor to all topics.

use super::map_pane::GridPixels;
use super::state::State;
use bus::{
    Bus, CheckedSample, GridSlot, PortError, RawSubscriber, ReceiveError, Stamp, StatusReader, Subscriber, Topic,
    TopicName, topics,
};
use daemon::facts::AlignmentSummary;
use messages::Checked;
use site_view::{SiteSample, SiteSamples};

/// Subscriptions to everything that is published; of each grid the newest sample is held.
pub(crate) struct Subscriptions {
    joined: Stamp,
    status: StatusReader,
    sites: Subscriber<topics::Site>,
    schedule_states: Subscriber<topics::ScheduleState>,
    indices: Subscriber<topics::Grids>,
    alignments: Subscriber<topics::Alignment>,
    /// Topics of which only the header is shown.
    others: Vec<RawSubscriber>,
    grids: Vec<Subscriber<topics::Grid>>,
    /// The grids that are shown.
    samples: SiteSamples,
}

/// The bus refuses.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SubscriptionError {
    /// An end cannot be opened.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A sample cannot be taken.
    #[error(transparent)]
    Receive(#[from] ReceiveError),
}

impl Subscriptions {
    pub(crate) fn to(bus: &Bus) -> Result<Self, PortError> {
        let others = [TopicName::MissionPlan, TopicName::SlamMap, TopicName::Deviations];
        Ok(Self {
            joined: Stamp::now(),
            status: bus.status_reader()?,
            sites: bus.subscriber(topics::Site)?,
            schedule_states: bus.subscriber(topics::ScheduleState)?,
            indices: bus.subscriber(topics::Grids)?,
            alignments: bus.subscriber(topics::Alignment)?,
            others: others.into_iter().map(|topic| bus.raw_subscriber(topic)).collect::<Result<_, _>>()?,
            grids: Vec::new(),
            samples: SiteSamples::default(),
        })
    }

    /// Number of storeys that are watched.
    pub(crate) fn n_storeys(&self) -> usize {
        self.grids.len()
    }

    /// The map of a storey, if its grid is there.
    pub(crate) fn map(&self, storey: usize) -> Option<GridPixels<'_>> {
        Some(GridPixels { grid: self.samples.grid(GridSlot::new(storey)?)?.view() })
    }

    /// Takes what has come; true if anything has.
    pub(crate) fn take(&mut self, bus: &Bus, state: &mut State) -> Result<bool, SubscriptionError> {
        let mut is_new = false;
        while let Some(record) = self.status.take()? {
            state.on_status(Stamp::now(), record);
            is_new = true;
        }
        // Damaged samples are not shown; their reader reports them.
        if let Some(site) = take_sample(&self.sites, self.joined, state, &mut is_new)? {
            let site = site.view();
            state.on_storey_names(site.map_storeys.iter().map(|s| site.text(s.name).to_owned()).collect());
        }
        if let Some(schedule_state) = take_sample(&self.schedule_states, self.joined, state, &mut is_new)? {
            state.on_schedule_state(Stamp::now(), &schedule_state.view());
        }
        if let Some(index) = take_sample(&self.indices, self.joined, state, &mut is_new)? {
            let n_storeys = index.view().slots.len();
            self.grids.truncate(n_storeys);
            self.samples.truncate_grids(n_storeys);
            for slot in GridSlot::all().take(n_storeys).skip(self.grids.len()) {
                self.grids.push(bus.subscriber(topics::Grid(slot))?);
            }
            state.on_index(Stamp::now(), &index.view());
        }
        if let Some(alignment) = take_sample(&self.alignments, self.joined, state, &mut is_new)? {
            state.on_alignment(AlignmentSummary::of(alignment.bytes().header().epoch, &alignment.view()));
        }
        for subscriber in &self.others {
            if let Some(sample) = subscriber.take()? {
                is_new = true;
                state.on_sample(Stamp::now(), self.joined, sample.topic(), *sample.header());
            }
        }
        for (slot, subscriber) in GridSlot::all().zip(&self.grids) {
            if let Some(grid) = take_sample(subscriber, self.joined, state, &mut is_new)? {
                let before = self.samples.grid(slot).map(Checked::view);
                state.on_grid(Stamp::now(), slot, grid.bytes().header().epoch, &grid.view(), before.as_ref());
                self.samples.insert(SiteSample::Grid(slot, grid));
            }
        }
        Ok(is_new)
    }
}

/// The newest sample of a topic, if one has come that is whole; its header is shown in any case.
fn take_sample<T: Topic>(
    subscriber: &Subscriber<T>,
    joined: Stamp,
    state: &mut State,
    is_new: &mut bool,
) -> Result<Option<CheckedSample<T>>, ReceiveError> {
    let Some(sample) = subscriber.take()? else { return Ok(None) };
    *is_new = true;
    state.on_sample(Stamp::now(), joined, subscriber.topic().name(), *sample.header());
    Ok(sample.check().ok())
}
