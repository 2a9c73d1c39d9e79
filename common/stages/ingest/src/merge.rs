//! Merges the models of all files into one, with indices and coordinates remapped.

use crate::by_global_id::merged_indices;
use crate::error::IngestError;
use crate::federation::{FederatedFile, Federation, federate, same_body};
use crate::input::{FilePlacement, SourceFile};
use crate::schedule_merge::{self, ScheduleSources};
use frames::{UprightRigid3, World};
use ifc::{Diagnostic, DiagnosticCode, Element, Geometry, LinkTarget, Model, Severity, Terrain};

/// All files as one model in the first file's world, and which file each thing comes from.
#[derive(Debug)]
pub(crate) struct Merged {
    pub(crate) model: Model,
    pub(crate) element_source: Vec<u32>,
    pub(crate) space_source: Vec<u32>,
    pub(crate) terrain_source: Vec<u32>,
    pub(crate) storey_source: Vec<u32>,
    pub(crate) schedule_sources: ScheduleSources,
    pub(crate) schemas: Vec<(String, f64)>,
    pub(crate) diagnostics: Vec<(u32, Diagnostic)>,
}

/// A file of the site with what was read from it.
pub(crate) struct FileModel<'a> {
    pub(crate) file: &'a SourceFile,
    pub(crate) model: Model,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Placement given by the user.
    pub(crate) place: Option<FilePlacement>,
}

impl Merged {
    /// All files as one.
    ///
    /// # Errors
    /// No files, files that lie too far apart, an element of two files with two bodies.
    pub(crate) fn of(files: Vec<FileModel<'_>>, prefer_last: bool) -> Result<Self, IngestError> {
        let names: Vec<String> = files.iter().map(|f| f.file.name()).collect();
        let parts: Vec<FederatedFile<'_>> = std::iter::zip(&files, &names)
            .map(|(f, name)| FederatedFile { name, model: &f.model, place: f.place })
            .collect();
        let Federation { site_from_file, georeference, diagnostics } = federate(&parts)?;
        let mut files = files.into_iter().zip(&site_from_file);
        let (first, motion) = files.next().ok_or(IngestError::NoFiles)?;
        let mut merged = Self::start(first, motion);
        merged.model.georeference = georeference;
        merged.diagnostics.extend(diagnostics);
        for (file, motion) in files {
            merged.add(file, motion, prefer_last)?;
        }
        Ok(merged)
    }

    fn start(first: FileModel<'_>, motion: &UprightRigid3<World, World>) -> Self {
        let FileModel { mut model, diagnostics, .. } = first;
        move_model(&mut model, motion);
        let mut schedule_sources = ScheduleSources::default();
        schedule_sources.extend(&model.schedule, 0);
        Self {
            schedule_sources,
            element_source: vec![0; model.elements.len()],
            space_source: vec![0; model.spaces.len()],
            terrain_source: vec![0; model.terrains.len()],
            storey_source: vec![0; model.storeys.len()],
            schemas: vec![(model.source.schema.clone(), model.source.length_unit_m)],
            diagnostics: diagnostics.into_iter().map(|d| (0, d)).collect(),
            model,
        }
    }

    fn add(
        &mut self,
        other: FileModel<'_>,
        motion: &UprightRigid3<World, World>,
        prefer_last: bool,
    ) -> Result<(), IngestError> {
        let FileModel { file, mut model, diagnostics, .. } = other;
        move_model(&mut model, motion);
        let source = self.schemas.len() as u32;
        self.schemas.push((model.source.schema.clone(), model.source.length_unit_m));
        self.diagnostics.extend(diagnostics.into_iter().map(|d| (source, d)));
        self.append(file, model, source, prefer_last)
    }

