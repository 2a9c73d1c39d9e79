//! History of a site: who did what when, kept for about a year within a size.
//!
//! A file a month in `history/` of the state folder, and more of them for a busy month: `2026-11.0001.jsonl` ended before
//! `2026-11.jsonl`. A JSON document a line. Every daemon appends to the last file; a line is written at once, so that lines of two
//! daemons do not mix.

use crate::caller::Caller;
use crate::config::SiteConfig;
use crate::robots_config::robot_states;
use crate::state::StateError;
use crate::state_files::HISTORY;
use bus::RobotName;
use clap::ValueEnum;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Months that are kept beside the current one.
const MAX_MONTHS: usize = 12;
/// Bytes that are kept, the current file aside.
const MAX_BYTES: u64 = 64 << 20;
/// Bytes after which a month goes on in another file.
const MAX_FILE_BYTES: u64 = 8 << 20;
/// Bytes that a relay passes on.
const MAX_PASSED_ON_BYTES: usize = 4 << 20;

/// The file that is locked while a file of a month ends.
const LOCK: &str = "lock";

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum HistoryKind {
    /// Another model, or another revision of it: in force, waiting, refused, confirmed or discarded.
    Revision,
    /// The map frame.
    Frame,
    /// The plan time, or how it moves.
    Date,
    /// Reported progress, or observed progress that was applied.
    Progress,
    /// The robot or the resolution.
    Robot,
    /// What waypoints are planned.
    Waypoints,
    /// Rules of the schedule.
    Rules,
    /// A pose of the robot's map: accepted, confirmed, taken back, or withdrawn by a newer map.
    Pose,
    /// Elements that are absent: confirmed or taken back.
    Absence,
    /// Another index of the server that is followed.
    Index,
}

impl std::fmt::Display for HistoryKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Every kind can be named on a command line.
        self.to_possible_value().map_or(Ok(()), |value| f.write_str(value.get_name()))
    }
}

/// An event to be recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryEvent {
    /// What happened.
    pub kind: HistoryKind,
    /// Who asked for it; `None` for what a daemon does by itself.
    pub by: Option<Caller>,
    /// A sentence for people, without a full stop.
    pub summary: String,
}

impl HistoryEvent {
    /// What happened, by whom, in a sentence.
    pub fn new(kind: HistoryKind, by: Option<Caller>, summary: String) -> Self {
        Self { kind, by, summary }
    }
}

/// An event that was recorded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HistoryEntry {
    /// When, in UTC.
    pub at: Timestamp,
    /// What happened.
    pub kind: HistoryKind,
    /// Who asked for it; `None` for what a daemon did by itself.
    pub by: Option<Caller>,
    /// A sentence for people, without a full stop.
    pub summary: String,
    /// The robot with a name whose daemon it was; `None` for what is the site's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
}

/// The history of a site with all its robots: each robot with a name has files of its own, in its own state folder.
#[derive(Debug, Clone)]
pub struct SiteHistory {
    of_site: History,
    of_robots: Vec<(RobotName, History)>,
}

impl SiteHistory {
    /// Of a site and the robots that it has.
    pub fn of(config: &SiteConfig) -> Self {
        let of_robots = robot_states(&config.site_state, &config.robot_names());
        let of_robots = of_robots.into_iter().map(|(robot, state)| (robot, History::at(&state))).collect();
        Self { of_site: History::at(&config.site_state), of_robots }
    }

    /// All entries, from old to new, and the number of lines that are none.
    ///
    /// # Errors
    /// Files that cannot be read.
    pub fn read(&self) -> Result<(Vec<HistoryEntry>, usize), StateError> {
        let (mut entries, mut n_damaged) = self.of_site.read()?;
        for (robot, history) in &self.of_robots {
            let (of_robot, n) = history.read()?;
            entries.extend(of_robot.into_iter().map(|entry| entry.of_robot(*robot)));
            n_damaged += n;
        }
        // What happened at one moment stays in its order.
        entries.sort_by_key(|entry| entry.at);
        Ok((entries, n_damaged))
    }

    /// The newest lines, for a relay to pass on; none where the files cannot be read.
    pub fn newest_lines(&self) -> Vec<u8> {
        if self.of_robots.is_empty() {
            return self.of_site.newest_lines();
        }
        let (entries, _) = self.read().unwrap_or_default();
        let (mut lines, mut n_bytes) = (Vec::new(), 0);
        for entry in entries.iter().rev() {
            let Ok(mut line) = serde_json::to_vec(entry) else { continue };
            line.push(b'\n');
            n_bytes += line.len();
            if n_bytes > MAX_PASSED_ON_BYTES {
                break;
            }
            lines.push(line);
        }
        lines.reverse();
        lines.concat()
    }
}

