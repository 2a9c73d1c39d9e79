//! A stage as a library: IFC file in, planning map of the first map storey out, everything built.
//!
//! ```text
//! cargo run --example planning_map -- config/demo/demo.ifc planning.pgm
//! ```
//!
//! The pixels are those of `planning.pgm` of `groundplan convert`: 0 occupied, 254 free, 205 unknown.

use ingest::{IngestOptions, SourceFile};
use messages::{Grid, RobotProfile, ScheduleState, ScheduleStateBuilder, Site};
use raster::Rasterizer;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [model, image] = &paths[..] else { return Err("usage: planning_map MODEL.ifc OUT.pgm".into()) };

    // IFC bytes to the site archive.
    let file = SourceFile { path: model.clone(), bytes: std::fs::read(model)? };
    let options = IngestOptions::default();
    let site = ingest::ingest(&[file], &options)?;
    let site = Site::open(site.bytes())?;

    // The schedule state in which every element stands; `schedule::evaluate` gives that of a date.
    let state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish();
    let state = ScheduleState::open(state.bytes())?;

    // One grid archive per map storey.
    let mut rasterizer = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.05)?;
    rasterizer.draw(&site, &state);
    let first = rasterizer.drawn().next().ok_or("the model has no storey that can be mapped")?;
    let grid = Grid::open(first.archive)?;

    let pixels: Vec<u8> = grid.planning.iter().map(|&occupancy| grid::pixel_of(occupancy)).collect();
    std::fs::write(image, grid::encode_pgm(grid.head.width as usize, &pixels))?;
    Ok(())
}
