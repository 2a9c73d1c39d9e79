//! A product with its body, what cuts it, and what fills it.

use crate::kernel::Record;
use crate::representations::Body;
use diagnostics::Named;

/// A product and the body that was chosen for it.
pub(crate) struct ProductBody<'p, 'a> {
    pub(crate) id: &'p Named,
    pub(crate) record: &'p Record<'a>,
    pub(crate) body: Body,
    /// Openings that void it; empty for all but elements.
    pub(crate) openings: &'p [u32],
    /// Its faces are ground: terrain, a road, earthworks.
    pub(crate) is_ground: bool,
    /// It is an opening.
    pub(crate) cuts: bool,
    /// Doors that fill it, then parts of doors that do, where it is an opening of a wall; empty for all else.
    pub(crate) doors: &'p [u32],
}
