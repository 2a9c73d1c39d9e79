//! Archives of one schedule state for a store, as they are on the bus or will be.

use messages::{ArchiveBuffer, ContentHash};
use replica::IndexClock;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An archive of a topic.
#[derive(Clone)]
pub(crate) struct Piece {
    /// The topic: archives of one topic have blocks in common.
    pub(crate) topic: String,
    /// Its content hash.
    pub(crate) hash: ContentHash,
    /// Its bytes.
    pub(crate) bytes: Arc<ArchiveBuffer>,
}

/// What all sets have in common.
pub(crate) struct SitePieces {
    pub(crate) site: Piece,
    pub(crate) tasks: Option<Piece>,
    pub(crate) frame_epoch: u64,
    pub(crate) clock: IndexClock,
}

/// The archives of one plan time.
pub(crate) struct SetPieces {
    pub(crate) plan_time_s: Option<i64>,
    pub(crate) valid_until_s: Option<i64>,
    pub(crate) state: Piece,
    /// By name of the robot in the index.
    pub(crate) robots: BTreeMap<String, RobotPieces>,
}

/// The maps of a robot.
pub(crate) struct RobotPieces {
    pub(crate) grids: Piece,
    pub(crate) mission_plan: Option<Piece>,
    pub(crate) robot_hash: ContentHash,
    pub(crate) storeys: Vec<StoreyPiece>,
}

/// The map of a storey.
pub(crate) struct StoreyPiece {
    pub(crate) map_storey: u32,
    pub(crate) name: String,
    pub(crate) global_id: String,
    pub(crate) input_hash: ContentHash,
    pub(crate) grid: Piece,
}

impl Piece {
    /// A copy of an archive.
    pub(crate) fn copy_of(topic: String, hash: ContentHash, bytes: &[u8]) -> Self {
        Self { topic, hash, bytes: Arc::new(ArchiveBuffer::copy_of(bytes)) }
    }

    /// The topic of a robot's archives.
    pub(crate) fn topic_of(robot: &str, topic: &str) -> String {
        format!("{robot}/{topic}")
    }
}

/// What identifies what all robots have: the same hashes are the same.
pub(crate) type SetKey = Vec<ContentHash>;
