//! Checks the configuration of a site before anything is started: values of the daemons that `up` starts, and files that it names.

use crate::failure::Failure;
use bus::{DomainError, RobotName};
use daemon::state_files::REVISIONS;
use daemon::{Configured, FileText, Robot, SettingKey, SiteConfig, check_setting, line_of_key};
use frames::PlanTime;
use grid::GridSpec;
use input_files::{MAX_CONFIGURATION_BYTES, open_regular_file, read_regular_text};
use occupancy::OccupancyMap;
use replica::{PublicKey, SiteName};
use schedule::Rules;
use std::fmt;
use std::path::{Path, PathBuf};
use waypoints::MissionPlanOptions;
use world::WorldOptions;

/// What is wrong with a key of `site.toml`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ConfigFinding {
    /// The configuration.
    file: PathBuf,
    /// Where it has the key, from 1; `None` if the key is left out.
    line: Option<usize>,
    /// The key, with the name of its table.
    pub(crate) key: &'static str,
    /// What is wrong and what to do.
    pub(crate) text: String,
    /// True if the daemons do not start with it.
    pub(crate) is_fatal: bool,
}

impl fmt::Display for ConfigFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, key, text, .. } = self;
        match line {
            Some(line) => write!(f, "{}, line {line}: {key}: {text}", file.display()),
            None => write!(f, "{}: {key}: {text}", file.display()),
        }
    }
}

