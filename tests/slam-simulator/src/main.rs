//! `slam-pairs`: simulated SLAM maps with true poses, logs of scans to make such maps of, and floor plans to simulate them in.

use clap::{Args, Parser, Subcommand};
use slam_simulator::{
    Clutter, LogOptions, PairOptions, Reference, RunOptions, floor_plans, write_logs, write_pairs, write_runs,
};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Simulates what a robot maps in the buildings of model maps, as pairs of maps with their true poses.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    pairs: Option<PairArguments>,
}

#[derive(Subcommand)]
enum Command {
    /// Writes model maps of generated buildings: offices, homes, halls.
    Plans {
        /// Folder of the maps.
        out: PathBuf,
        /// Number of floor plans.
        #[arg(long, default_value_t = 12)]
        count: usize,
        /// The same seed gives the same files.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Storeys of each building, which have its outer walls in common; with more than one each building is a folder of its own.
        #[arg(long, default_value_t = 1)]
        storeys: usize,
    },
    /// Writes SLAM maps of buildings in which elements are removed, displaced or cut through.
    Changed(ChangedArguments),
    /// Writes scans and drifting odometry as logs that programs for SLAM read, with the true poses.
    Logs(LogArguments),
}

#[derive(Args)]
struct LogArguments {
    /// Folder of drives.jsonl, and for each drive of NAME.log, NAME-true.csv and NAME-reference.yaml.
    out: PathBuf,
    /// Folders that `groundplan convert` or `slam-pairs plans` wrote, or descriptions (YAML) of model maps.
    #[arg(required = true)]
    references: Vec<PathBuf>,
    /// Drives, spread evenly over the references.
    #[arg(long, default_value_t = 20)]
    count: usize,
    /// The same seed gives the same files.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How full of furniture the buildings are.
    #[arg(long, value_enum, default_value_t = Clutter::All)]
    clutter: Clutter,
    /// Length of the longest way, in metres; the robot comes to less of a larger building.
    #[arg(long, default_value_t = 150.0)]
    max_way: f64,
}

#[derive(Args)]
struct ChangedArguments {
    /// Folder of truth.jsonl and of the maps.
    out: PathBuf,
    /// Folders that `groundplan convert --with-geometry --resolution 0.025` wrote.
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Drives, spread evenly over the storeys.
    #[arg(long, default_value_t = 60)]
    count: usize,
    /// Share of the walls, columns and pieces of furniture that are not as planned.
    #[arg(long, default_value_t = 0.08)]
    changed: f64,
    /// The same seed gives the same files.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How full of furniture the buildings are.
    #[arg(long, value_enum, default_value_t = Clutter::All)]
    clutter: Clutter,
}

#[derive(Args)]
struct PairArguments {
    /// Folder of pairs.jsonl, truth.jsonl, and the maps in references and slam.
    out: PathBuf,
    /// Folders that `groundplan convert` or `slam-pairs plans` wrote, or descriptions (YAML) of model maps.
    #[arg(required = true)]
    references: Vec<PathBuf>,
    /// Pairs of maps of the same building, spread evenly over the references.
    #[arg(long, default_value_t = 60)]
    count: usize,
    /// More pairs, with the SLAM map of another building or of another storey.
    #[arg(long, default_value_t = 0)]
    wrong: usize,
    /// The same seed gives the same files.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How full of furniture the buildings are.
    #[arg(long, value_enum, default_value_t = Clutter::All)]
    clutter: Clutter,
    /// Storeys of a building with a larger share of their walls in common are not paired: they are the same to a robot.
    #[arg(long, default_value_t = 0.7)]
    storey_overlap: f64,
    /// Maps of each drive after equal parts of its way, each a pair of its own; 1 for the map of the whole way only.
    #[arg(long, default_value_t = 1)]
    looks: usize,
    /// Threads; 0 for as many as there are cores. The files do not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match (cli.command, cli.pairs) {
        (Some(Command::Plans { out, count, seed, storeys }), _) => plans(&out, count, seed, storeys),
        (Some(Command::Changed(arguments)), _) => changed(&arguments),
        (Some(Command::Logs(arguments)), _) => logs(&arguments),
        (None, Some(arguments)) => pairs(&arguments),
        (None, None) => return ExitCode::from(2),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("slam-pairs: {}", chain(error.as_ref()));
            ExitCode::FAILURE
        }
    }
}

fn plans(out: &std::path::Path, count: usize, seed: u64, storeys: usize) -> Result<(), Box<dyn Error>> {
    for (name, maps) in floor_plans::drawn_buildings(count, storeys, seed) {
        for (number, map) in maps.iter().enumerate() {
            let (folder, name) = match storeys {
                1 => (out.to_owned(), name.as_str()),
                _ => (out.join(&name).join("storeys").join(number.to_string()), "localization"),
            };
            std::fs::create_dir_all(&folder)?;
            slam_simulator::write_map(&folder, name, map)?;
        }
    }
    Ok(())
}

fn changed(arguments: &ChangedArguments) -> Result<(), Box<dyn Error>> {
    let ChangedArguments { count, changed: changed_share, seed, clutter, .. } = *arguments;
    let options = RunOptions { count, changed_share, seed, clutter };
    for name in write_runs(&arguments.out, &arguments.models, &options)? {
        eprintln!("left out: {name}: no floor to drive on, or no walls in sight");
    }
    Ok(())
}

fn pairs(arguments: &PairArguments) -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build_global()?;
    let references = references(&arguments.references)?;
    let PairArguments { count, wrong, seed, clutter, storey_overlap, looks, .. } = *arguments;
    let options = PairOptions { count, wrong, seed, clutter, max_storey_overlap: storey_overlap, looks };
    for name in write_pairs(&arguments.out, &references, &options)? {
        eprintln!("left out: {name}: no floor to drive on, or no walls in sight");
    }
    Ok(())
}

fn logs(arguments: &LogArguments) -> Result<(), Box<dyn Error>> {
    let references = references(&arguments.references)?;
    let LogArguments { count, seed, clutter, max_way, .. } = *arguments;
    let options = LogOptions { count, seed, clutter, max_way_m: max_way };
    for name in write_logs(&arguments.out, &references, &options)? {
        eprintln!("left out: {name}: no floor to drive on, or no walls in sight");
    }
    Ok(())
}

/// All model maps of these paths that can be simulated; the others are told.
fn references(paths: &[PathBuf]) -> Result<Vec<Reference>, Box<dyn Error>> {
    let mut references = Vec::new();
    for path in paths {
        for reference in Reference::read_all(path)? {
            match reference {
                Ok(reference) => references.push(reference),
                Err(error) => eprintln!("left out: {}", chain(&error)),
            }
        }
    }
    Ok(references)
}

/// An error with its causes.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}
