//! Topics as types: what may be published on one and what is read from it is known to the compiler.
//!
//! ```compile_fail
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let bus: bus::Bus = todo!();
//! // A site has no plan time.
//! let sample = bus.subscriber(bus::topics::Site)?.take()?.expect("it is there");
//! let plan_time = sample.check()?.view().head.plan_time_s;
//! # Ok(())
//! # }
//! ```
//!
//! ```compile_fail
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let (bus, origin): (bus::Bus, bus::Origin) = todo!();
//! // States are no mission plan.
//! let states = messages::ScheduleStateBuilder::everything_built(messages::ContentHash::from_bits(7), 3, 1);
//! bus.publisher(bus::topics::MissionPlan, 4096)?.publish(&states, origin)?;
//! # Ok(())
//! # }
//! ```

use crate::names::{GridSlot, TopicName};
use messages::{Payload, payload};
use std::fmt::Debug;

/// A latched topic: who comes late gets the last sample.
pub trait Topic: Debug + Copy + Send + Sync + 'static {
    /// The archives that it carries.
    type Payload: Payload;

    /// Its name.
    fn name(self) -> TopicName;
}

macro_rules! topics {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct $name;

        impl Topic for $name {
            type Payload = payload::$name;

            fn name(self) -> TopicName {
                TopicName::$name
            }
        }
    )*};
}

topics! {
    /// Geometry, spaces, doors and schedule of the site.
    Site
    /// Tasks of schedule files, linked to the site; none without such files.
    Tasks
    /// States at a plan time.
    ScheduleState
    /// Index of the grids.
    Grids
    /// Waypoints.
    MissionPlan
    /// A map that a robot made.
    SlamMap
    /// The pose of that map.
    Alignment
    /// What differs between the model and that map.
    Deviations
}

/// A revision of the site that is not in force, while it is judged; it goes when that is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Candidate;

impl Topic for Candidate {
    type Payload = payload::Site;

    fn name(self) -> TopicName {
        TopicName::Candidate
    }
}

/// Layers of a map storey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid(pub GridSlot);

impl Topic for Grid {
    type Payload = payload::Grid;

    fn name(self) -> TopicName {
        TopicName::Grid(self.0)
    }
}
