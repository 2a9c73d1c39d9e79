//! The outcome of a command whose result is an answer.

use crate::failure::Failure;
use crate::run::Outcome;
use answers::findings::FindingsAnswer;
use answers::{DoorAnswer, RoomAnswer, ScansAnswer, WayAnswer};
use site_answers::Answer;

/// Exit code of an answer that is no.
const NO: u8 = 3;
/// Exit code of an answer of maps that may not be used.
const MAPS_NOT_USABLE: u8 = 4;

/// An answer that a command prints.
pub(crate) trait AnswerText: Answer {
    /// For people.
    fn text(&self) -> String;
}

macro_rules! texts {
    ($($answer:ty),*) => {
        $(impl AnswerText for $answer {
            fn text(&self) -> String {
                self.text()
            }
        })*
    };
}

texts!(DoorAnswer, FindingsAnswer, RoomAnswer, ScansAnswer, WayAnswer);

/// The outcome of a command whose result is an answer.
///
/// # Errors
/// An answer that cannot be written as JSON.
pub(super) fn outcome_of(answer: &impl AnswerText, json: bool) -> Result<Outcome, Failure> {
    let outcome = if json { Outcome::json(answer)? } else { Outcome::from(answer.text()) };
    let exit_code = match answer.verdict() {
        _ if !answer.circumstances().may_be_used() => MAPS_NOT_USABLE,
        Some(true) => 0,
        Some(false) | None => NO,
    };
    Ok(Outcome { exit_code, ..outcome })
}
