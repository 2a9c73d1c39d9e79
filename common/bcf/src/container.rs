//! A container of topics: a ZIP archive with a folder for each.

use crate::closing::closed;
use crate::guid::is_uuid;
use crate::markup::{extensions, file_names, markup, version};
use crate::reading::{read_markup, read_version, read_viewpoint};
use crate::topic::{BcfVersion, Comment, Snapshot, Topic};
use crate::viewpoint::visualization;
use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;

/// Most files of a container.
const MAX_FILES: usize = 50_000;
/// Largest file of a container, unpacked.
const MAX_FILE_BYTES: u64 = 64 << 20;
/// All files of a container, unpacked.
const MAX_BYTES: u64 = 512 << 20;
/// Most topics of a container.
const MAX_TOPICS: usize = 20_000;

/// Why a container cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum BcfError {
    /// It is no ZIP archive, or a damaged one.
    #[error("it is no BCF container (ZIP archive)")]
    Archive(#[source] zip::result::ZipError),
    /// A file in it cannot be unpacked.
    #[error("{file} in it cannot be unpacked")]
    File {
        /// Its path.
        file: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A file in it is no XML, or not that of BCF.
    #[error("{file} in it cannot be read: {why}")]
    Document {
        /// Its path.
        file: String,
        /// Why.
        why: String,
    },
    /// It has no `bcf.version`, or another one than those that are read.
    #[error("its version is {0:?}: 2.1 and 3.0 are read")]
    Version(String),
    /// It is larger than the limit.
    #[error("it has more than {limit} {what}")]
    TooLarge {
        /// How much there may be.
        limit: u64,
        /// Of what.
        what: &'static str,
    },
    /// It has no topic with this UUID.
    #[error("it has no topic {0}")]
    NoTopic(String),
}

/// A container of these topics.
pub fn written(topics: &[Topic], of: BcfVersion) -> Vec<u8> {
    let mut container = Container { version: of, files: BTreeMap::new(), topics: Vec::new() };
    container.files.insert("bcf.version".to_owned(), version(of).expect("memory does not fail"));
    if of == BcfVersion::V3_0 {
        container.files.insert("extensions.xml".to_owned(), extensions(topics).expect("memory does not fail"));
    }
    for topic in topics {
        container.add(topic.clone());
    }
    container.bytes()
}

/// A container that was read, or is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Container {
    version: BcfVersion,
    /// All files as they are, by path.
    files: BTreeMap<String, Vec<u8>>,
    topics: Vec<Topic>,
}

impl Container {
    /// Reads a container of somebody else.
    ///
    /// # Errors
    /// No ZIP archive, another version, files that are too large or no BCF.
    pub fn read(bytes: &[u8]) -> Result<Self, BcfError> {
        let files = unpacked(bytes)?;
        let version = files.get("bcf.version").map(|bytes| read_version(bytes)).transpose();
        let version =
            version.map_err(|why| BcfError::Document { file: "bcf.version".to_owned(), why })?.unwrap_or_default();
        let version = BcfVersion::of(&version).ok_or(BcfError::Version(version))?;
        let mut topics = Vec::new();
        for (path, bytes) in files.iter().filter(|(path, _)| path.ends_with("/markup.bcf")) {
            if topics.len() == MAX_TOPICS {
                return Err(BcfError::TooLarge { limit: MAX_TOPICS as u64, what: "topics" });
            }
            let unreadable = |file: &str, why: String| BcfError::Document { file: file.to_owned(), why };
            let (mut topic, names) = read_markup(bytes, version).map_err(|why| unreadable(path, why))?;
            let folder = path.trim_end_matches("markup.bcf");
            for (viewpoint, [file, picture]) in topic.viewpoints.iter_mut().zip(names) {
                let path = format!("{folder}{file}");
                if let Some(bytes) = files.get(&path).filter(|_| !file.is_empty()) {
                    read_viewpoint(bytes, viewpoint).map_err(|why| unreadable(&path, why))?;
                }
                let picture_bytes = files.get(&format!("{folder}{picture}")).filter(|_| !picture.is_empty()).cloned();
                let is_jpeg = picture.to_lowercase().ends_with("jpg") || picture.to_lowercase().ends_with("jpeg");
                viewpoint.snapshot = picture_bytes.map(|b| if is_jpeg { Snapshot::Jpeg(b) } else { Snapshot::Png(b) });
            }
            topics.push(topic);
        }
        Ok(Self { version, files, topics })
    }

