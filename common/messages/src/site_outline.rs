//! Parts of a site by which two revisions are compared: sources, georeference, storeys, elements, rooms, warnings.

use crate::archive::NONE;
use crate::site::Site;
use diagnostics::{DiagnosticCode, Severity};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The outline of a site. It does not depend on the layout of archives, so that a site is compared with one that a version with
/// another layout read.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SiteOutline {
    /// Where the model lies on earth; `None` if no file says it.
    pub georeference: Option<GeoreferenceOutline>,
    /// Storeys, in file order.
    pub storeys: Vec<StoreyOutline>,
    /// Elements by GlobalId.
    pub elements: BTreeMap<String, ElementOutline>,
    /// Names of rooms by GlobalId.
    pub rooms: BTreeMap<String, String>,
    /// Storeys that have a map, from low to high.
    pub map_storeys: Vec<MapStoreyOutline>,
    /// Warnings and errors about the files.
    pub n_warnings: usize,
    /// Those of them that a file has of which two versions are mixed, or of which a part is missing: records that cannot be read,
    /// ids that are used again, references to nothing.
    pub n_damages: usize,
}

/// A map conversion: metres in the projected system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GeoreferenceOutline {
    /// Name of the projected system.
    pub crs: String,
    /// Eastings, northings and height of the origin of `world`.
    pub origin_m: [f64; 3],
    /// The x axis of `world` in eastings and northings.
    pub x_axis: [f64; 2],
    /// Metres in the projected system per metre of `world`.
    pub scale: [f64; 3],
}

/// A storey.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoreyOutline {
    /// GlobalId.
    pub global_id: String,
    /// Name.
    pub name: String,
}

/// A storey that has a map.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapStoreyOutline {
    /// GlobalId of the storey it is named after.
    pub global_id: String,
    /// Name.
    pub name: String,
    /// Height of the finished floor in `map`, in tenths of a millimetre.
    pub floor_z_tenths: i32,
}

/// An element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ElementOutline {
    /// Index of the storey that contains it.
    pub storey: Option<u32>,
    /// Lower and upper corner of its body in `map`, in tenths of a millimetre; `None` without one.
    pub bounds_tenths: Option<[[i32; 3]; 2]>,
}

/// What is found in a file of which two versions are mixed, or a part is missing.
const DAMAGES: [DiagnosticCode; 3] =
    [DiagnosticCode::DuplicateId, DiagnosticCode::RecordMalformed, DiagnosticCode::ReferenceDangling];

impl SiteOutline {
    /// The outline of a site.
    pub fn of(site: &Site<'_>) -> Self {
        let text = |text| site.text(text).to_owned();
        let head = site.head;
        let georeference = (head.has_earth == 1).then(|| GeoreferenceOutline {
            crs: text(head.earth_crs),
            origin_m: head.earth_m,
            x_axis: head.earth_x_axis,
            scale: head.earth_scale,
        });
        let element = |e: &crate::ElementRecord| ElementOutline {
            storey: Some(e.storey).filter(|storey| *storey != NONE),
            bounds_tenths: (e.n_parts > 0).then_some([e.min_tenths, e.max_tenths]),
        };
        let is_warning = |severity: Option<Severity>| severity.is_some_and(|s| s != Severity::Info);
        let map_storey = |s: &crate::MapStoreyRecord| MapStoreyOutline {
            global_id: text(s.global_id),
            name: text(s.name),
            floor_z_tenths: s.floor_z_tenths,
        };
        let is_damage = |code: Option<DiagnosticCode>| code.is_some_and(|code| DAMAGES.contains(&code));
        Self {
            georeference,
            storeys: site
                .storeys
                .iter()
                .map(|s| StoreyOutline { global_id: text(s.global_id), name: text(s.name) })
                .collect(),
            elements: site.elements.iter().map(|e| (text(e.global_id), element(e))).collect(),
            rooms: site.spaces.iter().map(|s| (text(s.global_id), text(s.name))).collect(),
            map_storeys: site.map_storeys.iter().map(map_storey).collect(),
            n_damages: site.diagnostics.iter().filter(|d| is_damage(d.code.known())).count(),
            n_warnings: site.diagnostics.iter().filter(|d| is_warning(d.severity.known())).count(),
        }
    }
}
