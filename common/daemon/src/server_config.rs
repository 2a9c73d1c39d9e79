//! Configuration of sites on many machines: `[serve]` of the machine that draws, `[follow]` of the robots that show what it drew.

use bus::RobotName;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Gives what is drawn to a store.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServeConfig {
    /// Address of the store: a folder, or `s3://BUCKET/..`.
    pub store: String,
    /// Credentials of the store, a TOML file that only its user can read.
    #[serde(default)]
    pub credentials: Option<PathBuf>,
    /// Name of the site in the store.
    pub site: String,
    /// Private key that signs indices, a PEM file.
    pub key: PathBuf,
    /// The list of keys of the site, signed by its root key.
    pub keys: PathBuf,
    /// Files of each plan time that are given to the store too, as `groundplan export` writes them; none if left out.
    #[serde(default)]
    pub export: BTreeSet<ExportedFiles>,
    /// How many change instants are drawn ahead, where the plan time follows the clock of the machine.
    #[serde(default = "default_ahead")]
    #[schemars(range(max = MAX_AHEAD))]
    pub ahead: u8,
    /// Days that indices of the past stay.
    #[serde(default = "default_keep_days")]
    pub keep_days: u32,
    /// Bytes that indices of the past may take, in gigabytes.
    #[serde(default = "default_keep_gb")]
    pub keep_gb: u32,
    /// Tells robots of new indices at once, and takes what they see; without it they look by themselves.
    #[serde(default)]
    pub link: Option<ServeLinkConfig>,
}

/// The link of a server with its robots.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServeLinkConfig {
    /// Where it listens: `tcp/ADDRESS:PORT` or `tls/ADDRESS:PORT`.
    pub listen: Vec<String>,
    /// Robots that may tell what they see, each under its own name alone.
    #[serde(deserialize_with = "crate::robot_config::robot_names")]
    #[schemars(with = "Vec<String>")]
    pub robots: Vec<RobotName>,
    /// Their passwords, lines `ROBOT:PASSWORD` of a file that only its user can read.
    #[serde(default)]
    pub passwords: Option<PathBuf>,
    /// Certificate of the server, PEM, for `tls`.
    #[serde(default)]
    pub certificate: Option<PathBuf>,
    /// Its private key, PEM.
    #[serde(default)]
    pub key: Option<PathBuf>,
    /// The authority of the robots' certificates, PEM, for `tls`: their common names are those of the robots.
    #[serde(default)]
    pub robots_authority: Option<PathBuf>,
}

/// The link of a robot with the server of its site.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FollowLinkConfig {
    /// Where the server listens: `tcp/HOST:PORT` or `tls/HOST:PORT`; the first that answers is taken.
    pub connect: Vec<String>,
    /// Name of this robot, as the server has it.
    #[serde(deserialize_with = "crate::robot_config::robot_name")]
    #[schemars(with = "String")]
    pub name: RobotName,
    /// Its password, the only line of a file that only its user can read.
    #[serde(default)]
    pub password: Option<PathBuf>,
    /// The authority of the server's certificate, PEM, for `tls`.
    #[serde(default)]
    pub authority: Option<PathBuf>,
    /// Certificate of this robot, PEM, for `tls`.
    #[serde(default)]
    pub certificate: Option<PathBuf>,
    /// Its private key, PEM.
    #[serde(default)]
    pub key: Option<PathBuf>,
}

/// Files that a server exports. Those of every output come with any of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExportedFiles {
    /// What every output has: maps, waypoints, routes, semantic JSON.
    Maps,
    /// `--with-ground`.
    Ground,
    /// `--world`, with the options of `[world]`.
    World,
    /// `--world --usd`.
    Usd,
    /// `--cloud`.
    Cloud,
    /// `--octomap`.
    Octomap,
    /// `--fleet vda5050`.
    Vda5050,
    /// `--fleet lif`.
    Lif,
    /// `--open-rmf`.
    OpenRmf,
}

