//! An output folder that appears whole or not at all, and never at the expense of files of others.
//!
//! A folder is replaced only if its manifest says that groundplan wrote it. Of a replaced folder, only files are
//! deleted that this manifest lists and that still have the listed content; everything else is a reason to refuse, or
//! is moved to a folder beside the output.

mod inspection;

pub use inspection::ForeignFiles;

use crate::input::ExportFile;
use inspection::{MANIFEST, inspect, listed_files, manifest_bytes};
use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file in a folder that is being written; a folder beside an output that has it can be deleted by a later run.
const UNFINISHED: &str = ".groundplan-unfinished";
/// Folders beside an output that take files of others.
const MAX_KEPT_FOLDERS: u32 = 10_000;

/// Why an output folder could not be written. What stood there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Something else stands there.
    #[error("{} is no output folder of groundplan (it has no manifest.json of groundplan) and is not empty: choose another", path.display())]
    Foreign {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// Earlier output, with files that groundplan did not write.
    #[error("{} holds files that groundplan did not write, or that were altered since: {files}; move them away, or give --force to have them moved beside the folder", path.display())]
    Altered {
        /// The path that was asked for.
        path: PathBuf,
        /// The files.
        files: ForeignFiles,
    },
    /// A file stands there, or on the way.
    #[error("{} cannot be an output folder, because a file stands there: choose another", path.display())]
    File {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// A folder that cannot be swapped.
    #[error("{} cannot be swapped, because it is a mount point: choose a folder inside it", path.display())]
    MountPoint {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("{} cannot be read or written", path.display())]
    Io {
        /// What was being read or written.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// What becomes of files in earlier output that were added or altered since it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForeignFilePolicy {
    /// The folder is refused.
    Refuse,
    /// They are moved to a folder beside the output.
    SetAside,
}

/// Files that groundplan did not write and that stood in the way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetAside {
    /// The folder beside the output in which they are now.
    pub folder: PathBuf,
    /// Their names.
    pub files: ForeignFiles,
}

/// A place for output, known to be free or to hold earlier output.
#[derive(Debug)]
pub struct OutputFolder {
    /// Without links, if it exists: a swap replaces the folder, not a link to it.
    path: PathBuf,
}

impl OutputFolder {
    /// Inspects the place, writes nothing.
    ///
    /// # Errors
    /// A file, a folder that holds something else than output of groundplan, or output to which files were added or in which
    /// files were altered, unless these are set aside.
    pub fn at(path: &Path, policy: ForeignFilePolicy) -> Result<Self, OutputError> {
        let asked = || path.to_owned();
        let mut entries = match fs::read_dir(path) {
            Ok(entries) => entries,
            // A dangling link is a foreign file, too.
            Err(error) if error.kind() == io::ErrorKind::NotFound && !path.is_symlink() => {
                return Ok(Self { path: asked() });
            }
            Err(error) if [io::ErrorKind::NotADirectory, io::ErrorKind::NotFound].contains(&error.kind()) => {
                return Err(OutputError::File { path: asked() });
            }
            Err(source) => return Err(OutputError::Io { path: asked(), source }),
        };
        if entries.next().is_some() {
            let listed = listed_files(path).ok_or_else(|| OutputError::Foreign { path: asked() })?;
            let files = inspect(path, Some(&listed)).map_err(at(path))?.foreign;
            if policy == ForeignFilePolicy::Refuse && !files.is_empty() {
                return Err(OutputError::Altered { path: asked(), files });
            }
        }
        let path = fs::canonicalize(path).map_err(at(path))?;
        Ok(Self { path })
    }

    /// Writes the files beside the place, then swaps: no file of an earlier run remains, no half folder is ever seen.
    ///
    /// Returns the foreign files that were set aside.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn replace(&self, files: &[ExportFile]) -> Result<Option<SetAside>, OutputError> {
        let mut beside = self.begin()?;
        beside.write("", files)?;
        beside.swap_in()
    }

    /// Begins a folder beside the place, for output that is made piece by piece.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn begin(&self) -> Result<FolderBeside<'_>, OutputError> {
        let parent = self.parent();
        fs::create_dir_all(parent).map_err(at(parent))?;
        let path = parent.join(format!(".{}.new-{}", self.name(), std::process::id()));
        // A killed run with this process id, common in containers, may have left something.
        if path.join(UNFINISHED).is_file() {
            fs::remove_dir_all(&path).map_err(at(&self.path))?;
        } else {
            self.discard(&path);
        }
        fs::create_dir(&path).map_err(at(&self.path))?;
        let folders = BTreeSet::from([path.clone()]);
        let beside = FolderBeside { place: self, path, folders, files: Vec::new(), is_swapped: false };
        let mark = beside.path.join(UNFINISHED);
        File::create(&mark).map_err(at(&self.path))?;
        Ok(beside)
    }

    /// True if the folder holds these files, all with this content. Others may be in it.
    pub fn holds(path: &Path, files: &[ExportFile]) -> bool {
        let manifest = files.iter().find(|f| f.path == MANIFEST);
        let is_same = manifest.is_some_and(|m| manifest_bytes(path).is_some_and(|bytes| bytes == m.bytes));
        let listed = listed_files(path).filter(|_| is_same);
        listed.is_some_and(|l| inspect(path, Some(&l)).is_ok_and(|found| found.own.len() == files.len()))
    }

    /// Deletes output in which nothing was added or altered.
    ///
    /// # Errors
    /// Anything else; then nothing is deleted.
    pub fn delete(path: &Path) -> Result<(), OutputError> {
        let listed = listed_files(path).ok_or_else(|| OutputError::Foreign { path: path.to_owned() })?;
        let found = inspect(path, Some(&listed)).map_err(at(path))?;
        if !found.foreign.is_empty() {
            return Err(OutputError::Altered { path: path.to_owned(), files: found.foreign });
        }
        inspection::delete(path, &found);
        Ok(())
    }

    /// Deletes what groundplan wrote in a folder beside the place; what remains is moved to a folder of its own.
    fn discard(&self, old: &Path) -> Option<SetAside> {
        // A file may have been added or altered while the new output was made: it is inspected again.
        if let Some(listed) = listed_files(old)
            && let Ok(found) = inspect(old, Some(&listed))
        {
            inspection::delete(old, &found);
            if !found.foreign.is_empty() {
                return Some(SetAside { folder: self.keep(old), files: found.foreign });
            }
        }
        let is_gone = fs::remove_dir(old).map_or_else(|e| e.kind() == io::ErrorKind::NotFound, |()| true);
        if is_gone {
            return None;
        }
        let files = inspect(old, None).map(|found| found.foreign).unwrap_or_default();
        Some(SetAside { folder: self.keep(old), files })
    }

    /// Gives a folder beside the place a name that people see: `out.kept-1`. The folder then; it may stay where it is.
    fn keep(&self, old: &Path) -> PathBuf {
        for number in 1..MAX_KEPT_FOLDERS {
            let kept = self.parent().join(format!("{}.kept-{number}", self.name()));
            if fs::symlink_metadata(&kept).is_err() && fs::rename(old, &kept).is_ok() {
                return kept;
            }
        }
        old.to_owned()
    }

    fn parent(&self) -> &Path {
        match self.path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        }
    }

    fn name(&self) -> String {
        self.path.file_name().map_or_else(|| "out".to_owned(), |name| name.to_string_lossy().into_owned())
    }
}

