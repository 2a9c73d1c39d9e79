//! Schedule files of the site: watched, read again when they change, and kept with their contents.
//!
//! What is in force is kept in the state folder: a file that is removed or spoilt later changes nothing, and is a warning.

use daemon::state_files::SCHEDULE_FILES;
use daemon::{
    Failure, FileStamp, FileWatch, KeptFile, MachineTime, Save, SiteConfig, WholeFiles, chain, joined, stamps_of,
};
use jiff::Timestamp;
use schedule::Rules;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tasks::{MAX_SCHEDULE_FILE_BYTES, ScheduleFile, TableLink, parse_link_table};

/// The layout of that file, with which it begins: what follows names nothing.
const LAYOUT: u32 = 1;

/// Names and bytes of the files in force.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Contents {
    files: Vec<(String, Vec<u8>)>,
    table: Option<Vec<u8>>,
}

/// What the files in force hold.
#[derive(Debug, Default)]
pub(crate) struct Plans {
    pub(crate) files: Vec<ScheduleFile>,
    pub(crate) table: Vec<TableLink>,
}

/// Which files are named, and how they look on disk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Named {
    files: Vec<PathBuf>,
    links: Option<PathBuf>,
}

/// The schedule files of the site.
#[derive(Clone)]
pub(crate) struct ScheduleFiles {
    named: Named,
    /// How the files looked when they were read last.
    read_as: Vec<Option<FileStamp>>,
    /// Files that changed, until they are whole.
    watch: FileWatch,
    contents: Arc<Contents>,
    plans: Arc<Plans>,
    since: Timestamp,
    warning: Option<String>,
    kept: KeptFile,
}

impl ScheduleFiles {
    /// The files that the configuration names; what was in force before stands in for those that cannot be used.
    ///
    /// # Errors
    /// Files that cannot be used and were not in force before.
    pub(crate) fn open(config: &SiteConfig, rules: &Rules) -> Result<Self, Failure> {
        let kept = KeptFile::at(&config.state, SCHEDULE_FILES);
        let named = Named::of(config);
        let mut watch = FileWatch::new(MAX_SCHEDULE_FILE_BYTES);
        let read_as = stamps_of(&named.paths());
        let read = named.read(&mut watch).and_then(|(stamps, contents)| Ok((stamps, contents.plans(rules)?, contents)));
        let mut files = Self {
            read_as,
            watch,
            contents: Arc::default(),
            plans: Arc::default(),
            since: Timestamp::now(),
            warning: None,
            kept,
            named,
        };
        match read {
            Ok((stamps, plans, contents)) => {
                files.read_as = stamps;
                files.take(plans, contents)?.iter().try_for_each(Save::write)?;
            }
            Err(why) => {
                let earlier = read_kept(&files.kept)?.filter(|contents| contents.names() == files.named.names());
                let Some(contents) = earlier else { return Err(why) };
                files.plans = Arc::new(contents.plans(rules)?);
                files.contents = Arc::new(contents);
                let finding = files.kept.finding().map(str::to_owned);
                files.warning = joined([stays(why.as_ref())].into_iter().chain(finding));
            }
        }
        Ok(files)
    }

    /// Takes another configuration or other rules.
    ///
    /// # Errors
    /// Files that cannot be used.
    pub(crate) fn configure(&mut self, config: &SiteConfig, rules: &Rules) -> Result<Option<Save>, Failure> {
        let named = Named::of(config);
        let is_read = named == self.named && stamps_of(&named.paths()) == self.read_as;
        let (stamps, contents) = if is_read {
            (self.read_as.clone(), Contents::clone(&self.contents))
        } else {
            named.read(&mut self.watch)?
        };
        let plans = contents.plans(rules)?;
        let save = self.take(plans, contents)?;
        (self.named, self.read_as) = (named, stamps);
        Ok(save)
    }