/// Shows what the server of a site has drawn.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FollowConfig {
    /// Address of the store: a folder, `s3://BUCKET/..`, `https://..` or `http://..`.
    pub store: String,
    /// Credentials of the store, a TOML file that only its user can read.
    #[serde(default)]
    pub credentials: Option<PathBuf>,
    /// Name of the site in the store.
    pub site: String,
    /// Public root keys of the site, `ed25519:..`: what none of them leads to is not shown.
    pub roots: Vec<String>,
    /// Whose maps are shown: a named robot of the server; the one without a name if left out.
    #[serde(default, deserialize_with = "crate::robot_config::optional_robot_name")]
    #[schemars(with = "Option<String>")]
    pub robot: Option<RobotName>,
    /// Storeys that are fetched: index, GlobalId or name; all if left out.
    #[serde(default)]
    pub storeys: Vec<String>,
    /// Folder for the exported files of what is shown, where the server gives them to the store.
    #[serde(default)]
    pub files: Option<PathBuf>,
    /// Seconds between looks at the index.
    #[serde(default = "default_poll_s")]
    #[schemars(range(min = *POLLS_S.start(), max = *POLLS_S.end()))]
    pub poll_s: u16,
    /// Hears of new indices at once, and tells the server what this robot sees.
    #[serde(default)]
    pub link: Option<FollowLinkConfig>,
}

impl ServeConfig {
    /// Paths of files. A store that is a folder counts from `home` from here on.
    pub(crate) fn paths(&mut self, home: &Path) -> impl Iterator<Item = &mut PathBuf> {
        count_from(home, &mut self.store);
        let of_link = self.link.iter_mut().flat_map(ServeLinkConfig::paths);
        [&mut self.key, &mut self.keys].into_iter().chain(&mut self.credentials).chain(of_link)
    }
}

impl FollowConfig {
    /// What is decided where a site is drawn is not decided here.
    pub(crate) fn decided_on_server(&self) -> DecidedOnServer {
        DecidedOnServer { site: self.site.clone(), store: self.store.clone() }
    }

    /// Paths of files. A store that is a folder counts from `home` from here on.
    pub(crate) fn paths(&mut self, home: &Path) -> impl Iterator<Item = &mut PathBuf> {
        count_from(home, &mut self.store);
        let of_link = self.link.iter_mut().flat_map(FollowLinkConfig::paths);
        self.credentials.iter_mut().chain(&mut self.files).chain(of_link)
    }

    /// Whose maps are shown, as the index of the server has it.
    pub fn robot_in_index(&self) -> &str {
        self.robot.as_ref().map_or(UNNAMED_ROBOT, RobotName::as_str)
    }
}

impl ServeLinkConfig {
    fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let Self { passwords, certificate, key, robots_authority, .. } = self;
        [passwords, certificate, key, robots_authority].into_iter().flatten()
    }
}

impl FollowLinkConfig {
    fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let Self { password, authority, certificate, key, .. } = self;
        [password, authority, certificate, key].into_iter().flatten()
    }
}

/// So many robots can have a link with their server.
pub const MAX_LINKED_ROBOTS: usize = 1_000;

/// So many change instants can be drawn ahead.
const MAX_AHEAD: u8 = 64;

/// Seconds that may lie between looks at an index.
const POLLS_S: RangeInclusive<u16> = 1..=3600;

/// The name under which an index has the maps of a robot without one.
pub const UNNAMED_ROBOT: &str = "robot";

fn count_from(home: &Path, store: &mut String) {
    if !store.contains("://") {
        *store = home.join(&*store).to_string_lossy().into_owned();
    }
}

/// Something was to be decided on a robot that is decided on the server of its site.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("this robot follows the site {site} of {store}: this is decided there, on the server of the site")]
pub struct DecidedOnServer {
    /// Name of the site.
    site: String,
    /// Its store.
    store: String,
}

