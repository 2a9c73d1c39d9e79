//! The daemon: takes samples of the bus for answers, and listens.

use crate::desk::Desk;
use crate::guard::Guard;
use crate::http::router;
use crate::site::Site;
use crate::takers::Takers;
use bus::Bus;
use daemon::facts::AskFacts;
use daemon::state_files::ASK_TOKEN;
use daemon::{AskRequest, Asked, Done, Event, Failure, Service, SiteConfig, Standing};
use site_http::{Listening, ListeningFor, ServerSettings, access_of};
use std::sync::Arc;

daemon::inputs! {
    /// The last sample of a set, which wakes this service, and what robots saw.
    pub(crate) enum AskInput { MissionPlan, Deviations }
}

/// Connections at the same time.
const MAX_CONNECTIONS: usize = 100;

/// Answers questions about a running site.
pub(crate) struct AskService {
    config: SiteConfig,
    site: Arc<Site>,
    desk: Desk,
    listening: Listening,
    /// None before a bus is joined.
    takers: Option<Takers>,
}

impl AskService {
    /// Listens, now or as soon as its address can be had.
    ///
    /// # Errors
    /// A token that cannot be read.
    pub(crate) fn new(config: &SiteConfig) -> Result<Self, Failure> {
        let ask = &config.ask;
        let tls = ask.certificate.clone().zip(ask.key.clone());
        let is_encrypted = tls.is_some();
        // Who has a name for this server lets others in.
        let is_own_machine = ask.listen.ip().is_loopback() && ask.hosts.is_empty();
        let access = access_of(is_own_machine, &config.site_state.join(ASK_TOKEN), |token| {
            eprintln!("groundplan-ask: who asks sends this token, which is shown this once: {token}");
            if !is_encrypted {
                eprintln!("groundplan-ask: it is sent unencrypted: certificate and key in [ask] make it https");
            }
        })?;
        let guard = Guard { access, hosts: ask.hosts.clone() };
        let site = Arc::new(Site::of(config));
        let desk = Desk::of(Arc::clone(&site));
        let whose = ListeningFor { service: "groundplan-ask", what: "answers" };
        let settings = ServerSettings { listen: ask.listen, tls, n_connections: MAX_CONNECTIONS };
        let listening = Listening::of(whose, settings, router(desk.clone(), guard));
        Ok(Self { config: config.clone(), site, desk, listening, takers: None })
    }
}

impl Service for AskService {
    type Input = AskInput;
    type Request = AskRequest;
    type Facts = AskFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.site.forget();
        self.takers = Some(Takers::of(bus)?);
        Ok(())
    }

    fn handle(&mut self, event: Event<AskInput>) -> Result<Done, Failure> {
        match event {
            // It is taken below, with what it belongs to.
            Event::Input(AskInput::MissionPlan(_)) => {}
            Event::Input(AskInput::Deviations(deviations)) => self.site.insert_deviations(deviations),
            Event::Configuration(config) if config.ask != self.config.ask => {
                return Err("[ask] cannot change while groundplan-ask runs: restart it".into());
            }
            Event::Configuration(config) => {
                self.config = (*config).clone();
                self.site.set_config(*config);
            }
            Event::Tick => self.listening.keep_up(),
            Event::Attached => {}
        }
        self.takers.iter().try_for_each(|takers| takers.take(&self.site))?;
        self.site.looked();
        Ok(Done::default())
    }

    fn answer(&mut self, request: AskRequest, _asked: &Asked) -> Result<Done<Option<()>>, Failure> {
        match request {}
    }

    fn standing(&self) -> Standing {
        Standing { error: self.listening.why_not().map(str::to_owned), warning: None }
    }

    fn facts(&self) -> AskFacts {
        AskFacts { url: self.listening.url().map(str::to_owned), questions: self.desk.n_asked() }
    }
}
