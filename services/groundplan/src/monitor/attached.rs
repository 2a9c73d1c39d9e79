//! The monitor's ends of the bus.

use super::map_pane::MapOf;
use super::state::State;
use crate::alignment_report::Brief;
use bus::{Bus, GridSlot, PortError, ReceiveError, Sample, Stamp, StatusReader, Subscriber, Topic};
use messages::{Grid, Grids, Phase, Site};

/// Subscriptions to everything that is published; of each grid the newest sample is held.
pub(crate) struct Attached {
    joined: Stamp,
    status: StatusReader,
    others: Vec<Subscriber>,
    slots: Vec<(Subscriber, Option<Sample>)>,
}

/// The bus refuses.
#[derive(Debug, thiserror::Error)]
pub(crate) enum AttachError {
    /// An end cannot be opened.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A sample cannot be taken.
    #[error(transparent)]
    Receive(#[from] ReceiveError),
}

impl Attached {
    pub(crate) fn to(bus: &Bus) -> Result<Self, PortError> {
        let topics = Topic::all().filter(|topic| !matches!(topic, Topic::Grid(_)));
        let others = topics.map(|topic| bus.subscriber(topic)).collect::<Result<_, _>>()?;
        Ok(Self { joined: Stamp::now(), status: bus.status_reader()?, others, slots: Vec::new() })
    }

    /// Number of storeys that are watched.
    pub(crate) fn n_storeys(&self) -> usize {
        self.slots.len()
    }

    /// The map of a storey, if its grid is there.
    pub(crate) fn map(&self, storey: usize) -> Option<MapOf<'_>> {
        let sample = self.slots.get(storey)?.1.as_ref()?;
        // It was validated when it came.
        Grid::open(sample.bytes()).ok().map(|grid| MapOf { grid })
    }

    /// Takes what has come; true if anything has.
    pub(crate) fn take(&mut self, bus: &Bus, state: &mut State) -> Result<bool, AttachError> {
        let mut is_new = false;
        while let Some(record) = self.status.take()? {
            state.see_status(Stamp::now(), record);
            is_new = true;
        }
        for subscriber in &self.others {
            let Some(sample) = subscriber.take()? else { continue };
            is_new = true;
            let now = Stamp::now();
            state.see_sample(now, self.joined, subscriber.topic(), *sample.header());
            // What is damaged is not shown; its reader says so.
            match subscriber.topic() {
                Topic::Site => {
                    if let Ok(site) = Site::open(sample.bytes()) {
                        state.see_names(site.map_storeys.iter().map(|s| site.text(s.name).to_owned()).collect());
                    }
                }
                Topic::Phase => {
                    if let Ok(phase) = Phase::open(sample.bytes()) {
                        state.see_phase(now, &phase);
                    }
                }
                Topic::Alignment => {
                    if let Some(alignment) = Brief::of(sample.header().epoch, sample.bytes()) {
                        state.see_alignment(alignment);
                    }
                }
                _ => {
                    if let Ok(index) = Grids::open(sample.bytes()) {
                        self.slots.truncate(index.slots.len());
                        for slot in GridSlot::all().take(index.slots.len()).skip(self.slots.len()) {
                            self.slots.push((bus.subscriber(Topic::Grid(slot))?, None));
                        }
                        state.see_index(&index);
                    }
                }
            }
        }
        for (slot, (subscriber, held)) in GridSlot::all().zip(&mut self.slots) {
            let Some(sample) = subscriber.take()? else { continue };
            is_new = true;
            state.see_sample(Stamp::now(), self.joined, subscriber.topic(), *sample.header());
            if let Ok(grid) = Grid::open(sample.bytes()) {
                let before = held.as_ref().and_then(|before| Grid::open(before.bytes()).ok());
                state.see_grid(slot, sample.header().epoch, &grid, before.as_ref());
                *held = Some(sample);
            }
        }
        Ok(is_new)
    }
}
