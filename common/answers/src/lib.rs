//! Questions about a site, and one typed answer to each: for the client, the page and services.
//!
//! An answer is a function of archives that belong together ([`Situation`]) and of [`Circumstances`], which the caller takes from
//! the bus, or says of files: epochs, plan time, whether the maps may be used. No bus, no files, no processes, no clock. An answer
//! is serialized as a JSON document whose schema is made of its types, and has a text for people.
//!
//! | question | answer |
//! |---|---|
//! | how does this robot get from a room or point to another, over storeys, or what is missing | [`way()`], [`WayAnswer`] |
//! | where is a room, may this robot enter it, when does that change, what is in it | [`room()`], [`RoomAnswer`] |
//! | what stands and which rooms are open at a date, and how probable that is | [`states`] |
//! | what changes: at every change instant, between two dates, by a revision of the plan | [`changes`] |
//! | when the tasks are, what they act on, what is wrong with them | [`tasks`] |
//! | which scans a room has, what each sees, or why it has none | [`scans()`], [`ScansAnswer`] |
//! | what was found wrong, assumed, replaced or left out | [`findings`] |
//! | which processes of a site run, what they do and say, and whether its maps may be used | [`processes`] |
//! | which rooms may this robot enter, and why not the others | [`rooms()`], [`RoomsAnswer`] |
//! | when does a room open, by the schedule and for this robot | [`opening()`], [`OpeningAnswer`] |
//! | what did a robot see that differs from the plan | [`deviations`] |
//! | where is a door, can this robot pass it, when does that change | [`door()`], [`DoorAnswer`] |
//!
//! Rooms, doors and points are named as people name them ([`find_room`], [`find_door`], [`find_place`]); what is not found is an
//! error with the nearest names, of a storey with all storeys.
//!
//! Plan times are civil date-times of the site, lengths metres, coordinates those of `map`; keys of measures end with their unit,
//! and what there is not is null. What was not looked at is null, too, with the reason beside it: nothing is said that was not
//! checked.

pub mod changes;
pub mod deviations;
pub mod findings;
pub mod processes;
pub mod states;
pub mod tasks;

mod circumstances;
mod closed_by;
mod dated_task;
mod door;
mod door_text;
mod find;
mod later;
mod missing;
mod named;
mod opening;
mod room;
mod room_access;
mod room_text;
mod rooms;
mod scans;
mod situation;
mod way;
mod way_text;

pub use circumstances::{AnswerBasis, Circumstances, Epochs, MapUse};
pub use dated_task::DatedTask;
pub use door::{DoorAnswer, DoorReason, RoomBeside, can_pass, door, passage_of};
pub use find::{FindError, FoundPlace, find_door, find_element, find_place, find_room, find_storey};
pub use findings::Finding;
pub use later::Later;
pub use missing::Missing;
pub use named::{ElementRef, RoomRef, StoreyRef, TaskRef, date_text, optional_date_text};
pub use opening::{OpeningAnswer, opening};
pub use room::{ClosedBy, DoorOfRoom, RoomAnswer, RoomPeriod, ScanOfRoom, room, state_for_robot};
pub use room_access::{RoomAccess, may_enter};
pub use rooms::{RoomsAnswer, rooms};
pub use scans::{ScanPose, ScansAnswer, scans};
pub use situation::Situation;
pub use way::{DoorOnWay, PlaceAnswer, WayAnswer, WayLegAnswer, way, way_exists};
