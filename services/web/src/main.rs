//! The page that shows a site in browsers: of an output folder, or of the running daemons.
//!
//! # Guarantees
//!
//! - The page's documents are made of those that robots get (`src/documents`): `semantic.json` without what changes with the
//!   date is `data/site.json`, what changes is `data/dates/KEY.json`, and when it does is `data/calendar.json`. Files and
//!   daemons go through the same functions: `Source` (`src/source.rs`) is all that the server knows of either.
//! - `data/tasks.json` has the tasks of the schedule: of a running site with planned, reported and observed dates, of a folder what
//!   `groundplan tasks --json` prints if it is given, else what elements of the maps say of their tasks; which of these is in
//!   it. `data/summary/KEY.json` counts areas and the status of tasks at a date.
//! - Whether a room is open to the robot is what the mission plan says; the page judges nothing itself. Live, the calendar
//!   has the schedule's states alone, because there are mission plans of the present date only.
//! - What a state, a change or a finding is, and what a room, a door or a way is for the robot, is said by `answers`, in its
//!   words; of a running site `data/room/ROOM`, `data/door/DOOR` and `data/way/FROM/TO` are what `groundplan room`, `door` and
//!   `way` print, of the maps that are shown. One is made at a time, and kept while the maps are the same. Maps of later dates are not drawn for the page.
//! - Maps are tiles of 512 pixels on one tile grid for all storeys (`src/tiles.rs`); a pixel of an upper level shows the
//!   strongest of its cells, so that an obstacle of one cell is seen. Their addresses are hashes of all that they are made of
//!   (`ContentName`): what does not change with the date is not sent again, and only what has such an address is kept by
//!   browsers without a question.
//! - Of an output folder every byte is what the manifest lists (`src/files/checked_folder.rs`): files are opened below the
//!   open folder and never through a symbolic link, and their sha256 and date are compared before anything is made of them.
//!   The documents are those of one moment (`Maps`); each request looks whether the manifests are still the same, and keys of
//!   dates name them, so that a page never mixes two conversions.
//! - Live, tiles are cut from the grids in shared memory when a browser asks for them; documents are made when a set of maps
//!   belongs together, and handed on as server-sent events, the newest of each kind.
//! - A request names a date, a storey or a hash, never a path; a manifest cannot lead out of its folder. On 127.0.0.1 only
//!   names of the own machine are answered; elsewhere a token is asked for, of which only the sha256 is stored. Heads and
//!   bodies of requests have their time, connections and viewers their number (`site-http`); one too many is
//!   answered so.
//! - An address that cannot be had is no reason to end: `site-http` tries again at every tick, and the heartbeat
//!   has the reason. `src/live/watchdog.rs` tells viewers when the service itself does not look at its daemons. Everything is
//!   read-only but the plan time and confirmations, with `allow_control` alone.
//! - `page/` has the page's sources, `page/bundle` what `scripts/build_page` makes of them with Leaflet and three.js; it is
//!   part of the program, and `SHA256SUMS` says which sources it is of. Nothing of it is made by `cargo build`, and nothing
//!   is loaded from elsewhere.
//! - `--export` writes the page with all its data as scripts, because a browser lets a page of `file://` read nothing else.
//!
//! # Where
//!
//! - page: documents of a site and of a date: `src/documents/site.rs`, `src/documents/date.rs`, `src/live/live_documents.rs`
//! - page: events, control, who may look: `src/server/events.rs`, `src/server/control.rs`, `src/server/access.rs`,
//!   `src/token.rs`
//! - page: files of an output folder, checked: `src/files/checked_folder.rs`, `src/files/maps.rs`
//! - page: questions of viewers: `src/question.rs`, `src/live/live_answers.rs`

mod arguments;
mod documents;
mod files;
mod kept;
mod live;
mod page;
mod page_folder;
mod question;
mod server;
mod source;
mod tiles;
mod token;

use arguments::{Arguments, FolderArguments};
use clap::Parser;
use daemon::{Failure, StopSignal, chain};
use documents::TasksDocument;
use files::SiteOfFiles;
use live::WebService;
use server::{MAX_VIEWERS, Served, router};
use site_http::{ServeError, Server, ServerSettings};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Interval at which the server is looked at.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

fn main() -> ExitCode {
    bus::set_commit(bus::commit!());
    let Arguments { config, with_stdin, folder } = Arguments::parse();
    match (config, folder) {
        (Some(config), _) => {
            // Maps do not wait for pictures of them.
            daemon::in_background();
            daemon::run_with(&daemon::Arguments { config, robot_name: None, with_stdin }, WebService::new)
        }
        (None, Some(folder)) => match show_folder(&folder, with_stdin) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => {
                eprintln!("error: {}", chain(why.as_ref()));
                ExitCode::FAILURE
            }
        },
        (None, None) => unreachable!("clap asks for one of them"),
    }
}

fn show_folder(arguments: &FolderArguments, with_stdin: bool) -> Result<(), Failure> {
    let log = tracing_subscriber::fmt().with_writer(std::io::stderr);
    log.with_env_filter(tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| "warn".into())).init();
    let tasks = arguments.tasks.as_deref().map(TasksDocument::of_file).transpose()?;
    let site = SiteOfFiles::open(&arguments.out, tasks)?;
    if let Some(export) = &arguments.export {
        let n_files = page_folder::write_page(&*site.maps()?, export)?;
        eprintln!("{}: {n_files} files; open index.html in a browser", export.display());
        return Ok(());
    }
    let tls = arguments.certificate.clone().zip(arguments.key.clone());
    let access = token::access_of(arguments.listen, &arguments.token_folder()?, tls.is_some())?;
    let served = Served {
        source: Arc::new(site),
        live: None,
        access: Arc::new(access),
        viewers: Arc::new(Semaphore::new(MAX_VIEWERS)),
    };
    let router = router(served, tls.is_some());
    let server = Server::bind(ServerSettings::of(arguments.listen, tls), router).map_err(|why| match why {
        ServeError::Listen { .. } => format!("{}: name another address with --listen", chain(&why)).into(),
        why => Failure::from(why),
    })?;
    let mut stop = StopSignal::listen(with_stdin)?;
    arguments.print_address(&server.url())?;
    let server = std::thread::Builder::new().name("web-server".to_owned()).spawn(move || server.run())?;
    while !stop.is_raised_within(POLL_INTERVAL) {
        if server.is_finished() {
            server.join().map_err(|_| "the server panicked")??;
            return Ok(());
        }
    }
    Ok(())
}
