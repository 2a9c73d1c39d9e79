//! States of elements and rooms by the schedule, at a date or over a period.

mod document;
mod list;
mod probability;
mod text;

pub use document::{States, WholeDay, states, whole_day};
pub use list::{ElementAtDate, RoomAtDate, StatesAnswer, WantedElements, state_list};
pub use probability::StateProbabilities;
pub use text::text_of;
