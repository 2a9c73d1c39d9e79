//! The files of the demo, which are in the program: it runs wherever the program is.

use crate::failure::Failure;
use std::path::Path;

/// Model, schedule of the planner, reported progress, map of a robot with its image: as in `config/demo`, and beside the manual in
/// `share/groundplan/demo`.
const FILES: [(&str, &[u8]); 5] = [
    ("demo.ifc", include_bytes!("../../../../../config/demo/demo.ifc")),
    ("demo-schedule.xer", include_bytes!("../../../../../config/demo/demo-schedule.xer")),
    ("progress.csv", include_bytes!("../../../../../config/demo/progress.csv")),
    ("robot-map.yaml", include_bytes!("../../../../../config/demo/robot-map.yaml")),
    ("robot-map.png", include_bytes!("../../../../../config/demo/robot-map.png")),
];

/// Writes them into a folder, with the configuration of a site around them.
///
/// # Errors
/// The file system refuses.
pub(super) fn write(folder: &Path, plan_time: &str, prefix: &str, bus: &Path) -> Result<(), Failure> {
    // No other user is served, and a port that is free is taken.
    let site = format!(
        "state = \"state\"\nmodels = [\"demo.ifc\"]\n\
         [schedule]\nfiles = [\"demo-schedule.xer\"]\nplan_time = {plan_time:?}\n\
         [web]\nlisten = \"127.0.0.1:0\"\n\
         [relay]\nview_group = \"\"\ncontrol_group = \"\"\n\
         [bus]\nprefix = {prefix:?}\nroot = {bus:?}\n",
    );
    for (name, bytes) in FILES.into_iter().chain([("site.toml", site.as_bytes())]) {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| Failure::work(format!("{}: {e}", path.display())))?;
    }
    Ok(())
}
