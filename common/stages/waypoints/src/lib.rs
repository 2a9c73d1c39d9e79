//! Site, phase and grids in, a plan out: centres of spaces, scans that cover them, tours, the route graph.

mod options;

mod changed;
mod climb;
mod ground;
mod portals;
mod reached;
mod sloped_slabs;
mod spaces;
mod stair_ends;
mod start;
mod unknown;

mod centre;
mod cover;
mod face;
mod mesh_check;
mod scans;
mod search;
mod visible;

mod chance;
mod joining;
mod tour;
mod trip;
mod walk;

mod graph;
mod skeleton;

mod assemble;
mod plan;
mod steps;
mod storey;

pub use cover::Instance;
pub use options::{OptionsError, PlanOptions, Start};
pub use plan::{PlanInput, Planner, StoreyInstance};
pub use start::check_start;
pub use unknown::{UnknownName, check_names};