/// Output in the making; gone with this value unless it is swapped in.
#[derive(Debug)]
pub struct FolderBeside<'a> {
    place: &'a OutputFolder,
    path: PathBuf,
    /// Those that were made in it, itself among them.
    folders: BTreeSet<PathBuf>,
    /// The files that were written.
    files: Vec<PathBuf>,
    is_swapped: bool,
}

impl FolderBeside<'_> {
    /// Writes files into a folder of the output; `""` is the output itself.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn write(&mut self, folder: &str, files: &[ExportFile]) -> Result<(), OutputError> {
        let folder = self.path.join(folder);
        let written = files.iter().try_for_each(|file| self.write_file(&folder.join(&file.path), &file.bytes));
        written.map_err(|error| self.at_its_place(error))
    }

    /// An error names the place that was asked for, which people know, in place of the folder beside it.
    fn at_its_place(&self, error: OutputError) -> OutputError {
        match error {
            OutputError::Io { path, source } => {
                let path =
                    path.strip_prefix(&self.path).map_or_else(|_| path.clone(), |rest| self.place.path.join(rest));
                OutputError::Io { path, source }
            }
            other => other,
        }
    }

    fn write_file(&mut self, path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
        for folder in path.ancestors().skip(1).take_while(|folder| folder.starts_with(&self.path)) {
            if !self.folders.contains(folder) {
                fs::create_dir_all(folder).map_err(at(folder))?;
                self.folders.insert(folder.to_owned());
            }
        }
        let mut out = File::create(path).map_err(at(path))?;
        out.write_all(bytes).map_err(at(path))?;
        self.files.push(path.to_owned());
        Ok(())
    }

    /// Swaps the output with what stands at its place. Returns the foreign files that were there.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn swap_in(mut self) -> Result<Option<SetAside>, OutputError> {
        let mark = self.path.join(UNFINISHED);
        fs::remove_file(&mark).map_err(at(&self.place.path))?;
        // All files together; then what is in a folder first, and its name in the one above.
        let synced = self.files.iter().chain(self.folders.iter().rev()).try_for_each(|path| sync(path));
        synced.map_err(|error| self.at_its_place(error))?;
        swap(&self.path, &self.place.path)?;
        self.is_swapped = true;
        sync(self.place.parent())?;
        Ok(self.place.discard(&self.path))
    }
}

