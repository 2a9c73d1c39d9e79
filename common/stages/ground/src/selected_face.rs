//! Faces that a schedule state selects.

use crate::plane::Triangle;
use messages::GroundClass;

/// A face of a body that is there, or an uncovered part of one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SelectedFace {
    pub(crate) triangle: Triangle,
    pub(crate) slope_rad: f32,
    pub(crate) body: u32,
    pub(crate) class: GroundClass,
}
