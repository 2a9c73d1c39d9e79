//! Subscriptions to what answers are made of, for each lane of its own: the samples of an answer that takes its time are not those
//! of answers at once.

use crate::site::{Lane, Site};
use bus::Bus;
use daemon::Failure;
use site_view::SiteReader;

/// Takes samples for all lanes.
pub(crate) struct Takers([(Lane, SiteReader); 2]);

impl Takers {
    /// On a generation of the bus.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub(crate) fn of(bus: &Bus) -> Result<Self, Failure> {
        let [at_once, drawing] = Lane::ALL;
        Ok(Self([(at_once, SiteReader::of_sets(bus)?), (drawing, SiteReader::of_sets(bus)?)]))
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged; what was taken before stays.
    pub(crate) fn take(&self, site: &Site) -> Result<(), Failure> {
        for (lane, reader) in &self.0 {
            reader.take(|sample| site.insert(*lane, sample))?;
        }
        Ok(())
    }
}
