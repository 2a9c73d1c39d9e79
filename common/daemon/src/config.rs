//! The configuration of a site: a TOML file that all its daemons read; `config/site.toml` explains every key.

use crate::ask_config::AskConfig;
use crate::robot_config::{AlignConfig, NamedRobotConfig, RobotConfig, WaypointConfig, check_robots, separate_bridges};
use crate::ros_config::RosConfig;
use crate::server_config::{
    DecidedOnServer, FollowConfig, ServeConfig, check_ahead, check_certificate, check_link, check_server,
};
use crate::web_config::WebConfig;
use bus::{Domain, DomainError, RobotName};
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_text};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// More threads than this are a mistake.
const MAX_THREADS: u16 = 256;

/// The configuration of a site. Paths are absolute: those in the file count from its folder.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteConfig {
    /// The file that it was read from; empty for a text.
    #[serde(skip)]
    pub file: PathBuf,
    /// Folder of what must survive a daemon: plan time, robot, loaded files, epochs, the site's cache.
    pub state: PathBuf,
    /// IFC files of the site; others may be loaded later.
    #[serde(default)]
    pub models: Vec<PathBuf>,
    /// True to load a file of whose bodies more than half are bounding boxes, because they cannot be meshed.
    #[serde(default)]
    pub allow_boxes: bool,
    /// Threads that each daemon computes with, 1 to 256; as many as the machine has cores if left out.
    #[serde(default)]
    #[schemars(range(min = 1, max = 256))]
    pub threads: Option<u16>,
    /// Which bus.
    #[serde(default)]
    pub bus: BusConfig,
    /// How other users than the bus's own reach it.
    #[serde(default)]
    pub relay: RelayConfig,
    /// Dates.
    #[serde(default)]
    pub schedule: ScheduleConfig,
    /// The robot.
    #[serde(default)]
    pub robot: RobotConfig,
    /// Robots with names, in the place of one without: each has maps of its own, and what `robot`, `waypoints`, `align` and `ros`
    /// say in its table.
    #[serde(default)]
    pub robots: Vec<NamedRobotConfig>,
    /// The named robot that this is the configuration of; `None` for a site as a whole, and for a robot without a name.
    #[serde(skip)]
    pub robot_name: Option<RobotName>,
    /// The state folder of the site: `state`, but for a named robot, whose own lies in it.
    #[serde(skip)]
    pub site_state: PathBuf,
    /// The waypoints.
    #[serde(default)]
    pub waypoints: WaypointConfig,
    /// The robot's own map.
    #[serde(default)]
    pub align: AlignConfig,
    /// The simulation world.
    #[serde(default)]
    pub world: WorldConfig,
    /// ROS 2.
    #[serde(default)]
    pub ros: RosConfig,
    /// The page for browsers.
    #[serde(default)]
    pub web: WebConfig,
    /// Answers to questions over HTTP and MCP.
    #[serde(default)]
    pub ask: AskConfig,
    /// Gives what is drawn to a store, for robots on other machines.
    #[serde(default)]
    pub serve: Option<ServeConfig>,
    /// Shows what the server of the site has drawn: nothing is drawn here.
    #[serde(default)]
    pub follow: Option<FollowConfig>,
    /// The machine's clock.
    #[serde(default)]
    pub clock: ClockConfig,
    /// What is logged.
    #[serde(default)]
    pub log: LogConfig,
}

/// Which bus.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BusConfig {
    /// Begins the names of its segments in shared memory.
    pub prefix: String,
    /// Its folder, in a file system in memory.
    pub root: PathBuf,
}

/// How other users than the bus's own reach it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RelayConfig {
    /// Folder of the sockets; the bus's folder with `-relay` behind it if left out.
    pub folder: Option<PathBuf>,
    /// Group, by name or number, whose members may look at the site; empty for none.
    pub view_group: String,
    /// Group whose members may also send commands; empty for none.
    pub control_group: String,
}

/// Dates.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScheduleConfig {
    /// Rules of dates, as for `groundplan states --schedule`.
    pub rules: Option<PathBuf>,
    /// Schedules of the planner, in the place of that of the models, as for `groundplan states --schedule-file`. They are read
    /// again when they change.
    pub files: Vec<PathBuf>,
    /// Links of their tasks with elements, as for `--link`.
    pub links: Option<PathBuf>,
    /// Plan time until another is set; without one everything is built.
    pub plan_time: Option<String>,
}

/// The simulation world.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorldConfig {
    /// What it is like, as for `groundplan convert --world`.
    pub options: Option<PathBuf>,
    /// True if `groundplan export` writes it unasked.
    pub write: bool,
}

/// The machine's clock.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ClockConfig {
    /// A file that is there while the clock is synchronised; without one it is taken for synchronised.
    pub synchronised_while: Option<PathBuf>,
}

