//! The end of the server: the router of the site, which tells of indices and takes what robots tell.

use crate::config::ServerSettings;
use crate::error::LinkError;
use crate::{MessageKind, keys};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// So many messages of one robot wait for the server.
pub const MAX_WAITING: usize = 4;

/// What a robot tells. One that is dropped without an answer is refused.
pub struct Message {
    robot: String,
    kind: MessageKind,
    payload: Vec<u8>,
    query: Query,
    waiting: Arc<Waiting>,
}

/// So many bytes of all robots wait for the server.
const MAX_WAITING_BYTES: usize = 64 << 20;

/// Messages that wait, by robot, and their bytes.
#[derive(Default)]
struct Waiting(Mutex<(BTreeMap<String, usize>, usize)>);

impl Waiting {
    /// Counts one more of a robot, unless there are as many as there may be.
    fn enter(&self, robot: &str, n_bytes: usize) -> bool {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (counts, all_bytes) = &mut *waiting;
        let count = counts.entry(robot.to_owned()).or_default();
        let is_free = *count < MAX_WAITING && *all_bytes + n_bytes <= MAX_WAITING_BYTES;
        if is_free {
            *count += 1;
            *all_bytes += n_bytes;
        }
        is_free
    }

    fn leave(&self, robot: &str, n_bytes: usize) {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (counts, all_bytes) = &mut *waiting;
        if let Some(count) = counts.get_mut(robot) {
            *count -= 1;
            *all_bytes -= n_bytes;
        }
    }
}

impl Message {
    /// The robot, as the router knows it.
    pub fn robot(&self) -> &str {
        &self.robot
    }

    /// Its kind.
    pub fn kind(&self) -> MessageKind {
        self.kind
    }

    /// Its bytes.
    pub fn payload(&self) -> &[u8] {
        &self.payload
    }

    /// Answers; a robot that has gone by now hears nothing.
    pub fn answer(self, answer: Result<Vec<u8>, String>) {
        // The robot asks again where nothing came.
        let _ = match answer {
            Ok(bytes) => self.query.reply(self.query.key_expr(), bytes).wait(),
            Err(why) => self.query.reply_err(why).wait(),
        };
    }
}

impl Drop for Message {
    fn drop(&mut self) {
        self.waiting.leave(&self.robot, self.payload.len());
    }
}

/// The end of the server.
pub struct ServerLink {
    session: Session,
    site: String,
    here: Arc<Mutex<BTreeSet<String>>>,
    _messages: Queryable<()>,
    _robots: Subscriber<()>,
    _server: LivelinessToken,
}

impl ServerLink {
    /// Listens. What robots tell is put into `messages`.
    ///
    /// # Errors
    /// Settings that cannot be used, an address that is taken.
    pub fn open(settings: &ServerSettings, messages: Sender<Message>) -> Result<Self, LinkError> {
        let config = settings.config()?;
        let endpoints = settings.listen.join(", ");
        let open = zenoh::open(config).wait();
        let session = open.map_err(|source| LinkError::Open { how: "on", endpoints, source })?;
        let (here, waiting) = (Arc::new(Mutex::new(BTreeSet::new())), Arc::new(Waiting::default()));
        let (site, seen) = (settings.site.clone(), Arc::clone(&here));
        let robots = session.liveliness().declare_subscriber(keys::here(&site, "*")).history(true);
        let robots = robots.callback(move |sample| {
            if let Some((robot, _)) = keys::parts(sample.key_expr().as_str()) {
                let mut here = seen.lock().unwrap_or_else(PoisonError::into_inner);
                match sample.kind() {
                    SampleKind::Put => here.insert(robot.to_owned()),
                    SampleKind::Delete => here.remove(robot),
                };
            }
        });
        let robots = robots.wait().map_err(LinkError::Session)?;
        let known: BTreeSet<String> = settings.robots.iter().cloned().collect();
        let queryable = session.declare_queryable(keys::told(&site, "*", "*")).callback(move |mut query| {
            let (robot, kind) = match checked(&query, &known, &waiting) {
                Ok(checked) => checked,
                Err(why) => {
                    let _ = query.reply_err(why).wait();
                    return;
                }
            };
            let payload = query.payload_mut().map(std::mem::take);
            let payload = payload.map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
            let message = Message { robot, kind, payload, query, waiting: Arc::clone(&waiting) };
            // Nobody takes messages any more: the server ends.
            let _ = messages.send(message);
        });
        let queryable = queryable.wait().map_err(LinkError::Session)?;
        let token = session.liveliness().declare_token(keys::server(&site)).wait().map_err(LinkError::Session)?;
        Ok(Self { session, site, here, _messages: queryable, _robots: robots, _server: token })
    }

    /// Tells the robots of an index.
    ///
    /// # Errors
    /// The session is gone.
    pub fn announce(&self, epoch: u64) -> Result<(), LinkError> {
        self.session.put(keys::index(&self.site), epoch.to_string()).wait().map_err(LinkError::Session)
    }

    /// The robots that are there.
    pub fn here(&self) -> BTreeSet<String> {
        self.here.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The robot and the kind of what may be taken; the reason where it may not.
fn checked(query: &Query, known: &BTreeSet<String>, waiting: &Waiting) -> Result<(String, MessageKind), &'static str> {
    let parts = keys::parts(query.key_expr().as_str());
    let parts = parts.and_then(|(robot, kind)| Some((robot, MessageKind::of_name(kind)?)));
    // A key for several robots is of none.
    let (robot, kind) = parts
        .filter(|(robot, _)| known.contains(*robot))
        .ok_or("the site has no such robot, or the message is of no kind that is known here")?;
    let n_bytes = query.payload().map_or(0, |payload| payload.len());
    if n_bytes > kind.max_bytes() {
        return Err("the message is larger than any may be");
    }
    if !waiting.enter(robot, n_bytes) {
        return Err("so many messages wait already");
    }
    Ok((robot.to_owned(), kind))
}
