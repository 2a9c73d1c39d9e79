//! The kinds of archives: their numbers and names.

/// Calls a macro with every kind of archive: what it holds, its type, the number in its preamble, its name. A kind is added here; then
/// nothing builds without its declaration (`declaration.rs`), its sample for the hostile tests and the fuzz target, and a reader of
/// all that it has there (`tests/support/mod.rs`).
macro_rules! every_kind {
    ($macro:ident) => {
        $macro! {
            /// Geometry, spaces, doors and schedule of a site.
            Site = 1 "site",
            /// States of elements and spaces at a plan time.
            ScheduleState = 2 "schedule-state",
            /// Layers of one map storey.
            Grid = 3 "grid",
            /// Index of a set of grids.
            Grids = 4 "grids",
            /// Waypoints, tours, route graph.
            MissionPlan = 5 "mission-plan",
            /// A map that a robot made.
            SlamMap = 6 "slam-map",
            /// Pose of a robot's SLAM map in the model's map.
            Alignment = 7 "alignment",
            /// Deviations between model and SLAM map, per element.
            Deviations = 8 "deviations",
            /// What looks at a growing SLAM map have said about its poses.
            AlignmentEvidence = 9 "alignment-evidence",
            /// Tasks of schedule files, linked to a site.
            Tasks = 10 "tasks",
            /// The surface that can be walked or driven on at a plan time.
            Ground = 11 "ground",
        }
    };
}
pub(crate) use every_kind;

macro_rules! archive_kind {
    ($($(#[$doc:meta])* $kind:ident = $number:literal $name:literal,)*) => {
        /// What an archive holds.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum ArchiveKind {
            $($(#[$doc])* $kind = $number,)*
        }

        impl ArchiveKind {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// Its name: that of its topic, where it has one.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}
every_kind!(archive_kind);
