//! `groundplan view`: a page that shows a site in the browser, of models, of maps, or of the running daemons.

use crate::args::SiteArgs;
use crate::commands::{convert, tasks};
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::supervise::executable_of_own_build;
use bus::Daemon;
use clap::Parser;
use daemon::facts::WebFacts;
use daemon::{Report, StatusBoard, StopSignal};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{self, Child, Stdio};
use std::time::Duration;

/// Interval at which the server is looked at.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of `view`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// IFC files of one site, which are converted first: at every change if they have a schedule
    #[arg(value_name = "MODEL.ifc", conflicts_with = "out")]
    models: Vec<PathBuf>,

    /// Show the maps in this output folder of `groundplan convert`
    #[arg(long, value_name = "MAPS")]
    out: Option<PathBuf>,

    /// Schedule of the planner, as for `convert`; may be repeated
    #[arg(long, value_name = "PLAN", requires = "models")]
    schedule_file: Vec<PathBuf>,

    /// Rules of dates, as for `convert`
    #[arg(long, value_name = "FILE", requires = "models")]
    schedule: Option<PathBuf>,

    /// Robot profile, as for `convert`
    #[arg(long, value_name = "FILE", requires = "models")]
    robot: Option<PathBuf>,

    /// Tasks of the maps in --out, as `groundplan tasks --json` prints them; those of models are found by themselves
    #[arg(long, value_name = "TASKS.json", requires = "out")]
    tasks: Option<PathBuf>,

    /// Write the page with all its data into this new folder instead, to be opened without a server
    #[arg(long, value_name = "FOLDER")]
    export: Option<PathBuf>,

    /// Address and port of the page [default: 127.0.0.1:8642]. Port 0 takes a free one; an address that other machines reach
    /// asks viewers for a token, which is printed when it is made
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<SocketAddr>,

    /// Certificate of the page for https, a PEM file
    #[arg(long, value_name = "FILE", requires = "key")]
    certificate: Option<PathBuf>,

    /// Private key of the certificate, a PEM file
    #[arg(long, value_name = "FILE", requires = "certificate")]
    key: Option<PathBuf>,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

const AFTER_HELP: &str = "\
The page shows plan, waypoints, ways and the building in 3D at every date. It loads nothing from
the internet, and is read-only. Without models and --out it is that of the running daemons, which
[web] of the site's configuration, or `groundplan up --web`, serves: this prints its address.

Examples:
  groundplan view house.ifc
  groundplan view house.ifc --schedule-file plan.xer
  groundplan view --out maps
  groundplan view --out maps --export page                # then open page/index.html
  groundplan view --out maps --listen 0.0.0.0:8642 --certificate site.pem --key site.key

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

/// The command line of `convert`.
#[derive(Debug, clap::Parser)]
struct Conversion {
    #[command(flatten)]
    arguments: convert::Args,
}

/// The command line of `tasks`.
#[derive(Debug, clap::Parser)]
struct Listing {
    #[command(flatten)]
    arguments: tasks::Args,
}

impl Run for Args {
    /// Converts what is to be converted, and serves the page until it is stopped, or writes it.
    ///
    /// # Errors
    /// Models that cannot be converted, a folder without maps, an address that is taken; no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        if let Some(out) = &self.out {
            return self.show(out, self.tasks.as_deref());
        }
        if self.models.is_empty() {
            return self.running_page();
        }
        let folder = tempfile::Builder::new().prefix("groundplan-view-").tempdir().map_err(Failure::work)?;
        let maps = folder.path().join("maps");
        self.convert(&maps)?;
        let tasks = folder.path().join("tasks.json");
        self.list_tasks(&tasks)?;
        self.show(&maps, Some(&tasks))
    }
}

