//! Schedule rules of a site from TOML; `config/schedule.toml` documents every key.

use crate::probability::Uncertainty;
use frames::written_date::{DateOrder, WrittenDate, parse_iso};
use jiff::tz::TimeZone;
use schedule_files::{CsvColumn, ReadOptions};
use serde::Deserialize;
use std::collections::BTreeMap;
use tasks::{EffectWords, LinkRules, LinkRulesToml, LinkToml};

/// Rules for reading dates and closing spaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    /// Order of text dates; `None` takes what the file's dates can only mean.
    pub date_format: Option<DateOrder>,
    /// The length of a day in working time.
    pub duration_day: DurationDay,
    /// For dates that carry a zone.
    pub site_zone: Option<TimeZone>,
    /// What an element without any date is.
    pub undated: Undated,
    /// Which evaluation is used.
    pub mode: RulesMode,
    /// What an input of a constructing task becomes.
    pub inputs: InputEffect,
    /// Properties that hold dates, in order of rank within their kind.
    pub property_dates: Vec<PropertyDate>,
    /// Properties that name construction phases.
    pub construction_phase_properties: ConstructionPhaseProperties,
    /// When construction phases are; they have no dates in the file.
    pub construction_phases: Vec<ConstructionPhase>,
    /// Spaces that are closed by configuration.
    pub closed_spaces: Vec<ClosedSpace>,
    /// How schedule files are read: columns of tables, the sheet of workbooks, the order of dates, the encoding.
    pub reading: ReadOptions,
    /// Which tasks of schedule files work on which elements.
    pub links: LinkRules,
    /// A space is closing soon this long before it is blocked, in seconds.
    pub closing_lead_s: i64,
    /// How uncertain durations are, and what planning takes as certain.
    pub uncertainty: Uncertainty,
}

/// What `P1D` means in working time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
pub enum DurationDay {
    /// The working hours of one day of the calendar.
    #[default]
    #[serde(rename = "working_day")]
    WorkingDay,
    /// 24 working hours.
    #[serde(rename = "24h")]
    Hours24,
}

/// What an element without any date is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Undated {
    /// It stands at all times.
    #[default]
    Existing,
    /// It never stands.
    Absent,
}

/// Which evaluation is used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RulesMode {
    /// The evaluation of this crate.
    #[default]
    Standard,
    /// That of the published prototype: walls, doors and rooms by property dates; everything else is left out.
    Paper,
}

/// What an input (IfcRelAssignsToProcess) of a constructing task becomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InputEffect {
    /// The same as an output.
    #[default]
    Same,
    /// It is used up: removed.
    Consume,
}

/// A property that holds a date.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropertyDate {
    /// Entity, subtypes included, e.g. `IfcWall`; `IfcSpace` for rooms.
    pub applies_to: String,
    /// Property set.
    pub set: String,
    /// Property.
    pub property: String,
    /// Whether it says what is planned or what happened.
    #[serde(default)]
    pub kind: DateKind,
}

/// Whether a date says what is planned or what happened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DateKind {
    /// It happened.
    Actual,
    /// It is planned.
    #[default]
    Planned,
}

/// Properties that name construction phases.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ConstructionPhaseProperties {
    /// Property set.
    pub set: String,
    /// Construction phase in which an element is built.
    pub created: String,
    /// Construction phase in which it is removed.
    pub demolished: String,
    /// Construction phase at whose end a space is released.
    pub space: String,
}

/// A construction phase by its name; without start and finish it is before all time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConstructionPhase {
    /// As the properties spell it.
    pub name: String,
    /// Civil seconds since 1970 of start and finish.
    pub span_s: Option<[i64; 2]>,
}

/// Spaces that are closed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClosedSpace {
    /// GlobalId, or a pattern of Name, LongName or both: `*` for any text, `?` for one character.
    pub pattern: String,
    /// The reason of the closure.
    pub reason: String,
    /// From this time on, civil seconds since 1970.
    pub from_s: i64,
    /// Until then.
    pub until_s: i64,
}

