//! Checks that a model is fit for a robot: lists faults of its maps with their causes, element by element, each with its effect.
//!
//! [`check`] is a function of a situation as all answers are: the site with its diagnostics, the schedule state, the grids, the
//! mission plan. Its result is a document for programs ([`ModelCheck`]) and a page for people ([`ModelCheck::text`]). What
//! diagnostics of the stages say is grouped by cause, and not looked for twice; checks of geometry come on top.
//!
//! # Guarantees
//!
//! - Faults of the model are apart from what this robot cannot pass in a building that is modelled well, and those that change maps
//!   from those that do not ([`IssueKind`]): a narrow door is no fault.
//! - Rooms that cannot be reached are told of the cause without which a way would lead there: doors are opened, and gaps of floors
//!   closed, on the parts of floor between which the robot does not get (`src/regions.rs`).
//! - It says what was checked and what was not.
//! - A function of its input: no clock, no files, no order of hash maps.
//!
//! # Where
//!
//! - causes: their codes, words and advice: `src/causes.rs`
//! - doors and openings: `src/doors.rs`; rooms: `src/rooms.rs`; floors: `src/floors.rs`; walls: `src/walls.rs`
//! - copies and storeys of elements: `src/elements.rs`; storeys: `src/storeys.rs`
//! - diagnostics by cause, missing data: `src/input_faults.rs`
//! - the page in HTML: `src/html.rs`; pictures: `src/picture.rs`; BCF topics: `src/topics.rs`
//! - what is out of reach for a cause: `src/regions.rs`, `src/rooms.rs`

mod causes;
mod check;
mod document;
mod doors;
mod elements;
mod evidence;
mod floors;
mod html;
mod input_faults;
mod picture;
mod regions;
mod rooms;
mod storeys;
mod text;
mod topics;
mod walls;

pub use causes::{IssueCode, IssueKind};
pub use check::check;
pub use document::{AffectedRoom, Effect, Issue, IssueElement, ModelCheck, ModelFigures, NotChecked, Place};
pub use html::page;
pub use picture::StoreyPicture;
pub use topics::topics;