impl Args {
    /// Converts the models at every change, or as they are if nothing of them has a date.
    fn convert(&self, maps: &Path) -> Result<(), Failure> {
        let mut arguments: Vec<OsString> = ["convert", "--world", "--date", "all", "-o"].map(OsString::from).into();
        arguments.push(maps.into());
        if let Some(robot) = &self.robot {
            arguments.extend(["--robot".into(), robot.into()]);
        }
        arguments.extend(self.of_models());
        let Conversion { mut arguments } = Conversion::try_parse_from(arguments).map_err(Failure::work)?;
        arguments.or_everything = true;
        eprint!("{}", arguments.run()?.text);
        Ok(())
    }

    /// Writes the tasks of the models and their schedule files.
    fn list_tasks(&self, file: &Path) -> Result<(), Failure> {
        let arguments = ["tasks", "--json"].map(OsString::from).into_iter().chain(self.of_models());
        let Listing { arguments } = Listing::try_parse_from(arguments).map_err(Failure::work)?;
        std::fs::write(file, arguments.run()?.text).map_err(Failure::work)
    }

    /// Arguments for the models and their schedule.
    fn of_models(&self) -> impl Iterator<Item = OsString> {
        let rules = self.schedule.iter().map(|file| ("--schedule", file));
        let files = rules.chain(self.schedule_file.iter().map(|file| ("--schedule-file", file)));
        let files = files.flat_map(|(name, file)| [OsString::from(name), file.into()]);
        files.chain(self.models.iter().map(OsString::from))
    }

    /// Serves an output folder until it is stopped, or writes its page.
    fn show(&self, maps: &Path, tasks: Option<&Path>) -> Result<Outcome, Failure> {
        let mut command = process::Command::new(executable_of_own_build(Daemon::Web.name())?);
        command.arg("--with-stdin").arg("--out").arg(maps).stdin(Stdio::piped()).stdout(Stdio::piped());
        if let Some(tasks) = tasks {
            command.arg("--tasks").arg(tasks);
        }
        let listen = self.listen.map(|listen| listen.to_string());
        let files = [("--export", &self.export), ("--certificate", &self.certificate), ("--key", &self.key)];
        for (name, file) in files.into_iter().filter_map(|(name, file)| Some((name, file.as_ref()?))) {
            command.arg(name).arg(file);
        }
        if let Some(listen) = listen {
            command.args(["--listen", &listen]);
        }
        let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
        let mut server = Server(command.spawn().map_err(Failure::work)?);
        let mut address = String::new();
        let mut out = BufReader::new(server.0.stdout.take().ok_or_else(|| Failure::work("no output"))?);
        out.read_line(&mut address).map_err(Failure::work)?;
        if !address.is_empty() {
            eprintln!("the page is open until Ctrl-C:");
            print_line(&address)?;
        }
        loop {
            if let Some(status) = server.0.try_wait().map_err(Failure::work)? {
                return Ok(Outcome::judged(String::new(), status.success()));
            }
            if stop.is_raised_within(POLL_INTERVAL) {
                return Ok(Outcome::silent());
            }
        }
    }

    /// Where the daemons serve their page.
    fn running_page(&self) -> Result<Outcome, Failure> {
        if self.export.is_some() || self.listen.is_some() {
            return Err(Failure::usage("name models, or maps with --out"));
        }
        let config = self.site.config()?;
        let board = StatusBoard::of_site(&config).map_err(Failure::work)?;
        let report: Option<Report<WebFacts>> = board.report(Daemon::Web).filter(|_| board.is_alive(Daemon::Web));
        let Some(Report { facts, error, .. }) = report else {
            return Err(Failure::work(
                "no page is served: set enabled = true in [web] of the site's configuration, or `groundplan up --web`",
            ));
        };
        let why = || Failure::work(error.unwrap_or_else(|| "groundplan-web does not listen yet".to_owned()));
        Ok(format!("{}\n", facts.url.ok_or_else(why)?).into())
    }
}

/// The server; it ends with this process, however that ends.
struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        // One that has ended already is no error.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn print_line(line: &str) -> Result<(), Failure> {
    use std::io::Write;
    let mut out = std::io::stdout();
    out.write_all(line.as_bytes()).and_then(|()| out.flush()).map_err(Failure::work)
}
