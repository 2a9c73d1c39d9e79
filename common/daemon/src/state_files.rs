//! The files of a state folder: how each is named, and which daemon writes it. No other file of the sources names one, which a test
//! of the workspace looks after.
//!
//! What is decided is written before it is published (`committed.rs`). Others are written on the way: numbers of samples before the
//! sample, [`MESH_CACHE`] while files are read.
//!
//! Daemons of a robot with a name write theirs in the folder [`ROBOTS`]`/NAME` of it.
//!
//! # Damage
//!
//! A file that is kept *twice* has a sealed copy: what is left of one mends the other, and that is told (`kept_file.rs`). What becomes
//! of one of which both are damaged, or of the only copy of one that is kept *once*, is a word at each file:
//!
//! - *stops*: its daemon does not start, and names the file;
//! - *refused*: the daemon runs, and refuses what needs the file, each time; nothing else stands in for it;
//! - *anew*: it is made again, or nothing is kept of what it held, and the log or the status says so;
//! - *epochs*: they go on above all that can have been taken, from the microseconds since 1970;
//! - *unread*: no daemon reads it back, it is written again.

// ---- ifc-ingest.

/// `ifc-ingest`: the revisions of the site, in force, refused and waiting; twice, stops.
pub const REVISIONS: &str = "loaded.json";
/// `ifc-ingest`: the outline of the site in force, with which a revision is compared; twice, anew.
pub const SITE_OUTLINE: &str = "site-outline.json";
/// `ifc-ingest`: the map frame; twice, refused: revisions, and never another frame in its place.
pub const SITE_FRAME: &str = "site-frame.json";
/// `ifc-ingest`: the site in force; once, anew, of the models.
pub const SITE_CACHE: &str = "site.gpar";
/// `ifc-ingest`: meshes of the files that were read last; once, anew.
pub const MESH_CACHE: &str = "meshes.gpmesh";
/// `ifc-ingest`: numbers of samples of the site; twice, epochs.
pub const SITE_EPOCHS: &str = "ifc-ingest-epochs.json";
/// `ifc-ingest`: numbers of candidates for it; twice, epochs.
pub const CANDIDATE_EPOCHS: &str = "ifc-ingest-candidate-epochs.json";

// ---- schedule-eval.

/// `schedule-eval`: names and contents of the schedule files in force; twice. It is read where the files that the configuration names
/// cannot be used, and then stops.
pub const SCHEDULE_FILES: &str = "schedule-files.bin";
/// `schedule-eval`: the rules of the last schedule that could be evaluated; twice, anew.
pub const EVALUATED_RULES: &str = "evaluated-rules.json";
/// `schedule-eval`: the folder of tables of reported progress; twice each; that in force and the one before it stop, others are not read.
pub const PROGRESS: &str = "progress";
/// `schedule-eval`: the table of observed progress of a site whose robot has no name; twice, stops.
pub const OBSERVED: &str = "observed.csv";
/// `schedule-eval`: the tables of observed progress of robots with names; twice, stops.
pub const OBSERVED_BY_ROBOTS: &str = "observed-robots.json";
/// `schedule-eval`: numbers of samples; twice, epochs.
pub const SCHEDULE_EPOCHS: &str = "schedule-eval-epochs.json";

// ---- rasterize and waypoint-gen.

/// `rasterize`: numbers of samples; twice, epochs.
pub const GRID_EPOCHS: &str = "rasterize-epochs.json";
/// `waypoint-gen`: numbers of samples; twice, epochs.
pub const MISSION_PLAN_EPOCHS: &str = "waypoint-gen-epochs.json";

// ---- slam-align.

/// `slam-align`: the pose, what was confirmed, observations that are applied; twice, stops.
pub const ALIGNMENT: &str = "alignment.json";
/// `slam-align`: evidence over looks; an archive: twice, anew, the next look is worth less.
pub const ALIGNMENT_EVIDENCE: &str = "alignment-evidence.gpar";
/// `slam-align`: copies of map files begin so; what follows is the hash of their content. Twice, refused: the map is to be given again.
pub const SLAM_MAP_COPIES: &str = "slam-map-";
/// `slam-align`: the table of observed progress that it gave last; once, anew: the table is given again.
pub const OBSERVED_BY_ALIGNMENT: &str = "slam-align-observed.csv";
/// `slam-align`: numbers of samples; twice, epochs.
pub const ALIGNMENT_EPOCHS: &str = "slam-align-epochs.json";

// ---- ros-bridge.

/// `ros-bridge`: the storey that the robot is on; twice, stops.
pub const ROBOT_STOREY: &str = "ros-bridge-robot-storey.json";
/// `ros-bridge`: the folder of route graphs for Nav2; once, unread.
pub const ROS_MAPS: &str = "ros";
/// `ros-bridge`: numbers of samples of the robot's map; twice, epochs.
pub const SLAM_MAP_EPOCHS: &str = "ros-bridge-slam-map-epochs.json";

// ---- site-server.

/// `site-server`: the last epoch that it took in the store of a site; twice, refused: nothing is published.
pub fn published_epoch(site: &str) -> String {
    format!("site-server-{site}.json")
}
/// `site-server`: the folder of what robots told; twice, anew: they tell it again.
pub const TOLD: &str = "fleet";
/// `site-server`: what it knows of the robots, as a document for the page and answers; once, unread by daemons that decide.
pub const FLEET: &str = "fleet.json";

// ---- site-follow.

/// `site-follow`: what was acknowledged, and how far the plan time got; twice, stops.
pub const FOLLOWED: &str = "site-follow.json";
/// `site-follow`: the index that is shown; twice, anew: it is fetched.
pub const FOLLOWED_INDEX: &str = "site-follow-index.jsonl";
/// `site-follow`: the folder of archives; once, anew: they are fetched.
pub const FOLLOWED_ARCHIVES: &str = "followed-archives";
/// `site-follow`: the table of progress that the robot observed; twice, anew.
pub const OBSERVED_BY_FOLLOWER: &str = "follow-observed.csv";
/// `site-follow`: numbers of samples; twice, epochs.
pub const FOLLOW_EPOCHS: &str = "site-follow-epochs.json";

// ---- Page, answers, client.

/// `groundplan-web`: the hash of the token of viewers; once, stops where other machines may ask.
pub const WEB_TOKEN: &str = "web-token.sha256";
/// `groundplan-ask`: the hash of the token of who asks; once, stops where other machines may ask.
pub const ASK_TOKEN: &str = "ask-token.sha256";
/// `groundplan up`: its process; once, unread by daemons.
pub const UP_PROCESS: &str = "up.pid";

// ---- Every daemon.

/// `schedule-eval`, `rasterize`, `waypoint-gen`, `slam-align`, each its own by `SettingKey`: the folder of settings; twice each, stops.
pub const SETTINGS: &str = "settings";
/// Each daemon: the folder of what was done to the site, when and by whom; once, damaged lines are counted and left out.
pub const HISTORY: &str = "history";
/// Each daemon: the folder of records of files that are kept twice; empty files, of which only the names count.
pub const RECORDS: &str = "kept";
/// Each daemon: the version that wrote the folder; once, stops; an empty one is written again.
pub const VERSION: &str = "version";
/// The folder of robots with names.
pub const ROBOTS: &str = "robots";
