//! Tables of reported progress: the one in force, and those before it, to which `groundplan undo progress` goes back.
//!
//! Each table is a numbered file in a folder of the state folder; the one with the highest number is in force. To report is
//! to write another one, to take back is to remove the last: a death at any moment leaves one or the other.

use crate::replaced_file::write_durably;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Folder of the tables in the state folder.
const FOLDER: &str = "progress";
/// The table of earlier versions, in the state folder.
const OLDER_TABLE: &str = "actuals.csv";
/// Tables that are kept.
const MAX_TABLES: usize = 20;

/// The tables of a site.
#[derive(Debug, Clone)]
pub struct ReportedProgress {
    folder: PathBuf,
    older: PathBuf,
}

impl ReportedProgress {
    /// Those in a state folder; nothing is made.
    pub fn at(state: &Path) -> Self {
        Self { folder: state.join(FOLDER), older: state.join(OLDER_TABLE) }
    }

    /// The table in force, and the one before it; the first is missing if nothing was ever reported, the second if nothing
    /// was before.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn tables(&self) -> io::Result<[Option<PathBuf>; 2]> {
        let mut tables = self.numbered()?.into_iter().map(|(_, path)| path).rev();
        match [tables.next(), tables.next()] {
            // There is no folder of tables before the first report to this version.
            [None, _] => Ok([Some(self.older.clone()).filter(|older| older.is_file()), None]),
            two => Ok(two),
        }
    }

    /// Puts this table in force; it is on disk when this returns.
    ///
    /// # Errors
    /// The file system refuses; the table of before stays.
    pub fn add(&self, table: &[u8]) -> io::Result<()> {
        self.take_over_older()?;
        let numbered = self.numbered()?;
        let next = numbered.last().map_or(1, |(number, _)| number + 1);
        write_durably(&self.path(next), table)?;
        let n_too_many = (numbered.len() + 1).saturating_sub(MAX_TABLES);
        numbered.iter().take(n_too_many).try_for_each(|(_, path)| fs::remove_file(path))
    }

    /// Removes the table in force: the one before is in force, or none.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn take_back(&self) -> io::Result<()> {
        self.take_over_older()?;
        if let Some((_, path)) = self.numbered()?.last() {
            fs::remove_file(path)?;
            File::open(&self.folder)?.sync_all()?;
        }
        Ok(())
    }

    /// The table of an earlier version is the first one.
    fn take_over_older(&self) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        if self.older.is_file() {
            fs::rename(&self.older, self.path(0))?;
        }
        Ok(())
    }

    fn path(&self, number: u64) -> PathBuf {
        self.folder.join(format!("{number:08}.csv"))
    }

    /// The tables by their numbers, from old to new.
    fn numbered(&self) -> io::Result<Vec<(u64, PathBuf)>> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
        let number = |path: &Path| path.file_name()?.to_str()?.strip_suffix(".csv")?.parse().ok();
        let mut numbered: Vec<(u64, PathBuf)> =
            paths.into_iter().filter_map(|path| Some((number(&path)?, path))).collect();
        numbered.sort();
        Ok(numbered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(progress: &ReportedProgress) -> [Option<String>; 2] {
        progress.tables().unwrap().map(|path| path.map(|path| fs::read_to_string(path).unwrap()))
    }

    fn two(last: Option<&str>, before: Option<&str>) -> [Option<String>; 2] {
        [last, before].map(|text| text.map(str::to_owned))
    }

    #[test]
    fn what_was_reported_is_taken_back_step_by_step() {
        let state = tempfile::tempdir().unwrap();
        let progress = ReportedProgress::at(state.path());
        assert_eq!(texts(&progress), [None, None]);
        for text in ["a", "b", "c"] {
            progress.add(text.as_bytes()).unwrap();
        }
        assert_eq!(texts(&progress), two(Some("c"), Some("b")));
        progress.take_back().unwrap();
        assert_eq!(texts(&progress), two(Some("b"), Some("a")));
        progress.add(b"d").unwrap();
        assert_eq!(texts(&ReportedProgress::at(state.path())), two(Some("d"), Some("b")));
        for _ in 0..4 {
            progress.take_back().unwrap();
        }
        assert_eq!(texts(&progress), [None, None]);
    }

    #[test]
    fn only_the_last_tables_are_kept() {
        let state = tempfile::tempdir().unwrap();
        let progress = ReportedProgress::at(state.path());
        for number in 0..MAX_TABLES + 3 {
            progress.add(number.to_string().as_bytes()).unwrap();
        }
        assert_eq!(progress.numbered().unwrap().len(), MAX_TABLES);
        assert_eq!(texts(&progress)[0], Some((MAX_TABLES + 2).to_string()));
    }

    #[test]
    fn the_table_of_an_earlier_version_is_in_force_and_can_be_gone_back_to() {
        let state = tempfile::tempdir().unwrap();
        fs::write(state.path().join(OLDER_TABLE), "old").unwrap();
        let progress = ReportedProgress::at(state.path());
        assert_eq!(texts(&progress), two(Some("old"), None));
        progress.add(b"new").unwrap();
        assert_eq!(texts(&progress), two(Some("new"), Some("old")));
        progress.take_back().unwrap();
        assert_eq!(texts(&progress), two(Some("old"), None));
        progress.take_back().unwrap();
        assert_eq!(texts(&progress), [None, None]);
    }
}