    /// Its version.
    pub fn version(&self) -> BcfVersion {
        self.version
    }

    /// Its topics, in the order of their folders.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// Adds a topic, or replaces that with its UUID.
    pub fn add(&mut self, topic: Topic) {
        assert!(is_uuid(&topic.guid), "topics are named by UUIDs");
        let folder = format!("{}/", topic.guid);
        self.files.retain(|path, _| !path.starts_with(&folder));
        let of = self.version;
        for (at, viewpoint) in topic.viewpoints.iter().enumerate() {
            let (file, picture) = file_names(at, viewpoint);
            let bytes = visualization(viewpoint, of).expect("memory does not fail");
            self.files.insert(format!("{folder}{file}"), bytes);
            if let (Some(name), Some(Snapshot::Png(bytes) | Snapshot::Jpeg(bytes))) = (picture, &viewpoint.snapshot) {
                self.files.insert(format!("{folder}{name}"), bytes.clone());
            }
        }
        self.files.insert(format!("{folder}markup.bcf"), markup(&topic, of).expect("memory does not fail"));
        match self.topics.iter_mut().find(|known| known.guid == topic.guid) {
            Some(known) => *known = topic,
            None => self.topics.push(topic),
        }
    }

    /// Gives a topic another status, with a comment that says why; all else of it stays as it is.
    ///
    /// # Errors
    /// There is no such topic, or its markup cannot be changed.
    pub fn set_status(&mut self, guid: &str, status: &str, comment: &Comment) -> Result<(), BcfError> {
        let no_topic = || BcfError::NoTopic(guid.to_owned());
        let at = self.topics.iter().position(|topic| topic.guid == guid).ok_or_else(no_topic)?;
        let is_own = |path: &&String| {
            let folder = path.strip_suffix("/markup.bcf").unwrap_or_default();
            folder.rsplit('/').next().is_some_and(|name| name.eq_ignore_ascii_case(guid))
        };
        let path = self.files.keys().find(is_own).cloned().ok_or_else(no_topic)?;
        let markup = closed(&self.files[&path], self.version, status, comment);
        let markup = markup.map_err(|why| BcfError::Document { file: path.clone(), why })?;
        let (mut topic, _) =
            read_markup(&markup, self.version).map_err(|why| BcfError::Document { file: path.clone(), why })?;
        topic.viewpoints = std::mem::take(&mut self.topics[at].viewpoints);
        self.topics[at] = topic;
        self.files.insert(path, markup);
        Ok(())
    }

    /// The container as a file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
        // Readers look at the version first.
        let (first, rest): (Vec<_>, Vec<_>) = self.files.iter().partition(|(path, _)| *path == "bcf.version");
        for (path, bytes) in first.into_iter().chain(rest) {
            let written = zip
                .start_file(path.as_str(), options)
                .map_err(std::io::Error::from)
                .and_then(|()| zip.write_all(bytes));
            written.expect("memory does not fail, and names and sizes are those of files");
        }
        zip.finish().expect("memory does not fail").into_inner()
    }
}

/// The files of an archive, by path.
fn unpacked(bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, BcfError> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(BcfError::Archive)?;
    if archive.len() > MAX_FILES {
        return Err(BcfError::TooLarge { limit: MAX_FILES as u64, what: "files" });
    }
    let (mut files, mut all) = (BTreeMap::new(), 0_u64);
    for k in 0..archive.len() {
        let file = archive.by_index(k).map_err(BcfError::Archive)?;
        if file.is_dir() {
            continue;
        }
        let path = file.name().map_err(BcfError::Archive)?.replace('\\', "/");
        let mut content = Vec::new();
        // The size that an archive tells is not believed.
        let read = file.take(MAX_FILE_BYTES + 1).read_to_end(&mut content);
        read.map_err(|source| BcfError::File { file: path.clone(), source })?;
        all += content.len() as u64;
        if content.len() as u64 > MAX_FILE_BYTES {
            return Err(BcfError::TooLarge { limit: MAX_FILE_BYTES, what: "bytes in a file" });
        }
        if all > MAX_BYTES {
            return Err(BcfError::TooLarge { limit: MAX_BYTES, what: "bytes" });
        }
        files.insert(path, content);
    }
    Ok(files)
}
