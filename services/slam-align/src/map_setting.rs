//! The map file in force, `align.map` or that of a command, kept with its content.

use crate::robot_map::RobotMap;
use crate::stored_map::{MapStore, MapStoreError, StoredMap};
use daemon::{AlignConfig, Configured, Failure, KeptSetting, Save, Setting, SettingInForce, SettingKey, chain};
use messages::ContentHash;
use occupancy::MapFileContent;
use std::fs;
use std::path::Path;
use std::time::SystemTime;
use tracing::warn;

/// The map of a file. A robot may save the one that `site.toml` names later: what cannot be read is a warning, and is read as
/// soon as it looks different.
#[derive(Clone)]
pub(crate) struct MapSetting {
    setting: Setting<Option<StoredMap>>,
    store: MapStore,
    unread: Option<UnreadFile>,
}

/// The file that `site.toml` names and that cannot be used.
#[derive(Clone)]
struct UnreadFile {
    warning: String,
    /// How it looked.
    looks: Option<(u64, SystemTime)>,
}

/// What follows from another setting.
#[derive(Default)]
pub(crate) struct OtherMap {
    /// The map, if it is another one than before.
    pub(crate) map: Option<RobotMap>,
    /// The copy first, then the setting that names it.
    pub(crate) saves: Vec<Save>,
}

impl MapSetting {
    /// The setting at the start of the daemon.
    ///
    /// # Errors
    /// State that cannot be read or written.
    pub(crate) fn open(state: &Path, config: &AlignConfig) -> Result<Self, Failure> {
        let (store, file) = (MapStore::at(state), config.map.as_deref());
        fs::create_dir_all(state)?;
        let value = file.map(|file| copied(&store, file)).transpose();
        let configured = Configured { file: file.map(Path::to_owned), value };
        let setting = Setting::open_without_edit(state, SettingKey::SlamMap, configured)?;
        let mut map_setting = Self { setting, store, unread: None };
        map_setting.set_unread(file, map_setting.setting.warning().map(str::to_owned));
        map_setting.remove_other_copies();
        Ok(map_setting)
    }

    /// The map in force, `None` without one, with what was damaged or removed of its copy, and is mended.
    ///
    /// # Errors
    /// Its copy is missing or damaged.
    pub(crate) fn map(&self) -> Result<Option<(RobotMap, Option<String>)>, MapStoreError> {
        self.setting.value().as_ref().map(|stored| self.store.read(stored.content_hash)).transpose()
    }

    /// Takes what `site.toml` says now.
    ///
    /// # Errors
    /// State that has no JSON.
    pub(crate) fn edit(&mut self, config: &AlignConfig) -> Result<OtherMap, Failure> {
        let file = config.map.as_deref();
        let (value, read) = match file.map(RobotMap::read).transpose() {
            Ok(read) => (Ok(file.zip(read.as_ref()).map(|(file, (map, _))| StoredMap::of(file, map))), read),
            Err(why) => (Err(why.into()), None),
        };
        let edited = self.setting.edited(Configured { file: file.map(Path::to_owned), value });
        let (warning, kept) = match edited {
            Ok(kept) => (self.setting.warning().map(str::to_owned), Some(kept)),
            Err(why) => (Some(chain(why.as_ref())), None),
        };
        self.set_unread(file, warning);
        kept.map_or_else(|| Ok(OtherMap::default()), |kept| self.keep(kept, read))
    }

    /// Reads the file of `site.toml` again if it could not be used and looks different now.
    ///
    /// # Errors
    /// As [`Self::edit`].
    pub(crate) fn retry(&mut self, config: &AlignConfig) -> Result<OtherMap, Failure> {
        match &self.unread {
            Some(unread) if unread.looks != looks(config.map.as_deref()) => self.edit(config),
            _ => Ok(OtherMap::default()),
        }
    }

    /// Takes the map of this file, as a command of this user, also if it is the one in force.
    ///
    /// # Errors
    /// A map that cannot be used.
    pub(crate) fn command(&mut self, file: &Path, by_uid: u32) -> Result<OtherMap, Failure> {
        let (map, content) = RobotMap::read(file)?;
        let copy = self.store.saving(map.content_hash, content);
        let setting = self.setting.keep(self.setting.commanded(Some(StoredMap::of(file, &map)), by_uid))?;
        Ok(OtherMap { map: Some(map), saves: copy.into_iter().chain(setting).collect() })
    }

    /// What an operator should know.
    pub(crate) fn warning(&self) -> Option<&str> {
        self.unread.as_ref().map(|unread| unread.warning.as_str())
    }

    /// The setting for `status`; `None` without a map.
    pub(crate) fn in_force(&self) -> Option<SettingInForce> {
        let file = &self.setting.value().as_ref()?.file;
        Some(self.setting.in_force(|_| file.display().to_string()))
    }

    /// Content hashes of the maps whose copies the setting needs.
    pub(crate) fn needed(&self) -> [Option<ContentHash>; 2] {
        [self.setting.value(), self.setting.as_kept().in_site_toml()].map(|map| map.as_ref().map(|m| m.content_hash))
    }

