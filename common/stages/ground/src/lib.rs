//! Ground: a site and a schedule state in, the surface that can be walked or driven on out.
//!
//! The surface is triangles in `map`, each with its ground class, its slope, the element or terrain that carries it and the connected
//! surface that it is a part of; and where one gets from a surface to another. It is for no robot in particular: no headroom is looked
//! at, no obstacle and no limit of a robot but a bound of steepness ([`MAX_SLOPE_RAD`]).
//!
//! What the site alone decides is made once, as a [`SiteGround`]: the upward faces of each body, and which parts of them which other
//! body covers. A schedule state selects from that. [`ground`] does both.
//!
//! # Guarantees
//!
//! - What is ground is decided by `ingest` alone ([`messages::GroundClass`]); nothing is told from names or shapes here.
//! - A body carries somebody once it is built, as on maps; the shape of a site or road itself is always there.
//! - No place is twice in the surface within 2 cm of height: of faces that lie as near above each other the upper one stays, of faces
//!   at one height that of the body that comes later in the site. A face on which the underside of another body of ground rests is
//!   covered, however thick that body is.
//! - Faces are counter-clockwise from above. Those of open terrain count whichever way the file turns them; those of a solid only where
//!   they look up.
//! - Treads of stairs and decks of scaffolds are level, and larger than 2 dm2.
//! - The result is a function of site and schedule state: no clock, no threads, no order of hash maps.
//!
//! # Where
//!
//! - ground: which faces of a body: `src/upward_faces.rs`
//! - ground: what covers what: `src/covers.rs`, `src/overlap.rs`
//! - ground: surfaces and connections: `src/surfaces.rs`, `src/contacts.rs`, `src/connections.rs`

mod box_tree;
mod connections;
mod contacts;
mod covers;
mod overlap;
mod plane;
mod selected_face;
mod site_ground;
mod surfaces;
mod upward_faces;
mod visible_faces;

pub use contacts::MAX_STEP_M;
pub use site_ground::SiteGround;
pub use upward_faces::{MAX_SLOPE_RAD, upward_faces};

use messages::{GroundWriter, OtherSite, ScheduleState, Site};

/// The ground of a site at a schedule state.
///
/// # Errors
/// A schedule state of another site.
pub fn ground(site: &Site<'_>, schedule_state: &ScheduleState<'_>, out: &mut GroundWriter) -> Result<(), OtherSite> {
    SiteGround::of(site).at(site, schedule_state, out)
}
