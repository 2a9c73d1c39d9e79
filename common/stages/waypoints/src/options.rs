//! Waypoint options from TOML; `config/waypoints.toml` documents every key.

use crate::flight_options::{FlightOptions, FlightToml};
use frames::PlanTimeError;
use grid::Class;
use messages::{DriveModel, ScanSensor, Site, WayCost, WaypointKind};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, TAU};

use wildmatch::WildMatch;

/// Options of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct MissionPlanOptions {
    /// Kinds of waypoints that are planned.
    pub kinds: BTreeSet<WaypointKind>,
    /// Names, long names or GlobalIds of spaces, with `*` and `?`; all if empty.
    pub spaces: Vec<String>,
    /// Map storeys on which waypoints are planned; all if empty. The others are only passed through.
    pub storeys: Vec<u32>,
    /// Scan only elements built since this time, in civil seconds.
    pub changed_since_s: Option<i64>,
    /// Place waypoints at half the height of their space, for flying robots. Nothing looks at the air there: [`Self::flight`] does.
    pub flies: bool,
    /// Plan flight waypoints, which keep a distance from the bodies in all directions.
    pub flight: Option<FlightOptions>,
    /// Sensor of the scans.
    pub sensor: ScanSensor,
    /// Share of the visible target faces that the scans must see.
    pub coverage: f64,
    /// The same share for each space; without effect with a budget.
    pub space_coverage: f64,
    /// Length of target faces that a scan must see and no other sees; spaces below their share have scans regardless.
    pub min_gain_m: f64,
    /// Budget: the largest number of scans of the mission plan.
    pub scans_max: Option<u32>,
    /// Budget: the longest duration of driving and scanning of the mission plan.
    pub minutes_max: Option<f64>,
    /// Share of the faces of each scan that scans registered before it must also see.
    pub overlap: f64,
    /// Smallest distance between two scans, unless the share of a space cannot be reached otherwise.
    pub separation_m: f64,
    /// Exchanges of the tabu search, per scan.
    pub search_steps: u32,
    /// Random kicks of the tour search.
    pub tour_kicks: u32,
    /// Spacing of the candidate places for scans.
    pub spacing_m: f64,
    /// Classes whose faces are targets: a bit per class.
    pub classes: u32,
    /// Check the coverage on the meshes of the elements.
    pub mesh_check: bool,
    /// Start of the robot; by default the largest part of each storey with a stair, lift or outer door.
    pub start: Option<Start>,
    /// Tours return to their start.
    pub closed_tours: bool,
    /// Lifts that the robot can take: names or GlobalIds, with `*` and `?`.
    pub lifts: Vec<String>,
    /// How the robot drives, and by what its ways are chosen.
    pub drive: DriveModel,
    /// Duration of a scan.
    pub scan_s: f64,
}

/// Start of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Index of the map storey.
    pub storey: u32,
    /// In `map`.
    pub x_m: f64,
    /// In `map`.
    pub y_m: f64,
}

