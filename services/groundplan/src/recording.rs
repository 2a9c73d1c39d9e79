//! MCAP files of stamped ROS 2 messages. Only this module knows the format.

use input_files::open_regular_file;
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, Writer};
use ros::{CdrError, RosMessage};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read};
use std::path::{Path, PathBuf};

/// Why a recording could not be written. What stood at its path is untouched.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecordingError {
    /// Something else stands there.
    #[error("{} is no MCAP file: choose another name for the recording", path.display())]
    Foreign {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("recording {} cannot be written", path.display())]
    Io {
        /// The path that was asked for.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The writer of the format refused.
    #[error("recording {} cannot be written", path.display())]
    Mcap {
        /// The path that was asked for.
        path: PathBuf,
        /// Why.
        source: McapError,
    },
    /// A message has no bytes.
    #[error("a message of {topic} cannot be written")]
    Message {
        /// Its topic.
        topic: String,
        /// Why.
        source: CdrError,
    },
}

/// A recording that is being written, in a file beside its place.
pub(crate) struct Recording {
    files: RecordingFiles,
    writer: Writer<BufWriter<File>>,
    /// Number and next sequence of each topic.
    channels: BTreeMap<String, (u16, u32)>,
}

/// A whole recording on disk, beside its place.
pub(crate) struct FinishedRecording {
    files: RecordingFiles,
}

/// The place of a recording, and the file that will be moved there; this one is removed if it still exists in the end.
struct RecordingFiles {
    path: PathBuf,
    beside: PathBuf,
}

impl Recording {
    /// Begins a recording that is to stand at `path`, alone or instead of an earlier MCAP file.
    ///
    /// # Errors
    /// A file of another kind at the path, a folder that cannot be written.
    pub(crate) fn begin(path: &Path) -> Result<Self, RecordingError> {
        let files = RecordingFiles::at(path)?;
        let file = File::create(&files.beside).map_err(|e| files.io(e))?;
        // Compression in other threads would make the bytes depend on how many there are.
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .library(concat!("groundplan ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_threads(0);
        let writer = options.create(BufWriter::new(file)).map_err(|e| files.mcap(e))?;
        Ok(Self { files, writer, channels: BTreeMap::new() })
    }

    /// Adds facts about the recording.
    pub(crate) fn describe(&mut self, name: &str, facts: BTreeMap<String, String>) -> Result<(), RecordingError> {
        let metadata = mcap::records::Metadata { name: name.to_owned(), metadata: facts };
        self.writer.write_metadata(&metadata).map_err(|e| self.files.mcap(e))
    }

    /// Adds a message of a topic at an instant, in nanoseconds since 1970.
    pub(crate) fn add<M: RosMessage>(&mut self, topic: &str, at_ns: u64, message: &M) -> Result<(), RecordingError> {
        let data = ros::cdr(message).map_err(|source| RecordingError::Message { topic: topic.to_owned(), source })?;
        let (channel_id, sequence) = self.next_of::<M>(topic).map_err(|e| self.files.mcap(e))?;
        let header = MessageHeader { channel_id, sequence, log_time: at_ns, publish_time: at_ns };
        self.writer.write_to_known_channel(&header, &data).map_err(|e| self.files.mcap(e))
    }

    /// Number of a topic, which is added if it is new, and the next sequence in it.
    fn next_of<M: RosMessage>(&mut self, topic: &str) -> Result<(u16, u32), McapError> {
        if let Some((channel, sequence)) = self.channels.get_mut(topic) {
            *sequence += 1;
            return Ok((*channel, *sequence));
        }
        let schema = self.writer.add_schema(M::FULL_NAME, "ros2msg", M::DEFINITION.as_bytes())?;
        let facts = BTreeMap::from([("topic_type_hash".to_owned(), M::TYPE_HASH.to_owned())]);
        let channel = self.writer.add_channel(schema, topic, "cdr", &facts)?;
        self.channels.insert(topic.to_owned(), (channel, 0));
        Ok((channel, 0))
    }

    /// Writes the index and flushes all to the disk.
    pub(crate) fn finish(mut self) -> Result<FinishedRecording, RecordingError> {
        self.writer.finish().map_err(|e| self.files.mcap(e))?;
        let file = self.writer.into_inner().into_inner().map_err(|e| self.files.io(e.into_error()))?;
        file.sync_all().map_err(|e| self.files.io(e))?;
        Ok(FinishedRecording { files: self.files })
    }
}

impl FinishedRecording {
    /// Moves the recording to its place.
    pub(crate) fn swap_in(self) -> Result<(), RecordingError> {
        let RecordingFiles { path, beside } = &self.files;
        let flushed = |folder: &Path| File::open(folder).and_then(|folder| folder.sync_all());
        fs::rename(beside, path).and_then(|()| flushed(daemon::folder_of(path))).map_err(|e| self.files.io(e))
    }
}

impl RecordingFiles {
    fn at(path: &Path) -> Result<Self, RecordingError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let beside = daemon::folder_of(path).join(format!(".{name}.new-{}", std::process::id()));
        let files = Self { path: path.to_owned(), beside };
        match is_mcap(path) {
            Ok(true) => Ok(files),
            Ok(false) => Err(RecordingError::Foreign { path: path.to_owned() }),
            Err(error) if error.kind() == io::ErrorKind::NotFound && !path.is_symlink() => Ok(files),
            Err(error) => Err(files.io(error)),
        }
    }

    fn io(&self, source: io::Error) -> RecordingError {
        RecordingError::Io { path: self.path.clone(), source }
    }

    fn mcap(&self, error: McapError) -> RecordingError {
        match error {
            McapError::Io(source) => self.io(source),
            source => RecordingError::Mcap { path: self.path.clone(), source },
        }
    }
}

impl Drop for RecordingFiles {
    fn drop(&mut self) {
        // It is gone once the recording is in its place. Half a file helps nobody, and keeps a full disk full.
        let _ = fs::remove_file(&self.beside);
    }
}

/// True if a file begins as MCAP files do.
fn is_mcap(path: &Path) -> io::Result<bool> {
    let mut begin = Vec::new();
    open_regular_file(path)?.take(mcap::MAGIC.len() as u64).read_to_end(&mut begin)?;
    Ok(begin == mcap::MAGIC)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros::msg::std_msgs::String as Text;

    #[test]
    fn a_recording_appears_whole_or_not_at_all() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("film.mcap");
        let begun = || {
            let mut recording = Recording::begin(&path).unwrap();
            recording.add("/text", 5, &Text { data: "a".to_owned() }).unwrap();
            recording
        };
        drop(begun());
        drop(begun().finish().unwrap());
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 0);
        begun().finish().unwrap().swap_in().unwrap();
        let first = fs::read(&path).unwrap();
        begun().finish().unwrap().swap_in().unwrap();
        assert_eq!(fs::read(&path).unwrap(), first, "the same bytes for the same messages");
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1);
    }

    #[test]
    fn only_a_recording_is_replaced() {
        let home = tempfile::tempdir().unwrap();
        let model = home.path().join("house.ifc");
        fs::write(&model, "ISO-10303-21;").unwrap();
        assert!(matches!(Recording::begin(&model), Err(RecordingError::Foreign { .. })));
        assert!(matches!(Recording::begin(home.path()), Err(RecordingError::Io { .. })));
        assert!(matches!(Recording::begin(&home.path().join("none/film.mcap")), Err(RecordingError::Io { .. })));
        assert_eq!(fs::read(&model).unwrap(), b"ISO-10303-21;");
    }
}
