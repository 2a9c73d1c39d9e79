//! Ids of maps, and names that ids are made of.

use export::ExportInput;
use messages::Site;

/// A text with the characters that ids should have alone (VDA 5050, 7.1.2): each other one is a point.
///
/// GlobalIds have one character that is none of them, and no point, so that different ones stay different.
pub(crate) fn id_of(text: &str) -> String {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | ':');
    text.chars().map(|c| if is_allowed(c) { c } else { '.' }).collect()
}

/// Id of the map of a map storey, the same at every date: the GlobalId of its storey, with its index where several have that.
pub(crate) fn map_id(site: &Site<'_>, map_storey: u32) -> String {
    let id = |storey: usize| id_of(site.text(site.map_storeys[storey].global_id));
    let own = id(map_storey as usize);
    let n_alike = (0..site.map_storeys.len()).filter(|&storey| id(storey) == own).count();
    if n_alike == 1 && !own.is_empty() { own } else { format!("{own}:{map_storey}") }
}

/// Name of an element with its GlobalId, for descriptors.
pub(crate) fn element_text(input: &ExportInput<'_>, element: u32) -> String {
    let Some(record) = input.site.elements.get(element as usize) else { return String::new() };
    let [class, name, id] = [record.ifc_type, record.name, record.global_id].map(|text| input.site.text(text));
    [class, name, id].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_have_the_characters_that_fleets_expect() {
        assert_eq!(id_of("3f$kT_9-a.b:c"), "3f.kT_9-a.b:c");
        assert_eq!(id_of("Büro #1"), "B.ro..1");
    }
}
