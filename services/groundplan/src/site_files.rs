//! IFC files into the site.

use crate::cli::ModelArgs;
use crate::failure::Failure;
use crate::progress::ProgressLine;
use ingest::{IngestOptions, Place, SiteFrame, SourceFile};
use messages::{ArchiveBuffer, nearest_names_hint};
use std::path::PathBuf;

/// A thread pool with as many threads as were asked for.
///
/// # Errors
/// The system has no threads to give.
pub(crate) fn pool(arguments: &ModelArgs) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(usize::from(arguments.threads)).build().map_err(Failure::work)
}

/// Reads the models as one site. `frame` is that of an earlier run, `frame_epoch` that of a frame fixed anew.
///
/// # Errors
/// Bad places, files that cannot be read or do not belong together.
pub(crate) fn site_of(
    arguments: &ModelArgs,
    frame: Option<SiteFrame>,
    frame_epoch: u32,
    progress: &ProgressLine,
) -> Result<ArchiveBuffer, Failure> {
    let places = places(arguments)?;
    let options = IngestOptions {
        frame,
        frame_epoch,
        places: &places,
        prefer_last: arguments.prefer_last,
        allow_boxes: arguments.allow_boxes,
        progress: &|step| progress.reader(step),
    };
    ingest::ingest(&read_models(arguments)?, &options).map_err(Failure::work)
}

fn read_models(arguments: &ModelArgs) -> Result<Vec<SourceFile>, Failure> {
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

/// `--place FILE=X,Y,Z,YAW`, by the index of the file.
fn places(arguments: &ModelArgs) -> Result<Vec<Option<Place>>, Failure> {
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
        let index = index.ok_or_else(|| {
            let names = arguments.models.iter().filter_map(|p| p.file_name()?.to_str());
            Failure::usage(format!("--place: {file} is none of the models{}", nearest_names_hint(file, names)))
        })?;
        places[index] = Some(Place { translation_m: [x, y, z], yaw_rad });
    }
    Ok(places)
}
