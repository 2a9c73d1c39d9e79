//! The `deviations` archive: observations of a storey's elements, obstacles, map residuals.

use crate::archive::ArchiveError;
use crate::declaration::declare_archive;
use crate::deviation_records::*;
use crate::site::MAX_COORDINATE_TENTHS;
use crate::site_records::RingRecord;
use crate::tag::{Tag, check_tags};
use grid::MAX_CELLS;

declare_archive! {
    /// Deviations between a site at a plan time and a SLAM map, read in place.
    view Deviations;
    /// Records of a `deviations` archive to be.
    owned DeviationsBuilder;
    sections {
        /// What was compared, and how.
        pub head: one(1, DeviationsHead),
        /// One record per element of the storey, in the order of the site.
        pub elements: many(2, ElementDeviationRecord),
        /// What stands there and is not in the model, from large to small.
        pub obstacles: many(3, ObstacleRecord),
        /// Rings of the obstacles' polygons.
        pub rings: many(4, RingRecord),
        /// Points of the rings in `map`, tenths of a millimetre.
        pub points: many(5, [i32; 2]),
        /// How the SLAM map is bent, by place.
        pub residuals: many(6, ResidualRecord),
        /// The SLAM map in the axes of `map`: row-major from the lower left; [`DeviationsHead::spec`] says where.
        pub seen: many(7, Tag<SlamCell>),
        /// Stretches of elements that are not there, in the order of the elements.
        pub absent_parts: many(8, AbsentPartRecord),
    }
}

impl<'a> Deviations<'a> {
    fn check(&self) -> Result<(), ArchiveError> {
        self.check_tags()?;
        self.check_head()?;
        self.check_elements()?;
        self.check_absent_parts()?;
        self.check_obstacles()
    }

    /// The rings of an obstacle's polygon.
    pub fn rings_of(&self, obstacle: &ObstacleRecord) -> impl Iterator<Item = &'a [[i32; 2]]> + use<'a> {
        let points = self.points;
        let rings = &self.rings[obstacle.first_ring as usize..][..obstacle.n_rings as usize];
        rings.iter().map(move |r| &points[r.first_point as usize..][..r.n_points as usize])
    }

    /// Stretches of an element that are not there.
    pub fn absent_parts_of(&self, of: &ElementDeviationRecord) -> impl Iterator<Item = &'a AbsentPartRecord> + use<'a> {
        let first = self.absent_parts.partition_point(|p| p.element < of.element);
        let element = of.element;
        self.absent_parts[first..].iter().take_while(move |p| p.element == element)
    }

    fn check_tags(&self) -> Result<(), ArchiveError> {
        check_tags(self.seen.iter().copied(), "state of a cell")?;
        check_tags(self.elements.iter().map(|e| e.observation), "observation")?;
        check_tags(self.elements.iter().map(|e| e.verdict), "judgement")?;
        check_tags(self.absent_parts.iter().map(|p| p.verdict), "judgement")?;
        check_tags(self.elements.iter().map(|e| e.reason), "reason for not seeing")?;
        check_tags(self.elements.iter().map(|e| e.planned), "state of an element")
    }