impl HistoryEntry {
    fn of_robot(self, robot: RobotName) -> Self {
        Self { robot: Some(robot.to_string()), ..self }
    }
}

/// The history of a site, or of a robot with a name.
#[derive(Debug, Clone)]
pub struct History {
    folder: PathBuf,
}

impl History {
    /// The history in a state folder.
    pub fn at(state: &Path) -> Self {
        Self { folder: state.join(HISTORY) }
    }

    /// Appends an event; it is on disk when this returns.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn record(&self, event: HistoryEvent) -> Result<(), StateError> {
        self.record_at(Timestamp::now(), event)
    }

    fn record_at(&self, at: Timestamp, event: HistoryEvent) -> Result<(), StateError> {
        let HistoryEvent { kind, by, summary } = event;
        let month = at.strftime("%Y-%m").to_string();
        let path = self.folder.join(format!("{month}.jsonl"));
        self.append(&path, &HistoryEntry { at, kind, by, summary, robot: None })
            .map_err(|source| StateError::Io { path: path.clone(), source })
    }

    fn append(&self, path: &Path, entry: &HistoryEntry) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        match fs::metadata(path) {
            Ok(file) if file.len() < MAX_FILE_BYTES => {}
            Ok(_) => {
                self.end_file(path)?;
                self.forget_old()?;
            }
            Err(_) => self.forget_old()?,
        }
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(path)?;
        let mut line = serde_json::to_vec(entry)?;
        line.push(b'\n');
        // A power cut may have left half a line.
        if file.seek(SeekFrom::End(-1)).is_ok() {
            let mut last = [0];
            file.read_exact(&mut last)?;
            if last != *b"\n" {
                line.insert(0, b'\n');
            }
        }
        file.write_all(&line)?;
        file.sync_data()
    }

    /// Gives the full file of a month a number, so that another one begins. One daemon does so at a time: two would give one
    /// number twice, and a file would be lost.
    fn end_file(&self, path: &Path) -> io::Result<()> {
        let lock = File::create(self.folder.join(LOCK))?;
        lock.lock()?;
        // Another daemon may have ended it while this one waited.
        let is_full = existing(fs::metadata(path))?.is_some_and(|file| MAX_FILE_BYTES <= file.len());
        let number = (1..).find(|number| !numbered(path, *number).exists()).unwrap_or(1);
        let ended = if is_full { fs::rename(path, numbered(path, number)) } else { Ok(()) };
        // Closing is not enough: a process that was forked meanwhile has the file open until it becomes another program.
        lock.unlock().and(ended)
    }

    /// Removes the oldest files, before another one begins; the newest of them stays. Another daemon may do it at this moment.
    fn forget_old(&self) -> io::Result<()> {
        let (mut months, mut n_bytes) = (BTreeSet::new(), 0);
        for (age, path) in self.files()?.into_iter().rev().enumerate() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            months.insert(name.chars().take("2026-11".len()).collect::<String>());
            n_bytes += existing(fs::metadata(&path))?.map_or(0, |file| file.len());
            if age > 0 && (months.len() > MAX_MONTHS || n_bytes > MAX_BYTES) {
                existing(fs::remove_file(&path))?;
            }
        }
        Ok(())
    }

    /// Files, from old to new: a numbered one sorts before the last one of its month.
    fn files(&self) -> io::Result<Vec<PathBuf>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "jsonl"));
        paths.sort();
        Ok(paths)
    }

    /// All entries, from old to new, and the number of lines that are none.
    ///
    /// # Errors
    /// Files that cannot be read.
    pub fn read(&self) -> Result<(Vec<HistoryEntry>, usize), StateError> {
        let failed = |path: &Path, source| StateError::Io { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        for path in self.files().map_err(|source| failed(&self.folder, source))? {
            bytes.extend(fs::read(&path).map_err(|source| failed(&path, source))?);
            bytes.push(b'\n');
        }
        Ok(parse_history(&bytes))
    }

    /// The newest lines, for a relay to pass on; none where the files cannot be read.
    pub fn newest_lines(&self) -> Vec<u8> {
        let (mut files, mut n_bytes) = (Vec::new(), 0);
        for path in self.files().unwrap_or_default().into_iter().rev() {
            let bytes = fs::read(path).unwrap_or_default();
            n_bytes += bytes.len() + 1;
            files.push(bytes);
            if n_bytes >= MAX_PASSED_ON_BYTES {
                break;
            }
        }
        files.reverse();
        let all = files.join(&b'\n');
        let from = all.len().saturating_sub(MAX_PASSED_ON_BYTES);
        // Half a line is none.
        let begin = if from == 0 {
            0
        } else {
            all[from..].iter().position(|byte| *byte == b'\n').map_or(all.len(), |n| from + n)
        };
        all[begin..].to_vec()
    }
}

