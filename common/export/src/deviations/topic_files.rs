//! `deviations.bcfzip`: topics as tools for models read them, and those of an earlier comparison, which are closed where the robot
//! saw the element in place since.

use super::input::DeviationExport;
use super::picture::PlacePictures;
use super::topics::{Topic, topics};
use bcf::{BcfError, BcfVersion, Camera, Comment, Container, Snapshot, Viewpoint, uuid};
use frames::{Map, Point3, UprightRigid3, World};
use messages::{DeviationVerdict, ElementDeviationRecord, Observation};
use std::collections::BTreeMap;

/// Metres around what a view shows.
const MARGIN_M: f64 = 2.0;
/// Metres that the camera is above the lidar's plane.
const ABOVE_M: f64 = 20.0;
/// An obstacle whose place differs by less from one comparison to the next is the same.
const SAME_PLACE_M: f64 = 0.5;

const AUTHOR: &str = "groundplan";
const OPEN: &str = "Open";
const CLOSED: &str = "Closed";

/// The container of the topics.
pub(super) fn container(input: &DeviationExport<'_>, version: BcfVersion) -> Vec<u8> {
    bcf::written(&all(input), version)
}

/// An earlier container with what the comparison changes in it: topics of elements that are as planned are closed, those of elements
/// that are not any more are opened again, new ones are added. All else stays as it is.
///
/// # Errors
/// A topic of the earlier container whose markup cannot be changed.
pub(super) fn updated(input: &DeviationExport<'_>, mut earlier: Container) -> Result<Vec<u8>, BcfError> {
    let now = all(input);
    let judged: BTreeMap<&str, &ElementDeviationRecord> =
        input.deviations.elements.iter().map(|record| (input.global_id(record), record)).collect();
    let created = input.created.to_string();
    let known: Vec<bcf::Topic> = earlier.topics().to_vec();
    for topic in known.iter().filter(|topic| topic.author == AUTHOR) {
        let is_closed = topic.status == CLOSED;
        let text = if now.iter().any(|of_now| of_now.guid == topic.guid) {
            is_closed.then(|| (OPEN, "It is not as planned again.".to_owned()))
        } else {
            let element = topic.viewpoints.iter().flat_map(|view| &view.components).next();
            let record = element.and_then(|component| judged.get(component.global_id.as_str()));
            record.filter(|_| !is_closed).and_then(|record| why_closed(input, record)).map(|why| (CLOSED, why))
        };
        if let Some((status, text)) = text {
            let guid = uuid(&["comment", &topic.guid, status, &created]);
            let comment = Comment { guid, date: created.clone(), author: AUTHOR.to_owned(), text, viewpoint: None };
            earlier.set_status(&topic.guid, status, &comment)?;
        }
    }
    for topic in now {
        let is_known = known.iter().any(|earlier| earlier.guid == topic.guid || is_same_obstacle(earlier, &topic));
        if !is_known {
            earlier.add(topic);
        }
    }
    Ok(earlier.bytes())
}

/// Why the topic of an element is closed; `None` while nothing says so.
fn why_closed(input: &DeviationExport<'_>, record: &ElementDeviationRecord) -> Option<String> {
    let is_late_in_part = input
        .deviations
        .absent_parts
        .iter()
        .any(|part| part.element == record.element && part.verdict == DeviationVerdict::Late);
    if record.verdict != DeviationVerdict::OnPlan || is_late_in_part {
        return None;
    }
    let length = |n: u32| f64::from(n) * record.sample_m;
    match record.observation.get() {
        Observation::Observed => Some(format!(
            "The robot saw it in place: {:.2} m of the {:.2} m of its sides that it judged.",
            length(record.n_confirmed),
            length(record.n_visible)
        )),
        Observation::Absent => Some("The robot saw that it is gone, as planned.".to_owned()),
        Observation::Displaced | Observation::Unseen => None,
    }
}

/// True if two topics are about an obstacle in one place: those of an obstacle differ from map to map.
fn is_same_obstacle(earlier: &bcf::Topic, topic: &bcf::Topic) -> bool {
    let is_open_obstacle = |topic: &bcf::Topic| {
        let has_element = topic.viewpoints.iter().any(|view| !view.components.is_empty());
        !has_element && topic.status == OPEN && topic.labels.iter().any(|label| label == "not_in_the_model")
    };
    let place = |topic: &bcf::Topic| topic.viewpoints.iter().find_map(|view| view.camera).map(|camera| camera.position);
    let both = place(earlier).zip(place(topic));
    let is_near =
        both.is_some_and(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]) < SAME_PLACE_M && (a[2] - b[2]).abs() < 1.0);
    is_open_obstacle(earlier) && is_open_obstacle(topic) && is_near
}

/// The topics of the comparison, each with its picture.
fn all(input: &DeviationExport<'_>) -> Vec<bcf::Topic> {
    let pictures = PlacePictures::of(input);
    let world_from_map = WorldFromMap::of(input);
    let files: Vec<String> = input.site.sources.iter().map(|source| input.site.text(source.file).to_owned()).collect();
    let topic = |(topic, index): (Topic, u32)| bcf::Topic {
        viewpoints: vec![viewpoint(&topic, &world_from_map, &pictures)],
        guid: topic.guid,
        kind: "Issue".to_owned(),
        status: OPEN.to_owned(),
        title: topic.title,
        description: topic.description,
        labels: vec![topic.label.to_owned()],
        index: Some(index),
        created: input.created.to_string(),
        author: AUTHOR.to_owned(),
        modified: None,
        files: files.clone(),
        comments: Vec::new(),
    };
    topics(input).into_iter().zip(0..).map(topic).collect()
}

/// From above, north of the map up, in the coordinates of the IFC world; the outline of an obstacle, which is no component.
fn viewpoint(topic: &Topic, world_from_map: &WorldFromMap, pictures: &PlacePictures) -> Viewpoint {
    let [min, max] = topic.bounds_m;
    let up = world_from_map.motion.in_plane().rotate([0.0, 1.0]);
    let camera = Camera {
        position: world_from_map.point([(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0], ABOVE_M),
        direction: [0.0, 0.0, -1.0],
        up: [up[0], up[1], 0.0],
        height_m: (max[1] - min[1]).max(max[0] - min[0]) + 2.0 * MARGIN_M,
        aspect_ratio: 1.0,
    };
    let line = |(from, to): (&[f64; 2], &[f64; 2])| [*from, *to].map(|p| world_from_map.point(p, 0.0));
    let lines = topic.outlines_m.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(line));
    Viewpoint {
        guid: topic.viewpoint.clone(),
        camera: Some(camera),
        components: topic.component.iter().cloned().collect(),
        lines: lines.collect(),
        snapshot: Some(Snapshot::Png(pictures.around(topic.bounds_m))),
    }
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
