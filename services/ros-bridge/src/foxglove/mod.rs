//! The server for Foxglove: what the bridge publishes in ROS 2, and rooms as entities, over a WebSocket.
//!
//! Only this module names the SDK of Foxglove. Messages of ROS 2 are the bytes of recordings: CDR, with the definition of their
//! type beside. Clients look and change nothing: no parameters, services or messages are taken from them, and the only asset is
//! the model of the building. Messages go into a bounded queue of each client, which loses its oldest ones if the client does not
//! read; the threads of the service wait for none of them.

mod channels;
mod latch;
mod listening;
mod room_entities;
mod timestamp;
mod world_model;

use crate::machine_clock::stamp;
use crate::outputs::Outputs;
use channels::Channels;
use daemon::{Failure, FoxgloveConfig, RosConfig, SiteConfig, chain};
use foxglove::Context;
use frames::metres;
use listening::{Listening, ServeError};
use messages::{Grid, ShortContentId};
use ros::markers::Room;
use ros::msg::diagnostic_msgs::DiagnosticArray;
use ros::msg::geometry_msgs::PoseWithCovarianceStamped;
use ros::msg::std_msgs::Header;
use ros::msg::tf2_msgs::TFMessage;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::runtime::{Builder, Runtime};
use world_model::WorldModel;

/// Serves Foxglove; clients are disconnected with it.
pub(crate) struct FoxgloveServer {
    asked: SocketAddr,
    ros: RosConfig,
    /// One thread for all clients.
    runtime: Runtime,
    /// What the channels belong to.
    context: Arc<Context>,
    channels: Channels,
    world: Arc<WorldModel>,
    listening: Result<Listening, ServeError>,
}

impl FoxgloveServer {
    /// Begins to serve. An address that is taken is an error of the server, not of its start: ROS 2 does not need it.
    ///
    /// # Errors
    /// No thread.
    pub(crate) fn start(config: &FoxgloveConfig, site: &SiteConfig) -> Result<Self, Failure> {
        let runtime = Builder::new_multi_thread().worker_threads(1).thread_name("foxglove").enable_all().build()?;
        let context = Context::new();
        let channels = Channels::open(&context, &site.ros);
        let world = Arc::new(WorldModel::of(site));
        let listening = Listening::begin(config.address, &runtime, &context, channels.latches(), &world);
        Ok(Self { asked: config.address, ros: site.ros.clone(), runtime, context, channels, world, listening })
    }

    /// Tries to listen again after an error; one that is new stands until the next call.
    pub(crate) fn listen(&mut self) {
        self.listening = match &self.listening {
            Ok(listening) => match listening.end() {
                Some(why) => Err(why),
                None => return,
            },
            Err(_) => {
                // Clients that were cut off are still in the context, and would be sent messages for ever.
                self.context = Context::new();
                let channels = Channels::open(&self.context, &self.ros);
                channels.follow(&self.channels);
                self.channels = channels;
                Listening::begin(self.asked, &self.runtime, &self.context, self.channels.latches(), &self.world)
            }
        };
    }

    /// Where it listens.
    pub(crate) fn address(&self) -> Option<SocketAddr> {
        self.listening.as_ref().ok().map(Listening::address)
    }

    /// Why it does not listen.
    pub(crate) fn error(&self) -> Option<String> {
        self.listening.as_ref().err().map(|why| chain(why))
    }

    /// Sends a set of maps with the rooms of their storey: the keep-out mask before the map that needs it.
    pub(crate) fn show<'a>(&self, outputs: &Outputs, rooms: impl Iterator<Item = Room<'a>>) {
        let channels = &self.channels;
        channels.keepout_info.send(&outputs.grids.keepout_info);
        channels.keepout_mask.send(&outputs.grids.keepout_mask);
        if let (Some((mask, info)), Some((speed_mask, speed_info))) = (&channels.speed, &outputs.grids.speed) {
            info.send(speed_info);
            mask.send(speed_mask);
        }
        channels.localization_map.send(&outputs.grids.localization_map);
        channels.map.send(&outputs.grids.map);
        if let (Some(channel), Some(elevation)) = (&channels.elevation, &outputs.grids.elevation) {
            channel.send(elevation);
        }
        channels.rooms.send(&outputs.rooms);
        let header = Header { stamp: outputs.grids.map.header.stamp, frame_id: self.ros.frame.clone() };
        channels.room_entities.send(&room_entities::update(rooms, &header));
        channels.waypoints.send(&outputs.waypoints);
        channels.route.send(&outputs.route);
        channels.changed.send(&outputs.changed);
    }

    /// Sends where the model of the building is and how it lies, by the grid of the storey and the identifier of the index of its set.
    pub(crate) fn show_world(&self, grid: &Grid<'_>, set: ShortContentId) {
        let header = Header { stamp: stamp(), frame_id: self.ros.frame.clone() };
        self.channels.world.send(&world_model::update(set, metres(grid.head.floor_z_tenths), &header));
    }

    /// Sends how the model's map lies in the robot's, and how certain that is.
    pub(crate) fn show_alignment(&self, transform: &TFMessage, pose: &PoseWithCovarianceStamped) {
        self.channels.tf_static.send(transform);
        self.channels.alignment.send(pose);
    }

    /// Sends how the processes of the site are.
    pub(crate) fn show_diagnostics(&self, diagnostics: &DiagnosticArray) {
        self.channels.diagnostics.send(diagnostics);
    }
}

#[cfg(test)]
mod tests {
    use super::listening::MAX_CLIENTS;
    use super::*;
    use std::io::Read;
    use std::net::{Ipv4Addr, TcpListener, TcpStream};
    use std::path::Path;

    fn site() -> SiteConfig {
        SiteConfig::parse("state = \"state\"\n", Path::new("/")).unwrap()
    }

    #[test]
    fn an_address_that_is_taken_is_told_and_tried_again() {
        let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = taken.local_addr().unwrap();
        let mut server = FoxgloveServer::start(&FoxgloveConfig { address }, &site()).unwrap();
        server.listen();
        let error = server.error().unwrap();
        assert!(error.contains(&address.to_string()) && error.contains("in use"), "{error}");
        assert_eq!(server.address(), None);
        drop(taken);
        server.listen();
        assert_eq!((server.error(), server.address()), (None, Some(address)));
        TcpStream::connect(address).unwrap();
    }

    #[test]
    fn a_flood_of_clients_is_cut_off_and_the_next_one_is_served() {
        let config = FoxgloveConfig { address: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)) };
        let mut server = FoxgloveServer::start(&config, &site()).unwrap();
        let address = server.address().unwrap();
        assert_ne!(address.port(), 0, "a free port is named");
        let flood: Vec<TcpStream> = (0..=MAX_CLIENTS).map(|_| TcpStream::connect(address).unwrap()).collect();
        for mut client in flood {
            // Each reads the end, or that the connection was reset.
            assert!(matches!(client.read(&mut [0]), Ok(0) | Err(_)));
        }
        while server.error().is_none() {
            server.listen();
        }
        assert!(server.error().unwrap().contains("more than 64 clients"), "{:?}", server.error());
        while server.error().is_some() {
            server.listen();
        }
        TcpStream::connect(server.address().unwrap()).unwrap();
    }
}
