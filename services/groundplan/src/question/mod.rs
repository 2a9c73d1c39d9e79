//! Questions about a site that `way`, `room` and `door` answer: of model files, or of the running daemons.

mod args;
mod models;
mod outcome;
mod output_folder;
mod running;

pub(crate) use args::QuestionArgs;
pub(crate) use outcome::AnswerText;

use crate::failure::Failure;
use crate::run::Outcome;
use site_answers::Question;

impl QuestionArgs {
    /// Answers a question, which this command asks with what it is about.
    ///
    /// # Errors
    /// Bad arguments, names that stand for nothing, models that cannot be read, no daemons.
    pub(crate) fn answer<Q: Question<Answer: AnswerText>>(
        &self,
        question: &Q,
        command: &[&str],
    ) -> Result<Outcome, Failure> {
        if self.models.is_empty() { running::answer(self, question) } else { models::answer(self, question, command) }
    }
}
