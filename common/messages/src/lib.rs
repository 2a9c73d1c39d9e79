//! The archives that stages read and write: layouts, views, writers. Safe code, no bus.
//!
//! An archive is flat, relocatable and 64-byte aligned: a 64-byte [`Preamble`], a table of sections, then the sections,
//! each a plain array of one record type that begins at a multiple of 64. Offsets count from the archive's start, so the
//! same bytes live in heap, cache file and shared memory. Little-endian. The sections of each kind are declared once
//! (`src/declaration.rs`). A stage is a function from views to a writer:
//!
//! | archive | view | writer | producer |
//! |---|---|---|---|
//! | `site` | [`Site`] | [`SiteBuilder`] | ifc-ingest |
//! | `tasks` | [`Tasks`] | [`TasksBuilder`] | schedule-eval |
//! | `schedule-state` | [`ScheduleState`] | [`ScheduleStateBuilder`] | schedule-eval |
//! | `grid` | [`Grid`] | [`GridWriter`] | rasterize |
//! | `grids` | [`Grids`] | [`GridsBuilder`] | rasterize |
//! | `mission-plan` | [`MissionPlan`] | [`MissionPlanBuilder`] | waypoint-gen |
//! | `slam-map` | [`SlamMap`] | [`SlamMapBuilder`] | the robot |
//! | `alignment` | [`Alignment`] | [`AlignmentBuilder`] | slam-align |
//! | `deviations` | [`Deviations`] | [`DeviationsBuilder`] | slam-align |
//! | none | [`Ground`] | [`GroundWriter`] | `groundplan` |
//! | none | [`AlignmentEvidence`] | [`AlignmentEvidenceBuilder`] | slam-align, `groundplan align` |
//!
//! Beside an archive travels its [`SampleHeader`]: data of the publication, not of the content. Daemons report
//! themselves with a [`StatusRecord`].
//!
//! Records are `repr(C)` without hidden padding; their sizes are asserted. An enumeration is a [`Tag`]: an archive with a number
//! that stands for nothing is refused when it is opened. Text is a [`Text`] into the archive's string
//! section; a list of texts is a [`TextList`]. [`NONE`] in an index means "none". Lengths are metres in `f64`, or tenths of a millimetre in `map` in `i32`
//! where the field's name ends in `_tenths`.
//!
//! # Guarantees
//!
//! - A view validates once: preamble, hash, bounds, coordinates, and every index inside. After that it reads in place and
//!   does not panic. `Checked` keeps the memory of an archive that was validated, so that nothing hashes it again.
//! - Whoever reads the grids of a site takes them as `MapGrids`, one view at a time: a conversion packs those of a large site
//!   (`src/packed_grid.rs`), so that one storey at a time is dense in memory.
//! - Archives that are each whole may still be of different sites: `check_site` of each view tells.
//! - Archives are read in place; none is turned back into a model.
//! - All layouts have one version, [`LAYOUT_VERSION`], which is 1 in the first release and rises with any change of a record or section: a
//!   reader refuses every other one with both numbers, and nothing converts archives. What is kept of them is made anew.
//!
//! # Where
//!
//! - archives: sections of each kind: `src/declaration.rs`; all kinds: `src/archive_kind.rs`
//! - door: the leaves that move beside a fixed one: `src/moving_leaves.rs`
//! - door: which passages are closed, and whether an opening without its door can be passed: `src/grids.rs`
//! - grids: held packed, unpacked for a view: `src/packed_grid.rs`, `src/map_grids.rs`, `services/groundplan/src/maps.rs`
//! - grids: heights, slopes and how well a robot drives over a cell: `src/grid_archive.rs`, `src/traversability.rs`
//! - pose: whether it may be used, and in what words not: `src/pose_use.rs`
//! - process: how it is by its last report: `src/process_health.rs`
//! - python: layouts of archives: `src/python_layouts.rs`

