//! The command line; its help is the manual.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Building models (IFC) into everything a robot needs to move before it has ever seen the place.
#[derive(Debug, Parser)]
#[command(name = "groundplan", version, propagate_version = true, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn building models into maps per storey, semantic JSON and waypoints
    #[command(after_help = AFTER_CONVERT)]
    Convert(ConvertArgs),
}

const AFTER_CONVERT: &str = "\
Files in OUT (written whole or not at all, the same bytes for the same input):
  manifest.json                 storeys, frames, robot, sources, sha256 of every file
  report.json                   what was counted, assumed, replaced by a box, left out; doors, regions
  semantic.json                 every element and space by GlobalId, with its footprints
  waypoints.{json,csv,geojson}  the centre of every space that can be entered
  site-frame.json               the map frame; a later run into the same OUT keeps it
  storeys/<index>-<name>/
    planning.{pgm,yaml}         for global planning: 0 occupied, 254 free, 205 unknown or no floor
    localization.{pgm,yaml}     what a lidar sees of finished structure
    keepout.{pgm,yaml}          Nav2 keep-out mask: drop-offs and their margins
    waypoints.yaml              this storey's waypoints for Nav2
    semantic.png  classes.png   for people; class ids for programs

Examples:
  groundplan convert house.ifc -o maps
  groundplan convert architecture.ifc structure.ifczip -o maps --robot config/robots/legged.toml
  groundplan convert house.ifc -o maps --resolution 0.1 --json | jq .storeys

Exit codes: 0 done, 1 failed, 2 bad usage or configuration. RUST_LOG=debug shows the steps.";

/// Arguments of `convert`.
#[derive(Debug, Clone, Args)]
pub struct ConvertArgs {
    /// IFC files of one site: .ifc or .ifczip, IFC2X3, IFC4 or IFC4X3
    #[arg(required = true, value_name = "MODEL.ifc")]
    pub models: Vec<PathBuf>,

    /// Output folder; replaced as a whole if it holds earlier output
    #[arg(short, long, value_name = "OUT")]
    pub out: PathBuf,

    /// Robot profile [default: 1.2 m high, 0.3 m radius, see config/robots/default.toml]
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,

    /// Metres per cell, a whole number of tenths of a millimetre from 0.001 to 1
    #[arg(long, value_name = "METRES", default_value_t = 0.05)]
    pub resolution: f64,

    /// Write vertices, faces and edges of every element into semantic.json
    #[arg(long)]
    pub with_geometry: bool,

    /// Use the map frame of this site-frame.json [default: that of OUT, if there is one]
    #[arg(long, value_name = "FILE", conflicts_with = "new_frame")]
    pub frame: Option<PathBuf>,

    /// Fix the map frame anew and raise its epoch: maps and waypoints of earlier runs no longer fit
    #[arg(long)]
    pub new_frame: bool,

    /// Where a file lies in the first file's world: metres and radians; may be repeated
    #[arg(long, value_name = "FILE=X,Y,Z,YAW")]
    pub place: Vec<String>,

    /// Where two files give one GlobalId different bodies, take the last
    #[arg(long)]
    pub prefer_last: bool,

    /// Write maps that are blank, or storeys with spaces and no obstacle
    #[arg(long)]
    pub allow_empty: bool,

    /// Threads to work with; the result does not depend on them [default: all cores]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub threads: usize,

    /// Print one JSON summary on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}
