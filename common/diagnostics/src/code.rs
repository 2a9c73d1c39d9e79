//! Codes of diagnostics, which are stable for programs.

use bytemuck::{CheckedBitPattern, NoUninit};

macro_rules! codes {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)*) => {
        /// The code of a diagnostic; its name is that in files.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, CheckedBitPattern, NoUninit)]
        #[repr(u32)]
        pub enum DiagnosticCode {
            $($(#[$doc])* $variant,)*
        }

        impl DiagnosticCode {
            /// All codes.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Its name in files.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

codes! {
    // Reading a file: `ifc`.
    /// A boolean operation may have gone wrong.
    BooleanDoubtful = "boolean_doubtful",
    /// A body that has no faces.
    BodyWithoutFaces = "body_without_faces",
    /// A calendar that cannot be used as it is written.
    CalendarUnreadable = "calendar_unreadable",
    /// A date that is an entity with members of no date.
    DateEntityUnreadable = "date_entity_unreadable",
    /// A GlobalId that two elements have.
    DuplicateGlobalId = "duplicate_global_id",
    /// A STEP id that two records have.
    DuplicateId = "duplicate_id",
    /// Texts in an encoding that the file does not name.
    EncodingGuessed = "encoding_guessed",
    /// A body that could not be made, or in whose place a box stands.
    GeometryFailed = "geometry_failed",
    /// A body of which a part is missing.
    GeometryIncomplete = "geometry_incomplete",
    /// A header that is not as ISO 10303-21 has it.
    HeaderMalformed = "header_malformed",
    /// A STEP id beyond 64 bits.
    IdTooLarge = "id_too_large",
    /// The lag of a sequence that is not in the file, or none.
    LagMissing = "lag_missing",
    /// The file does not say its unit of length.
    LengthUnitUnknown = "length_unit_unknown",
    /// A map conversion that contradicts itself.
    MapConversionDoubtful = "map_conversion_doubtful",
    /// A map conversion that cannot be used.
    MapConversionUnusable = "map_conversion_unusable",
    /// An assignment to a group or classification that is not in the file.
    MembershipDangling = "membership_dangling",
    /// More groups and classifications of objects than the limit.
    MembershipsTooMany = "memberships_too_many",
    /// An opening that only touches its wall, which is cut by its door.
    OpeningBesideWall = "opening_beside_wall",
    /// Openings, or other cuts, that would take the kernel too long.
    OpeningsNotCut = "openings_not_cut",
    /// A placement that cannot be used.
    PlacementUnusable = "placement_unusable",
    /// An IfcProxy, of which the kind is not known.
    ProxyNotDrawn = "proxy_not_drawn",
    /// A record that is no STEP.
    RecordMalformed = "record_malformed",
    /// A record that refers to one that is not in the file.
    ReferenceDangling = "reference_dangling",
    /// A schema of before IFC4.
    SchemaOlder = "schema_older",
    /// A sequence whose tasks are not in the file.
    SequenceDangling = "sequence_dangling",
    /// A sequence of a type of the author's own.
    SequenceUserDefined = "sequence_user_defined",
    /// Earthworks that are cut out of terrain, which is not done.
    EarthworksNotCut = "earthworks_not_cut",
    /// Openings that leave nothing of a body.
    SwallowedByOpenings = "swallowed_by_openings",
    /// A task with two calendars.
    TaskCalendarTwice = "task_calendar_twice",
    /// A work schedule that controls tasks and is not in the file.
    TaskControlDangling = "task_control_dangling",
    /// A link of a task to something that is not in the file.
    TaskLinkDangling = "task_link_dangling",
    /// A link of a task to something that has no state.
    TaskLinkWithoutState = "task_link_without_state",
    /// More links of tasks than the limit.
    TaskLinksTooMany = "task_links_too_many",
    /// A task that is nested in two tasks.
    TaskNestedTwice = "task_nested_twice",
    /// Tasks that are nested in themselves.
    TaskNestingCircle = "task_nesting_circle",
    /// Terrain of which triangles are left out.
    TerrainIncomplete = "terrain_incomplete",
    /// The time of a task that is not in the file.
    TaskTimeMissing = "task_time_missing",
    /// A task that recurs.
    TaskTimeRecurring = "task_time_recurring",
    /// A unit of time that is unknown.
    TimeUnitUnknown = "time_unit_unknown",
    /// An entity that no schema has.
    UnknownEntity = "unknown_entity",

    // Making the site of files: `ingest`.
    /// An element too far from the rest of the building.
    CoordinatesOutOfReach = "coordinates_out_of_reach",
    /// A door that does not say how it opens.
    DoorOperationUnknown = "door_operation_unknown",
    /// A width of a door that its opening or its body contradicts.
    DoorWidthImplausible = "door_width_implausible",
    /// A door that has no body.
    DoorWithoutBody = "door_without_body",
    /// The map frame of before stays although the files have another.
    FrameKept = "frame_kept",
    /// More levels than the limit.
    LevelsLeftOut = "levels_left_out",
    /// A file without a map conversion among others whose conversions differ.
    MapConversionMissing = "map_conversion_missing",
    /// Files whose scales on the map differ.
    MapScalesDiffer = "map_scales_differ",
    /// An opening of a wall that something fills which is no door.
    OpeningFilled = "opening_filled",
    /// Files in different projected systems.
    ProjectedSystemsDiffer = "projected_systems_differ",
    /// More contacts of spaces and elements than the limit.
    SpaceContactsTooMany = "space_contacts_too_many",
    /// A space without a body.
    SpaceWithoutBody = "space_without_body",
    /// A measure of a stair that its body contradicts.
    StairMeasureImplausible = "stair_measure_implausible",
    /// Terrain that has faces which carry nobody, or lie above each other.
    TerrainFacesUnusable = "terrain_faces_unusable",
    /// Terrain that is held with fewer triangles than the file has.
    TerrainSimplified = "terrain_simplified",

    // Linking schedule files with the site: `tasks`.
    /// A link whose task does not say what it does with the element.
    LinkEffectUnknown = "link_effect_unknown",
    /// A row of the table of links that names no task, or no element or space.
    LinkRowUnmatched = "link_row_unmatched",
    /// The schedule of the models, in whose place that of schedule files is used.
    ModelScheduleReplaced = "model_schedule_replaced",
    /// Tasks that another task of the file has the identity of.
    ScheduleFileDuplicateTask = "schedule_file_duplicate_task",
    /// A task that is nested in itself.
    ScheduleFileNesting = "schedule_file_nesting",
    /// Something in a schedule file that is not understood.
    ScheduleFileNotUnderstood = "schedule_file_not_understood",
    /// A task, calendar or parent that a schedule file names and does not have.
    ScheduleFileReference = "schedule_file_reference",
    /// A value in a schedule file that cannot be read or used.
    ScheduleFileValue = "schedule_file_value",
    /// Tasks of a schedule file that are still ahead and that it plans before its data date.
    TaskBeforeDataDate = "task_before_data_date",
    /// Tasks of schedule files that work on nothing.
    TasksWithoutLinks = "tasks_without_links",

    // Evaluating the schedule: `schedule`.
    /// A task whose calendar is to be used and is not there.
    CalendarMissing = "calendar_missing",
    /// A calendar with more working times than the limit.
    CalendarTooLarge = "calendar_too_large",
    /// A calendar in which nobody ever works.
    CalendarWithoutWork = "calendar_without_work",
    /// A rule that closes spaces and names none of the site.
    ClosedSpaceUnknown = "closed_space_unknown",
    /// A task that is complete, without a finish.
    CompletionWithoutFinish = "completion_without_finish",
    /// A date that binds a task and that its dates, or what it depends on, do not keep.
    ConstraintUnmet = "constraint_unmet",
    /// A date that can be read in two orders.
    DateAmbiguous = "date_ambiguous",
    /// A date in another order than the configured one.
    DateOrder = "date_order",
    /// A date that stands for none.
    DatePlaceholder = "date_placeholder",
    /// A text that is no date.
    DateUnreadable = "date_unreadable",
    /// A date with a zone, where the zone of the site is unknown.
    DateZone = "date_zone",
    /// A delay that moves nothing.
    DelayWithoutEffect = "delay_without_effect",
    /// Durations in days, which a calendar counts.
    DurationInDays = "duration_in_days",
    /// A construction phase without dates.
    ConstructionPhaseUnknown = "phase_unknown",
    /// A task that has an actual finish and 0 per cent complete.
    FinishWithoutCompletion = "finish_without_completion",
    /// Reported progress of elements or tasks that a revision of the model no longer has.
    ReportedProgressGone = "reported_progress_gone",
    /// A room without the date that rules look for.
    RoomUndated = "room_undated",
    /// A work schedule without tasks.
    ScheduleEmpty = "schedule_empty",
    /// The start of a work schedule that is no date.
    ScheduleStartUnreadable = "schedule_start_unreadable",
    /// A schedule of which nothing can be used.
    ScheduleUnusable = "schedule_unusable",
    /// A status that needs a date, and has none.
    StatusWithoutDate = "status_without_date",
    /// A summary task whose dates are not those of its parts.
    SummaryDatesDiffer = "summary_dates_differ",
    /// Tasks that depend on themselves.
    TaskCycle = "task_cycle",
    /// A date of a task that is no date.
    TaskDateUnreadable = "task_date_unreadable",
    /// A task that finishes before it starts.
    TaskReversed = "task_reversed",
    /// A task without dates.
    TaskUndated = "task_undated",

    // Planning missions: `waypoints`.
    /// A budget of minutes that driving alone uses up.
    BudgetTooSmall = "budget_too_small",
    /// An element that can be seen and that no scan sees.
    ElementUnseen = "element_unseen",
    /// A storey without faces of the classes that scans are to see.
    NoTargetFaces = "no_target_faces",
    /// The map of the ground outdoors is too large for ways over it; a coarser one has them.
    OutdoorsNotPlanned = "outdoors_not_planned",
    /// Scans that cannot be registered with others.
    ScanNotJoined = "scan_not_joined",
    /// A start where the robot cannot stand.
    StartBlocked = "start_blocked",

    // Making simulation worlds: `world`.
    /// A piece of an element that is not closed and convex as a file has it, so that another stands in.
    CollisionReplaced = "collision_replaced",
    /// An element that stands and is not in the world.
    NotInWorld = "not_in_world",

    // Evaluating the schedule, with what several robots observed: `schedule`.
    /// An element that one robot saw and another confirmed absent.
    ObservationConflict = "observation_conflict",

    // Planning missions with distances to keep: `waypoints`.
    /// A waypoint within a distance that the robot is to keep from an element: no other place serves.
    WithinSafetyDistance = "within_safety_distance",

    // Planning flights: `waypoints`.
    /// More places in the air, or more flight waypoints, than are planned.
    FlightTooLarge = "flight_too_large",

    // Making the site of files, for checks of the model: `ingest`.
    /// A door without an OverallWidth, whose width is measured.
    DoorWidthMissing = "door_width_missing",
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_word_of_its_own() {
        let mut names: Vec<_> = DiagnosticCode::ALL.iter().map(|code| code.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), DiagnosticCode::ALL.len());
        let is_word = |name: &&str| name.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        assert!(names.iter().all(is_word), "{names:?}");
    }
}
