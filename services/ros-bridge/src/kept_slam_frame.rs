//! The robot's frame that maps are moved into: kept while the robot's map lies where it did, so that maps do not change with each look.

use messages::SlamFrame;

/// Maps stay as they are while the robot's map is found to lie this near to where they have it, in metres: a cell.
const STAYS_M: f64 = 0.05;

/// The frame in use, with its number: another one has another.
#[derive(Debug, Default)]
pub(crate) struct KeptSlamFrame {
    number: u64,
    frame: Option<SlamFrame>,
}

impl KeptSlamFrame {
    /// Takes that of the newest alignment, which follows the robot's map as a whole and never the robot's place.
    pub(crate) fn take(&mut self, newest: Option<SlamFrame>) {
        let stays = match (&self.frame, &newest) {
            (Some(kept), Some(newest)) => !kept.differs_from(newest, STAYS_M),
            (None, None) => true,
            _ => false,
        };
        if !stays {
            (self.number, self.frame) = (self.number + 1, newest);
        }
    }

    /// The frame, if one is known.
    pub(crate) fn get(&self) -> Option<(u64, &SlamFrame)> {
        self.frame.as_ref().map(|frame| (self.number, frame))
    }

    /// Index of the map storey that it lies on, if one is known.
    pub(crate) fn map_storey(&self) -> Option<u32> {
        self.frame.as_ref().map(SlamFrame::map_storey)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::PoseRecord;

    fn frame(x_m: f64) -> Option<SlamFrame> {
        let pose = PoseRecord { map_from_slam: [x_m, 0.0, 0.0], map_storey: 2, ..PoseRecord::NONE };
        Some(SlamFrame::rigid(&pose))
    }

    #[test]
    fn a_frame_stays_until_the_map_lies_elsewhere_by_a_cell() {
        let mut kept = KeptSlamFrame::default();
        kept.take(frame(0.0));
        let first = kept.get().unwrap().0;
        kept.take(frame(0.04));
        assert_eq!(kept.get().unwrap().0, first);
        // The shifts of many looks add up: what counts is where the maps were put.
        kept.take(frame(0.08));
        let (second, moved) = kept.get().unwrap();
        assert!(second != first && moved.motion.apply([1.0, 0.0])[0] > 1.07);
    }

    #[test]
    fn what_is_not_known_any_more_is_given_up_and_comes_back_as_another() {
        let mut kept = KeptSlamFrame::default();
        kept.take(frame(0.0));
        let first = kept.get().unwrap().0;
        kept.take(None);
        assert!(kept.get().is_none() && kept.map_storey().is_none());
        kept.take(frame(0.0));
        assert!(kept.get().unwrap().0 != first && kept.map_storey() == Some(2));
    }
}
