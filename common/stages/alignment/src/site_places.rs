//! Place hints of a site: rooms, floors of storeys, stairs, ramps and lifts by name, height or GlobalId.

use crate::place_hints::{Area, PlaceHint};
use crate::rooms::Room;
use diagnostics::{Called, NothingCalled, called, counted};
use frames::metres;
use grid::Class;
use messages::{ElementRecord, Site};

/// A stair, a ramp or a lift.
#[derive(Debug, Clone, PartialEq)]
pub struct Portal {
    /// GlobalId.
    pub global_id: String,
    /// Name; may be empty.
    pub name: String,
    /// True for a lift, which stops at every storey wherever its body is modelled.
    pub is_lift: bool,
    /// Corners of the upright box around it in `map`, in metres.
    pub bounds_m: [[f64; 3]; 2],
}

impl Called for &Portal {
    fn global_id(&self) -> &str {
        &self.global_id
    }

    fn names(&self) -> Vec<&str> {
        vec![&self.name]
    }
}

/// Places of a site.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SitePlaces {
    /// All rooms.
    pub rooms: Vec<Room>,
    /// Map storeys, each with the height of its floor in `map`, in metres.
    pub floors: Vec<(u32, f64)>,
    /// Stairs, ramps and lifts.
    pub portals: Vec<Portal>,
}

/// A hint that names what the site does not have.
#[derive(Debug, thiserror::Error)]
pub enum UnknownPlace {
    /// Maps alone.
    #[error("these maps know neither rooms nor storeys: give the folder that `groundplan convert` wrote, or a site")]
    NoSite,
    /// A site without rooms.
    #[error("the site has no rooms, so none is called {wanted:?}")]
    NoRooms {
        /// What was asked for.
        wanted: String,
    },
    /// No such room.
    #[error(transparent)]
    Room(#[from] NothingCalled),
    /// No floor is there.
    #[error("no storey has its floor within {HALF_STOREY_M} m of elevation {elevation_m} m: floors are at {floors} m")]
    Elevation {
        /// What was asked for.
        elevation_m: f64,
        /// Heights of all floors.
        floors: String,
    },
    /// No such stair, ramp or lift.
    #[error("there is no stair, ramp or lift {wanted:?} among {among}{nearest}")]
    Portal {
        /// What was asked for.
        wanted: String,
        /// How many there are.
        among: String,
        /// The nearest names, as the end of the message; may be empty.
        nearest: String,
    },
}

/// The bounds of two boxes.
pub fn joined([lo, hi]: [[f64; 3]; 2], [other_lo, other_hi]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    [[0, 1, 2].map(|k| f64::min(lo[k], other_lo[k])), [0, 1, 2].map(|k| f64::max(hi[k], other_hi[k]))]
}

/// Half of the height of a low storey, in metres.
const HALF_STOREY_M: f64 = 1.5;
/// A stair begins and ends at floors so near to its body in height, in metres.
const LANDING_M: f64 = 0.5;

impl SitePlaces {
    /// Those of a site.
    pub fn of(site: &Site<'_>) -> Self {
        let portal = |(index, element): (u32, &ElementRecord)| {
            let is_lift = site.text(element.ifc_type).eq_ignore_ascii_case("IfcTransportElement");
            let is_portal = is_lift || [Class::Stair, Class::Ramp].contains(&element.class());
            let of_portal = |other: &&ElementRecord| other.whole == index && other.n_parts > 0;
            let parts = site.elements.iter().filter(|_| is_portal).filter(of_portal);
            let bodies = Some(element).filter(|element| is_portal && element.n_parts > 0).into_iter().chain(parts);
            let bounds = bodies.map(|body| [body.min_tenths.map(metres), body.max_tenths.map(metres)]);
            Some(Portal {
                global_id: site.text(element.global_id).to_owned(),
                name: site.text(element.name).to_owned(),
                is_lift,
                bounds_m: bounds.reduce(joined)?,
            })
        };
        Self {
            rooms: Room::all_of(site),
            floors: site.levels().map(|(k, storey)| (k as u32, metres(storey.floor_z_tenths))).collect(),
            portals: (0..).zip(site.elements).filter_map(portal).collect(),
        }
    }

    /// The hints for points of the SLAM map that lie in rooms, the height of the floor, and a portal.
    ///
    /// # Errors
    /// What the site does not have.
    pub fn hints<'a>(
        &self,
        points_in_rooms: impl IntoIterator<Item = ([f64; 2], &'a str)>,
        elevation_m: Option<f64>,
        portal: Option<&str>,
    ) -> Result<Vec<PlaceHint>, UnknownPlace> {
        let rooms = points_in_rooms.into_iter().map(|(in_slam_m, room)| self.in_room(in_slam_m, room));
        let elevation = elevation_m.map(|elevation_m| self.at_elevation(elevation_m));
        rooms.chain(elevation).chain(portal.map(|portal| self.behind_portal(portal))).collect()
    }

    /// A point of the SLAM map lies in a room, which is given by number, name or GlobalId.
    ///
    /// # Errors
    /// There is no such room.
    pub fn in_room(&self, in_slam_m: [f64; 2], wanted: &str) -> Result<PlaceHint, UnknownPlace> {
        if self.floors.is_empty() {
            return Err(UnknownPlace::NoSite);
        }
        if self.rooms.is_empty() {
            return Err(UnknownPlace::NoRooms { wanted: wanted.to_owned() });
        }
        let [x_m, y_m] = in_slam_m;
        let label = match in_slam_m == [0.0; 2] {
            true => format!("start in room {wanted}"),
            false => format!("x {x_m} m, y {y_m} m in room {wanted}"),
        };
        let rooms = called("room", self.rooms.iter().collect(), wanted)?;
        let areas = rooms.into_iter().map(|room| Area::Room { in_slam_m, room: room.clone() }).collect();
        Ok(PlaceHint { label, areas })
    }

