//! Static elements of the world at a plan time, as convex pieces.

use crate::element_pieces::pieces_of;
use crate::ground_faces::GroundFaces;
use crate::options::WorldOptions;
use convex::{ConvexBox, Made, Piece, Shape};
use export::ExportInput;
use frames::metres;
use geometry::Ring;
use grid::Class;
use messages::{ElementRecord, NONE, Site, Text};

/// What a static part of the world is in the site, in its order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Body {
    /// This element.
    Element(u32),
    /// This terrain: the shape of a site or road itself.
    Terrain(u32),
    /// Nothing: a barrier or assumed floor.
    StandIn,
}

impl Body {
    /// GlobalId, name and entity name; `None` for what is not in the site.
    pub(crate) fn texts(self, site: &Site<'_>) -> Option<[Text; 3]> {
        match self {
            Self::Element(k) => site.elements.get(k as usize).map(|e| [e.global_id, e.name, e.ifc_type]),
            Self::Terrain(k) => site.terrains.get(k as usize).map(|t| [t.global_id, t.name, t.ifc_type]),
            Self::StandIn => None,
        }
    }

    /// Its class: other for what is no element.
    pub(crate) fn class(self, site: &Site<'_>) -> Class {
        match self {
            Self::Element(k) => site.elements[k as usize].class(),
            Self::Terrain(_) | Self::StandIn => Class::Other,
        }
    }

    /// GlobalId; `None` for what is not in the site.
    pub(crate) fn global_id<'a>(self, site: &Site<'a>) -> Option<&'a str> {
        self.texts(site).map(|[global_id, ..]| site.text(global_id))
    }
}

/// A standing element, terrain, or a stand-in for something that the model lacks.
#[derive(Debug)]
pub(crate) struct StaticElement {
    pub(crate) body: Body,
    /// Its name in the world.
    pub(crate) link: String,
    pub(crate) class: Class,
    /// Map storey that it is shown with.
    pub(crate) storey: u32,
    /// Convex pieces; of ground plates under its faces.
    pub(crate) pieces: Vec<Piece>,
    /// The faces of ground, which are in the place of the pieces where an engine takes them as they are.
    pub(crate) ground: Option<GroundFaces>,
}

impl StaticElement {
    /// A level box that is no element: along `axis` in plan, lengths in metres.
    pub(crate) fn plate(
        link: String,
        class: Class,
        storey: u32,
        centre_m: [f64; 3],
        axis: [f64; 2],
        size_m: [f64; 3],
    ) -> Self {
        let axes = [[axis[0], axis[1], 0.0], [-axis[1], axis[0], 0.0], [0.0, 0.0, 1.0]];
        let shape = Shape::Box(ConvexBox { centre_m, axes, size_m });
        let pieces = vec![Piece { shape, made: Made::Exact, deviation_m: 0.0 }];
        Self { body: Body::StandIn, link, class, storey, pieces, ground: None }
    }

    /// A level slab that is no element: convex plans below a height.
    pub(crate) fn slab(
        link: String,
        class: Class,
        storey: u32,
        plans: Vec<Ring>,
        top_m: f64,
        thickness_m: f64,
    ) -> Self {
        let made = |plan: Ring| Piece {
            shape: Shape::prism(&plan, [top_m - thickness_m, top_m]),
            made: Made::Exact,
            deviation_m: 0.0,
        };
        let pieces = plans.into_iter().map(made).collect();
        Self { body: Body::StandIn, link, class, storey, pieces, ground: None }
    }
}

/// True if the element stands at the plan time, finished or not: as on the maps.
pub(crate) fn stands(input: &ExportInput<'_>, element: u32) -> bool {
    let record = &input.site.elements[element as usize];
    record.n_parts > 0 && input.schedule_state.effective(element as usize).is_obstacle()
}

/// True if the element is ground outdoors, whose faces the world has as they are.
pub(crate) fn is_outdoors(input: &ExportInput<'_>, element: u32) -> bool {
    let record = &input.site.elements[element as usize];
    record.n_parts > 0 && record.ground.get().is_outdoors()
}

/// All standing elements but ground outdoors and those for which `moves` is true, in the order of the site.
pub(crate) fn statics(
    input: &ExportInput<'_>,
    options: &WorldOptions,
    moves: impl Fn(u32) -> bool,
) -> Vec<StaticElement> {
    let site = input.site;
    let is_static = |e: &u32| stands(input, *e) && !moves(*e) && !is_outdoors(input, *e);
    let elements: Vec<u32> = (0..site.elements.len() as u32).filter(is_static).collect();
    let bodies = elements.iter().map(|e| site.element_meshes(&site.elements[*e as usize]).collect());
    let pieces = pieces_of(bodies, &options.piece_options());
    let of = |(element, pieces): (&u32, Vec<Piece>)| {
        let record = &site.elements[*element as usize];
        StaticElement {
            body: Body::Element(*element),
            link: link_name(input, record),
            class: record.class(),
            storey: storey_of(input, record),
            pieces,
            ground: None,
        }
    };
    elements.iter().zip(pieces).map(of).collect()
}

/// Class and GlobalId.
pub(crate) fn link_name(input: &ExportInput<'_>, record: &ElementRecord) -> String {
    format!("{}_{}", record.class().name(), input.site.text(record.global_id))
}

/// The map storey of the storey that contains an element, else the highest whose floor is not above its middle, else the lowest.
pub(crate) fn storey_of(input: &ExportInput<'_>, record: &ElementRecord) -> u32 {
    let site = input.site;
    if record.storey != NONE && site.storeys[record.storey as usize].map_storey != NONE {
        return site.storeys[record.storey as usize].map_storey;
    }
    storey_at(input, (metres(record.min_tenths[2]) + metres(record.max_tenths[2])) / 2.0)
}

/// The highest map storey whose floor is not above a height, else the lowest.
pub(crate) fn storey_at(input: &ExportInput<'_>, z_m: f64) -> u32 {
    let below = input.site.levels().rfind(|(_, s)| metres(s.floor_z_tenths) <= z_m + 1e-6);
    below.map_or(0, |(storey, _)| storey as u32)
}
