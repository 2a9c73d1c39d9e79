//! The topics of schedule-eval: the tasks of schedule files, on the bus before the states that follow them, and the schedule state.

use bus::{Bus, topics};
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, Outputs, Published};

/// The ends of the topics.
pub struct ScheduleOutputs {
    pub(crate) tasks: LatchedOutput<topics::Tasks>,
    pub(crate) state: LatchedOutput<topics::ScheduleState>,
}

/// What can be published.
pub enum ScheduleSample {
    /// The tasks of schedule files.
    Tasks(NewSample<topics::Tasks>),
    /// The schedule state.
    State(NewSample<topics::ScheduleState>),
}

impl Default for ScheduleOutputs {
    fn default() -> Self {
        Self { tasks: LatchedOutput::new(topics::Tasks), state: LatchedOutput::new(topics::ScheduleState) }
    }
}

impl<D: Decide> Outputs<D> for ScheduleOutputs {
    type Publication = ScheduleSample;

    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        self.tasks.attach(bus, epochs)?;
        self.state.attach(bus, epochs)
    }

    fn publish(&mut self, sample: ScheduleSample, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        match sample {
            ScheduleSample::Tasks(tasks) => self.tasks.publish(epochs, tasks),
            ScheduleSample::State(state) => self.state.publish(epochs, state),
        }
    }

    fn settle(&mut self) {
        self.tasks.settle();
        self.state.settle();
    }

    fn go_back(&mut self, _: &D, epochs: &mut Epochs) {
        self.tasks.go_back(epochs);
        self.state.go_back(epochs);
    }

    fn retry(&mut self, _: &D, epochs: &mut Epochs) -> Result<bool, Failure> {
        let is_late = self.tasks.is_pending() || self.state.is_pending();
        self.tasks.retry(epochs)?;
        self.state.retry(epochs)?;
        Ok(is_late)
    }

    fn published(&self) -> Published {
        self.state.published()
    }
}
