//! Settings: what `site.toml` says, and what a command set over it; kept in the state folder with their contents.
//!
//! The value that was set last is in force: that of a command until the file's own value is edited, then the file's. An
//! edit counts when it is read, at a start or on SIGHUP. What a key names is part of its value: to edit the robot profile
//! that `site.toml` names is to edit `robot.profile`.
//!
//! A value is kept whole, not as the name of a file: a file that is removed or spoilt later changes nothing, and is told as
//! a warning.

use crate::failure::{Failure, chain, joined};
use crate::save::Save;
use crate::state::{StateError, StateFile};
use crate::state_files::SETTINGS;
use jiff::Timestamp;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// A key of `site.toml` whose value is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingKey {
    /// `models`.
    Models,
    /// `schedule.rules`.
    Rules,
    /// `schedule.files`.
    ScheduleFiles,
    /// `schedule.plan_time`.
    PlanTime,
    /// `robot.profile`.
    RobotProfile,
    /// `robot.resolution_m`.
    Resolution,
    /// `waypoints.options`.
    Waypoints,
    /// `align.map`.
    SlamMap,
}

impl SettingKey {
    /// As in `site.toml`, with the name of its table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Models => "models",
            Self::Rules => "schedule.rules",
            Self::ScheduleFiles => "schedule.files",
            Self::PlanTime => "schedule.plan_time",
            Self::RobotProfile => "robot.profile",
            Self::Resolution => "robot.resolution_m",
            Self::Waypoints => "waypoints.options",
            Self::SlamMap => "align.map",
        }
    }

    fn file_name(self) -> String {
        format!("{SETTINGS}/{}.json", self.name())
    }
}

impl fmt::Display for SettingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a key of `site.toml` says now.
#[derive(Debug)]
pub struct Configured<T> {
    /// The file that it names, for keys that name one.
    pub file: Option<PathBuf>,
    /// Its value, or why that cannot be used.
    pub value: Result<T, Failure>,
}

impl<T> Configured<T> {
    /// A value that is written in `site.toml` itself.
    pub fn literal(value: T) -> Self {
        Self { file: None, value: Ok(value) }
    }
}

/// Where a value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SettingSource {
    /// The configuration of the site.
    SiteToml,
    /// A command.
    Command,
}

/// A setting as `groundplan status` shows it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SettingInForce {
    /// The key of `site.toml`, with the name of its table.
    pub key: String,
    /// The value in words; a file is its path.
    pub value: String,
    /// Where it comes from.
    pub source: SettingSource,
    /// The user who gave the command; null where there was none.
    pub by_uid: Option<u32>,
    /// When the value came into force, in UTC.
    #[schemars(with = "String")]
    pub since: Timestamp,
}

impl SettingInForce {
    /// A value, in words, that comes into force now.
    pub fn now(key: SettingKey, value: String, source: SettingSource, by_uid: Option<u32>) -> Self {
        Self { key: key.to_string(), value, source, by_uid, since: Timestamp::now() }
    }
}

/// The value of a setting, as it lies in the state folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptSetting<T> {
    site_toml: FromSiteToml<T>,
    command: Option<FromCommand<T>>,
}

/// What `site.toml` said when it was read last, and could be used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FromSiteToml<T> {
    file: Option<PathBuf>,
    value: T,
    since: Timestamp,
}

/// What a command set, if it is in force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FromCommand<T> {
    value: T,
    by_uid: Option<u32>,
    since: Timestamp,
}

impl<T> KeptSetting<T> {
    /// The value in force.
    pub fn value(&self) -> &T {
        self.command.as_ref().map_or(&self.site_toml.value, |command| &command.value)
    }

    /// What `site.toml` said when it was read last, also while a command's value is in force.
    pub fn in_site_toml(&self) -> &T {
        &self.site_toml.value
    }

    /// The user who set the value by a command that is in force.
    pub fn by_uid(&self) -> Option<u32> {
        self.command.as_ref().and_then(|command| command.by_uid)
    }
}

