//! The rooms that this robot may enter, and why not the others.

use crate::circumstances::Circumstances;
use crate::room_access::{RoomAccess, room_access};
use crate::situation::Situation;
use messages::space_flags;
use schemars::JsonSchema;
use serde::Serialize;

/// All rooms of a site, or of a storey.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RoomsAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// How many rooms there are, listed or not.
    pub n_rooms: usize,
    /// How many of them this robot may enter.
    pub n_may_enter: usize,
    /// For how many of them nobody looked for a way.
    pub n_unknown: usize,
    /// The rooms, in the order of the site.
    pub rooms: Vec<RoomAccess>,
}

/// The rooms of a site, or of one map storey. What is an area in square metres alone, and no room, is left out.
pub fn rooms(situation: &Situation<'_>, map_storey: Option<u32>) -> RoomsAnswer {
    let spaces = situation.site.spaces.iter().enumerate();
    let is_room = |record: &messages::SpaceRecord| !record.has(space_flags::METADATA_ONLY);
    let on_storey = |record: &messages::SpaceRecord| map_storey.is_none_or(|storey| record.map_storey == storey);
    let wanted = spaces.filter(|(_, record)| is_room(record) && on_storey(record));
    let rooms: Vec<RoomAccess> = wanted.map(|(space, _)| room_access(situation, space)).collect();
    let count = |may_enter: Option<bool>| rooms.iter().filter(|room| room.may_enter == may_enter).count();
    RoomsAnswer {
        circumstances: situation.circumstances.clone(),
        n_rooms: rooms.len(),
        n_may_enter: count(Some(true)),
        n_unknown: count(None),
        rooms,
    }
}
