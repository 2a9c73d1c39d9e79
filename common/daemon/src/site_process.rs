//! The processes of a site that report on its status board.

use crate::config::SiteConfig;
use bus::Daemon;
use std::fmt;

/// A process of a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteProcess {
    /// A participant of the bus.
    Daemon(Daemon),
    /// Creates the bus and removes resources of dead participants.
    Keeper,
    /// Serves users other than the bus's own.
    Relay,
}

impl SiteProcess {
    /// All that `groundplan up` starts and starts again for a site, in the order of the start.
    pub fn supervised(config: &SiteConfig) -> impl Iterator<Item = Self> + use<> {
        let daemons = Daemon::SUPERVISED.into_iter().map(Self::Daemon);
        let bridge = config.ros.enabled.then_some(Self::Daemon(Daemon::RosBridge));
        let web = config.web.enabled.then_some(Self::Daemon(Daemon::Web));
        std::iter::once(Self::Keeper).chain(daemons).chain(bridge).chain(web).chain(std::iter::once(Self::Relay))
    }

    /// Its name, as of its process or its command.
    pub fn name(self) -> &'static str {
        match self {
            Self::Daemon(daemon) => daemon.name(),
            Self::Keeper => "keeper",
            Self::Relay => "relay",
        }
    }
}

impl From<Daemon> for SiteProcess {
    fn from(daemon: Daemon) -> Self {
        Self::Daemon(daemon)
    }
}

impl fmt::Display for SiteProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
