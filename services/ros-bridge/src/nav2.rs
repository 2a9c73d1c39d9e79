//! Calls to Nav2 when maps change: stop, load, forget, go on.

use crate::graph::{GraphError, RosGraph, ServiceClient};
use daemon::{Failure, Nav2Config, Nav2Pause, RosServiceMapping};
use ros::srv::RosService;
use ros::srv::action_msgs::{CancelGoal, CancelGoalRequest};
use ros::srv::nav2_msgs::{
    ClearEntireCostmap, Empty, ManageLifecycleNodes, ManageLifecycleNodesRequest, SetRouteGraph, SetRouteGraphRequest,
};
use std::path::PathBuf;

/// Services of Nav2. One that no node offers is passed over: not every robot has every part of Nav2.
pub(crate) struct Nav2 {
    pause: Pause,
    costmaps: Vec<ServiceClient<ClearEntireCostmap>>,
    route_server: Option<ServiceClient<SetRouteGraph>>,
    /// The route graph that the server has.
    route_graph: Option<RouteGraph>,
}

/// A file as Nav2's route server reads it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RouteGraph {
    pub(crate) path: PathBuf,
    pub(crate) bytes: Vec<u8>,
}

enum Pause {
    Goals(Vec<ServiceClient<CancelGoal>>),
    Lifecycle(Box<ServiceClient<ManageLifecycleNodes>>),
}

impl Nav2 {
    /// Clients of the services that the configuration names.
    ///
    /// # Errors
    /// Names that are none.
    pub(crate) fn of(
        graph: &mut RosGraph,
        config: &Nav2Config,
        mapping: RosServiceMapping,
    ) -> Result<Self, GraphError> {
        let pause = match config.pause {
            Nav2Pause::Goals => {
                let name = |action: &String| format!("{action}/_action/cancel_goal");
                let clients = config.actions.iter().map(|action| graph.client(&name(action), mapping));
                Pause::Goals(clients.collect::<Result<_, _>>()?)
            }
            Nav2Pause::Lifecycle => {
                let manager = graph.client(&format!("{}/manage_nodes", config.lifecycle_manager), mapping)?;
                Pause::Lifecycle(Box::new(manager))
            }
        };
        let clear = |costmap: &String| {
            let base = costmap.rsplit('/').next().unwrap_or_default();
            graph.client(&format!("{costmap}/clear_entirely_{base}"), mapping)
        };
        let costmaps = config.costmaps.iter().map(clear).collect::<Result<_, _>>()?;
        let route_server = match config.route_server.as_str() {
            "" => None,
            server => Some(graph.client(&format!("{server}/set_route_graph"), mapping)?),
        };
        Ok(Self { pause, costmaps, route_server, route_graph: None })
    }

    /// Stops the robot.
    ///
    /// # Errors
    /// A service that refuses or does not answer: the robot may still drive.
    pub(crate) fn pause(&self) -> Result<(), Failure> {
        match &self.pause {
            Pause::Goals(actions) => {
                let cancel = |client: &ServiceClient<CancelGoal>| {
                    call_if_there(client, &CancelGoalRequest::default(), |response| response.is_done())
                };
                first_error(actions.iter().map(cancel))
            }
            Pause::Lifecycle(manager) => command(manager, ManageLifecycleNodesRequest::PAUSE),
        }
    }

    /// Loads a route graph that the server does not have, and empties the costmaps if the maps have changed.
    ///
    /// # Errors
    /// A service that refuses or does not answer.
    pub(crate) fn load(&mut self, route_graph: Option<&RouteGraph>, maps_changed: bool) -> Result<(), Failure> {
        let loaded = self.load_route_graph(route_graph);
        let clear = |client: &ServiceClient<ClearEntireCostmap>| call_if_there(client, &Empty::default(), |_| true);
        loaded.and(first_error(self.costmaps.iter().filter(|_| maps_changed).map(clear)))
    }

    fn load_route_graph(&mut self, route_graph: Option<&RouteGraph>) -> Result<(), Failure> {
        let (Some(server), Some(graph)) = (&self.route_server, route_graph) else { return Ok(()) };
        if self.route_graph.as_ref() == Some(graph) {
            return Ok(());
        }
        let request = SetRouteGraphRequest { graph_filepath: graph.path.display().to_string() };
        if call_if_there(server, &request, |response| response.success)? {
            self.route_graph = Some(graph.clone());
        }
        Ok(())
    }

    /// Lets Nav2 go on; cancelled goals are the mission's to send again.
    ///
    /// # Errors
    /// A service that refuses or does not answer: the robot stands.
    pub(crate) fn resume(&self) -> Result<(), Failure> {
        match &self.pause {
            Pause::Goals(_) => Ok(()),
            Pause::Lifecycle(manager) => command(manager, ManageLifecycleNodesRequest::RESUME),
        }
    }
}

fn command(manager: &ServiceClient<ManageLifecycleNodes>, command: u8) -> Result<(), Failure> {
    call_if_there(manager, &ManageLifecycleNodesRequest { command }, |response| response.success).map(drop)
}

/// True if a node offers the service, and it has done what was asked for.
fn call_if_there<S: RosService>(
    client: &ServiceClient<S>,
    request: &S::Request,
    is_done: impl Fn(&S::Response) -> bool,
) -> Result<bool, Failure> {
    if !client.is_there() {
        return Ok(false);
    }
    let response = client.call(request).map_err(|why| format!("Nav2: {why}"))?;
    if is_done(&response) { Ok(true) } else { Err(format!("Nav2: {} refuses", client.name()).into()) }
}

/// All are done; the first that fails is the error.
fn first_error(results: impl Iterator<Item = Result<bool, Failure>>) -> Result<(), Failure> {
    let mut first = Ok(());
    for result in results {
        first = first.and(result.map(drop));
    }
    first
}
