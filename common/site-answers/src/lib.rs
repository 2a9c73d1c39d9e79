//! Answers of a running site: of the maps that it publishes, of maps of other dates that are drawn for an answer, and when an
//! answer changes. For the client, the page and the service of questions.
//!
//! `answers` makes an answer of archives that belong together; here are the archives: those of the bus with the circumstances that
//! they come in ([`circumstances_of`], [`map_use`]), or maps that are drawn for an answer ([`Drawing`]). A question with a yes or
//! a no ([`Question`]) is asked in the same way of either, and of model files.
//!
//! # Guarantees
//!
//! - Nothing is published, and nothing is written.
//! - An answer at another date is drawn with the robot, the resolution and the options of the mission plan that are in force;
//!   where one of these is not known here, that is the answer ([`start_is_known`], `site-schedule`).
//! - When an answer changes is searched at every later change of the schedule in turn. A search that is stopped says up to which
//!   change it came.

mod circumstances;
mod dates;
mod difference;
mod draw_error;
mod drawing;
mod fleet;
mod kept_rasterizer;
mod later;
mod maps;
mod progress;
mod question;
mod questions;

pub use circumstances::{circumstances_of, epochs_of, map_use, options_of, start_is_known};
pub use dates::{PeriodError, end_s, period_of};
pub use difference::difference_between;
pub use draw_error::DrawError;
pub use drawing::{Drawing, situation_of};
pub use fleet::{FleetError, fleet_document};
pub use kept_rasterizer::KeptRasterizer;
pub use maps::{MapInputs, Maps, with_maps, with_maps_once};
pub use progress::{DrawingProgress, Silent};
pub use question::{Answer, Question};
pub use questions::{
    DoorQuestion, FindingsQuestion, OpeningQuestion, RoomQuestion, RoomsQuestion, ScansQuestion, WayQuestion,
};
