//! Rooms, doors, drop-offs, waypoints and routes of a storey as markers.
//!
//! All lie in the plane z = 0 of their frame, as maps of Nav2 do. Each array begins with a marker that deletes those of
//! before, so that what vanishes from the building vanishes from the viewer; ids are the indices of what is drawn in the site or
//! the mission plan, and the same at every date.

mod doors;
mod drawing;
mod drop_offs;
mod rooms;
mod route;
mod waypoints;

pub use doors::doors;
pub use drawing::together;
pub use drop_offs::drop_offs;
pub use rooms::{Room, RoomState, each_room, rooms};
pub use route::route;
pub use waypoints::waypoints;