/// Entries of lines, from old to new, and the number of lines that are none.
pub fn parse_history(lines: &[u8]) -> (Vec<HistoryEntry>, usize) {
    let (mut entries, mut n_damaged) = (Vec::new(), 0);
    for line in lines.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
        match serde_json::from_slice(line) {
            Ok(entry) => entries.push(entry),
            Err(_) => n_damaged += 1,
        }
    }
    (entries, n_damaged)
}

fn numbered(path: &Path, number: u32) -> PathBuf {
    path.with_extension(format!("{number:04}.jsonl"))
}

/// `None` for a file that is gone.
fn existing<T>(found: io::Result<T>) -> io::Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(summary: &str) -> HistoryEvent {
        HistoryEvent { kind: HistoryKind::Date, by: Some(Caller { uid: 7 }), summary: summary.to_owned() }
    }

    #[test]
    fn what_was_recorded_is_read_in_its_order_and_half_a_line_costs_nothing_else() {
        let state = tempfile::tempdir().unwrap();
        let history = History::at(state.path());
        assert_eq!(history.read().unwrap(), (Vec::new(), 0));
        history.record(event("first")).unwrap();
        let path = history.files().unwrap().remove(0);
        let half = OpenOptions::new().append(true).open(path).unwrap().write(b"{\"at\":").unwrap();
        assert_eq!(half, 6);
        history.record(event("second")).unwrap();
        let (entries, n_damaged) = history.read().unwrap();
        let summaries: Vec<_> = entries.iter().map(|entry| entry.summary.as_str()).collect();
        assert_eq!((summaries.as_slice(), n_damaged), (&["first", "second"][..], 1));
        assert_eq!(entries[0].by, Some(Caller { uid: 7 }));
        assert_eq!(parse_history(&history.newest_lines()), (entries, 1));
    }

    #[test]
    fn a_busy_month_goes_on_in_another_file_and_the_newest_of_it_stay() {
        let state = tempfile::tempdir().unwrap();
        let history = History::at(state.path());
        let at = |month: &str, summary: &str| {
            history.record_at(format!("{month}-01T00:00:00Z").parse().unwrap(), event(summary)).unwrap();
        };
        let n_files = usize::try_from(MAX_BYTES / MAX_FILE_BYTES).unwrap() + 2;
        for n in 0..n_files {
            at("2026-11", &n.to_string());
            // As after very many lines.
            let file = OpenOptions::new().write(true).open(history.files().unwrap().pop().unwrap()).unwrap();
            file.set_len(MAX_FILE_BYTES).unwrap();
        }
        at("2026-12", "next month");
        let (entries, _) = history.read().unwrap();
        let first: usize = entries[0].summary.parse().unwrap();
        assert!(first > 0 && entries.len() == n_files - first + 1, "{} from {first}", entries.len());
        assert_eq!(entries.last().unwrap().summary, "next month");
        let (newest, _) = parse_history(&history.newest_lines());
        assert!(!newest.is_empty() && entries.ends_with(&newest), "{newest:?}");
        assert!(entries.iter().any(|entry| entry.summary == (n_files - 1).to_string()), "the newest stay");
    }

    #[test]
    fn daemons_that_end_a_file_at_once_lose_nothing() {
        const DAEMONS: usize = 4;
        for _ in 0..50 {
            let state = tempfile::tempdir().unwrap();
            let history = History::at(state.path());
            history.record(event("before")).unwrap();
            let file = OpenOptions::new().write(true).open(history.files().unwrap().pop().unwrap()).unwrap();
            file.set_len(MAX_FILE_BYTES).unwrap();
            let at_once = std::sync::Barrier::new(DAEMONS);
            std::thread::scope(|scope| {
                for daemon in 0..DAEMONS {
                    let (history, at_once) = (&history, &at_once);
                    scope.spawn(move || {
                        at_once.wait();
                        history.record(event(&daemon.to_string())).unwrap();
                    });
                }
            });
            let (entries, _) = history.read().unwrap();
            let summaries: BTreeSet<_> = entries.into_iter().map(|entry| entry.summary).collect();
            assert_eq!(summaries, ["0", "1", "2", "3", "before"].map(str::to_owned).into());
        }
    }

    #[test]
    fn a_year_is_kept() {
        let state = tempfile::tempdir().unwrap();
        let history = History::at(state.path());
        for month in 0..15 {
            let at = format!("{}-{:02}-01T00:00:00Z", 2024 + month / 12, month % 12 + 1);
            history.record_at(at.parse().unwrap(), event(&at)).unwrap();
        }
        let (entries, _) = history.read().unwrap();
        assert_eq!((entries.len(), entries[0].summary.as_str()), (13, "2024-03-01T00:00:00Z"));
    }
}
