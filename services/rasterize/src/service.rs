//! Rasterisation as a daemon: re-slices the storeys that a new phase changes.

use crate::{Rasterizer, StoreyFindings};
use bus::{Bus, GridSlot, Origin, Publisher, Sample, Topic};
use daemon::{Answer, Done, Epochs, Event, Failure, Request, Robot, Service, SiteConfig, Stages, StateFile};
use messages::{Grid, GridWriter, Grids, InputHashes, Phase, RobotProfile, Site, Stage};
use std::path::PathBuf;
use tracing::info;

/// Makes grids for one robot at one resolution.
pub struct RasterizeService {
    robot: Robot,
    resolution_m: f64,
    state: StateFile,
    epochs: Epochs,
    stages: Stages,
    bus: Option<Bus>,
    index: Option<Publisher>,
    grids: Vec<Publisher>,
    site: Option<(Sample, Rasterizer)>,
    phase: Option<Sample>,
    /// What was published of each storey: hash of what it was made from, what the index says of it.
    published: Vec<Option<(u64, StoreyFindings)>>,
    last: Answer,
}

impl RasterizeService {
    /// From the configuration and what survived: a robot that was set goes before the configured one.
    ///
    /// # Errors
    /// A robot profile, a resolution or state that cannot be used.
    pub fn new(config: &SiteConfig, stages: Stages) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "robot.json")?;
        let profile = state.load::<PathBuf>()?.or(config.robot.profile.clone());
        grid::GridSpec::cell_tenths_of(config.robot.resolution_m)?;
        Ok(Self {
            robot: profile.as_deref().map_or(Ok(Robot::default()), Robot::read)?,
            resolution_m: config.robot.resolution_m,
            state,
            epochs: Epochs::at(&config.state, "rasterize-epochs.json")?,
            stages,
            bus: None,
            index: None,
            grids: Vec::new(),
            site: None,
            phase: None,
            published: Vec::new(),
            last: Answer::default(),
        })
    }

    fn see_site(&mut self, sample: Sample) -> Result<Done, Failure> {
        self.stages.set(Stage::Reading);
        let rasterizer = Rasterizer::new(&Site::open(sample.bytes())?, &self.robot.profile, self.resolution_m)?;
        if rasterizer.n_storeys() > GridSlot::COUNT {
            let n = rasterizer.n_storeys();
            return Err(format!("the site has {n} map storeys, the bus has room for {}", GridSlot::COUNT).into());
        }
        self.published = vec![None; rasterizer.n_storeys()];
        self.site = Some((sample, rasterizer));
        self.draw()
    }

    fn set_robot(&mut self, profile: PathBuf) -> Result<Done, Failure> {
        let robot = Robot::read(&profile)?;
        self.state.save(&profile)?;
        self.robot = robot;
        match self.site.take() {
            Some((sample, _)) => self.see_site(sample),
            None => Ok(self.done()),
        }
    }

    /// Draws the storeys that differ from what is published, then the index that names them.
    fn draw(&mut self) -> Result<Done, Failure> {
        let (Some((sample, rasterizer)), Some(phase), Some(bus)) = (&self.site, &self.phase, &self.bus) else {
            return Ok(self.done());
        };
        let frame_epoch = sample.header().frame_epoch;
        let (site, phase) = (Site::open(sample.bytes())?, Phase::open(phase.bytes())?);
        if phase.head.site_hash != site.content_hash() {
            // One of them is older; the other will come.
            return Ok(Done::default());
        }
        self.stages.set(Stage::Writing);
        let robot_hash = xxhash_rust::xxh3::xxh3_64(bytemuck::bytes_of::<RobotProfile>(&self.robot.profile));
        let inputs = InputHashes {
            site: site.content_hash(),
            phase: phase.content_hash(),
            robot: robot_hash,
            ..InputHashes::default()
        };
        let mut n_drawn = 0;
        for storey in 0..rasterizer.n_storeys() {
            let own = rasterizer.input_hash(&phase, storey);
            if self.published[storey].as_ref().is_some_and(|(hash, _)| *hash == own) {
                continue;
            }
            let length = GridWriter::len_of(rasterizer.spec(storey).n_cells());
            if self.grids.len() == storey {
                let slot = GridSlot::new(storey).ok_or("there are more storeys than slots")?;
                self.grids.push(bus.publisher(Topic::Grid(slot), length)?);
            }
            let mut loan = self.grids[storey].loan(length)?;
            rasterizer.rasterize(&site, &phase, storey, GridWriter::new(loan.bytes_mut()));
            let findings = rasterizer.findings(&site, &phase, &Grid::open(loan.bytes_mut())?);
            let inputs = InputHashes { own, ..inputs };
            loan.publish(Origin { epoch: self.epochs.take()?, frame_epoch, inputs })?;
            self.published[storey] = Some((own, findings));
            n_drawn += 1;
        }
        let findings: Vec<StoreyFindings> = self.published.iter().flatten().map(|(_, f)| f.clone()).collect();
        let index = rasterizer.index_of(site.content_hash(), &phase, &self.robot.name, &findings);
        let epoch = self.epochs.take()?;
        let publisher = self.index.as_ref().ok_or("it is not attached to a bus")?;
        publisher.publish_copy(index.bytes(), Origin { epoch, frame_epoch, inputs })?;
        let content_hash = Grids::open(index.bytes())?.content_hash();
        info!(service = "rasterize", epoch, storeys = rasterizer.n_storeys(), drawn = n_drawn, "grids published");
        self.stages.set(Stage::Published);
        self.last = Answer {
            content_hash,
            epoch,
            plan_time_s: Some(phase.head.plan_time_s).filter(|_| phase.head.plan_time().is_some()),
        };
        Ok(self.done())
    }

    fn done(&self) -> Done {
        Done { answer: self.last.clone() }
    }
}

impl Service for RasterizeService {
    fn inputs(&self) -> &'static [Topic] {
        &[Topic::Site, Topic::Phase]
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Ends and samples of an earlier generation are of no use; the inputs come again.
        (self.index, self.site, self.phase) = (None, None, None);
        self.grids.clear();
        self.published.clear();
        self.index = Some(bus.publisher(Topic::Grids, 1 << 16)?);
        self.bus = Some(bus.clone());
        Ok(())
    }

    fn handle(&mut self, event: Event) -> Result<Done, Failure> {
        match event {
            Event::Input(Topic::Site, sample) => self.see_site(sample),
            Event::Input(_, sample) => {
                self.phase = Some(sample);
                self.draw()
            }
            Event::Request(Request::SetRobot { profile }) => self.set_robot(profile),
            Event::Request(_) => Err("rasterize makes grids for a robot and nothing else".into()),
            Event::Attached | Event::Tick => Ok(Done::default()),
        }
    }
}
