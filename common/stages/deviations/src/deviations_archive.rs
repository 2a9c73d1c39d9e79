//! Writes the `deviations` archive.

use crate::deviation_verdict::deviation_verdict;
use crate::distortion::{Distortion, DistortionField};
use crate::evidence::{Evidence, is_observable};
use crate::input::DeviationInput;
use crate::obstacles::Obstacle;
use crate::partial_absence::AbsentPart;
use crate::sections::Sections;
use crate::slam_view::SlamView;
use crate::thresholds::SAMPLE_M;
use frames::TENTHS_PER_M;
use geometry::{Bounds, MultiPolygon};
use grid::GridSpec;
use messages::{
    AbsentPartRecord, ArchiveBuffer, DeviationsBuilder, DeviationsHead, ElementDeviationRecord, NONE, Observation,
    ObstacleRecord, ResidualRecord, RingRecord, SlamCell,
};
use occupancy::Cell;

/// Cells of the SLAM map in the axes of `map`; twice as large as often as the storey has more than so many of them.
const SEEN_CELL_M: f64 = 0.05;
const MAX_SEEN_CELLS: usize = 1 << 24;

/// What the comparison found.
pub(super) struct Findings<'a> {
    /// By cut.
    pub(super) evidence: &'a [Evidence],
    /// By cut: stretches of it that are not there.
    pub(super) parts: &'a [Vec<AbsentPart>],
    pub(super) obstacles: &'a [Obstacle],
    pub(super) n_outside: u32,
}

pub(super) fn archive(
    input: &DeviationInput<'_>,
    slam: &SlamView<'_>,
    sections: &Sections,
    distortions: &DistortionField,
    found: &Findings<'_>,
) -> ArchiveBuffer {
    let residuals: Vec<ResidualRecord> =
        distortions.all().into_iter().map(|(at_m, distortion)| residual(slam, at_m, &distortion)).collect();
    let mut builder = DeviationsBuilder::new(head(input, slam, &residuals, found.n_outside));
    let spec = builder.head.spec();
    for (index, seen) in builder.seen.iter_mut().enumerate() {
        let middle = spec.centre_of(spec.cell_of(index));
        let cell = match slam.at(middle.coordinates_m()) {
            Cell::Free => SlamCell::Free,
            Cell::Occupied => SlamCell::Occupied,
            Cell::Unknown => SlamCell::Unknown,
        };
        *seen = cell.into();
    }
    let elements =
        sections.cuts.iter().zip(found.evidence).map(|(cut, e)| record(input, cut.element, is_observable(cut.kind), e));
    builder.elements.extend(elements);
    for (cut, parts) in sections.cuts.iter().zip(found.parts) {
        builder.absent_parts.extend(parts.iter().map(|part| absent_part(input, cut.element, part)));
    }
    found.obstacles.iter().for_each(|o| add_obstacle(input, &mut builder, o));
    builder.residuals.extend(residuals);
    builder.finish()
}

fn head(
    input: &DeviationInput<'_>,
    slam: &SlamView<'_>,
    residuals: &[ResidualRecord],
    n_outside: u32,
) -> DeviationsHead {
    let squares = residuals.iter().map(|r| r.residual_m[0] * r.residual_m[0] + r.residual_m[1] * r.residual_m[1]);
    let storey = &input.site.map_storeys[input.map_storey];
    let spec = spec_of(storey.bounds_tenths);
    DeviationsHead {
        site_hash: input.site.content_hash(),
        schedule_state_hash: input.schedule_state.content_hash(),
        slam_map_hash: input.slam_map_hash,
        plan_time_s: input.schedule_state.head.plan_time_s,
        map_from_slam: input.slam_frame.map_from_slam().x_y_yaw(),
        pose_deviation: input.covariance.deviations(),
        lidar_z_m: frames::metres(storey.floor_z_tenths) + input.robot.lidar_height_m,
        slam_cell_m: slam.cell_m,
        residual_rms_m: (squares.sum::<f64>() / residuals.len().max(1) as f64).sqrt(),
        map_storey: input.map_storey as u32,
        n_outside,
        cell_tenths: spec.cell_tenths,
        first_cell: spec.first_cell,
        width: spec.width,
        height: spec.height,
        reserved: 0,
    }
}

