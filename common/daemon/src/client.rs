//! Client side of requests: a client of one daemon, which cannot be sent another's requests.

use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::request::Request;
use bus::{Bus, CommandClient, CommandError, Daemon, OpenCommand, PortError, Reply};
use std::marker::PhantomData;
use std::time::{Duration, Instant};

/// A client of the daemon that takes requests `R`.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let bus: bus::Bus = todo!();
/// use daemon::{Client, FileText, RasterizeRequest};
/// let rasterize = Client::<RasterizeRequest>::of(&bus)?;
/// let profile = FileText { path: "/robot.toml".into(), text: "name = \"slim\"\nradius_m = 0.2\n".to_owned() };
/// let open = rasterize.send(&RasterizeRequest::SetRobot { profile })?;
/// # Ok(())
/// # }
/// ```
///
/// A daemon cannot be sent the request of another:
///
/// ```compile_fail
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let bus: bus::Bus = todo!();
/// use daemon::{Client, IngestRequest, RasterizeRequest};
/// let rasterize = Client::<RasterizeRequest>::of(&bus)?;
/// let open = rasterize.send(&IngestRequest::GetRevision)?;
/// # Ok(())
/// # }
/// ```
pub struct Client<R> {
    port: CommandClient,
    requests: PhantomData<fn(R)>,
}

impl<R: Request> Client<R> {
    /// A client of the daemon.
    ///
    /// # Errors
    /// The bus refuses.
    pub fn of(bus: &Bus) -> Result<Self, PortError> {
        Ok(Self { port: bus.command_client(R::DAEMON)?, requests: PhantomData })
    }

    /// Sends a request.
    ///
    /// # Errors
    /// The daemon does not run, or the bus refuses.
    pub fn send(&self, request: &R) -> Result<OpenRequest<R>, ClientError> {
        let bytes = serde_json::to_vec(request).map_err(|source| ClientError::Words { daemon: R::DAEMON, source })?;
        Ok(OpenRequest { command: self.port.send(&bytes)?, requests: PhantomData })
    }
}

/// A request that waits for its answer; dropping it tells the daemon that no client waits.
pub struct OpenRequest<R> {
    command: OpenCommand,
    requests: PhantomData<fn(R)>,
}

/// A reply of a daemon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer<A> {
    /// It is on the way.
    Progress(Progress),
    /// The effect is on disk. No reply follows.
    Done(A),
}

impl<R: Request> OpenRequest<R> {
    /// The next reply; `None` if there is none yet.
    ///
    /// # Errors
    /// The daemon refuses, went away or answers in other words.
    pub fn take(&self) -> Result<Option<Answer<R::Answer>>, ClientError> {
        let daemon = R::DAEMON;
        let words = |source| ClientError::Words { daemon, source };
        Ok(match self.command.take()? {
            Some(Reply::Done(bytes)) => Some(Answer::Done(serde_json::from_slice(&bytes).map_err(words)?)),
            Some(Reply::Progress(bytes)) => Some(Answer::Progress(serde_json::from_slice(&bytes).map_err(words)?)),
            Some(Reply::Failed(text)) => {
                return Err(ClientError::Refused { daemon, why: String::from_utf8_lossy(&text).into_owned() });
            }
            None => None,
        })
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The client's end cannot be opened.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The request cannot be sent, or the daemon went away.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// Request or answer are not as this program has them.
    #[error("{daemon} and this program use different words: start all from one version")]
    Words {
        /// The daemon.
        daemon: Daemon,
        /// What differs.
        source: serde_json::Error,
    },
    /// The daemon refuses.
    #[error("{daemon}: {why}")]
    Refused {
        /// The daemon.
        daemon: Daemon,
        /// Its reason.
        why: String,
    },
    /// No answer within the time.
    #[error("{daemon} does not answer")]
    Silent {
        /// The daemon.
        daemon: Daemon,
    },
    /// The client cannot wait.
    #[error(transparent)]
    Wait(Failure),
}

/// Timeouts of a request.
#[derive(Debug, Clone, Copy)]
pub struct RequestTimeouts {
    /// For the daemon to start.
    pub starting: Duration,
    /// For the answer, from the first attempt.
    pub answer: Duration,
}

/// For a daemon to answer who asks without showing progress; it may just be started again.
const OF_SITE: RequestTimeouts = RequestTimeouts { starting: Duration::from_secs(5), answer: Duration::from_secs(20) };
/// Interval between two looks for such an answer.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Asks a daemon of a site that runs, as a client of it. Each request joins the bus anew: it may have been replaced since the last.
///
/// # Errors
/// The site does not run, the daemon refuses or does not answer within 20 s.
pub fn ask_site<R: Request>(config: &SiteConfig, request: &R) -> Result<R::Answer, Failure> {
    let (bus, mut waiter) = Bus::join(&config.domain()?, Daemon::Groundplan)?;
    let pause = || waiter.wait(POLL_INTERVAL).map(drop).map_err(Into::into);
    Ok(ask(&bus, request, OF_SITE, |_| {}, pause)?)
}

/// Sends a request and waits for its answer; `progress` gets its progress, `pause` sleeps between two polls. A request that
/// [may be sent twice](Request::may_be_sent_twice) is sent once more where the daemon dies before it has answered. Daemons send
/// requests to schedule-eval and site-follow alone, which send none: no daemon waits for itself.
///
/// # Errors
/// The daemon does not run, refuses, or does not answer.
pub fn ask<R: Request>(
    bus: &Bus,
    request: &R,
    timeouts: RequestTimeouts,
    mut progress: impl FnMut(&Progress),
    mut pause: impl FnMut() -> Result<(), Failure>,
) -> Result<R::Answer, ClientError> {
    let begun = Instant::now();
    let client = loop {
        match Client::<R>::of(bus) {
            Ok(client) => break client,
            // The keeper died, and the next one creates what is missing.
            Err(PortError::Missing { .. }) if begun.elapsed() < timeouts.starting => {
                pause().map_err(ClientError::Wait)?;
            }
            Err(why) => return Err(why.into()),
        }
    };
    let send = |pause: &mut dyn FnMut() -> Result<(), Failure>, begun: Instant| loop {
        match client.send(request) {
            Err(ClientError::Command(CommandError::NotServed { .. })) if begun.elapsed() < timeouts.starting => {
                pause().map_err(ClientError::Wait)?;
            }
            sent => return sent,
        }
    };
    let mut open = send(&mut pause, begun)?;
    let mut may_send_again = request.may_be_sent_twice();
    loop {
        match open.take() {
            Ok(Some(Answer::Done(answer))) => return Ok(answer),
            Ok(Some(Answer::Progress(news))) => progress(&news),
            Ok(None) if begun.elapsed() > timeouts.answer => return Err(ClientError::Silent { daemon: R::DAEMON }),
            Ok(None) => pause().map_err(ClientError::Wait)?,
            Err(ClientError::Command(CommandError::Lost { .. })) if may_send_again => {
                (open, may_send_again) = (send(&mut pause, Instant::now())?, false);
            }
            Err(why) => return Err(why),
        }
    }
}
