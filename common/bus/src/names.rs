//! Daemons and topics: names, archive kinds, and the producer of each topic.

use messages::ArchiveKind;
use std::fmt;

/// A participant of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u32)]
pub enum Daemon {
    /// Reads IFC files.
    IfcIngest = 0,
    /// Evaluates the schedule.
    ScheduleEval = 1,
    /// Makes grids.
    Rasterize = 2,
    /// Makes waypoints.
    WaypointGen = 3,
    /// Aligns the robot's map.
    SlamAlign = 4,
    /// The robot's side: brings its own map.
    Robot = 5,
    /// The operator's client; the only one of which several may run at once.
    Groundplan = 6,
    /// Brings maps to ROS 2.
    RosBridge = 7,
    /// Shows the site in browsers.
    Web = 8,
    /// Publishes what the server of a site has drawn, on the bus of a robot that follows it.
    SiteFollow = 9,
    /// Gives what a site has drawn to a store, for robots on other machines.
    SiteServer = 10,
    /// Answers questions about the site over HTTP and MCP.
    Ask = 11,
}

impl Daemon {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 12] = [
        Self::IfcIngest,
        Self::ScheduleEval,
        Self::Rasterize,
        Self::WaypointGen,
        Self::SlamAlign,
        Self::Robot,
        Self::Groundplan,
        Self::RosBridge,
        Self::Web,
        Self::SiteFollow,
        Self::SiteServer,
        Self::Ask,
    ];

    /// Daemons that `groundplan up` starts and starts again, and without which there are no maps, where the site is drawn.
    pub const SUPERVISED: [Self; 5] =
        [Self::IfcIngest, Self::ScheduleEval, Self::Rasterize, Self::WaypointGen, Self::SlamAlign];

    /// Daemons that `groundplan up` starts in the place of [`Daemon::SUPERVISED`] for a robot that follows the server of its site.
    pub const FOLLOWING: [Self; 2] = [Self::SiteFollow, Self::SlamAlign];

    /// True for daemons that draw a site: what they publish comes from its server instead where a robot follows one.
    pub fn draws(self) -> bool {
        matches!(self, Self::IfcIngest | Self::ScheduleEval | Self::Rasterize | Self::WaypointGen)
    }

    /// True for daemons of the site's own user; robots and clients may be of others.
    pub fn is_of_site(self) -> bool {
        !matches!(self, Self::Robot | Self::Groundplan)
    }

    /// True for daemons of which each robot has its own. The others are there once, for all robots of a site.
    pub fn is_of_robot(self) -> bool {
        match self {
            Self::Rasterize | Self::WaypointGen | Self::SlamAlign | Self::Robot | Self::RosBridge => true,
            Self::IfcIngest
            | Self::ScheduleEval
            | Self::Groundplan
            | Self::Web
            | Self::SiteFollow
            | Self::SiteServer
            | Self::Ask => false,
        }
    }

    /// Its name, as of its process.
    pub fn name(self) -> &'static str {
        match self {
            Self::IfcIngest => "ifc-ingest",
            Self::ScheduleEval => "schedule-eval",
            Self::Rasterize => "rasterize",
            Self::WaypointGen => "waypoint-gen",
            Self::SlamAlign => "slam-align",
            Self::Robot => "robot",
            Self::Groundplan => "groundplan",
            Self::RosBridge => "ros-bridge",
            Self::Web => "groundplan-web",
            Self::SiteFollow => "site-follow",
            Self::SiteServer => "site-server",
            Self::Ask => "groundplan-ask",
        }
    }

    /// The daemon with this number, as in [`messages::StatusRecord`].
    pub fn from_id(id: u32) -> Option<Self> {
        Self::ALL.get(id as usize).copied()
    }
}

impl fmt::Display for Daemon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Place of a map storey's grid: `grid/00` to `grid/63`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GridSlot(u8);

impl GridSlot {
    /// Number of slots.
    pub const COUNT: usize = 64;

    /// The slot with this number; `None` from [`GridSlot::COUNT`] on.
    pub fn new(index: usize) -> Option<Self> {
        (index < Self::COUNT).then_some(Self(index as u8))
    }

