//! Rules of a robot about the distance that it keeps and the speed at which it drives near elements, by what they mean.

use crate::archive::{ArchiveError, Text};
use crate::robot::RobotProfile;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use grid::Class;

/// What a rule is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum SafetyKind {
    /// Elements that let light through.
    Glass = 1,
    /// Edges of floor at which a stair leads down.
    StairEdge = 2,
    /// The floor over which the leaf of a door swings.
    DoorSwing = 3,
    /// Elements that are being built or removed.
    Work = 4,
    /// Elements of a material.
    Material = 5,
    /// Elements of a class.
    Class = 6,
    /// Stairs on which the robot drives.
    Stair = 7,
}

impl SafetyKind {
    /// All kinds.
    pub const ALL: [Self; 7] =
        [Self::Glass, Self::StairEdge, Self::DoorSwing, Self::Work, Self::Material, Self::Class, Self::Stair];

    /// Its name in robot profiles and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glass => "glass",
            Self::StairEdge => "stair_edge",
            Self::DoorSwing => "door_swing",
            Self::Work => "work",
            Self::Material => "material",
            Self::Class => "class",
            Self::Stair => "stair",
        }
    }
}

/// A distance to keep from elements, a limit of speed within it, or both.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SafetyRuleRecord {
    /// What it is about.
    pub kind: Tag<SafetyKind>,
    /// Of a rule about a class, [`Class`] as a number; else 0.
    pub class: u32,
    /// Of a rule about a material, the words of its name in the section of materials; else empty.
    pub material: Text,
    /// Distance to keep from the elements, metres; 0 where the rule is about the cells of the elements alone.
    pub distance_m: f64,
    /// Limit of speed within the distance; 0 if there is none.
    pub speed_m_s: f64,
}
const _: () = assert!(size_of::<SafetyRuleRecord>() == 32);

/// What a rule is about, with its words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SafetySubject<'a> {
    /// Elements that let light through.
    Glass,
    /// Edges of floor at which a stair leads down.
    StairEdge,
    /// The floor over which the leaf of a door swings.
    DoorSwing,
    /// Elements that are being built or removed.
    Work,
    /// Elements with a material whose name contains these words, in any case.
    Material(&'a str),
    /// Elements of a class.
    Class(Class),
    /// Stairs on which the robot drives.
    Stair,
}

impl SafetySubject<'_> {
    /// Of the class with this name; `None` if there is none.
    pub fn of_class(name: &str) -> Option<Self> {
        Class::ALL[1..].iter().copied().find(|class| class.name() == name).map(Self::Class)
    }

    /// The names of classes.
    pub fn class_names() -> impl Iterator<Item = &'static str> {
        Class::ALL[1..].iter().map(|class| class.name())
    }
}

/// A rule that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SafetyRuleError {
    /// A number out of its limits, or none.
    #[error("{key} is {value}, it must be from {} to {}", limits[0], limits[1])]
    Outside {
        /// Its key in a robot profile.
        key: &'static str,
        /// As given.
        value: f64,
        /// The smallest and the largest value.
        limits: [f64; 2],
    },
    /// It says nothing.
    #[error("it has neither distance_m nor speed_m_s")]
    Nothing,
    /// The edge of a floor is no cell on which a robot drives.
    #[error("a rule near stair_edge needs distance_m")]
    NoDistance,
    /// A material without a name.
    #[error("material is empty")]
    NoMaterial,
    /// More rules than a robot may have.
    #[error("there are more than {} entries", SafetyRules::MAX_RULES)]
    TooMany,
}

/// The rules of a robot; none unless its profile has some.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SafetyRules {
    records: Vec<SafetyRuleRecord>,
    materials: String,
}

impl SafetyRules {
    /// Most rules of a robot.
    pub const MAX_RULES: usize = 64;
    /// Limits of a distance, metres.
    pub const DISTANCE_M: [f64; 2] = [0.0, 20.0];
    /// Limits of a speed, metres per second.
    pub const SPEED_M_S: [f64; 2] = [0.05, 5.0];

