//! The building as a model for viewers, which a client gets under its URL: made when the first one asks for it.

use bus::{Bus, Daemon, SiteSet, SiteSetReader, SiteViews};
use daemon::{Failure, SiteConfig, read_parsed};
use export::ExportInput;
use foxglove::messages::{ModelPrimitive, Pose, Quaternion, SceneEntity, SceneUpdate, Timestamp, Vector3};
use ros::msg::std_msgs::Header;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use world::WorldOptions;

/// What a URL of the model begins and ends with; between is what the model is made of, so that viewers load a new one.
const BEGIN: &str = "package://groundplan/";
const END: &str = "/site.glb";
/// For a set of maps to be there.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Interval between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The model, and where it comes from.
pub(super) struct WorldModel {
    config: SiteConfig,
    options: WorldOptions,
    /// The newest one, and the set that it is made of. One is made at a time, however many ask.
    newest: Mutex<Option<(u64, Arc<Vec<u8>>)>>,
}

impl WorldModel {
    /// The model of a site.
    ///
    /// # Errors
    /// Options of worlds that cannot be read.
    pub(super) fn of(config: &SiteConfig) -> Result<Self, Failure> {
        let read = |path| read_parsed("options of worlds", path, WorldOptions::parse);
        let options = config.world.options.as_deref().map(read).transpose()?.unwrap_or_default();
        Ok(Self { config: config.clone(), options, newest: Mutex::default() })
    }

    /// The model of the set that is published now.
    ///
    /// # Errors
    /// A URL that is not the model's, no set of maps.
    pub(super) fn fetch(&self, url: &str) -> Result<Arc<Vec<u8>>, Failure> {
        if !(url.starts_with(BEGIN) && url.ends_with(END)) {
            return Err(format!("there is no {url}").into());
        }
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let (bus, mut waiter) = Bus::join(&self.config.domain()?, Daemon::Groundplan)?;
        let (mut reader, begun) = (SiteSetReader::of(&bus)?, Instant::now());
        loop {
            reader.take()?;
            if let Some(set) = reader.set().filter(|set| set.mission_plan.is_some()) {
                let made_of = set.index.content_hash();
                if let Some((last, bytes)) = &*newest
                    && *last == made_of
                {
                    return Ok(Arc::clone(bytes));
                }
                let bytes = Arc::new(self.model(&set)?);
                *newest = Some((made_of, Arc::clone(&bytes)));
                return Ok(bytes);
            }
            if begun.elapsed() > TIMEOUT {
                return Err("there are no maps and waypoints that belong together".into());
            }
            waiter.wait(POLL_INTERVAL)?;
        }
    }

    fn model(&self, set: &SiteSet<'_>) -> Result<Vec<u8>, Failure> {
        let SiteViews { site, state, index, grids, mission_plan } = &set.views()?;
        let mission_plan = mission_plan.as_ref().ok_or("there are no waypoints")?;
        let input = ExportInput {
            site,
            schedule_state: state,
            index,
            grids,
            mission_plan,
            footprints: &[],
            resolution_m: self.config.robot.resolution_m,
            with_geometry: false,
        };
        Ok(world::model(&input, &self.options))
    }
}

/// The model of a set, lowered so that the floor of the storey lies in the plane of its maps.
pub(super) fn update(set: u64, floor_z_m: f64, header: &Header) -> SceneUpdate {
    let timestamp = Timestamp::new_checked(u32::try_from(header.stamp.sec).unwrap_or_default(), header.stamp.nanosec);
    let pose = Pose {
        position: Some(Vector3 { x: 0.0, y: 0.0, z: -floor_z_m }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    };
    let model = ModelPrimitive {
        pose: Some(pose),
        scale: Some(Vector3 { x: 1.0, y: 1.0, z: 1.0 }),
        url: format!("{BEGIN}{set:016x}{END}"),
        media_type: "model/gltf-binary".to_owned(),
        ..ModelPrimitive::default()
    };
    let entity = SceneEntity {
        timestamp,
        frame_id: header.frame_id.clone(),
        id: "world".to_owned(),
        frame_locked: true,
        models: vec![model],
        ..SceneEntity::default()
    };
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_lies_with_its_floor_in_the_plane_and_its_url_tells_the_set() {
        let update = update(0xabc, 3.5, &Header { frame_id: "site_map".to_owned(), ..Header::default() });
        let entity = &update.entities[0];
        assert_eq!((entity.id.as_str(), entity.frame_id.as_str()), ("world", "site_map"));
        let model = &entity.models[0];
        assert_eq!(model.url, "package://groundplan/0000000000000abc/site.glb");
        assert_eq!(model.pose.as_ref().unwrap().position, Some(Vector3 { x: 0.0, y: 0.0, z: -3.5 }));
    }
}
