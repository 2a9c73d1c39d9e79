//! Configuration of groundplan-web: `[web]` of a site.

use crate::robot_config::optional_robot_name;
use bus::RobotName;
use schemars::JsonSchema;
use serde::Deserialize;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// The page that shows the site in browsers.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WebConfig {
    /// True to run groundplan-web.
    pub enabled: bool,
    /// Address and port of the page. Another address than one of the machine itself asks viewers for a token.
    #[schemars(with = "String")]
    pub listen: SocketAddr,
    /// The robot whose maps it shows, of a site with several.
    #[serde(deserialize_with = "optional_robot_name")]
    #[schemars(with = "Option<String>")]
    pub robot: Option<RobotName>,
    /// True to let viewers set the plan time and confirm absent elements.
    pub allow_control: bool,
    /// Certificate, a PEM file: the page is served by https with it and `key`.
    pub certificate: Option<PathBuf>,
    /// Its private key, a PEM file.
    pub key: Option<PathBuf>,
}

impl Default for WebConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 8642)),
            robot: None,
            allow_control: false,
            certificate: None,
            key: None,
        }
    }
}