/// What is logged.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LogConfig {
    /// Where to, and how it looks.
    pub format: LogFormat,
    /// Which messages, in the words of RUST_LOG, which goes before; what the daemons have to say if left out.
    pub level: Option<String>,
}

/// Where a log goes, and how it looks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// Lines for people on standard error.
    #[default]
    Terminal,
    /// One JSON document a line on standard error.
    Json,
    /// The journal of systemd, with facts as fields.
    Journald,
}

/// A configuration that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// There is no such file.
    #[error(
        "there is no configuration {}: name that of the site with --config SITE.toml, or start the demo with `groundplan up --demo`",
        path.display()
    )]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be read.
    #[error("configuration {} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong type: the source has line and column.
    #[error("configuration {}", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<toml::de::Error>,
    },
}

impl Default for BusConfig {
    fn default() -> Self {
        Self { prefix: Domain::DEFAULT_PREFIX.to_owned(), root: PathBuf::from(Domain::DEFAULT_ROOT) }
    }
}

impl Default for RelayConfig {
    fn default() -> Self {
        Self { folder: None, view_group: "groundplan-view".to_owned(), control_group: "groundplan".to_owned() }
    }
}

impl SiteConfig {
    /// Threads that each daemon computes with; 0: as many as the machine has cores.
    pub fn n_threads(&self) -> usize {
        self.threads.map_or(0, usize::from)
    }

    /// The bus, as the robot has it that this is the configuration of.
    ///
    /// # Errors
    /// A prefix or folder that does not fit.
    pub fn domain(&self) -> Result<Domain, DomainError> {
        let mut domain = Domain::shared(&self.bus.prefix, &self.bus.root)?;
        if let Some(folder) = &self.relay.folder {
            domain = domain.with_relay(folder)?;
        }
        let domain = domain.with_robots(self.robots.iter().map(|robot| robot.name))?;
        self.robot_name.map_or(Ok(domain.clone()), |robot| domain.of_robot(robot))
    }

    /// Refuses a robot that follows the server of its site, for what is decided where a site is drawn.
    ///
    /// # Errors
    /// Such a robot.
    pub fn check_draws(&self) -> Result<(), DecidedOnServer> {
        self.follow.as_ref().map_or(Ok(()), |follow| Err(follow.decided_on_server()))
    }

