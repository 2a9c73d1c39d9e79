//! Configuration of groundplan-ask: `[ask]` of a site.

use crate::robot_config::optional_robot_name;
use bus::RobotName;
use schemars::JsonSchema;
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// Answers to questions about the site, over HTTP and MCP.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AskConfig {
    /// True to run groundplan-ask.
    pub enabled: bool,
    /// Address and port. Another address than one of the machine itself asks for a token.
    #[schemars(with = "String")]
    pub listen: SocketAddr,
    /// The robot whose maps are asked about, of a site with several.
    #[serde(deserialize_with = "optional_robot_name")]
    #[schemars(with = "Option<String>")]
    pub robot: Option<RobotName>,
    /// Names, without a port, by which clients may call this server, beside `localhost` and addresses as numbers: those of the
    /// machine and of proxies before it.
    pub hosts: Vec<String>,
    /// Certificate, a PEM file: it answers by https with it and `key`.
    pub certificate: Option<PathBuf>,
    /// Its private key, a PEM file.
    pub key: Option<PathBuf>,
}

impl Default for AskConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 8643)),
            robot: None,
            hosts: Vec::new(),
            certificate: None,
            key: None,
        }
    }
}
