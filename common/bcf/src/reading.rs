//! Reads the documents of a container: what [`Topic`] has, whatever else there is.

use crate::topic::{BcfVersion, Camera, Comment, Component, Topic, Viewpoint};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Elements in each other; those of BCF are ten deep.
const MAX_DEPTH: usize = 64;

/// What a walk over a document meets.
enum Met<'a> {
    /// An element begins.
    Start(&'a BytesStart<'a>),
    /// The text of the innermost element, at its end.
    End(&'a str),
}

/// What is done with it; the names are those of the open elements from the root on.
type Visit<'v> = dyn FnMut(&[String], Met<'_>) -> Result<(), String> + 'v;

/// Walks over a document: the names of open elements from the root on, and what is met.
fn walk(bytes: &[u8], visit: &mut Visit<'_>) -> Result<(), String> {
    let mut reader = Reader::from_reader(bytes);
    let config = reader.config_mut();
    config.expand_empty_elements = true;
    let (mut path, mut texts, mut buffer): (Vec<String>, Vec<String>, Vec<u8>) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).map_err(|e| e.to_string())? {
            Event::Start(start) => {
                if path.len() == MAX_DEPTH {
                    return Err(format!("more than {MAX_DEPTH} elements lie in each other"));
                }
                path.push(start.local_name().as_ref().to_owned());
                texts.push(String::new());
                visit(&path, Met::Start(&start))?;
            }
            Event::End(_) => {
                let text = texts.pop().unwrap_or_default();
                visit(&path, Met::End(&text))?;
                path.pop();
            }
            Event::Text(text) => {
                let text = text.xml10_content();
                if let Some(of) = texts.last_mut() {
                    of.push_str(&text);
                }
            }
            Event::CData(text) => {
                let text = text.xml10_content();
                if let Some(of) = texts.last_mut() {
                    of.push_str(&text);
                }
            }
            Event::GeneralRef(reference) => {
                let name = reference.xml10_content();
                let character = reference.resolve_char_ref().map_err(|e| e.to_string())?;
                let resolved = character
                    .map(String::from)
                    .or_else(|| quick_xml::escape::resolve_xml_entity(&name).map(str::to_owned));
                let resolved = resolved.ok_or_else(|| format!("the entity &{name}; is not known"))?;
                if let Some(of) = texts.last_mut() {
                    of.push_str(&resolved);
                }
            }
            Event::Eof if path.is_empty() => return Ok(()),
            Event::Eof => return Err(format!("it ends inside of {}", path.join("/"))),
            Event::Decl(_) | Event::Comment(_) | Event::PI(_) | Event::DocType(_) | Event::Empty(_) => {}
        }
    }
}

/// An attribute of an element; empty without it.
fn attribute(start: &BytesStart<'_>, name: &str) -> Result<String, String> {
    let found = start.try_get_attribute(name).map_err(|e| e.to_string())?;
    let value = found.map(|a| a.normalized_value(quick_xml::XmlVersion::Implicit1_0).map(|v| v.into_owned()));
    value.transpose().map_err(|e| e.to_string()).map(Option::unwrap_or_default)
}

/// VersionId.
pub(crate) fn read_version(bytes: &[u8]) -> Result<String, String> {
    let mut version = None;
    walk(bytes, &mut |path, met| {
        if let (["Version"], Met::Start(start)) = (names(path).as_slice(), met) {
            version = Some(attribute(start, "VersionId")?);
        }
        Ok(())
    })?;
    version.ok_or_else(|| "it has no Version".to_owned())
}

fn names(path: &[String]) -> Vec<&str> {
    path.iter().map(String::as_str).collect()
}

