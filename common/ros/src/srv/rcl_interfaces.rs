//! Parameters of a node.

use super::ros_service;
use serde::{Deserialize, Serialize};

/// Kinds of values.
#[derive(Debug, Clone, Copy)]
pub struct ParameterType;

impl ParameterType {
    /// There is no such parameter.
    pub const NOT_SET: u8 = 0;
    /// A whole number.
    pub const INTEGER: u8 = 2;
    /// A text.
    pub const STRING: u8 = 4;
}

/// A value: the field of its kind counts.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "a field for each kind")]
pub struct ParameterValue {
    /// One of [`ParameterType`].
    pub r#type: u8,
    pub bool_value: bool,
    pub integer_value: i64,
    pub double_value: f64,
    pub string_value: String,
    pub byte_array_value: Vec<u8>,
    pub bool_array_value: Vec<bool>,
    pub integer_array_value: Vec<i64>,
    pub double_array_value: Vec<f64>,
    pub string_array_value: Vec<String>,
}

impl ParameterValue {
    /// A whole number.
    pub fn integer(integer_value: i64) -> Self {
        Self { r#type: ParameterType::INTEGER, integer_value, ..Self::default() }
    }

    /// A text.
    pub fn string(string_value: String) -> Self {
        Self { r#type: ParameterType::STRING, string_value, ..Self::default() }
    }
}

/// A parameter and its value.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

/// Request of [`SetParameters`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SetParametersRequest {
    /// Each is set, or refused, by itself.
    pub parameters: Vec<Parameter>,
}

/// What became of a parameter.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersResult {
    /// True if it was set.
    pub successful: bool,
    /// Why not.
    pub reason: String,
}

/// Response of [`SetParameters`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersResponse {
    /// In the order of the request.
    pub results: Vec<SetParametersResult>,
}

/// Response of [`SetParametersAtomically`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersAtomicallyResponse {
    /// Of all together.
    pub result: SetParametersResult,
}

/// Names of parameters.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Names {
    /// Without the node's name.
    pub names: Vec<String>,
}

/// Response of [`GetParameters`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GetParametersResponse {
    /// In the order of the request.
    pub values: Vec<ParameterValue>,
}

/// Response of [`GetParameterTypes`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetParameterTypesResponse {
    /// In the order of the request.
    pub types: Vec<u8>,
}

/// Request of [`ListParameters`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersRequest {
    /// Those that begin so; all without any.
    pub prefixes: Vec<String>,
    /// How many levels of names; 0 for all.
    pub depth: u64,
}

/// Response of [`ListParameters`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersResponse {
    /// Their names.
    pub names: Vec<String>,
    /// Prefixes of these.
    pub prefixes: Vec<String>,
}

/// A range of numbers, from, to and step.
pub type Range<T, S> = (T, T, S);

/// What a parameter is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterDescriptor {
    /// Its name.
    pub name: String,
    /// One of [`ParameterType`].
    pub r#type: u8,
    /// For people.
    pub description: String,
    /// Which values it takes, for people.
    pub additional_constraints: String,
    /// True if it cannot be set.
    pub read_only: bool,
    /// True if its kind may change.
    pub dynamic_typing: bool,
    /// At most one.
    pub floating_point_range: Vec<Range<f64, f64>>,
    /// At most one.
    pub integer_range: Vec<Range<i64, u64>>,
}

/// Response of [`DescribeParameters`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DescribeParametersResponse {
    /// In the order of the request.
    pub descriptors: Vec<ParameterDescriptor>,
}

ros_service! {
    /// Sets parameters: `<node>/set_parameters`.
    SetParameters: rcl_interfaces, SetParametersRequest => SetParametersResponse
}
ros_service! {
    /// Sets all parameters or none: `<node>/set_parameters_atomically`.
    SetParametersAtomically: rcl_interfaces, SetParametersRequest => SetParametersAtomicallyResponse
}
ros_service! {
    /// Their values: `<node>/get_parameters`.
    GetParameters: rcl_interfaces, Names => GetParametersResponse
}
ros_service! {
    /// Their kinds: `<node>/get_parameter_types`.
    GetParameterTypes: rcl_interfaces, Names => GetParameterTypesResponse
}
ros_service! {
    /// Their names: `<node>/list_parameters`.
    ListParameters: rcl_interfaces, ListParametersRequest => ListParametersResponse
}
ros_service! {
    /// What they are: `<node>/describe_parameters`.
    DescribeParameters: rcl_interfaces, Names => DescribeParametersResponse
}
