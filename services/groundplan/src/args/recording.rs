//! Arguments of recordings.

/// What a recording has beside what all have.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct RecordingArgs {
    /// Record heights, slopes and traversability too: topics grid_map (grid_map_msgs/GridMap) and elevation (the same as
    /// foxglove_msgs/Grid, which Foxglove colours); 24 bytes for each cell before compression, where a map has one
    #[arg(long)]
    pub(crate) grid_map: bool,

    /// Record the limits of speed of the robot's profile ([[safety]]) too: topics speed_mask and speed_info
    #[arg(long)]
    pub(crate) speed_mask: bool,
}
