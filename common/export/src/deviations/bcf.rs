//! `deviations.bcfzip`: BCF 2.1, as tools for models read it.
//!
//! # Source
//! buildingSMART, BIM Collaboration Format 2.1: `version.xsd`, `markup.xsd`, `visinfo.xsd`.

use super::input::DeviationExport;
use super::topics::{Component, Topic, topics};
use crate::text::{rounded, xml_text as text};
use frames::{Map, Point3, UprightRigid3, World};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io::{Cursor, Result, Write};
use zip::write::SimpleFileOptions;

/// Metres around what a view shows.
const MARGIN_M: f64 = 2.0;
/// Metres that the camera is above the lidar's plane.
const ABOVE_M: f64 = 20.0;

type Xml = Writer<Vec<u8>>;

/// The container, one folder for each topic. Its files have no time of their own.
pub(super) fn container(input: &DeviationExport<'_>) -> Vec<u8> {
    written(input).expect("memory does not fail, and names and sizes are those of files")
}

fn written(input: &DeviationExport<'_>) -> Result<Vec<u8>> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |path: &str, bytes: &[u8]| -> Result<()> {
        let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
        zip.start_file(path, options)?;
        zip.write_all(bytes)
    };
    add("bcf.version", &version()?)?;
    for (topic, index) in topics(input).iter().zip(0..) {
        add(&format!("{}/markup.bcf", topic.guid), &markup(input, topic, index)?)?;
        add(&format!("{}/viewpoint.bcfv", topic.guid), &viewpoint(input, topic)?)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn document() -> Result<Xml> {
    let mut xml = Writer::new(Vec::new());
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    Ok(xml)
}

fn version() -> Result<Vec<u8>> {
    let mut xml = document()?;
    let root = xml.create_element("Version").with_attribute(("VersionId", "2.1"));
    root.write_inner_content(|xml| text(xml, "DetailedVersion", "2.1"))?;
    Ok(xml.into_inner())
}

fn markup(input: &DeviationExport<'_>, topic: &Topic, index: u32) -> Result<Vec<u8>> {
    let mut xml = document()?;
    let root = xml.create_element("Markup");
    root.write_inner_content(|xml| {
        if !input.site.sources.is_empty() {
            xml.create_element("Header").write_inner_content(|xml| {
                input.site.sources.iter().try_for_each(|source| {
                    let file = xml.create_element("File").with_attribute(("isExternal", "true"));
                    file.write_inner_content(|xml| text(xml, "Filename", input.site.text(source.file))).map(|_| ())
                })
            })?;
        }
        let head = xml.create_element("Topic").with_attributes([
            ("Guid", topic.guid.as_str()),
            ("TopicType", "Issue"),
            ("TopicStatus", "Open"),
        ]);
        head.write_inner_content(|xml| {
            text(xml, "Title", &topic.title)?;
            text(xml, "Index", &index.to_string())?;
            text(xml, "Labels", topic.label)?;
            text(xml, "CreationDate", &input.created.to_string())?;
            text(xml, "CreationAuthor", "groundplan")?;
            text(xml, "Description", &topic.description)
        })?;
        let view = xml.create_element("Viewpoints").with_attribute(("Guid", topic.viewpoint.as_str()));
        view.write_inner_content(|xml| text(xml, "Viewpoint", "viewpoint.bcfv"))?;
        Ok(())
    })?;
    Ok(xml.into_inner())
}

fn viewpoint(input: &DeviationExport<'_>, topic: &Topic) -> Result<Vec<u8>> {
    let mut xml = document()?;
    let root = xml.create_element("VisualizationInfo").with_attribute(("Guid", topic.viewpoint.as_str()));
    root.write_inner_content(|xml| {
        xml.create_element("Components").write_inner_content(|xml| {
            if let Some(component) = &topic.component {
                xml.create_element("Selection").write_inner_content(|xml| selected(xml, component))?;
            }
            xml.create_element("Visibility").with_attribute(("DefaultVisibility", "true")).write_empty()?;
            Ok(())
        })?;
        camera(xml, input, topic)?;
        lines(xml, input, topic)
    })?;
    Ok(xml.into_inner())
}

/// A component by its GlobalId, if it is one; by its line in the file otherwise.
fn selected(xml: &mut Xml, component: &Component) -> Result<()> {
    let element = xml.create_element("Component");
    if is_global_id(&component.global_id) {
        element.with_attribute(("IfcGuid", component.global_id.as_str())).write_empty()?;
    } else {
        let id = format!("#{}", component.step_id);
        element.write_inner_content(|xml| text(xml, "AuthoringToolId", &id))?;
    }
    Ok(())
}

fn is_global_id(text: &str) -> bool {
    text.len() == 22 && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'$')
}

/// From above, north of the map up, in the coordinates of the IFC world.
fn camera(xml: &mut Xml, input: &DeviationExport<'_>, topic: &Topic) -> Result<()> {
    let [min, max] = topic.bounds_m;
    let world_from_map = WorldFromMap::of(input);
    let eye = world_from_map.point([(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0], ABOVE_M);
    let up = world_from_map.motion.in_plane().rotate([0.0, 1.0]);
    xml.create_element("OrthogonalCamera").write_inner_content(|xml| {
        vector(xml, "CameraViewPoint", eye)?;
        vector(xml, "CameraDirection", [0.0, 0.0, -1.0])?;
        vector(xml, "CameraUpVector", [up[0], up[1], 0.0])?;
        let height_m = (max[1] - min[1]).max(max[0] - min[0]) + 2.0 * MARGIN_M;
        text(xml, "ViewToWorldScale", &rounded(height_m).to_string())
    })?;
    Ok(())
}

/// The outline of an obstacle, which is no component.
fn lines(xml: &mut Xml, input: &DeviationExport<'_>, topic: &Topic) -> Result<()> {
    if topic.outlines_m.is_empty() {
        return Ok(());
    }
    let world_from_map = WorldFromMap::of(input);
    xml.create_element("Lines").write_inner_content(|xml| {
        for ring in &topic.outlines_m {
            for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                xml.create_element("Line").write_inner_content(|xml| {
                    vector(xml, "StartPoint", world_from_map.point(*from, 0.0))?;
                    vector(xml, "EndPoint", world_from_map.point(*to, 0.0))
                })?;
            }
        }
        Ok(())
    })?;
    Ok(())
}

/// Back from the map to the coordinates of the files.
struct WorldFromMap {
    motion: UprightRigid3<World, Map>,
    /// In the map.
    lidar_z_m: f64,
}

impl WorldFromMap {
    fn of(input: &DeviationExport<'_>) -> Self {
        Self { motion: input.site.map_from_world().inverse(), lidar_z_m: input.deviations.head.lidar_z_m }
    }

    /// A place in plan, so far above the lidar's plane.
    fn point(&self, [x, y]: [f64; 2], above_m: f64) -> [f64; 3] {
        let at: Point3<World> = &self.motion * Point3::<Map>::new(x, y, self.lidar_z_m);
        let [x, y, z] = at.coordinates_m();
        [x, y, z + above_m]
    }
}

fn vector(xml: &mut Xml, name: &str, [x, y, z]: [f64; 3]) -> Result<()> {
    xml.create_element(name).write_inner_content(|xml| {
        [("X", x), ("Y", y), ("Z", z)].iter().try_for_each(|(axis, c)| text(xml, axis, &rounded(*c).to_string()))
    })?;
    Ok(())
}
