//! Services of the graph: what the bridge asks of other nodes, and what they ask of it.

use super::qos::queue;
use super::{GraphError, RosGraph, create};
use daemon::RosServiceMapping;
use futures::stream::{LocalBoxStream, SelectAll, StreamExt};
use ros::srv::RosService;
use ros2_client::service::{Client, Server, ServiceMapping};
use ros2_client::{Message, ServiceTypeName};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tracing::warn;

/// Requests and responses that are kept for a slow reader.
const DEPTH: usize = 10;
/// A node that has not answered after this time is asked once more, and then is taken for one that does not answer.
const TIMEOUT: Duration = Duration::from_secs(2);
const ATTEMPTS: usize = 2;
/// Interval at which an answer is looked for.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// A request or response as the library wants it.
#[derive(Clone, Serialize, Deserialize)]
#[serde(transparent)]
struct Wire<T>(T);

impl<T: Serialize + DeserializeOwned> Message for Wire<T> {}

/// A call that brought nothing.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CallError {
    #[error("{service} does not answer")]
    Silent { service: String },
    #[error("{service} cannot be called: {why}")]
    Send { service: String, why: String },
}

/// A service of another node.
pub(crate) struct ServiceClient<S: RosService> {
    name: String,
    client: Client<Wire<S::Request>, Wire<S::Response>>,
    participant: super::Participant,
}

impl<S: RosService> ServiceClient<S> {
    /// Its name in full.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// True if a node offers it.
    pub(crate) fn is_there(&self) -> bool {
        let wanted = format!("rq{}Request", self.name);
        self.participant
            .discovered_readers()
            .iter()
            .any(|reader| *reader.subscription_topic_data.topic_name() == wanted)
    }

    /// Calls it, and once more if no answer comes: for requests that may come twice.
    ///
    /// # Errors
    /// No answer within the time.
    pub(crate) fn call(&self, request: &S::Request) -> Result<S::Response, CallError> {
        for _ in 0..ATTEMPTS {
            let failed = |why: String| CallError::Send { service: self.name.clone(), why };
            let sent = self.client.send_request(Wire(request.clone())).map_err(|why| failed(format!("{why:?}")))?;
            let begun = Instant::now();
            while begun.elapsed() < TIMEOUT {
                match self.client.receive_response() {
                    Ok(Some((id, Wire(response)))) if id == sent => return Ok(response),
                    // The answer to an earlier request, or to another client.
                    Ok(Some(_)) => {}
                    Ok(None) => sleep(POLL_INTERVAL),
                    Err(why) => return Err(failed(format!("{why:?}"))),
                }
            }
        }
        Err(CallError::Silent { service: self.name.clone() })
    }
}

/// A service of the bridge: the answer is made by the one who reads the calls.
pub(crate) struct ServiceServer<S: RosService>(Server<Wire<S::Request>, Wire<S::Response>>);

/// A call that waits for its answer; `A` makes it.
pub(crate) type Call<'a, A> = Box<dyn FnOnce(&mut A) + 'a>;

/// The calls of several services, in the order in which they come.
pub(crate) type Calls<'a, A> = SelectAll<LocalBoxStream<'a, Call<'a, A>>>;

impl<S: RosService> ServiceServer<S> {
    /// Its calls; what cannot be read is logged.
    pub(crate) fn calls<'a, A: 'a>(
        &'a self,
        answer: impl Fn(&mut A, S::Request) -> S::Response + Copy + 'a,
    ) -> LocalBoxStream<'a, Call<'a, A>> {
        let asked = self.0.receive_request_stream();
        let call = move |asked| {
            let call: Call<'a, A> = match asked {
                Ok((id, Wire(request))) => Box::new(move |answering: &mut A| {
                    let response = answer(answering, request);
                    if let Err(why) = self.0.send_response(id, Wire(response)) {
                        warn!(service = "ros-bridge", called = S::NAME, error = ?why, "an answer is not sent");
                    }
                }),
                Err(why) => Box::new(
                    move |_| warn!(service = "ros-bridge", called = S::NAME, error = ?why, "a call cannot be read"),
                ),
            };
            call
        };
        asked.map(call).boxed_local()
    }
}

fn mapping(configured: RosServiceMapping) -> ServiceMapping {
    match configured {
        RosServiceMapping::FastDds => ServiceMapping::Enhanced,
        RosServiceMapping::CycloneDds => ServiceMapping::Cyclone,
    }
}

impl RosGraph {
    /// A client of a service; names as of topics.
    ///
    /// # Errors
    /// A name that is none, a service that cannot be opened.
    pub(crate) fn client<S: RosService>(
        &mut self,
        name: &str,
        configured: RosServiceMapping,
    ) -> Result<ServiceClient<S>, GraphError> {
        let (full, kind) = (self.name(name)?, ServiceTypeName::new(S::PACKAGE, S::NAME));
        let client = self
            .node
            .create_client(mapping(configured), &full, &kind, queue(DEPTH), queue(DEPTH))
            .map_err(create(name))?;
        Ok(ServiceClient { name: full.to_string(), client, participant: self.participant.clone() })
    }

    /// A service of the bridge; names as of topics.
    ///
    /// # Errors
    /// A name that is none, a service that cannot be opened.
    pub(crate) fn server<S: RosService>(
        &mut self,
        name: &str,
        configured: RosServiceMapping,
    ) -> Result<ServiceServer<S>, GraphError> {
        let (full, kind) = (self.name(name)?, ServiceTypeName::new(S::PACKAGE, S::NAME));
        let server = self
            .node
            .create_server(mapping(configured), &full, &kind, queue(DEPTH), queue(DEPTH))
            .map_err(create(name))?;
        Ok(ServiceServer(server))
    }
}
