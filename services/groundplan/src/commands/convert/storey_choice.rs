//! `--storeys`: selection of the map storeys that are written.

use crate::failure::Failure;
use diagnostics::nearest_names_hint;
use messages::{NONE, Site};
use wildmatch::WildMatch;

/// The indices of the map storeys that are asked for, ascending; of all if nothing is.
///
/// Each text is an index, a GlobalId or a name, which may have `*` and `?`, of a map storey or of a storey of the files that is
/// mapped with it; or several, separated by commas.
///
/// # Errors
/// A text that matches no map storey, or one as an index and another as a name.
pub(super) fn chosen(site: &Site<'_>, asked: &[String]) -> Result<Vec<u32>, Failure> {
    if asked.is_empty() {
        return Ok((0..site.map_storeys.len() as u32).collect());
    }
    let mut chosen = Vec::new();
    for text in asked {
        // A name may have a comma.
        let whole = matching(site, text)?;
        if !whole.is_empty() {
            chosen.extend(whole);
            continue;
        }
        for part in text.split(',').map(str::trim) {
            let found = matching(site, part)?;
            if found.is_empty() {
                return Err(unknown(site, part));
            }
            chosen.extend(found);
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

fn matching(site: &Site<'_>, text: &str) -> Result<Vec<u32>, Failure> {
    let pattern = WildMatch::new(text);
    let is_it = |t: messages::Text| !site.text(t).is_empty() && pattern.matches(site.text(t));
    let named = (0..).zip(site.map_storeys).filter(|(index, s)| {
        let merged = site.storeys.iter().filter(|m| m.map_storey == *index);
        is_it(s.name) || is_it(s.global_id) || merged.into_iter().any(|m| is_it(m.name) || is_it(m.global_id))
    });
    let named: Vec<u32> = named.map(|(index, _)| index).collect();
    let index = text.parse::<u32>().ok().filter(|index| (*index as usize) < site.map_storeys.len());
    match index {
        Some(index) if !named.is_empty() && named != [index] => Err(Failure::usage(format!(
            "--storeys {text:?} is the index of one storey and the name of another: write a GlobalId of {}",
            listed(site)
        ))),
        Some(index) => Ok(vec![index]),
        None => Ok(named),
    }
}

fn unknown(site: &Site<'_>, text: &str) -> Failure {
    let pattern = WildMatch::new(text);
    let unmapped = site
        .storeys
        .iter()
        .find(|s| s.map_storey == NONE && [s.name, s.global_id].iter().any(|t| pattern.matches(site.text(*t))));
    if let Some(storey) = unmapped {
        let (name, why) = (site.text(storey.name), site.text(storey.why));
        return Failure::usage(format!("--storeys {text:?}: storey {name:?} is not mapped: {why}"));
    }
    if site.map_storeys.is_empty() {
        return Failure::usage(format!("--storeys {text:?}: the model has no storey that is mapped"));
    }
    let names = site.map_storeys.iter().map(|s| site.text(s.name));
    let nearest = nearest_names_hint(&text.replace(['*', '?'], ""), names);
    Failure::usage(format!("--storeys {text:?} matches no storey{nearest}; there are {}", listed(site)))
}

fn listed(site: &Site<'_>) -> String {
    let storey = |(index, s): (usize, &messages::MapStoreyRecord)| {
        format!("{index} {:?} {}", site.text(s.name), site.text(s.global_id)).trim_end().to_owned()
    };
    site.map_storeys.iter().enumerate().map(storey).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{MapStoreyRecord, SiteBuilder, StoreyRecord, Text};

    fn asked(texts: &[&str]) -> Result<Vec<u32>, String> {
        let mut b = SiteBuilder::default();
        let floor = messages::FloorKind::Built.into();
        for (name, id) in [("Ground floor", "id-0"), ("Level 2, east", "id-1"), ("0", "id-2")] {
            let [name, global_id] = [name, id].map(|t| b.texts.add(t));
            b.map_storeys.push(MapStoreyRecord { global_id, name, floor_z_tenths: 0, floor, bounds_tenths: [0; 4] });
        }
        for (name, why, map_storey) in [("Roof", "nothing to walk on", NONE), ("Screed", "", 1)] {
            let [name, why] = [name, why].map(|t| b.texts.add(t));
            b.storeys.push(StoreyRecord {
                global_id: Text::default(),
                name,
                why,
                placement_z_tenths: 0,
                has_placement: 0,
                map_storey,
                source: 0,
            });
        }
        let site = b.finish();
        let texts: Vec<String> = texts.iter().map(|t| (*t).to_owned()).collect();
        chosen(&Site::open(site.bytes()).unwrap(), &texts).map_err(|failure| failure.to_string())
    }

    #[test]
    fn storeys_are_chosen_by_index_name_pattern_or_global_id() {
        assert_eq!(asked(&[]), Ok(vec![0, 1, 2]));
        assert_eq!(asked(&["1"]), Ok(vec![1]));
        assert_eq!(asked(&["id-2", "Ground*"]), Ok(vec![0, 2]));
        assert_eq!(asked(&["id-2,1", "1"]), Ok(vec![1, 2]));
        assert_eq!(asked(&["Level 2, east"]), Ok(vec![1]), "a name may have a comma");
        assert_eq!(asked(&["Screed"]), Ok(vec![1]), "a storey that is mapped with another");
        assert_eq!(asked(&["*"]), Ok(vec![0, 1, 2]));
    }

    #[test]
    fn storeys_that_are_unknown_not_mapped_or_ambiguous_are_errors() {
        let error = asked(&["Gruond floor"]).unwrap_err();
        assert!(error.contains("nearest: \"Ground floor\"") && error.contains("2 \"0\" id-2"), "{error}");
        assert!(asked(&["7"]).unwrap_err().contains("matches no storey"));
        assert!(asked(&["Roof"]).unwrap_err().contains("not mapped: nothing to walk on"));
        assert!(asked(&["0"]).unwrap_err().contains("GlobalId"), "index of one, name of another");
    }
}
