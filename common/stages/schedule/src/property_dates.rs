//! Reads construction dates, construction phases and status from property sets by configured rules.

use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::error::{AmbiguousDates, EvaluateError};
use crate::rules::{DateKind, Rules, RulesMode};
use frames::written_date::{self, DateError, DateOrder, WrittenDate};
use jiff::tz::TimeZone;
use messages::{AttributeKind, AttributeRecord, DiagnosticCode, ElementRecord, Severity, Site, Text};
use std::collections::BTreeMap;

/// Schedule properties of one element or space.
#[derive(Debug, Clone, Default)]
pub(crate) struct ObjectProperties {
    pub(crate) actual: Option<WrittenDate>,
    pub(crate) planned: Option<WrittenDate>,
    pub(crate) created: Option<Text>,
    pub(crate) demolished: Option<Text>,
    /// Construction phase at whose end a space is released.
    pub(crate) construction_phase: Option<Text>,
    pub(crate) status: Option<Text>,
    /// A date of it fits both orders, and other dates of the file decided.
    pub(crate) is_ambiguous: bool,
}

/// Schedule properties of all elements and spaces.
pub(crate) struct ScheduleProperties {
    pub(crate) elements: Vec<ObjectProperties>,
    pub(crate) spaces: Vec<ObjectProperties>,
}

/// An element or space with its properties.
struct Object<'a> {
    attributes: &'a [AttributeRecord],
    /// `None` for a space.
    element: Option<&'a ElementRecord>,
    entity: Entity,
    global_id: Text,
    source: u32,
}

/// A date property, not parsed yet.
struct DateText {
    object: usize,
    rule: usize,
    attribute: AttributeRecord,
}