/// Refuses what cannot be together: one bus has the maps that are drawn on it, or those of a server.
///
/// The last three say whether the configuration has `[serve]`, `[[robots]]`, and models or schedule files.
pub(crate) fn check_server(
    follow: Option<&FollowConfig>,
    [serves, has_robots, has_files]: [bool; 3],
) -> Result<(), toml::de::Error> {
    let Some(follow) = follow else { return Ok(()) };
    let refused = |why: &str| Err(serde::de::Error::custom(why.to_owned()));
    if serves {
        return refused("[follow] and [serve]: a site is drawn here and served, or its server is followed");
    }
    if has_robots {
        return refused(
            "[follow] and [[robots]]: one robot follows on one bus; [follow] robot says whose maps it shows",
        );
    }
    if has_files {
        return refused(
            "[follow] with models or schedule files: the server of the site has them, and nothing is drawn here",
        );
    }
    if follow.roots.is_empty() {
        return refused("[follow] roots: without a root key of the site nothing of it can be believed");
    }
    if let Some(link) = &follow.link {
        check_certificate("[follow.link]", link.certificate.as_ref(), link.key.as_ref())?;
    }
    if !POLLS_S.contains(&follow.poll_s) {
        return refused("[follow] poll_s must be 1 to 3600");
    }
    Ok(())
}

/// Refuses more sets ahead than are drawn while a plan time holds.
pub(crate) fn check_ahead(serve: Option<&ServeConfig>) -> Result<(), toml::de::Error> {
    match serve.map(|serve| serve.ahead).filter(|ahead| *ahead > MAX_AHEAD) {
        None => Ok(()),
        Some(ahead) => Err(serde::de::Error::custom(format!("[serve] ahead = {ahead}: {MAX_AHEAD} is the most"))),
    }
}

/// Refuses a link of robots without names: whose observation counts could not be told.
pub(crate) fn check_link(serve: Option<&ServeConfig>, drawn: &[RobotName]) -> Result<(), toml::de::Error> {
    let Some(link) = serve.and_then(|serve| serve.link.as_ref()) else { return Ok(()) };
    let refused = |why: String| Err(serde::de::Error::custom(why));
    if drawn.is_empty() {
        return refused("[serve.link] without [[robots]]: the robots of the site need names".to_owned());
    }
    if link.robots.is_empty() || link.robots.len() > MAX_LINKED_ROBOTS {
        return refused(format!("[serve.link] robots: 1 to {MAX_LINKED_ROBOTS} names"));
    }
    let mut names = link.robots.clone();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return refused(format!("[serve.link] robots: {} is there twice", twice[0]));
    }
    if let Some(twice) = link.robots.iter().find(|robot| drawn.contains(robot)) {
        return refused(format!(
            "[serve.link] robots: {twice} is one of [[robots]], whose observations come from this machine: robots with a link have other names"
        ));
    }
    check_certificate("[serve.link]", link.certificate.as_ref(), link.key.as_ref())
}

/// Refuses a certificate without its private key, and a key without a certificate.
pub(crate) fn check_certificate(
    table: &str,
    certificate: Option<&PathBuf>,
    key: Option<&PathBuf>,
) -> Result<(), toml::de::Error> {
    match certificate.is_some() == key.is_some() {
        true => Ok(()),
        false => Err(serde::de::Error::custom(format!("{table}: certificate and key belong together"))),
    }
}

fn default_ahead() -> u8 {
    3
}

fn default_keep_days() -> u32 {
    365
}

fn default_keep_gb() -> u32 {
    100
}

