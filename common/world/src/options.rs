//! Options of simulation worlds from TOML; `config/world.toml` documents every key.

use convex::PieceOptions;
use serde::Deserialize;

/// Options of a world.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WorldOptions {
    /// Mode of the doors.
    pub doors: DoorMode,
    /// Blocked spaces are closed by thin walls.
    pub barriers: bool,
    /// Source of colours.
    pub materials: Materials,
    /// Tolerance of simplifying visual meshes, in metres; 0 for none.
    pub lod_m: f64,
    /// Waypoints are shown.
    pub markers: bool,
    /// The world is written as USD, too.
    pub usd: bool,
    /// Limits of convex pieces.
    pub pieces: Pieces,
    /// Sizes and physical properties of doors.
    pub door: DoorOptions,
}

/// Mode of the doors.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DoorMode {
    /// They move on their joints.
    #[default]
    Movable,
    /// They are fixed open.
    Open,
    /// They are fixed closed.
    Closed,
    /// They are left out.
    Passable,
}

impl DoorMode {
    /// All modes.
    pub const ALL: [Self; 4] = [Self::Movable, Self::Open, Self::Closed, Self::Passable];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Movable => "movable",
            Self::Open => "open",
            Self::Closed => "closed",
            Self::Passable => "passable",
        }
    }
}

/// Source of colours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Materials {
    /// From the class of an element.
    #[default]
    Semantic,
    /// From the model; from the class where it gives none.
    Model,
}

impl Materials {
    /// All sources.
    pub const ALL: [Self; 2] = [Self::Semantic, Self::Model];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Semantic => "semantic",
            Self::Model => "model",
        }
    }
}

/// Limits of convex pieces.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pieces {
    /// A part that is not convex may become its hull if that lies no farther from it than this.
    pub tolerance_m: f64,
    /// A decomposition that lies farther off than this becomes thin plates along the surface.
    pub worst_m: f64,
    /// Exact pieces of a part before an approximation is tried.
    pub exact_max: usize,
    /// Pieces of an element before neighbours become one.
    pub element_max: usize,
    /// Maximum deviation of such a hull; eight times as much for foliage.
    pub joined_m: f64,
}

/// Sizes and physical properties of doors.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DoorOptions {
    /// Operation type of doors that have none, or `fixed`.
    pub unknown: String,
    /// Thickness of leaves where the model says nothing.
    pub thickness_m: f64,
    /// Density of leaves.
    pub density_kg_m3: f64,
    /// Gap between a leaf and the floor.
    pub floor_gap_m: f64,
    /// Gap between a leaf and the sides of its opening.
    pub side_gap_m: f64,
    /// Damping of joints: N m s/rad, N s/m.
    pub damping: f64,
    /// Friction of joints: N m, N.
    pub friction: f64,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            doors: DoorMode::Movable,
            barriers: false,
            materials: Materials::Semantic,
            lod_m: 0.0,
            markers: false,
            usd: false,
            pieces: Pieces::default(),
            door: DoorOptions::default(),
        }
    }
}

impl Default for Pieces {
    fn default() -> Self {
        Self { tolerance_m: 0.02, worst_m: 0.1, exact_max: 64, element_max: 64, joined_m: 0.05 }
    }
}

impl Default for DoorOptions {
    fn default() -> Self {
        Self {
            unknown: "SINGLE_SWING_LEFT".to_owned(),
            thickness_m: 0.04,
            density_kg_m3: 500.0,
            floor_gap_m: 0.01,
            side_gap_m: 0.01,
            damping: 1.0,
            friction: 0.1,
        }
    }
}

/// Errors of world options.
#[derive(Debug, thiserror::Error)]
pub enum WorldOptionsError {
    /// Not TOML, an unknown key, or a value of the wrong type: the source has line and column.
    #[error("it has other keys or values than options have")]
    Toml(#[from] Box<toml::de::Error>),
    /// A value out of range.
    #[error("{0}")]
    Value(String),
}

impl WorldOptions {
    /// Parses options from TOML.
    ///
    /// # Errors
    /// No TOML of these keys, or a value that no world can have.
    pub fn parse(text: &str) -> Result<Self, WorldOptionsError> {
        let options: Self = toml::from_str(text).map_err(Box::new)?;
        options.check().map_err(WorldOptionsError::Value)?;
        Ok(options)
    }

    /// Says what no world can have.
    ///
    /// # Errors
    /// A value out of range, in words.
    pub fn check(&self) -> Result<(), String> {
        let door = &self.door;
        let ranges = [
            ("lod_m", self.lod_m, 0.0, 1.0),
            ("pieces.tolerance_m", self.pieces.tolerance_m, 0.0, 1.0),
            ("pieces.worst_m", self.pieces.worst_m, 0.0, 10.0),
            ("pieces.joined_m", self.pieces.joined_m, 0.001, 1.0),
            ("door.thickness_m", door.thickness_m, 0.005, 0.5),
            ("door.density_kg_m3", door.density_kg_m3, 1.0, 20_000.0),
            ("door.floor_gap_m", door.floor_gap_m, 0.001, 0.2),
            ("door.side_gap_m", door.side_gap_m, 0.001, 0.1),
            ("door.damping", door.damping, 0.0, 1e4),
            ("door.friction", door.friction, 0.0, 1e4),
        ];
        for (key, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err(format!("{key} = {value} is not between {least} and {most}"));
            }
        }
        if door.unknown != "fixed" && messages::door_operations::leaves(&door.unknown, 0.5).is_none() {
            return Err(format!(
                "door.unknown = {:?} is neither an operation type that moves nor \"fixed\"",
                door.unknown
            ));
        }
        Ok(())
    }

    pub(crate) fn piece_options(&self) -> PieceOptions {
        PieceOptions {
            tolerance_m: self.pieces.tolerance_m,
            worst_m: self.pieces.worst_m,
            exact_max: self.pieces.exact_max,
            element_max: self.pieces.element_max,
            joined_m: self.pieces.joined_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_file_says_the_defaults() {
        let shipped = include_str!("../../../config/world.toml");
        assert_eq!(WorldOptions::parse(shipped).unwrap(), WorldOptions::default());
    }

    #[test]
    fn what_no_world_can_have_is_refused() {
        for (text, expected) in [
            ("lod_m = -1.0", "lod_m"),
            ("doors = \"ajar\"", "other keys"),
            ("[door]\nunknown = \"SWINGS\"", "SWINGS"),
            ("windows = 1", "other keys"),
        ] {
            let error = WorldOptions::parse(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
