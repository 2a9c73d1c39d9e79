//! `--storey`, `--hint`, `--hint-radius`: a guess of the pose of a robot's map.

use alignment::Hint;
use daemon::PoseHint;

/// Where a robot's map may lie in the model's.
#[derive(Debug, Clone, clap::Args)]
pub struct PoseHintArgs {
    /// Index of the storey [default: all are tried]
    #[arg(long, value_name = "INDEX")]
    pub(crate) storey: Option<u32>,

    /// Guess of map_from_slam: metres, metres, degrees
    #[arg(long, num_args = 3, value_names = ["X", "Y", "YAW"], allow_negative_numbers = true)]
    hint: Option<Vec<f64>>,

    /// How far off the guess may be: metres, degrees
    #[arg(long, num_args = 2, value_names = ["M", "DEG"], default_values_t = [2.0, 20.0], requires = "hint")]
    hint_radius: Vec<f64>,
}

impl PoseHintArgs {
    /// The guess, as a daemon is given it.
    pub(crate) fn pose_hint(&self) -> Option<PoseHint> {
        let &[x_m, y_m, yaw_deg] = self.hint.as_deref()?.first_chunk::<3>()?;
        let &[radius_m, radius_deg] = self.hint_radius.first_chunk::<2>()?;
        Some(PoseHint { x_m, y_m, yaw_deg, radius_m, radius_deg })
    }

    /// The guess, as the search takes it.
    pub(crate) fn hint(&self) -> Option<Hint> {
        let PoseHint { x_m, y_m, yaw_deg, radius_m, radius_deg } = self.pose_hint()?;
        Some(Hint::in_degrees([x_m, y_m, yaw_deg], radius_m, radius_deg))
    }
}
