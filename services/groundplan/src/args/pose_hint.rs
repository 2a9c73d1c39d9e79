//! `--storey`, `--hint`, `--start-room` and others: what is known of the pose of a robot's map.

use crate::failure::Failure;
use alignment::Hint;
use daemon::{KnownPlaces, PointInRoom, PoseHint};

/// Where a robot's map may lie in the model's.
#[derive(Debug, Clone, clap::Args)]
pub struct PoseHintArgs {
    /// Index of the storey that the robot is on [default: all are tried]
    #[arg(long, value_name = "INDEX")]
    pub(crate) storey: Option<u32>,

    /// Guess of map_from_slam: metres, metres, degrees
    #[arg(long, num_args = 3, value_names = ["X", "Y", "YAW"], allow_negative_numbers = true)]
    hint: Option<Vec<f64>>,

    /// How far off the guess may be: metres, degrees
    #[arg(long, num_args = 2, value_names = ["M", "DEG"], default_values_t = [2.0, 20.0], requires = "hint")]
    hint_radius: Vec<f64>,

    /// Room in which the robot's map began, by number, name or GlobalId: there x and y of the map are 0
    #[arg(long, value_name = "ROOM")]
    start_room: Option<String>,

    /// A point of the robot's map that lies in a room, as a door number or a code there told; may be repeated: metres, metres,
    /// number, name or GlobalId
    #[arg(long, num_args = 3, value_names = ["X", "Y", "ROOM"], allow_negative_numbers = true)]
    at: Vec<String>,

    /// Height of the floor under the robot in the model's map, in metres: storeys within 1.5 m of it
    #[arg(long, value_name = "Z", allow_negative_numbers = true)]
    elevation: Option<f64>,

    /// Stair, ramp or lift that the robot took last, by name or GlobalId; the robot's map shows where it ends
    #[arg(long, value_name = "NAME")]
    portal: Option<String>,
}

impl PoseHintArgs {
    /// The guess, as a daemon is given it.
    pub(crate) fn pose_hint(&self) -> Option<PoseHint> {
        let &[x_m, y_m, yaw_deg] = self.hint.as_deref()?.first_chunk::<3>()?;
        let &[radius_m, radius_deg] = self.hint_radius.first_chunk::<2>()?;
        Some(PoseHint { x_m, y_m, yaw_deg, radius_m, radius_deg })
    }

    /// What is known of where the robot is.
    ///
    /// # Errors
    /// A coordinate that is no number.
    pub(crate) fn known_places(&self) -> Result<KnownPlaces, Failure> {
        let number = |text: &String| match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(Failure::usage(format!("--at {text}: not a number of metres"))),
        };
        let mut rooms: Vec<PointInRoom> = self.start_room.clone().map(PointInRoom::start).into_iter().collect();
        for [x, y, room] in self.at.as_chunks::<3>().0 {
            rooms.push(PointInRoom { x_m: number(x)?, y_m: number(y)?, room: room.clone() });
        }
        Ok(KnownPlaces { rooms, elevation_m: self.elevation, portal: self.portal.clone() })
    }

    /// The guess, as the search takes it.
    pub(crate) fn hint(&self) -> Option<Hint> {
        let PoseHint { x_m, y_m, yaw_deg, radius_m, radius_deg } = self.pose_hint()?;
        Some(Hint::in_degrees([x_m, y_m, yaw_deg], radius_m, radius_deg))
    }
}
