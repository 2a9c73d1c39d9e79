//! Service types by interface package: requests and responses, with their fields in the order of the definitions.
//!
//! A request or response without fields is one byte: types of DDS have a member.

pub mod action_msgs;
pub mod nav2_msgs;
pub mod rcl_interfaces;
pub mod std_srvs;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A service type: its name, its request, its response.
pub trait RosService {
    /// Interface package, e.g. `std_srvs`.
    const PACKAGE: &'static str;
    /// Name in the package, e.g. `Trigger`.
    const NAME: &'static str;
    /// What a client sends.
    type Request: Clone + Serialize + DeserializeOwned + Send + 'static;
    /// What it gets back.
    type Response: Clone + Serialize + DeserializeOwned + Send + 'static;
}

/// A service type without fields of its own.
macro_rules! ros_service {
    ($(#[$doc:meta])* $name:ident: $package:ident, $request:ty => $response:ty) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl $crate::srv::RosService for $name {
            const PACKAGE: &'static str = stringify!($package);
            const NAME: &'static str = stringify!($name);
            type Request = $request;
            type Response = $response;
        }
    };
}

use ros_service;
