//! Element classes of cells and their drawing priority.

use bytemuck::{CheckedBitPattern, NoUninit};

/// Class of an element: ids of `classes.png` and of the `class` layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, CheckedBitPattern, NoUninit)]
#[repr(u8)]
pub enum Class {
    /// Nothing.
    None = 0,
    /// Wall.
    Wall = 1,
    /// Column.
    Column = 2,
    /// Door.
    Door = 3,
    /// Window.
    Window = 4,
    /// Stair and its flights.
    Stair = 5,
    /// Ramp and its flights.
    Ramp = 6,
    /// Railing.
    Railing = 7,
    /// Furniture.
    Furniture = 8,
    /// Curtain wall with its plates and members.
    CurtainWall = 9,
    /// Slab and roof.
    Slab = 10,
    /// Beam.
    Beam = 11,
    /// Mechanical, electrical and plumbing.
    Mep = 12,
    /// Any other element.
    Other = 13,
}

impl Class {
    /// All classes by id.
    pub const ALL: [Self; 14] = [
        Self::None,
        Self::Wall,
        Self::Column,
        Self::Door,
        Self::Window,
        Self::Stair,
        Self::Ramp,
        Self::Railing,
        Self::Furniture,
        Self::CurtainWall,
        Self::Slab,
        Self::Beam,
        Self::Mep,
        Self::Other,
    ];

    /// Its id.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// Its name in files, e.g. `curtain_wall`.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Wall => "wall",
            Self::Column => "column",
            Self::Door => "door",
            Self::Window => "window",
            Self::Stair => "stair",
            Self::Ramp => "ramp",
            Self::Railing => "railing",
            Self::Furniture => "furniture",
            Self::CurtainWall => "curtain_wall",
            Self::Slab => "slab",
            Self::Beam => "beam",
            Self::Mep => "mep",
            Self::Other => "other",
        }
    }

    /// Priority of a class where elements overlap in a cell: the highest is shown. Doors are lowest, because a cell that any
    /// obstacle touches is occupied.
    pub fn draw_priority(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Door => 1,
            Self::Other => 2,
            Self::Slab => 3,
            Self::Mep => 4,
            Self::Beam => 5,
            Self::Furniture => 6,
            Self::Railing => 7,
            Self::Ramp => 8,
            Self::Stair => 9,
            Self::Window => 10,
            Self::CurtainWall => 11,
            Self::Column => 12,
            Self::Wall => 13,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_and_priorities_are_unique() {
        for (id, class) in Class::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(class.id()), id);
        }
        let mut priorities: Vec<_> = Class::ALL.map(Class::draw_priority).to_vec();
        priorities.sort_unstable();
        assert_eq!(priorities, (0..14).collect::<Vec<_>>());
    }
}
