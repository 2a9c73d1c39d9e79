//! Reads robot profiles from TOML.

use crate::config_file::{ConfigFileError, read_parsed};
use crate::file_text::FileText;
use crate::setting::Configured;
use messages::{DoorCapability, Grids, RobotProfile, SafetyKind, SafetyRules, SafetySubject};
use serde::Deserialize;
use std::path::Path;

/// What a profile configures, for errors.
const WHAT: &str = "robot profile";

/// A robot: what the stages use, and what is passed on to files.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Name of the profile.
    pub name: String,
    /// Measures and abilities.
    pub profile: RobotProfile,
    /// Outline in the robot's frame, in metres; may be empty.
    pub footprint_m: Vec<[f64; 2]>,
    /// Distances that it keeps from elements, and its speed near them; none unless the profile has some.
    pub safety: SafetyRules,
}

/// A text that is no robot profile.
#[derive(Debug, thiserror::Error)]
pub enum RobotTextError {
    /// Not TOML, an unknown key, or a value of the wrong type: with line and column.
    #[error(transparent)]
    Toml(#[from] Box<toml::de::Error>),
    /// A value that no robot has, and what it may be.
    #[error("{0}")]
    Value(String),
}

/// The file's keys; see `config/robots/default.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotToml {
    name: String,
    height_m: Option<f64>,
    clearance_above_m: Option<f64>,
    step_height_m: Option<f64>,
    radius_m: Option<f64>,
    footprint_m: Option<Vec<[f64; 2]>>,
    max_slope_rad: Option<f64>,
    max_cross_slope_rad: Option<f64>,
    climbs_stairs: Option<bool>,
    stair_cost: Option<u32>,
    opens: Option<Vec<String>>,
    door_margin_m: Option<f64>,
    edge_margin_m: Option<f64>,
    work_margin_m: Option<f64>,
    lidar_height_m: Option<f64>,
    lidar_range_m: Option<f64>,
    sensor_height_m: Option<f64>,
    #[serde(default)]
    safety: Vec<SafetyToml>,
}

/// An entry of `[[safety]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SafetyToml {
    near: String,
    material: Option<String>,
    class: Option<String>,
    distance_m: Option<f64>,
    speed_m_s: Option<f64>,
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            name: "default".to_owned(),
            profile: RobotProfile::DEFAULT,
            footprint_m: Vec::new(),
            safety: SafetyRules::default(),
        }
    }
}

impl Robot {
    /// The robot that an index of grids was drawn for: it has it whole.
    pub fn of_index(index: &Grids<'_>) -> Self {
        Self {
            name: index.robot_name.to_owned(),
            profile: index.head.robot,
            footprint_m: index.robot_footprint_m.to_vec(),
            safety: SafetyRules::of(index),
        }
    }

    /// Reads a profile.
    ///
    /// # Errors
    /// A file that cannot be read, is no TOML of these keys, or has a value that no robot has.
    pub fn read(path: &Path) -> Result<Self, ConfigFileError> {
        read_parsed(WHAT, path, Self::parse)
    }

    /// What `robot.profile` of `site.toml` says.
    pub fn configured(path: Option<&Path>) -> Configured<Option<FileText>> {
        FileText::configured(WHAT, path, Self::parse)
    }

    /// The robot of a profile that was kept; without one, the default robot.
    ///
    /// # Errors
    /// Content that is none of this version's profiles.
    pub fn of(profile: Option<&FileText>) -> Result<Self, ConfigFileError> {
        profile.map_or_else(|| Ok(Self::default()), |file| file.parse(WHAT, Self::parse))
    }

    /// The robot that a text says.
    ///
    /// # Errors
    /// No TOML of these keys, or a value that no robot has.
    pub fn parse(text: &str) -> Result<Self, RobotTextError> {
        let parsed: RobotToml = toml::from_str(text).map_err(Box::new)?;
        parsed.into_robot().map_err(RobotTextError::Value)
    }
}