/// A setting of a daemon.
#[derive(Debug, Clone)]
pub struct Setting<T> {
    key: SettingKey,
    file: StateFile,
    kept: KeptSetting<T>,
    warning: Option<String>,
    was_edited: bool,
}

impl<T: Clone + Default + PartialEq + Serialize + DeserializeOwned> Setting<T> {
    /// The setting at the start of its daemon.
    ///
    /// # Errors
    /// An edit that cannot be used, or state that cannot be read or written.
    pub fn open(state: &Path, key: SettingKey, now: Configured<T>) -> Result<Self, Failure> {
        Self::open_with(state, key, now, |_, why| Err(why))
    }

    /// As [`Self::open`], for a value that its daemon can start without: an edit that cannot be used is a warning, and what was
    /// in force before stays.
    ///
    /// # Errors
    /// State that cannot be read or written.
    pub fn open_without_edit(state: &Path, key: SettingKey, now: Configured<T>) -> Result<Self, Failure> {
        Self::open_with(state, key, now, |kept, why| {
            let nothing = || FromSiteToml { file: None, value: T::default(), since: Timestamp::now() };
            Ok((kept.unwrap_or_else(|| KeptSetting { site_toml: nothing(), command: None }), chain(why.as_ref())))
        })
    }

    fn open_with(
        state: &Path,
        key: SettingKey,
        now: Configured<T>,
        unusable: impl FnOnce(Option<KeptSetting<T>>, Failure) -> Result<(KeptSetting<T>, String), Failure>,
    ) -> Result<Self, Failure> {
        let file = StateFile::at(state, &key.file_name())?;
        let at = Timestamp::now();
        let (before, mended): (Option<KeptSetting<T>>, _) = file.load_and_tell()?;
        let (kept, warning) = match read(before.clone(), now, at) {
            Ok(read) => read,
            Err(why) => {
                let (kept, warning) = unusable(before.clone(), why).map_err(|why| named(key, why.as_ref()))?;
                (kept, Some(warning))
            }
        };
        if before.as_ref() != Some(&kept) {
            file.save(&kept)?;
        }
        let was_edited = before.is_some_and(|before| before != kept);
        let warning = joined(mended.into_iter().chain(warning)).map(|text| format!("{key}: {text}"));
        Ok(Self { key, file, kept, warning, was_edited })
    }

    /// True if `site.toml` was edited before this start.
    pub fn was_edited(&self) -> bool {
        self.was_edited
    }

    /// The value in force.
    pub fn value(&self) -> &T {
        self.kept.value()
    }

    /// What an operator should know: the file that `site.toml` names cannot be used any more.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// What is in force after `site.toml` was read again: to be tried, then [kept](Self::keep).
    ///
    /// # Errors
    /// An edit that cannot be used; the value stays.
    pub fn edited(&mut self, now: Configured<T>) -> Result<KeptSetting<T>, Failure> {
        let (kept, warning) =
            read(Some(self.kept.clone()), now, Timestamp::now()).map_err(|why| named(self.key, why.as_ref()))?;
        self.warning = warning.map(|text| format!("{}: {text}", self.key));
        Ok(kept)
    }

    /// What is in force now.
    pub fn as_kept(&self) -> KeptSetting<T> {
        self.kept.clone()
    }

    /// What is in force after a command of this user: to be tried, then [kept](Self::keep).
    pub fn commanded(&self, value: T, by_uid: u32) -> KeptSetting<T> {
        let command = FromCommand { value, by_uid: Some(by_uid), since: Timestamp::now() };
        KeptSetting { command: Some(command), ..self.kept.clone() }
    }

    /// What is in force when the value of `site.toml` counts again: to be tried, then [kept](Self::keep).
    pub fn without_command(&self) -> KeptSetting<T> {
        KeptSetting { command: None, ..self.kept.clone() }
    }

    /// The same setting with a command's value that has moved on, such as a clock that runs: who set it, and when, stays.
    pub fn moved_on(&self, value: T) -> KeptSetting<T> {
        let mut kept = self.kept.clone();
        if let Some(command) = &mut kept.command {
            command.value = value;
        }
        kept
    }

