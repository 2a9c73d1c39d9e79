//! The topics of schedule-eval: the tasks of schedule files, on the bus before the states that follow them, and the schedule state.

use bus::topics;
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, OutputEnd, Outputs, Published};

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

    fn ends(&mut self) -> Vec<&mut dyn OutputEnd> {
        vec![&mut self.tasks, &mut self.state]
    }

    fn publish(&mut self, sample: ScheduleSample, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        match sample {
            ScheduleSample::Tasks(tasks) => self.tasks.publish(epochs, tasks),
            ScheduleSample::State(state) => self.state.publish(epochs, state),
        }
    }

    fn published(&self) -> Published {
        self.state.published()
    }
}