mod alignment;
mod alignment_evidence;
mod alignment_records;
mod archive;
mod archive_kind;
mod archive_writer;
mod checked;
mod consistency;
mod content_hash;
mod content_id;
mod declaration;
mod deviation_records;
mod deviations;
mod diagnostic_record;
pub mod door_operations;
mod drive_model;
mod flight;
mod grid_archive;
mod grids;
mod ground;
mod ground_records;
mod local_poses;
mod map_grids;
mod mission_plan;
mod mission_plan_records;
mod moving_leaves;
mod packed_grid;
pub mod payload;
mod pose_use;
mod process_health;
#[cfg(test)]
mod python_layouts;
mod robot;
mod safety_rules;
mod sample_header;
mod schedule_date_view;
mod schedule_dates;
mod schedule_records;
mod schedule_state;
mod section;
mod site;
mod site_builder;
mod site_comparison;
mod site_outline;
mod site_records;
mod slam_frame;
mod slam_map;
mod spans;
mod status;
mod tag;
mod tasks;
mod text_pool;
mod traversability;
mod work_schedule;

pub use alignment::{Alignment, AlignmentBuilder};
pub use alignment_evidence::{AlignmentEvidence, AlignmentEvidenceBuilder, AlignmentEvidenceHead, PoseHistoryRecord};
pub use alignment_records::*;
pub use archive::{
    Archive, ArchiveBuffer, ArchiveError, Block, HASHED_BLOCK, LAYOUT_VERSION, NONE, Preamble, Text, TextList,
};
pub use archive_kind::ArchiveKind;
pub use archive_writer::ArchiveWriter;
pub use checked::Checked;
pub use consistency::OtherSite;
pub use content_hash::ContentHash;
pub use content_id::{ContentId, NoContentId, ShortContentId};
pub use deviation_records::*;
pub use deviations::{Deviations, DeviationsBuilder};
pub use diagnostic_record::DiagnosticRecord;
pub use diagnostics::{Diagnostic, DiagnosticCode, Named, Report, Severity};
pub use drive_model::{DriveModel, JOULES_PER_WH, WayCost};
pub use flight::{Flight, FlightHead, FlightRecords, FlightSpaceRecord, FlightWaypointRecord, NoFlight};
pub use grid_archive::{
    BlockHashes, FLOOR_ASSUMED, FLOOR_BUILT, Grid, GridHead, GridLayers, GridWriter, NO_HEIGHT, NO_SLOPE, copy_changed,
};
pub use grids::{
    DoorPassage, DoorPassageRecord, DoorUse, GridSlotRecord, Grids, GridsBuilder, GridsHead, RegionRecord,
};
pub use ground::{Ground, GroundWriter};
pub use ground_records::*;
pub use local_poses::{LocalPoseRecord, LocalPoses, LocalPosesHead, LocalPosesParts, OutlineRingRecord, flat, part_at};
pub use map_grids::{ChosenGrids, MapGrids};
pub use mission_plan::{MissionPlan, MissionPlanBuilder};
pub use mission_plan_records::*;
pub use moving_leaves::{LeafPanel, MovingLeaves};
pub use packed_grid::HeldGrid;
pub use payload::Payload;
pub use pose_use::SearchOutcome;
pub use process_health::{ProcessHealth, SeenProcess, SeenReport};
pub use robot::{DoorCapability, MAX_RISER_M, RobotLimitError, RobotProfile};
pub use safety_rules::{SafetyKind, SafetyRuleError, SafetyRuleRecord, SafetyRules, SafetySubject};
pub use sample_header::{InputHashes, SampleError, SampleHeader};
pub use schedule_dates::{
    CivilDate, ScheduleDate, ScheduleDateKind, ScheduleDateRecord, ScheduleLength, TaskDurationRecord,
};
pub use schedule_records::*;
pub use schedule_state::{
    DateSource, ElementScheduleRecord, ElementState, ScheduleState, ScheduleStateBuilder, ScheduleStateHead,
    SpaceState, SpaceStateRecord, plan_time,
};
pub use section::{Section, SectionCount};
pub use site::{MAX_SILL_TENTHS, Site, SiteBuilder};
pub use site_comparison::{Difference, SiteComparison, StoreyDifference, StoreyPresence, is_same_building};
pub use site_outline::{ElementOutline, GeoreferenceOutline, MapStoreyOutline, SiteOutline, StoreyOutline};
pub use site_records::*;
pub use slam_frame::SlamFrame;
pub use slam_map::{SlamMap, SlamMapBuilder, SlamMapHead};
pub use status::{Activity, StatusRecord};
pub use tag::{Enumeration, Tag, TagOf};
pub use tasks::{Tasks, TasksBuilder, TasksHead};
pub use text_pool::TextPool;
pub use work_schedule::{WorkSchedule, WorkScheduleRecords};