    /// Looks whether the files have changed, and reads them again once they are whole. What is to be saved, if what they hold is new.
    ///
    /// # Errors
    /// Contents that cannot be kept.
    pub(crate) fn look(&mut self, rules: &Rules, now: MachineTime) -> Result<Option<Save>, Failure> {
        let paths = self.named.paths();
        if stamps_of(&paths) == self.read_as {
            return Ok(None);
        }
        let Some(whole) = self.watch.look(&paths, now) else { return Ok(None) };
        self.read_as = whole.as_ref().map_or_else(|_| stamps_of(&paths), |whole| whole.stamps.clone());
        let read = whole.map(|whole| self.named.contents(whole));
        match read.and_then(|contents| Ok((contents.plans(rules)?, contents))) {
            Ok((_, contents)) if contents == *self.contents => self.warning = None,
            Ok((plans, contents)) => return self.take(plans, contents),
            Err(why) => self.warning = Some(stays(why.as_ref())),
        }
        Ok(None)
    }

    /// What the files in force hold.
    pub(crate) fn plans(&self) -> &Plans {
        &self.plans
    }

    /// Why the files on disk are not in force.
    pub(crate) fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Names of the files in force, for people; `None` without any.
    pub(crate) fn names(&self) -> Option<String> {
        (!self.contents.files.is_empty()).then(|| self.contents.names().join(", "))
    }

    /// Since when they are in force.
    pub(crate) fn since(&self) -> Timestamp {
        self.since
    }

    /// What is to be saved before this is in force.
    fn take(&mut self, plans: Plans, contents: Contents) -> Result<Option<Save>, Failure> {
        let mut save = None;
        if contents != *self.contents || contents.files.is_empty() {
            save = Some(saving(&self.kept, &contents)?);
            self.since = Timestamp::now();
        }
        (self.plans, self.contents, self.warning) = (Arc::new(plans), Arc::new(contents), None);
        Ok(save)
    }
}

