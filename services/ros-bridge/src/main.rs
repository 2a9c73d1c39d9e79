//! ROS 2 and Foxglove: maps, masks, markers and diagnostics of the robot's storey out, the robot's SLAM map in.
//!
//! # Guarantees
//!
//! - `ros-bridge` is the only one on a network: a node of ROS 2 by DDS in Rust, with threads that take SLAM maps and
//!   transforms, publish maps and answer calls. It publishes the maps of one storey, the keep-out mask before the map that
//!   needs it, and `/tf_static` from an effective pose that the newest search accepted. Maps are published on a thread of
//!   their own, because Nav2 may take seconds to stop; the newest set goes before those that wait. The map waits for the
//!   readers of the mask and what follows for those of the map, together at most 3 s, or 10 s while Nav2 stands; then a
//!   warning says that a reader is late, until it is not. Grids have writers of DDS, because publishers of the library do not
//!   tell what their readers have taken; the library does not count them among the node's. Therefore the bridge itself sends
//!   the list of the node's readers and writers (`services/ros-bridge/src/graph/node_entities.rs`), which takes the place of
//!   the library's. No publisher of it says the hash of its type: the DDS library sends no user data of writers, and `ros2
//!   topic info -v` shows the hash as invalid; messages are read all the same. Grids that have not changed are not published
//!   again: a change on another storey leaves the robot its goal. A call that would change the site becomes a request to its
//!   daemon over the bus, as that of any client, and is not offered unless the site allows it. As the robot's side of the bus
//!   it brings SLAM maps to the topic `slam-map`, without borders of which nothing is known. A message that is no map is
//!   refused with a warning in `status`, and the map before it stays; of several publishers the map that comes last counts,
//!   with a warning. Of a topic that it reads it keeps no more messages than it needs: with a map of 25 MB each second it has
//!   0.4 to 0.6 GB.
//! - If `[ros.foxglove]` says so, `ros-bridge` also serves the bytes of these messages to Foxglove over a WebSocket, on one
//!   more thread. The newest message of each channel is kept and sent to whoever subscribes; of a client that does not read
//!   the oldest are dropped, and nothing waits for it. More than 64 clients are all disconnected: the bus needs the files of
//!   the process that they would take. Clients cannot change anything; an address that is taken is an error of the daemon,
//!   which goes on with ROS 2 and tries again. The simulation world is a URL among the channels: the model is made from the
//!   newest set on the bus when a client asks for it, one at a time, and kept until the next set.
//! - The storey that `ros-bridge` publishes is told by a parameter, by the robot that goes through a portal, by the
//!   configuration or by the alignment. A robot has gone through when it stood at one end and has followed the line over
//!   three quarters; a lift has no line, and a robot below a stair did not begin at its end.
//! - The ROS 2 library's threads end without an error when a signal interrupts their waiting, as after SIGSTOP or when a
//!   computer wakes up, and a reader that acknowledges nothing fills its memory: the bridge looks each second, and ends then,
//!   to be started again.
//! - `/clock` is looked at ten times a second; a plan time is asked for only where the published schedule state does not
//!   hold.
//!
//! # Where
//!
//! - Foxglove: channels, what a late client gets: `src/foxglove/channels.rs`, `src/foxglove/latch.rs`,
//!   `src/foxglove/room_entities.rs`, `src/foxglove/world_model.rs`, `config/foxglove/groundplan.json`
//! - ROS 2: other publishers of maps: `src/rivals.rs`
//! - ROS 2: parameters and services of the node: `src/parameters.rs`, `src/calls.rs`, `src/control.rs`
//! - ROS 2: plan time from `/clock`: `src/sim_time.rs`
//! - ROS 2: pose of the robot from transforms: `src/robot_pose.rs`
//! - ROS 2: the library in the process: `src/graph/library.rs`
//! - ROS 2: topics and qualities of service: `src/graph/publishers.rs`, `src/graph/qos.rs`, `src/outputs.rs`
//! - ROS 2: which readers and writers are the node's: `src/graph/node_entities.rs`

mod calls;
mod control;
mod followed_transform;
mod foxglove;
mod graph;
mod kept_slam_frame;
mod machine_clock;
mod map_sender;
mod nav2;
mod outdoors;
mod outputs;
mod parameters;
mod portals;
mod rivals;
mod robot;
mod robot_pose;
mod service;
mod sim_time;
mod slam_map;
mod storey;

use service::BridgeService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(bus::commit!(), BridgeService::new)
}
