//! The kinds of archives as types: the payload of a topic, the result of a writer.

use crate::archive::{ArchiveError, ArchiveKind};

/// A kind of archive.
pub trait Payload: 'static {
    /// Its number in the preamble.
    const KIND: ArchiveKind;

    /// How its bytes are read in place.
    type View<'a>: Copy;

    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole archive of this kind.
    fn open(bytes: &[u8]) -> Result<Self::View<'_>, ArchiveError>;

    /// Views an archive whose hash and records were validated before; sections are looked up, nothing else is.
    ///
    /// # Errors
    /// Bytes that are no archive of this kind.
    fn view(bytes: &[u8]) -> Result<Self::View<'_>, ArchiveError>;
}

/// `site`: geometry, spaces, doors, schedule.
#[derive(Debug)]
pub enum Site {}
/// `schedule-state`: states of elements and spaces at a plan time.
#[derive(Debug)]
pub enum ScheduleState {}
/// `grid`: layers of one map storey.
#[derive(Debug)]
pub enum Grid {}
/// `grids`: the index of a set of grids.
#[derive(Debug)]
pub enum Grids {}
/// `mission-plan`: waypoints, tour, route graph.
#[derive(Debug)]
pub enum MissionPlan {}
/// `slam-map`: a robot's occupancy map.
#[derive(Debug)]
pub enum SlamMap {}
/// `alignment`: the pose of a robot's map.
#[derive(Debug)]
pub enum Alignment {}
/// `deviations`: deviations between model and SLAM map.
#[derive(Debug)]
pub enum Deviations {}
/// `tasks`: tasks of schedule files, linked to a site.
#[derive(Debug)]
pub enum Tasks {}
/// `alignment-evidence`: what looks at a growing SLAM map have said.
#[derive(Debug)]
pub enum AlignmentEvidence {}