    /// Takes what was tried. The answer is to be written before anything follows from it; nothing, if nothing changes.
    ///
    /// # Errors
    /// A value that has no JSON; the value stays.
    pub fn keep(&mut self, kept: KeptSetting<T>) -> Result<Option<Save>, StateError> {
        let save = if kept == self.kept { None } else { Some(self.file.saving(&kept)?) };
        self.kept = kept;
        Ok(save)
    }

    /// The setting for `status`, with its value in words.
    pub fn in_force(&self, words: impl FnOnce(&T) -> String) -> SettingInForce {
        let (source, by_uid, since) = match &self.kept.command {
            Some(command) => (SettingSource::Command, command.by_uid, command.since),
            None => (SettingSource::SiteToml, None, self.kept.site_toml.since),
        };
        SettingInForce { key: self.key.to_string(), value: words(self.value()), source, by_uid, since }
    }
}

/// The rule: the setting after `site.toml` was read, and what an operator should know.
fn read<T: PartialEq>(
    kept: Option<KeptSetting<T>>,
    now: Configured<T>,
    at: Timestamp,
) -> Result<(KeptSetting<T>, Option<String>), Failure> {
    let Configured { file, value } = now;
    match (kept, value) {
        (Some(kept), Ok(value)) if (&kept.site_toml.file, &kept.site_toml.value) == (&file, &value) => Ok((kept, None)),
        (_, Ok(value)) => Ok((KeptSetting { site_toml: FromSiteToml { file, value, since: at }, command: None }, None)),
        (Some(kept), Err(why)) => stand_in(&kept, file.as_deref(), why).map(|warning| (kept, Some(warning))),
        (None, Err(why)) => Err(why),
    }
}

/// The warning about a file that cannot be used although `site.toml` names it as before: its earlier content stands in.
///
/// # Errors
/// The edit of a key of `site.toml`: nothing stands in for a file that was never read.
fn stand_in<T>(kept: &KeptSetting<T>, file: Option<&Path>, why: Failure) -> Result<String, Failure> {
    if file.is_none() || kept.site_toml.file.as_deref() != file {
        return Err(why);
    }
    Ok(format!("{}; what was in force before stays", chain(why.as_ref())))
}