fn stays(why: &(dyn std::error::Error + 'static)) -> String {
    format!("the schedule stays that of before: {}", chain(why))
}

impl Named {
    fn of(config: &SiteConfig) -> Self {
        Self { files: config.schedule.files.clone(), links: config.schedule.links.clone() }
    }

    /// The files, and behind them the table of links.
    fn paths(&self) -> Vec<PathBuf> {
        self.files.iter().chain(&self.links).cloned().collect()
    }

    fn names(&self) -> Vec<String> {
        self.files.iter().map(|path| name_of(path)).collect()
    }

    /// Reads the files once they are whole.
    fn read(&self, watch: &mut FileWatch) -> Result<(Vec<Option<FileStamp>>, Contents), Failure> {
        let whole = watch.wait(&self.paths(), || {})?;
        Ok((whole.stamps.clone(), self.contents(whole)))
    }

    fn contents(&self, whole: WholeFiles) -> Contents {
        let mut bytes = whole.contents.into_iter();
        let names = self.files.iter().map(|path| name_of(path));
        let files = names.zip(bytes.by_ref()).collect();
        Contents { files, table: bytes.next() }
    }
}

impl Contents {
    fn plans(&self, rules: &Rules) -> Result<Plans, Failure> {
        let file = |(name, bytes): &(String, Vec<u8>)| ScheduleFile::read(name, bytes, &rules.reading);
        let files = self.files.iter().map(file).collect::<Result<_, _>>()?;
        let table = self.table.as_deref().map_or(Ok(Vec::new()), parse_link_table)?;
        Ok(Plans { files, table })
    }

    fn names(&self) -> Vec<String> {
        self.files.iter().map(|(name, _)| name.clone()).collect()
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn read_kept(kept: &KeptFile) -> Result<Option<Contents>, Failure> {
    let path = kept.path();
    let bytes = kept.load().map_err(|e| format!("{} cannot be read: {e}", path.display()))?;
    let parsed = |bytes: &[u8]| match postcard::take_from_bytes::<u32>(bytes) {
        Ok((LAYOUT, contents)) => postcard::from_bytes(contents).map_err(|e| format!("{}: {e}", path.display())),
        _ => {
            Err(format!("{} has another layout than {LAYOUT}: remove it and {0}.sealed to start anew", path.display()))
        }
    };
    Ok(bytes.as_deref().map(parsed).transpose()?)
}

fn saving(kept: &KeptFile, contents: &Contents) -> Result<Save, Failure> {
    if contents.files.is_empty() {
        return Ok(kept.removing());
    }
    let bytes = postcard::to_allocvec(&(LAYOUT, contents)).map_err(|e| format!("{}: {e}", kept.path().display()))?;
    Ok(kept.saving(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::{Clock, MachineClock};
    use std::fs;
    use std::time::{Duration, Instant};

    const PLAN: &str = "id,name,start,finish\nA1,Walls,2024-03-04,2024-03-08\n";

    fn now() -> MachineTime {
        MachineClock::of_this_boot().now()
    }

    fn site(home: &Path) -> SiteConfig {
        let text = "models = []\nstate = \"state\"\n[schedule]\nfiles = [\"plan.csv\"]\n";
        fs::create_dir_all(home.join("state")).unwrap();
        SiteConfig::parse(text, home).unwrap()
    }

    #[test]
    fn a_file_that_changes_is_read_once_it_is_whole() {
        let home = tempfile::tempdir().unwrap();
        let (config, rules) = (site(home.path()), Rules::default());
        fs::write(home.path().join("plan.csv"), PLAN).unwrap();
        let mut files = ScheduleFiles::open(&config, &rules).unwrap();
        assert_eq!(files.plans().files[0].plan.tasks.len(), 1);
        assert!(files.look(&rules, now()).unwrap().is_none());
        fs::write(home.path().join("plan.csv"), format!("{PLAN}A2,Doors,2024-03-11,2024-03-12\n")).unwrap();
        assert!(files.look(&rules, now()).unwrap().is_none(), "it may not be whole yet");
        let begun = Instant::now();
        while files.look(&rules, now()).unwrap().is_none() {
            assert!(begun.elapsed() < Duration::from_secs(30));
        }
        assert_eq!(files.plans().files[0].plan.tasks.len(), 2);
    }

    #[test]
    fn a_file_that_is_spoilt_or_removed_changes_nothing() {
        let home = tempfile::tempdir().unwrap();
        let (config, rules) = (site(home.path()), Rules::default());
        let path = home.path().join("plan.csv");
        assert!(ScheduleFiles::open(&config, &rules).is_err(), "it was never there");
        fs::write(&path, PLAN).unwrap();
        let mut files = ScheduleFiles::open(&config, &rules).unwrap();
        fs::write(&path, b"%PDF-1.7 no schedule at all").unwrap();
        let begun = Instant::now();
        while files.warning().is_none() {
            assert!(files.look(&rules, now()).unwrap().is_none() && begun.elapsed() < Duration::from_secs(30));
        }
        assert!(files.plans().files.len() == 1);
        fs::remove_file(&path).unwrap();
        let again = ScheduleFiles::open(&config, &rules).unwrap();
        assert!(again.warning().unwrap().contains("plan.csv") && again.plans().files.len() == 1);
        assert_eq!(again.names().as_deref(), Some("plan.csv"));
    }

    #[test]
    fn a_flipped_bit_of_what_is_kept_changes_no_date_and_what_is_removed_is_told() {
        let home = tempfile::tempdir().unwrap();
        let (config, rules) = (site(home.path()), Rules::default());
        let path = home.path().join("plan.csv");
        fs::write(&path, PLAN).unwrap();
        let files = ScheduleFiles::open(&config, &rules).unwrap();
        let as_read = format!("{:?}", files.plans());
        fs::remove_file(&path).unwrap();
        let kept = config.state.join(SCHEDULE_FILES);
        let mut bytes = fs::read(&kept).unwrap();
        let at = bytes.windows(10).position(|text| text == b"2024-03-04").unwrap();
        bytes[at + 9] ^= 1;
        fs::write(&kept, bytes).unwrap();
        let again = ScheduleFiles::open(&config, &rules).unwrap();
        assert_eq!(format!("{:?}", again.plans()), as_read);
        assert!(again.warning().unwrap().contains(SCHEDULE_FILES), "{:?}", again.warning());
        assert!(
            ScheduleFiles::open(&config, &rules)
                .unwrap()
                .warning()
                .is_some_and(|warning| !warning.contains(SCHEDULE_FILES))
        );
    }
}
