//! `groundplan ask`: answers to questions over HTTP and MCP, of the running daemons, or of models.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::supervise::executable;
use bus::{Daemon, RobotName};
use daemon::facts::AskFacts;
use daemon::{Report, SiteConfig, StatusBoard, StopSignal};
use rustix::process::{Pid, Signal, kill_process};
use std::fmt::Write as _;
use std::io::Write as _;
use std::net::SocketAddr;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Interval at which processes are looked at.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of `ask`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// IFC files of one site, whose daemons are started for the answers [default: the running daemons are asked]
    #[arg(value_name = "MODEL.ifc", conflicts_with_all = ["config", "demo", "robot_name"])]
    models: Vec<PathBuf>,

    /// Schedule of the planner, as for `convert`; may be repeated
    #[arg(long, value_name = "PLAN", requires = "models")]
    schedule_file: Vec<PathBuf>,

    /// Rules of dates, as for `convert`
    #[arg(long, value_name = "FILE", requires = "models")]
    schedule: Option<PathBuf>,

    /// Robot profile, as for `convert`
    #[arg(long, value_name = "FILE", requires = "models")]
    robot: Option<PathBuf>,

    /// Answer one client of MCP over standard input and output, as assistants start their servers
    #[arg(long)]
    stdio: bool,

    /// Address and port of the answers [default: a free port of this machine]
    #[arg(long, value_name = "ADDRESS:PORT", requires = "models", conflicts_with = "stdio")]
    listen: Option<SocketAddr>,

    /// The robot, of a site with several [default: that of [ask] in the site's configuration]
    #[arg(long, value_name = "NAME", requires = "stdio")]
    robot_name: Option<RobotName>,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

const AFTER_HELP: &str = "\
Questions are which rooms the robot may enter and why not, when a room opens, what changes between two
dates, ways, doors, what stands, tasks, scans, findings, what robots saw, and which processes run. They
are paths of HTTP (ADDRESS/openapi.json lists them), and tools and resources of the Model Context
Protocol (ADDRESS/mcp, or --stdio). Nothing can be changed by them. Of the running daemons [ask] of the
site's configuration, or `groundplan up --ask`, answers over HTTP: this prints its address. --stdio
needs neither.

Examples:
  groundplan ask
  groundplan ask --stdio --config site.toml               # the command of an MCP server
  groundplan ask --stdio house.ifc --schedule-file plan.xer
  groundplan ask house.ifc --listen 127.0.0.1:8643

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

impl Run for Args {
    /// Answers until the client leaves or it is stopped, or tells where the daemons do.
    ///
    /// # Errors
    /// Models that cannot be read, an address that is taken; no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        if !self.models.is_empty() {
            return self.of_models();
        }
        let config = self.site.config()?;
        if self.stdio {
            let mut command = stdio_command(&config.file)?;
            command.args(self.robot_name.iter().flat_map(|name| ["--robot-name".to_owned(), name.to_string()]));
            // The client's process is that of the answers: it ends with them.
            return Err(Failure::work(command.exec()));
        }
        let board = StatusBoard::of_site(&config).map_err(Failure::work)?;
        let url = address(&board)?.ok_or_else(|| Failure::work("groundplan-ask does not listen yet"))?;
        Ok(format!("{url}\n").into())
    }
}

/// The answers to one client of MCP.
fn stdio_command(config: &Path) -> Result<Command, Failure> {
    let mut command = Command::new(executable(Daemon::Ask.name())?);
    command.arg("--stdio").arg("--config").arg(config);
    Ok(command)
}

/// Where the daemons answer; `None` while they begin to.
fn address(board: &StatusBoard) -> Result<Option<String>, Failure> {
    let report: Option<Report<AskFacts>> = board.report(Daemon::Ask).filter(|_| board.is_alive(Daemon::Ask));
    let Some(Report { facts, error, .. }) = report else {
        return Err(Failure::work(
            "nothing answers over HTTP: set enabled = true in [ask] of the site's configuration, or `groundplan up --ask`",
        ));
    };
    match (facts.url, error) {
        (Some(url), _) => Ok(Some(url)),
        (None, Some(why)) => Err(Failure::work(why)),
        (None, None) => Ok(None),
    }
}