fn named(key: SettingKey, why: &(dyn std::error::Error + 'static)) -> Failure {
    format!("{key}: {}", chain(why)).into()
}

/// What a daemon would make of a key of `site.toml` at its start; nothing is written. A warning tells that a file cannot be
/// used and its earlier content stands in.
///
/// # Errors
/// A value that cannot be used, or state that is damaged: the daemon would not start.
pub fn check_setting<T>(state: &Path, key: SettingKey, now: Configured<T>) -> Result<Option<String>, Failure> {
    let file = StateFile::of(state, &key.file_name());
    let (kept, mended): (Option<KeptSetting<serde_json::Value>>, _) = file.load_and_tell()?;
    match (kept, now.value) {
        (_, Ok(_)) => Ok(mended),
        (Some(kept), Err(why)) => {
            let warning = stand_in(&kept, now.file.as_deref(), why)?;
            Ok(joined(mended.into_iter().chain([warning])))
        }
        (None, Err(why)) => Err(why),
    }
}

/// What is in force once this was read from `site.toml`; nothing is written.
///
/// # Errors
/// An edit that cannot be used, or state that is damaged.
pub(crate) fn would_be_in_force<T: PartialEq + DeserializeOwned>(
    state: &Path,
    key: SettingKey,
    now: Configured<T>,
) -> Result<KeptSetting<T>, Failure> {
    let (kept, _) = read(load(state, key)?, now, Timestamp::now()).map_err(|why| named(key, why.as_ref()))?;
    Ok(kept)
}

fn load<T: DeserializeOwned>(state: &Path, key: SettingKey) -> Result<Option<KeptSetting<T>>, StateError> {
    StateFile::of(state, &key.file_name()).load()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file_text::FileText;
    use proptest::prelude::*;
    use std::fs;

    /// A site with the files that `site.toml` may name, and a daemon with one setting.
    struct Site {
        home: tempfile::TempDir,
        /// The file that `site.toml` names.
        named: Option<usize>,
        setting: Option<Setting<Option<FileText>>>,
    }

    #[derive(Debug, thiserror::Error)]
    #[error("it is broken")]
    struct Broken;

    fn parse(text: &str) -> Result<(), Broken> {
        if text == "broken" { Err(Broken) } else { Ok(()) }
    }

    impl Site {
        fn new() -> Self {
            Self { home: tempfile::tempdir().unwrap(), named: None, setting: None }
        }

        fn path(&self, file: usize) -> PathBuf {
            self.home.path().join(file.to_string())
        }

        fn write(&self, file: usize, text: Option<&str>) {
            match text {
                Some(text) => fs::write(self.path(file), text).unwrap(),
                None => drop(fs::remove_file(self.path(file))),
            }
        }

        fn configured(&self) -> Configured<Option<FileText>> {
            FileText::configured("profile", self.named.map(|file| self.path(file)).as_deref(), parse)
        }

        fn start(&mut self) -> Result<(), Failure> {
            let state = self.home.path().join("state");
            let checked = check_setting(&state, SettingKey::RobotProfile, self.configured());
            let opened = Setting::open(&state, SettingKey::RobotProfile, self.configured());
            assert_eq!(checked.is_ok(), opened.is_ok(), "a check before a start says what the start does");
            self.setting = Some(opened?);
            assert_eq!(checked.unwrap().is_some(), self.setting.as_ref().unwrap().warning().is_some());
            Ok(())
        }

        fn reload(&mut self) -> Result<(), Failure> {
            let now = self.configured();
            let Some(setting) = &mut self.setting else { return self.start() };
            let kept = setting.edited(now)?;
            Ok(setting.keep(kept)?.iter().try_for_each(Save::write)?)
        }

        fn command(&mut self, text: &str) {
            let Some(setting) = &mut self.setting else { return };
            let kept = setting.commanded(Some(FileText { path: "/command".into(), text: text.to_owned() }), 7);
            setting.keep(kept).unwrap().iter().for_each(|save| save.write().unwrap());
        }

        fn text(&self) -> Option<&str> {
            self.setting.as_ref().unwrap().value().as_ref().map(|file| file.text.as_str())
        }

        fn source(&self) -> SettingSource {
            self.setting.as_ref().unwrap().in_force(|_| String::new()).source
        }
    }

    #[test]
    fn a_file_that_is_removed_or_spoilt_changes_nothing_and_is_told() {
        let mut site = Site::new();
        site.write(0, Some("a"));
        site.named = Some(0);
        site.start().unwrap();
        for spoilt in [None, Some("broken")] {
            site.write(0, spoilt);
            site.start().unwrap();
            let warning = site.setting.as_ref().unwrap().warning().unwrap();
            assert!(warning.starts_with("robot.profile: profile ") && warning.ends_with("stays"), "{warning}");
            assert_eq!((site.text(), site.source()), (Some("a"), SettingSource::SiteToml));
            site.reload().unwrap();
            assert_eq!(site.text(), Some("a"));
        }
        site.write(0, Some("b"));
        site.reload().unwrap();
        assert_eq!((site.text(), site.setting.as_ref().unwrap().warning()), (Some("b"), None));
    }

    #[test]
    fn an_edit_of_site_toml_that_names_an_unusable_file_is_refused() {
        let mut site = Site::new();
        site.named = Some(0);
        assert!(site.start().unwrap_err().to_string().starts_with("robot.profile: profile "), "nothing was read ever");
        site.named = None;
        site.start().unwrap();
        site.named = Some(1);
        assert!(site.reload().is_err() && site.start().is_err());
        assert_eq!(site.text(), None);
    }

    #[test]
    fn state_of_another_layout_is_refused_by_name_and_stays_as_it_is() {
        let mut site = Site::new();
        site.start().unwrap();
        let path = site.home.path().join("state/settings/robot.profile.json");
        let other = fs::read_to_string(&path).unwrap().replacen('{', r#"{"unit":1,"#, 1);
        crate::sealed_file::write_sealed(&path, other.as_bytes()).unwrap();
        let why = chain(site.start().unwrap_err().as_ref());
        assert!(why.contains("robot.profile.json") && why.contains("another layout") && why.contains("unit"), "{why}");
        assert_eq!(fs::read_to_string(&path).unwrap(), other);
    }

    #[test]
    fn damaged_state_is_an_error_of_the_check_too() {
        let mut site = Site::new();
        site.start().unwrap();
        let file = site.home.path().join("state/settings/robot.profile.json");
        fs::write(&file, "{}").unwrap();
        fs::write(crate::sealed_file::sealed_path(&file), "{").unwrap();
        assert!(site.start().unwrap_err().to_string().contains("damaged"));
    }

    #[test]
    fn a_value_whose_file_is_damaged_or_removed_stays_and_is_told() {
        let mut site = Site::new();
        site.start().unwrap();
        site.command("legged");
        let file = site.home.path().join("state/settings/robot.profile.json");
        let intact = fs::read(&file).unwrap();
        for damage in [Some("{}"), Some(""), None] {
            match damage {
                Some(text) => fs::write(&file, text).unwrap(),
                None => fs::remove_file(&file).unwrap(),
            }
            site.start().unwrap();
            assert_eq!(site.text(), Some("legged"));
            let warning = site.setting.as_ref().unwrap().warning().unwrap();
            assert!(warning.contains("robot.profile.json") && warning.contains("stays"), "{warning}");
            assert_eq!(fs::read(&file).unwrap(), intact);
            site.start().unwrap();
            assert_eq!(site.setting.as_ref().unwrap().warning(), None);
        }
    }

    #[derive(Debug, Clone)]
    enum Step {
        /// A file gets this text; `None` removes it.
        Write(usize, Option<&'static str>),
        /// `site.toml` names another file, or none.
        Name(Option<usize>),
        Restart,
        Reload,
        Command(&'static str),
    }

    fn step() -> impl Strategy<Value = Step> {
        let text = prop_oneof![Just(None), Just(Some("broken")), Just(Some("a")), Just(Some("b"))];
        prop_oneof![
            (0..2_usize, text).prop_map(|(file, text)| Step::Write(file, text)),
            proptest::option::of(0..2_usize).prop_map(Step::Name),
            Just(Step::Restart),
            Just(Step::Reload),
            prop_oneof![Just("c"), Just("d")].prop_map(Step::Command),
        ]
    }

    proptest! {
        // Each step is a write to disk.
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The rule in other words: of all commands, and all readings that found a usable value other than the usable one
        /// that was read before, the last is in force.
        #[test]
        fn the_value_that_was_set_last_is_in_force(steps in prop::collection::vec(step(), 0..40)) {
            let mut site = Site::new();
            site.start().unwrap();
            let mut files = [None, None];
            let (mut was_read, mut in_force) = ((None, None), None);
            for step in steps {
                match step {
                    Step::Write(file, text) => {
                        site.write(file, text);
                        files[file] = text;
                    }
                    Step::Name(file) => site.named = file,
                    Step::Command(text) => {
                        site.command(text);
                        in_force = Some(text);
                    }
                    Step::Restart | Step::Reload => {
                        let text = site.named.and_then(|file| files[file]).filter(|text| *text != "broken");
                        let is_usable = site.named.is_none() || text.is_some();
                        if is_usable && was_read != (site.named, text) {
                            was_read = (site.named, text);
                            in_force = text;
                        }
                        let taken = if matches!(step, Step::Restart) { site.start() } else { site.reload() };
                        prop_assert_eq!(taken.is_ok(), is_usable || was_read.0 == site.named);
                    }
                }
                prop_assert_eq!(site.text(), in_force);
            }
        }
    }
}
