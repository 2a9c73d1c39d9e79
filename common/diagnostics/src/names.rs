//! Things by the words of people: GlobalIds, names and long names.

use crate::nearest_names::{hint, nearest_names};

/// What a thing may be called.
pub trait Called {
    /// Its GlobalId, in which case counts.
    fn global_id(&self) -> &str;

    /// Its names, in any case; empty ones are none.
    fn names(&self) -> Vec<&str>;
}

/// Nothing is called so.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no {kind} {wanted:?}{}", hint(nearest))]
pub struct NothingCalled {
    /// What was looked for, e.g. `room`.
    pub kind: &'static str,
    /// The words.
    pub wanted: String,
    /// The nearest names, the nearest first; may be empty.
    pub nearest: Vec<String>,
}

impl NothingCalled {
    /// The nearest names as the end of a message, e.g. `; nearest: "Lab 3", "Lab 2"`; empty if there is none.
    pub fn nearest_hint(&self) -> String {
        hint(&self.nearest)
    }
}

/// The things that people mean by a word, in their order: the one with this GlobalId, else all with this name; spaces around it do
/// not count.
///
/// # Errors
/// There is none, with the nearest names, or GlobalIds where no name comes near.
pub fn called<T: Called>(kind: &'static str, things: Vec<T>, wanted: &str) -> Result<Vec<T>, NothingCalled> {
    let wanted = wanted.trim();
    let folded = wanted.to_lowercase();
    let is_named =
        |thing: &T| !folded.is_empty() && thing.names().iter().any(|name| name.trim().to_lowercase() == folded);
    let has_id = |thing: &T| !wanted.is_empty() && thing.global_id() == wanted;
    let is_by_id = things.iter().any(has_id);
    let is_meant = |thing: &T| if is_by_id { has_id(thing) } else { is_named(thing) };
    if !things.iter().any(is_meant) {
        let near_name = nearest_names(wanted, things.iter().flat_map(Called::names));
        let near_id = || nearest_names(wanted, things.iter().map(Called::global_id));
        let nearest = if near_name.is_empty() { near_id() } else { near_name };
        let nearest = nearest.into_iter().map(str::to_owned).collect();
        return Err(NothingCalled { kind, wanted: wanted.to_owned(), nearest });
    }
    Ok(things.into_iter().filter(is_meant).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Called for (&str, [&str; 2]) {
        fn global_id(&self) -> &str {
            self.0
        }

        fn names(&self) -> Vec<&str> {
            self.1.to_vec()
        }
    }

    #[test]
    fn a_global_id_goes_before_names_and_case_counts_in_it_alone() {
        let rooms = [("id-4", ["U.04", "Office"]), ("id-9", ["U.09", "office "]), ("id-77", ["id-4", ""])];
        let found = |wanted: &str| {
            let found = called("room", rooms.to_vec(), wanted).map_err(|error| error.to_string())?;
            Ok::<_, String>(found.iter().map(|room| room.0).collect::<Vec<_>>())
        };
        for (wanted, expected) in [
            ("u.04 ", Ok(vec!["id-4"])),
            (" OFFICE", Ok(vec!["id-4", "id-9"])),
            ("id-4", Ok(vec!["id-4"])),
            ("ID-4", Ok(vec!["id-77"])),
            ("U.08", Err("there is no room \"U.08\"; nearest: \"U.04\", \"U.09\"".to_owned())),
            ("di-77", Err("there is no room \"di-77\"; nearest: \"id-77\"".to_owned())),
            (" ", Err("there is no room \"\"".to_owned())),
            ("Officf", Err("there is no room \"Officf\"; nearest: \"Office\", \"office \"".to_owned())),
        ] {
            assert_eq!(found(wanted), expected, "{wanted}");
        }
    }
}
