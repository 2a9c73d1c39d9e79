//! A robot's maps from the server of its site: the signed index of a store in, the topics of the daemons that draw out.
//!
//! # Guarantees
//!
//! - What is published is what the server's daemons published, byte for byte: the archives are theirs. Of a robot that follows some
//!   storeys alone, the index of the grids names those.
//! - An index is shown only if the root key of the robot leads to its signature, and if it is not older than what was acknowledged
//!   (`replica::accept`); what is acknowledged is on disk before anything of it is published.
//! - A set of maps is published when all of its archives are here and have the sha256 that the index names. What is shown stays until
//!   then, whatever the store says, and says until when it is valid.
//! - Sets of later plan times are fetched ahead, and shown by the robot's own clock if that can be trusted: without a network, too.
//! - Schedule state, grids, index and mission plan are published in this order, as where they are drawn: what must not be entered any
//!   more is known before the map that shows it.
//!
//! - Exported files of the server ([follow] files) are checked by their sha256 and shown as a whole, by a link: those of the maps that
//!   are shown, or none. The link goes before maps of another date are published. Maps wait neither for files nor for
//!   their folder.
//!
//! # Where
//!
//! - exported files on disk: `src/file_folder.rs`
//! - archives on disk, and resuming of what was fetched in part: `src/archive_folder.rs`
//! - which set is shown, and when: `src/service.rs`, `replica::SiteIndex::choose`
//! - what is fetched, and how often the store is asked: `src/fetcher.rs`

use site_follow::service::SiteFollow;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), SiteFollow::start)
}
