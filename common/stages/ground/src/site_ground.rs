//! The ground of a site, before a schedule state selects from it.

use crate::connections::connections;
use crate::contacts::Contacts;
use crate::covers::{Cover, covers};
use crate::plane::Triangle;
use crate::selected_face::SelectedFace;
use crate::surfaces::Surfaces;
use crate::upward_faces::{MAX_SLOPE_RAD, undersides, upward_faces};
use crate::visible_faces::uncovered;
use geometry::{MeshView, Ring};
use messages::{
    ElementState, GroundBodyRecord, GroundClass, GroundHead, GroundWriter, NONE, OtherSite, ScheduleState, Site,
};

/// Faces of all bodies of ground of a site, and what of them other bodies cover.
#[derive(Debug)]
pub struct SiteGround {
    bodies: Vec<GroundBodyRecord>,
    /// Triangle, slope and body, in the order of the bodies.
    faces: Vec<(Triangle, f32, u32)>,
    /// By face.
    covers: Vec<Cover>,
    /// First of the covers of each face, and the end of the last.
    first_cover: Vec<u32>,
}

impl SiteGround {
    /// The ground of all elements and terrains of a site.
    pub fn of(site: &Site<'_>) -> Self {
        let (mut bodies, mut faces, mut bottoms) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |body: GroundBodyRecord, meshes: &mut dyn Iterator<Item = MeshView<'_>>| {
            let (index, n_faces, n_bottoms) = (bodies.len() as u32, faces.len(), bottoms.len());
            for mesh in meshes {
                let upward = upward_faces(mesh, body.class.get());
                faces.extend(upward.into_iter().map(|(triangle, slope)| (triangle, slope, index)));
                bottoms.extend(undersides(mesh).into_iter().map(|triangle| (triangle, index)));
            }
            if faces.len() > n_faces {
                bodies.push(body);
            } else {
                bottoms.truncate(n_bottoms);
            }
        };
        for (element, record) in (0..).zip(site.elements).filter(|(_, e)| e.ground.get() != GroundClass::None) {
            let body = GroundBodyRecord { element, terrain: NONE, class: record.ground, reserved: [0; 3] };
            add(body, &mut site.element_meshes(record));
        }
        for (terrain, record) in (0..).zip(site.terrains).filter(|(_, t)| t.ground.get() != GroundClass::None) {
            let body = GroundBodyRecord { element: NONE, terrain, class: record.ground, reserved: [0; 3] };
            add(body, &mut site.terrain_meshes(record));
        }
        let tops: Vec<(Triangle, u32)> = faces.iter().map(|(triangle, _, body)| (*triangle, *body)).collect();
        let covers = covers(&tops, &bottoms);
        let first_cover = (0..=faces.len() as u32).map(|k| covers.partition_point(|c| c.face < k) as u32).collect();
        Self { bodies, faces, covers, first_cover }
    }

    /// Writes the ground of the bodies that are built at a schedule state.
    ///
    /// # Errors
    /// A schedule state of another site.
    pub fn at(
        &self,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        out: &mut GroundWriter,
    ) -> Result<(), OtherSite> {
        schedule_state.check_site(site)?;
        let is_built = |body: &GroundBodyRecord| {
            body.element == NONE || schedule_state.effective(body.element as usize) == ElementState::Built
        };
        let is_there: Vec<bool> = self.bodies.iter().map(is_built).collect();
        let faces = self.selected(&is_there);
        let contacts = Contacts::of(&faces);
        let surfaces = Surfaces::of(&faces, &contacts);
        let connections = connections(&surfaces, &contacts);
        let head = GroundHead {
            site_hash: site.content_hash(),
            schedule_state_hash: schedule_state.content_hash(),
            plan_time_s: schedule_state.head.plan_time_s,
            max_slope_rad: MAX_SLOPE_RAD,
        };
        *out = surfaces.written(&faces);
        (out.head, out.bodies, out.connections) = (head, self.bodies.clone(), connections);
        Ok(())
    }

    /// The faces of bodies that are there, without what others that are there cover.
    fn selected(&self, is_there: &[bool]) -> Vec<SelectedFace> {
        let mut selected = Vec::new();
        for (k, (triangle, slope_rad, body)) in self.faces.iter().enumerate() {
            if !is_there[*body as usize] {
                continue;
            }
            let own = &self.covers[self.first_cover[k] as usize..self.first_cover[k + 1] as usize];
            let rings: Vec<&Ring> = own.iter().filter(|c| is_there[c.body as usize]).map(|c| &c.ring).collect();
            let class = self.bodies[*body as usize].class.get();
            let left = uncovered(triangle, &rings).into_iter();
            selected.extend(left.map(|triangle| SelectedFace { triangle, slope_rad: *slope_rad, body: *body, class }));
        }
        selected
    }
}
