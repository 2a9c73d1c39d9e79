//! Settings of both ends of a link, and the configuration of zenoh that they make.

use crate::error::LinkError;
use crate::secret::{read_names, read_password};
use crate::{MAX_MESSAGE_BYTES, keys};
use serde_json::{Value, json};
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use zenoh::Config;

/// The end of the server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerSettings {
    /// Name of the site.
    pub site: String,
    /// Where it listens: `tcp/ADDRESS:PORT` or `tls/ADDRESS:PORT`.
    pub listen: Vec<String>,
    /// Robots that may speak.
    pub robots: Vec<String>,
    /// Lines `ROBOT:PASSWORD`, a file that only its user can read.
    pub passwords: Option<PathBuf>,
    /// Certificate and private key of the server, PEM files: for `tls`.
    pub identity: Option<Identity>,
    /// The authority whose certificates robots need, PEM; their common names are those of the robots.
    pub robots_authority: Option<PathBuf>,
}

/// A certificate with its private key, PEM files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// The certificate.
    pub certificate: PathBuf,
    /// The private key.
    pub key: PathBuf,
}

/// The end of a robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RobotSettings {
    /// Name of the site.
    pub site: String,
    /// Name of the robot, as the server knows it.
    pub robot: String,
    /// Where the server listens: `tcp/HOST:PORT` or `tls/HOST:PORT`; the first that answers is taken.
    pub connect: Vec<String>,
    /// The robot's password, a file that only its user can read.
    pub password: Option<PathBuf>,
    /// The authority that signed the server's certificate, PEM: for `tls`.
    pub authority: Option<PathBuf>,
    /// Certificate and private key of the robot, PEM files.
    pub identity: Option<Identity>,
}

impl ServerSettings {
    /// What keeps these settings from being used, as far as they say so by themselves.
    ///
    /// # Errors
    /// Settings that do not fit together.
    pub fn check(&self) -> Result<(), LinkError> {
        let refused = |why: String| Err(LinkError::Settings(why));
        if self.listen.is_empty() || self.robots.is_empty() {
            return refused("a link needs an address to listen on, and the names of the robots".to_owned());
        }
        for endpoint in &self.listen {
            let (protocol, address) = parts(endpoint)?;
            if protocol == "tls" && self.identity.is_none() {
                return refused(format!("{endpoint} needs a certificate and its key"));
            }
            let is_known = self.passwords.is_some() || self.robots_authority.is_some() && protocol == "tls";
            if !is_known && !is_own_machine(address) {
                return refused(format!(
                    "{endpoint} is for others than this machine: it needs passwords, or tls with robots_authority, or any name could be \
                     taken there"
                ));
            }
        }
        Ok(())
    }

    /// The robots that may speak, and which password or certificate tells them.
    fn subjects(&self) -> Value {
        let is_open = self.passwords.is_none() && self.robots_authority.is_none();
        let subjects = self.robots.iter().map(|robot| match (is_open, &self.passwords) {
            // On its own machine alone: see `check`.
            (true, _) => json!({ "id": robot }),
            (false, Some(_)) => json!({ "id": robot, "usernames": [robot] }),
            (false, None) => json!({ "id": robot, "cert_common_names": [robot] }),
        });
        subjects.collect()
    }

    /// Rules by which a robot hears what is for it, and speaks under its own name. What is not allowed is denied.
    fn access_control(&self) -> Value {
        let (index, server) = (keys::index(&self.site), keys::server(&self.site));
        let mut rules = vec![
            json!({
                "id": "hears", "permission": "allow", "flows": ["egress"], "key_exprs": [index],
                "messages": ["put"],
            }),
            json!({
                "id": "asks_to_hear", "permission": "allow", "flows": ["ingress"], "key_exprs": [index],
                "messages": ["declare_subscriber"],
            }),
            json!({
                "id": "asks_for_server", "permission": "allow", "flows": ["ingress"], "key_exprs": [server],
                "messages": ["declare_liveliness_subscriber", "liveliness_query"],
            }),
            json!({
                "id": "sees_server", "permission": "allow", "flows": ["egress"], "key_exprs": [server],
                "messages": ["liveliness_token", "reply"],
            }),
        ];
        let mut policies = Vec::new();
        for robot in &self.robots {
            let own = keys::told(&self.site, robot, "*");
            let [tells, is_answered] = ["tells", "is_answered"].map(|what| format!("{what}:{robot}"));
            rules.push(json!({
                "id": tells, "permission": "allow", "flows": ["ingress"], "key_exprs": [own],
                "messages": ["query", "liveliness_token"],
            }));
            // Of the server's queryable for all robots a robot sees that it is there.
            rules.push(json!({
                "id": is_answered, "permission": "allow", "flows": ["egress"],
                "key_exprs": [keys::told(&self.site, "*", "*")], "messages": ["reply", "declare_queryable"],
            }));
            let rules = json!(["hears", "asks_to_hear", "asks_for_server", "sees_server", tells, is_answered]);
            policies.push(json!({ "rules": rules, "subjects": [robot] }));
        }
        json!({
            "enabled": true, "default_permission": "deny", "rules": rules, "subjects": self.subjects(),
            "policies": policies,
        })
    }

