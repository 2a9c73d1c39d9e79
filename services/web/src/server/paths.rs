//! Addresses of tiles in paths.

use crate::source::{ContentName, TileAddress};
use crate::tiles::{Layer, TilePlace};

/// The tile that a path names: storey, layer, content, level, column, row with `.png`.
pub(super) fn tile_address(path: (u32, String, String, u32, u32, String)) -> Option<TileAddress> {
    let (storey, layer, name, level, column, row) = path;
    let row = row.strip_suffix(".png")?.parse().ok()?;
    Some(TileAddress {
        storey,
        layer: Layer::named(&layer)?,
        name: ContentName::parse(&name)?,
        place: TilePlace { level, column, row },
    })
}