    fn append(&mut self, file: &SourceFile, other: Model, source: u32, prefer_last: bool) -> Result<(), IngestError> {
        let Model { elements, spaces, storeys, openings, terrains, boundaries, schedule, .. } = other;
        self.add_terrains(terrains, source);
        let storey_at = merged_indices(&self.model.storeys, &storeys, |s| &s.id.global_id);
        let element_at = merged_indices(&self.model.elements, &elements, |e| &e.id.global_id);
        let space_at = merged_indices(&self.model.spaces, &spaces, |s| &s.id.global_id);
        let opening_at = merged_indices(&self.model.openings, &openings, |o| &o.id.global_id);
        for (storey, at) in storeys.into_iter().zip(&storey_at) {
            if *at == self.model.storeys.len() {
                self.model.storeys.push(storey);
                self.storey_source.push(source);
            }
        }
        for (mut element, at) in elements.into_iter().zip(&element_at) {
            element.storey = element.storey.map(|k| storey_at[k]);
            element.space = element.space.map(|k| space_at[k]);
            element.whole = element.whole.map(|k| element_at[k]);
            element.fills = element.fills.map(|k| opening_at[k]);
            if *at == self.model.elements.len() {
                self.model.elements.push(element);
                self.element_source.push(source);
            } else {
                self.replace(file, *at, element, source, prefer_last)?;
            }
        }
        for (mut space, at) in spaces.into_iter().zip(&space_at) {
            space.storey = space.storey.map(|k| storey_at[k]);
            if *at == self.model.spaces.len() {
                self.model.spaces.push(space);
                self.space_source.push(source);
            }
        }
        for (mut opening, at) in openings.into_iter().zip(&opening_at) {
            opening.host = opening.host.map(|k| element_at[k]);
            opening.filling = opening.filling.map(|k| element_at[k]);
            if *at == self.model.openings.len() {
                self.model.openings.push(opening);
            }
        }
        let moved = boundaries
            .into_iter()
            .map(|b| ifc::SpaceBoundary { space: space_at[b.space], element: element_at[b.element] });
        self.model.boundaries.extend(moved);
        self.model.boundaries.sort_unstable();
        self.model.boundaries.dedup();
        schedule_merge::append(&mut self.model.schedule, schedule, |target| match target {
            LinkTarget::Element(k) => LinkTarget::Element(element_at[k]),
            LinkTarget::Space(k) => LinkTarget::Space(space_at[k]),
            LinkTarget::Storey(k) => LinkTarget::Storey(storey_at[k]),
        });
        self.schedule_sources.extend(&self.model.schedule, source);
        Ok(())
    }

    /// Files of one project often share the site: of shapes with one GlobalId the first counts, and another one is told.
    fn add_terrains(&mut self, terrains: Vec<Terrain>, source: u32) {
        for terrain in terrains {
            let known = self.model.terrains.iter().find(|t| t.id.global_id == terrain.id.global_id);
            if known.is_some_and(|known| !same_body(&known.geometry, &terrain.geometry)) {
                let message = format!("an earlier file has another shape of this {}, which counts", terrain.ifc_type);
                let (severity, code) = (Severity::Warning, DiagnosticCode::TerrainIncomplete);
                let diagnostic = Diagnostic { severity, code, entity: Some(terrain.id.clone()), source: None, message };
                self.diagnostics.push((source, diagnostic));
            }
            if known.is_none() {
                self.model.terrains.push(terrain);
                self.terrain_source.push(source);
            }
        }
    }

    /// An element that an earlier file has, too.
    fn replace(
        &mut self,
        file: &SourceFile,
        at: usize,
        element: Element,
        source: u32,
        prefer_last: bool,
    ) -> Result<(), IngestError> {
        if same_body(&self.model.elements[at].geometry, &element.geometry) {
            return Ok(());
        }
        if !prefer_last {
            return Err(IngestError::TwoBodies {
                ifc_type: element.ifc_type.to_owned(),
                global_id: element.id.global_id,
                file: file.name(),
            });
        }
        self.model.elements[at] = element;
        self.element_source[at] = source;
        Ok(())
    }
}

fn move_model(model: &mut Model, motion: &UprightRigid3<World, World>) {
    if motion.yaw_rad() == 0.0 && motion.translation_m() == [0.0; 3] {
        return;
    }
    let plane = motion.in_plane();
    for element in &mut model.elements {
        move_body(&mut element.geometry, motion);
        let frame_of_door = element.door.as_mut().and_then(|door| door.frame.as_mut());
        for placement in element.placement.iter_mut().chain(frame_of_door) {
            placement.origin_m = motion.apply(placement.origin_m);
            for axis in &mut placement.axes {
                let [x, y] = plane.rotate([axis[0], axis[1]]);
                *axis = [x, y, axis[2]];
            }
        }
    }
    let spaces = model.spaces.iter_mut().map(|s| &mut s.geometry);
    let terrains = model.terrains.iter_mut().map(|t| &mut t.geometry);
    for geometry in spaces.chain(model.openings.iter_mut().map(|o| &mut o.geometry)).chain(terrains) {
        move_body(geometry, motion);
    }
    for storey in &mut model.storeys {
        storey.placement_z_m = storey.placement_z_m.map(|z| z + motion.translation_m()[2]);
        storey.elevation_m = storey.elevation_m.map(|z| z + motion.translation_m()[2]);
    }
}

fn move_body(geometry: &mut Geometry, motion: &UprightRigid3<World, World>) {
    for part in &mut geometry.parts {
        part.origin_m = motion.apply(part.origin_m);
        for p in &mut part.positions_m {
            let [x, y] = motion.in_plane().rotate([f64::from(p[0]), f64::from(p[1])]);
            *p = [x as f32, y as f32, p[2]];
        }
    }
}
