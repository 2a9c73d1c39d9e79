//! Schedule evaluation: site and rules in, states of elements and spaces at any plan time out.
//!
//! [`evaluate`] resolves task dates (written, rolled up, computed from sequences, durations and calendars), the timeline of
//! each element and the closures of spaces once. The [`Timeline`] answers for any instant or period by looking up sorted
//! changes. No clock, no I/O.
//!
//! Instants are civil seconds since 1970-01-01T00:00 at the site, without a zone.
//!
//! # Sources of dates
//!
//! In order of rank, for each element: reported progress (of as-built models the property set `Groundplan_AsBuilt`, before
//! which other reports rank), tasks (actual, scheduled, early or computed dates), property sets, construction phases, status. Tasks, times, sequences with lags and calendars are those of IFC2X3, IFC4 and
//! IFC4X3; dates that are missing are computed by a forward pass, with floats.
//!
//! Rules of property dates, construction phases (models name them, but do not date them), closed rooms, time zone and
//! date order are [`Rules`], a file like `config/schedule.toml`. A date that can be read in two ways is an error that
//! shows both readings, unless other dates of the file or the rules decide. A date with an offset or `Z` is converted
//! to `site_zone` of the rules, and is an error without one. What is wrong with a task or a date is a diagnostic with
//! its GlobalId, and does not stop the rest.
//!
//! # Instants and periods
//!
//! `states`, `changes` and the daemons deal in instants: a date without a time is its midnight. A map serves a working
//! period, by default a whole day, and shows the union over it: a space is blocked if it is at any instant, an element is
//! an obstacle if it is there at any instant, and a cell has floor only if it has throughout. `groundplan states` lists
//! what differs between the two.
//!
//! ```text
//! groundplan convert house.ifc -o maps --date 2024-04-15                          # the union over the day
//! groundplan convert house.ifc -o maps --date 2024-04-15T08:30:00                 # an instant
//! groundplan convert house.ifc -o maps --date 2024-04-15 --until 2024-04-19       # the union over the days
//! groundplan convert house.ifc -o maps --date all                                 # a folder per change
//! groundplan states house.ifc --date 2024-04-15                                   # the midnight, and what differs in the day
//! groundplan states house.ifc --date 2024-04-15 --until 2024-04-15                # the whole day, as convert draws it
//! groundplan states house.ifc --date 2024-04-15 --delay 'Partition walls=5d'      # what if
//! groundplan states house.ifc --date 2024-04-15 --actuals progress.csv            # columns id, start, finish
//! groundplan states house.ifc --date 2024-04-15 --probability                     # how sure that is, safest days
//! groundplan tasks house.ifc                                                      # dates, targets, problems
//! groundplan changes house.ifc                                                    # change instants and their tasks
//! ```
//!
//! Without a date every element stands and every space is open, with a warning if the model has a schedule.
//!
//! # Guarantees
//!
//! - The planned state follows the schedule alone; the effective state also reports and observations. Maps follow the
//!   effective state.
//! - Dates that a file writes come back as they are; those that it leaves open are computed as the planner's tool computes
//!   them: `scripts/check_schedule_dates.py` compares them with MPXJ's schedulers of both products. The two differ where that
//!   is known: an instant that a P6 relationship asks of a finish stands, and activities start together in the calendar of
//!   their lag (`sequence_flags::PRIMAVERA`), latest dates go before dependencies in MS Project.
//! - A level of effort spans what it is linked with, a WBS summary all tasks below its node, also under delays and in
//!   probabilities; neither decides the dates of another task.
//! - A task that is scheduled by hand is moved by its own delay alone; what it or a constraint does not keep is a diagnostic
//!   with the task's name.
//! - A task that cannot be used is a diagnostic and has no effect; only a date that can be read in two ways stops everything,
//!   and shows both readings.
//! - While the plan time moves, a schedule state is that of the last change instant: it is the same however often it is
//!   evaluated.
//! - Uncertain durations are simulated: thousands of forward passes with durations from triangular distributions, three-point
//!   ones where the schedule has them (PERT: Malcolm et al., 1959; Monte Carlo over the network: Van Slyke, 1963). A draw
//!   depends on seed, task and run alone (SplitMix64), so that results are the same with any number of threads.
//! - Without spread the probabilities are 0 and 1, and those of the timeline.
//! - Planning under uncertainty is a schedule state like any other, in which an element that may be there is in progress and
//!   only one that stands almost surely is built: `raster` knows nothing of probabilities.
//!
//! # Where
//!
//! - calendars, working time: `src/working_time/mod.rs`
//! - tasks: dates written, rolled up, computed, delayed; floats: `src/tasks/resolve.rs`, `src/tasks/delays.rs`,
//!   `src/tasks/floats.rs`
//! - tasks: targets, and the tasks of a change: `src/task_targets.rs`
//! - tasks: that span others (level of effort, WBS summary): `src/tasks/span.rs`

mod as_built;
mod clock;
mod closures;
mod construction_phases;
mod diagnostics;
mod durations;
mod element_timeline;
mod error;
mod evaluate;
mod overrides;
mod probability;
mod property_dates;
mod rules;
mod simulation;
mod task_effects;
mod task_targets;
mod tasks;
mod timeline;
mod working_time;

pub use as_built::AS_BUILT_SET;
pub use error::{AmbiguousDates, EvaluateError};
pub use evaluate::{ReportedDates, evaluate, planned};
pub use frames::written_date::DateOrder;
pub use overrides::{ABSENT, Actual, Delay, ObservationConflict, OverrideError, Overrides, find_task, parse_actuals};
pub use probability::{ElementProbability, Probabilities, SafeDay, UNCERTAIN, Uncertainty};
pub use rules::{
    ClosedSpace, ConstructionPhase, ConstructionPhaseProperties, DateKind, DurationDay, InputEffect, PropertyDate,
    Rules, RulesError, RulesMode, Undated,
};
pub use simulation::{ProbabilityError, probabilities};
pub use task_targets::{Cause, TaskOperation, TaskTargets};
pub use tasks::{Floats, TaskDates};
pub use timeline::{Change, Period, Timeline};
