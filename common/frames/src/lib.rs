//! Points and rigid motions with their frame in the type, the length unit of archives, plan time, and counts for messages.
//!
//! All lengths are metres, all angles radians, Z is up, frames are right-handed. Underneath are points and isometries of
//! nalgebra; their trigonometry comes from libm, so that results are the same on every machine.

mod angle;
mod bent_motion;
mod earth;
mod plan_time;
mod point;
mod pose_covariance;
mod rigid;
mod tenth_mm;
pub mod written_date;

pub use angle::wrapped;
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
