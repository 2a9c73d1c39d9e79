//! Progress in P6 XML: elements of each `Activity`.

use crate::planner_update::{Changed, PlannerFileError, TaskUpdates, number};
use quick_xml::Reader;
use quick_xml::events::Event;
use std::ops::Range;

/// An element of an activity: its name, its place, and its text.
struct Child {
    name: String,
    place: Range<usize>,
    text: String,
}

/// The file with progress: status, actual dates, remaining duration, and the percentage that the activity goes by, where that is of
/// duration or physical.
///
/// # Errors
/// What is no XML in UTF-8.
pub fn updated_pmxml(file: &[u8], updates: &TaskUpdates) -> Result<Vec<u8>, PlannerFileError> {
    let text = std::str::from_utf8(file).map_err(|_| PlannerFileError::Encoding)?;
    let mut reader = Reader::from_str(text);
    let (mut out, mut copied) = (Vec::with_capacity(file.len()), 0);
    // Depth below the activity: its own elements are at one.
    let (mut depth, mut children, mut before): (Option<usize>, Vec<Child>, usize) = (None, Vec::new(), 0);
    loop {
        let event = reader.read_event()?;
        let after = reader.buffer_position() as usize;
        match event {
            Event::Start(start) => match &mut depth {
                None if start.local_name().as_ref() == "Activity" => depth = Some(0),
                None => {}
                Some(depth) => {
                    *depth += 1;
                    if *depth == 1 {
                        let name = start.local_name().as_ref().to_owned();
                        children.push(Child { name, place: before..after, text: String::new() });
                    }
                }
            },
            Event::Empty(empty) if depth == Some(0) => {
                let name = empty.local_name().as_ref().to_owned();
                children.push(Child { name, place: before..after, text: String::new() });
            }
            Event::Text(text) if depth == Some(1) => {
                if let Some(child) = children.last_mut() {
                    child.text.push_str(&text);
                }
            }
            Event::End(_) => match depth {
                Some(0) => {
                    for (place, text) in edits(&children, updates, before) {
                        out.extend_from_slice(&file[copied..place.start]);
                        out.extend_from_slice(text.as_bytes());
                        copied = place.end;
                    }
                    depth = None;
                    children.clear();
                }
                Some(1) => {
                    depth = Some(0);
                    if let Some(child) = children.last_mut() {
                        child.place.end = after;
                    }
                }
                Some(below) => depth = Some(below - 1),
                None => {}
            },
            Event::Eof => break,
            _ => {}
        }
        before = after;
    }
    out.extend_from_slice(&file[copied..]);
    Ok(out)
}

/// What changes in an activity that ends at `end`, by place.
fn edits(children: &[Child], updates: &TaskUpdates, end: usize) -> Vec<(Range<usize>, String)> {
    let text = |name: &str| children.iter().find(|child| child.name == name).map(|child| child.text.trim());
    let update = text("ObjectId").and_then(|id| updates.get(id));
    let Some(changed) = update.and_then(Changed::of) else { return Vec::new() };
    let share = changed.percent.map(|percent| number(percent / 100.0, '.'));
    let planned_h = text("PlannedDuration").and_then(|hours| hours.parse::<f64>().ok());
    let remaining_h = if changed.is_done { Some(0.0) } else { planned_h.and_then(|hours| changed.remaining_h(hours)) };
    let of_kind = |kind: &str| share.clone().filter(|_| text("PercentCompleteType") == Some(kind));
    let wanted = [
        ("ActualFinishDate", changed.finish.clone()),
        ("ActualStartDate", changed.start.clone()),
        ("DurationPercentComplete", of_kind("Duration")),
        ("PercentComplete", of_kind("Duration").or_else(|| of_kind("Physical"))),
        ("PhysicalPercentComplete", of_kind("Physical")),
        ("RemainingDuration", remaining_h.map(|hours| number(hours, '.'))),
        ("Status", Some(if changed.is_done { "Completed" } else { "In Progress" }.to_owned())),
    ];
    let mut edits: Vec<(Range<usize>, String)> = wanted
        .into_iter()
        .filter_map(|(name, value)| {
            // A finish that the file has is that of a task which the report says is at work.
            let is_stale =
                name == "ActualFinishDate" && !changed.is_done && text(name).is_some_and(|at| !at.is_empty());
            let element = match value {
                Some(value) => format!("<{name}>{value}</{name}>"),
                None if is_stale => String::new(),
                None => return None,
            };
            let place = match children.iter().find(|child| child.name == name) {
                Some(child) => child.place.clone(),
                // The elements of an activity are in the order of their names.
                None => {
                    let next = children.iter().find(|child| child.name.as_str() > name);
                    let at = next.map_or(end, |next| next.place.start);
                    at..at
                }
            };
            Some((place, element))
        })
        .collect();
    edits.sort_by_key(|(place, _)| (place.start, place.end));
    edits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner_update::TaskUpdate;

    const FILE: &str = "<?xml version=\"1.0\"?>\n<X xmlns:xsi=\"x\"><Project><Activity><ActualFinishDate xsi:nil=\"true\"/>\
        <Name>W &amp; Ä</Name><ObjectId>7</ObjectId><PercentComplete>0</PercentComplete><PercentCompleteType>Duration</PercentCompleteType>\
        <PlannedDuration>40</PlannedDuration><RemainingDuration>40</RemainingDuration><Status>Not Started</Status>\
        <Code><ObjectId>8</ObjectId></Code></Activity>\r\n<Activity><ObjectId>8</ObjectId></Activity></Project></X>\n";

    fn updated(id: &str, percent: f64, finish: Option<&str>) -> String {
        let update = TaskUpdate {
            percent: Some(percent),
            start: Some("2024-03-04T08:00:00".to_owned()),
            finish: finish.map(str::to_owned),
        };
        String::from_utf8(updated_pmxml(FILE.as_bytes(), &TaskUpdates::from([(id.to_owned(), update)])).unwrap())
            .unwrap()
    }

    #[test]
    fn elements_of_an_activity_change_or_come_where_their_names_belong() {
        let begun = "<ActualFinishDate xsi:nil=\"true\"/><ActualStartDate>2024-03-04T08:00:00</ActualStartDate>\
            <DurationPercentComplete>0.25</DurationPercentComplete><Name>";
        let expected = FILE
            .replacen("<ActualFinishDate xsi:nil=\"true\"/><Name>", begun, 1)
            .replacen("<PercentComplete>0<", "<PercentComplete>0.25<", 1)
            .replacen("<RemainingDuration>40<", "<RemainingDuration>30<", 1)
            .replacen("Not Started", "In Progress", 1);
        assert_eq!(updated("7", 25.0, None), expected);
        let done = updated("7", 0.0, Some("2024-03-07T17:00:00"));
        assert!(
            done.contains("<ActualFinishDate>2024-03-07T17:00:00</ActualFinishDate>") && done.contains(">Completed<")
        );
        assert!(done.contains("<PercentComplete>1<") && done.contains("<RemainingDuration>0<"), "{done}");
        assert!(updated("8", 50.0, None).contains("<ActualStartDate>2024-03-04T08:00:00</ActualStartDate><ObjectId>8</ObjectId><Status>In Progress</Status></Activity>"));
        assert_eq!(updated("9", 50.0, None), FILE);
    }
}
