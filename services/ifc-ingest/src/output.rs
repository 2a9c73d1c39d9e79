//! The topics of ifc-ingest: a site is in force once it is on disk, and is published as soon as there is room for it; a candidate is
//! there while it is judged.

use bus::{Bus, topics};
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, OutputEnd, Outputs, Published, chain};
use messages::{Checked, InputHashes, payload};
use std::sync::Arc;
use tracing::{info, warn};

/// What is published.
pub enum SiteSample {
    /// The site in force.
    InForce(Arc<Checked<payload::Site>>),
    /// A revision that is not in force.
    Candidate(Arc<Checked<payload::Site>>),
    /// It is judged.
    NoCandidate,
}

/// The ends of the topics.
pub struct SiteOutput {
    output: LatchedOutput<topics::Site>,
    candidate: LatchedOutput<topics::Candidate>,
    /// Of candidates: those of sites count what was in force.
    candidate_epochs: Epochs,
}

impl SiteOutput {
    /// Nothing was published yet.
    pub(crate) fn new(candidate_epochs: Epochs) -> Self {
        let (output, candidate) = (LatchedOutput::new(topics::Site), LatchedOutput::new(topics::Candidate));
        Self { output, candidate, candidate_epochs }
    }

    /// The site in force; none before the first.
    pub(crate) fn site(&self) -> Option<&Checked<payload::Site>> {
        self.output.last()
    }

    /// True while a candidate is on the bus.
    pub(crate) fn has_candidate(&self) -> bool {
        self.candidate.last().is_some()
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
    type Publication = SiteSample;

    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        self.candidate.attach(bus, &mut self.candidate_epochs)?;
        self.output.attach(bus, epochs)
    }

    fn publish(&mut self, sample: SiteSample, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        match sample {
            SiteSample::InForce(site) => self.put(site, epochs),
            SiteSample::Candidate(archive) => {
                let frame_epoch = u64::from(archive.view().head.frame_epoch);
                let sample = NewSample { archive, frame_epoch, inputs: InputHashes::default() };
                self.candidate.publish(&mut self.candidate_epochs, sample)?;
            }
            SiteSample::NoCandidate => self.candidate.withdraw(),
        }
        Ok(())
    }

    fn settle(&mut self) {
        self.candidate.settle();
    }

    fn go_back(&mut self, _: &D, _: &mut Epochs) {
        self.candidate.go_back(&mut self.candidate_epochs);
    }

    fn retry(&mut self, _: &D, epochs: &mut Epochs) -> Result<bool, Failure> {
        let is_late = self.output.is_pending();
        self.candidate.retry(&mut self.candidate_epochs)?;
        self.output.retry(epochs).map(|()| is_late)
    }

    fn published(&self) -> Published {
        self.published()
    }
}
