//! Issues from diagnostics of model, schedule and mission plan, and from data that the model lacks.

use crate::causes::IssueCode;
use crate::evidence::{Found, Subject};
use answers::Situation;
use frames::metres;
use messages::{DiagnosticCode, DiagnosticRecord, DoorPassage, NONE, Severity, Site, Text, element_flags};
use std::collections::BTreeMap;

/// What is found of input that could not be used as it is.
pub(crate) fn input_faults(situation: &Situation<'_>) -> Vec<Found> {
    let Situation { site, schedule_state, .. } = *situation;
    let by_id = ById::of(site);
    let mut all = Vec::new();
    for diagnostic in site.diagnostics {
        all.extend(of_site(situation, &by_id, diagnostic));
    }
    for diagnostic in schedule_state.diagnostics.iter().filter(|d| d.severity.get() > Severity::Info) {
        let text = |text: Text| schedule_state.text(text).to_owned();
        let subject = Subject::Named([text(diagnostic.global_id), "IfcTask".to_owned(), text(diagnostic.name)]);
        all.push(Found::of(IssueCode::ScheduleDoubtful, subject, text(diagnostic.message)));
    }
    all.extend(undiagnosed_boxes(site, &all));
    all
}

/// Elements and spaces by GlobalId.
struct ById<'a> {
    elements: BTreeMap<&'a str, Vec<usize>>,
    spaces: BTreeMap<&'a str, usize>,
}

impl<'a> ById<'a> {
    fn of(site: &Site<'a>) -> Self {
        let mut elements: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (k, element) in site.elements.iter().enumerate() {
            elements.entry(site.text(element.global_id)).or_default().push(k);
        }
        let spaces = site.spaces.iter().enumerate().map(|(k, space)| (site.text(space.global_id), k)).collect();
        Self { elements, spaces }
    }
}

/// The cause that a diagnostic of the model tells of.
fn code_of(code: DiagnosticCode) -> IssueCode {
    use DiagnosticCode as D;
    match code {
        D::GeometryFailed | D::BodyWithoutFaces | D::SwallowedByOpenings => IssueCode::GeometryFailed,
        D::GeometryIncomplete | D::BooleanDoubtful | D::OpeningsNotCut | D::OpeningFilled => {
            IssueCode::GeometryDoubtful
        }
        D::CoordinatesOutOfReach | D::PlacementUnusable => IssueCode::ElementOutOfReach,
        D::ProxyNotDrawn => IssueCode::NotDrawn,
        D::DuplicateGlobalId => IssueCode::DuplicateGlobalId,
        D::DoorOperationUnknown => IssueCode::DoorWithoutOperation,
        D::DoorWidthImplausible => IssueCode::DoorWidthWrong,
        D::DoorWidthMissing => IssueCode::DoorWithoutWidth,
        D::DoorWithoutBody => IssueCode::DoorWithoutBody,
        D::SpaceWithoutBody => IssueCode::RoomWithoutBody,
        D::StairMeasureImplausible => IssueCode::StairDoubtful,
        D::TerrainIncomplete | D::TerrainFacesUnusable | D::EarthworksNotCut => IssueCode::GroundDoubtful,
        D::MapConversionDoubtful
        | D::MapConversionUnusable
        | D::MapConversionMissing
        | D::MapScalesDiffer
        | D::ProjectedSystemsDiffer => IssueCode::GeoreferenceDoubtful,
        // The wall is cut where the door stands, so that the opening itself lies in the wall by now.
        D::OpeningBesideWall => IssueCode::OpeningMissesWall,
        // Of the schedule.
        D::CalendarUnreadable
        | D::DateEntityUnreadable
        | D::LagMissing
        | D::SequenceDangling
        | D::SequenceUserDefined
        | D::TaskCalendarTwice
        | D::TaskControlDangling
        | D::TaskLinkDangling
        | D::TaskLinkWithoutState
        | D::TaskLinksTooMany
        | D::TaskNestedTwice
        | D::TaskNestingCircle
        | D::TaskTimeMissing
        | D::TaskTimeRecurring
        | D::TimeUnitUnknown => IssueCode::ScheduleDoubtful,
        _ => IssueCode::FileDoubtful,
    }
}

