//! The requests of each daemon, with their answers.
//!
//! # Which may be sent twice
//!
//! Where a daemon dies before it has answered, [`crate::ask`] sends a request once more if
//! [`Request::may_be_sent_twice`](crate::Request::may_be_sent_twice): the second then does nothing that the first did not, since it
//! names all that it changes, or what the client saw.
//!
//! | daemon | may not be sent twice | because |
//! |---|---|---|
//! | `ifc-ingest` | [`IngestRequest::Load`] | the files may be what it died of |
//! | `ifc-ingest` | [`IngestRequest::Discard`] | another revision may wait by then |
//! | `schedule-eval` | [`ScheduleRequest::Simulate`] without `from_s` | it starts where the plan time is when it comes |
//!
//! All others may be. What daemons send each other without being asked is sent again until it is in force.

mod align;
mod ask;
mod ingest;
mod rasterize;
mod ros_bridge;
mod schedule;
mod server;
mod waypoints;
mod web;

pub use align::{
    AlignAnswer, AlignRequest, ComparisonState, Confirmations, Confirmed, ConfirmedElement, ListedPose, SearchState,
};
pub use ask::AskRequest;
pub use ingest::{IngestAnswer, IngestRequest, Revision, RevisionEffect};
pub use rasterize::{RasterizeAnswer, RasterizeRequest};
pub use ros_bridge::RosBridgeRequest;
pub use schedule::{
    ActualsSource, MAX_RATE, MIN_RATE, RateError, ScheduleAnswer, ScheduleRequest, ScheduleVerdict, checked_rate,
};
pub use server::{FollowRequest, ServeRequest};
pub use waypoints::{WaypointAnswer, WaypointRequest};
pub use web::WebRequest;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::Pose;
    use crate::failure::chain;
    use crate::file_text::FileText;
    use crate::known_places::{KnownPlaces, PointInRoom};
    use crate::request::{Request, parse_request};
    use messages::ContentId;

    fn refusal<R: Request>(bytes: &[u8]) -> String {
        chain(&parse_request::<R>(bytes).unwrap_err())
    }

    #[test]
    fn only_what_names_neither_its_files_nor_its_instant_for_sure_is_not_sent_twice() {
        let load = IngestRequest::Load { models: Vec::new(), dry_run: false, force: false };
        let simulate = |from_s| ScheduleRequest::Simulate { rate: 1.0, from_s };
        assert!(![&load, &IngestRequest::Discard].iter().any(|request| request.may_be_sent_twice()));
        assert!(!simulate(None).may_be_sent_twice() && simulate(Some(0)).may_be_sent_twice());
        let confirm = IngestRequest::Confirm { sha256: Vec::new() };
        assert!([confirm, IngestRequest::GetRevision].iter().all(Request::may_be_sent_twice));
        let schedule = [
            ScheduleRequest::SetPlanTime { at_s: 0 },
            ScheduleRequest::NextChange { after_s: None },
            ScheduleRequest::FollowWallClock,
            ScheduleRequest::GetPlanTime,
            ScheduleRequest::GetVerdict,
            ScheduleRequest::UndoActuals { table: String::new() },
        ];
        assert!(schedule.iter().all(Request::may_be_sent_twice));
    }

    #[test]
    fn a_request_of_another_daemon_is_refused_with_the_name_of_the_one_that_got_it() {
        let profile = FileText { path: "/r.toml".into(), text: "name = \"x\"\n".to_owned() };
        let robot = serde_json::to_vec(&RasterizeRequest::SetRobot { profile }).unwrap();
        assert!(parse_request::<RasterizeRequest>(&robot).is_ok());
        let all = [
            ("ifc-ingest", refusal::<IngestRequest>(&robot)),
            ("schedule-eval", refusal::<ScheduleRequest>(&robot)),
            ("waypoint-gen", refusal::<WaypointRequest>(&robot)),
            ("slam-align", refusal::<AlignRequest>(&robot)),
            ("rasterize", refusal::<RasterizeRequest>(b"\xff\x00 no JSON")),
            ("rasterize", refusal::<RasterizeRequest>(b"")),
            (
                "rasterize",
                refusal::<RasterizeRequest>(br#"{"set_robot":{"profile":{"path":"/r.toml","text":""},"speed":1}}"#),
            ),
        ];
        for (daemon, refusal) in all {
            assert!(refusal.starts_with(&format!("this is no request of {daemon}: ")), "{refusal}");
        }
    }

    #[test]
    fn requests_survive_the_way_over_the_bus() {
        fn check<R: Request + PartialEq>(request: &R) {
            let bytes = serde_json::to_vec(request).unwrap();
            assert_eq!(&parse_request::<R>(&bytes).unwrap(), request);
        }
        check(&IngestRequest::Load { models: vec!["/a.ifc".into()], dry_run: false, force: true });
        check(&IngestRequest::Confirm { sha256: vec![ContentId::of(b"a")] });
        check(&ScheduleRequest::NextChange { after_s: Some(-1) });
        check(&ScheduleRequest::Simulate { rate: 3600.0, from_s: None });
        check(&ScheduleRequest::SetActuals { file: None, source: ActualsSource::Observed, robot: None });
        let robot = Some("lift".to_owned());
        check(&ScheduleRequest::SetActuals { file: None, source: ActualsSource::Observed, robot });
        check(&WaypointRequest::SetWaypoints { options: None, spaces: vec!["1*".into()], changed_since_s: Some(-1) });
        let rooms = vec![PointInRoom { x_m: 1.0, y_m: -2.0, room: "U.04".to_owned() }];
        let places = KnownPlaces { rooms, elevation_m: Some(3.2), portal: None };
        check(&AlignRequest::Align { hint: None, storey: Some(2), places });
        check(&AlignRequest::UndoAbsent { elements: vec!["1".to_owned()] });
        let map_from_slam = Pose { x_m: 0.1, y_m: -1.0 / 3.0, yaw_rad: 1e-9 };
        check(&AlignRequest::ConfirmPose { waiting: ListedPose { storey: 1, map_from_slam } });
    }
}