    /// # Errors
    /// Settings that do not fit together, passwords that cannot be used.
    pub(crate) fn config(&self) -> Result<Config, LinkError> {
        self.check()?;
        let mut auth = json!({});
        if let Some(path) = &self.passwords {
            let known = read_names(path)?;
            if let Some(robot) = self.robots.iter().find(|robot| !known.contains(robot)) {
                return Err(LinkError::Settings(format!("{} has no password of {robot}", path.display())));
            }
            auth = json!({ "usrpwd": { "dictionary_file": text(path) } });
        }
        let mut tls = json!({});
        if let Some(identity) = &self.identity {
            tls["listen_certificate"] = text(&identity.certificate);
            tls["listen_private_key"] = text(&identity.key);
        }
        if let Some(authority) = &self.robots_authority {
            tls["root_ca_certificate"] = text(authority);
            tls["enable_mtls"] = true.into();
        }
        let mut config = common(auth, tls);
        config["mode"] = "router".into();
        config["listen"] = json!({ "endpoints": self.listen });
        config["access_control"] = self.access_control();
        parsed(&config)
    }
}

impl RobotSettings {
    /// What keeps these settings from being used, as far as they say so by themselves.
    ///
    /// # Errors
    /// Settings that do not fit together.
    pub fn check(&self) -> Result<(), LinkError> {
        if self.connect.is_empty() {
            return Err(LinkError::Settings("a link needs the address of the server".to_owned()));
        }
        self.connect.iter().try_for_each(|endpoint| parts(endpoint).map(drop))
    }

    /// # Errors
    /// Settings that do not fit together, a password that cannot be used.
    pub(crate) fn config(&self) -> Result<Config, LinkError> {
        self.check()?;
        let mut auth = json!({});
        if let Some(path) = &self.password {
            auth = json!({ "usrpwd": { "user": self.robot, "password": read_password(path)? } });
        }
        let mut tls = json!({});
        if let Some(authority) = &self.authority {
            tls["root_ca_certificate"] = text(authority);
        }
        if let Some(identity) = &self.identity {
            tls["enable_mtls"] = true.into();
            tls["connect_certificate"] = text(&identity.certificate);
            tls["connect_private_key"] = text(&identity.key);
        }
        let mut config = common(auth, tls);
        config["mode"] = "client".into();
        // Whoever opens the link tries again.
        let retry = json!({ "period_init_ms": 500, "period_max_ms": 5_000, "period_increase_factor": 2 });
        config["connect"] =
            json!({ "endpoints": self.connect, "timeout_ms": 0, "exit_on_failure": true, "retry": retry });
        parsed(&config)
    }
}

/// What both ends have: nobody is looked for, nobody is told of.
fn common(auth: Value, tls: Value) -> Value {
    json!({
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "adminspace": { "enabled": false },
        "transport": {
            "auth": auth,
            "link": { "tls": tls, "rx": { "max_message_size": MAX_MESSAGE_BYTES + (64 << 10) } },
        },
    })
}

fn parsed(config: &Value) -> Result<Config, LinkError> {
    Config::from_json5(&config.to_string()).map_err(|why| LinkError::Settings(why.to_string()))
}

fn text(path: &Path) -> Value {
    path.to_string_lossy().into_owned().into()
}

/// Protocol and address of an endpoint.
fn parts(endpoint: &str) -> Result<(&str, &str), LinkError> {
    let parts = endpoint.split_once('/').filter(|(protocol, _)| ["tcp", "tls"].contains(protocol));
    let parts =
        parts.filter(|(_, address)| address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok()));
    // What follows these characters would be other settings.
    let parts = parts.filter(|(_, address)| !address.contains(['?', '#', '/']));
    parts.ok_or_else(|| LinkError::Settings(format!("{endpoint:?} is no endpoint: tcp/HOST:PORT or tls/HOST:PORT")))
}

fn is_own_machine(address: &str) -> bool {
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    host == "localhost"
        || address.parse::<SocketAddr>().is_ok_and(|address| address.ip().is_loopback())
        || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(listen: &str) -> ServerSettings {
        ServerSettings {
            site: "tower".to_owned(),
            listen: vec![listen.to_owned()],
            robots: vec!["a".to_owned(), "b".to_owned()],
            passwords: None,
            identity: None,
            robots_authority: None,
        }
    }

    #[test]
    fn a_server_without_passwords_listens_on_its_own_machine_alone() {
        for own in ["tcp/127.0.0.1:7447", "tcp/localhost:7447", "tcp/[::1]:7447"] {
            settings(own).check().unwrap();
        }
        for open in ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "tcp/192.168.1.2:7447", "tcp/site.example:7447"] {
            let why = settings(open).check().unwrap_err().to_string();
            assert!(why.contains("passwords"), "{why}");
            let known = ServerSettings { passwords: Some("x".into()), ..settings(open) };
            known.check().unwrap();
        }
        // Certificates of robots count where they are asked for.
        let authority = ServerSettings { robots_authority: Some("x".into()), ..settings("tcp/0.0.0.0:7447") };
        assert!(authority.check().is_err());
        assert!(settings("tls/127.0.0.1:7447").check().unwrap_err().to_string().contains("certificate"));
    }

    #[test]
    fn endpoints_of_other_protocols_or_with_settings_of_their_own_are_refused() {
        for wrong in [
            "udp/127.0.0.1:1",
            "tcp/127.0.0.1",
            "tcp/127.0.0.1:x",
            "127.0.0.1:1",
            "tcp/127.0.0.1:1#iface=lo",
            "tcp/a?b:1",
        ] {
            assert!(settings(wrong).check().is_err(), "{wrong}");
        }
    }

    #[test]
    fn zenoh_takes_the_configuration_of_both_ends() {
        settings("tcp/127.0.0.1:7447").config().unwrap();
        let robot = RobotSettings {
            site: "tower".to_owned(),
            robot: "a".to_owned(),
            connect: vec!["tls/site.example:7447".to_owned()],
            password: None,
            authority: Some("ca.pem".into()),
            identity: Some(Identity { certificate: "a.pem".into(), key: "a-key.pem".into() }),
        };
        robot.config().unwrap();
    }
}