/// How far the SLAM map is off from where its pose as a whole puts it.
fn residual(slam: &SlamView<'_>, at_m: [f64; 2], distortion: &Distortion) -> ResidualRecord {
    ResidualRecord {
        at_m,
        residual_m: slam.off_whole_m(at_m, distortion.by_m.into()),
        deviation_m: distortion.worst_m(),
        n_samples: distortion.n as u32,
        reserved: 0,
    }
}

/// The storey and a metre around it.
fn spec_of([x0, y0, x1, y1]: [i32; 4]) -> GridSpec {
    let bounds = Bounds { min: [x0, y0], max: [x1, y1] };
    let mut cell_m = SEEN_CELL_M;
    loop {
        match GridSpec::around(bounds, TENTHS_PER_M, cell_m) {
            Ok(spec) if spec.n_cells() <= MAX_SEEN_CELLS => return spec,
            _ if cell_m > 0.5 => {
                // A storey of kilometres: no picture, and the numbers are the same.
                return GridSpec { cell_tenths: TENTHS_PER_M, first_cell: [0; 2], width: 0, height: 0 };
            }
            _ => cell_m *= 2.0,
        }
    }
}

fn record(input: &DeviationInput<'_>, element: u32, is_observable: bool, e: &Evidence) -> ElementDeviationRecord {
    let planned = input.schedule_state.planned(element as usize);
    // What is not judged has no numbers: behind glass a robot sees other things.
    let is_known = is_observable && e.n_visible > 0;
    let if_known = |number: f64| if is_known { number } else { 0.0 };
    let count = |n: u32| if is_observable { n } else { 0 };
    let is_met = e.observation != Observation::Absent && e.n_confirmed + u32::from(e.displacement.is_displaced) > 0;
    ElementDeviationRecord {
        offset_m: if is_met { if_known(e.displacement.offset_m) } else { 0.0 },
        displacement_m: if is_met { e.displacement.by_m.map(if_known) } else { [0.0; 2] },
        deviation_m: if_known(e.deviation_m),
        residual_m: e.off_whole_m.map(if_known),
        sample_m: SAMPLE_M,
        element,
        observation: e.observation.into(),
        verdict: deviation_verdict(e.observation, planned).into(),
        reason: e.reason.into(),
        n_samples: e.n_samples,
        n_visible: count(e.n_visible),
        n_confirmed: count(e.n_confirmed),
        n_contradicted: count(e.n_contradicted),
        planned: planned.into(),
        reserved: [0; 7],
    }
}

fn absent_part(input: &DeviationInput<'_>, element: u32, part: &AbsentPart) -> AbsentPartRecord {
    let planned = input.schedule_state.planned(element as usize);
    AbsentPartRecord {
        from_m: part.from_m,
        to_m: part.to_m,
        ends_m: part.ends_m,
        deviation_m: part.deviation_m,
        element,
        verdict: deviation_verdict(Observation::Absent, planned).into(),
    }
}

fn add_obstacle(input: &DeviationInput<'_>, builder: &mut DeviationsBuilder, obstacle: &Obstacle) {
    let Some(centroid) = obstacle.area.centroid() else { return };
    let first_ring = builder.rings.len() as u32;
    for ring in obstacle.area.rings() {
        builder.rings.push(RingRecord { first_point: builder.points.len() as u32, n_points: ring.len() as u32 });
        builder.points.extend(ring);
    }
    builder.obstacles.push(ObstacleRecord {
        area_m2: obstacle.area.area_m2(),
        length_m: obstacle.length_m,
        centroid_m: centroid.map(|c| c / f64::from(TENTHS_PER_M)),
        first_ring,
        n_rings: builder.rings.len() as u32 - first_ring,
        space: space_at(input, centroid),
        reserved: 0,
    });
}

/// The smallest space of the storey around a place; `NONE` outside of all.
fn space_at(input: &DeviationInput<'_>, at_tenths: [f64; 2]) -> u32 {
    let site = input.site;
    let on_storey = site.spaces.iter().zip(0..).filter(|(s, _)| s.map_storey == input.map_storey as u32);
    let around = on_storey.filter(|(s, _)| {
        let floor: MultiPolygon = site.floor_polygon(s);
        !s.has(messages::space_flags::METADATA_ONLY) && floor.contains(at_tenths)
    });
    around.min_by(|a, b| a.0.area_m2.total_cmp(&b.0.area_m2)).map_or(NONE, |(_, index)| index)
}
