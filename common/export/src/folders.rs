//! Folders of an output folder, and the sums of the files in them.

use crate::input::ExportFile;
use crate::transliteration;
use messages::ContentId;
use messages::{MapStoreyRecord, Site};
use std::collections::BTreeMap;

/// sha256 of files by their path in the output, as manifests list them; they lie in this folder of it, `""` for the output.
pub fn sums(folder: &str, files: &[ExportFile]) -> BTreeMap<String, String> {
    let path = |file: &ExportFile| match folder {
        "" => file.path.clone(),
        folder => format!("{folder}/{}", file.path),
    };
    files.iter().map(|file| (path(file), ContentId::of(&file.bytes).to_string())).collect()
}

/// Folder of a map storey inside the output folder, e.g. `storeys/00-ground-floor`.
pub fn storey_folder(site: &Site<'_>, index: u32, storey: &MapStoreyRecord) -> String {
    format!("storeys/{index:02}-{}", transliteration::slug(site.text(storey.name), "storey"))
}
