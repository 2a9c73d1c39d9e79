//! Finds rooms, doors and points by the words of people.

use diagnostics::nearest_names_hint;
use frames::{Map, Point2};
use messages::{Site, space_flags};
use waypoints::WayEnd;

/// A name that stands for nothing of the site, or for several things.
#[derive(Debug, thiserror::Error)]
pub enum FindError {
    /// No room has it.
    #[error("there is no room {wanted:?}{nearest}")]
    Room {
        /// What was asked for.
        wanted: String,
        /// The nearest names, as the end of the message; may be empty.
        nearest: String,
    },
    /// No door has it.
    #[error("there is no door {wanted:?}{nearest}")]
    Door {
        /// What was asked for.
        wanted: String,
        /// The nearest names, as the end of the message; may be empty.
        nearest: String,
    },
    /// Several things have it.
    #[error("{wanted:?} are several: {}; name one by its GlobalId", found.join(", "))]
    Several {
        /// What was asked for.
        wanted: String,
        /// Their GlobalIds, each with what tells it from the others.
        found: Vec<String>,
    },
    /// A point without a storey, on a site of several.
    #[error("{wanted:?}: write X,Y,STOREY in metres of the frame map, with the index or name of a storey: {storeys}")]
    Storey {
        /// What was asked for.
        wanted: String,
        /// All storeys.
        storeys: String,
    },
}

/// An end of a way, as it was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundPlace {
    /// The words.
    pub asked: String,
    /// What they stand for.
    pub end: WayEnd,
}

/// GlobalIds in an error; more are counted.
const MAX_LISTED: usize = 8;

/// The space with a GlobalId, name (often a number), long name, or both as outputs write them; case counts in GlobalIds only.
///
/// # Errors
/// None, with the nearest names, or several, with their GlobalIds. Gross areas count only by GlobalId.
pub fn find_room(site: &Site<'_>, wanted: &str) -> Result<usize, FindError> {
    let wanted = wanted.trim();
    let spaces = || site.spaces.iter().enumerate();
    if let Some((space, _)) = spaces().find(|(_, space)| site.text(space.global_id) == wanted) {
        return Ok(space);
    }
    let names = |space: usize| {
        let record = &site.spaces[space];
        let both = export::space_name(site, space as u32).unwrap_or_default();
        [site.text(record.name).to_owned(), site.text(record.long_name).to_owned(), both]
    };
    let folded = wanted.to_lowercase();
    let is_named =
        |space: usize| names(space).iter().any(|name| !name.is_empty() && name.trim().to_lowercase() == folded);
    let rooms = || spaces().filter(|(_, space)| !space.has(space_flags::METADATA_ONLY)).map(|(k, _)| k);
    let found: Vec<usize> = rooms().filter(|space| is_named(*space)).collect();
    match found[..] {
        [space] => Ok(space),
        [] => {
            let all: Vec<String> = rooms().flat_map(names).collect();
            let ids = site.spaces.iter().map(|space| site.text(space.global_id));
            let nearest = nearest_names_hint(wanted, all.iter().map(String::as_str).chain(ids));
            Err(FindError::Room { wanted: wanted.to_owned(), nearest })
        }
        _ => {
            let storey = |space: usize| {
                let storey = site.map_storeys.get(site.spaces[space].map_storey as usize);
                storey.map_or("on no map", |storey| site.text(storey.name))
            };
            let label = |space: &usize| format!("{} ({})", site.text(site.spaces[*space].global_id), storey(*space));
            Err(several(wanted, found.iter().map(label).collect()))
        }
    }
}

/// The door (its place among those of the site) with a GlobalId or name.
///
/// # Errors
/// As [`find_room`].
pub fn find_door(site: &Site<'_>, wanted: &str) -> Result<usize, FindError> {
    let wanted = wanted.trim();
    let element = |door: usize| &site.elements[site.doors[door].element as usize];
    let doors = 0..site.doors.len();
    if let Some(door) = doors.clone().find(|door| site.text(element(*door).global_id) == wanted) {
        return Ok(door);
    }
    let folded = wanted.to_lowercase();
    let is_named = |door: &usize| {
        let name = site.text(element(*door).name).trim().to_lowercase();
        !name.is_empty() && name == folded
    };
    let found: Vec<usize> = doors.clone().filter(is_named).collect();
    match found[..] {
        [door] => Ok(door),
        [] => {
            let names = doors.clone().flat_map(|door| [element(door).name, element(door).global_id]);
            let nearest = nearest_names_hint(wanted, names.map(|text| site.text(text)));
            Err(FindError::Door { wanted: wanted.to_owned(), nearest })
        }
        _ => {
            let label = |door: &usize| {
                let rooms = site.doors[*door].spaces.iter().filter_map(|space| export::space_name(site, *space));
                let rooms: Vec<String> = rooms.collect();
                let between = if rooms.is_empty() { "no room".to_owned() } else { rooms.join(" and ") };
                format!("{} (at {between})", site.text(element(*door).global_id))
            };
            Err(several(wanted, found.iter().map(label).collect()))
        }
    }
}

fn several(wanted: &str, mut found: Vec<String>) -> FindError {
    let n_more = found.len().saturating_sub(MAX_LISTED);
    found.truncate(MAX_LISTED);
    if n_more > 0 {
        found.push(format!("and {n_more} more"));
    }
    FindError::Several { wanted: wanted.to_owned(), found }
}

/// A room, or a point `X,Y` or `X,Y,STOREY` in metres of the frame `map`, with the index or name of a map storey.
///
/// # Errors
/// As [`find_room`]; a point without a storey on a site of several, or with one that does not exist.
pub fn find_place(site: &Site<'_>, wanted: &str) -> Result<FoundPlace, FindError> {
    let asked = wanted.trim().to_owned();
    let mut parts = wanted.splitn(3, ',').map(str::trim);
    let number = |part: Option<&str>| part?.parse::<f64>().ok().filter(|number| number.is_finite());
    let (x_m, y_m) = (number(parts.next()), number(parts.next()));
    // Numbers of rooms may have commas, too.
    let is_room = find_room(site, wanted).is_ok();
    let (Some(x_m), Some(y_m), false) = (x_m, y_m, is_room) else {
        return Ok(FoundPlace { end: WayEnd::Space(find_room(site, wanted)?), asked });
    };
    let name = |storey: usize| site.text(site.map_storeys[storey].name);
    let n_storeys = site.map_storeys.len();
    let storey = match parts.next() {
        None => (n_storeys == 1).then_some(0),
        Some(storey) => (0..n_storeys)
            .find(|k| k.to_string() == storey)
            .or_else(|| (0..n_storeys).find(|k| name(*k).to_lowercase() == storey.to_lowercase())),
    };
    let Some(storey) = storey else {
        let storeys: Vec<String> = (0..n_storeys).map(|k| format!("{k} {:?}", name(k))).collect();
        return Err(FindError::Storey { wanted: asked, storeys: storeys.join(", ") });
    };
    Ok(FoundPlace { end: WayEnd::Point { map_storey: storey as u32, at: Point2::<Map>::new(x_m, y_m) }, asked })
}