fn of_site(situation: &Situation<'_>, by_id: &ById<'_>, diagnostic: &DiagnosticRecord) -> Vec<Found> {
    let site = situation.site;
    let kind = diagnostic.code.get();
    // Information is no fault, but for the widths that nothing else tells of.
    if diagnostic.severity.get() == Severity::Info && kind != DiagnosticCode::DoorWidthMissing {
        return Vec::new();
    }
    let code = code_of(kind);
    let [id, name, message] = [diagnostic.global_id, diagnostic.name, diagnostic.message].map(|text| site.text(text));
    let source = |element: &&usize| {
        diagnostic.source == NONE
            || (site.elements[**element].source == diagnostic.source
                && site.elements[**element].step_id == diagnostic.step_id)
    };
    let known = by_id.elements.get(id).and_then(|of| of.iter().find(source).or(of.first()));
    let subject = match (known, by_id.spaces.get(id)) {
        (Some(element), _) => Subject::Element(*element),
        (None, Some(space)) => Subject::Space(*space),
        (None, None) => {
            let file = site.source_file(diagnostic.source).unwrap_or_default();
            let step_id = if diagnostic.step_id == 0 { String::new() } else { format!("#{}", diagnostic.step_id) };
            let place = [file, &step_id].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ");
            let name = if name.is_empty() { place } else { name.to_owned() };
            Subject::Named([id.to_owned(), String::new(), name])
        }
    };
    let mut found = Found::of(code, subject.clone(), message);
    if kind == DiagnosticCode::OpeningBesideWall {
        found = found.without_effect_on_maps();
    }
    match subject {
        Subject::Element(element) => {
            let record = &site.elements[element];
            if code == IssueCode::GeometryFailed && record.has(element_flags::BOUNDING_BOX) {
                found.area_m2 = box_area_m2(record);
            }
            if record.door != NONE {
                found.doors.push(record.door);
            }
        }
        Subject::Space(space) => found.rooms.push(space as u32),
        Subject::Storey(_) | Subject::MapStorey(_) | Subject::Named(_) => {}
    }
    // A width that closes the door changes the map.
    let closes = |door: &u32| {
        let passage = situation.index.doors.iter().find(|passage| passage.door == *door);
        passage.is_some_and(|p| p.closed_by().any(|reason| reason == DoorPassage::TooNarrow))
    };
    if code == IssueCode::DoorWidthWrong && found.doors.iter().any(closes) {
        found.kind = crate::causes::IssueKind::Maps;
    }
    vec![found]
}

/// Bodies for which a box stands that no diagnostic names.
fn undiagnosed_boxes(site: &Site<'_>, told: &[Found]) -> Vec<Found> {
    let is_told = |k: usize| {
        let is_of = |found: &Found| matches!(found.subject, Subject::Element(element) if element == k);
        told.iter().any(|found| {
            is_of(found)
                && matches!(
                    found.code,
                    IssueCode::GeometryFailed | IssueCode::DoorWithoutBody | IssueCode::ElementOutOfReach
                )
        })
    };
    let failed = |k: &usize| {
        let element = &site.elements[*k];
        (element.has(element_flags::FAILED) || (element.has(element_flags::BOUNDING_BOX) && element.door == NONE))
            && !is_told(*k)
    };
    let found = |k: usize| {
        let mut found = Found::of(IssueCode::GeometryFailed, Subject::Element(k), "");
        if site.elements[k].has(element_flags::BOUNDING_BOX) {
            found.area_m2 = box_area_m2(&site.elements[k]);
        }
        found
    };
    (0..site.elements.len()).filter(failed).map(found).collect()
}

fn box_area_m2(record: &messages::ElementRecord) -> f64 {
    let side = |k: usize| metres(record.max_tenths[k] - record.min_tenths[k]);
    side(0) * side(1)
}

/// Words by which people name the property with the number of an activity, without what is no letter, lower case.
const ACTIVITY: [&str; 8] =
    ["activityid", "activitycode", "taskid", "activitynumber", "scheduleid", "4did", "vorgangsnummer", "activityno"];

/// Data that nothing in the model gives.
pub(crate) fn missing_data(situation: &Situation<'_>) -> Vec<Found> {
    let site = situation.site;
    let mut all = Vec::new();
    let file = |code| {
        let names: Vec<&str> = site.sources.iter().map(|source| site.text(source.file)).collect();
        Found::of(code, Subject::Named([String::new(), "IfcProject".to_owned(), names.join(", ")]), "")
    };
    if site.earth_from_world().is_none() {
        all.push(file(IssueCode::NoGeoreference));
    }
    let has_dates = site.has_schedule()
        || (0..site.elements.len())
            .any(|k| situation.schedule_state.schedule_of(k).source != messages::DateSource::None);
    let is_number = |attribute: &messages::AttributeRecord| {
        let name: String = site.text(attribute.name).chars().filter(|c| c.is_alphanumeric()).collect();
        ACTIVITY.iter().any(|word| name.to_lowercase() == *word)
    };
    if !has_dates && !site.attributes.iter().any(is_number) {
        all.push(file(IssueCode::NoDates));
    }
    all
}
