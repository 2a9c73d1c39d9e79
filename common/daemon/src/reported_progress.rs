//! Tables of reported progress: the one in force, and those before it, to which `groundplan undo progress` goes back.
//!
//! Each table is a numbered file in a folder of the state folder; the one with the highest number is in force. To report is
//! to write another one, to take back is to remove the last: a death at any moment leaves one or the other. Each is kept twice,
//! so that none is lost by the damage or the removal of a file.

use crate::failure::joined;
use crate::kept_file::{KeptFile, records};
use crate::save::Save;
use crate::sealed_file::sealed_content;
use crate::state_files::PROGRESS;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Tables that are kept.
const MAX_TABLES: usize = 20;

/// The tables of a site.
#[derive(Debug, Clone)]
pub struct ReportedProgress {
    state: PathBuf,
    folder: PathBuf,
}

impl ReportedProgress {
    /// Those in a state folder; nothing is made.
    pub fn at(state: &Path) -> Self {
        Self { state: state.to_owned(), folder: state.join(PROGRESS) }
    }

    /// The table in force, and the one before it; the first is missing if nothing was ever reported, the second if nothing
    /// was before.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn tables(&self) -> io::Result<[Option<PathBuf>; 2]> {
        let mut tables = self.numbered()?.into_iter().map(|(_, path)| path).rev();
        Ok([tables.next(), tables.next()])
    }

    /// What tells a table from others: its number, and the first eight bytes of the sha256 of its content in hex.
    pub fn id_of(table: &Path, content: &[u8]) -> String {
        let name = table.file_stem().unwrap_or_default().to_string_lossy();
        let digest: String = Sha256::digest(content).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        format!("{name}-{digest}")
    }

    /// The content of one of the [tables](Self::tables).
    ///
    /// # Errors
    /// A table that is damaged, or the file system refuses.
    pub fn read(table: &Path) -> io::Result<Vec<u8>> {
        sealed_content(table)
    }

    /// Makes the folder, and mends tables that were damaged or removed; for the daemon that writes them, at its start. The answer is
    /// what an operator should know, which is logged too.
    ///
    /// # Errors
    /// The file system refuses.
    pub(crate) fn mend(&self) -> io::Result<Option<String>> {
        fs::create_dir_all(&self.folder)?;
        let recorded = numbers_in(&records(&self.state).join(PROGRESS))?;
        let numbers: BTreeSet<u64> = recorded.into_iter().chain(numbers_in(&self.folder)?).collect();
        let findings: Vec<Option<String>> =
            numbers.into_iter().map(|number| mended(&self.table(number))).collect::<io::Result<_>>()?;
        Ok(joined(findings.into_iter().flatten()))
    }

    /// What puts this table in force: another file, and the removal of the oldest beyond those that are kept; nothing if its content
    /// is in force. With it what tells the table from others.
    ///
    /// # Errors
    /// A table that is damaged, or the file system refuses.
    pub fn adding(&self, table: Vec<u8>) -> io::Result<(String, Vec<Save>)> {
        if let [Some(last), _] = self.tables()?
            && Self::read(&last)? == table
        {
            return Ok((Self::id_of(&last, &table), Vec::new()));
        }
        let numbers = numbers_in(&self.folder)?;
        let next = numbers.last().map_or(1, |number| number + 1);
        let id = Self::id_of(&self.path(next), &table);
        let n_too_many = (numbers.len() + 1).saturating_sub(MAX_TABLES);
        let too_many = numbers.iter().take(n_too_many).map(|number| self.table(*number).removing());
        Ok((id, [self.table(next).saving(table)].into_iter().chain(too_many).collect()))
    }

    /// What puts the table before in force, or none: the removal of the last one, if there is one.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn taking_back(&self) -> io::Result<Option<Save>> {
        Ok(numbers_in(&self.folder)?.last().map(|number| self.table(*number).removing()))
    }

    fn table(&self, number: u64) -> KeptFile {
        KeptFile::at(&self.state, format!("{PROGRESS}/{}", name_of(number)))
    }

    fn path(&self, number: u64) -> PathBuf {
        self.folder.join(name_of(number))
    }

    /// The tables by their numbers, from old to new; one that is there sealed only was removed by somebody else.
    fn numbered(&self) -> io::Result<Vec<(u64, PathBuf)>> {
        Ok(numbers_in(&self.folder)?.into_iter().map(|number| (number, self.path(number))).collect())
    }
}

fn name_of(number: u64) -> String {
    format!("{number:08}.csv")
}

/// Numbers of the tables in a folder, sealed ones too.
fn numbers_in(folder: &Path) -> io::Result<BTreeSet<u64>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(BTreeSet::new()),
        entries => entries?,
    };
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    let number = |path: &Path| {
        let name = path.file_name()?.to_str()?;
        name.strip_suffix(".sealed").unwrap_or(name).strip_suffix(".csv")?.parse::<u64>().ok()
    };
    Ok(paths.iter().filter_map(|path| number(path)).collect())
}