/// Reads the schedule properties of all elements and spaces.
///
/// # Errors
/// Dates of a file that fit two orders, if nothing else decides.
pub(crate) fn schedule_properties(
    site: &Site<'_>,
    rules: &Rules,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Result<ScheduleProperties, EvaluateError> {
    let elements = site.elements.iter().map(|e| Object {
        attributes: site.element_attributes(e),
        element: Some(e),
        entity: Entity::of(e.global_id, e.name, e.step_id, e.source),
        global_id: e.global_id,
        source: e.source,
    });
    let spaces = site.spaces.iter().map(|s| Object {
        attributes: site.space_attributes(s),
        element: None,
        entity: Entity::of(s.global_id, s.name, 0, s.source),
        global_id: s.global_id,
        source: s.source,
    });
    let objects: Vec<Object<'_>> = elements.chain(spaces).collect();
    let mut properties = vec![ObjectProperties::default(); objects.len()];
    let texts = collect(site, rules, &objects, &mut properties);
    let orders = orders(site, rules, &objects, &texts)?;
    for text in &texts {
        let object = &objects[text.object];
        let order = orders[object.source as usize];
        let rule = &rules.property_dates[text.rule];
        let properties = &mut properties[text.object];
        match read(site, rules, &text.attribute, order.0) {
            Ok(date) => {
                let kind = if rule.kind == DateKind::Actual { &mut properties.actual } else { &mut properties.planned };
                // Rules rank in their order, and so were the texts collected.
                kind.get_or_insert(date);
                properties.is_ambiguous |=
                    order.1 && readings(site.text(text.attribute.text)).is_some_and(|[a, b]| a != b);
            }
            Err(why) => {
                let (severity, code) = match why {
                    DateError::Placeholder(_) => (Severity::Warning, DiagnosticCode::DatePlaceholder),
                    DateError::Unreadable(_) => (Severity::Error, DiagnosticCode::DateUnreadable),
                    DateError::OtherOrder { .. } => (Severity::Error, DiagnosticCode::DateOrder),
                    DateError::NoSiteZone(_) => (Severity::Error, DiagnosticCode::DateZone),
                };
                let message = format!("{}.{}: {why}; it is skipped", rule.set, rule.property);
                diagnostics.add(severity, code, Some(object.entity), message);
            }
        }
    }
    let spaces = properties.split_off(site.elements.len());
    Ok(ScheduleProperties { elements: properties, spaces })
}

/// Sets construction phases and status, and collects the date properties that the rules name, rule by rule.
fn collect(
    site: &Site<'_>,
    rules: &Rules,
    objects: &[Object<'_>],
    properties: &mut [ObjectProperties],
) -> Vec<DateText> {
    let construction_phases = &rules.construction_phase_properties;
    let mut texts = Vec::new();
    let mut sets: BTreeMap<(u32, u32), SetUse> = BTreeMap::new();
    for (index, object) in objects.iter().enumerate() {
        for attribute in object.attributes {
            let set = site.text(attribute.set);
            let key = (attribute.set.offset, attribute.set.length);
            let used = sets.entry(key).or_insert_with(|| SetUse::of(set, rules));
            if !used.any {
                continue;
            }
            let name = site.text(attribute.name);
            let properties = &mut properties[index];
            let mut note = |wanted: bool, slot: fn(&mut ObjectProperties) -> &mut Option<Text>| {
                if wanted && attribute.text.length > 0 {
                    slot(properties).get_or_insert(attribute.text);
                }
            };
            note(used.construction_phases && name == construction_phases.created, |s| &mut s.created);
            note(used.construction_phases && name == construction_phases.demolished, |s| &mut s.demolished);
            note(used.construction_phases && name == construction_phases.space, |s| &mut s.construction_phase);
            note(used.status && name == "Status", |s| &mut s.status);
            for &rule in &used.rules {
                let wanted = &rules.property_dates[rule];
                let is_wanted = |entity: &str| entity.eq_ignore_ascii_case(&wanted.applies_to);
                let applies = || match object.element {
                    Some(element) => site.supertypes(element).any(is_wanted),
                    None => is_wanted("IfcSpace"),
                };
                if name == wanted.property && applies() {
                    texts.push(DateText { object: index, rule, attribute: *attribute });
                }
            }
        }
    }
    texts.sort_by_key(|t| (t.object, t.rule));
    texts
}

/// How the rules use a property set.
struct SetUse {
    any: bool,
    construction_phases: bool,
    status: bool,
    rules: Vec<usize>,
}

impl SetUse {
    fn of(set: &str, rules: &Rules) -> Self {
        let construction_phases = set == rules.construction_phase_properties.set;
        let status = set.starts_with("Pset_") && set.ends_with("Common");
        let dates: Vec<usize> =
            (0..rules.property_dates.len()).filter(|k| rules.property_dates[*k].set == set).collect();
        Self { any: construction_phases || status || !dates.is_empty(), construction_phases, status, rules: dates }
    }
}

fn read(
    site: &Site<'_>,
    rules: &Rules,
    attribute: &AttributeRecord,
    order: DateOrder,
) -> Result<WrittenDate, DateError> {
    let zone = rules.site_zone.as_ref();
    if attribute.kind == AttributeKind::Number {
        return written_date::from_timestamp(attribute.number, zone);
    }
    written_date::parse(site.text(attribute.text), order, zone)
}

/// A text in both orders, where it is a date in any.
fn readings(text: &str) -> Option<[Option<WrittenDate>; 2]> {
    if written_date::is_iso(text) {
        return None;
    }
    // Readings are compared with each other: the zone does not matter.
    let both = [DateOrder::Dmy, DateOrder::Mdy].map(|order| written_date::in_order(text, order, &TimeZone::UTC));
    both.iter().any(Option::is_some).then_some(both)
}

/// The order of text dates by file, and whether it was found out from the dates themselves.
fn orders(
    site: &Site<'_>,
    rules: &Rules,
    objects: &[Object<'_>],
    texts: &[DateText],
) -> Result<Vec<(DateOrder, bool)>, EvaluateError> {
    // The published prototype knows day/month/year alone.
    let fixed = rules.date_format.or((rules.mode == RulesMode::Paper).then_some(DateOrder::Dmy));
    if let Some(order) = fixed {
        return Ok(vec![(order, false); site.sources.len().max(1)]);
    }
    (0..site.sources.len().max(1))
        .map(|source| {
            let of_file = || texts.iter().filter(|t| objects[t.object].source as usize == source);
            let read = || of_file().filter_map(|t| Some((t, readings(site.text(t.attribute.text))?)));
            let only = |order: usize| read().find(|(_, r)| r[order].is_some() && r[1 - order].is_none());
            let file = || site.sources.get(source).map_or("the model", |s| site.text(s.file)).to_owned();
            let text = |t: &DateText| site.text(t.attribute.text).to_owned();
            match (only(0), only(1)) {
                (Some((dmy, _)), Some((mdy, _))) => {
                    Err(EvaluateError::ContradictingDates { file: file(), dmy: text(dmy), mdy: text(mdy) })
                }
                (Some(_), None) => Ok((DateOrder::Dmy, true)),
                (None, Some(_)) => Ok((DateOrder::Mdy, true)),
                (None, None) => match read().find(|(_, [dmy, mdy])| dmy != mdy) {
                    None => Ok((DateOrder::Dmy, false)),
                    Some((t, readings)) => {
                        let rule = &rules.property_dates[t.rule];
                        let [dmy, mdy] = readings.map(|r| r.map(day).unwrap_or_default());
                        Err(EvaluateError::AmbiguousDates(Box::new(AmbiguousDates {
                            file: file(),
                            text: text(t),
                            property: format!("{}.{}", rule.set, rule.property),
                            global_id: site.text(objects[t.object].global_id).to_owned(),
                            dmy,
                            mdy,
                            n_dates: of_file().count(),
                        })))
                    }
                },
            }
        })
        .collect()
}

fn day(date: WrittenDate) -> String {
    messages::plan_time(date.start_s()).map(|t| t.0.date().to_string()).unwrap_or_default()
}