fn default_poll_s() -> u16 {
    5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::SiteConfig;

    const FOLLOW: &str = "state = \"x\"\n[follow]\nstore = \"maps\"\nsite = \"tower\"\nroots = [\"ed25519:A\"]\n";

    fn parse(text: &str) -> Result<SiteConfig, toml::de::Error> {
        SiteConfig::parse(text, Path::new("/srv"))
    }

    #[test]
    fn a_store_in_a_folder_counts_from_the_file_and_an_address_does_not() {
        let follow = parse(FOLLOW).unwrap().follow.unwrap();
        assert_eq!((follow.store.as_str(), follow.robot_in_index(), follow.poll_s), ("/srv/maps", "robot", 5));
        let follow = parse(&FOLLOW.replace("maps", "https://site.example/maps")).unwrap().follow.unwrap();
        assert_eq!(follow.store, "https://site.example/maps");
    }

    #[test]
    fn files_to_be_exported_are_named_as_the_command_names_them() {
        let serve = |export: &str| {
            let text = "state = \"x\"\n[serve]\nstore = \"s\"\nsite = \"t\"\nkey = \"k\"\nkeys = \"l\"\n";
            parse(&format!("{text}{export}")).map(|config| config.serve.unwrap().export)
        };
        assert!(serve("").unwrap().is_empty(), "none if left out");
        let some = serve("export = [\"open-rmf\", \"vda5050\", \"vda5050\"]\n").unwrap();
        assert!(some.into_iter().eq([ExportedFiles::Vda5050, ExportedFiles::OpenRmf]));
        let why = serve("export = [\"gazebo\"]\n").unwrap_err().to_string();
        assert!(why.contains("gazebo") && why.contains("open-rmf"), "{why}");
        let follow = parse(&format!("{FOLLOW}files = \"files\"\n")).unwrap().follow.unwrap();
        assert_eq!(follow.files.as_deref(), Some(Path::new("/srv/files")));
    }

    #[test]
    fn so_many_sets_ahead_as_the_schema_allows_are_taken() {
        let ahead = |n: u8| {
            parse(&format!(
                "state = \"x\"\n[serve]\nstore = \"s\"\nsite = \"t\"\nkey = \"k\"\nkeys = \"l\"\nahead = {n}\n"
            ))
        };
        assert!(ahead(64).is_ok() && ahead(65).unwrap_err().to_string().contains("64 is the most"));
    }

    #[test]
    fn what_cannot_be_together_is_refused_with_a_reason() {
        let serve = "[serve]\nstore = \"s\"\nsite = \"t\"\nkey = \"k\"\nkeys = \"l\"\n";
        for (more, word) in [
            (serve, "[serve]"),
            ("[[robots]]\nname = \"a\"\n", "[[robots]]"),
            ("[schedule]\nfiles = [\"a.xer\"]\n", "schedule files"),
        ] {
            let why = parse(&format!("{FOLLOW}{more}")).unwrap_err().to_string();
            assert!(why.contains(word), "{why}");
        }
        let serve = "state = \"x\"\n[serve]\nstore = \"s\"\nsite = \"t\"\nkey = \"k\"\nkeys = \"l\"\n[serve.link]\nlisten = []\n";
        let robots = "[[robots]]\nname = \"scout\"\n";
        for (text, word) in [
            (format!("{serve}robots = [\"a\"]\n"), "[[robots]]"),
            (format!("{serve}robots = []\n{robots}"), "1 to 1000"),
            (format!("{serve}robots = [\"a\", \"b\", \"a\"]\n{robots}"), "a is there twice"),
            (format!("{serve}robots = [\"A B\"]\n{robots}"), "no name of a robot"),
            (format!("{serve}robots = [\"scout\"]\n{robots}"), "is one of [[robots]]"),
            (format!("{serve}robots = [\"a\"]\nkey = \"k\"\n{robots}"), "belong together"),
            (format!("{FOLLOW}[follow.link]\nconnect = []\nname = \"a\"\nkey = \"k\"\n"), "belong together"),
            ("state = \"x\"\n[web]\nkey = \"k\"\n".to_owned(), "[web]: certificate and key belong together"),
            ("state = \"x\"\n[ask]\ncertificate = \"c\"\n".to_owned(), "[ask]: certificate and key belong together"),
        ] {
            let why = parse(&text).unwrap_err().to_string();
            assert!(why.contains(word), "{why}");
        }
        let linked = parse(&format!("{serve}robots = [\"a\", \"b\"]\n{robots}")).unwrap();
        let names: Vec<String> = linked.observers().iter().map(ToString::to_string).collect();
        assert_eq!(names, ["a", "b", "scout"]);
        assert!(parse(&FOLLOW.replace("[\"ed25519:A\"]", "[]")).is_err());
        assert!(parse(&format!("{FOLLOW}poll_s = 0\n")).is_err());
    }
}
