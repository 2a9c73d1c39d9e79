//! BCF topics: one for each element of each issue, with camera, selection and a picture of the map around it.

use crate::document::{Issue, IssueElement, ModelCheck, Place};
use crate::picture::StoreyPicture;
use bcf::{Camera, Component, Snapshot, Topic, Viewpoint, uuid};
use frames::{Map, Point3};
use messages::Site;

/// Metres that the camera is above the floor.
const ABOVE_M: f64 = 20.0;
/// Metres around what a view shows.
const MARGIN_M: f64 = 2.0;
/// Topics of one issue: who has a thousand doors to mend needs no thousand pictures.
const MAX_TOPICS: usize = 100;

/// The topics, the worst first. `created` is a date with a time, as XML writes it. An element keeps its topic from one check of a
/// model to the next.
pub fn topics(check: &ModelCheck, pictures: &[StoreyPicture], site: &Site<'_>, created: &str) -> Vec<Topic> {
    let files: Vec<String> = site.sources.iter().map(|source| site.text(source.file).to_owned()).collect();
    let all = check
        .issues
        .iter()
        .flat_map(|issue| issue.elements.iter().take(MAX_TOPICS).map(move |element| (issue, element)));
    let mut topics: Vec<Topic> = Vec::new();
    for (issue, element) in all {
        let guid = topic_guid(issue, element, &topics);
        let viewpoint = element.place.as_ref().map(|place| viewpoint(pictures, site, element, place, &guid));
        topics.push(Topic {
            kind: if issue.kind == "maps" { "Error" } else { "Warning" }.to_owned(),
            status: "Open".to_owned(),
            title: title(issue, element),
            description: description(issue, element),
            labels: vec![issue.code.to_owned(), issue.kind.to_owned()],
            index: Some(topics.len() as u32),
            created: created.to_owned(),
            author: "groundplan".to_owned(),
            files: files.clone(),
            viewpoints: viewpoint.into_iter().collect(),
            guid,
            ..Topic::default()
        });
    }
    topics
}

/// The same for the same element and cause; several of an element are told apart by their number.
fn topic_guid(issue: &Issue, element: &IssueElement, before: &[Topic]) -> String {
    let name = element.name.as_deref().unwrap_or_default();
    let who = if element.global_id.is_empty() { name } else { &element.global_id };
    let guid = |number: usize| uuid(&["check", issue.code, who, &number.to_string()]);
    let is_free = |guid: &String| before.iter().all(|topic| topic.guid != *guid);
    (0..).map(guid).find(is_free).expect("numbers do not end")
}

fn title(issue: &Issue, element: &IssueElement) -> String {
    let code = crate::IssueCode::ALL.iter().find(|code| code.name() == issue.code);
    let what = code.map_or("", |code| code.phrases()[0]);
    let name = element.name.as_deref().unwrap_or(&element.global_id);
    let of =
        [element.ifc_type.as_str(), name].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
    format!("{of}: {what}")
}

fn description(issue: &Issue, element: &IssueElement) -> String {
    let mut text = String::new();
    if !element.text.is_empty() {
        text += &format!("{}.\n", element.line());
    }
    text += issue.cause;
    if !issue.effect.text.is_empty() {
        text += &format!("\nOf all {}: {}.", issue.n, issue.effect.text);
    }
    format!("{text}\n{}", issue.advice)
}

fn viewpoint(
    pictures: &[StoreyPicture],
    site: &Site<'_>,
    element: &IssueElement,
    place: &Place,
    topic: &str,
) -> Viewpoint {
    let picture = place.storey.and_then(|storey| pictures.iter().find(|picture| picture.map_storey == storey));
    let component =
        Component { global_id: element.global_id.clone(), authoring_tool_id: element.name.clone().unwrap_or_default() };
    let world_from_map = site.map_from_world().inverse();
    let middle = place.middle_m();
    let at = &world_from_map * Point3::<Map>::new(middle[0], middle[1], place.z_m + ABOVE_M);
    let up = world_from_map.in_plane().rotate([0.0, 1.0]);
    let [min, max] = place.bounds_m;
    let height_m = (max[1] - min[1]).max(max[0] - min[0]) + 2.0 * MARGIN_M;
    Viewpoint {
        guid: uuid(&["viewpoint", topic]),
        camera: Some(Camera {
            position: at.coordinates_m(),
            direction: [0.0, 0.0, -1.0],
            up: [up[0], up[1], 0.0],
            height_m,
            aspect_ratio: 1.0,
        }),
        components: vec![component],
        lines: Vec::new(),
        snapshot: picture.map(|picture| Snapshot::Png(picture.around(place).0)),
    }
}
