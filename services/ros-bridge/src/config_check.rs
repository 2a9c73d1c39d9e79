//! Checks `[ros]` for topics, frames and values that cannot work.

use crate::graph::full_name;
use crate::sim_time::SimTime;
use daemon::{Failure, QosConfig, RosConfig};

/// Refuses a configuration with which the bridge would take its own map for the robot's, or that has values that are none.
pub(crate) fn check(config: &RosConfig) -> Result<(), Failure> {
    let own = full_name(&config.namespace, config.map_topic.as_deref().unwrap_or("map"));
    let taken = config.slam_map_topic.as_deref().map(|topic| full_name(&config.namespace, topic));
    if taken.as_ref() == Some(&own) {
        return Err(
            format!("ros.slam_map_topic is {own}, on which the bridge publishes: set another ros.map_topic").into()
        );
    }
    // Without SLAM there is no other frame.
    let has_slam = config.slam_map_topic.is_some() || config.in_slam_frame;
    if has_slam && config.frame == config.slam_frame {
        return Err(format!("ros.frame and ros.slam_frame are both {:?}: they are two frames", config.frame).into());
    }
    for (output, qos) in &config.qos {
        if let Some(depth) = qos.depth.filter(|depth| !QosConfig::DEPTHS.contains(depth)) {
            return Err(format!("the depth of qos {output:?} is {depth}: {:?} is meant", QosConfig::DEPTHS).into());
        }
        let times = [("lifespan_s", qos.lifespan_s), ("deadline_s", qos.deadline_s)];
        for (key, time_s) in times.into_iter().filter_map(|(key, time_s)| Some((key, time_s?))) {
            if !(time_s.is_finite() && time_s > 0.0) {
                return Err(format!("{key} of qos {output:?} is {time_s}: more than 0 is meant").into());
            }
        }
    }
    config.sim_time.as_ref().map_or(Ok(()), |sim_time| SimTime::of(sim_time).map(drop))
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::RosOutput;

    #[test]
    fn qualities_that_no_topic_has_are_refused() {
        let config = |qos| RosConfig { qos: [(RosOutput::Map, qos)].into(), ..RosConfig::default() };
        let depth = |depth| check(&config(QosConfig { depth: Some(depth), ..QosConfig::default() }));
        assert!(depth(1).is_ok() && depth(100).is_ok());
        assert!(depth(0).unwrap_err().to_string().contains("1..=100 is meant") && depth(101).is_err());
        let lifespan = |time_s| check(&config(QosConfig { lifespan_s: Some(time_s), ..QosConfig::default() }));
        assert!(lifespan(0.5).is_ok() && lifespan(0.0).is_err() && lifespan(f64::NAN).is_err());
    }

    #[test]
    fn the_topic_out_and_in_are_two_topics_and_frames_are_two_frames() {
        let config = |slam_map_topic: &str, map_topic: Option<&str>| RosConfig {
            slam_map_topic: Some(slam_map_topic.to_owned()),
            map_topic: map_topic.map(str::to_owned),
            ..RosConfig::default()
        };
        assert!(check(&config("/map", None)).is_ok() && check(&config("/map", Some("planned"))).is_ok());
        for same in [config("/map", Some("/map")), config("map", None), config("/groundplan/map", None)] {
            assert!(check(&same).unwrap_err().to_string().contains("slam_map_topic"), "{same:?}");
        }
        let one_frame = RosConfig { frame: "map".to_owned(), ..RosConfig::default() };
        assert!(check(&one_frame).is_ok(), "without SLAM there is no other");
        assert!(check(&RosConfig { in_slam_frame: true, ..one_frame.clone() }).is_err());
        assert!(check(&RosConfig { slam_map_topic: Some("/map".to_owned()), ..one_frame }).is_err());
    }
}
