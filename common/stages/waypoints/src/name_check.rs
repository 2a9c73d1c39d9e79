//! Checks the names in options against the site.

use crate::options::MissionPlanOptions;
use diagnostics::nearest_names_hint;
use messages::Site;
use wildmatch::WildMatch;

/// Names in options that match nothing in the site.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnknownName {
    /// No space matches.
    #[error("spaces: {asked:?} matches no space of the model{hint}")]
    Space {
        /// The pattern in the options.
        asked: String,
        /// Similar names, or examples of existing ones.
        hint: String,
    },
    /// No lift matches.
    #[error("[tour] lifts: {asked:?} matches no lift of the model{hint}")]
    Lift {
        /// The pattern in the options.
        asked: String,
        /// Similar names, or examples of existing ones.
        hint: String,
    },
    /// No map storey has this index.
    #[error("[tour] start: there is no storey {asked}; {known}")]
    Storey {
        /// Index in the options.
        asked: u32,
        /// Indices and names of the map storeys.
        known: String,
    },
}

/// Maximum number of example names.
const MAX_EXAMPLES: usize = 5;

/// The end of a message: similar names, else examples of existing ones.
fn hint(asked: &str, names: &[String]) -> String {
    let near = nearest_names_hint(&asked.replace(['*', '?'], ""), names.iter().map(String::as_str));
    let some: Vec<String> = names.iter().take(MAX_EXAMPLES).map(|name| format!("{name:?}")).collect();
    match (near.is_empty(), some.is_empty()) {
        (false, _) => near,
        (true, false) => format!("; there are {}", some.join(", ")),
        (true, true) => "; it has none".to_owned(),
    }
}

/// Refuses options that name spaces, lifts or a storey that the site does not have.
///
/// A pattern of wildcards alone, such as `*` for all lifts, may match nothing, except for spaces.
///
/// # Errors
/// The first name that matches nothing, with the most similar names.
pub fn check_names(site: &Site<'_>, options: &MissionPlanOptions) -> Result<(), UnknownName> {
    for asked in &options.spaces {
        let pattern = WildMatch::new(asked);
        if !(0..site.spaces.len()).any(|k| MissionPlanOptions::space_names(site, k).iter().any(|n| pattern.matches(n)))
        {
            let all: Vec<String> =
                (0..site.spaces.len()).flat_map(|k| MissionPlanOptions::space_names(site, k)).collect();
            return Err(UnknownName::Space { asked: asked.clone(), hint: hint(asked, &all) });
        }
    }
    let lifts = || site.elements.iter().filter(|e| site.is_a(e, "IfcTransportElement"));
    let names = || lifts().flat_map(|e| [e.global_id, e.name].map(|t| site.text(t)));
    for asked in options.lifts.iter().filter(|l| !l.chars().all(|c| ['*', '?'].contains(&c))) {
        if !names().any(|name| WildMatch::new(asked).matches(name)) {
            let all: Vec<String> = names().filter(|name| !name.is_empty()).map(str::to_owned).collect();
            return Err(UnknownName::Lift { asked: asked.clone(), hint: hint(asked, &all) });
        }
    }
    match options.start {
        Some(start) if start.storey as usize >= site.map_storeys.len() => {
            let storeys = site.map_storeys.iter().enumerate();
            let known: Vec<String> = storeys.map(|(k, s)| format!("{k} is {:?}", site.text(s.name))).collect();
            let known = if known.is_empty() { "the model has none".to_owned() } else { known.join(", ") };
            Err(UnknownName::Storey { asked: start.storey, known })
        }
        _ => Ok(()),
    }
}
