//! Distances and speed limits of a robot near elements, by what they mean: rules, site, schedule state and grid in, a layer of
//! a map storey out.
//!
//! [`SafetyLayer::of`] says of each cell which speed is the limit in it, what it costs to drive there, and which element and rule
//! that is so for. Without rules there is no layer, but for a robot that drives on stairs.
//!
//! # Guarantees
//!
//! - A distance is that of the robot's centre, along cells on which nothing stands: it does not lead through a wall.
//! - Where rules meet the lowest limit of speed and the highest cost count, each with its own element; of equal ones the nearer
//!   element, then the rule that comes first in the profile.
//! - What is near is told by its height above the ground there: on a ramp and outdoors above that of the cells around, at least as much
//!   as a robot meets that stands in any of them (`src/local_ground.rs`). Terrain is what is driven on, and nothing to keep a distance
//!   from, where a map has heights; edges from which it breaks off are passed by distances.
//! - Cells of a stair on which the robot drives have at least the cost of its profile, whatever rules there are.
//! - A cost is never lethal: from 90 per cent beside the element to 10 at the end of the distance.
//! - What is not there at the plan time has neither distance nor limit. Of work what is below it is a part, up to the next floor.
//! - A door whose model does not say how it hangs swings on both sides from both jambs.
//!
//! # Where
//!
//! - cells of the elements of a rule: `src/rule_elements.rs`
//! - height of the ground around a cell: `src/local_ground.rs`
//! - edges at stairs, stairs that are driven on: `src/stair_edges.rs`, `src/stair_cells.rs`
//! - leaves of doors: `src/door_swings.rs`
//! - cells near them: `src/safety_layer.rs`

mod local_ground;
mod rule_elements;

mod door_swings;
mod stair_cells;
mod stair_edges;

mod safety_layer;

pub use safety_layer::{NO_SOURCE, SafetyInput, SafetyLayer, SafetySource, speed_mask, speed_step_m_s};