/// A topic, and for each of its viewpoints the names of its file and of its picture.
pub(crate) fn read_markup(bytes: &[u8], version: BcfVersion) -> Result<(Topic, Vec<[String; 2]>), String> {
    let (mut topic, mut files) = (Topic::default(), Vec::new());
    let mut has_topic = false;
    walk(bytes, &mut |path, met| {
        let path = names(path);
        // Version 3.0 has comments and viewpoints in the topic, each in a list.
        let path: Vec<&str> = match (version, path.as_slice()) {
            (BcfVersion::V3_0, ["Markup", "Topic", "Comments" | "Viewpoints", rest @ ..]) if !rest.is_empty() => {
                let lists = [&["Markup"][..], rest].concat();
                lists.into_iter().map(|name| if name == "ViewPoint" { "Viewpoints" } else { name }).collect()
            }
            (BcfVersion::V3_0, ["Markup", "Header", "Files", rest @ ..]) => [&["Markup", "Header"][..], rest].concat(),
            (BcfVersion::V3_0, ["Markup", "Topic", "Labels", "Label"]) => vec!["Markup", "Topic", "Labels"],
            (BcfVersion::V3_0, ["Markup", "Topic", "Labels"]) => Vec::new(),
            (_, path) => path.to_vec(),
        };
        match (path.as_slice(), met) {
            (["Markup", "Topic"], Met::Start(start)) => {
                has_topic = true;
                topic.guid = attribute(start, "Guid")?;
                topic.kind = attribute(start, "TopicType")?;
                topic.status = attribute(start, "TopicStatus")?;
            }
            (["Markup", "Topic", name], Met::End(text)) => set(&mut topic, name, text),
            (["Markup", "Header", "File", "Filename"], Met::End(text)) => topic.files.push(text.to_owned()),
            (["Markup", "Comment"], Met::Start(start)) => {
                topic.comments.push(Comment { guid: attribute(start, "Guid")?, ..Comment::default() });
            }
            (["Markup", "Comment", "Viewpoint"], Met::Start(start)) => {
                let guid = attribute(start, "Guid")?;
                topic.comments.iter_mut().last().into_iter().for_each(|c| c.viewpoint = Some(guid.clone()));
            }
            (["Markup", "Comment", name], Met::End(text)) => {
                let Some(comment) = topic.comments.last_mut() else { return Ok(()) };
                match *name {
                    "Date" => text.clone_into(&mut comment.date),
                    "Author" => text.clone_into(&mut comment.author),
                    "Comment" => text.clone_into(&mut comment.text),
                    _ => {}
                }
            }
            (["Markup", "Viewpoints"], Met::Start(start)) => {
                topic.viewpoints.push(Viewpoint { guid: attribute(start, "Guid")?, ..Viewpoint::default() });
                files.push([String::new(), String::new()]);
            }
            (["Markup", "Viewpoints", name @ ("Viewpoint" | "Snapshot")], Met::End(text)) => {
                let Some(names) = files.last_mut() else { return Ok(()) };
                text.trim().clone_into(&mut names[usize::from(*name == "Snapshot")]);
            }
            _ => {}
        }
        Ok(())
    })?;
    if !has_topic || topic.guid.is_empty() {
        return Err("it has no Topic with a Guid".to_owned());
    }
    Ok((topic, files))
}

fn set(topic: &mut Topic, name: &str, text: &str) {
    let modified = |topic: &mut Topic, at: usize| {
        let both = topic.modified.get_or_insert_with(|| [String::new(), String::new()]);
        text.clone_into(&mut both[at]);
    };
    match name {
        "Title" => text.clone_into(&mut topic.title),
        "Description" => text.clone_into(&mut topic.description),
        "Labels" => topic.labels.push(text.to_owned()),
        "Index" => topic.index = text.trim().parse().ok(),
        "CreationDate" => text.clone_into(&mut topic.created),
        "CreationAuthor" => text.clone_into(&mut topic.author),
        "ModifiedDate" => modified(topic, 0),
        "ModifiedAuthor" => modified(topic, 1),
        _ => {}
    }
}

/// Camera, selection and lines of a viewpoint.
pub(crate) fn read_viewpoint(bytes: &[u8], viewpoint: &mut Viewpoint) -> Result<(), String> {
    const NONE: f64 = f64::NAN;
    let mut camera =
        Camera { position: [NONE; 3], direction: [NONE; 3], up: [NONE; 3], height_m: NONE, aspect_ratio: 1.0 };
    walk(bytes, &mut |path, met| {
        match (names(path).as_slice(), met) {
            (["VisualizationInfo", "Components", "Selection", "Component"], Met::Start(start)) => {
                let global_id = attribute(start, "IfcGuid")?;
                viewpoint.components.push(Component { global_id, authoring_tool_id: String::new() });
            }
            (["VisualizationInfo", "Components", "Selection", "Component", "AuthoringToolId"], Met::End(text)) => {
                viewpoint
                    .components
                    .iter_mut()
                    .last()
                    .into_iter()
                    .for_each(|c| text.clone_into(&mut c.authoring_tool_id));
            }
            (["VisualizationInfo", "OrthogonalCamera", of, axis], Met::End(text)) => {
                let vector = match *of {
                    "CameraViewPoint" => &mut camera.position,
                    "CameraDirection" => &mut camera.direction,
                    "CameraUpVector" => &mut camera.up,
                    _ => return Ok(()),
                };
                set_axis(vector, axis, number(text)?);
            }
            (["VisualizationInfo", "OrthogonalCamera", "ViewToWorldScale"], Met::End(text)) => {
                camera.height_m = number(text)?
            }
            (["VisualizationInfo", "OrthogonalCamera", "AspectRatio"], Met::End(text)) => {
                camera.aspect_ratio = number(text)?
            }
            (["VisualizationInfo", "Lines", "Line"], Met::Start(_)) => viewpoint.lines.push([[0.0; 3]; 2]),
            (["VisualizationInfo", "Lines", "Line", end @ ("StartPoint" | "EndPoint"), axis], Met::End(text)) => {
                let Some(line) = viewpoint.lines.last_mut() else { return Ok(()) };
                set_axis(&mut line[usize::from(*end == "EndPoint")], axis, number(text)?);
            }
            _ => {}
        }
        Ok(())
    })?;
    let numbers = [camera.position, camera.direction, camera.up].concat();
    if numbers.iter().chain([&camera.height_m, &camera.aspect_ratio]).all(|n| n.is_finite()) {
        viewpoint.camera = Some(camera);
    }
    Ok(())
}

fn set_axis(vector: &mut [f64; 3], axis: &str, value: f64) {
    if let Some(k) = ["X", "Y", "Z"].iter().position(|name| *name == axis) {
        vector[k] = value;
    }
}

fn number(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("{text:?} is no number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("{text:?} is no finite number")) }
}
