//! Channels that keep their newest message, and send it again to whoever subscribes: the server itself keeps none.

use foxglove::messages::SceneUpdate;
use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{ChannelBuilder, Context, Encode, RawChannel, Schema, SinkId};
use ros::RosMessage;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tracing::warn;

/// A channel and the bytes of its newest message.
pub(super) struct Latch {
    channel: Arc<RawChannel>,
    newest: Mutex<Option<Vec<u8>>>,
}

impl Latch {
    fn open(builder: ChannelBuilder, encoding: impl Into<String>) -> Arc<Self> {
        let channel = builder.message_encoding(encoding).build_raw().expect("it has an encoding");
        Arc::new(Self { channel, newest: Mutex::default() })
    }

    /// Takes the newest message of another latch, as if it had been sent before anybody subscribed.
    pub(super) fn follow(&self, other: &Self) {
        *self.newest() = other.newest().take();
    }

    /// Under one lock with [`Latch::send_again`]: no client gets an older message after a newer one.
    fn send(&self, bytes: Vec<u8>) {
        let mut newest = self.newest();
        self.channel.log(&bytes);
        *newest = Some(bytes);
    }

    fn send_again(&self, client: Option<SinkId>) {
        if let Some(bytes) = &*self.newest() {
            self.channel.log_to_sink(bytes, client);
        }
    }

    fn newest(&self) -> MutexGuard<'_, Option<Vec<u8>>> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    #[cfg(test)]
    pub(super) fn topic(&self) -> &str {
        self.channel.topic()
    }
}

/// A channel of messages of ROS 2.
pub(super) struct RosChannel<M: RosMessage> {
    pub(super) latch: Arc<Latch>,
    message: PhantomData<fn(&M)>,
}

impl<M: RosMessage> RosChannel<M> {
    /// Opens the channel of a topic, named in full.
    pub(super) fn open(context: &Arc<Context>, topic: &str) -> Self {
        let schema = Schema::new(M::FULL_NAME, "ros2msg", M::DEFINITION.as_bytes());
        let latch = Latch::open(context.channel_builder(topic).schema(schema), "cdr");
        Self { latch, message: PhantomData }
    }

    /// Sends a message to all who have subscribed; one that has no bytes is logged, and the one before it stays.
    pub(super) fn send(&self, message: &M) {
        match ros::cdr(message) {
            Ok(bytes) => self.latch.send(bytes),
            Err(why) => {
                warn!(service = "ros-bridge", topic = self.latch.channel.topic(), error = %why, "a message is not sent");
            }
        }
    }
}

/// A channel of entities of a scene.
pub(super) struct SceneChannel {
    pub(super) latch: Arc<Latch>,
}

impl SceneChannel {
    /// Opens the channel of a topic, named in full.
    pub(super) fn open(context: &Arc<Context>, topic: &str) -> Self {
        let builder = context.channel_builder(topic).schema(SceneUpdate::get_schema());
        Self { latch: Latch::open(builder, SceneUpdate::get_message_encoding()) }
    }

    /// Sends an update to all who have subscribed.
    pub(super) fn send(&self, update: &SceneUpdate) {
        let mut bytes = Vec::new();
        update.encode(&mut bytes).expect("a vector grows as far as it must");
        self.latch.send(bytes);
    }
}

/// The latches of a server: who subscribes to a channel gets its newest message.
pub(super) struct Latches(pub(super) Vec<Arc<Latch>>);

impl ServerListener for Latches {
    fn on_subscribe(&self, client: Client, channel: ChannelView<'_>) {
        let subscribed = self.0.iter().find(|latch| latch.channel.id() == channel.id());
        if let Some(latch) = subscribed {
            latch.send_again(client.sink_id());
        }
    }
}