/// Refuses a configuration with which the daemons would not start; tells on standard error what else an operator should
/// know.
///
/// # Errors
/// All that is wrong, a line each.
pub(crate) fn refuse_unusable(config: &SiteConfig) -> Result<(), Failure> {
    let (fatal, warnings): (Vec<_>, Vec<_>) = findings(config).into_iter().partition(|f| f.is_fatal);
    if !fatal.is_empty() {
        return Err(Failure::usage(fatal.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")));
    }
    warnings.iter().for_each(|warning| eprintln!("groundplan: warning: {warning}"));
    Ok(())
}

/// All that is wrong with a configuration; nothing is started or written.
///
/// A file that cannot be used any more is a warning where its content of before is in force.
pub(crate) fn findings(config: &SiteConfig) -> Vec<ConfigFinding> {
    let text = read_regular_text(&config.file, MAX_CONFIGURATION_BYTES).unwrap_or_default();
    let mut found = Findings { file: &config.file, text, robot: None, findings: Vec::new() };
    let domain = config.domain();
    let is_of_relay = matches!(domain, Err(DomainError::RelayFolder { .. }));
    found.of(if is_of_relay { "relay.folder" } else { "bus.prefix" }, domain);
    found.of("log.level", config.log.check());
    models(&mut found, config);
    for config in config.of_each_robot() {
        found.robot = config.robot_name;
        of_robot(&mut found, &config);
    }
    found.robot = None;
    if config.web.enabled && (config.web.robot.is_some() || config.robots.len() > 1) {
        found.of("web.robot", config.of_robot(config.web.robot));
    }
    if config.ask.enabled && (config.ask.robot.is_some() || config.robots.len() > 1) {
        found.of("ask.robot", config.of_robot(config.ask.robot));
    }
    schedule(&mut found, config);
    server(&mut found, config);
    let world = config.world.options.as_deref();
    found.of(
        "world.options",
        world.map(|path| daemon::read_parsed("options of worlds", path, WorldOptions::parse)).transpose(),
    );
    found.findings
}

/// Names and keys of a site on many machines.
fn server(found: &mut Findings<'_>, config: &SiteConfig) {
    if let Some(serve) = &config.serve {
        found.of("serve.site", serve.site.parse::<SiteName>());
    }
    if let Some(follow) = &config.follow {
        found.of("follow.site", follow.site.parse::<SiteName>());
        found.of("follow.roots", follow.roots.iter().map(|root| root.parse()).collect::<Result<Vec<PublicKey>, _>>());
    }
}

/// What each robot has of its own.
fn of_robot(found: &mut Findings<'_>, config: &SiteConfig) {
    let robot = Robot::configured(config.robot.profile.as_deref());
    found.setting(&config.state, SettingKey::RobotProfile, robot);
    found.of(SettingKey::Resolution.name(), GridSpec::cell_tenths_of(config.robot.resolution_m));
    let options =
        FileText::configured("options of waypoints", config.waypoints.options.as_deref(), MissionPlanOptions::parse);
    found.setting(&config.state, SettingKey::Waypoints, options);
    align(found, config);
    for (key, why) in config.ros.faults() {
        found.add(key, why, true);
    }
}

fn models(found: &mut Findings<'_>, config: &SiteConfig) {
    let unreadable = config.models.iter().find_map(|path| match open_regular_file(path) {
        Err(_) if path.is_dir() => Some(format!("{} is a folder: name the IFC files in it", path.display())),
        Err(why) => Some(format!("{} cannot be read: {why}", path.display())),
        Ok(_) => None,
    });
    let Some(why) = unreadable else { return };
    let is_as_before = models_before(&config.state).as_ref() == Some(&config.models);
    let text = if is_as_before { format!("{why}; the site that was read before stays") } else { why };
    found.add(SettingKey::Models.name(), text, !is_as_before);
}

/// The models that the site's file named when ifc-ingest chose the site in force; `None` before the first one.
fn models_before(state: &Path) -> Option<Vec<PathBuf>> {
    #[derive(serde::Deserialize)]
    struct Loaded {
        configured: Vec<PathBuf>,
    }
    let bytes = std::fs::read(state.join(REVISIONS)).ok()?;
    serde_json::from_slice(&bytes).ok().map(|Loaded { configured }| configured)
}

/// The plan time is read in the zone of the rules.
fn schedule(found: &mut Findings<'_>, config: &SiteConfig) {
    let rules = FileText::configured("rules", config.schedule.rules.as_deref(), Rules::parse);
    let parsed = rules.value.as_ref().map(|file| file.as_ref().map(|file| Rules::parse(&file.text)));
    let zone = parsed.ok().flatten().and_then(Result::ok).and_then(|rules| rules.site_zone);
    let are_usable = rules.value.is_ok();
    found.setting(&config.state, SettingKey::Rules, rules);
    let Some(text) = config.schedule.plan_time.as_deref().filter(|_| are_usable) else { return };
    found.of(SettingKey::PlanTime.name(), PlanTime::parse(text, zone.as_ref()));
}

fn align(found: &mut Findings<'_>, config: &SiteConfig) {
    let align = &config.align;
    if let Some(Err(why)) = align.map.as_deref().map(OccupancyMap::read) {
        // The robot may save it later: slam-align says so until it is there.
        found.add(SettingKey::SlamMap.name(), daemon::chain(&why), false);
    }
    for (key, why) in align.faults() {
        found.add(key, why, true);
    }
}

/// Findings, and what their lines are counted in.
struct Findings<'a> {
    file: &'a Path,
    text: String,
    /// The robot with a name whose keys are looked at.
    robot: Option<RobotName>,
    findings: Vec<ConfigFinding>,
}

impl Findings<'_> {
    fn add(&mut self, key: &'static str, text: String, is_fatal: bool) {
        // Tables of robots have their keys without the name of a table of one without a name.
        let (line, text) = match self.robot {
            Some(robot) => (None, format!("robot {robot}: {text}")),
            None => (line_of_key(&self.text, key), text),
        };
        self.findings.push(ConfigFinding { file: self.file.to_owned(), line, key, text, is_fatal });
    }

    fn of<T, E: std::error::Error + 'static>(&mut self, key: &'static str, value: Result<T, E>) {
        if let Err(why) = value {
            self.add(key, daemon::chain(&why), true);
        }
    }

    fn setting<T>(&mut self, state: &Path, key: SettingKey, now: Configured<T>) {
        match check_setting(state, key, now) {
            Ok(None) => {}
            Ok(Some(warning)) => self.add(key.name(), warning, false),
            Err(why) => self.add(key.name(), daemon::chain(why.as_ref()), true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The findings of a site with this configuration, as `key: text`, the fatal ones with a mark.
    fn found(home: &Path, toml: &str) -> Vec<String> {
        let file = home.join("site.toml");
        std::fs::write(&file, format!("state = \"state\"\n{toml}")).unwrap();
        let findings = findings(&SiteConfig::read(&file).unwrap());
        let shown = |f: &ConfigFinding| {
            let text = f.to_string().replace(&format!("{}/", home.display()), "");
            format!("{}{text}", if f.is_fatal { "! " } else { "" })
        };
        findings.iter().map(shown).collect()
    }

    #[test]
    fn every_value_that_no_daemon_can_start_with_is_named_with_its_line() {
        let home = tempfile::tempdir().unwrap();
        std::fs::write(home.path().join("rules.toml"), "date_fromat = \"dmy\"\n").unwrap();
        std::fs::write(home.path().join("robot.toml"), "name = \"x\"\nradius_m = -1.0\n").unwrap();
        std::fs::write(home.path().join("w.toml"), "scan = 3\n").unwrap();
        for (toml, start, word) in [
            ("models = [\"none.ifc\"]", "! site.toml, line 2: models: none.ifc cannot be read", ""),
            ("models = [\".\"]", "! site.toml, line 2: models: ", "is a folder"),
            ("models = [\"/dev/zero\"]", "! site.toml, line 2: models: ", "it is a device, not a regular file"),
            ("[robot]\nprofile = \"none.toml\"", "! site.toml, line 3: robot.profile: robot profile none.toml", "read"),
            ("[robot]\nprofile = \"robot.toml\"", "! site.toml, line 3: robot.profile: ", "radius_m"),
            ("[robot]\nresolution_m = 0.0", "! site.toml, line 3: robot.resolution_m: ", "0"),
            ("[robot]\nresolution_m = nan", "! site.toml, line 3: robot.resolution_m: ", "NaN"),
            (
                "[schedule]\nrules = \"rules.toml\"",
                "! site.toml, line 3: schedule.rules: rules rules.toml",
                "date_fromat",
            ),
            ("[schedule]\nplan_time = \"soon\"", "! site.toml, line 3: schedule.plan_time: ", "soon"),
            (
                "[schedule]\nplan_time = \"2024-04-15T08:00:00Z\"",
                "! site.toml, line 3: schedule.plan_time: ",
                "site_zone",
            ),
            ("[waypoints]\noptions = \"w.toml\"", "! site.toml, line 3: waypoints.options: ", "scan"),
            ("[world]\noptions = \"none.toml\"", "! site.toml, line 3: world.options: ", "none.toml"),
            ("[align]\nmax_jump_m = -1.0", "! site.toml, line 3: align.max_jump_m: -1", ""),
            ("[align]\nhint = { x_m = nan, y_m = 0.0, yaw_deg = 0.0 }", "! site.toml, line 3: align.hint: ", ""),
            ("[align]\nmap = \"none.yaml\"", "site.toml, line 3: align.map: ", "none.yaml"),
            ("[ros]\nslam_map_topic = \"map\"", "! site.toml, line 3: ros.slam_map_topic: ", "another ros.map_topic"),
            ("[ros]\nqos.map.depth = 0", "! site.toml", "ros.qos: Map: depth is 0"),
            ("[ros]\ndomain_id = 233", "! site.toml, line 3: ros.domain_id: ", "0 to 232"),
            (
                "[ros.sim_time]\nplan_time_at_zero = \"soon\"",
                "! site.toml, line 2: ros.sim_time: ",
                "plan_time_at_zero: ",
            ),
            ("[bus]\nprefix = \"a/b\"", "! site.toml, line 3: bus.prefix: ", ""),
            ("[log]\nlevel = \"daemon=loud\"", "! site.toml, line 3: log.level: ", "loud"),
        ] {
            let found = found(home.path(), toml);
            let [finding] = found.as_slice() else { panic!("{toml}: {found:?}") };
            assert!(finding.starts_with(start) && finding.contains(word), "{toml}: {finding}");
        }
        assert!(!home.path().join("state").exists(), "a check writes nothing");
    }

    #[test]
    fn a_file_whose_content_is_in_force_may_be_gone() {
        let home = tempfile::tempdir().unwrap();
        let profile = home.path().join("robot.toml");
        std::fs::write(&profile, "name = \"x\"\n").unwrap();
        let (state, toml) = (home.path().join("state"), "[robot]\nprofile = \"robot.toml\"");
        daemon::Setting::open(&state, SettingKey::RobotProfile, Robot::configured(Some(&profile))).unwrap();
        std::fs::remove_file(&profile).unwrap();
        let found_now = found(home.path(), toml);
        assert!(
            found_now[0].starts_with("site.toml, line 3: robot.profile: ") && found_now[0].ends_with("stays"),
            "{found_now:?}"
        );
        assert!(found(home.path(), "[robot]\nprofile = \"other.toml\"")[0].starts_with("! "));
    }

    #[test]
    fn models_of_the_site_in_force_may_be_gone() {
        let home = tempfile::tempdir().unwrap();
        std::fs::create_dir(home.path().join("state")).unwrap();
        let loaded = serde_json::json!({ "configured": [home.path().join("a.ifc")] });
        std::fs::write(home.path().join("state/loaded.json"), loaded.to_string()).unwrap();
        let found_now = found(home.path(), "models = [\"a.ifc\"]");
        assert!(
            found_now[0].starts_with("site.toml, line 2: models: ") && found_now[0].ends_with("stays"),
            "{found_now:?}"
        );
        assert!(found(home.path(), "models = [\"b.ifc\"]")[0].starts_with("! "));
    }

    #[test]
    fn the_shipped_configuration_is_usable() {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/site.toml");
        assert_eq!(findings(&SiteConfig::read(&shipped).unwrap()), []);
    }
}
