//! Sets of later plan times: drawn with the stages from the archives in force, as the daemons will draw them when they are due.

use crate::pieces::{Piece, RobotPieces, SetPieces, SitePieces, StoreyPiece};
use daemon::{Failure, Robot, SiteConfig, WaypointOptions};
use messages::{ContentHash, Grid, Grids, MissionPlan, ScheduleState, Site, Tasks};
use raster::Rasterizer;
use schedule::Timeline;
use site_schedule::schedule_in_force;
use std::collections::BTreeMap;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner};

/// What draws for each robot; kept from one index to the next.
#[derive(Default)]
pub struct LaterSets {
    rasterizers: BTreeMap<String, Prepared>,
}

struct Prepared {
    site: ContentHash,
    robot: ContentHash,
    resolution_m: f64,
    rasterizer: Rasterizer,
    planner: MissionPlanner,
}

impl LaterSets {
    /// The sets of the next change instants after that of a set, at most so many.
    ///
    /// # Errors
    /// A schedule that is not the one in force, rules or options that cannot be read.
    pub fn draw(
        &mut self,
        config: &SiteConfig,
        site_pieces: &SitePieces,
        present: &SetPieces,
        ahead: usize,
    ) -> Result<Vec<SetPieces>, Failure> {
        let Some(now_s) = present.plan_time_s else { return Ok(Vec::new()) };
        let site_archive = Site::open(site_pieces.site.bytes.bytes())?;
        let tasks = site_pieces.tasks.as_ref().map(|tasks| Tasks::open(tasks.bytes.bytes())).transpose()?;
        let site = tasks.map_or(Ok(site_archive), |tasks| site_archive.with_tasks(&tasks))?;
        let state = ScheduleState::open(present.state.bytes.bytes())?;
        let timeline = schedule_in_force(config, &site, &state)?.timeline;
        let instants_s = timeline.update_instants_s();
        let later = &instants_s[instants_s.partition_point(|at_s| *at_s <= now_s)..];
        let mut sets = Vec::new();
        for &at_s in later.iter().take(ahead) {
            sets.push(self.draw_at(config, &site, &timeline, present, at_s)?);
        }
        Ok(sets)
    }

    fn draw_at(
        &mut self,
        config: &SiteConfig,
        site: &Site<'_>,
        timeline: &Timeline,
        present: &SetPieces,
        at_s: i64,
    ) -> Result<SetPieces, Failure> {
        let archive = timeline.schedule_state_at(Some(at_s)).finish();
        let state = ScheduleState::open(archive.bytes())?;
        let mut robots = BTreeMap::new();
        for (name, maps) in &present.robots {
            let own = config_of(config, name)?;
            robots.insert(name.clone(), self.draw_for(&own, name, site, &state, maps)?);
        }
        let valid_until_s = messages::plan_time(state.head.valid_until_s).map(|at| at.civil_seconds());
        let state = Piece::copy_of("schedule-state".to_owned(), state.content_hash(), archive.bytes());
        Ok(SetPieces { plan_time_s: Some(at_s), valid_until_s, state, robots })
    }

    fn draw_for(
        &mut self,
        config: &SiteConfig,
        name: &str,
        site: &Site<'_>,
        state: &ScheduleState<'_>,
        present: &RobotPieces,
    ) -> Result<RobotPieces, Failure> {
        let robot = Robot::of_index(&Grids::open(present.grids.bytes.bytes())?);
        let first = present.storeys.first().map(|storey| Grid::open(storey.grid.bytes.bytes())).transpose()?;
        let resolution_m = first.map_or(config.robot.resolution_m, |grid| grid.spec().resolution_m());
        let (site_hash, robot_hash) = (site.content_hash(), present.robot_hash);
        let is_for = |prepared: &Prepared| {
            (prepared.site, prepared.robot, prepared.resolution_m) == (site_hash, robot_hash, resolution_m)
        };
        if !self.rasterizers.get(name).is_some_and(is_for) {
            let rasterizer = Rasterizer::new(site, &robot.profile, resolution_m)?;
            let planner = MissionPlanner::default();
            let prepared = Prepared { site: site_hash, robot: robot_hash, resolution_m, rasterizer, planner };
            self.rasterizers.insert(name.to_owned(), prepared);
        }
        let Some(Prepared { rasterizer, planner, .. }) = self.rasterizers.get_mut(name) else {
            unreachable!("it was made")
        };
        rasterizer.draw(site, state);
        let archive = rasterizer.index(site, state, &robot.name, &robot.footprint_m, &robot.safety).finish();
        let index = Grids::open(archive.bytes())?;
        let topic = |topic: &str| Piece::topic_of(name, topic);
        let mut storeys = Vec::new();
        for (slot, drawn) in index.slots.iter().zip(rasterizer.drawn()) {
            let storey = &site.map_storeys[slot.map_storey as usize];
            storeys.push(StoreyPiece {
                map_storey: slot.map_storey,
                name: site.text(storey.name).to_owned(),
                global_id: site.text(storey.global_id).to_owned(),
                input_hash: drawn.input_hash,
                grid: Piece::copy_of(topic(&format!("grid/{}", slot.map_storey)), drawn.content_hash, drawn.archive),
            });
        }
        let grids: Vec<Grid<'_>> = rasterizer.drawn().map(|grid| Grid::open(grid.archive)).collect::<Result<_, _>>()?;
        let kept = WaypointOptions::in_force(config, MissionPlanOptions::parse)?;
        let options = kept.parse(MissionPlanOptions::parse)?.narrowed(&kept.spaces, kept.changed_since_s);
        let input = MissionPlanInput { site, schedule_state: state, index: &index, grids: &grids, options: &options };
        let plan = planner.plan(&input);
        let plan_hash = MissionPlan::open(plan.bytes())?.content_hash();
        Ok(RobotPieces {
            grids: Piece::copy_of(topic("grids"), index.content_hash(), archive.bytes()),
            mission_plan: Some(Piece::copy_of(topic("mission-plan"), plan_hash, plan.bytes())),
            robot_hash,
            storeys,
        })
    }
}

/// The configuration of a robot, by its name in an index.
///
/// # Errors
/// A robot that the configuration does not have any more.
pub(crate) fn config_of(config: &SiteConfig, robot: &str) -> Result<SiteConfig, Failure> {
    match robot.parse() {
        Ok(robot) if !config.robots.is_empty() => Ok(config.of_robot(Some(robot))?),
        _ => Ok(config.clone()),
    }
}
