//! State that the service and the threads of the server share: the newest samples, and the documents made of them.

use super::content_names::{model_name, tiles_name};
use super::live_answers;
use super::live_documents::MadeDate;
use super::{ControlError, Feed, LiveSite, control};
use crate::documents::TasksDocument;
use crate::kept::Kept;
use crate::question::Question;
use crate::source::{Bytes, ContentName, Source, SourceError, TileAddress, json, locked};
use crate::tiles::{Extent, Layer, LayerCells, TileGrid, strength_of_class, strength_of_pixel};
use answers::MapUse;
use bus::{CheckedSample, GridSlot};
use daemon::{Failure, SiteConfig, read_parsed};
use export::ExportInput;
use grid::pixel_of;
use messages::{ContentHash, Grid};
use schedule::Timeline;
use site_view::SiteSamples;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};
use tokio::sync::watch;
use world::WorldOptions;

/// Answers that are kept, in bytes.
const MAX_KEPT_ANSWER_BYTES: usize = 4 << 20;

/// Documents of dates that viewers may still ask for.
const N_DATES: usize = 8;

/// The running site.
pub(crate) struct SharedSite {
    config: SiteConfig,
    samples: Mutex<SiteSamples>,
    documents: Mutex<Documents>,
    feed: watch::Sender<Feed>,
    slam_picture: Mutex<Option<(ContentName, Bytes)>>,
    model: Mutex<Option<(ContentName, Bytes)>>,
    checked: Mutex<Instant>,
    /// Whether the maps that are shown may be used, as viewers were told last.
    maps: Mutex<MapUse>,
    /// Answers about the maps that are shown. Who makes one holds it, so that one is made at a time.
    answers: Mutex<Kept<AnswerKey, Bytes>>,
}

/// What an answer is of: number of the schedule, site, schedule state, grids and mission plan by their hashes, whether they may be
/// used, and the question.
type AnswerKey = (u64, [ContentHash; 4], MapUse, Question);

/// What was made of the newest samples.
#[derive(Default)]
pub(super) struct Documents {
    pub(super) site: Option<Bytes>,
    pub(super) calendar: Option<Bytes>,
    pub(super) tasks: Option<Arc<TasksDocument>>,
    /// By key, the newest last.
    pub(super) dates: VecDeque<(String, MadeDate)>,
    pub(super) tiles: Option<TileGrid>,
    /// The schedule in force, with a number that no other has.
    pub(super) schedule: (u64, Option<Arc<Timeline>>),
}

impl SharedSite {
    pub(super) fn of(config: &SiteConfig) -> Self {
        Self {
            config: config.clone(),
            samples: Mutex::default(),
            documents: Mutex::default(),
            feed: watch::Sender::default(),
            slam_picture: Mutex::default(),
            model: Mutex::default(),
            checked: Mutex::new(Instant::now()),
            maps: Mutex::new(MapUse::of(Some("whether they may be used was not looked at yet".to_owned()))),
            answers: Mutex::new(Kept::of(MAX_KEPT_ANSWER_BYTES)),
        }
    }

    /// The daemons were looked at now.
    pub(super) fn set_checked(&self) {
        *locked(&self.checked) = Instant::now();
    }

    /// How long ago they were.
    pub(super) fn unchecked_for(&self) -> Duration {
        locked(&self.checked).elapsed()
    }

    /// Viewers are told whether the maps may be used.
    pub(super) fn set_maps(&self, maps: MapUse) {
        *locked(&self.maps) = maps;
    }

    /// The newest samples.
    pub(super) fn samples(&self) -> MutexGuard<'_, SiteSamples> {
        locked(&self.samples)
    }

    /// What was made of them.
    pub(super) fn documents(&self) -> MutexGuard<'_, Documents> {
        locked(&self.documents)
    }

    /// Tells viewers, if it is not what they know.
    pub(super) fn tell(&self, kind: &'static str, event: &impl serde::Serialize) {
        let text = serde_json::to_string(event).expect("keys are texts, and numbers are finite");
        self.feed.send_if_modified(|feed| {
            let is_new = feed.get(kind).is_none_or(|known| **known != *text);
            if is_new {
                feed.insert(kind, text.into());
            }
            is_new
        });
    }

    /// Takes the picture of the robot's map.
    pub(super) fn set_slam_picture(&self, picture: Option<(ContentName, Bytes)>) {
        *locked(&self.slam_picture) = picture;
    }

    /// True if this picture is there.
    pub(super) fn has_slam_picture(&self, name: &ContentName) -> bool {
        locked(&self.slam_picture).as_ref().is_some_and(|(known, _)| known == name)
    }

    fn make_model(&self, name: &ContentName) -> Result<Option<Vec<u8>>, SourceError> {
        let read = |path| read_parsed("options of worlds", path, WorldOptions::parse);
        let options = self.config.world.options.as_deref().map(read).transpose();
        let options = options.map_err(|why| SourceError::Live(why.into()))?.unwrap_or_default();
        let samples = self.samples();
        let Some(set) = samples.set().filter(|set| model_name(&self.config, set) == *name) else { return Ok(None) };
        let views = set.views().map_err(|why| SourceError::Live(why.into()))?;
        let Some(mission_plan) = &views.mission_plan else { return Ok(None) };
        let input = ExportInput::of_maps(&views.site, &views.state, &views.index, &views.grids, mission_plan);
        Ok(input.map(|input| world::model(&input, &options)))
    }
}

