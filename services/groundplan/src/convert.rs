//! `groundplan convert`: the stages one after the other, archives in the heap.

use crate::cli::ConvertArgs;
use crate::failure::Failure;
use crate::progress::ProgressLine;
use crate::robot_file::Robot;
use crate::summary::Summary;
use export::{ExportInput, OutputFolder, SiteFrameFile};
use ifc_ingest::{IngestOptions, Place, SiteFrame, SourceFile};
use messages::{ArchiveBuffer, Grid, GridWriter, Grids, Phase, PhaseBuilder, Plan, Site};
use rasterize::Rasterizer;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tracing::debug;

/// Converts the models and writes the output folder.
///
/// # Errors
/// Bad arguments, models that cannot be read or do not belong together, blank maps, a folder that cannot be written.
pub fn convert(arguments: &ConvertArgs) -> Result<Summary, Failure> {
    let started = Instant::now();
    let robot = arguments.robot.as_deref().map_or(Ok(Robot::default()), Robot::read).map_err(Failure::usage)?;
    grid::GridSpec::cell_tenths_of(arguments.resolution).map_err(Failure::usage)?;
    let places = places(arguments)?;
    let folder = OutputFolder::at(&arguments.out).map_err(Failure::usage)?;
    let frame = frame(arguments)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build().map_err(Failure::work)?;
    let progress = ProgressLine::new();
    pool.install(|| {
        let options = IngestOptions {
            frame: frame.filter(|_| !arguments.new_frame),
            frame_epoch: frame.map_or(1, |f| f.frame_epoch.saturating_add(u32::from(arguments.new_frame))),
            places: &places,
            prefer_last: arguments.prefer_last,
            progress: &|step| progress.reader(step),
        };
        let site = ifc_ingest::ingest(&read_models(arguments)?, &options).map_err(Failure::work)?;
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        let (elements, spaces, map_storeys) = (site.elements.len(), site.spaces.len(), site.map_storeys.len());
        debug!(elements, spaces, map_storeys, elapsed_us = micros(started), "models read");
        map(arguments, &robot, &site, &folder, &progress, started)
    })
}

/// From the site to the files.
fn map(
    arguments: &ConvertArgs,
    robot: &Robot,
    site: &Site<'_>,
    folder: &OutputFolder,
    progress: &ProgressLine,
    started: Instant,
) -> Result<Summary, Failure> {
    let phase = PhaseBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish();
    let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
    progress.stage("drawing");
    let rasterizer = Rasterizer::new(site, &robot.profile, arguments.resolution).map_err(Failure::work)?;
    let draw = |map_storey: usize| {
        let mut grid = ArchiveBuffer::zeroed(GridWriter::len_of(rasterizer.spec(map_storey).n_cells()));
        rasterizer.rasterize(site, &phase, map_storey, GridWriter::new(grid.bytes_mut()));
        grid
    };
    let grids: Vec<ArchiveBuffer> = (0..site.map_storeys.len()).into_par_iter().map(draw).collect();
    let grids: Vec<Grid<'_>> =
        grids.iter().map(|g| Grid::open(g.bytes())).collect::<Result<_, _>>().map_err(Failure::work)?;
    if !arguments.allow_empty {
        rasterize::check_not_blank(site, &grids).map_err(Failure::work)?;
    }
    debug!(elapsed_us = micros(started), "maps drawn");
    let index = rasterizer.index(site, &phase, &robot.name, &grids);
    let index = Grids::open(index.bytes()).map_err(Failure::work)?;
    let plan = waypoint_gen::plan(site, &phase, &grids, &robot.profile);
    let plan = Plan::open(plan.bytes()).map_err(Failure::work)?;
    debug!(waypoints = plan.waypoints.len(), elapsed_us = micros(started), "waypoints planned");
    progress.stage("writing");
    let footprints: Vec<_> = (0..grids.len()).map(|k| rasterizer.footprints(k)).collect();
    let input = ExportInput {
        site,
        phase: &phase,
        index: &index,
        grids: &grids,
        plan: &plan,
        footprints: &footprints,
        resolution_m: arguments.resolution,
        robot_footprint_m: &robot.footprint_m,
        with_geometry: arguments.with_geometry,
    };
    let files = export::files(&input);
    folder.replace(&files).map_err(Failure::work)?;
    debug!(files = files.len(), elapsed_us = micros(started), "output swapped in");
    Ok(Summary::of(&input, &arguments.out, started.elapsed(), arguments.json))
}

fn micros(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_micros()).unwrap_or(u64::MAX)
}

fn read_models(arguments: &ConvertArgs) -> Result<Vec<SourceFile>, Failure> {
    let read = |path: &PathBuf| {
        if path.is_dir() {
            return Err(Failure::work(format!("{} is a folder: name the IFC files in it", path.display())));
        }
        let bytes =
            std::fs::read(path).map_err(|e| Failure::work(format!("{} cannot be read: {e}", path.display())))?;
        Ok(SourceFile { path: path.clone(), bytes })
    };
    arguments.models.iter().map(read).collect()
}

/// The site's frame: of `--frame`, else of an earlier run into the same folder.
fn frame(arguments: &ConvertArgs) -> Result<Option<SiteFrame>, Failure> {
    let earlier = arguments.out.join("site-frame.json");
    let path: &Path = match &arguments.frame {
        Some(path) => path,
        None if earlier.is_file() => &earlier,
        None => return Ok(None),
    };
    let unusable = |e: &dyn std::fmt::Display| Failure::usage(format!("frame file {}: {e}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| unusable(&e))?;
    let file = SiteFrameFile::parse(&bytes).map_err(|e| unusable(&format!("{:#}", Failure::usage(e))))?;
    Ok(Some(SiteFrame { map_from_world: file.motion(), frame_epoch: file.frame_epoch }))
}

/// `--place FILE=X,Y,Z,YAW`, by the index of the file.
fn places(arguments: &ConvertArgs) -> Result<Vec<Option<Place>>, Failure> {
    let mut places = vec![None; arguments.models.len()];
    for text in &arguments.place {
        let wrong = || Failure::usage(format!("--place {text:?}: write FILE=X,Y,Z,YAW in metres and radians"));
        let (file, numbers) = text.rsplit_once('=').ok_or_else(wrong)?;
        let numbers: Vec<f64> =
            numbers.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let &[x, y, z, yaw_rad] = numbers.as_slice() else { return Err(wrong()) };
        if numbers.iter().any(|n| !n.is_finite()) {
            return Err(wrong());
        }
        let named = |p: &PathBuf| p.as_os_str() == file || p.file_name().is_some_and(|n| n == file);
        let index = arguments.models.iter().position(named);
        let index = index.ok_or_else(|| Failure::usage(format!("--place: {file} is none of the models")))?;
        places[index] = Some(Place { translation_m: [x, y, z], yaw_rad });
    }
    Ok(places)
}
