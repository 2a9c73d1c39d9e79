//! The topic of ifc-ingest: a site is in force once it is on disk, and is published as soon as there is room for it.

use bus::{Bus, topics};
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, Outputs, Published, chain};
use messages::{Checked, InputHashes, payload};
use std::sync::Arc;
use tracing::{info, warn};

/// The end of the topic.
pub struct SiteOutput {
    output: LatchedOutput<topics::Site>,
}

impl SiteOutput {
    /// Nothing was published yet.
    pub(crate) fn new() -> Self {
        Self { output: LatchedOutput::new(topics::Site) }
    }

    /// The site in force; none before the first.
    pub(crate) fn site(&self) -> Option<&Checked<payload::Site>> {
        self.output.last()
    }

    /// Hash and epoch of the site in force.
    pub(crate) fn published(&self) -> Published {
        self.output.published()
    }

    /// Makes a site the one that is published.
    pub(crate) fn put(&mut self, site: Arc<Checked<payload::Site>>, epochs: &mut Epochs) {
        let (n_bytes, frame_epoch) = (site.bytes().bytes().len(), u64::from(site.view().head.frame_epoch));
        let sample = NewSample { archive: site, frame_epoch, inputs: InputHashes::default() };
        match self.output.publish_for_good(epochs, sample) {
            Ok(()) => info!(service = "ifc-ingest", epoch = self.output.epoch(), bytes = n_bytes, "site published"),
            Err(why) => warn!(service = "ifc-ingest", error = chain(why.as_ref()), "the site has no room yet"),
        }
    }
}

impl<D: Decide> Outputs<D> for SiteOutput {
    type Publication = Arc<Checked<payload::Site>>;

    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        self.output.attach(bus, epochs)
    }

    fn publish(&mut self, site: Arc<Checked<payload::Site>>, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        self.put(site, epochs);
        Ok(())
    }

    fn settle(&mut self) {}

    fn go_back(&mut self, _: &D, _: &mut Epochs) {}

    fn retry(&mut self, _: &D, epochs: &mut Epochs) -> Result<bool, Failure> {
        let is_late = self.output.is_pending();
        self.output.retry(epochs).map(|()| is_late)
    }

    fn published(&self) -> Published {
        self.published()
    }
}