    /// Removes copies that the setting in force does not need.
    pub(crate) fn remove_other_copies(&self) {
        self.store.keep_only(&self.needed().into_iter().flatten().collect::<Vec<_>>());
    }

    fn keep(
        &mut self,
        kept: KeptSetting<Option<StoredMap>>,
        read: Option<(RobotMap, MapFileContent)>,
    ) -> Result<OtherMap, Failure> {
        let [before, _] = self.needed();
        let Some(setting) = self.setting.keep(kept)? else { return Ok(OtherMap::default()) };
        let Some((map, content)) = read else { return Ok(OtherMap { map: None, saves: vec![setting] }) };
        let copy = self.store.saving(map.content_hash, content);
        let saves = copy.into_iter().chain([setting]).collect();
        Ok(OtherMap { map: Some(map).filter(|map| before != Some(map.content_hash)), saves })
    }

    fn set_unread(&mut self, file: Option<&Path>, warning: Option<String>) {
        if let Some(text) = &warning
            && self.warning() != Some(text)
        {
            warn!(service = "slam-align", warning = text, "the map file is not read");
        }
        self.unread = warning.map(|warning| UnreadFile { warning, looks: looks(file) });
    }
}

/// A map of which there is a copy on disk when this returns.
fn copied(store: &MapStore, file: &Path) -> Result<StoredMap, Failure> {
    let (map, content) = RobotMap::read(file)?;
    store.saving(map.content_hash, content).iter().try_for_each(Save::write)?;
    Ok(StoredMap::of(file, &map))
}

fn looks(file: Option<&Path>) -> Option<(u64, SystemTime)> {
    let metadata = fs::metadata(file?).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::{SettingSource, SiteConfig};
    use std::path::PathBuf;

    /// A map of three by two cells with this one occupied.
    fn save(home: &Path, name: &str, occupied: usize) -> PathBuf {
        let mut image = b"P5\n3 2\n255\n\xfe\xfe\xcd\xfe\xfe\xfe".to_vec();
        let n = image.len();
        image[n - 1 - occupied] = 0;
        fs::write(home.join(format!("{name}.pgm")), image).unwrap();
        let path = home.join(format!("{name}.yaml"));
        fs::write(&path, format!("image: {name}.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n")).unwrap();
        path
    }

    fn config(home: &Path, map: &str) -> SiteConfig {
        SiteConfig::parse(&format!("state = \"state\"\n[align]\nmap = \"{map}.yaml\"\n"), home).unwrap()
    }

    fn open(config: &SiteConfig) -> MapSetting {
        MapSetting::open(&config.state, &config.align).unwrap()
    }

    /// The hash of another map, once what follows from it is on disk.
    fn written(setting: &MapSetting, OtherMap { map, saves }: OtherMap) -> Option<ContentHash> {
        saves.iter().for_each(|save| save.write().unwrap());
        setting.remove_other_copies();
        map.map(|map| map.content_hash)
    }

    fn hash(setting: &MapSetting) -> Option<ContentHash> {
        setting.map().unwrap().map(|(map, _)| map.content_hash)
    }

    #[test]
    fn the_map_that_was_set_last_is_in_force_and_outlives_its_files() {
        let home = tempfile::tempdir().unwrap();
        let config = config(home.path(), "site");
        let site = save(home.path(), "site", 0);
        let mut setting = open(&config);
        let of_site = hash(&setting);
        assert!(of_site.is_some() && setting.in_force().unwrap().source == SettingSource::SiteToml);
        let command = save(home.path(), "command", 1);
        let other = setting.command(&command, 7).unwrap();
        let of_command = written(&setting, other);
        for path in [&command, &site] {
            fs::remove_file(path).unwrap();
        }
        let mut setting = open(&config);
        assert_eq!(hash(&setting), of_command);
        assert!(setting.warning().unwrap().ends_with("stays"), "{:?}", setting.warning());
        let in_force = setting.in_force().unwrap();
        assert_eq!((in_force.source, in_force.by_uid), (SettingSource::Command, Some(7)));
        save(home.path(), "site", 2);
        let other = setting.retry(&config.align).unwrap();
        let edited = written(&setting, other);
        assert!(edited.is_some() && edited != of_site && edited == hash(&setting));
        assert_eq!((setting.warning(), setting.in_force().unwrap().source), (None, SettingSource::SiteToml));
        let copies = fs::read_dir(&config.state).unwrap().filter(|e| e.as_ref().unwrap().path().is_file()).count();
        assert_eq!(copies, 4, "an image and its description, each twice");
    }

    #[test]
    fn a_map_that_the_robot_has_not_saved_yet_is_read_when_it_has() {
        let home = tempfile::tempdir().unwrap();
        let config = config(home.path(), "later");
        let mut setting = open(&config);
        let warning = setting.warning().unwrap().to_owned();
        assert!(warning.starts_with("align.map: ") && warning.contains("later.yaml"), "{warning}");
        assert!(setting.map().unwrap().is_none() && setting.retry(&config.align).unwrap().map.is_none());
        save(home.path(), "later", 0);
        assert!(setting.retry(&config.align).unwrap().map.is_some());
        assert!(setting.warning().is_none() && setting.retry(&config.align).unwrap().map.is_none());
    }
}