    /// Adds a rule: a distance to keep, a limit of speed within it, or both.
    ///
    /// # Errors
    /// A number out of its limits, a rule that says nothing, or one more than [`Self::MAX_RULES`].
    pub fn add(
        &mut self,
        subject: SafetySubject<'_>,
        distance_m: Option<f64>,
        speed_m_s: Option<f64>,
    ) -> Result<(), SafetyRuleError> {
        if self.records.len() == Self::MAX_RULES {
            return Err(SafetyRuleError::TooMany);
        }
        if distance_m.is_none() && speed_m_s.is_none() {
            return Err(SafetyRuleError::Nothing);
        }
        let (kind, class, words) = match subject {
            SafetySubject::Glass => (SafetyKind::Glass, Class::None, ""),
            SafetySubject::StairEdge => (SafetyKind::StairEdge, Class::None, ""),
            SafetySubject::DoorSwing => (SafetyKind::DoorSwing, Class::None, ""),
            SafetySubject::Work => (SafetyKind::Work, Class::None, ""),
            SafetySubject::Material(words) if words.trim().is_empty() => return Err(SafetyRuleError::NoMaterial),
            SafetySubject::Material(words) => (SafetyKind::Material, Class::None, words.trim()),
            SafetySubject::Class(class) => (SafetyKind::Class, class, ""),
            SafetySubject::Stair => (SafetyKind::Stair, Class::None, ""),
        };
        let material = Text { offset: self.materials.len() as u32, length: words.len() as u32 };
        let record = SafetyRuleRecord {
            kind: kind.into(),
            class: u32::from(class.id()),
            material,
            distance_m: distance_m.unwrap_or(0.0),
            speed_m_s: speed_m_s.unwrap_or(0.0),
        };
        check(&record, speed_m_s.is_some())?;
        self.materials.push_str(words);
        self.records.push(record);
        Ok(())
    }

    /// The rules of an archive that was checked.
    pub(crate) fn read(records: &[SafetyRuleRecord], materials: &[u8]) -> Self {
        Self { records: records.to_vec(), materials: String::from_utf8_lossy(materials).into_owned() }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// The rules, in the order of the profile.
    pub fn records(&self) -> &[SafetyRuleRecord] {
        &self.records
    }

    /// The words of materials, one after the other.
    pub fn materials(&self) -> &[u8] {
        self.materials.as_bytes()
    }

    /// What a rule is about.
    pub fn subject(&self, rule: &SafetyRuleRecord) -> SafetySubject<'_> {
        match rule.kind.get() {
            SafetyKind::Glass => SafetySubject::Glass,
            SafetyKind::StairEdge => SafetySubject::StairEdge,
            SafetyKind::DoorSwing => SafetySubject::DoorSwing,
            SafetyKind::Work => SafetySubject::Work,
            SafetyKind::Material => {
                let Text { offset, length } = rule.material;
                SafetySubject::Material(&self.materials[offset as usize..(offset + length) as usize])
            }
            SafetyKind::Class => SafetySubject::Class(Class::ALL[rule.class as usize]),
            SafetyKind::Stair => SafetySubject::Stair,
        }
    }

    /// These rules, and for a robot that drives on stairs one that says nothing but that they cost something: what layers are made
    /// from.
    pub fn with_costs_of(mut self, robot: &RobotProfile) -> Self {
        if robot.drives_on_stairs() {
            let (material, [distance_m, speed_m_s]) = (Text::default(), [0.0; 2]);
            let kind = SafetyKind::Stair.into();
            self.records.push(SafetyRuleRecord { kind, class: 0, material, distance_m, speed_m_s });
        }
        self
    }
}

fn check(rule: &SafetyRuleRecord, has_speed: bool) -> Result<(), SafetyRuleError> {
    let within = |key, value: f64, limits: [f64; 2]| {
        let fits = limits[0] <= value && value <= limits[1];
        if fits { Ok(()) } else { Err(SafetyRuleError::Outside { key, value, limits }) }
    };
    within("distance_m", rule.distance_m, SafetyRules::DISTANCE_M)?;
    if has_speed {
        within("speed_m_s", rule.speed_m_s, SafetyRules::SPEED_M_S)?;
    }
    if rule.kind == SafetyKind::StairEdge && rule.distance_m == 0.0 {
        return Err(SafetyRuleError::NoDistance);
    }
    Ok(())
}

