//! The end of a robot: it hears of indices, and tells the server what it has to tell.

use crate::config::RobotSettings;
use crate::error::LinkError;
use crate::{MessageKind, keys};
use std::time::Duration;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// A server answers when what it was told is on its disk.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);

/// The end of a robot. The server sees it as long as this lives and the network holds.
pub struct RobotLink {
    session: Session,
    site: String,
    robot: String,
    _index: Subscriber<()>,
    _server: Subscriber<()>,
    _here: LivelinessToken,
}

impl RobotLink {
    /// Joins. `is_new` is called when the server tells of an index, and when it comes back: it may have told of one meanwhile.
    ///
    /// # Errors
    /// Settings that cannot be used; nobody listens there now, or it refuses this robot.
    pub fn open(
        settings: &RobotSettings,
        is_new: impl Fn() + Clone + Send + Sync + 'static,
    ) -> Result<Self, LinkError> {
        let config = settings.config()?;
        let endpoints = settings.connect.join(", ");
        let open = zenoh::open(config).wait();
        let session = open.map_err(|source| LinkError::Open { how: "to", endpoints, source })?;
        let RobotSettings { site, robot, .. } = settings;
        let told = is_new.clone();
        let index = session.declare_subscriber(keys::index(site)).callback(move |_| told());
        let index = index.wait().map_err(LinkError::Session)?;
        let server = session.liveliness().declare_subscriber(keys::server(site)).history(true);
        let server = server.callback(move |sample| {
            if sample.kind() == SampleKind::Put {
                is_new();
            }
        });
        let server = server.wait().map_err(LinkError::Session)?;
        let here = session.liveliness().declare_token(keys::here(site, robot)).wait().map_err(LinkError::Session)?;
        Ok(Self { session, site: site.clone(), robot: robot.clone(), _index: index, _server: server, _here: here })
    }

    /// Tells the server something; what it answers. This blocks until it does, or the link is lost.
    ///
    /// # Errors
    /// No server is there, or it refuses.
    pub fn tell(&self, kind: MessageKind, payload: Vec<u8>) -> Result<Vec<u8>, LinkError> {
        if payload.len() > kind.max_bytes() {
            return Err(LinkError::TooLarge { bytes: payload.len() });
        }
        let key = keys::told(&self.site, &self.robot, kind.name());
        let replies = self.session.get(key).payload(payload).timeout(ANSWER_TIMEOUT);
        let replies = replies.wait().map_err(LinkError::Session)?;
        let Ok(reply) = replies.recv() else { return Err(LinkError::NoAnswer) };
        match reply.into_result() {
            Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
            Err(why) => {
                let why = why.payload().to_bytes();
                // What zenoh says in the place of a server that has not answered.
                let is_late = &*why == b"Timeout";
                let why = String::from_utf8_lossy(&why).into_owned();
                Err(if is_late { LinkError::NoAnswer } else { LinkError::Refused(why) })
            }
        }
    }
}