/// Errors of waypoint options.
#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    /// Not TOML, an unknown key, or a value of the wrong type: the source has line and column.
    #[error("it has other keys or values than options have")]
    Toml(#[from] Box<toml::de::Error>),
    /// A value out of range.
    #[error("{0}")]
    Value(String),
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct OptionsToml {
    waypoints: Option<Vec<String>>,
    spaces: Vec<String>,
    flies: bool,
    flight: Option<FlightToml>,
    sensor: SensorToml,
    scan: ScanToml,
    tour: TourToml,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct SensorToml {
    range_m: Option<f64>,
    min_range_m: Option<f64>,
    max_incidence_rad: Option<f64>,
    field_of_view_rad: Option<f64>,
    min_elevation_rad: Option<f64>,
    max_elevation_rad: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ScanToml {
    coverage: Option<f64>,
    scans: Option<u32>,
    minutes: Option<f64>,
    space_coverage: Option<f64>,
    min_gain_m: Option<f64>,
    overlap: Option<f64>,
    separation_m: Option<f64>,
    quality: Option<u32>,
    spacing_m: Option<f64>,
    classes: Option<Vec<String>>,
    mesh_check: bool,
    changed_since: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TourToml {
    start: Option<Start>,
    closed: bool,
    lifts: Vec<String>,
    cost: Option<String>,
    speed_m_s: Option<f64>,
    climb_s_per_m: Option<f64>,
    mass_kg: Option<f64>,
    rolling_resistance: Option<f64>,
    drive_efficiency: Option<f64>,
    idle_w: Option<f64>,
    scan_s: Option<f64>,
}

impl Default for MissionPlanOptions {
    fn default() -> Self {
        Self {
            kinds: WaypointKind::ALL.into(),
            spaces: Vec::new(),
            storeys: Vec::new(),
            changed_since_s: None,
            flies: false,
            flight: None,
            sensor: ScanSensor::DEFAULT,
            coverage: 0.99,
            space_coverage: 0.8,
            min_gain_m: 0.5,
            scans_max: None,
            minutes_max: None,
            overlap: 0.2,
            separation_m: 0.5,
            search_steps: STEPS_PER_QUALITY,
            tour_kicks: KICKS_PER_QUALITY,
            spacing_m: 0.5,
            classes: STRUCTURE,
            mesh_check: false,
            start: None,
            closed_tours: false,
            lifts: Vec::new(),
            drive: DriveModel::DEFAULT,
            scan_s: 60.0,
        }
    }
}

/// Classes of what does not move when people use a building.
const STRUCTURE: u32 = 1 << Class::Wall as u32
    | 1 << Class::Column as u32
    | 1 << Class::Door as u32
    | 1 << Class::Window as u32
    | 1 << Class::CurtainWall as u32
    | 1 << Class::Stair as u32;

/// Exchanges per scan, and kicks, per unit of `quality`.
const STEPS_PER_QUALITY: u32 = 100;
const KICKS_PER_QUALITY: u32 = 200;

impl MissionPlanOptions {
    /// These, for the spaces and the time that a command named beside them, where it did.
    #[must_use]
    pub fn narrowed(mut self, spaces: &[String], changed_since_s: Option<i64>) -> Self {
        if !spaces.is_empty() {
            self.spaces = spaces.to_vec();
        }
        self.changed_since_s = changed_since_s.or(self.changed_since_s);
        self
    }

    /// Options for centres only, which are planned fast.
    pub fn centres_only() -> Self {
        Self { kinds: [WaypointKind::Centre].into(), ..Self::default() }
    }

    /// True if scans are planned.
    pub(crate) fn plans_scans(&self) -> bool {
        self.kinds.contains(&WaypointKind::Scan)
    }

    /// True if a number of scans or a duration limits the plan.
    pub fn has_budget(&self) -> bool {
        self.scans_max.is_some() || self.minutes_max.is_some()
    }

    /// Parses options from TOML.
    ///
    /// # Errors
    /// A text that is no TOML with these keys, or a value out of range.
    pub fn parse(text: &str) -> Result<Self, OptionsError> {
        let file: OptionsToml = toml::from_str(text).map_err(Box::new)?;
        file.into_options().map_err(OptionsError::Value)
    }

    /// True if waypoints are planned on the map storey.
    pub(crate) fn wants_storey(&self, map_storey: u32) -> bool {
        self.storeys.is_empty() || self.storeys.contains(&map_storey)
    }

    /// Names by which a space can be selected: GlobalId, name, long name, and both names as outputs write them.
    pub(crate) fn space_names(site: &Site<'_>, space: usize) -> Vec<String> {
        let record = &site.spaces[space];
        let [id, name, long_name] = [record.global_id, record.name, record.long_name].map(|t| site.text(t).to_owned());
        let both = if name.is_empty() || long_name.is_empty() { String::new() } else { format!("{name} {long_name}") };
        [id, name, long_name, both].into_iter().filter(|text| !text.is_empty()).collect()
    }

    /// True if the space is selected.
    pub(crate) fn wants_space(&self, site: &Site<'_>, space: usize) -> bool {
        if self.spaces.is_empty() {
            return true;
        }
        let names = Self::space_names(site, space);
        self.spaces.iter().any(|p| names.iter().any(|name| WildMatch::new(p).matches(name)))
    }

    /// True if the robot can take the lift.
    pub(crate) fn takes_lift(&self, site: &Site<'_>, element: usize) -> bool {
        let record = &site.elements[element];
        let texts = [record.global_id, record.name].map(|t| site.text(t));
        self.lifts.iter().any(|p| texts.iter().any(|t| WildMatch::new(p).matches(t)))
    }
}

impl OptionsToml {
    fn into_options(self) -> Result<MissionPlanOptions, String> {
        let defaults = MissionPlanOptions::default();
        let (s, d) = (&self.sensor, defaults.sensor);
        let sensor = ScanSensor {
            range_m: within("range_m", s.range_m, d.range_m, 0.1, 200.0)?,
            min_range_m: within("min_range_m", s.min_range_m, d.min_range_m, 0.0, 100.0)?,
            max_incidence_rad: within("max_incidence_rad", s.max_incidence_rad, d.max_incidence_rad, 0.01, FRAC_PI_2)?,
            field_of_view_rad: within("field_of_view_rad", s.field_of_view_rad, d.field_of_view_rad, 0.1, TAU)?,
            min_elevation_rad: within("min_elevation_rad", s.min_elevation_rad, d.min_elevation_rad, -FRAC_PI_2, 0.0)?,
            max_elevation_rad: within("max_elevation_rad", s.max_elevation_rad, d.max_elevation_rad, 0.0, FRAC_PI_2)?,
        };
        if sensor.min_range_m >= sensor.range_m {
            return Err(format!("min_range_m {} is not below range_m {}", sensor.min_range_m, sensor.range_m));
        }
        let kinds = self.waypoints.as_deref().map_or(Ok(defaults.kinds.clone()), kinds_of)?;
        let quality = self.scan.quality.unwrap_or(1);
        if quality > 1000 {
            return Err(format!("quality is {quality}, it must be from 0 to 1000"));
        }
        let changed_since = self
            .scan
            .changed_since
            .as_deref()
            .map(|text| text.parse::<frames::PlanTime>().map_err(|e| unusable_date(text, &e)));
        let start = self.tour.start;
        if start.is_some_and(|s| !s.x_m.is_finite() || !s.y_m.is_finite()) {
            return Err("start is no place".to_owned());
        }
        let minutes = self.scan.minutes.map(|minutes| within("minutes", Some(minutes), 0.0, 0.0, 1e6));
        let drive = self.tour.drive()?;
        // A budget is used up, unless a share is written beside it.
        let usual = if self.scan.scans.is_some() || minutes.is_some() {
            MissionPlanOptions { coverage: 1.0, min_gain_m: 0.0, ..defaults.clone() }
        } else {
            defaults.clone()
        };
        Ok(MissionPlanOptions {
            kinds,
            spaces: self.spaces,
            storeys: defaults.storeys,
            changed_since_s: changed_since.transpose()?.map(|t| t.civil_seconds()),
            flies: self.flies,
            flight: self.flight.map(FlightToml::into_options).transpose()?,
            sensor,
            coverage: within("coverage", self.scan.coverage, usual.coverage, 0.0, 1.0)?,
            space_coverage: within("space_coverage", self.scan.space_coverage, defaults.space_coverage, 0.0, 1.0)?,
            min_gain_m: within("min_gain_m", self.scan.min_gain_m, usual.min_gain_m, 0.0, 100.0)?,
            scans_max: self.scan.scans,
            minutes_max: minutes.transpose()?,
            overlap: within("overlap", self.scan.overlap, defaults.overlap, 0.0, 0.9)?,
            separation_m: within("separation_m", self.scan.separation_m, defaults.separation_m, 0.0, 10.0)?,
            search_steps: quality * STEPS_PER_QUALITY,
            tour_kicks: quality * KICKS_PER_QUALITY,
            spacing_m: within("spacing_m", self.scan.spacing_m, defaults.spacing_m, 0.05, 10.0)?,
            classes: self.scan.classes.as_deref().map_or(Ok(defaults.classes), class_bits)?,
            mesh_check: self.scan.mesh_check,
            start,
            closed_tours: self.tour.closed,
            lifts: self.tour.lifts,
            drive,
            scan_s: within("scan_s", self.tour.scan_s, defaults.scan_s, 0.0, 86_400.0)?,
        })
    }
}

/// Kinds of waypoints by their names.
fn kinds_of(names: &[String]) -> Result<BTreeSet<WaypointKind>, String> {
    let kind = |name: &String| {
        WaypointKind::from_name(name).ok_or_else(|| {
            let known = WaypointKind::ALL.map(|kind| format!("{:?}", kind.name())).join(" and ");
            format!("waypoints has {name:?}, it may hold {known}")
        })
    };
    names.iter().map(kind).collect()
}

impl TourToml {
    fn drive(&self) -> Result<DriveModel, String> {
        let d = DriveModel::DEFAULT;
        let cost = match &self.cost {
            None => d.cost.get(),
            Some(name) => WayCost::ALL
                .into_iter()
                .find(|cost| cost.name() == name)
                .ok_or_else(|| format!("cost is {name:?}, it may be \"length\", \"time\" or \"energy\""))?,
        };
        if cost == WayCost::Energy && self.mass_kg.is_none() {
            return Err("cost is \"energy\", which needs mass_kg".to_owned());
        }
        Ok(DriveModel {
            speed_m_s: within("speed_m_s", self.speed_m_s, d.speed_m_s, 0.01, 10.0)?,
            climb_s_per_m: within("climb_s_per_m", self.climb_s_per_m, d.climb_s_per_m, 0.0, 100.0)?,
            mass_kg: self
                .mass_kg
                .map_or(Ok(d.mass_kg), |mass_kg| within("mass_kg", Some(mass_kg), 0.0, 0.1, 10_000.0))?,
            rolling_resistance: within(
                "rolling_resistance",
                self.rolling_resistance,
                d.rolling_resistance,
                0.001,
                1.0,
            )?,
            drive_efficiency: within("drive_efficiency", self.drive_efficiency, d.drive_efficiency, 0.01, 1.0)?,
            idle_w: within("idle_w", self.idle_w, d.idle_w, 0.0, 10_000.0)?,
            cost: cost.into(),
            reserved: 0,
        })
    }
}

/// The value of a key, or the usual one.
fn within(key: &str, value: Option<f64>, usual: f64, lo: f64, hi: f64) -> Result<f64, String> {
    match value.unwrap_or(usual) {
        v if (lo..=hi).contains(&v) => Ok(v),
        v => Err(format!("{key} is {v}, it must be from {lo} to {hi}")),
    }
}

fn unusable_date(text: &str, error: &PlanTimeError) -> String {
    match error {
        // The time zone of the site is in the schedule rules, which are not read here.
        PlanTimeError::NoSiteZone { .. } => {
            format!("changed_since is {text:?}, which carries a time zone: write the time at the site without one")
        }
        PlanTimeError::Unreadable { .. } => format!("changed_since is {text:?}: {error}"),
    }
}

fn class_bits(names: &[String]) -> Result<u32, String> {
    let all = || Class::ALL.into_iter().filter(|class| *class != Class::None);
    let bit = |name: &String| {
        let is_meant = |class: &Class| name == "all" || class.name() == name;
        let bits = all().filter(is_meant).fold(0, |bits, class| bits | 1 << class.id());
        let names = || all().map(Class::name).collect::<Vec<_>>().join(", ");
        if bits == 0 { Err(format!("classes has {name:?}, it may hold \"all\" or {}", names())) } else { Ok(bits) }
    };
    names.iter().try_fold(0, |bits, name| Ok(bits | bit(name)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_file_says_what_is_usual() {
        let shipped = include_str!("../../../../config/waypoints.toml");
        assert_eq!(MissionPlanOptions::parse(shipped).unwrap(), MissionPlanOptions::default());
        assert_eq!(MissionPlanOptions::parse("").unwrap(), MissionPlanOptions::default());
    }

    #[test]
    fn what_cannot_be_planned_is_refused_by_name() {
        for (text, word) in [
            ("[sensor]\nrange_m = 0.0", "range_m"),
            ("[sensor]\nmin_range_m = 9.0", "min_range_m"),
            ("[scan]\ncoverage = 1.5", "coverage"),
            ("[scan]\nclasses = [\"walls\"]", "curtain_wall"),
            ("[scan]\nminutes = -1.0", "minutes"),
            ("[scan]\nscans = -1", "scans"),
            ("[scan]\nchanged_since = \"soon\"", "changed_since"),
            ("[scan]\nchanged_since = \"2024-04-15T08:00:00+02:00\"", "without one"),
            ("waypoints = [\"center\"]", "center"),
            ("[tour]\nstart = { storey = 0, x_m = nan, y_m = 0.0 }", "start"),
            ("[tour]\nclose = true", "close"),
            ("[tour]\ncost = \"distance\"", "distance"),
            ("[tour]\ncost = \"energy\"", "mass_kg"),
            ("[tour]\nmass_kg = 0.0", "mass_kg"),
            ("[tour]\nclimb_s_per_m = -1.0", "climb_s_per_m"),
            ("[tour]\nrolling_resistance = 0.0", "rolling_resistance"),
            ("[flight]\nheights_m = [0.5]\nclearance_m = 0.8", "heights_m"),
            ("[flight]\nheight_m = [0.5]", "height_m"),
        ] {
            let error = MissionPlanOptions::parse(text).unwrap_err();
            let text =
                format!("{error} {}", std::error::Error::source(&error).map_or(String::new(), |s| s.to_string()));
            assert!(text.contains(word), "{text}");
        }
        let only = MissionPlanOptions::parse("[scan]\nclasses = [\"wall\", \"column\"]").unwrap();
        assert_eq!(only.classes, 0b110);
    }

    #[test]
    fn structure_is_scanned_unless_all_classes_are_named() {
        let classes = |text: &str| MissionPlanOptions::parse(text).unwrap().classes;
        let has = |classes: u32, class: Class| classes & 1 << class.id() != 0;
        assert!(has(classes(""), Class::Wall) && !has(classes(""), Class::Furniture));
        let all = classes("[scan]\nclasses = [\"all\"]");
        assert!(Class::ALL.into_iter().filter(|class| *class != Class::None).all(|class| has(all, class)));
    }

    #[test]
    fn a_budget_is_used_up_unless_a_share_is_written_beside_it() {
        let options = |text: &str| MissionPlanOptions::parse(&format!("[scan]\n{text}")).unwrap();
        let scans = options("scans = 20");
        assert_eq!((scans.scans_max, scans.minutes_max, scans.coverage, scans.min_gain_m), (Some(20), None, 1.0, 0.0));
        let minutes = options("minutes = 45\ncoverage = 0.9\nmin_gain_m = 0.2");
        assert_eq!((minutes.minutes_max, minutes.coverage, minutes.min_gain_m), (Some(45.0), 0.9, 0.2));
        assert!(scans.has_budget() && minutes.has_budget() && !options("coverage = 0.9").has_budget());
    }
}
