//! Points and rigid motions with their frame in the type, the length unit of archives, plan time.
//!
//! All lengths are metres, all angles radians, Z is up, frames are right-handed. Underneath are points and isometries of
//! nalgebra; their trigonometry comes from libm, so that results are the same on every machine.
//!
//! # Guarantees
//!
//! - To compose motions whose frames do not meet does not compile. Matrices and decompositions are nalgebra's, and are named
//!   only where equations are solved (`alignment`, `deviations`) or affine maps are read (`ifc`).
//! - A motion keeps its angle as it was given, beside its cosine and sine: files and archives give back the same bits.
//! - Instants are civil seconds at the site. Intervals are half-open; a date without a time is its midnight as a start, and
//!   the next midnight as a finish.
//! - A date with an offset is converted to the zone of the site, and is an error without one.
//!
//! # Where
//!
//! - dates: meaning of a text: `src/written_date.rs`, `common/stages/schedule/src/durations.rs`,
//!   `common/messages/src/schedule_dates.rs`

mod angle;
mod attitude;
mod bent_motion;
mod earth;
mod plan_time;
mod point;
mod pose_covariance;
mod rigid;
mod tenth_mm;
pub mod written_date;

pub use angle::wrapped;
pub use attitude::{Attitude, UPRIGHT};
pub use bent_motion::BentMotion;
pub use earth::{Earth, EarthFromWorld};
pub use plan_time::{PlanTime, PlanTimeError, WrittenPlanTime};
pub use point::{Point2, Point3};
pub use pose_covariance::PoseCovariance;
pub use rigid::{Rigid2, UprightRigid3};
pub use tenth_mm::{TENTHS_PER_M, metres, tenths};

/// The IFC world: the site's placement applied, the file's units converted to metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum World {}

/// The frame of every product: the building's dominant wall direction is axis-parallel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Map {}

/// The frame of a robot's map: where its SLAM began.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slam {}