impl Drop for FolderBeside<'_> {
    fn drop(&mut self) {
        if !self.is_swapped {
            // What a failure left. Best effort: the error that matters is the one at hand.
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    move |source| OutputError::Io { path, source }
}

/// Makes the bytes of a file, or the names in a folder, survive a power cut.
fn sync(path: &Path) -> Result<(), OutputError> {
    File::open(path).and_then(|f| f.sync_all()).map_err(at(path))
}

/// Puts `new` in the place of `path`, and what stood there in the place of `new`.
fn swap(new: &Path, path: &Path) -> Result<(), OutputError> {
    if !path.exists() {
        return fs::rename(new, path).map_err(at(path));
    }
    match renameat_with(CWD, new, CWD, path, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(()),
        Err(Errno::BUSY | Errno::XDEV) => Err(OutputError::MountPoint { path: path.to_owned() }),
        // Some file systems cannot exchange, e.g. NFS: two renames, with a moment in between.
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => swap_in_two_steps(new, path),
        Err(error) => Err(at(path)(error.into())),
    }
}

fn swap_in_two_steps(new: &Path, path: &Path) -> Result<(), OutputError> {
    let old = new.with_extension("old");
    fs::rename(path, &old).map_err(at(path))?;
    if let Err(error) = fs::rename(new, path) {
        fs::rename(&old, path).map_err(at(path))?;
        return Err(at(path)(error));
    }
    fs::rename(&old, new).map_err(at(&old))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::with_manifest;
    use serde_json::json;

    /// Output as groundplan writes it, with these files.
    fn output(names: &[&str]) -> Vec<ExportFile> {
        with_manifest(json!({}), names.iter().map(|n| ExportFile::new(*n, *n)).collect())
    }

    fn write(out: &Path, names: &[&str]) {
        place(out).replace(&output(names)).unwrap();
    }

    fn place(out: &Path) -> OutputFolder {
        OutputFolder::at(out, ForeignFilePolicy::Refuse).unwrap()
    }

    fn n_entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    /// The names in a refusal of earlier output.
    fn refusal(out: &Path) -> String {
        match OutputFolder::at(out, ForeignFilePolicy::Refuse) {
            Err(OutputError::Altered { files, .. }) => files.to_string(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_second_run_leaves_nothing_of_the_first() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("deep/out");
        write(&out, &["a/old.pgm"]);
        write(&out, &["a/new.pgm"]);
        assert!(out.join("a/new.pgm").exists() && !out.join("a/old.pgm").exists());
        assert_eq!((n_entries(&out), n_entries(out.parent().unwrap())), (2, 1), "nothing is left inside or beside");
    }

    #[test]
    fn two_renames_do_what_an_exchange_does() {
        let home = tempfile::tempdir().unwrap();
        let (new, out) = (home.path().join(".out.new-1"), home.path().join("out"));
        fs::create_dir(&new).unwrap();
        fs::create_dir(&out).unwrap();
        fs::write(new.join("a"), "").unwrap();
        swap_in_two_steps(&new, &out).unwrap();
        assert!(out.join("a").exists() && new.is_dir() && n_entries(home.path()) == 2);
    }

    #[test]
    fn a_folder_without_a_manifest_of_groundplan_is_refused_even_by_force() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path();
        let check = |manifest: &[u8]| {
            fs::write(out.join("manifest.json"), manifest).unwrap();
            for policy in [ForeignFilePolicy::Refuse, ForeignFilePolicy::SetAside] {
                let refused = OutputFolder::at(out, policy);
                assert!(matches!(refused, Err(OutputError::Foreign { .. })), "{}", String::from_utf8_lossy(manifest));
            }
        };
        let text = format!("{:#}", json!({"tool": "groundplan", "files": {}}));
        check(br#"{"name": "a web site"}"#);
        check(b"{\n  // icons\n  \"tool\": \"groundplan\"\n}");
        check(format!("\u{feff}{text}").as_bytes());
        check(text.trim_end_matches('}').as_bytes());
        check(br#"{"tool": "groundplan", "files": ["a"]}"#);
        check(b"");
        fs::remove_file(out.join("manifest.json")).unwrap();
        fs::write(out.join("real.json"), &text).unwrap();
        std::os::unix::fs::symlink("real.json", out.join("manifest.json")).unwrap();
        assert!(matches!(OutputFolder::at(out, ForeignFilePolicy::SetAside), Err(OutputError::Foreign { .. })));
        fs::remove_file(out.join("manifest.json")).unwrap();
        fs::create_dir(out.join("manifest.json")).unwrap();
        assert!(matches!(OutputFolder::at(out, ForeignFilePolicy::SetAside), Err(OutputError::Foreign { .. })));
    }

    #[test]
    fn a_file_or_a_link_to_nowhere_is_refused() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("thesis.tex"), "precious").unwrap();
        std::os::unix::fs::symlink("nowhere", home.path().join("link")).unwrap();
        for at in ["thesis.tex", "thesis.tex/out", "link"] {
            let refused = OutputFolder::at(&home.path().join(at), ForeignFilePolicy::SetAside);
            assert!(matches!(refused, Err(OutputError::File { .. })), "{at}");
        }
    }

    #[test]
    fn output_to_which_files_were_added_or_in_which_they_were_altered_is_refused_with_their_names() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        write(&out, &["a.json", "storeys/00/planning.pgm", "storeys/00/planning.yaml"]);
        fs::write(out.join("storeys/00/planning.pgm"), "touched up").unwrap();
        fs::write(out.join("storeys/00/slam.pgm"), "a day of mapping").unwrap();
        fs::write(out.join("notes.txt"), "precious").unwrap();
        fs::create_dir_all(out.join("photos/may")).unwrap();
        std::os::unix::fs::symlink("/", out.join("root")).unwrap();
        fs::remove_file(out.join("a.json")).unwrap();
        std::os::unix::fs::symlink("notes.txt", out.join("a.json")).unwrap();
        let names = "a.json (altered), notes.txt (added), photos/may/ (added), root (added), \
                     storeys/00/planning.pgm (altered), storeys/00/slam.pgm (added)";
        assert_eq!(refusal(&out), names);
        (0..20).for_each(|k| fs::write(out.join(format!("b{k:02}")), "").unwrap());
        assert!(refusal(&out).ends_with("b06 (added) and 18 more"), "{}", refusal(&out));
    }

    #[test]
    fn files_that_are_gone_are_no_reason_to_refuse() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        write(&out, &["a.json", "storeys/00/planning.pgm"]);
        fs::remove_file(out.join("storeys/00/planning.pgm")).unwrap();
        write(&out, &["b.json"]);
        assert_eq!((n_entries(&out), n_entries(home.path())), (2, 1));
    }

    #[test]
    fn force_moves_files_of_others_beside_the_output_and_deletes_none() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        for number in [1, 2] {
            write(&out, &["a.json", "storeys/00/planning.pgm"]);
            fs::write(out.join("notes.txt"), "precious").unwrap();
            fs::write(out.join("storeys/00/planning.pgm"), "touched up").unwrap();
            let place = OutputFolder::at(&out, ForeignFilePolicy::SetAside).unwrap();
            let set_aside = place.replace(&output(&["b.json"])).unwrap().unwrap();
            let kept = home.path().join(format!("out.kept-{number}"));
            assert_eq!(set_aside.folder, fs::canonicalize(&kept).unwrap());
            assert_eq!(set_aside.files.to_string(), "notes.txt (added), storeys/00/planning.pgm (altered)");
            assert_eq!(fs::read_to_string(kept.join("storeys/00/planning.pgm")).unwrap(), "touched up");
            assert_eq!((n_entries(&kept), n_entries(&out)), (2, 2), "the rest is gone");
        }
    }

    #[test]
    fn a_file_that_is_added_while_the_output_is_made_is_set_aside() {
        let home = tempfile::tempdir().unwrap();
        // A folder with earlier output, an empty one, and none.
        let outs = ["written", "empty", "new"].map(|name| home.path().join(name));
        write(&outs[0], &["a.json"]);
        fs::create_dir(&outs[1]).unwrap();
        for out in outs {
            let place = place(&out);
            let mut beside = place.begin().unwrap();
            beside.write("", &output(&["a.json"])).unwrap();
            fs::create_dir_all(&out).unwrap();
            fs::write(out.join("notes.txt"), "precious").unwrap();
            let set_aside = beside.swap_in().unwrap().unwrap();
            assert_eq!(set_aside.files.to_string(), "notes.txt (added)");
            assert_eq!(fs::read_to_string(set_aside.folder.join("notes.txt")).unwrap(), "precious");
            assert_eq!((n_entries(&set_aside.folder), n_entries(&out)), (1, 2));
        }
    }

    #[test]
    fn errors_name_the_place_that_was_asked_for() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        let place = place(&out);
        let mut beside = place.begin().unwrap();
        // A file stands where a folder of the output has to be.
        beside.write("", &output(&["storeys"])).unwrap();
        let error = beside.write("storeys", &output(&["a.json"])).unwrap_err();
        assert!(error.to_string().starts_with(&out.join("storeys").display().to_string()), "{error}");
    }

    #[test]
    fn what_a_killed_run_left_is_deleted_only_if_groundplan_wrote_it() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        let beside = home.path().join(format!(".out.new-{}", std::process::id()));
        fs::create_dir(&beside).unwrap();
        fs::write(beside.join(UNFINISHED), "").unwrap();
        fs::write(beside.join("half.pgm"), "P5").unwrap();
        write(&out, &["a.json"]);
        assert_eq!(n_entries(home.path()), 1);
        // Killed between the swap and the deletion of what stood there.
        fs::create_dir(&beside).unwrap();
        fs::write(beside.join("notes.txt"), "precious").unwrap();
        write(&out, &["a.json"]);
        assert_eq!(fs::read_to_string(home.path().join("out.kept-1/notes.txt")).unwrap(), "precious");
    }

    #[test]
    fn output_is_deleted_only_as_it_was_written() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("7");
        let files = output(&["a.json", "storeys/00/planning.pgm"]);
        place(&out).replace(&files).unwrap();
        assert!(OutputFolder::holds(&out, &files) && !OutputFolder::holds(&out, &output(&["a.json"])));
        fs::write(out.join("notes.txt"), "precious").unwrap();
        assert!(OutputFolder::holds(&out, &files));
        assert!(matches!(OutputFolder::delete(&out), Err(OutputError::Altered { .. })));
        assert!(matches!(OutputFolder::delete(home.path()), Err(OutputError::Foreign { .. })));
        assert_eq!(n_entries(&out), 4);
        fs::remove_file(out.join("notes.txt")).unwrap();
        OutputFolder::delete(&out).unwrap();
        assert_eq!(n_entries(home.path()), 0);
    }

    #[test]
    fn a_manifest_that_is_a_pipe_is_not_waited_for_and_nothing_is_deleted() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("7");
        let files = output(&["a.json"]);
        place(&out).replace(&files).unwrap();
        fs::remove_file(out.join(MANIFEST)).unwrap();
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, out.join(MANIFEST), rustix::fs::FileType::Fifo, mode, 0).unwrap();
        assert!(!OutputFolder::holds(&out, &files));
        assert!(matches!(OutputFolder::at(&out, ForeignFilePolicy::SetAside), Err(OutputError::Foreign { .. })));
        assert!(matches!(OutputFolder::delete(&out), Err(OutputError::Foreign { .. })));
        assert_eq!(n_entries(&out), 2);
    }

    #[test]
    fn the_folder_behind_a_link_is_replaced_and_the_link_stays() {
        let home = tempfile::tempdir().unwrap();
        let (real, link) = (home.path().join("real"), home.path().join("link"));
        fs::create_dir(&real).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write(&link, &[]);
        assert!(link.is_symlink() && real.join("manifest.json").is_file());
    }

    #[test]
    fn a_failed_write_leaves_the_earlier_output() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        write(&out, &["a.json"]);
        // A file where a folder is needed makes the write fail half way.
        assert!(place(&out).replace(&output(&["storeys", "storeys/x.pgm"])).is_err());
        assert_eq!(fs::read_to_string(out.join("a.json")).unwrap(), "a.json");
        assert_eq!(n_entries(home.path()), 1, "nothing is left beside");
    }
}
