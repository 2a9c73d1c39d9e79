//! Subscriptions to the topics of a site set.

use crate::site_set::{SiteSample, SiteSamples, SiteSet, SiteState};
use bus::{Bus, GridSlot, PortError, RawSubscriber, ReceiveError, TopicName};
use messages::ArchiveError;

/// Follows topics of a site set.
#[derive(Default)]
pub struct SiteReader(Vec<RawSubscriber>);

/// Follows the topics of a site set, and holds the newest sample of each.
pub struct SiteSetReader {
    reader: SiteReader,
    samples: SiteSamples,
}

/// Why the samples that have come cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SiteSetError {
    /// A sample cannot be taken.
    #[error(transparent)]
    Receive(#[from] ReceiveError),
    /// A sample is damaged.
    #[error("the sample of `{topic}` cannot be read")]
    Archive {
        /// Its topic.
        topic: TopicName,
        /// What is wrong.
        source: ArchiveError,
    },
}

impl SiteReader {
    /// A reader of all topics of whole sets.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub fn of_sets(bus: &Bus) -> Result<Self, PortError> {
        let of_site =
            [TopicName::Site, TopicName::Tasks, TopicName::ScheduleState, TopicName::Grids, TopicName::MissionPlan];
        Self::of_topics(bus, of_site.into_iter().chain(GridSlot::all().map(TopicName::Grid)))
    }

    /// A reader of grids, for who gets the other topics as its inputs.
    ///
    /// # Errors
    /// As [`Self::of_sets`].
    pub fn of_grids(bus: &Bus) -> Result<Self, PortError> {
        Self::of_topics(bus, GridSlot::all().map(TopicName::Grid))
    }

    fn of_topics(bus: &Bus, topics: impl IntoIterator<Item = TopicName>) -> Result<Self, PortError> {
        Ok(Self(topics.into_iter().map(|topic| bus.raw_subscriber(topic)).collect::<Result<_, _>>()?))
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged; what was taken before stays.
    pub fn take(&self, mut insert: impl FnMut(SiteSample)) -> Result<(), SiteSetError> {
        for subscriber in &self.0 {
            let Some(sample) = subscriber.take()? else { continue };
            let topic = sample.topic();
            let sample = SiteSample::check(sample).map_err(|source| SiteSetError::Archive { topic, source })?;
            sample.into_iter().for_each(&mut insert);
        }
        Ok(())
    }
}

impl SiteSetReader {
    /// A reader of whole sets.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub fn of(bus: &Bus) -> Result<Self, PortError> {
        Ok(Self { reader: SiteReader::of_sets(bus)?, samples: SiteSamples::default() })
    }

    /// A reader of sites and schedule states alone: there are no sets.
    ///
    /// # Errors
    /// As [`SiteSetReader::of`].
    pub fn of_states(bus: &Bus) -> Result<Self, PortError> {
        let reader = SiteReader::of_topics(bus, [TopicName::Site, TopicName::ScheduleState])?;
        Ok(Self { reader, samples: SiteSamples::default() })
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged; what was taken before stays.
    pub fn take(&mut self) -> Result<(), SiteSetError> {
        self.reader.take(|sample| self.samples.insert(sample))
    }

    /// The newest sample of each topic.
    pub fn samples(&self) -> &SiteSamples {
        &self.samples
    }

    /// The newest samples, if they belong together, tasks of schedule files included.
    pub fn set(&self) -> Option<SiteSet<'_>> {
        self.samples.set().filter(SiteSet::has_tasks)
    }

    /// The newest site and schedule state, if they belong together.
    pub fn state(&self) -> Option<SiteState<'_>> {
        self.samples.state()
    }
}
