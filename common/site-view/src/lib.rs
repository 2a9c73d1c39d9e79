//! One view of a site: which samples of the bus belong together, and whether the maps among them may be used.
//!
//! # What belongs together
//!
//! Samples of different topics come in any order. [`SiteSamples`] holds the newest of each topic, and gives the [`SiteSet`] of
//! those that belong together; a [`SiteSetReader`] follows the topics for it.
//!
//! # What may be used, and until when
//!
//! [`MapRule`] is the one rule. It hears heartbeats, schedule states and indices, and says whether maps may be used:
//!
//! | what is known | verdict | the robot |
//! |---|---|---|
//! | one of the [`WATCHED`] daemons (`schedule-eval`, `rasterize`), or the [`FOLLOWER`] (`site-follow`) in their place, was not heard for [`SILENT_AFTER`], 3 s: three heartbeats | no map: silent | stands still |
//! | the plan time moves, but does not follow the machine's clock ([`NextState::Unknown`]) | no map: the clock is not to be trusted | stands still |
//! | the next schedule state has been due for [`FRESH_TOLERANCE`], 3 s, by the machine's clock ([`NextState::Due`]), or the consumer's own plan time is past the end of the newest one, at once ([`ClockTime::Plan`]); never for a consumer without a clock | no map: past its validity | stands still |
//! | no schedule state, index and grids that match have come yet | no map: incomplete | stands still |
//! | the newest index is of the newest schedule state, and its grids are there | current | uses the maps |
//! | they are not, for less than [`GRIDS_LATE`], 1 s, since a newer schedule state, and for less than [`FRESH_TOLERANCE`] in all | overtaken | uses the maps, and enters nothing that the newer state blocks |
//! | they are not for longer | hold | stands still |
//!
//! Two consumers are built on it, and none decides by itself:
//!
//! - [`ConsistentSet`] holds the samples of the last set that was whole, for a robot or the monitor. Grids are there when it has
//!   them, and the verdict is that of the rule.
//! - [`Freshness`] judges maps that were passed on: a folder (`fresh`), the page, the topics of ROS 2. It keeps no samples, and
//!   compares what was passed on with the index of the daemons.
//!
//! # Where the two differ
//!
//! Maps that were passed on outlast the bus; therefore [`Freshness`] has a third answer, [`MapState::Unknown`], with which what
//! was last known counts. A map that was fresh stays so while it is overtaken, and for less than [`FRESH_TOLERANCE`] in all
//!
//! - without a bus, and until schedule state and index have come again from one that was created anew, where a consistent set
//!   is made anew too and has no map;
//! - while the maps of another site were not passed on yet.
//!
//! Storeys whose maps changed are outdated until their maps are passed on (a folder's `fresh` lists them, and nobody enters them by it),
//! and late after [`FRESH_TOLERANCE`] ([`Freshness::late_storeys`]): stale for a robot on them, which the hook of a folder and the
//! heartbeat on ROS 2 say; the others stay fresh. A check of maps that were passed on that is older than [`FRESH_TOLERANCE`] is none: the
//! robot stands still. A consistent set whose grids do not come holds as a whole.
//! In all other cases maps that were passed on at once are stale exactly when the set says hold or no map; a test compares them
//! over sequences of events.
//!
//! The Python package has the rule a second time (`common/python/src/groundplan/map_rule.py`): a test here writes its limits
//! (`_map_limits.py`) and the table of cases `tests/map_verdicts.json`, and a test there reads that.
//!
//! What a revision changes is told by `messages::SiteComparison`: the ingest stage compares sites, and knows no bus.

mod consistent_set;
mod freshness;
mod limits;
mod map_rule;
mod map_verdict;
mod plan_clock;
mod site_set;
mod site_set_reader;

pub use consistent_set::ConsistentSet;
pub use freshness::{Freshness, MapState, MapsInUse, Staleness, Storeys};
pub use limits::{
    FOLLOWER, FRESH_TOLERANCE, GRIDS_LATE, MISSED_HEARTBEATS, SCHEDULE_REPORTERS, SILENT_AFTER, WATCHED,
    newest_schedule_report,
};
pub use map_rule::MapRule;
pub use map_verdict::{MapVerdict, NoMapReason};
pub use plan_clock::{ClockTime, NextState};
pub use site_set::{SiteSample, SiteSamples, SiteSet, SiteState, SiteViews};
pub use site_set_reader::{SiteReader, SiteSetError, SiteSetReader};
