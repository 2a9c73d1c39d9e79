//! Parameters of the node: the plan time and the storey.

use crate::control::Control;
use bus::Daemon;
use daemon::facts::RosBridgeFacts;
use daemon::{Failure, Report, SiteConfig, StatusBoard, chain};
use messages::plan_time;
use ros::srv::rcl_interfaces::*;
use tracing::info;

/// The civil time of the schedule, as `2024-04-15T08:30:00`; empty while everything is built.
const PLAN_TIME: &str = "plan_time";
/// Index of the map storey; -1 for that of configuration or alignment.
const STOREY: &str = "storey";

const NAMES: [&str; 2] = [PLAN_TIME, STOREY];

pub(crate) fn list(request: &ListParametersRequest) -> ListParametersResponse {
    let is_asked = |name: &&str| request.prefixes.is_empty() || request.prefixes.iter().any(|prefix| prefix == name);
    let names = NAMES.into_iter().filter(is_asked).map(str::to_owned).collect();
    ListParametersResponse { names, prefixes: Vec::new() }
}

pub(crate) fn describe(names: &Names) -> DescribeParametersResponse {
    let describe = |name: &String| {
        let (r#type, description) = match name.as_str() {
            PLAN_TIME => (ParameterType::STRING, "plan time, as 2024-04-15T08:30:00 at the site"),
            STOREY => (ParameterType::INTEGER, "index of the map storey; -1 for that of configuration or alignment"),
            _ => (ParameterType::NOT_SET, ""),
        };
        ParameterDescriptor {
            name: name.clone(),
            r#type,
            description: description.to_owned(),
            ..ParameterDescriptor::default()
        }
    };
    DescribeParametersResponse { descriptors: names.names.iter().map(describe).collect() }
}

pub(crate) fn types(names: &Names) -> GetParameterTypesResponse {
    GetParameterTypesResponse { types: describe(names).descriptors.iter().map(|d| d.r#type).collect() }
}

pub(crate) fn get(config: &SiteConfig, names: &Names) -> GetParametersResponse {
    let board = StatusBoard::of_own(config);
    let value = |name: &String| match name.as_str() {
        PLAN_TIME => {
            let report = daemon::schedule_report(&board);
            let at = report.and_then(|report| plan_time(report.facts.plan_time_s?));
            ParameterValue::string(at.map(|at| at.to_string()).unwrap_or_default())
        }
        STOREY => {
            let report: Option<Report<RosBridgeFacts>> = board.report(Daemon::RosBridge);
            let storey = report.and_then(|report| report.facts.set_storey);
            ParameterValue::integer(storey.map_or(-1, i64::from))
        }
        _ => ParameterValue::default(),
    };
    GetParametersResponse { values: names.names.iter().map(value).collect() }
}

/// Sets parameters one after the other. The storey is the robot's to tell; the plan time is the site's, which must allow it.
pub(crate) fn set(control: &Control, request: &SetParametersRequest) -> SetParametersResponse {
    let set = |parameter: &Parameter| result(&parameter.name, set_one(control, parameter));
    SetParametersResponse { results: request.parameters.iter().map(set).collect() }
}

/// Sets one parameter. Several are refused: plan time and storey are set by two processes, and what one did cannot be undone
/// where the other refuses.
pub(crate) fn set_atomically(control: &Control, request: &SetParametersRequest) -> SetParametersAtomicallyResponse {
    let done = match request.parameters.as_slice() {
        [parameter] => set_one(control, parameter),
        several => Err(format!("{} parameters at once: one at a time can be set so", several.len()).into()),
    };
    let names: Vec<&str> = request.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    SetParametersAtomicallyResponse { result: result(&names.join(", "), done) }
}

fn result(name: &str, done: Result<(), Failure>) -> SetParametersResult {
    let reason = done.err().map(|why| chain(why.as_ref()));
    info!(service = "ros-bridge", parameter = name, refused = reason, "a parameter was set from ROS");
    SetParametersResult { successful: reason.is_none(), reason: reason.unwrap_or_default() }
}

fn set_one(control: &Control, Parameter { name, value }: &Parameter) -> Result<(), Failure> {
    let allow_control = control.config.ros.allow_control;
    match (name.as_str(), value.r#type) {
        (PLAN_TIME, ParameterType::STRING) if allow_control => control.set_plan_time(&value.string_value).map(drop),
        (PLAN_TIME, ParameterType::STRING) => Err("the site does not allow it: ros.allow_control is false".into()),
        (STOREY, ParameterType::INTEGER) => {
            let storey = u32::try_from(value.integer_value).ok();
            if storey.is_none() && value.integer_value != -1 {
                return Err(format!("{} is no storey: 0 and above, or -1", value.integer_value).into());
            }
            control.set_storey(storey)
        }
        (PLAN_TIME, _) => Err("plan_time is a string".into()),
        (STOREY, _) => Err("storey is an integer".into()),
        _ => Err(format!("there is no parameter {name}: it is one of {}", NAMES.join(", ")).into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_listed_and_described_by_their_names() {
        let names = list(&ListParametersRequest::default()).names;
        assert_eq!(names, NAMES);
        let types = types(&Names { names: [names, vec!["other".to_owned()]].concat() }).types;
        assert_eq!(types, [ParameterType::STRING, ParameterType::INTEGER, ParameterType::NOT_SET]);
        let asked = ListParametersRequest { prefixes: vec![STOREY.to_owned()], depth: 0 };
        assert_eq!(list(&asked).names, [STOREY]);
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_why() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site.toml");
        std::fs::write(&path, "state = \"state\"\n").unwrap();
        let control = Control { config: SiteConfig::read(&path).unwrap() };
        let why = |name: &str, value: ParameterValue| {
            let parameters = vec![Parameter { name: name.to_owned(), value }];
            let result = set(&control, &SetParametersRequest { parameters }).results.remove(0);
            assert!(!result.successful);
            result.reason
        };
        assert!(why(PLAN_TIME, ParameterValue::string("2024-04-15".to_owned())).contains("allow_control"));
        assert!(why(PLAN_TIME, ParameterValue::integer(3)).contains("string"));
        assert!(why(STOREY, ParameterValue::integer(-2)).contains("no storey"));
        assert!(why("storeys", ParameterValue::integer(1)).contains("plan_time, storey"));
        for (n_parameters, expected) in [(1, "no storey"), (2, "2 parameters at once"), (0, "0 parameters at once")] {
            let wrong = Parameter { name: STOREY.to_owned(), value: ParameterValue::integer(-2) };
            let parameters = vec![wrong; n_parameters];
            let result = set_atomically(&control, &SetParametersRequest { parameters }).result;
            assert!(!result.successful && result.reason.contains(expected), "{result:?}");
        }
    }
}
