//! Schedule files and linking rules in, the `tasks` archive out: a planner's tasks, and the elements and spaces of a site that
//! each works on.
//!
//! [`link`] finds the targets of every task, by a table of links or by [`LinkRules`]; [`tasks_of`] writes tasks and links as a
//! work schedule, which the schedule stage evaluates in the place of that of the models. Dates stay those of the files; nothing
//! is scheduled here. No clock, no I/O.
//!
//! A target takes its links from the first that names it: the table, then the rules in their order.
//!
//! # Guarantees
//!
//! - The same plan gives the same maps, whichever file it is in (`Site::with_tasks`).
//! - Linking is linear in tasks, targets and links: targets are indexed by the values that a task must have.
//! - A link has its effect; the type of the task, by which models say it, does not count.
//! - What is linked with nothing is reported, with the names of tasks.
//! - Dates, durations and lags of a planner's file are typed from its reader to the schedule stage (`ScheduleDateRecord`);
//!   only those of models are texts, which rules interpret.
//!
//! # Where
//!
//! - tasks: links with elements: `src/linking.rs`, `src/link_rules.rs`, `src/target_values.rs`, `src/link_table.rs`
//! - tasks: rules that are proposed, and why not: `src/proposals/mod.rs`, `src/proposals/evidence.rs`
//! - tasks: of schedule files, their dates and calendars: `src/records.rs`, `src/task_dates.rs`, `src/calendar_records.rs`

mod calendar_records;
mod contradictions;
mod effect;
mod file_findings;
mod folded;
mod link_rules;
mod link_table;
mod linking;
mod links;
mod matches;
mod proposals;
mod records;
mod schedule_file;
mod selector;
mod target_values;
mod task_dates;
mod task_values;

pub use contradictions::{Contradiction, ContradictionKind, contradictions};
pub use effect::{Effect, EffectWords};
pub use link_rules::{
    EffectChoice, ElementSelector, LinkRule, LinkRules, LinkRulesError, LinkRulesToml, LinkToml, TaskSelector,
};
pub use link_table::{LinkTableError, TableLink, link_table, parse_link_table};
pub use linking::{LinkError, link};
pub use links::{Link, LinkOrigin, Links, Target};
pub use matches::{ClassShare, MAX_COMPARED_TASKS, MAX_COMPARED_VALUES, Matches, NearMiss, matches};
pub use proposals::{NotProposed, Proposal, ProposalExample, Proposals, WhyNot, propose};
pub use records::tasks_of;
pub use schedule_file::{MAX_SCHEDULE_FILE_BYTES, ScheduleFile, ScheduleFileError};
pub use schedule_files::cell_of;
pub use task_values::PlannedTask;