impl Args {
    /// Starts the daemons of the models, and answers.
    fn of_models(&self) -> Result<Outcome, Failure> {
        let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
        let mut site = ModelSite::start(&self.site_toml()?)?;
        if self.stdio {
            let mut client = stdio_command(&site.config())?.spawn().map_err(Failure::work)?;
            loop {
                if let Some(status) = client.try_wait().map_err(Failure::work)? {
                    return Ok(Outcome::judged(String::new(), status.success()));
                }
                if stop.is_raised_within(POLL_INTERVAL) || site.has_ended()? {
                    // One that has ended already is no error.
                    let _ = client.kill();
                    let _ = client.wait();
                    return Ok(Outcome::silent());
                }
            }
        }
        let config = SiteConfig::read(&site.config()).map_err(Failure::usage)?;
        let board = StatusBoard::of_own(&config);
        let mut told = false;
        while !stop.is_raised_within(POLL_INTERVAL) {
            if site.has_ended()? {
                return Err(Failure::work("the daemons ended"));
            }
            // The report comes a moment after its process.
            if let Some(url) = address(&board).ok().flatten().filter(|_| !told) {
                eprintln!("questions are answered until Ctrl-C:");
                let mut out = std::io::stdout();
                writeln!(out, "{url}").and_then(|()| out.flush()).map_err(Failure::work)?;
                told = true;
            }
        }
        Ok(Outcome::silent())
    }

    /// The configuration of the site of the models, but for its bus.
    fn site_toml(&self) -> Result<String, Failure> {
        let absolute = |path: &PathBuf| {
            let path = std::fs::canonicalize(path)
                .map_err(|why| Failure::usage(format!("{} cannot be read: {why}", path.display())))?;
            let path = path.to_str().ok_or_else(|| Failure::usage(format!("{} is no UTF-8", path.display())))?;
            // Texts of JSON are those of TOML.
            serde_json::to_string(path).map_err(Failure::work)
        };
        let list = |paths: &[PathBuf]| -> Result<String, Failure> {
            Ok(paths.iter().map(absolute).collect::<Result<Vec<_>, _>>()?.join(", "))
        };
        let mut toml = format!("state = \"state\"\nmodels = [{}]\n[schedule]\n", list(&self.models)?);
        // Writing to a string does not fail.
        let _ = writeln!(toml, "files = [{}]", list(&self.schedule_file)?);
        for (key, file) in [("rules", &self.schedule), ("[robot]\nprofile", &self.robot)] {
            if let Some(file) = file {
                let _ = writeln!(toml, "{key} = {}", absolute(file)?);
            }
        }
        let listen = self.listen.map_or_else(|| "127.0.0.1:0".to_owned(), |listen| listen.to_string());
        let _ = writeln!(toml, "[ask]\nenabled = {}\nlisten = \"{listen}\"", !self.stdio);
        Ok(toml)
    }
}

/// A site of its own, whose daemons end with this value.
struct ModelSite {
    home: TempDir,
    bus: PathBuf,
    up: Child,
}

impl ModelSite {
    fn start(toml: &str) -> Result<Self, Failure> {
        let home = tempfile::Builder::new().prefix("groundplan-ask-").tempdir().map_err(Failure::work)?;
        let own = std::process::id();
        let bus = PathBuf::from(format!("/dev/shm/groundplan-ask-{own}"));
        let config = home.path().join("site.toml");
        let toml = format!("{toml}[bus]\nprefix = \"gpask{own}_\"\nroot = \"{}\"\n", bus.display());
        std::fs::write(&config, toml).map_err(Failure::work)?;
        let mut command = Command::new(executable(Daemon::Groundplan.name())?);
        // What standard output says is for the client. The pipe ends with this process, however that ends, and the daemons with it.
        command.args(["up", "--with-stdin", "--config"]).arg(&config).stdin(Stdio::piped()).stdout(Stdio::null());
        Ok(Self { up: command.spawn().map_err(Failure::work)?, home, bus })
    }

    fn config(&self) -> PathBuf {
        self.home.path().join("site.toml")
    }

    fn has_ended(&mut self) -> Result<bool, Failure> {
        Ok(self.up.try_wait().map_err(Failure::work)?.is_some())
    }
}

impl Drop for ModelSite {
    fn drop(&mut self) {
        // One that has ended already is no error.
        if let Some(pid) = i32::try_from(self.up.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process(pid, Signal::TERM);
        }
        let _ = self.up.wait();
        let _ = std::fs::remove_dir_all(&self.bus);
    }
}
