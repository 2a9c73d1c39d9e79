//! The building as a model for viewers, which a client gets under its URL: made when the first one asks for it.

use super::timestamp::timestamp;
use bus::{Bus, Daemon};
use daemon::{Failure, SiteConfig, read_parsed};
use export::ExportInput;
use foxglove::messages::{ModelPrimitive, Pose, Quaternion, SceneEntity, SceneUpdate, Vector3};
use messages::{ContentId, ShortContentId};
use ros::msg::std_msgs::Header;
use site_view::{SiteSet, SiteSetReader, SiteViews};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use world::WorldOptions;

/// What a URL of the model begins and ends with; between is what the model is made of, so that viewers load a new one.
const BEGIN: &str = "package://groundplan/";
const END: &str = "/site.glb";
/// For a set of maps to be there.
const TIMEOUT: Duration = Duration::from_secs(30);
/// Interval between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// The server keeps an answer until its client has read it: so many bytes are handed out within a minute, and no larger models.
const MAX_BYTES_A_MINUTE: usize = 256 << 20;
const MAX_MODEL_BYTES: usize = 64 << 20;

/// The model, and where it comes from.
pub(super) struct WorldModel {
    config: SiteConfig,
    /// The newest one. One is made at a time, however many ask.
    newest: Mutex<Option<Model>>,
    /// When how many bytes were handed out.
    handed_out: Mutex<VecDeque<(Instant, usize)>>,
}

struct Model {
    /// The index of the set that it is made of.
    made_of: ShortContentId,
    bytes: Arc<[u8]>,
}

impl WorldModel {
    /// The model of a site.
    pub(super) fn of(config: &SiteConfig) -> Self {
        Self { config: config.clone(), newest: Mutex::default(), handed_out: Mutex::default() }
    }

    /// The model of a URL.
    ///
    /// # Errors
    /// A URL that is not that of the set which is published now; too many who ask.
    pub(super) fn fetch(&self, url: &str) -> Result<Arc<[u8]>, Failure> {
        let named = url.strip_prefix(BEGIN).and_then(|rest| rest.strip_suffix(END));
        let wanted = named.and_then(|id| id.parse().ok());
        let wanted = wanted.ok_or_else(|| format!("there is no {url}"))?;
        let (bus, mut waiter) = Bus::join(&self.config.domain()?, Daemon::Groundplan)?;
        let (mut reader, begun) = (SiteSetReader::of(&bus)?, Instant::now());
        loop {
            reader.take()?;
            if let Some(set) = reader.set().filter(|set| set.mission_plan.is_some()) {
                return self.hand_out(wanted, &set);
            }
            if begun.elapsed() > TIMEOUT {
                return Err("there are no maps and waypoints that belong together".into());
            }
            waiter.wait(POLL_INTERVAL)?;
        }
    }

    fn hand_out(&self, wanted: ShortContentId, set: &SiteSet<'_>) -> Result<Arc<[u8]>, Failure> {
        if wanted != ContentId::of(set.index.bytes().bytes()).short() {
            return Err("the building is another by now: its model has another URL".into());
        }
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = match &*newest {
            Some(model) if model.made_of == wanted => Arc::clone(&model.bytes),
            _ => {
                let bytes: Arc<[u8]> = self.model(set)?.into();
                *newest = Some(Model { made_of: wanted, bytes: Arc::clone(&bytes) });
                bytes
            }
        };
        drop(newest);
        if bytes.len() > MAX_MODEL_BYTES {
            let megabytes = bytes.len() >> 20;
            return Err(format!("the model has {megabytes} MB: groundplan export --world writes it").into());
        }
        let mut handed_out = self.handed_out.lock().unwrap_or_else(PoisonError::into_inner);
        if account(&mut handed_out, Instant::now(), bytes.len()) {
            Ok(bytes)
        } else {
            Err("too many ask for the model: ask again in a minute".into())
        }
    }

    fn model(&self, set: &SiteSet<'_>) -> Result<Vec<u8>, Failure> {
        let SiteViews { site, state, index, grids, mission_plan } = &set.views()?;
        let mission_plan = mission_plan.as_ref().ok_or("there are no waypoints")?;
        let read = |path| read_parsed("options of worlds", path, WorldOptions::parse);
        let options = self.config.world.options.as_deref().map(read).transpose()?.unwrap_or_default();
        let input = ExportInput::of_maps(site, state, index, grids, mission_plan).ok_or("there are no maps")?;
        Ok(world::model(&input, &options))
    }
}

/// True if so many more bytes may be handed out now: then they are.
fn account(handed_out: &mut VecDeque<(Instant, usize)>, now: Instant, n_bytes: usize) -> bool {
    handed_out.retain(|(at, _)| now.duration_since(*at) < Duration::from_secs(60));
    let is_within = handed_out.iter().map(|(_, n)| n).sum::<usize>() + n_bytes <= MAX_BYTES_A_MINUTE;
    if is_within {
        handed_out.push_back((now, n_bytes));
    }
    is_within
}

/// The model of a set, lowered so that the floor of the storey lies in the plane of its maps.
pub(super) fn update(set: ShortContentId, floor_z_m: f64, header: &Header) -> SceneUpdate {
    let pose = Pose {
        position: Some(Vector3 { x: 0.0, y: 0.0, z: -floor_z_m }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    };
    let model = ModelPrimitive {
        pose: Some(pose),
        scale: Some(Vector3 { x: 1.0, y: 1.0, z: 1.0 }),
        url: format!("{BEGIN}{set}{END}"),
        media_type: "model/gltf-binary".to_owned(),
        ..ModelPrimitive::default()
    };
    let entity = SceneEntity {
        timestamp: timestamp(header),
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
        let set = "00000000000000000000000000000abc".parse().unwrap();
        let update = update(set, 3.5, &Header { frame_id: "site_map".to_owned(), ..Header::default() });
        let entity = &update.entities[0];
        assert_eq!((entity.id.as_str(), entity.frame_id.as_str()), ("world", "site_map"));
        let model = &entity.models[0];
        assert_eq!(model.url, "package://groundplan/00000000000000000000000000000abc/site.glb");
        assert_eq!(model.pose.as_ref().unwrap().position, Some(Vector3 { x: 0.0, y: 0.0, z: -3.5 }));
    }

    #[test]
    fn so_many_bytes_are_handed_out_a_minute() {
        let (mut handed_out, begun) = (VecDeque::new(), Instant::now());
        let half = MAX_BYTES_A_MINUTE / 2;
        let after = |seconds| begun + Duration::from_secs(seconds);
        assert!(account(&mut handed_out, after(0), half) && account(&mut handed_out, after(30), half));
        assert!(!account(&mut handed_out, after(59), 1));
        assert!(account(&mut handed_out, after(60), half) && !account(&mut handed_out, after(89), 1));
    }

    #[test]
    fn another_url_is_none() {
        let config = SiteConfig::parse("state = \"state\"\n", std::path::Path::new("/")).unwrap();
        for url in ["package://groundplan/site.glb", "package://groundplan/x/site.glb", "file:///etc/passwd"] {
            assert!(WorldModel::of(&config).fetch(url).unwrap_err().to_string().contains(url));
        }
    }
}
