//! Values of `[ros]` that cannot work: topics, frames, numbers.

use crate::failure::Failure;
use crate::requests::{RateError, checked_rate};
use crate::ros_config::{QosConfig, RosConfig, SimTimeConfig};
use frames::{PlanTime, PlanTimeError};

/// A simulated time that no plan time can follow.
#[derive(Debug, thiserror::Error)]
pub enum SimTimeError {
    /// No date-time.
    #[error("plan_time_at_zero")]
    Zero(#[source] PlanTimeError),
    /// A rate that is none.
    #[error("rate")]
    Rate(#[source] RateError),
}

impl SimTimeConfig {
    /// The civil seconds since 1970 when `/clock` says zero, and the seconds of plan time for each of `/clock`.
    ///
    /// # Errors
    /// A plan time or a rate that is none.
    pub fn zero_and_rate(&self) -> Result<(i64, f64), SimTimeError> {
        let zero: PlanTime = self.plan_time_at_zero.parse().map_err(SimTimeError::Zero)?;
        Ok((zero.civil_seconds(), checked_rate(self.rate).map_err(SimTimeError::Rate)?))
    }
}

impl RosConfig {
    /// Keys whose values cannot work, with the reason: the bridge would take its own map for the robot's, or a value is none.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let mut faults = Vec::new();
        if let Some(id) = self.domain_id.filter(|id| *id > Self::MAX_DOMAIN) {
            faults.push(("ros.domain_id", format!("{id} is no ROS domain: it must be 0 to {}", Self::MAX_DOMAIN)));
        }
        let own = self.full_name(self.map_topic.as_deref().unwrap_or("map"));
        let taken = self.slam_map_topic.as_deref().map(|topic| self.full_name(topic));
        if taken.as_ref() == Some(&own) {
            let why = format!("it is {own}, on which the bridge publishes: set another ros.map_topic");
            faults.push(("ros.slam_map_topic", why));
        }
        // Without SLAM there is no other frame.
        let has_slam = self.slam_map_topic.is_some() || self.in_slam_frame;
        if has_slam && self.frame == self.slam_frame {
            let why = format!("ros.frame and ros.slam_frame are both {:?}: they are two frames", self.frame);
            faults.push(("ros.frame", why));
        }
        for (output, qos) in &self.qos {
            faults.extend(qos.faults().map(|why| ("ros.qos", format!("{output:?}: {why}"))));
        }
        if let Some(Err(why)) = self.sim_time.as_ref().map(SimTimeConfig::zero_and_rate) {
            faults.push(("ros.sim_time", crate::chain(&why)));
        }
        faults
    }

    /// Refuses values that cannot work.
    ///
    /// # Errors
    /// The first of them.
    pub fn check(&self) -> Result<(), Failure> {
        let fault = self.faults().into_iter().next();
        fault.map_or(Ok(()), |(key, why)| Err(format!("{key}: {why}").into()))
    }
}

impl QosConfig {
    fn faults(&self) -> impl Iterator<Item = String> {
        let depth = self.depth.filter(|depth| !Self::DEPTHS.contains(depth));
        let depth = depth.map(|depth| format!("depth is {depth}: {:?} is meant", Self::DEPTHS));
        let times = [("lifespan_s", self.lifespan_s), ("deadline_s", self.deadline_s)];
        let times = times.into_iter().filter_map(|(key, time_s)| Some((key, time_s?)));
        let unusable = times.filter(|(_, time_s)| !(time_s.is_finite() && *time_s > 0.0));
        depth.into_iter().chain(unusable.map(|(key, time_s)| format!("{key} is {time_s}: more than 0 is meant")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros_config::RosOutput;

    #[test]
    fn qualities_that_no_topic_has_are_refused() {
        let config = |qos| RosConfig { qos: [(RosOutput::Map, qos)].into(), ..RosConfig::default() };
        let depth = |depth| config(QosConfig { depth: Some(depth), ..QosConfig::default() }).check();
        assert!(depth(1).is_ok() && depth(100).is_ok());
        assert!(depth(0).unwrap_err().to_string().contains("1..=100 is meant") && depth(101).is_err());
        let lifespan = |time_s| config(QosConfig { lifespan_s: Some(time_s), ..QosConfig::default() }).check();
        assert!(lifespan(0.5).is_ok() && lifespan(0.0).is_err() && lifespan(f64::NAN).is_err());
    }

    #[test]
    fn the_topic_out_and_in_are_two_topics_and_frames_are_two_frames() {
        let config = |slam_map_topic: &str, map_topic: Option<&str>| RosConfig {
            slam_map_topic: Some(slam_map_topic.to_owned()),
            map_topic: map_topic.map(str::to_owned),
            ..RosConfig::default()
        };
        assert!(config("/map", None).check().is_ok() && config("/map", Some("planned")).check().is_ok());
        for same in [config("/map", Some("/map")), config("map", None), config("/groundplan/map", None)] {
            assert!(same.check().unwrap_err().to_string().contains("slam_map_topic"), "{same:?}");
        }
        let one_frame = RosConfig { frame: "map".to_owned(), ..RosConfig::default() };
        assert!(one_frame.check().is_ok(), "without SLAM there is no other");
        assert!(RosConfig { in_slam_frame: true, ..one_frame.clone() }.check().is_err());
        assert!(RosConfig { slam_map_topic: Some("/map".to_owned()), ..one_frame }.check().is_err());
    }
}