/// Checks the rules of an archive.
pub(crate) fn check_archive(rules: &[SafetyRuleRecord], materials: &[u8]) -> Result<(), ArchiveError> {
    let wrong = Err(ArchiveError::Index { what: "a safety rule" });
    let Ok(materials) = std::str::from_utf8(materials) else { return wrong };
    let is_possible = |rule: &SafetyRuleRecord| {
        let Text { offset, length } = rule.material;
        let words = offset.checked_add(length).and_then(|end| materials.get(offset as usize..end as usize));
        let is_material = rule.kind == SafetyKind::Material;
        rule.kind.is_known()
            && (rule.class as usize) < Class::ALL.len()
            && words.is_some_and(|words| words.is_empty() != is_material)
            && check(rule, rule.speed_m_s != 0.0).is_ok()
    };
    if rules.len() <= SafetyRules::MAX_RULES && rules.iter().all(is_possible) { Ok(()) } else { wrong }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_says_something_that_can_be() {
        let add = |subject, distance_m, speed_m_s| {
            let mut rules = SafetyRules::default();
            rules.add(subject, distance_m, speed_m_s).map(|()| rules).map_err(|why| why.to_string())
        };
        for (subject, distance_m, speed_m_s, expected) in [
            (SafetySubject::Glass, None, None, "it has neither distance_m nor speed_m_s"),
            (SafetySubject::Glass, Some(-0.5), None, "distance_m is -0.5, it must be from 0 to 20"),
            (SafetySubject::Work, Some(f64::NAN), None, "distance_m is NaN, it must be from 0 to 20"),
            (SafetySubject::Work, Some(f64::INFINITY), None, "distance_m is inf, it must be from 0 to 20"),
            (SafetySubject::DoorSwing, None, Some(0.0), "speed_m_s is 0, it must be from 0.05 to 5"),
            (SafetySubject::StairEdge, None, Some(0.3), "a rule near stair_edge needs distance_m"),
            (SafetySubject::Material("  "), Some(1.0), None, "material is empty"),
        ] {
            assert_eq!(add(subject, distance_m, speed_m_s), Err(expected.to_owned()));
        }
        let mut rules = add(SafetySubject::Material("marble"), Some(0.5), None).unwrap();
        rules.add(SafetySubject::Material("Glass mosaic"), None, Some(0.2)).unwrap();
        rules.add(SafetySubject::Class(Class::Furniture), Some(0.4), Some(0.5)).unwrap();
        let subjects: Vec<_> = rules.records().iter().map(|rule| rules.subject(rule)).collect();
        let expected = [
            SafetySubject::Material("marble"),
            SafetySubject::Material("Glass mosaic"),
            SafetySubject::Class(Class::Furniture),
        ];
        assert_eq!(subjects, expected);
    }

    #[test]
    fn rules_of_an_archive_are_checked() {
        let mut rules = SafetyRules::default();
        rules.add(SafetySubject::Material("marble"), Some(0.5), Some(0.3)).unwrap();
        let good = rules.records()[0];
        assert!(check_archive(&[good], b"marble").is_ok());
        assert!(check_archive(&[good; SafetyRules::MAX_RULES + 1], b"marble").is_err());
        for wrong in [
            SafetyRuleRecord { distance_m: f64::NAN, ..good },
            SafetyRuleRecord { speed_m_s: -1.0, ..good },
            SafetyRuleRecord { class: 14, ..good },
            SafetyRuleRecord { kind: Tag::numbered(9), ..good },
            SafetyRuleRecord { material: Text { offset: u32::MAX, length: 6 }, ..good },
            SafetyRuleRecord { material: Text::default(), ..good },
        ] {
            assert!(check_archive(&[wrong], b"marble").is_err(), "{wrong:?}");
        }
        assert!(check_archive(&[good], b"\xff\xff\xff\xff\xff\xff").is_err());
    }
}
