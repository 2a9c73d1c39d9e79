//! The page that shows a site in browsers: of an output folder, or of the running daemons.

mod arguments;
mod documents;
mod files;
mod live;
mod page;
mod page_folder;
mod server;
mod source;
mod tiles;
mod token;

use arguments::{Arguments, FolderArguments};
use clap::Parser;
use daemon::{Failure, StopSignal, chain};
use files::SiteOfFiles;
use live::WebService;
use server::{MAX_VIEWERS, ServeError, Served, Server, ServerSettings};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Interval at which the server is looked at.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

fn main() -> ExitCode {
    let Arguments { config, with_stdin, folder } = Arguments::parse();
    match (config, folder) {
        (Some(config), _) => {
            // Maps do not wait for pictures of them.
            daemon::in_background();
            daemon::run_with(&daemon::Arguments { config, with_stdin }, WebService::new)
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
    let site = SiteOfFiles::open(&arguments.out)?;
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
    let server = Server::bind(ServerSettings::of(arguments.listen, tls), served).map_err(|why| match why {
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