/// A rules file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RulesError {
    /// Not TOML, an unknown key, or a value of the wrong type: the source has line and column.
    #[error("the rules cannot be read")]
    Toml(#[source] Box<toml::de::Error>),
    /// A value that is not valid.
    #[error("{0}")]
    Value(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RulesToml {
    date_format: Option<DateOrder>,
    encoding: Option<String>,
    sheet: Option<String>,
    #[serde(default)]
    duration_day: DurationDay,
    site_zone: Option<String>,
    #[serde(default)]
    undated: Undated,
    #[serde(default)]
    mode: RulesMode,
    #[serde(default)]
    inputs: InputEffect,
    property_dates: Option<Vec<PropertyDate>>,
    #[serde(default, rename = "phase_properties")]
    construction_phase_properties: ConstructionPhaseProperties,
    #[serde(default, rename = "phases")]
    construction_phases: Vec<ConstructionPhaseToml>,
    #[serde(default)]
    closed_spaces: Vec<ClosedSpaceToml>,
    closing: Option<ClosingToml>,
    #[serde(default)]
    csv_columns: BTreeMap<CsvColumn, String>,
    link: Option<Vec<LinkToml>>,
    #[serde(default)]
    link_words: EffectWords,
    #[serde(default)]
    uncertainty: Uncertainty,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ConstructionPhaseToml {
    name: String,
    start: Option<toml::Value>,
    finish: Option<toml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClosedSpaceToml {
    r#match: String,
    #[serde(default = "private")]
    reason: String,
    from: Option<toml::Value>,
    until: Option<toml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClosingToml {
    lead_minutes: u32,
}

const LEAD_MINUTES: u32 = 30;

fn private() -> String {
    "private".to_owned()
}

impl Default for ConstructionPhaseProperties {
    fn default() -> Self {
        let [set, created, demolished, space] =
            ["Phasing", "Phase Created", "Phase Demolished", "Phase"].map(str::to_owned);
        Self { set, created, demolished, space }
    }
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            date_format: None,
            duration_day: DurationDay::default(),
            site_zone: None,
            undated: Undated::default(),
            mode: RulesMode::default(),
            inputs: InputEffect::default(),
            property_dates: published_dates(),
            construction_phase_properties: ConstructionPhaseProperties::default(),
            construction_phases: Vec::new(),
            closed_spaces: Vec::new(),
            reading: ReadOptions::default(),
            links: LinkRules::default(),
            closing_lead_s: i64::from(LEAD_MINUTES) * 60,
            uncertainty: Uncertainty::default(),
        }
    }
}

/// The property sets of the published prototype.
fn published_dates() -> Vec<PropertyDate> {
    let rules = [
        ("IfcWall", "Wall Schedule", "ConstructionDate"),
        ("IfcDoor", "Door Schedule", "DoorDate"),
        ("IfcSpace", "Room Schedule", "RoomDate"),
    ];
    let rule = |(applies_to, set, property): (&str, &str, &str)| PropertyDate {
        applies_to: applies_to.to_owned(),
        set: set.to_owned(),
        property: property.to_owned(),
        kind: DateKind::Planned,
    };
    rules.map(rule).to_vec()
}

impl Rules {
    /// Reads the text of a rules file; keys that are not there have their defaults.
    ///
    /// # Errors
    /// Not TOML, unknown keys, zones or dates that do not exist, construction phases that end before they start or are
    /// named twice.
    pub fn parse(text: &str) -> Result<Self, RulesError> {
        let file: RulesToml = toml::from_str(text).map_err(|e| RulesError::Toml(Box::new(e)))?;
        let site_zone = file.site_zone.as_deref().map(zone).transpose()?;
        let lead_minutes = file.closing.map_or(LEAD_MINUTES, |c| c.lead_minutes);
        let construction_phases: Vec<ConstructionPhase> = file
            .construction_phases
            .iter()
            .map(|p| construction_phase(p, site_zone.as_ref()))
            .collect::<Result<_, RulesError>>()?;
        if let Some((k, twice)) = construction_phases
            .iter()
            .enumerate()
            .find(|(k, p)| construction_phases[..*k].iter().any(|q| q.name == p.name))
        {
            return Err(RulesError::Value(format!("phases[{k}]: {:?} has dates already", twice.name)));
        }
        let closed_spaces = file.closed_spaces.into_iter().map(|c| closed_space(c, site_zone.as_ref()));
        let links = LinkRules::of(LinkRulesToml { link: file.link, link_words: file.link_words })
            .map_err(|e| RulesError::Value(e.to_string()))?;
        let reading = ReadOptions {
            columns: file.csv_columns,
            date_format: file.date_format,
            encoding: file.encoding.map(encoding).transpose()?,
            sheet: file.sheet,
        };
        Ok(Self {
            reading,
            links,
            closed_spaces: closed_spaces.collect::<Result<_, RulesError>>()?,
            date_format: file.date_format,
            duration_day: file.duration_day,
            undated: file.undated,
            mode: file.mode,
            inputs: file.inputs,
            property_dates: file.property_dates.unwrap_or_else(published_dates),
            construction_phase_properties: file.construction_phase_properties,
            construction_phases,
            closing_lead_s: i64::from(lead_minutes) * 60,
            uncertainty: file.uncertainty.checked().map_err(RulesError::Value)?,
            site_zone,
        })
    }
}

fn encoding(label: String) -> Result<String, RulesError> {
    if schedule_files::is_encoding(&label) {
        return Ok(label);
    }
    Err(RulesError::Value(format!("encoding: there is no encoding {label:?}; write e.g. \"windows-1250\" or \"big5\"")))
}

fn zone(name: &str) -> Result<TimeZone, RulesError> {
    TimeZone::get(name).map_err(|_| {
        RulesError::Value(format!("site_zone: there is no time zone {name:?}; write e.g. \"Europe/Amsterdam\""))
    })
}

fn date(key: &str, value: &toml::Value, zone: Option<&TimeZone>) -> Result<WrittenDate, RulesError> {
    let text = match value {
        toml::Value::Datetime(date) => date.to_string(),
        toml::Value::String(text) => text.clone(),
        other => {
            return Err(RulesError::Value(format!(
                "{key}: {other} is no date; write 2024-03-04 or 2024-03-04T08:00:00"
            )));
        }
    };
    parse_iso(&text, zone).map_err(|e| RulesError::Value(format!("{key}: {e}")))
}

fn construction_phase(file: &ConstructionPhaseToml, zone: Option<&TimeZone>) -> Result<ConstructionPhase, RulesError> {
    let name = &file.name;
    let span_s = match (&file.start, &file.finish) {
        (None, None) => None,
        (Some(start), Some(finish)) => {
            let start_s = date(&format!("start of phase {name:?}"), start, zone)?.start_s();
            let finish_s = date(&format!("finish of phase {name:?}"), finish, zone)?.finish_s();
            if finish_s < start_s {
                return Err(RulesError::Value(format!("phase {name:?} finishes before it starts")));
            }
            Some([start_s, finish_s])
        }
        _ => {
            return Err(RulesError::Value(format!(
                "phase {name:?} has one of start and finish; give both, or none if it exists"
            )));
        }
    };
    Ok(ConstructionPhase { name: name.clone(), span_s })
}

fn closed_space(file: ClosedSpaceToml, zone: Option<&TimeZone>) -> Result<ClosedSpace, RulesError> {
    let pattern = file.r#match;
    let end = |word: &str, value: Option<&toml::Value>| {
        value.map(|v| date(&format!("{word} of closed space {pattern:?}"), v, zone)).transpose()
    };
    let from_s = end("from", file.from.as_ref())?.map_or(i64::MIN, WrittenDate::start_s);
    let until_s = end("until", file.until.as_ref())?.map_or(i64::MAX, WrittenDate::finish_s);
    if until_s <= from_s {
        return Err(RulesError::Value(format!("closed space {pattern:?} opens before it closes")));
    }
    let is_one_line = |text: &str| !text.is_empty() && !text.contains('\n');
    if !is_one_line(&file.reason) || pattern.is_empty() {
        return Err(RulesError::Value("closed_spaces: match and reason are one line each".to_owned()));
    }
    Ok(ClosedSpace { pattern, reason: file.reason, from_s, until_s })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        let error = Rules::parse(text).unwrap_err();
        let cause = std::error::Error::source(&error).map(|e| e.to_string()).unwrap_or_default();
        format!("{error}: {cause}")
    }

    #[test]
    fn the_shipped_file_holds_the_defaults() {
        let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../config/schedule.toml");
        assert_eq!(Rules::parse(&std::fs::read_to_string(shipped).unwrap()).unwrap(), Rules::default());
        assert_eq!(Rules::parse("").unwrap(), Rules::default());
    }

    #[test]
    fn the_examples_of_the_shipped_file_can_be_used() {
        let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../config/schedule.toml");
        let text = std::fs::read_to_string(shipped).unwrap();
        let lines: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("# ")).collect();
        let table = |head: &str, n: usize| {
            let at = lines.iter().position(|line| *line == head).unwrap();
            lines[at..at + n].join("\n")
        };
        let rules = Rules::parse(&table("[[link]]", 5)).unwrap();
        assert_eq!((rules.links.rules.len(), &*rules.links.rules[0].name), (1, "Dry lining by storey"));
        assert_eq!(Rules::parse("sheet = \"Look-ahead\"").unwrap().reading.sheet.as_deref(), Some("Look-ahead"));
        let columns = Rules::parse(&table("[csv_columns]", 3)).unwrap().reading.columns;
        assert_eq!(columns[&CsvColumn::Code], "Position");
        // Every column that there is, is named.
        let named = lines.iter().skip_while(|line| !line.starts_with("Headings of columns")).take(6).copied();
        let named = named.collect::<Vec<_>>().join(" ");
        let columns = named.split_once("Columns: ").unwrap().1.split_once('.').unwrap().0;
        let columns = columns.split(", ").map(|column| format!("{column} = \"{column}\"\n"));
        let all = format!("[csv_columns]\n{}", columns.collect::<String>());
        assert_eq!(Rules::parse(&all).unwrap().reading.columns.len(), 26);
    }

    #[test]
    fn unknown_keys_are_named_with_their_line() {
        let error = error("undated = \"absent\"\ndate_fromat = \"dmy\"\n");
        assert!(error.contains("date_fromat") && error.contains("line 2"), "{error}");
    }

    #[test]
    fn values_that_mean_nothing_are_refused() {
        for (text, word) in [
            ("site_zone = \"Europe/Atlantis\"", "Atlantis"),
            ("date_format = \"ymd\"", "ymd"),
            ("[[phases]]\nname = \"1\"\nstart = 2024-03-04", "one of start and finish"),
            ("[[phases]]\nname = \"1\"\nstart = 2024-03-04\nfinish = 2024-03-01", "before it starts"),
            ("[[phases]]\nname = \"1\"\n[[phases]]\nname = \"1\"", "already"),
            ("[[phases]]\nname = \"1\"\nstart = 5\nfinish = 6", "no date"),
            ("[uncertainty]\noptimistic = 1.2", "optimistic"),
            ("[uncertainty]\npessimistic = nan", "pessimistic"),
            ("[uncertainty]\nruns = 0", "runs"),
            ("[uncertainty]\nopen_above = 1.0", "open_above"),
            ("[uncertainty]\nlikely = 1.0", "likely"),
            ("[[closed_spaces]]\nmatch = \"Lab\"\nfrom = 2024-03-04\nuntil = 2024-03-01", "opens before"),
        ] {
            let error = error(text);
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn construction_phases_and_closed_spaces_have_civil_times() {
        let rules = Rules::parse(
            "[[phases]]\nname = \"Phase 1\"\nstart = 2024-03-04T00:00:00\nfinish = 2024-04-08\n\
             [[closed_spaces]]\nmatch = \"Lab 3*\"\nuntil = \"2024-03-04T12:00:00\"\n[closing]\nlead_minutes = 5",
        )
        .unwrap();
        let at = |text: &str| text.parse::<frames::PlanTime>().unwrap().civil_seconds();
        assert_eq!(
            rules.construction_phases[0].span_s,
            Some([at("2024-03-04"), at("2024-04-09")]),
            "a finish without a time is the end of its day"
        );
        let closed = &rules.closed_spaces[0];
        assert_eq!(
            (closed.reason.as_str(), closed.from_s, closed.until_s),
            ("private", i64::MIN, at("2024-03-04T12:00"))
        );
        assert_eq!(rules.closing_lead_s, 300);
    }
}
