//! Subscriptions to what answers are made of, for each lane of its own: the samples of an answer that takes its time are not those
//! of answers at once.

use crate::site::{Lane, Site};
use bus::{Bus, GridSlot, RawSubscriber, TopicName};
use daemon::Failure;
use site_view::SiteSample;

/// Takes samples for all lanes.
pub(crate) struct Takers([(Lane, Vec<RawSubscriber>); 2]);

impl Takers {
    /// On a generation of the bus.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub(crate) fn of(bus: &Bus) -> Result<Self, Failure> {
        let subscribers = || {
            let of_site =
                [TopicName::Site, TopicName::Tasks, TopicName::ScheduleState, TopicName::Grids, TopicName::MissionPlan];
            let topics = of_site.into_iter().chain(GridSlot::all().map(TopicName::Grid));
            topics.map(|topic| bus.raw_subscriber(topic)).collect::<Result<_, _>>()
        };
        let [at_once, drawing] = Lane::ALL;
        Ok(Self([(at_once, subscribers()?), (drawing, subscribers()?)]))
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged; what was taken before stays.
    pub(crate) fn take(&self, site: &Site) -> Result<(), Failure> {
        for (lane, subscribers) in &self.0 {
            for subscriber in subscribers {
                if let Some(sample) = subscriber.take()? {
                    SiteSample::check(sample)?.into_iter().for_each(|sample| site.insert(*lane, sample));
                }
            }
        }
        Ok(())
    }
}
