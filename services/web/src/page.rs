//! The page's own files, which are part of the program: `page/bundle`, made by `scripts/build_page`.

/// A file of the page.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PageFile {
    /// Path beside `index.html`.
    pub(crate) path: &'static str,
    /// Its media type.
    pub(crate) media_type: &'static str,
    /// Its content.
    pub(crate) bytes: &'static [u8],
}

macro_rules! page_file {
    ($path:literal, $media_type:literal) => {
        PageFile { path: $path, media_type: $media_type, bytes: include_bytes!(concat!("../page/bundle/", $path)) }
    };
}

/// The page itself.
pub(crate) const INDEX: PageFile = page_file!("index.html", "text/html; charset=utf-8");

/// All files of the page.
pub(crate) const FILES: [PageFile; 4] = [
    INDEX,
    page_file!("app.js", "text/javascript; charset=utf-8"),
    page_file!("scene.js", "text/javascript; charset=utf-8"),
    page_file!("style.css", "text/css; charset=utf-8"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};
    use std::path::{Path, PathBuf};

    /// Bytes of all files together, which a robot's PC and a mail can bear.
    const MAX_BYTES: usize = 1_100_000;

    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("page")
    }

    #[test]
    fn the_page_is_small() {
        let bytes: usize = FILES.iter().map(|file| file.bytes.len()).sum();
        assert!(bytes <= MAX_BYTES, "{bytes}");
    }

    #[test]
    fn the_bundle_is_made_of_the_sources_beside_it() {
        let sums = std::fs::read_to_string(folder().join("bundle/SHA256SUMS")).unwrap();
        let listed: Vec<(&str, &str)> = sums.lines().map(|line| line.split_once("  ").unwrap()).collect();
        for (sum, path) in &listed {
            let bytes = std::fs::read(folder().join(path)).unwrap();
            let found: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(found, *sum, "{path} has changed: scripts/build_page makes the bundle anew");
        }
        let at_the_top = ["index.html", "style.css", "package.json", "package-lock.json", "tsconfig.json"];
        let mut sources: Vec<PathBuf> = at_the_top.into_iter().map(PathBuf::from).collect();
        let scripts = std::fs::read_dir(folder().join("src")).unwrap();
        sources.extend(scripts.map(|entry| Path::new("src").join(entry.unwrap().file_name())));
        for source in sources.into_iter().chain(FILES.map(|file| Path::new("bundle").join(file.path))) {
            assert!(listed.iter().any(|(_, path)| Path::new(path) == source), "{} is not listed", source.display());
        }
    }
}