    /// Reads a configuration.
    ///
    /// # Errors
    /// A file that cannot be read, or is no TOML of these keys.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let io = |source| ConfigError::Io { path: path.to_owned(), source };
        let text = read_regular_text(path, MAX_CONFIGURATION_BYTES).map_err(|source| match source.kind() {
            std::io::ErrorKind::NotFound => ConfigError::Missing { path: path.to_owned() },
            _ => io(source),
        })?;
        let file = std::fs::canonicalize(path).map_err(io)?;
        let home = file.parent().unwrap_or(Path::new("/")).to_owned();
        let parsed = Self::parse(&text, &home);
        let toml = |path: &Path, source| ConfigError::Toml { path: path.to_owned(), source: Box::new(source) };
        let mut config = parsed.map_err(|source| toml(path, source))?;
        let of_robots = config.robots.iter_mut().map(|robot| &mut robot.ros);
        for ros in std::iter::once(&mut config.ros).chain(of_robots) {
            let Some(options) = ros.options.clone() else { continue };
            let text = read_regular_text(&options, MAX_CONFIGURATION_BYTES)
                .map_err(|source| ConfigError::Io { path: options.clone(), source })?;
            *ros = ros.with_options(&text).map_err(|source| toml(&options, source))?;
        }
        separate_bridges(&mut config.robots).map_err(|source| toml(path, source))?;
        Ok(Self { file, ..config })
    }

    /// The configuration that a text says; its paths count from `home`.
    ///
    /// # Errors
    /// No TOML of these keys.
    pub fn parse(text: &str, home: &Path) -> Result<Self, toml::de::Error> {
        let mut config: Self = toml::from_str(text)?;
        check_robots(&config.robots, text)?;
        let has_files = !config.models.is_empty() || !config.schedule.files.is_empty();
        let has_robots = !config.robots.is_empty();
        check_server(config.follow.as_ref(), [config.serve.is_some(), has_robots, has_files])?;
        check_ahead(config.serve.as_ref())?;
        check_link(config.serve.as_ref(), &config.robot_names())?;
        check_certificate("[web]", config.web.certificate.as_ref(), config.web.key.as_ref())?;
        check_certificate("[ask]", config.ask.certificate.as_ref(), config.ask.key.as_ref())?;
        if let Some(threads) = config.threads
            && !(1..=MAX_THREADS).contains(&threads)
        {
            let why = format!("threads = {threads}: it must be 1 to {MAX_THREADS}, or left out");
            return Err(serde::de::Error::custom(why));
        }
        let lists = config.models.iter_mut().chain(&mut config.schedule.files);
        let paths = lists.chain([&mut config.state, &mut config.bus.root]);
        let of_server = config.serve.iter_mut().flat_map(|serve| serve.paths(home));
        let of_server = of_server.chain(config.follow.iter_mut().flat_map(|follow| follow.paths(home)));
        let optional = [
            &mut config.relay.folder,
            &mut config.schedule.rules,
            &mut config.schedule.links,
            &mut config.robot.profile,
            &mut config.waypoints.options,
            &mut config.align.map,
            &mut config.world.options,
            &mut config.ros.options,
            &mut config.web.certificate,
            &mut config.web.key,
            &mut config.ask.certificate,
            &mut config.ask.key,
            &mut config.clock.synchronised_while,
        ];
        let of_robots = config.robots.iter_mut().flat_map(NamedRobotConfig::paths);
        for path in paths.chain(optional.into_iter().flatten()).chain(of_robots).chain(of_server) {
            *path = home.join(&*path);
        }
        config.site_state = config.state.clone();
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_file_is_read_and_paths_count_from_its_folder() {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/site.toml");
        let config = SiteConfig::read(&shipped).unwrap();
        assert_eq!((config.bus, config.relay), (BusConfig::default(), RelayConfig::default()));
        assert_eq!(config.robot.resolution_m, 0.05);
        assert_eq!(RosConfig { options: None, ..config.ros }, RosConfig::default());
        let profile = config.robot.profile.unwrap();
        assert!(
            config.models[0].is_file() && profile.is_file(),
            "{} {}",
            config.models[0].display(),
            profile.display()
        );
        assert!(!config.world.write && config.world.options.is_some_and(|options| options.is_file()));
        assert!(config.waypoints.options.is_some_and(|options| options.is_file()));
        assert!(config.schedule.rules.is_some_and(|rules| rules.is_file()));
    }

    #[test]
    fn the_shipped_schema_is_that_of_the_types() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/schemas/site.schema.json");
        let schema = serde_json::to_string_pretty(&schemars::schema_for!(SiteConfig)).unwrap() + "\n";
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(&path, &schema).unwrap();
        }
        assert!(std::fs::read_to_string(path).unwrap() == schema, "UPDATE_GOLDEN=1 writes it");
    }

    #[test]
    fn a_number_of_threads_is_one_that_a_machine_can_have() {
        let parse = |toml: &str| SiteConfig::parse(&format!("state = \"x\"\n{toml}"), Path::new("/"));
        assert_eq!([parse("").unwrap().n_threads(), parse("threads = 3").unwrap().n_threads()], [0, 3]);
        for bad in ["threads = 0", "threads = 257", "threads = -1"] {
            assert!(parse(bad).unwrap_err().to_string().contains("threads"), "{bad}");
        }
    }

    #[test]
    fn foxglove_is_served_where_its_table_says_and_only_if_there_is_one() {
        let parse = |toml: &str| SiteConfig::parse(&format!("state = \"x\"\n{toml}"), Path::new("/"));
        let address = |toml: &str| parse(toml).unwrap().ros.foxglove.map(|foxglove| foxglove.address.to_string());
        assert_eq!(address("[ros]\nenabled = true"), None);
        assert_eq!(address("[ros.foxglove]").as_deref(), Some("127.0.0.1:8765"));
        assert_eq!(address("[ros.foxglove]\naddress = \"[::1]:80\"").as_deref(), Some("[::1]:80"));
        assert!(parse("[ros.foxglove]\naddress = \"somewhere\"").unwrap_err().to_string().contains("address"));
    }

    #[test]
    fn what_is_known_of_the_robots_place_is_read_with_the_room_of_its_start_first() {
        let text = "state = \"x\"\n[align]\nstart_room = \"U.04\"\nelevation_m = 3.2\nat = [{ x_m = 1, y_m = -2.5, room = \"9\" }]";
        let known = SiteConfig::parse(text, Path::new("/")).unwrap().align.known_places();
        let points: Vec<_> = known.points_in_rooms().collect();
        assert_eq!(points, [([0.0, 0.0], "U.04"), ([1.0, -2.5], "9")]);
        assert_eq!((known.elevation_m, known.portal.as_deref(), known.is_empty()), (Some(3.2), None, false));
        assert!(AlignConfig::default().known_places().is_empty());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site.toml");
        std::fs::write(&path, "state = \"x\"\nmodel = \"y\"\n").unwrap();
        let text = crate::chain(&SiteConfig::read(&path).unwrap_err());
        assert!(text.contains("model") && text.contains("line 2"), "{text}");
    }
}