    fn check_head(&self) -> Result<(), ArchiveError> {
        let head = self.head;
        let numbers = head.map_from_slam.iter().chain(&head.pose_deviation);
        let lengths = [head.lidar_z_m, head.slam_cell_m, head.residual_rms_m];
        let n_cells = u64::from(head.width) * u64::from(head.height);
        // Pictures are made of the cells, and places of the cells' numbers.
        let is_near = |first: i32, n: u32| {
            let end = i64::from(first) + i64::from(n);
            i64::from(first).abs().max(end.abs()).saturating_mul(i64::from(head.cell_tenths))
                <= 2 * i64::from(MAX_COORDINATE_TENTHS)
        };
        let whole = numbers.chain(&lengths).all(|n| is_metres(*n))
            && head.cell_tenths > 0
            && n_cells <= MAX_CELLS
            && n_cells == self.seen.len() as u64
            && is_near(head.first_cell[0], head.width)
            && is_near(head.first_cell[1], head.height);
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "the map that was seen" }) }
    }

    fn check_elements(&self) -> Result<(), ArchiveError> {
        let whole = self.elements.iter().all(|e| {
            let numbers = [e.offset_m, e.deviation_m, e.sample_m];
            let counts = e.n_visible <= e.n_samples && e.n_confirmed <= e.n_visible && e.n_contradicted <= e.n_visible;
            counts && numbers.iter().chain(&e.displacement_m).chain(&e.residual_m).all(|n| is_metres(*n))
        });
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "an observation" }) }
    }

    fn check_absent_parts(&self) -> Result<(), ArchiveError> {
        let whole = self.absent_parts.iter().all(|p| {
            let numbers = p.ends_m.as_flattened().iter().chain([&p.from_m, &p.to_m, &p.deviation_m]);
            let is_listed = self.elements.binary_search_by_key(&p.element, |e| e.element).is_ok();
            is_listed && p.from_m <= p.to_m && numbers.copied().all(is_metres)
        });
        // Elements that share parts would walk them again and again.
        let is_sorted = self.absent_parts.is_sorted_by_key(|p| p.element)
            && (self.absent_parts.is_empty() || self.elements.is_sorted_by(|a, b| a.element < b.element));
        if whole && is_sorted { Ok(()) } else { Err(ArchiveError::Index { what: "an absent part" }) }
    }

    fn check_obstacles(&self) -> Result<(), ArchiveError> {
        let fits = |first: u32, n: u32, length: usize| u64::from(first) + u64::from(n) <= length as u64;
        let all = |counts: &mut dyn Iterator<Item = u32>| counts.map(u64::from).sum::<u64>();
        let whole = self.obstacles.iter().all(|o| {
            fits(o.first_ring, o.n_rings, self.rings.len())
                && [o.area_m2, o.length_m].iter().chain(&o.centroid_m).all(|n| is_metres(*n))
        }) && self.rings.iter().all(|r| fits(r.first_point, r.n_points, self.points.len()))
            // Obstacles that share rings, or rings that share points, would be walked again and again.
            && all(&mut self.obstacles.iter().map(|o| o.n_rings)) <= self.rings.len() as u64
            && all(&mut self.rings.iter().map(|r| r.n_points)) <= self.points.len() as u64
            && self.points.as_flattened().iter().all(|c| c.unsigned_abs() <= MAX_COORDINATE_TENTHS)
            && self.residuals.iter().all(|r| {
                r.at_m.iter().chain(&r.residual_m).chain([&r.deviation_m]).all(|n| is_metres(*n))
            });
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "an obstacle" }) }
    }
}

/// A number that files can be made from: finite, and within a site.
fn is_metres(number: f64) -> bool {
    number.abs() <= f64::from(MAX_COORDINATE_TENTHS)
}

impl DeviationsBuilder {
    /// Nothing but a head, and nothing seen.
    pub fn new(head: DeviationsHead) -> Self {
        let n_cells = head.width as usize * head.height as usize;
        Self { head, seen: vec![SlamCell::Unknown.into(); n_cells], ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NONE;
    use bytemuck::Zeroable;

    fn one_obstacle() -> DeviationsBuilder {
        let mut builder =
            DeviationsBuilder::new(DeviationsHead { cell_tenths: 500, width: 2, height: 1, ..Zeroable::zeroed() });
        builder.seen = vec![SlamCell::Free.into(), SlamCell::Occupied.into()];
        builder.points = vec![[0, 0], [500, 0], [0, 500]];
        builder.rings = vec![RingRecord { first_point: 0, n_points: 3 }];
        builder.obstacles = vec![ObstacleRecord { area_m2: 0.1, n_rings: 1, space: NONE, ..Zeroable::zeroed() }];
        builder
    }

    #[test]
    fn what_is_written_is_read() {
        let buffer = one_obstacle().finish();
        let read = Deviations::open(buffer.bytes()).unwrap();
        assert_eq!(read.rings_of(&read.obstacles[0]).collect::<Vec<_>>(), [[[0, 0], [500, 0], [0, 500]]]);
        assert_eq!(read.head.spec().n_cells(), read.seen.len());
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let refused = |change: fn(&mut DeviationsBuilder)| {
            let mut builder = one_obstacle();
            change(&mut builder);
            Deviations::open(builder.finish().bytes()).is_err()
        };
        assert!(refused(|b| b.seen.push(SlamCell::Free.into())));
        assert!(refused(|b| b.head.cell_tenths = 0));
        assert!(refused(|b| b.head.lidar_z_m = f64::NAN));
        assert!(refused(|b| b.obstacles[0].first_ring = 1));
        assert!(refused(|b| b.obstacles.push(b.obstacles[0])));
        assert!(refused(|b| b.points[0][0] = i32::MIN));
        assert!(refused(|b| b.elements.push(Zeroable::zeroed())), "no observation has the number 0");
    }
}
