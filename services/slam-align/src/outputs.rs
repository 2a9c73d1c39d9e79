//! The topics of slam-align, and the table of observed progress that schedule-eval has from it.

use crate::observed_table::ObservedTable;
use bus::topics;
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, OutputEnd, Outputs, Published};

/// The ends of the topics.
pub struct AlignOutputs {
    pub(crate) alignment: LatchedOutput<topics::Alignment>,
    pub(crate) deviations: LatchedOutput<topics::Deviations>,
    observed: ObservedTable,
}

/// What can be published.
pub enum AlignSample {
    /// The pose, and what it is worth.
    Alignment(NewSample<topics::Alignment>),
    /// What differs.
    Deviations(NewSample<topics::Deviations>),
    /// Observed progress.
    Observed {
        /// Its table.
        table: String,
        /// A client waits until it is in force.
        is_asked: bool,
    },
}

impl AlignOutputs {
    pub(crate) fn new(observed: ObservedTable) -> Self {
        let (alignment, deviations) = (LatchedOutput::new(topics::Alignment), LatchedOutput::new(topics::Deviations));
        Self { alignment, deviations, observed }
    }
}

impl<D: Decide> Outputs<D> for AlignOutputs {
    type Publication = AlignSample;

    fn ends(&mut self) -> Vec<&mut dyn OutputEnd> {
        vec![&mut self.alignment, &mut self.deviations, &mut self.observed]
    }

    fn publish(&mut self, sample: AlignSample, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        match sample {
            AlignSample::Alignment(alignment) => self.alignment.publish(epochs, alignment),
            AlignSample::Deviations(deviations) => self.deviations.publish(epochs, deviations),
            AlignSample::Observed { table, is_asked } => self.observed.set(table, is_asked),
        }
    }

    fn published(&self) -> Published {
        self.alignment.published()
    }
}
