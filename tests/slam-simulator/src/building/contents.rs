//! Counts of the things in a building that its model does not have.

use serde::Serialize;

/// Number of things in a building that the model does not have.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Contents {
    /// Walls that are missing.
    pub walls_removed: usize,
    /// Walls that are elsewhere.
    pub walls_moved: usize,
    /// Additional walls.
    pub walls_added: usize,
    /// Length of walls of glass.
    pub glass_m: f64,
    /// Door leaves, whatever their angle.
    pub door_leaves: usize,
    /// Pieces of furniture.
    pub furniture: usize,
    /// People who stand.
    pub people_standing: usize,
}
