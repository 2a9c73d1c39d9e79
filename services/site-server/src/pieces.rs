//! Archives of one schedule state for a store, as they are on the bus or will be.

use messages::{ArchiveBuffer, ContentHash};
use replica::IndexClock;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An archive of a topic.
#[derive(Clone)]
pub struct Piece {
    /// The topic: archives of one topic have blocks in common.
    pub topic: String,
    /// Its content hash.
    pub hash: ContentHash,
    /// Its bytes.
    pub bytes: Arc<ArchiveBuffer>,
}

/// What all sets have in common.
#[derive(Clone)]
pub struct SitePieces {
    /// The site.
    pub site: Piece,
    /// The tasks of schedule files.
    pub tasks: Option<Piece>,
    /// Counts the changes of the map frame.
    pub frame_epoch: u64,
    /// How the plan time moves.
    pub clock: IndexClock,
}

/// The archives of one plan time.
#[derive(Clone)]
pub struct SetPieces {
    /// Civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// The instant after which it is not valid.
    pub valid_until_s: Option<i64>,
    /// The schedule state.
    pub state: Piece,
    /// By name of the robot in the index.
    pub robots: BTreeMap<String, RobotPieces>,
}

/// The maps of a robot.
#[derive(Clone)]
pub struct RobotPieces {
    /// The index of the grids.
    pub grids: Piece,
    /// The mission plan; `None` while it is planned.
    pub mission_plan: Option<Piece>,
    /// Hash of what the maps depend on of the robot.
    pub robot_hash: ContentHash,
    /// The storeys, in the order of the index of the grids.
    pub storeys: Vec<StoreyPiece>,
}

/// The map of a storey.
#[derive(Clone)]
pub struct StoreyPiece {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Name.
    pub name: String,
    /// GlobalId; empty where the site has none.
    pub global_id: String,
    /// Hash of what alone can change the grid.
    pub input_hash: ContentHash,
    /// The grid.
    pub grid: Piece,
}

impl Piece {
    /// A copy of an archive.
    pub fn copy_of(topic: String, hash: ContentHash, bytes: &[u8]) -> Self {
        Self { topic, hash, bytes: Arc::new(ArchiveBuffer::copy_of(bytes)) }
    }

    /// The topic of a robot's archives.
    pub fn topic_of(robot: &str, topic: &str) -> String {
        format!("{robot}/{topic}")
    }
}

/// What identifies what all robots have: the same hashes are the same.
pub type SetKey = Vec<ContentHash>;