impl RobotToml {
    fn into_robot(self) -> Result<Robot, String> {
        let usual = RobotProfile::DEFAULT;
        let profile = RobotProfile {
            height_m: self.height_m.unwrap_or(usual.height_m),
            clearance_above_m: self.clearance_above_m.unwrap_or(usual.clearance_above_m),
            step_height_m: self.step_height_m.unwrap_or(usual.step_height_m),
            radius_m: self.radius_m.unwrap_or(usual.radius_m),
            max_slope_rad: self.max_slope_rad.unwrap_or(usual.max_slope_rad),
            max_cross_slope_rad: self.max_cross_slope_rad.map_or(Ok(0.0), given_angle)?,
            door_margin_m: self.door_margin_m.unwrap_or(usual.door_margin_m),
            edge_margin_m: self.edge_margin_m.unwrap_or(usual.edge_margin_m),
            work_margin_m: self.work_margin_m.unwrap_or(usual.work_margin_m),
            lidar_height_m: self.lidar_height_m.unwrap_or(usual.lidar_height_m),
            lidar_range_m: self.lidar_range_m.unwrap_or(usual.lidar_range_m),
            sensor_height_m: self.sensor_height_m.unwrap_or(usual.sensor_height_m),
            opens: self.opens.as_deref().map_or(Ok(usual.opens), opens_bits)?,
            climbs_stairs: u32::from(self.climbs_stairs.unwrap_or(usual.climbs_stairs == 1)),
            stair_cost: self.stair_cost.unwrap_or(usual.stair_cost),
            reserved: 0,
        };
        profile.check().map_err(|limit| limit.to_string())?;
        let footprint_m = self.footprint_m.unwrap_or_default();
        check_footprint(&footprint_m, profile.radius_m)?;
        if self.name.trim().is_empty() {
            return Err("name is empty".to_owned());
        }
        let safety = safety_rules(&self.safety)?;
        if !profile.drives_on_stairs() && safety.records().iter().any(|rule| rule.kind == SafetyKind::Stair) {
            return Err("a safety entry near \"stair\" is about stairs on which the robot drives: it needs stair_cost"
                .to_owned());
        }
        Ok(Robot { name: self.name, profile, footprint_m, safety })
    }
}

/// A cross slope that is given: 0 says in a record that it is not.
fn given_angle(max_cross_slope_rad: f64) -> Result<f64, String> {
    if max_cross_slope_rad > 0.0 {
        Ok(max_cross_slope_rad)
    } else {
        Err(format!("max_cross_slope_rad is {max_cross_slope_rad}, it must be above 0"))
    }
}

/// The rules of the entries of `[[safety]]`; errors name the entry by its number, from 1, and what it is near.
fn safety_rules(entries: &[SafetyToml]) -> Result<SafetyRules, String> {
    let mut rules = SafetyRules::default();
    for (number, entry) in (1..).zip(entries) {
        let named = |what: String| format!("safety entry {number} (near {:?}): {what}", entry.near);
        let subject = entry.subject().map_err(named)?;
        rules.add(subject, entry.distance_m, entry.speed_m_s).map_err(|why| named(why.to_string()))?;
    }
    Ok(rules)
}

impl SafetyToml {
    fn subject(&self) -> Result<SafetySubject<'_>, String> {
        let kind = SafetyKind::ALL.into_iter().find(|kind| kind.name() == self.near);
        let kind = kind.ok_or_else(|| {
            let names = SafetyKind::ALL.map(SafetyKind::name).join(", ");
            format!("near may be {names}")
        })?;
        if self.material.is_some() && kind != SafetyKind::Material {
            return Err("material belongs to near = \"material\"".to_owned());
        }
        if self.class.is_some() && kind != SafetyKind::Class {
            return Err("class belongs to near = \"class\"".to_owned());
        }
        Ok(match kind {
            SafetyKind::Glass => SafetySubject::Glass,
            SafetyKind::StairEdge => SafetySubject::StairEdge,
            SafetyKind::DoorSwing => SafetySubject::DoorSwing,
            SafetyKind::Work => SafetySubject::Work,
            SafetyKind::Material => SafetySubject::Material(self.material.as_deref().ok_or("material is missing")?),
            SafetyKind::Class => class_named(self.class.as_deref().ok_or("class is missing")?)?,
            SafetyKind::Stair => SafetySubject::Stair,
        })
    }
}

/// The class with a name as on maps.
fn class_named(name: &str) -> Result<SafetySubject<'_>, String> {
    let names = || SafetySubject::class_names().collect::<Vec<_>>().join(", ");
    SafetySubject::of_class(name).ok_or_else(|| format!("class is {name:?}, it may be {}", names()))
}

/// An outline has an area, and the circle of the radius holds it: planners may use either.
fn check_footprint(footprint_m: &[[f64; 2]], radius_m: f64) -> Result<(), String> {
    if (1..3).contains(&footprint_m.len()) {
        return Err("footprint_m has fewer than three corners".to_owned());
    }
    let beyond = footprint_m
        .iter()
        .find(|corner| corner[0].is_nan() || corner[1].is_nan() || corner[0].hypot(corner[1]) > radius_m);
    beyond.map_or(Ok(()), |[x, y]| Err(format!("footprint_m has the corner [{x}, {y}] beyond radius_m {radius_m}")))
}

