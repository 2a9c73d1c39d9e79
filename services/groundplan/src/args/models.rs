//! Arguments of the IFC files of a site, and how they are joined.

use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use diagnostics::nearest_names_hint;
use ingest::{FilePlacement, IngestOptions, MAX_MODEL_BYTES, MeshCache, MeshPool, SiteFrame, SourceFile};
use input_files::read_regular_file;
use messages::ArchiveBuffer;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// Which models make the site.
#[derive(Debug, Clone, clap::Args)]
pub struct ModelArgs {
    /// IFC files of one site: .ifc or .ifczip, IFC2X3, IFC4 or IFC4X3
    #[arg(required = true, value_name = "MODEL.ifc")]
    models: Vec<PathBuf>,

    /// Where a file lies in the first file's world: metres and radians; may be repeated
    #[arg(long, value_name = "FILE=X,Y,Z,YAW")]
    place: Vec<String>,

    /// Where two files give one GlobalId different bodies, take the last
    #[arg(long)]
    prefer_last: bool,

    /// Take a file of whose bodies more than half cannot be meshed, with bounding boxes for them
    #[arg(long)]
    allow_boxes: bool,

    /// Threads to work with, at most 256; the result does not depend on them [default: all cores]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true, value_parser = clap::value_parser!(u16).range(..=256))]
    threads: u16,
}

/// The bytes of a model.
///
/// # Errors
/// A folder, or a file that cannot be read.
pub(crate) fn read_model(path: &Path) -> Result<Vec<u8>, Failure> {
    if path.is_dir() {
        return Err(Failure::work(format!("{} is a folder: name the IFC files in it", path.display())));
    }
    read_regular_file(path, MAX_MODEL_BYTES)
        .map_err(|e| Failure::work(format!("{} cannot be read: {e}", path.display())))
}

impl ModelArgs {
    /// These files where they lie, read on all cores.
    pub(crate) fn new(models: Vec<PathBuf>, allow_boxes: bool) -> Self {
        Self { models, place: Vec::new(), prefer_last: false, allow_boxes, threads: 0 }
    }

    /// The files.
    pub(crate) fn paths(&self) -> &[PathBuf] {
        &self.models
    }

    /// Number of threads that were asked for.
    pub(crate) fn n_threads(&self) -> usize {
        let all = || std::thread::available_parallelism().map_or(1, NonZero::get);
        if self.threads == 0 { all() } else { usize::from(self.threads) }
    }

    /// A thread pool with as many threads as were asked for.
    ///
    /// # Errors
    /// The system has no threads to give.
    pub(crate) fn pool(&self) -> Result<MeshPool, Failure> {
        MeshPool::new(self.n_threads()).map_err(Failure::work)
    }

    /// Reads the models as one site on the threads of the pool. `frame` is that of an earlier run, `frame_epoch` that of a frame fixed anew.
    ///
    /// # Errors
    /// Bad places, files that cannot be read or do not belong together.
    pub(crate) fn site(
        &self,
        pool: &MeshPool,
        frame: Option<SiteFrame>,
        frame_epoch: u32,
        progress: &ProgressLine,
    ) -> Result<ArchiveBuffer, Failure> {
        self.site_with(None, pool, frame, frame_epoch, progress)
    }

    /// The same with meshes of an earlier reading.
    ///
    /// # Errors
    /// As [`Self::site`].
    pub(crate) fn site_with(
        &self,
        cache: Option<&MeshCache>,
        pool: &MeshPool,
        frame: Option<SiteFrame>,
        frame_epoch: u32,
        progress: &ProgressLine,
    ) -> Result<ArchiveBuffer, Failure> {
        let places = self.places()?;
        let options = IngestOptions {
            frame,
            frame_of: None,
            frame_epoch,
            places: &places,
            prefer_last: self.prefer_last,
            allow_boxes: self.allow_boxes,
            isolation: Some(&daemon::in_mesh_process),
            cache,
            pool: Some(pool),
            progress: &|step| progress.reader(step),
        };
        ingest::ingest(&self.read()?, &options).map_err(Failure::work)
    }

    fn read(&self) -> Result<Vec<SourceFile>, Failure> {
        let read = |path: &PathBuf| Ok(SourceFile { path: path.clone(), bytes: read_model(path)? });
        self.models.iter().map(read).collect()
    }

    /// `--place FILE=X,Y,Z,YAW`, by the index of the file.
    fn places(&self) -> Result<Vec<Option<FilePlacement>>, Failure> {
        let mut places = vec![None; self.models.len()];
        for text in &self.place {
            let wrong = || Failure::usage(format!("--place {text:?}: write FILE=X,Y,Z,YAW in metres and radians"));
            let (file, numbers) = text.rsplit_once('=').ok_or_else(wrong)?;
            let numbers: Vec<f64> =
                numbers.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
            let &[x, y, z, yaw_rad] = numbers.as_slice() else { return Err(wrong()) };
            if numbers.iter().any(|n| !n.is_finite()) {
                return Err(wrong());
            }
            let named = |p: &PathBuf| p.as_os_str() == file || p.file_name().is_some_and(|n| n == file);
            let index = self.models.iter().position(named);
            let index = index.ok_or_else(|| {
                let names = self.models.iter().filter_map(|p| p.file_name()?.to_str());
                Failure::usage(format!("--place: {file} is none of the models{}", nearest_names_hint(file, names)))
            })?;
            places[index] = Some(FilePlacement { translation_m: [x, y, z], yaw_rad });
        }
        Ok(places)
    }
}
