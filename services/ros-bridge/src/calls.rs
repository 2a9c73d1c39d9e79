//! The thread that answers the calls of other nodes.

use crate::control::Control;
use crate::graph::{Calls, GraphError, NODE, RosGraph, ServiceServer};
use crate::parameters;
use daemon::{Failure, SiteConfig, chain};
use futures::executor::block_on;
use futures::stream::{SelectAll, StreamExt};
use ros::srv::rcl_interfaces::{
    DescribeParameters, GetParameterTypes, GetParameters, ListParameters, SetParameters, SetParametersAtomically,
};
use ros::srv::std_srvs::{Trigger, TriggerRequest, TriggerResponse};
use std::thread;
use tracing::info;

/// The services of the bridge.
struct Services {
    list_parameters: ServiceServer<ListParameters>,
    describe_parameters: ServiceServer<DescribeParameters>,
    get_parameter_types: ServiceServer<GetParameterTypes>,
    get_parameters: ServiceServer<GetParameters>,
    set_parameters: ServiceServer<SetParameters>,
    /// Clients of rclpy wait until all six are there.
    set_parameters_atomically: ServiceServer<SetParametersAtomically>,
    /// Only where the site allows control from ROS.
    control: Option<ControlServices>,
}

struct ControlServices {
    next_change: ServiceServer<Trigger>,
    align: ServiceServer<Trigger>,
    confirm: ServiceServer<Trigger>,
}

/// Answers calls on a thread, one after the other.
///
/// # Errors
/// Services that cannot be opened, no thread.
pub(crate) fn serve(graph: &mut RosGraph, config: &SiteConfig) -> Result<(), Failure> {
    let services = Services::open(graph, config)?;
    let mut control = Control { config: config.clone() };
    let answer = move || {
        let mut calls = services.calls();
        while let Some(call) = block_on(calls.next()) {
            call(&mut control);
        }
    };
    thread::Builder::new().name("ros-calls".to_owned()).spawn(answer)?;
    Ok(())
}

impl Services {
    fn open(graph: &mut RosGraph, config: &SiteConfig) -> Result<Self, GraphError> {
        let mapping = config.ros.service_mapping;
        let of_node = |name: &str| format!("{NODE}/{name}");
        let control = match config.ros.allow_control {
            true => Some(ControlServices {
                next_change: graph.server("next_change", mapping)?,
                align: graph.server("align", mapping)?,
                confirm: graph.server("confirm", mapping)?,
            }),
            false => None,
        };
        Ok(Self {
            list_parameters: graph.server(&of_node("list_parameters"), mapping)?,
            describe_parameters: graph.server(&of_node("describe_parameters"), mapping)?,
            get_parameter_types: graph.server(&of_node("get_parameter_types"), mapping)?,
            get_parameters: graph.server(&of_node("get_parameters"), mapping)?,
            set_parameters: graph.server(&of_node("set_parameters"), mapping)?,
            set_parameters_atomically: graph.server(&of_node("set_parameters_atomically"), mapping)?,
            control,
        })
    }

    fn calls(&self) -> Calls<'_, Control> {
        let mut calls = SelectAll::new();
        calls.push(self.list_parameters.calls(|_: &mut Control, asked| parameters::list(&asked)));
        calls.push(self.describe_parameters.calls(|_, asked| parameters::describe(&asked)));
        calls.push(self.get_parameter_types.calls(|_, asked| parameters::types(&asked)));
        calls.push(self.get_parameters.calls(|control: &mut Control, asked| parameters::get(&control.config, &asked)));
        calls.push(self.set_parameters.calls(|control, asked| parameters::set(control, &asked)));
        calls.push(self.set_parameters_atomically.calls(|control, asked| parameters::set_atomically(control, &asked)));
        if let Some(ControlServices { next_change, align, confirm }) = &self.control {
            calls.push(next_change.calls(|control, asked| done("next_change", control, asked, Control::next_change)));
            calls.push(align.calls(|control, asked| done("align", control, asked, Control::align)));
            calls.push(confirm.calls(|control, asked| done("confirm", control, asked, Control::confirm)));
        }
        calls
    }
}

/// Does what is asked for, logs it, and answers.
fn done(
    what: &str,
    control: &Control,
    _: TriggerRequest,
    work: fn(&Control) -> Result<String, Failure>,
) -> TriggerResponse {
    let (success, message) = match work(control) {
        Ok(message) => (true, message),
        Err(why) => (false, chain(why.as_ref())),
    };
    info!(service = "ros-bridge", what, success, message, "asked for from ROS");
    TriggerResponse { success, message }
}