fn opens_bits(words: &[String]) -> Result<u32, String> {
    if words == ["none"] {
        return Ok(0);
    }
    let bit = |word: &String| {
        let known = DoorCapability::ALL.into_iter().find(|o| o.name() == word);
        known.map(|o| o as u32).ok_or_else(|| {
            let names = DoorCapability::ALL.map(DoorCapability::name).join(", ");
            format!("opens has {word:?}, it may hold {names}, or \"none\" alone")
        })
    };
    words.iter().try_fold(0, |bits, word| Ok(bits | bit(word)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Robot, String> {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("robot.toml");
        std::fs::write(&path, text).unwrap();
        Robot::read(&path).map_err(|e| crate::chain(&e))
    }

    #[test]
    fn shipped_profiles_are_read_and_the_default_is_the_default() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/robots");
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let robot = Robot::read(&path).unwrap();
            assert_eq!(Some(robot.name.as_str()), path.file_stem().and_then(|s| s.to_str()));
            names.push(robot.name);
        }
        names.sort();
        assert_eq!(names, ["default", "legged", "wheeled-low"]);
        assert_eq!(Robot::read(&folder.join("default.toml")).unwrap(), Robot::default());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line() {
        let error = parse("name = \"x\"\nheigth_m = 1.0\n").unwrap_err();
        assert!(error.contains("heigth_m") && error.contains("line 2"), "{error}");
    }

    #[test]
    fn values_that_no_robot_has_are_refused() {
        for (text, word) in [
            ("radius_m = -1.0", "radius_m"),
            ("height_m = nan", "height_m"),
            ("opens = [\"swing\", \"magic\"]", "magic"),
            ("height_m = 0.1\nstep_height_m = 0.2", "step_height_m"),
            ("footprint_m = [[0.2, 0.2], [-0.2, 0.2], [0.0, -0.4]]", "beyond radius_m 0.3"),
            ("footprint_m = [[0.2, 0.2]]", "three corners"),
        ] {
            let error = parse(&format!("name = \"x\"\n{text}")).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
        assert_eq!(parse("name = \"x\"\nopens = [\"none\"]").unwrap().profile.opens, 0);
    }

    #[test]
    fn a_robot_without_safety_entries_has_no_rules_and_one_with_them_has_them_in_their_order() {
        assert!(parse("name = \"x\"").unwrap().safety.is_empty());
        let robot = parse(
            "name = \"x\"\n[[safety]]\nnear = \"glass\"\ndistance_m = 0.6\nspeed_m_s = 0.4\n\
             [[safety]]\nnear = \"material\"\nmaterial = \"Marble\"\nspeed_m_s = 0.2\n\
             [[safety]]\nnear = \"class\"\nclass = \"curtain_wall\"\ndistance_m = 1.0\n",
        )
        .unwrap();
        let rules = robot.safety.records();
        let found: Vec<_> =
            rules.iter().map(|rule| (robot.safety.subject(rule), rule.distance_m, rule.speed_m_s)).collect();
        let expected = [
            (SafetySubject::Glass, 0.6, 0.4),
            (SafetySubject::Material("Marble"), 0.0, 0.2),
            (SafetySubject::of_class("curtain_wall").unwrap(), 1.0, 0.0),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_safety_entry_that_cannot_be_is_refused_by_its_number_and_name() {
        let first = "name = \"x\"\n[[safety]]\nnear = \"work\"\ndistance_m = 2.0\n[[safety]]\n";
        for (entry, expected) in [
            ("near = \"glas\"\ndistance_m = 1.0", "safety entry 2 (near \"glas\"): near may be glass, stair_edge"),
            ("near = \"glass\"\ndistance_m = -1.0", "safety entry 2 (near \"glass\"): distance_m is -1"),
            ("near = \"glass\"\ndistance_m = 21.0", "distance_m is 21, it must be from 0 to 20"),
            ("near = \"glass\"\nspeed_m_s = nan", "speed_m_s is NaN"),
            ("near = \"glass\"", "neither distance_m nor speed_m_s"),
            ("near = \"material\"\ndistance_m = 1.0", "safety entry 2 (near \"material\"): material is missing"),
            ("near = \"glass\"\nmaterial = \"marble\"\ndistance_m = 1.0", "material belongs to near"),
            ("near = \"class\"\nclass = \"sofa\"\ndistance_m = 1.0", "class is \"sofa\", it may be wall, column"),
            ("near = \"glass\"\ndistance = 1.0", "unknown field `distance`"),
        ] {
            let error = parse(&format!("{first}{entry}\n")).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
