//! A site for robots on other machines: the topics of its drawing daemons in, blobs and a signed index in a store out.
//!
//! # Guarantees
//!
//! - An index has archives that belong together, as they are on the bus: of every robot of the site, of one schedule state.
//! - Blobs come before the index that names them; an index of an epoch is created once, and its epoch is one above that of the store, so
//!   that two servers of one site cannot both publish, and the second one says so.
//! - What a store has lost of the newest index is noticed when the server starts, and given to it again.
//! - Another list of keys, and a store that was set back, give a new index at the start, also where nothing else has changed: robots
//!   learn which keys are revoked, and wait for no epoch that does not come.
//! - Where the plan time follows the clock, sets of the next change instants are drawn with the stages, from the same archives: what is
//!   drawn later on the bus has the same bytes. Where the schedule that is evaluated for that is not the one in force, there are none,
//!   and the index says why.
//! - Files that `[serve] export` asks for have the bytes of `groundplan export` at that plan time. They are made once all maps are in the
//!   store, and are in the index of the next epoch; a newer set ends their making, and waits at most for the one format that is under
//!   way. Where nothing is asked for, or all files are there, there is no such epoch. A plan time that moves on before its files are made
//!   has none.
//! - Of the past, indices stay for a time within a size, with all blobs that they name.
//!
//! # Where
//!
//! - what is published, and when: `src/service.rs`
//! - sets of later plan times: `src/later_sets.rs`
//! - exported files, and when maps of VDA 5050 are enabled: `src/exports.rs`, `src/enabling.rs`
//! - what robots are told and tell, and the document of the fleet: `src/robots.rs`, `daemon::FleetDocument`
//! - which blobs are new, the order of objects, what goes: `src/publication.rs`

use site_server::service::SiteServer;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), SiteServer::start)
}
