//! The page with all its data as files, for a mail or a web server: `file://` allows neither modules nor requests, so that documents
//! are scripts that hand themselves to the page.

use crate::files::Maps;
use crate::page::FILES;
use crate::source::{Source, SourceError, TileAddress};
use base64::prelude::{BASE64_STANDARD, Engine};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What marks the page as one of files, in place of the beginning of `index.html`.
const OF_SERVER: &str = "<html ";
const OF_FILES: &str = "<html data-source=\"files\" ";

/// Why the folder is not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PageFolderError {
    /// It is there already.
    #[error("{} exists: name a folder that does not", folder.display())]
    Exists {
        /// The folder.
        folder: PathBuf,
    },
    /// It cannot be written.
    #[error("{} cannot be written", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The maps became others meanwhile.
    #[error("the maps changed while they were read: write the page again")]
    Changed,
    /// The maps cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
}

/// Writes the page with all dates into a new folder, which appears whole or not at all; returns the number of its files.
///
/// # Errors
/// See [`PageFolderError`].
pub(crate) fn write_page(site: &Maps, folder: &Path) -> Result<usize, PageFolderError> {
    if folder.exists() {
        return Err(PageFolderError::Exists { folder: folder.to_owned() });
    }
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let beside = folder.with_file_name(format!(".{name}.unfinished-{}", std::process::id()));
    let mut writer = Writer { folder: beside.clone(), n_files: 0 };
    let written = write_files(site, &mut writer);
    // What was read of maps that are gone, or could not be, has one reason.
    let written = if site.is_current() { written } else { Err(PageFolderError::Changed) };
    let written = written.and_then(|()| {
        fs::rename(&beside, folder).map_err(|source| PageFolderError::Io { path: folder.to_owned(), source })
    });
    if written.is_err() {
        // What is unfinished is of no use; the error that matters is the first one.
        let _ = fs::remove_dir_all(&beside);
    }
    written.map(|()| writer.n_files)
}

fn write_files(site: &Maps, writer: &mut Writer) -> Result<(), PageFolderError> {
    for file in FILES {
        let text = std::str::from_utf8(file.bytes).expect("the files of the page are text");
        let text = if file.path == "index.html" { text.replacen(OF_SERVER, OF_FILES, 1) } else { text.to_owned() };
        writer.write(file.path, text.as_bytes())?;
    }
    writer.document("site", &site.site()?)?;
    writer.document("calendar", &site.calendar()?)?;
    writer.document("tasks", &site.tasks()?)?;
    for key in site.keys() {
        if let Some(date) = site.date(&key)? {
            writer.document(&format!("dates/{key}"), &date)?;
        }
        if let Some(summary) = site.summary(&key)? {
            writer.document(&format!("summary/{key}"), &summary)?;
        }
    }
    let resolution_m = site.head().resolution_m;
    for (name, file) in site.layers() {
        for place in site.tiles().tiles_of(&file.storey.extent(), resolution_m) {
            let (storey, layer) = (file.storey.index, file.layer);
            let address = TileAddress { storey, layer, name: *name, place };
            if let Some(tile) = site.tile(&address)? {
                writer.write(&format!("data/tiles/{storey}/{}/{name}/{place}.png", layer.name()), &tile)?;
            }
        }
    }
    for name in site.models() {
        if let Some(model) = site.model(name)? {
            writer.document(&format!("models/{name}"), format!("\"{}\"", BASE64_STANDARD.encode(&model)).as_bytes())?;
        }
    }
    Ok(())
}

struct Writer {
    folder: PathBuf,
    n_files: usize,
}

impl Writer {
    fn write(&mut self, path: &str, bytes: &[u8]) -> Result<(), PageFolderError> {
        let path = self.folder.join(path);
        let parent = path.parent().unwrap_or(&self.folder);
        let written = fs::create_dir_all(parent).and_then(|()| fs::write(&path, bytes));
        written.map_err(|source| PageFolderError::Io { path: path.clone(), source })?;
        self.n_files += 1;
        Ok(())
    }

    /// A document as a script.
    fn document(&mut self, name: &str, json: &[u8]) -> Result<(), PageFolderError> {
        let script = [format!("groundplanData(\"{name}\",").as_bytes(), json, b");\n"].concat();
        self.write(&format!("data/{name}.js"), &script)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::SiteOfFiles;

    #[test]
    fn a_folder_that_exists_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let maps = tempfile::tempdir().unwrap();
        crate::files::tests::dated_maps(maps.path());
        let site = SiteOfFiles::open(maps.path(), None).unwrap().maps().unwrap();
        assert!(matches!(write_page(&site, folder.path()), Err(PageFolderError::Exists { .. })));
        let n_files = write_page(&site, &folder.path().join("page")).unwrap();
        // The page, site, calendar, tasks, two dates with their summaries, and a tile for each of two maps.
        assert_eq!(n_files, FILES.len() + 3 + 4 + 2);
        let index = std::fs::read_to_string(folder.path().join("page/index.html")).unwrap();
        assert!(index.contains(OF_FILES), "the page asks for files");
        let site = std::fs::read_to_string(folder.path().join("page/data/site.js")).unwrap();
        assert!(site.starts_with("groundplanData(\"site\",{") && site.ends_with("});\n"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
    }

    #[test]
    fn maps_that_change_give_no_page() {
        let folder = tempfile::tempdir().unwrap();
        let maps = tempfile::tempdir().unwrap();
        crate::files::tests::dated_maps(maps.path());
        let site = SiteOfFiles::open(maps.path(), None).unwrap().maps().unwrap();
        let manifest = maps.path().join("manifest.json");
        let text = std::fs::read_to_string(&manifest).unwrap();
        std::fs::write(&manifest, text + " ").unwrap();
        let page = folder.path().join("page");
        assert!(matches!(write_page(&site, &page), Err(PageFolderError::Changed)));
        let site = SiteOfFiles::open(maps.path(), None).unwrap().maps().unwrap();
        std::fs::write(maps.path().join("d1/storeys/00-floor/planning.pgm"), "").unwrap();
        assert!(matches!(write_page(&site, &page), Err(PageFolderError::Source(SourceError::Altered { .. }))));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
    }
}
