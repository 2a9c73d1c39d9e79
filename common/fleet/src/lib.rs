//! Files for the control of a fleet, of a site at a date: zones and map downloads by VDA 5050, layouts by LIF.
//!
//! ```text
//! groundplan convert house.ifc -o maps --date 2024-04-15 --fleet vda5050,lif
//! ```
//!
//! | file | content |
//! |---|---|
//! | `fleet/vda5050/INDEX-NAME.zoneSet.json` | the `zoneSet` message of a storey: `BLOCKED`, `SPEED_LIMIT`, `RELEASE` |
//! | `fleet/vda5050/INDEX-NAME.map.tar` | the maps of a storey as one file, as downloads of maps have to be |
//! | `fleet/vda5050/maps.json` | ids, versions, hashes, and the instant actions that download and enable maps and zone sets |
//! | `fleet/lif/site.lif.json` | the route graph, a layout for each storey |
//!
//! Coordinates are metres in `map`. Ids are of the characters that VDA 5050 recommends (7.1.2): `$` of GlobalIds, and what else is not
//! among them, is `.` in ids, and is written as it is in descriptors.
//!
//! # VDA 5050
//!
//! - The polygons of `BLOCKED` zones are the cells of the keep-out mask, no more and no less, along their borders; those of
//!   `SPEED_LIMIT` zones the cells with a limit in the speed mask, with the limit of the rule, which the mask rounds down. Zones of one
//!   type do not overlap, are simple, counter-clockwise, without holes, and end at the border of the map (6.4.2, 7.6).
//! - A robot must not touch these zones with its contour (6.4.1.1), while the mask is for its centre: with zones it keeps its radius
//!   more distance than with the mask. A route of the graph that passes work or a drop-off nearer than that is told by fleets as blocked.
//! - A `RELEASE` zone lies in the way through a door that is closed to this robot only because it cannot open it. On the map it is an
//!   obstacle as long as it is shut; someone opens it, and then grants the release. Where a release is lost the robot stops, which is
//!   also what happens where nothing is said.
//! - A zone set has an id of its content: the same zones on the same map have the same id and the same bytes at every date, any other
//!   zones another id. `headerId`, `timestamp`, `manufacturer` and `serialNumber` are those of a message to one robot: whoever sends it
//!   sets them, and they are 0, 1970 and empty here.
//! - The bytes satisfy the schemas as first published with 3.0.0 and as corrected later: what the corrections renamed is of zone
//!   types that are not used here, and `releaseLossBehavior`, which they require, the first ones allow.
//! - A store of a site has `maps.json` with its own links and the instant at which robots go on to the maps
//!   ([`vda5050::StoreMapsDocument`], `config/schemas/fleet-store-maps.schema.json`).
//! - A map has the id of its storey, the same at every date, and the version of its content. No format of map files is standardised: the
//!   tar has the files of Nav2, `planning`, `localization` and `keepout`.
//!
//! # LIF
//!
//! - Only what this robot can use is there: edges that it cannot take are left out, as LIF demands. It has no zones.
//! - Ids of nodes are of what they are at, and the storey: a space, a door, a place in centimetres. What stays where it is keeps its id at
//!   every date. A way is an edge in each direction; one that leads to another storey ends in its layout.
//! - A line with corners is a curve of degree 1. Centres of rooms are stations.
//! - `exportTimestamp` is the plan time, as if the site's clock showed UTC, or 1970: output has no clock of its own.
//!
//! # Sources
//!
//! - VDA 5050 3.0.0, `VDA5050_EN.md` and `json_schemas/zoneSet.schema` of github.com/VDA5050/VDA5050: instant actions 6.2.1 and 6.2.3.1
//!   (`downloadMap`, `enableMap`, `downloadZoneSet`, `enableZoneSet`), maps 6.3, zones 6.4 and 7.6.
//! - LIF 1.0.0, VDMA, March 2024: nodes, edges between layouts 8.3.8; its schema `lif-schema.json` of github.com/continua-systems/vdma-lif.
//!
//! # Where
//!
//! - why a cell is keep-out: `src/vda5050/keepout_reasons.rs`
//! - cells as polygons: `src/vda5050/areas.rs`
//! - ids: `src/ids.rs`, those of nodes and edges `src/lif/names.rs`

mod ids;

pub mod lif;
pub mod vda5050;

use export::{ExportFile, ExportInput};

/// A format for the control of fleets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FleetFormat {
    /// Zone sets and map downloads of VDA 5050.
    Vda5050,
    /// Layouts of LIF.
    Lif,
}

impl FleetFormat {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Vda5050, Self::Lif];

    /// Its name on the command line, and of its folder.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vda5050 => "vda5050",
            Self::Lif => "lif",
        }
    }
}

/// The files of these formats, in `fleet/`.
pub fn files(input: &ExportInput<'_>, formats: &[FleetFormat]) -> Vec<ExportFile> {
    let of = |format: &FleetFormat| match format {
        FleetFormat::Vda5050 => vda5050::files(input),
        FleetFormat::Lif => lif::files(input),
    };
    let is_asked_for = |format: &&FleetFormat| formats.contains(format);
    FleetFormat::ALL.iter().filter(is_asked_for).flat_map(of).collect()
}
