//! Identity of a bus: name prefix and folder on this machine, the folder of its relay, and the robots of its site.

use crate::accounts::user_text;
use crate::error::{DomainError, PortError};
use crate::generation::Place;
use crate::limits::MAX_ROBOTS;
use crate::robot_name::{OfRobot, Owned, RobotName, names_of_robots};
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Names of sockets have 107 bytes; `control.sock` leaves this for the folder.
const MAX_RELAY_BYTES: usize = 94;

/// A bus. Domains with another prefix and another folder know nothing of each other.
#[derive(Debug, Clone)]
pub struct Domain {
    pub(crate) place: Place,
    relay_folder: PathBuf,
    robots: Robots,
}

/// The robots of a site, and the one of them that is meant.
#[derive(Debug, Clone, Default)]
pub(crate) struct Robots {
    /// In the order of their names; none for a site whose robot has no name.
    all: Vec<RobotName>,
    /// The robot whose topics and daemons are meant.
    own: Option<RobotName>,
}

impl Robots {
    /// One named robot.
    pub(crate) fn one(robot: RobotName) -> Self {
        Self { all: vec![robot], own: Some(robot) }
    }

    /// The same with another robot meant, or none.
    ///
    /// # Errors
    /// A robot that the site does not have.
    pub(crate) fn meaning(&self, robot: Option<RobotName>) -> Result<Self, DomainError> {
        match robot {
            Some(robot) if !self.all.contains(&robot) => {
                Err(DomainError::NoSuchRobot { robot, robots: names_of_robots(&self.all) })
            }
            own => Ok(Self { all: self.all.clone(), own }),
        }
    }

    /// The robot that is meant.
    pub(crate) fn own(&self) -> Option<RobotName> {
        self.own
    }

    /// All of them; none for a site whose robot has no name.
    pub(crate) fn all(&self) -> &[RobotName] {
        &self.all
    }

    /// Which topic or daemon is meant.
    ///
    /// # Errors
    /// One of a robot of a site that has named ones, and none is meant.
    pub(crate) fn find<T: Owned>(&self, what: T, name: impl Fn() -> String) -> Result<OfRobot<T>, PortError> {
        if what.is_of_robot() && self.own.is_none() && !self.all.is_empty() {
            return Err(PortError::NoRobotNamed { what: name(), robots: names_of_robots(&self.all) });
        }
        Ok(OfRobot::new(self.own, what))
    }
}

impl Domain {
    /// Prefix of a machine's bus, with the version of the library, whose formats no other version opens.
    pub const DEFAULT_PREFIX: &'static str = "gp010_";

    /// Folder of a machine's bus.
    pub const DEFAULT_ROOT: &'static str = "/run/groundplan";

    /// A bus in shared memory. `prefix` begins the names of its segments: at most 15 letters and digits and an underscore,
    /// so that it is not the beginning of another's. `root` is an absolute folder of at most 48 bytes, because sockets lie
    /// in it, on a file system in memory such as `/run`: the bus library syncs each of its hundreds of files. It is for the
    /// bus's user alone. The sockets of the relay lie in `<root>-relay`.
    ///
    /// # Errors
    /// A prefix or folder that does not fit.
    pub fn shared(prefix: &str, root: impl AsRef<Path>) -> Result<Self, DomainError> {
        let root = root.as_ref();
        let mut relay_folder = root.as_os_str().to_owned();
        relay_folder.push("-relay");
        Ok(Self { place: Place::new(prefix, root)?, relay_folder: relay_folder.into(), robots: Robots::default() })
    }

    /// The same bus with the sockets of its relay in an absolute folder of at most 94 bytes.
    ///
    /// # Errors
    /// A folder that does not fit.
    pub fn with_relay(self, folder: impl Into<PathBuf>) -> Result<Self, DomainError> {
        let relay_folder = folder.into();
        if !relay_folder.is_absolute() || relay_folder.as_os_str().len() > MAX_RELAY_BYTES {
            return Err(DomainError::RelayFolder { folder: relay_folder, max: MAX_RELAY_BYTES });
        }
        Ok(Self { relay_folder, ..self })
    }

    /// The bus of a site with these named robots, in the place of one without a name: each has topics and daemons of its own.
    ///
    /// # Errors
    /// A name that is there twice, more than [`MAX_ROBOTS`].
    pub fn with_robots(self, robots: impl IntoIterator<Item = RobotName>) -> Result<Self, DomainError> {
        let mut all: Vec<RobotName> = robots.into_iter().collect();
        all.sort_unstable();
        if let Some(twice) = all.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(DomainError::RobotTwice { robot: twice[0] });
        }
        if all.len() > MAX_ROBOTS {
            return Err(DomainError::ManyRobots { n_robots: all.len() });
        }
        Ok(Self { robots: Robots { all, own: None }, ..self })
    }

    /// The same bus as one of its named robots has it: what is a robot's means this one's.
    ///
    /// # Errors
    /// A robot that the site does not have.
    pub fn of_robot(self, robot: RobotName) -> Result<Self, DomainError> {
        let robots = self.robots.meaning(Some(robot))?;
        Ok(Self { robots, ..self })
    }

    /// The named robots, in the order of their names; none for a site whose robot has no name.
    pub fn robots(&self) -> &[RobotName] {
        &self.robots.all
    }

    /// The robot that is meant, on a site with named ones.
    pub fn robot(&self) -> Option<RobotName> {
        self.robots.own
    }

    /// The robots, and the one of them that is meant.
    pub(crate) fn scope(&self) -> Robots {
        self.robots.clone()
    }

    /// The folder of the relay's sockets.
    pub fn relay_folder(&self) -> &Path {
        &self.relay_folder
    }

    /// The user who owns the bus, if that is not the user of this process.
    pub(crate) fn foreign_owner(&self) -> Result<Option<u32>, DomainError> {
        let own = rustix::process::geteuid().as_raw();
        Ok(self.place.owner()?.filter(|owner| *owner != own))
    }

    /// Refuses the bus of another user.
    pub(crate) fn require_own(&self) -> Result<(), DomainError> {
        self.foreign_owner()?.map_or(Ok(()), |owner| Err(DomainError::Foreign { owner: user_text(owner) }))
    }

    /// True if a keeper lives; `None` if this user may not know.
    pub fn has_keeper(&self) -> Option<bool> {
        match File::open(self.place.keeper_lock_path()) {
            Ok(file) => Some(matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock))),
            Err(error) if error.kind() == ErrorKind::NotFound => Some(false),
            Err(_) => None,
        }
    }
}
