//! The relay's participation in one generation of the bus.

use super::feeds::Feeds;
use crate::bus::Bus;
use crate::domain::Domain;
use crate::error::DomainError;
use crate::names::Daemon;
use crate::robot_name::RobotName;
use crate::status::StatusReader;
use crate::waiter::Waiter;

/// What it has open.
pub(super) struct Session {
    pub(super) feeds: Feeds,
    /// Heartbeats of the site's daemons, and of those of each named robot.
    pub(super) status: Vec<(Option<RobotName>, StatusReader)>,
    pub(super) bus: Bus,
    pub(super) waiter: Waiter,
}

impl Session {
    /// Joins the bus.
    pub(super) fn join(domain: &Domain) -> Result<Self, DomainError> {
        let (bus, waiter) = Bus::join_as_owner(domain, Daemon::Groundplan)?;
        let status = bus.status_streams();
        let status = status
            .map_err(|error| DomainError::Refused { what: "status stream".to_owned(), reason: error.to_string() })?;
        Ok(Self { feeds: Feeds::default(), status, bus, waiter })
    }
}