    /// All slots.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT as u8).map(Self)
    }

    /// Its number, the place in the index of the grids.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The name of a latched topic: for tools, logs and the keeper; [`crate::Topic`] is its type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TopicName {
    /// Geometry and facts of the site.
    Site,
    /// A revision of the site that is not in force, while it is judged.
    Candidate,
    /// Tasks of schedule files.
    Tasks,
    /// States at a plan time.
    ScheduleState,
    /// Layers of a map storey.
    Grid(GridSlot),
    /// Index of the grids.
    Grids,
    /// Waypoints.
    MissionPlan,
    /// A map that a robot made.
    SlamMap,
    /// Where that map lies.
    Alignment,
    /// What differs from it.
    Deviations,
}

impl TopicName {
    /// All topics, the slots of the grids included. Their places are their numbers for the relay: a new one comes last.
    pub fn all() -> impl Iterator<Item = Self> {
        [
            Self::Site,
            Self::Tasks,
            Self::ScheduleState,
            Self::Grids,
            Self::MissionPlan,
            Self::SlamMap,
            Self::Alignment,
            Self::Deviations,
        ]
        .into_iter()
        .chain(GridSlot::all().map(Self::Grid))
        .chain([Self::Candidate])
    }

    /// Archives that it carries.
    pub fn kind(self) -> ArchiveKind {
        match self {
            Self::Site | Self::Candidate => ArchiveKind::Site,
            Self::Tasks => ArchiveKind::Tasks,
            Self::ScheduleState => ArchiveKind::ScheduleState,
            Self::Grid(_) => ArchiveKind::Grid,
            Self::Grids => ArchiveKind::Grids,
            Self::MissionPlan => ArchiveKind::MissionPlan,
            Self::SlamMap => ArchiveKind::SlamMap,
            Self::Alignment => ArchiveKind::Alignment,
            Self::Deviations => ArchiveKind::Deviations,
        }
    }

    /// True for topics of which each robot has its own: those that its daemons publish.
    pub fn is_of_robot(self) -> bool {
        self.producer().is_of_robot()
    }

    /// True if this daemon may publish it: its producer, and on a robot that follows the server of its site what publishes all that is
    /// drawn there. The two are never on one bus: the configuration of a site has one or the other.
    pub fn is_published_by(self, daemon: Daemon) -> bool {
        let producer = self.producer();
        producer == daemon || (daemon == Daemon::SiteFollow && producer.draws() && self != Self::Candidate)
    }

    /// The only daemon that publishes it where the site is drawn.
    pub fn producer(self) -> Daemon {
        match self {
            Self::Site | Self::Candidate => Daemon::IfcIngest,
            Self::Tasks | Self::ScheduleState => Daemon::ScheduleEval,
            Self::Grid(_) | Self::Grids => Daemon::Rasterize,
            Self::MissionPlan => Daemon::WaypointGen,
            Self::SlamMap => Daemon::Robot,
            Self::Alignment | Self::Deviations => Daemon::SlamAlign,
        }
    }
}

impl fmt::Display for TopicName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Site => f.write_str("site"),
            Self::Candidate => f.write_str("candidate"),
            Self::Tasks => f.write_str("tasks"),
            Self::ScheduleState => f.write_str("schedule-state"),
            Self::Grid(slot) => write!(f, "grid/{:02}", slot.index()),
            Self::Grids => f.write_str("grids"),
            Self::MissionPlan => f.write_str("mission-plan"),
            Self::SlamMap => f.write_str("slam-map"),
            Self::Alignment => f.write_str("alignment"),
            Self::Deviations => f.write_str("deviations"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_topic_has_a_name_of_its_own() {
        let names: BTreeSet<String> = TopicName::all().map(|t| t.to_string()).collect();
        assert_eq!(names.len(), 9 + GridSlot::COUNT);
        assert!(names.contains("grid/00") && names.contains("grid/63") && !names.contains("grid/64"));
    }

    #[test]
    fn numbers_and_daemons_are_the_same_thing() {
        for daemon in Daemon::ALL {
            assert_eq!(Daemon::from_id(daemon as u32), Some(daemon));
            assert!(daemon.name().len() <= 15, "ps shows 15 bytes");
        }
        assert_eq!(Daemon::from_id(Daemon::ALL.len() as u32), None);
    }
}