    /// The floor under the robot is at this height in `map`, in metres.
    ///
    /// # Errors
    /// There is no such floor.
    pub fn at_elevation(&self, elevation_m: f64) -> Result<PlaceHint, UnknownPlace> {
        if self.floors.is_empty() {
            return Err(UnknownPlace::NoSite);
        }
        let is_there = |(_, floor_m): &&(u32, f64)| (floor_m - elevation_m).abs() <= HALF_STOREY_M;
        let areas: Vec<Area> = self.floors.iter().filter(is_there).map(|(storey, _)| Area::Storey(*storey)).collect();
        if areas.is_empty() {
            let floors: Vec<String> = self.floors.iter().map(|(_, floor_m)| format!("{floor_m:.2}")).collect();
            return Err(UnknownPlace::Elevation { elevation_m, floors: floors.join(", ") });
        }
        Ok(PlaceHint { label: format!("elevation {elevation_m} m"), areas })
    }

    /// The robot came through a stair, a ramp or a lift, given by name or GlobalId, and its map shows where that ends.
    ///
    /// # Errors
    /// There is no such portal.
    pub fn behind_portal(&self, wanted: &str) -> Result<PlaceHint, UnknownPlace> {
        if self.floors.is_empty() {
            return Err(UnknownPlace::NoSite);
        }
        let portals = called("stair, ramp or lift", self.portals.iter().collect(), wanted);
        let unknown = |nothing: NothingCalled| UnknownPlace::Portal {
            among: counted(self.portals.len(), "portal"),
            nearest: nothing.nearest_hint(),
            wanted: nothing.wanted,
        };
        let area = |portal: &Portal| {
            let [lo, hi] = portal.bounds_m;
            let ends = self.floors.iter().filter(|(_, floor_m)| {
                portal.is_lift || (lo[2] - LANDING_M <= *floor_m && *floor_m <= hi[2] + LANDING_M)
            });
            let map_storeys = ends.map(|(storey, _)| *storey).collect();
            Area::Beside { map_storeys, bounds_m: [[lo[0], lo[1]], [hi[0], hi[1]]] }
        };
        let areas = portals.map_err(unknown)?.into_iter().map(area).collect();
        Ok(PlaceHint { label: format!("portal {wanted}"), areas })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places() -> SitePlaces {
        let portal = |name: &str, is_lift, z: [f64; 2]| Portal {
            global_id: format!("id-{name}"),
            name: name.to_owned(),
            is_lift,
            bounds_m: [[1.0, 2.0, z[0]], [3.0, 6.0, z[1]]],
        };
        let room = Room { name: "U.04".to_owned(), ..Room::default() };
        SitePlaces {
            rooms: vec![room],
            floors: vec![(0, 0.0), (1, 3.1), (2, 6.2), (3, 3.55)],
            portals: vec![portal("Stair 1", false, [0.1, 3.1]), portal("Lift", true, [0.0, 2.0])],
        }
    }

    fn storeys(hint: &PlaceHint) -> Vec<u32> {
        hint.areas
            .iter()
            .flat_map(|area| match area {
                Area::Storey(storey) => vec![*storey],
                Area::Room { room, .. } => vec![room.map_storey],
                Area::Beside { map_storeys, .. } => map_storeys.clone(),
            })
            .collect()
    }

    #[test]
    fn elevations_and_portals_choose_storeys() {
        let places = places();
        assert_eq!(storeys(&places.at_elevation(3.0).unwrap()), [1, 3]);
        assert_eq!(storeys(&places.at_elevation(6.9).unwrap()), [2]);
        assert_eq!(storeys(&places.behind_portal("stair 1").unwrap()), [0, 1, 3]);
        assert_eq!(storeys(&places.behind_portal("id-Lift").unwrap()), [0, 1, 2, 3]);
        assert_eq!(places.in_room([0.0; 2], "U.04").unwrap().label, "start in room U.04");
        assert_eq!(places.in_room([1.5, -2.0], "u.04").unwrap().label, "x 1.5 m, y -2 m in room u.04");
    }

    #[test]
    fn what_the_site_does_not_have_is_told_with_what_comes_nearest() {
        let text = |result: Result<PlaceHint, UnknownPlace>| result.unwrap_err().to_string();
        let places = places();
        assert_eq!(text(places.in_room([0.0; 2], "U.05")), "there is no room \"U.05\"; nearest: \"U.04\"");
        assert_eq!(
            text(places.at_elevation(-4.0)),
            "no storey has its floor within 1.5 m of elevation -4 m: floors are at 0.00, 3.10, 6.20, 3.55 m"
        );
        assert_eq!(
            text(places.behind_portal("Stair 2")),
            "there is no stair, ramp or lift \"Stair 2\" among 2 portals; nearest: \"Stair 1\""
        );
        let without_rooms = SitePlaces { rooms: Vec::new(), ..places };
        assert!(text(without_rooms.in_room([0.0; 2], "1")).contains("has no rooms"));
        let maps = SitePlaces::default();
        for hint in [maps.in_room([0.0; 2], "1"), maps.at_elevation(0.0), maps.behind_portal("Lift")] {
            assert!(text(hint).contains("groundplan convert"));
        }
    }
}
