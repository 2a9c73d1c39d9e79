//! The keeper: creates the bus, cleans up behind the dead, does nothing else.

use crate::cli::KeeperArgs;
use crate::failure::Failure;
use bus::Keeper;
use daemon::StopSignal;
use std::time::Duration;
use tracing::{info, warn};

/// How often the dead are looked for.
const TICK: Duration = Duration::from_secs(1);

/// Holds the bus until it is told to stop.
///
/// # Errors
/// A bus that cannot be created.
pub fn keeper(arguments: &KeeperArgs) -> Result<String, Failure> {
    let config = arguments.site.config()?;
    let domain = config.bus.domain().map_err(Failure::usage)?;
    let mut stop = StopSignal::listen(arguments.with_stdin).map_err(Failure::work)?;
    let keeper = Keeper::start(&domain).map_err(Failure::work)?;
    info!(service = "keeper", generation = keeper.generation(), "bus created");
    daemon::ready("holds the bus");
    while !stop.is_raised_within(TICK) {
        daemon::alive("holds the bus");
        match keeper.tick() {
            Ok(0) => {}
            Ok(dead) => info!(service = "keeper", dead, "cleaned up behind dead participants"),
            Err(why) => warn!(service = "keeper", error = daemon::chain(&why), "cannot clean up"),
        }
    }
    daemon::stopping();
    Ok(String::new())
}
