//! BCF topics from deviations: one per element that is not as planned and one per obstacle.

use super::input::DeviationExport;
use bcf::uuid;
use geometry::Bounds;
use messages::{AbsentPartRecord, Deviation, DeviationVerdict, ElementDeviationRecord, ObstacleRecord};

/// A topic to be.
pub(super) struct Topic {
    /// UUID that stays the same from one comparison to the next, for an element; of the robot's map, for an obstacle.
    pub(super) guid: String,
    /// Of its viewpoint.
    pub(super) viewpoint: String,
    pub(super) title: String,
    pub(super) description: String,
    /// `late`, `early`, `displaced` or `not_in_the_model`.
    pub(super) label: &'static str,
    /// The element, if it is about one.
    pub(super) component: Option<bcf::Component>,
    /// What the view shows in plan, in `map`.
    pub(super) bounds_m: [[f64; 2]; 2],
    /// Outlines to draw in `map`.
    pub(super) outlines_m: Vec<Vec<[f64; 2]>>,
}

/// Elements in the order of the site, stretches of elements, then obstacles from large to small.
pub(super) fn topics(input: &DeviationExport<'_>) -> Vec<Topic> {
    let elements = input.deviations.elements.iter().filter_map(|e| of_element(input, e));
    let parts = input.deviations.absent_parts.iter().filter_map(|p| of_absent_part(input, p));
    let obstacles = input.deviations.obstacles.iter().zip(1..).map(|(o, number)| of_obstacle(input, o, number));
    elements.chain(parts).chain(obstacles).collect()
}

/// An element, with its line in the file for programs that do not use GlobalIds.
fn component(global_id: &str, step_id: u64) -> bcf::Component {
    bcf::Component { global_id: global_id.to_owned(), authoring_tool_id: format!("#{step_id}") }
}

fn of_element(input: &DeviationExport<'_>, e: &ElementDeviationRecord) -> Option<Topic> {
    let verdict = e.verdict.get();
    let element = &input.site.elements[e.element as usize];
    let [dx, dy] = e.displacement_m.map(|m| m * 1e3);
    let deviation = verdict.deviation()?;
    let phrase = match deviation {
        Deviation::Late if e.n_contradicted > e.n_confirmed => {
            "is planned to stand, and the robot saw through its place"
        }
        Deviation::Late => "is planned to be removed, and stands",
        Deviation::Early => "is built before it is planned",
        Deviation::Displaced => "does not stand in its place",
    };
    let by = if deviation == Deviation::Displaced {
        format!(" Displaced by {:.0} mm: {dx:.0} mm along x, {dy:.0} mm along y of the map.", libm::hypot(dx, dy))
    } else {
        String::new()
    };
    let global_id = input.global_id(e);
    let (kind, name) = (input.site.text(element.ifc_type), input.site.text(element.name));
    let length = |n: u32| f64::from(n) * e.sample_m;
    Some(Topic {
        guid: uuid(&["element", global_id, verdict.name()]),
        viewpoint: uuid(&["viewpoint", global_id, verdict.name()]),
        title: format!("{kind} {name} {phrase}"),
        description: format!(
            "{kind} {global_id} {phrase}.{by} Storey {}, planned state {}. Of {:.2} m of its sides the robot judged {:.2} m: {:.2} m in \
             place, {:.2} m with free space inside.",
            input.storey(),
            e.planned.get().name(),
            length(e.n_samples),
            length(e.n_visible),
            length(e.n_confirmed),
            length(e.n_contradicted),
        ),
        label: verdict.name(),
        component: Some(component(global_id, element.step_id)),
        bounds_m: [element.min_tenths, element.max_tenths].map(|[x, y, _]| [x, y].map(frames::metres)),
        outlines_m: Vec::new(),
    })
}

fn of_absent_part(input: &DeviationExport<'_>, part: &AbsentPartRecord) -> Option<Topic> {
    if part.verdict != DeviationVerdict::Late {
        return None;
    }
    let element = &input.site.elements[part.element as usize];
    let [id, kind, name] = [element.global_id, element.ifc_type, element.name].map(|text| input.site.text(text));
    let length_m = part.to_m - part.from_m;
    // Half metres: the ends of the same hole differ a little from one comparison to the next.
    let place = format!("{:.0}", part.from_m + part.to_m);
    let [[x0, y0], [x1, y1]] = part.ends_m;
    Some(Topic {
        guid: uuid(&["part", id, &place]),
        viewpoint: uuid(&["part viewpoint", id, &place]),
        title: format!("{kind} {name} is planned to stand, and the robot saw through {length_m:.1} m of it"),
        description: format!(
            "{kind} {id} is planned to stand; from {:.2} m to {:.2} m along its axis, at x {x0:.2} m, y {y0:.2} m to x {x1:.2} m, y \
             {y1:.2} m of the map, the robot saw through its place. Storey {}; each end to {:.2} m (standard deviation).",
            part.from_m,
            part.to_m,
            input.storey(),
            part.deviation_m,
        ),
        label: DeviationVerdict::Late.name(),
        component: Some(component(id, element.step_id)),
        bounds_m: [[x0.min(x1), y0.min(y1)], [x0.max(x1), y0.max(y1)]],
        outlines_m: vec![part.ends_m.to_vec()],
    })
}

fn of_obstacle(input: &DeviationExport<'_>, o: &ObstacleRecord, number: u32) -> Topic {
    let [x, y] = o.centroid_m;
    let map = input.deviations.head.slam_map_hash.to_string();
    let place = format!("{x:.4} {y:.4}");
    let space = input.site.spaces.get(o.space as usize).map(|s| {
        let names = [input.site.text(s.name), input.site.text(s.long_name)];
        format!(" in {}", names.join(" ").trim())
    });
    let points = input.deviations.rings_of(o).flatten().copied();
    let bounds = Bounds::of(points).map_or([o.centroid_m; 2], |b| [b.min, b.max].map(|p| p.map(frames::metres)));
    Topic {
        guid: uuid(&["obstacle", &map, &place]),
        viewpoint: uuid(&["viewpoint", &map, &place]),
        title: format!("Obstacle {number} of {:.1} m{} is not in the model", o.length_m, space.unwrap_or_default()),
        description: format!(
            "The robot met something that is no element of the model at x {x:.2} m, y {y:.2} m of the map, storey {}: {:.2} m long, \
             {:.2} m² of it seen.",
            input.storey(),
            o.length_m,
            o.area_m2
        ),
        label: "not_in_the_model",
        component: None,
        bounds_m: bounds,
        outlines_m: input.deviations.rings_of(o).map(|r| r.iter().map(|p| p.map(frames::metres)).collect()).collect(),
    }
}
