//! The options of waypoints as they are kept: a file with its content, and what a command set beside it. `waypoint-gen`
//! plans with it, and `site-server` plans ahead with the same.

use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::file_text::FileText;
use crate::setting::{Configured, SettingKey, would_be_in_force};
use serde::{Deserialize, Serialize};
use std::error::Error;

/// What waypoints are planned: a file of options, and what a command set beside them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointOptions {
    /// The options; without a file, the default ones.
    pub file: Option<FileText>,
    /// Only these spaces; without any, those of the options.
    pub spaces: Vec<String>,
    /// Only what was built since this plan time, civil seconds since 1970; without one, that of the options.
    pub changed_since_s: Option<i64>,
}

impl WaypointOptions {
    /// What the files are called in errors.
    pub const WHAT: &str = "options of waypoints";

    /// Those of a command; without a file, with the options that `site.toml` names.
    ///
    /// # Errors
    /// Options that `parse` refuses.
    pub fn of_command<O, E: Error + Send + Sync + 'static>(
        file: Option<FileText>,
        spaces: Vec<String>,
        changed_since_s: Option<i64>,
        in_site_toml: &Self,
        parse: impl Fn(&str) -> Result<O, E>,
    ) -> Result<Self, Failure> {
        if let Some(file) = &file {
            file.parse(Self::WHAT, &parse)?;
        }
        let file = file.or_else(|| in_site_toml.file.clone());
        Ok(Self { file, spaces, changed_since_s })
    }

    /// The options of the file, before what a command set beside them.
    ///
    /// # Errors
    /// A file that was kept and is none of this version.
    pub fn parse<O: Default, E: Error + Send + Sync + 'static>(
        &self,
        parse: impl Fn(&str) -> Result<O, E>,
    ) -> Result<O, Failure> {
        self.file.as_ref().map_or_else(|| Ok(O::default()), |file| Ok(file.parse(Self::WHAT, &parse)?))
    }

    /// What `waypoints.options` of `site.toml` says.
    pub fn configured<O, E: Error + Send + Sync + 'static>(
        config: &SiteConfig,
        parse: impl Fn(&str) -> Result<O, E>,
    ) -> Configured<Self> {
        let Configured { file, value } = FileText::configured(Self::WHAT, config.waypoints.options.as_deref(), parse);
        Configured { file, value: value.map(|file| Self { file, ..Self::default() }) }
    }

    /// Those that are in force for a robot, or will be once its waypoint-gen has read the configuration.
    ///
    /// # Errors
    /// State that cannot be read, options that cannot be used.
    pub fn in_force<O, E: Error + Send + Sync + 'static>(
        config: &SiteConfig,
        parse: impl Fn(&str) -> Result<O, E>,
    ) -> Result<Self, Failure> {
        let configured = Self::configured(config, parse);
        Ok(would_be_in_force(&config.state, SettingKey::Waypoints, configured)?.value().clone())
    }

    /// In words: the file, and what a command set beside it.
    pub fn words(&self) -> String {
        let mut words = FileText::words(self.file.as_ref(), "the default options");
        if !self.spaces.is_empty() {
            words += &format!(", spaces {}", self.spaces.join(", "));
        }
        if let Some(since) = self.changed_since_s.and_then(messages::plan_time) {
            words += &format!(", changed since {since}");
        }
        words
    }
}
