//! Topics about a building model as BCF files: written and read, versions 2.1 and 3.0. No site, no file of the system, no clock.
//!
//! [`written`] makes a container of [`Topic`]s with camera, components, lines, picture and comments. [`Container`] is one that
//! somebody else may have written: its topics are read, topics are closed and added in it, and all else stays as it is.
//!
//! # Guarantees
//!
//! - The same topics give the same bytes: files of a container have no time of their own.
//! - What is read is limited before memory is taken: files, bytes of each and of all, topics ([`BcfError`]).
//! - Closing a topic changes its status and the time and author of its last change, and adds a comment; everything else of its
//!   markup is copied event by event, what no version of BCF has included.
//!
//! # Source
//! buildingSMART, BIM Collaboration Format 2.1 and 3.0: `version.xsd`, `markup.xsd`, `visinfo.xsd`, `extensions.xsd`.
//!
//! # Where
//!
//! - differences of the versions: `src/markup.rs`, `src/viewpoint.rs`; reading: `src/reading.rs`; closing: `src/closing.rs`

mod closing;
mod container;
mod guid;
mod markup;
mod reading;
mod topic;
mod viewpoint;
mod xml;

pub use container::{BcfError, Container, written};
pub use guid::{is_global_id, uuid};
pub use topic::{BcfVersion, Camera, Comment, Component, Snapshot, Topic, Viewpoint};
