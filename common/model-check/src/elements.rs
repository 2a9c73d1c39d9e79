//! Elements: twice in one place, and on another storey than they say.

use crate::causes::IssueCode;
use crate::evidence::{Found, Subject};
use frames::metres;
use grid::Class;
use messages::{ElementRecord, NONE, Site, element_flags};

/// Corners of bodies that are the same differ by no more: 2 mm.
const SAME: i32 = 20;
/// How far an element stands above the floor of the next storey at most to count as of its own: 0.05 m.
const ON_FLOOR: i32 = 500;
/// Storeys whose heights differ by less are levels of one.
const MIN_STOREY: i32 = 10_000;

/// Elements of an entity whose bodies are the same: the later one of each pair.
pub(crate) fn duplicates(site: &Site<'_>) -> Vec<Found> {
    let has_body = |e: &&(usize, &ElementRecord)| e.1.n_parts > 0 && !e.1.has(element_flags::BOUNDING_BOX);
    let elements: Vec<(usize, &ElementRecord)> = site.elements.iter().enumerate().collect();
    let mut elements: Vec<(usize, &ElementRecord)> = elements.iter().filter(has_body).copied().collect();
    elements.sort_by_key(|(k, e)| (e.min_tenths[0], e.min_tenths[1], e.min_tenths[2], *k));
    let mut all = Vec::new();
    for (at, (a, first)) in elements.iter().enumerate() {
        let near = elements[at + 1..].iter().take_while(|(_, other)| other.min_tenths[0] - first.min_tenths[0] <= SAME);
        for (b, _) in near.filter(|(_, other)| is_same(site, first, other)) {
            let (one, two) = (*a.min(b), *a.max(b));
            let text = format!("the same body as {}", site.text(site.elements[one].global_id));
            let mut found = Found::of(IssueCode::DuplicateElement, Subject::Element(two), text);
            if site.elements[two].door != NONE {
                found.doors.push(site.elements[two].door);
            }
            all.push((two, found));
        }
    }
    // Of three copies two are told, each once.
    all.sort_by_key(|(element, _)| *element);
    all.dedup_by_key(|(element, _)| *element);
    all.into_iter().map(|(_, found)| found).collect()
}

fn is_same(site: &Site<'_>, a: &ElementRecord, b: &ElementRecord) -> bool {
    let near = |p: [i32; 3], q: [i32; 3]| (0..3).all(|k| (p[k] - q[k]).abs() <= SAME);
    let is_alike = site.text(a.ifc_type) == site.text(b.ifc_type)
        && near(a.min_tenths, b.min_tenths)
        && near(a.max_tenths, b.max_tenths);
    is_alike && !is_part_of(site, a, b) && n_triangles(site, a) == n_triangles(site, b) && same_volume(site, a, b)
}

/// True if one of them is a part of the other.
fn is_part_of(site: &Site<'_>, a: &ElementRecord, b: &ElementRecord) -> bool {
    let whole = |e: &ElementRecord| site.elements.get(e.whole as usize).map(|whole| whole.step_id);
    whole(a) == Some(b.step_id) || whole(b) == Some(a.step_id)
}

fn n_triangles(site: &Site<'_>, element: &ElementRecord) -> u32 {
    site.element_parts(element).iter().map(|part| part.n_triangles).sum()
}

fn same_volume(site: &Site<'_>, a: &ElementRecord, b: &ElementRecord) -> bool {
    let [a, b] = [a, b].map(|e| site.element_meshes(e).map(|mesh| mesh.volume_m3()).sum::<f64>());
    (a - b).abs() <= 0.01 * a.abs().max(b.abs()).max(1e-6)
}

/// Walls, doors, furniture and rooms that stand on another storey of their file than the one that contains them.
pub(crate) fn on_other_storeys(site: &Site<'_>) -> Vec<Found> {
    let mut all = Vec::new();
    let listed = |e: &ElementRecord| matches!(e.class(), Class::Wall | Class::Door | Class::Furniture | Class::Column);
    for (k, element) in site.elements.iter().enumerate().filter(|(_, e)| e.n_parts > 0 && e.whole == NONE && listed(e))
    {
        let range = [element.min_tenths[2], element.max_tenths[2]];
        if let Some(text) = stands_elsewhere(site, element.storey, range) {
            all.push(Found::of(IssueCode::ElementOnOtherStorey, Subject::Element(k), text));
        }
    }
    for (k, space) in site.spaces.iter().enumerate().filter(|(_, s)| s.n_rings > 0) {
        let range = [space.floor_z_tenths, space.floor_z_tenths.saturating_add(space.height_tenths.max(1))];
        if let Some(text) = stands_elsewhere(site, space.storey, range) {
            all.push(Found::of(IssueCode::ElementOnOtherStorey, Subject::Space(k), text));
        }
    }
    all
}

/// On which storey something stands, if not on its own.
fn stands_elsewhere(site: &Site<'_>, storey: u32, [low, high]: [i32; 2]) -> Option<String> {
    let own = site.storeys.get(storey as usize).filter(|own| own.has_placement == 1)?;
    let own_z = own.placement_z_tenths;
    let others = || site.storeys.iter().filter(|s| s.has_placement == 1 && s.source == own.source);
    // A storey that gives nothing a floor, as levels of roofs and foundations, is no place to stand on.
    let mapped = || others().filter(|s| s.map_storey != NONE);
    let above =
        mapped().filter(|s| s.placement_z_tenths >= own_z + MIN_STOREY && s.placement_z_tenths - ON_FLOOR <= low);
    let above = above.max_by_key(|s| s.placement_z_tenths);
    let below =
        mapped().filter(|s| s.placement_z_tenths <= own_z - MIN_STOREY && s.placement_z_tenths - MIN_STOREY / 2 <= low);
    let below = below.max_by_key(|s| s.placement_z_tenths).filter(|_| high <= own_z + ON_FLOOR);
    let other = above.or(below)?;
    let name = |s: &messages::StoreyRecord| match site.text(s.name) {
        "" => site.text(s.global_id).to_owned(),
        name => name.to_owned(),
    };
    Some(format!("listed on {}, and stands on {}: it begins at {:.2} m", name(own), name(other), metres(low)))
}
