//! `groundplan fleet`: the robots of a site, as its server knows them.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use daemon::{FleetDocument, FleetElement, FleetRobot, RobotReport};
use diagnostics::counted;
use jiff::Timestamp;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use ureq::tls::{Certificate, RootCerts, TlsConfig};

/// A server answers within this.
const TIMEOUT: Duration = Duration::from_secs(20);

/// A larger document is none of a fleet.
const MAX_BYTES: u64 = 64 << 20;

/// A document that was written so long ago is told to be old.
const OLD_S: i64 = 30;

/// So many elements are listed.
const N_LISTED: usize = 20;

/// Arguments of `fleet`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

/// What is asked of the fleet.
#[derive(Debug, Clone, clap::Subcommand)]
enum Command {
    /// Print which robot shows which index, who is silent, where they are, and what they observed otherwise than planned. Exit code 0 if
    /// every robot shows the newest index and has nothing to tell
    #[command(after_help = AFTER_HELP)]
    Status {
        /// Address of the server's page, as http://HOST:PORT [default: that of the configuration, on this machine]
        #[arg(long, value_name = "URL")]
        server: Option<String>,
        /// The token of the page, in a file; pages that only their own machine can see need none
        #[arg(long, value_name = "FILE")]
        token: Option<PathBuf>,
        /// Certificate of the authority that signed the page's, PEM [default: those of the system]
        #[arg(long, value_name = "CA.pem")]
        authority: Option<PathBuf>,
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
}

const AFTER_HELP: &str = "\
The server of a site with [serve.link] and [web] enabled = true answers. A robot is current by a report of the last half minute, in
which it says that it shows the newest index; of one that is silent nothing is known but what it told before.

Examples:
  groundplan fleet status --config site.toml
  groundplan fleet status --server https://office.site.example:8642 --token page-token.txt --json";

impl Run for Args {
    /// Asks the server.
    ///
    /// # Errors
    /// A server that does not answer, or has no link with robots.
    fn run(&self) -> Result<Outcome, Failure> {
        let Command::Status { server, token, authority, json, site } = &self.command;
        let server = match server {
            Some(server) => server.clone(),
            None => {
                let config = site.config()?;
                if config.follow.is_some() {
                    return Err(Failure::usage(
                        "the server of the site knows its robots, not this one: name its page with --server URL",
                    ));
                }
                let web = config.web;
                let scheme = if web.certificate.is_some() { "https" } else { "http" };
                format!("{scheme}://{}", web.listen)
            }
        };
        let bytes = fetch(&server, token.as_deref(), authority.as_deref())?;
        let document: FleetDocument = serde_json::from_slice(&bytes)
            .map_err(|why| Failure::work(format!("{server} answers with something else than a fleet: {why}")))?;
        let text = if *json {
            serde_json::to_string(&document).map_err(Failure::work)? + "\n"
        } else {
            text(&document, Timestamp::now())
        };
        let is_well = document.error.is_none() && document.robots.values().all(FleetRobot::is_well);
        Ok(Outcome::judged(text, is_well))
    }
}

/// The document of the fleet from a server's page.
fn fetch(server: &str, token: Option<&Path>, authority: Option<&Path>) -> Result<Vec<u8>, Failure> {
    let read = |path: &Path| {
        std::fs::read_to_string(path).map_err(|why| Failure::work(format!("{} cannot be read: {why}", path.display())))
    };
    let roots = match authority {
        None => RootCerts::PlatformVerifier,
        Some(path) => {
            let certificate = Certificate::from_pem(read(path)?.as_bytes())
                .map_err(|why| Failure::work(format!("{} is no certificate: {why}", path.display())))?;
            RootCerts::new_with_certs(&[certificate])
        }
    };
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let tls = TlsConfig::builder().root_certs(roots).unversioned_rustls_crypto_provider(provider).build();
    let agent: ureq::Agent = ureq::Agent::config_builder()
        .tls_config(tls)
        .timeout_global(Some(TIMEOUT))
        .http_status_as_error(false)
        .build()
        .into();
    let url = format!("{}/data/fleet.json", server.trim_end_matches('/'));
    let mut request = agent.get(&url);
    if let Some(token) = token {
        request = request.header("Authorization", format!("Bearer {}", read(token)?.trim()));
    }
    let failed = |why: ureq::Error| Failure::work(format!("{server} does not answer: {why}"));
    let mut answer = request.call().map_err(failed)?;
    let status = answer.status().as_u16();
    let bytes = answer.body_mut().with_config().limit(MAX_BYTES).read_to_vec().map_err(failed)?;
    match status {
        200 => Ok(bytes),
        404 => {
            Err(Failure::work(format!("{server} has no fleet: its site has no [serve.link], or it is another version")))
        }
        status => {
            let why = String::from_utf8_lossy(&bytes);
            Err(Failure::work(format!("{server} refuses ({status}): {}", why.trim())))
        }
    }
}

fn text(document: &FleetDocument, now: Timestamp) -> String {
    let FleetDocument { site, written, error, epoch, robots, elements, n_elements } = document;
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(out, "site {site}, index {epoch}, {}", counted(robots.len(), "robot"));
    if let Some(error) = error {
        let _ = writeln!(out, "the link with the robots: {error}");
    }
    let age_s = now.duration_since(*written).as_secs();
    if age_s > OLD_S {
        let _ = writeln!(out, "the server wrote this {age_s} s ago, by the clock of this machine");
    }
    for (name, robot) in robots {
        let here = if robot.here { "" } else { ", no link" };
        let _ = write!(out, "{name}: {}{here}", robot.state.words());
        if let Some(report) = &robot.report {
            let _ = write!(out, ", {}", shown(report));
        }
        out.push('\n');
        for finding in &robot.findings {
            let _ = writeln!(out, "  {finding}");
        }
    }
    if *n_elements > 0 {
        let _ = writeln!(out, "{} observed otherwise than planned, or contrary:", counted(*n_elements, "element"));
    }
    for element in elements.iter().take(N_LISTED) {
        let _ = writeln!(out, "  {}", element_text(element));
    }
    if *n_elements > N_LISTED {
        let _ = writeln!(out, "  {} more: --json", n_elements - N_LISTED);
    }
    out
}

/// What a robot shows and where it is.
fn shown(report: &RobotReport) -> String {
    let date = report.plan_time.as_deref().unwrap_or("everything built");
    let mut out = match report.epoch {
        0 => "shows nothing yet".to_owned(),
        epoch => format!("index {epoch}, {} of {} at {date}", counted(report.storeys, "storey"), report.maps_of),
    };
    if let Some(until) = &report.valid_until {
        let _ = write!(out, ", valid until {until}");
    }
    if let Some(place) = &report.place {
        let [x_m, y_m] = [place.pose.x_m, place.pose.y_m];
        let _ = write!(
            out,
            "; on storey {} at x {x_m:.1} m, y {y_m:.1} m, seen {:.0} s before",
            place.map_storey, place.age_s
        );
    }
    if let Some(alignment) = &report.alignment {
        let _ = write!(out, "; {alignment}");
    }
    out
}

fn element_text(element: &FleetElement) -> String {
    let told = element.told.iter().map(|(robot, told)| {
        let since = told.since.strftime("%Y-%m-%d %H:%M UTC");
        format!("{robot}: {} ({}) since {since}", told.observed.observation, told.observed.verdict)
    });
    let absent = element.absent.iter().map(|(robot, absence)| {
        let state = if absence.is_in_force { "is in force" } else { "is not in force" };
        let seen = absence.seen_by.as_ref().map(|by| format!(", because {by} saw it stand"));
        format!("its absence, confirmed on {robot}, {state}{}", seen.unwrap_or_default())
    });
    let told: Vec<String> = told.chain(absent).collect();
    let conflict = if element.is_conflict { "conflict, " } else { "" };
    format!("{conflict}{}: {}", element.id, told.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;
    use daemon::{ElementObservation, ToldObservation};

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        assert_shipped_schema("fleet-status", &schemars::schema_for!(FleetDocument));
    }

    #[test]
    fn what_is_old_or_silent_is_said() {
        let written = Timestamp::from_second(1_000).unwrap();
        let observed = ElementObservation { observation: "absent".to_owned(), verdict: "late".to_owned() };
        let told = [("scout".to_owned(), ToldObservation { observed, since: written })].into();
        let document = FleetDocument {
            site: "tower".to_owned(),
            written,
            error: None,
            epoch: 4,
            robots: [("scout".to_owned(), FleetRobot::of(None, false, 4, written))].into(),
            elements: vec![FleetElement {
                id: "wall".to_owned(),
                is_conflict: false,
                told,
                absent: Default::default(),
            }],
            n_elements: 1,
        };
        let text = text(&document, Timestamp::from_second(1_100).unwrap());
        for part in [
            "site tower, index 4, 1 robot",
            "100 s ago",
            "scout: never heard, no link",
            "wall: scout: absent (late) since",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
