//! Questions about a site that `way`, `room` and `door` answer: of model files, or of the running daemons.

mod args;
mod asked;
mod later;
mod models;
mod output_folder;
mod running;

pub(crate) use args::QuestionArgs;
pub(crate) use asked::{Answer, Question};

use crate::failure::Failure;
use crate::run::Outcome;

impl QuestionArgs {
    /// Answers a question.
    ///
    /// # Errors
    /// Bad arguments, names that stand for nothing, models that cannot be read, no daemons.
    pub(crate) fn answer<Q: Question>(&self, question: &Q) -> Result<Outcome, Failure> {
        if self.models.is_empty() { running::answer(self, question) } else { models::answer(self, question) }
    }
}
