//! Finds rooms, doors and points by the words of people.

use diagnostics::{Called, NothingCalled, called};
use frames::{Map, Point2};
use messages::{Site, SpaceRecord, space_flags};
use waypoints::WayEnd;

/// A name that stands for nothing of the site, or for several things.
#[derive(Debug, thiserror::Error)]
pub enum FindError {
    /// No room or door has it.
    #[error(transparent)]
    Unknown(#[from] NothingCalled),
    /// Several things have it.
    #[error("{wanted:?} are several: {}; name one by its GlobalId", found.join(", "))]
    Several {
        /// What was asked for.
        wanted: String,
        /// Their GlobalIds, each with what tells it from the others.
        found: Vec<String>,
    },
    /// A storey that there is not.
    #[error("there is no storey {wanted:?}: name one of {storeys}")]
    NoStorey {
        /// What was asked for.
        wanted: String,
        /// All storeys.
        storeys: String,
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

/// A room or door with its place among those of the site.
struct Found<'s> {
    place: usize,
    global_id: &'s str,
    names: Vec<String>,
}

impl Called for Found<'_> {
    fn global_id(&self) -> &str {
        self.global_id
    }

    fn names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).collect()
    }
}

/// The one of some things that a word stands for; `tell` says what tells one from the others.
fn one_of(
    kind: &'static str,
    things: Vec<Found<'_>>,
    wanted: &str,
    tell: impl Fn(usize) -> String,
) -> Result<usize, FindError> {
    let found = called(kind, things, wanted)?;
    match &found[..] {
        [one] => Ok(one.place),
        _ => {
            let label = |thing: &Found<'_>| format!("{} ({})", thing.global_id, tell(thing.place));
            Err(several(wanted.trim(), found.iter().map(label).collect()))
        }
    }
}

/// The space with a GlobalId, name (often a number), long name, or both as outputs write them; case counts in GlobalIds only.
///
/// # Errors
/// None, with the nearest names, or several, with their GlobalIds. Gross areas count only by GlobalId.
pub fn find_room(site: &Site<'_>, wanted: &str) -> Result<usize, FindError> {
    let room = |(place, record): (usize, &SpaceRecord)| {
        let both = export::space_name(site, place as u32).unwrap_or_default();
        let names = vec![site.text(record.name).to_owned(), site.text(record.long_name).to_owned(), both];
        let has_names = !record.has(space_flags::METADATA_ONLY);
        Found { place, global_id: site.text(record.global_id), names: if has_names { names } else { Vec::new() } }
    };
    one_of("room", site.spaces.iter().enumerate().map(room).collect(), wanted, |space| {
        let storey = site.map_storeys.get(site.spaces[space].map_storey as usize);
        storey.map_or("on no map", |storey| site.text(storey.name)).to_owned()
    })
}

/// The door (its place among those of the site) with a GlobalId or name.
///
/// # Errors
/// As [`find_room`].
pub fn find_door(site: &Site<'_>, wanted: &str) -> Result<usize, FindError> {
    let door = |place: usize| {
        let element = &site.elements[site.doors[place].element as usize];
        Found { place, global_id: site.text(element.global_id), names: vec![site.text(element.name).to_owned()] }
    };
    one_of("door", (0..site.doors.len()).map(door).collect(), wanted, |door| {
        let rooms = site.doors[door].spaces.iter().filter_map(|space| export::space_name(site, *space));
        let rooms: Vec<String> = rooms.collect();
        if rooms.is_empty() { "at no room".to_owned() } else { format!("at {}", rooms.join(" and ")) }
    })
}

/// The element (its place among those of the site) with a GlobalId or name.
///
/// # Errors
/// As [`find_room`].
pub fn find_element(site: &Site<'_>, wanted: &str) -> Result<usize, FindError> {
    let element = |(place, record): (usize, &messages::ElementRecord)| Found {
        place,
        global_id: site.text(record.global_id),
        names: vec![site.text(record.name).to_owned()],
    };
    one_of("element", site.elements.iter().enumerate().map(element).collect(), wanted, |element| {
        site.text(site.elements[element].ifc_type).to_owned()
    })
}

/// The map storey with an index or name; case does not count.
///
/// # Errors
/// None, with all storeys.
pub fn find_storey(site: &Site<'_>, wanted: &str) -> Result<u32, FindError> {
    let name = |storey: usize| site.text(site.map_storeys[storey].name);
    let wanted = wanted.trim();
    let mut storeys = 0..site.map_storeys.len();
    let by_index = storeys.clone().find(|storey| storey.to_string() == wanted);
    let found = by_index.or_else(|| storeys.find(|storey| name(*storey).to_lowercase() == wanted.to_lowercase()));
    found.map(|storey| storey as u32).ok_or_else(|| {
        let all = (0..site.map_storeys.len()).map(|storey| format!("{storey} {:?}", name(storey)));
        FindError::NoStorey { wanted: wanted.to_owned(), storeys: all.collect::<Vec<_>>().join(", ") }
    })
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