impl Documents {
    /// Takes the schedule in force; `None` while it is not known.
    pub(super) fn set_schedule(&mut self, timeline: Option<Timeline>) {
        self.schedule = (self.schedule.0 + 1, timeline.map(Arc::new));
    }

    /// Adds a date, and gives up the oldest one.
    pub(super) fn add_date(&mut self, key: String, made: MadeDate) {
        self.dates.retain(|(known, _)| *known != key);
        self.dates.push_back((key, made));
        while self.dates.len() > N_DATES {
            self.dates.pop_front();
        }
    }
}

impl Source for SharedSite {
    fn site(&self) -> Result<Bytes, SourceError> {
        self.documents().site.clone().ok_or(SourceError::NotYet)
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        self.documents().calendar.clone().ok_or(SourceError::NotYet)
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        let documents = self.documents();
        let found = documents.dates.iter().find(|(known, _)| known == key);
        Ok(found.map(|(_, made)| Arc::clone(&made.date)))
    }

    fn tasks(&self) -> Result<Bytes, SourceError> {
        let tasks = self.documents().tasks.clone().ok_or(SourceError::NotYet)?;
        Ok(json(&*tasks))
    }

    fn summary(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        let documents = self.documents();
        let found = documents.dates.iter().find(|(known, _)| known == key);
        Ok(found.map(|(_, made)| Arc::clone(&made.summary)))
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        let Some(tiles) = self.documents().tiles else { return Ok(None) };
        let samples = self.samples();
        let mut grids = GridSlot::all().filter_map(|slot| samples.grid(slot));
        let is_asked_for = |grid: &Grid<'_>| {
            grid.head.map_storey == address.storey && tiles_name(address.layer, grid, &tiles) == address.name
        };
        let grid = grids.find(|grid| is_asked_for(&grid.view()));
        Ok(grid.and_then(|grid| tile_of(&grid.view(), &tiles, address)).map(Bytes::from))
    }

    fn model(&self, name: &ContentName) -> Result<Option<Bytes>, SourceError> {
        let mut kept = locked(&self.model);
        if let Some((_, model)) = kept.as_ref().filter(|(known, _)| known == name) {
            return Ok(Some(Arc::clone(model)));
        }
        let made = self.make_model(name)?.map(Bytes::from);
        if let Some(model) = &made {
            *kept = Some((*name, Arc::clone(model)));
        }
        Ok(made)
    }

    fn answer(&self, question: &Question) -> Result<Bytes, SourceError> {
        let mut answers = locked(&self.answers);
        let (maps, (schedule, timeline)) = (locked(&self.maps).clone(), self.documents().schedule.clone());
        let samples = self.samples();
        let set = samples.set().ok_or(SourceError::NotYet)?;
        let plan = set.mission_plan.map_or(ContentHash::NONE, CheckedSample::content_hash);
        let hashes = [set.site.content_hash(), set.state.content_hash(), set.index.content_hash(), plan];
        let key = (schedule, hashes, maps.clone(), question.clone());
        if let Some(answer) = answers.get(&key) {
            return Ok(answer);
        }
        let answer = Bytes::from(live_answers::answer(question, &set, timeline.as_deref(), maps)?);
        answers.insert(key, Arc::clone(&answer), answer.len());
        Ok(answer)
    }
}

fn tile_of(grid: &Grid<'_>, tiles: &TileGrid, address: &TileAddress) -> Option<Vec<u8>> {
    let spec = grid.spec();
    let extent = Extent::of(&spec);
    let (layer, width, height) = (address.layer, spec.width as usize, spec.height as usize);
    let strength = |column: u32, row: u32| {
        let cell = (height - 1 - row as usize) * width + column as usize;
        match layer {
            Layer::Semantic => strength_of_class(grid.class[cell]),
            Layer::Planning => strength_of_pixel(layer, pixel_of(grid.planning[cell])),
            Layer::Keepout => strength_of_pixel(layer, pixel_of(grid.keepout[cell])),
            Layer::Localization => strength_of_pixel(layer, pixel_of(grid.localization[cell])),
        }
    };
    let offset = tiles.offset(&extent, spec.resolution_m());
    LayerCells { layer, extent, offset, strength: &strength }.tile(tiles, address.place)
}

impl LiveSite for SharedSite {
    fn feed(&self) -> watch::Receiver<Feed> {
        self.feed.subscribe()
    }

    fn slam_picture(&self, name: &ContentName) -> Option<Bytes> {
        let picture = locked(&self.slam_picture);
        picture.as_ref().filter(|(known, _)| known == name).map(|(_, picture)| Arc::clone(picture))
    }

    fn fleet(&self) -> Result<Option<Bytes>, Failure> {
        Ok(site_answers::fleet_document(&self.config)?.map(|document| json(&document)))
    }

    fn set_date(&self, at: &str) -> Result<(), ControlError> {
        self.allowed()?;
        control::set_plan_time(&self.config, at).map_err(ControlError::Failed)
    }

    fn confirm(&self, global_id: &str) -> Result<(), ControlError> {
        self.allowed()?;
        control::confirm_absent(&self.config, global_id).map_err(ControlError::Failed)
    }
}

impl SharedSite {
    fn allowed(&self) -> Result<(), ControlError> {
        if self.config.web.allow_control { Ok(()) } else { Err(ControlError::NotAllowed) }
    }
}
