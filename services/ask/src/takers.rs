//! Subscriptions to what answers are made of, for each lane of its own: the samples of an answer that takes its time are not those
//! of answers at once.

use crate::site::{Lane, Site};
use bus::Bus;
use daemon::Failure;
use site_view::SiteReader;

/// Takes samples for all lanes. What is answered at once is known to answers that draw, too: whoever saw maps in the one asks the
/// other next.
pub(crate) struct Takers {
    at_once: SiteReader,
    drawing: SiteReader,
}

impl Takers {
    /// On a generation of the bus.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub(crate) fn of(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self { at_once: SiteReader::of_sets(bus)?, drawing: SiteReader::of_sets(bus)? })
    }

    /// Takes what has come.
    ///
    /// # Errors
    /// A sample that cannot be taken, or is damaged; what was taken before stays.
    pub(crate) fn take(&self, site: &Site) -> Result<(), Failure> {
        // Read first and shown last, so that the other lane is never behind.
        let mut samples = Vec::new();
        let at_once = self.at_once.take(|sample| samples.push(sample));
        let drawing = self.drawing.take(|sample| site.insert(Lane::Drawing, sample));
        samples.into_iter().for_each(|sample| site.insert(Lane::AtOnce, sample));
        Ok(at_once.and(drawing)?)
    }
}
