//! `*.bcfv`: camera, components and lines of a viewpoint.

use crate::guid::is_global_id;
use crate::topic::{BcfVersion, Camera, Component, Viewpoint};
use crate::xml::{Xml, document, number, text, vector};
use std::io::Result;

/// The file.
pub(crate) fn visualization(viewpoint: &Viewpoint, version: BcfVersion) -> Result<Vec<u8>> {
    let mut xml = document()?;
    let root = xml.create_element("VisualizationInfo").with_attribute(("Guid", viewpoint.guid.as_str()));
    root.write_inner_content(|xml| {
        xml.create_element("Components").write_inner_content(|xml| {
            if !viewpoint.components.is_empty() {
                let selection = xml.create_element("Selection");
                selection.write_inner_content(|xml| viewpoint.components.iter().try_for_each(|c| component(xml, c)))?;
            }
            xml.create_element("Visibility").with_attribute(("DefaultVisibility", "true")).write_empty()?;
            Ok(())
        })?;
        if let Some(of) = &viewpoint.camera {
            camera(xml, of, version)?;
        }
        lines(xml, &viewpoint.lines)
    })?;
    Ok(xml.into_inner())
}

/// An element by its GlobalId, if it is one; by the name that a program gives it otherwise.
fn component(xml: &mut Xml, component: &Component) -> Result<()> {
    let element = xml.create_element("Component");
    if is_global_id(&component.global_id) {
        element.with_attribute(("IfcGuid", component.global_id.as_str())).write_empty()?;
    } else {
        element.write_inner_content(|xml| text(xml, "AuthoringToolId", &component.authoring_tool_id))?;
    }
    Ok(())
}

fn camera(xml: &mut Xml, camera: &Camera, version: BcfVersion) -> Result<()> {
    xml.create_element("OrthogonalCamera").write_inner_content(|xml| {
        vector(xml, "CameraViewPoint", camera.position)?;
        vector(xml, "CameraDirection", camera.direction)?;
        vector(xml, "CameraUpVector", camera.up)?;
        text(xml, "ViewToWorldScale", &number(camera.height_m))?;
        match version {
            BcfVersion::V2_1 => Ok(()),
            BcfVersion::V3_0 => text(xml, "AspectRatio", &number(camera.aspect_ratio)),
        }
    })?;
    Ok(())
}

fn lines(xml: &mut Xml, lines: &[[[f64; 3]; 2]]) -> Result<()> {
    if lines.is_empty() {
        return Ok(());
    }
    xml.create_element("Lines").write_inner_content(|xml| {
        lines.iter().try_for_each(|[from, to]| {
            xml.create_element("Line").write_inner_content(|xml| {
                vector(xml, "StartPoint", *from)?;
                vector(xml, "EndPoint", *to)
            })?;
            Ok(())
        })
    })?;
    Ok(())
}
