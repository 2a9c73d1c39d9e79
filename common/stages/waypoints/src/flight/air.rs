//! Holds the triangles of all that stands at the plan time (elements, doors and glass included, terrain) and of closed rooms, and measures
//! distances from them.

use crate::input::MissionPlanInput;
use geometry::{MeshView, TriangleTree, triangulated};
use grid::Class;
use messages::{GroundClass, NONE, Site, SpaceRecord, space_flags};

/// Triangles of all that flight waypoints keep a distance from.
pub(crate) struct Air {
    /// Elements that are built, being built or being removed, and terrain.
    standing: TriangleTree,
    /// The bodies of rooms that are blocked.
    rooms: TriangleTree,
    bodies: [Vec<Body>; 2],
}

/// A mesh.
#[derive(Debug, Clone, Copy)]
struct Body {
    owner: Owner,
    /// True if it encloses something.
    is_solid: bool,
    /// True if it carries somebody or is a roof: what is above it is not in the room below.
    is_ground: bool,
}

/// Of what a mesh is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    /// An element of the site.
    Element(u32),
    /// A terrain of the site.
    Terrain(u32),
    /// A space of the site.
    Room(u32),
}

/// Triangles in the making.
#[derive(Default)]
struct Bodies {
    triangles: Vec<([[i32; 3]; 3], u32)>,
    bodies: Vec<Body>,
}

impl Bodies {
    fn add<'a>(&mut self, owner: Owner, is_ground: bool, meshes: impl Iterator<Item = MeshView<'a>>) {
        for mesh in meshes {
            let body = self.bodies.len() as u32;
            self.triangles.extend(mesh.corners().map(|corners| (corners, body)));
            self.bodies.push(Body { owner, is_solid: mesh.closed && mesh.volume_m3() != 0.0, is_ground });
        }
    }
}

impl Air {
    /// Of the effective state of a site.
    pub(crate) fn of(input: &MissionPlanInput<'_>) -> Self {
        let MissionPlanInput { site, schedule_state, .. } = *input;
        let (mut standing, mut rooms) = (Bodies::default(), Bodies::default());
        for (k, element) in site.elements.iter().enumerate() {
            if schedule_state.effective(k).is_obstacle() {
                let is_ground = element.ground != GroundClass::None || element.class() == Class::Slab;
                standing.add(Owner::Element(k as u32), is_ground, site.element_meshes(element));
            }
        }
        for (k, terrain) in (0..).zip(site.terrains) {
            standing.add(Owner::Terrain(k), true, site.terrain_meshes(terrain));
        }
        for (k, space) in site.spaces.iter().enumerate() {
            if !schedule_state.is_blocked(k) || space.has(space_flags::METADATA_ONLY) {
                continue;
            }
            if space.n_parts > 0 {
                rooms.add(Owner::Room(k as u32), false, site.space_meshes(space));
            } else {
                let (body, triangles) = (rooms.bodies.len() as u32, prism(site, space));
                rooms.triangles.extend(triangles.into_iter().map(|corners| (corners, body)));
                rooms.bodies.push(Body { owner: Owner::Room(k as u32), is_solid: true, is_ground: false });
            }
        }
        let bodies = [standing.bodies, rooms.bodies];
        Self { standing: TriangleTree::of(standing.triangles), rooms: TriangleTree::of(rooms.triangles), bodies }
    }

    /// Distance to the nearest triangle of what stands or of a closed room, at most `reach`; in tenths of a millimetre.
    pub(crate) fn distance(&self, place: [i32; 3], reach: f64) -> f64 {
        let near = self.standing.nearest(place, reach).map_or(reach, |nearest| nearest.distance);
        self.rooms.nearest(place, near).map_or(near, |nearest| nearest.distance)
    }

    /// The nearest of what stands, if any is nearer than `reach`, and how far it is; in tenths of a millimetre.
    pub(crate) fn nearest(&self, place: [i32; 3], reach: f64) -> Option<(Owner, f64)> {
        let nearest = self.standing.nearest(place, reach)?;
        Some((self.bodies[0][nearest.body as usize].owner, nearest.distance))
    }

    /// True if all places of a segment keep a distance from what stands and from closed rooms.
    pub(crate) fn is_clear(&self, ends: [[i32; 3]; 2], distance: f64) -> bool {
        self.standing.is_clear(ends, distance) && self.rooms.is_clear(ends, distance)
    }

    /// True if something that carries somebody, or a roof, lies between a place and one so high above it.
    pub(crate) fn has_ground_above(&self, place: [i32; 3], height: f64) -> bool {
        let mut is_between = false;
        self.standing.each_above(place, |body, _, above| {
            is_between |= above < height && self.bodies[0][body as usize].is_ground;
        });
        is_between
    }

    /// The first body within which a place lies that is not on the surface of any.
    pub(crate) fn body_around(&self, place: [i32; 3]) -> Option<Owner> {
        [&self.standing, &self.rooms].into_iter().zip(&self.bodies).find_map(|(tree, bodies)| {
            // Of most bodies the line upwards meets none or a few triangles.
            let mut turns: Vec<(u32, i32)> = Vec::new();
            tree.each_above(place, |body, turn, _| turns.push((body, turn)));
            turns.sort_unstable();
            let around = turns.chunk_by(|a, b| a.0 == b.0).find(|of_body| {
                bodies[of_body[0].0 as usize].is_solid && of_body.iter().map(|(_, turn)| turn).sum::<i32>() != 0
            });
            around.map(|of_body| bodies[of_body[0].0 as usize].owner)
        })
    }
}

impl Owner {
    /// Element and terrain of records, of which at most one is not [`NONE`].
    pub(crate) fn numbers(self) -> [u32; 2] {
        match self {
            Self::Element(element) => [element, NONE],
            Self::Terrain(terrain) => [NONE, terrain],
            Self::Room(_) => [NONE, NONE],
        }
    }
}

/// The body of a space that has none: its floor up to its height.
fn prism(site: &Site<'_>, space: &SpaceRecord) -> Vec<[[i32; 3]; 3]> {
    let polygon = site.floor_polygon(space);
    let [low, high] = [space.floor_z_tenths, space.floor_z_tenths.saturating_add(space.height_tenths)];
    let at = |[x, y]: [i32; 2], z: i32| [x, y, z];
    let mut triangles = Vec::new();
    for [a, b, c] in triangulated(&polygon) {
        triangles.extend([[at(a, high), at(b, high), at(c, high)], [at(c, low), at(b, low), at(a, low)]]);
    }
    for ring in polygon.0.iter().flat_map(|polygon| polygon.rings()) {
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            triangles.extend([[at(a, low), at(b, low), at(b, high)], [at(a, low), at(b, high), at(a, high)]]);
        }
    }
    triangles
}
