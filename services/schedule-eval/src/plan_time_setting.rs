//! The plan time in force: that of `site.toml`, or the clock that a command set.

use daemon::{Configured, Failure, PlanTimeClock, Save, Setting, SettingInForce, SettingKey, SiteConfig};
use frames::{PlanTime, PlanTimeError};
use jiff::tz::TimeZone;
use serde::{Deserialize, Serialize};

/// A plan time as it is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PlanTimeValue {
    /// As `site.toml` has it; without one everything is built.
    SiteToml(Option<String>),
    /// Set by a command, and as far as it got.
    Clock(PlanTimeClock),
}

impl Default for PlanTimeValue {
    fn default() -> Self {
        Self::SiteToml(None)
    }
}

impl PlanTimeValue {
    fn clock(&self, zone: Option<&TimeZone>) -> Result<PlanTimeClock, PlanTimeError> {
        match self {
            Self::SiteToml(None) => Ok(PlanTimeClock::Everything),
            Self::SiteToml(Some(text)) => {
                Ok(PlanTimeClock::Fixed { at_s: PlanTime::parse(text, zone)?.at.civil_seconds() })
            }
            Self::Clock(clock) => Ok(*clock),
        }
    }
}

/// The plan time of a site.
#[derive(Debug, Clone)]
pub(crate) struct PlanTimeSetting {
    setting: Setting<PlanTimeValue>,
    clock: PlanTimeClock,
}

impl PlanTimeSetting {
    /// The plan time at the start of the daemon.
    ///
    /// # Errors
    /// A plan time that is none, or state that cannot be read or written.
    pub(crate) fn open(config: &SiteConfig, zone: Option<&TimeZone>) -> Result<Self, Failure> {
        let setting = Setting::open(&config.state, SettingKey::PlanTime, configured(config, zone))?;
        let clock = setting.value().clock(zone)?;
        Ok(Self { setting, clock })
    }

    /// The clock in force.
    pub(crate) fn clock(&self) -> &PlanTimeClock {
        &self.clock
    }

    /// Takes a clock that a command of this user sets.
    ///
    /// # Errors
    /// A clock that has no JSON.
    pub(crate) fn set(&mut self, clock: PlanTimeClock, by_uid: u32) -> Result<Option<Save>, Failure> {
        self.clock = clock;
        Ok(self.setting.keep(self.setting.commanded(PlanTimeValue::Clock(clock), by_uid))?)
    }

    /// Takes the same clock, having got further.
    ///
    /// # Errors
    /// A clock that has no JSON.
    pub(crate) fn move_on(&mut self, clock: PlanTimeClock) -> Result<Option<Save>, Failure> {
        self.clock = clock;
        Ok(self.setting.keep(self.setting.moved_on(PlanTimeValue::Clock(clock)))?)
    }

    /// Takes an edit of the site's file, read in the zone of its rules. True for one that changed the plan time.
    ///
    /// # Errors
    /// A plan time that is none.
    pub(crate) fn edit(
        &mut self,
        config: &SiteConfig,
        zone: Option<&TimeZone>,
    ) -> Result<(bool, Option<Save>), Failure> {
        let edited = self.setting.edited(configured(config, zone))?;
        let clock = edited.value().clock(zone)?;
        let save = self.setting.keep(edited)?;
        Ok((std::mem::replace(&mut self.clock, clock) != clock, save))
    }

    /// True if `site.toml` was edited before this start.
    pub(crate) fn was_edited(&self) -> bool {
        self.setting.was_edited()
    }

    /// What an operator should know: the state of the plan time was damaged or removed.
    pub(crate) fn warning(&self) -> Option<&str> {
        self.setting.warning()
    }

    /// The plan time for `status`.
    pub(crate) fn in_force(&self) -> SettingInForce {
        self.setting.in_force(|value| match value {
            PlanTimeValue::SiteToml(Some(text)) => text.clone(),
            PlanTimeValue::SiteToml(None) => "everything built".to_owned(),
            PlanTimeValue::Clock(clock @ PlanTimeClock::Fixed { at_s }) => {
                PlanTime::from_civil_seconds(*at_s).map_or_else(|| clock.name(), |at| at.to_string())
            }
            PlanTimeValue::Clock(clock) => clock.name(),
        })
    }
}

fn configured(config: &SiteConfig, zone: Option<&TimeZone>) -> Configured<PlanTimeValue> {
    let value = PlanTimeValue::SiteToml(config.schedule.plan_time.clone());
    let checked = value.clock(zone).map_err(Failure::from);
    Configured { file: None, value: checked.map(|_| value) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::SettingSource;
    use std::path::Path;

    fn config(home: &Path, plan_time: &str) -> SiteConfig {
        SiteConfig::parse(&format!("state = \"state\"\n[schedule]\nplan_time = {plan_time:?}\n"), home).unwrap()
    }

    fn open(config: &SiteConfig) -> Result<PlanTimeSetting, Failure> {
        PlanTimeSetting::open(config, None)
    }

    fn in_force(setting: &PlanTimeSetting) -> (String, SettingSource) {
        let SettingInForce { value, source, .. } = setting.in_force();
        (value, source)
    }

    #[test]
    fn a_date_that_was_set_counts_until_that_of_the_site_is_edited() {
        let home = tempfile::tempdir().unwrap();
        let first = config(home.path(), "2024-03-01");
        let mut setting = open(&first).unwrap();
        assert_eq!(in_force(&setting), ("2024-03-01".to_owned(), SettingSource::SiteToml));
        let noon = PlanTimeClock::Fixed { at_s: PlanTime::parse("2024-04-01T12:00", None).unwrap().at.civil_seconds() };
        let save = setting.set(noon, 7).unwrap().unwrap();
        let (is_other, nothing) = setting.edit(&first, None).unwrap();
        assert!(!is_other && nothing.is_none() && *setting.clock() == noon);
        assert_eq!(in_force(&open(&first).unwrap()).1, SettingSource::SiteToml, "nothing is written yet");
        save.write().unwrap();
        let mut setting = open(&first).unwrap();
        assert_eq!(in_force(&setting), ("2024-04-01T12:00:00".to_owned(), SettingSource::Command));
        assert!(setting.edit(&config(home.path(), "soon"), None).is_err());
        assert!(*setting.clock() == noon);
        let (is_other, save) = setting.edit(&config(home.path(), "2024-05-01"), None).unwrap();
        assert!(is_other);
        save.unwrap().write().unwrap();
        assert_eq!(in_force(&setting), ("2024-05-01".to_owned(), SettingSource::SiteToml));
        let start = |plan_time: &str| open(&config(home.path(), plan_time)).unwrap().was_edited();
        assert_eq!([start("2024-05-01"), start("2024-06-01"), start("2024-06-01")], [false, true, false]);
    }

    #[test]
    fn a_plan_time_whose_file_is_removed_stays_and_is_told() {
        let home = tempfile::tempdir().unwrap();
        let config = config(home.path(), "2024-03-01");
        let mut setting = open(&config).unwrap();
        let april = PlanTimeClock::Fixed { at_s: PlanTime::parse("2024-04-01", None).unwrap().at.civil_seconds() };
        setting.set(april, 7).unwrap().unwrap().write().unwrap();
        std::fs::remove_file(config.state.join("settings/schedule.plan_time.json")).unwrap();
        let setting = open(&config).unwrap();
        assert!(*setting.clock() == april && setting.warning().unwrap().contains("was removed"));
    }
}