/// Mends a table; what an operator should know of it. One that is damaged is refused where it is read.
pub(crate) fn mended(table: &KeptFile) -> io::Result<Option<String>> {
    match table.load() {
        Err(error) if error.kind() != io::ErrorKind::InvalidData => Err(error),
        _ => Ok(table.finding().map(str::to_owned)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sealed_file::sealed_path;

    fn texts(progress: &ReportedProgress) -> [Option<String>; 2] {
        progress
            .tables()
            .unwrap()
            .map(|path| path.map(|path| String::from_utf8(ReportedProgress::read(&path).unwrap()).unwrap()))
    }

    fn two(last: Option<&str>, before: Option<&str>) -> [Option<String>; 2] {
        [last, before].map(|text| text.map(str::to_owned))
    }

    /// The tables in a state folder, at the start of their daemon.
    fn tables_at(state: &Path) -> ReportedProgress {
        let progress = ReportedProgress::at(state);
        progress.mend().unwrap();
        progress
    }

    fn add(progress: &ReportedProgress, table: &str) {
        progress.adding(table.into()).unwrap().1.iter().try_for_each(Save::write).unwrap();
    }

    fn take_back(progress: &ReportedProgress) {
        progress.taking_back().unwrap().iter().try_for_each(Save::write).unwrap();
    }

    #[test]
    fn what_was_reported_is_taken_back_step_by_step() {
        let state = tempfile::tempdir().unwrap();
        let progress = tables_at(state.path());
        assert_eq!(texts(&progress), [None, None]);
        for text in ["a", "b", "c"] {
            add(&progress, text);
        }
        assert_eq!(texts(&progress), two(Some("c"), Some("b")));
        take_back(&progress);
        assert_eq!(texts(&progress), two(Some("b"), Some("a")));
        add(&progress, "d");
        assert_eq!(texts(&ReportedProgress::at(state.path())), two(Some("d"), Some("b")));
        for _ in 0..4 {
            take_back(&progress);
        }
        assert_eq!(texts(&progress), [None, None]);
    }

    #[test]
    fn a_table_that_comes_twice_is_one_and_has_another_id_than_all_others() {
        let state = tempfile::tempdir().unwrap();
        let progress = tables_at(state.path());
        let ids: Vec<String> = ["a", "a", "b", "a"]
            .into_iter()
            .map(|table| {
                let (id, saves) = progress.adding(table.into()).unwrap();
                saves.iter().try_for_each(Save::write).unwrap();
                id
            })
            .collect();
        let numbers: Vec<&str> = ids.iter().map(|id| &id[..8]).collect();
        assert_eq!(numbers, ["00000001", "00000001", "00000002", "00000003"]);
        assert!(ids[0] == ids[1] && ids[0][8..] == ids[3][8..] && ids[0][8..] != ids[2][8..], "{ids:?}");
    }

    #[test]
    fn a_table_that_is_removed_or_damaged_stays_in_force_and_is_told() {
        let state = tempfile::tempdir().unwrap();
        let progress = tables_at(state.path());
        for text in ["a", "b"] {
            add(&progress, text);
        }
        let table = progress.path(2);
        for damage in [None, Some(""), Some("B")] {
            match damage {
                Some(text) => fs::write(&table, text).unwrap(),
                None => fs::remove_file(&table).unwrap(),
            }
            assert_eq!(texts(&progress), two(Some("b"), Some("a")));
            let why = progress.mend().unwrap().unwrap();
            assert!(why.contains("00000002.csv") && why.contains("stays"), "{why}");
            assert_eq!((fs::read_to_string(&table).unwrap().as_str(), progress.mend().unwrap()), ("b", None));
        }
        fs::write(&table, "B").unwrap();
        fs::write(sealed_path(&table), "sha256").unwrap();
        assert!(ReportedProgress::read(&table).is_err(), "no earlier table is taken for it");
        assert_eq!(progress.mend().unwrap(), None, "it is refused where it is read");
        progress.table(2).save(b"b").unwrap();
        for path in [&table, &sealed_path(&table)] {
            fs::remove_file(path).unwrap();
        }
        let why = progress.mend().unwrap().unwrap();
        assert!(why.contains("00000002.csv") && why.ends_with("is lost"), "{why}");
        assert_eq!((texts(&progress), progress.mend().unwrap()), (two(Some("a"), None), None));
    }

    #[test]
    fn only_the_last_tables_are_kept() {
        let state = tempfile::tempdir().unwrap();
        let progress = tables_at(state.path());
        for number in 0..MAX_TABLES + 3 {
            add(&progress, &number.to_string());
        }
        assert_eq!(progress.numbered().unwrap().len(), MAX_TABLES);
        assert_eq!(texts(&progress)[0], Some((MAX_TABLES + 2).to_string()));
    }
}
