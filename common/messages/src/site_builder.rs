//! Meshes of a `site` archive to be.

use crate::site::SiteBuilder;
use geometry::MeshView;

impl SiteBuilder {
    /// The meshes of parts that were added.
    pub fn meshes(&self, first_part: u32, n_parts: u32) -> impl Iterator<Item = MeshView<'_>> + Clone {
        self.parts[first_part as usize..][..n_parts as usize].iter().map(|part| MeshView {
            vertices: &self.vertices[part.first_vertex as usize..][..part.n_vertices as usize],
            triangles: &self.triangles[part.first_triangle as usize..][..part.n_triangles as usize],
            closed: part.closed == 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule_records::*;
    use crate::site_records::*;
    use crate::{ArchiveError, NONE, Site, Text};
    use bytemuck::Zeroable;

    fn element(builder: &mut SiteBuilder) -> ElementRecord {
        ElementRecord {
            global_id: builder.texts.add("2O2Fr$t4X7Zf8NOew3FLOH"),
            class: grid::Class::Wall.into(),
            whole: NONE,
            storey: NONE,
            space: NONE,
            door: NONE,
            stair: NONE,
            ..bytemuck::Zeroable::zeroed()
        }
    }

    #[test]
    fn an_element_keeps_its_text_and_mesh() {
        let mut builder = SiteBuilder::default();
        builder.vertices.extend([[0, 0, 0], [1, 0, 0], [0, 1, 0]]);
        builder.triangles.push([0, 1, 2]);
        builder.parts.push(PartRecord { n_vertices: 3, n_triangles: 1, ..bytemuck::Zeroable::zeroed() });
        let record = ElementRecord { n_parts: 1, ..element(&mut builder) };
        builder.elements.push(record);
        let buffer = builder.finish();
        let site = Site::open(buffer.bytes()).unwrap();
        assert_eq!(site.text(site.elements[0].global_id), "2O2Fr$t4X7Zf8NOew3FLOH");
        assert_eq!(site.element_meshes(&site.elements[0]).next().unwrap().corners().count(), 1);
    }

    #[test]
    fn records_that_point_outside_are_refused() {
        let refused = |change: fn(&mut SiteBuilder)| {
            let mut builder = SiteBuilder::default();
            let record = element(&mut builder);
            builder.elements.push(record);
            change(&mut builder);
            matches!(Site::open(builder.finish().bytes()), Err(ArchiveError::Index { .. }))
        };
        assert!(!refused(|_| {}));
        assert!(refused(|b| b.elements[0].n_parts = 1));
        assert!(refused(|b| b.elements[0].first_part = u32::MAX));
        assert!(refused(|b| b.elements[0].whole = 1));
        assert!(refused(|b| b.elements[0].space = 0));
        assert!(refused(|b| b.elements[0].supertypes.count = 1));
        assert!(refused(|b| b.elements[0].supertypes = b.texts.add_list(["IfcWall"; 33])));
        assert!(refused(|b| b.contacts.push(BoundaryRecord { space: 0, element: 0 })));
        assert!(refused(|b| b.elements[0].name = Text { offset: 5, length: 100 }));
        assert!(!refused(|b| b.triangles.push([0, 0, 0])), "unused triangles are harmless");
        assert!(refused(|b| {
            b.triangles.push([0, 0, 0]);
            b.parts.push(PartRecord { n_triangles: 1, ..bytemuck::Zeroable::zeroed() });
        }));
    }

    #[test]
    fn an_element_of_a_file_that_the_site_does_not_have_is_refused() {
        let opened = |n_files: usize, source: u32| {
            let mut builder = SiteBuilder::default();
            let record = ElementRecord { source, ..element(&mut builder) };
            builder.elements.push(record);
            builder.sources = vec![bytemuck::Zeroable::zeroed(); n_files];
            Site::open(builder.finish().bytes()).map(|_| ())
        };
        assert_eq!((opened(0, 0), opened(2, 1)), (Ok(()), Ok(())));
        for (n_files, source) in [(0, 1), (2, 2), (2, NONE)] {
            assert_eq!(opened(n_files, source), Err(ArchiveError::Index { what: "an element" }));
        }
    }

    #[test]
    fn schedules_that_point_outside_are_refused() {
        let refused = |change: fn(&mut SiteBuilder)| {
            let mut builder = SiteBuilder::default();
            let task = TaskRecord { parent: NONE, control: NONE, calendar: NONE, ..TaskRecord::zeroed() };
            builder.schedule.tasks.extend([task, task]);
            builder.schedule.sequences.push(SequenceRecord {
                successor: 1,
                kind: SequenceKind::FinishStart.into(),
                lag_calendar: NONE,
                ..SequenceRecord::zeroed()
            });
            change(&mut builder);
            matches!(Site::open(builder.finish().bytes()), Err(ArchiveError::Index { .. }))
        };
        assert!(!refused(|_| {}));
        assert!(refused(|b| b.schedule.tasks[0].parent = 2));
        assert!(refused(|b| b.schedule.tasks[0].calendar = 0));
        assert!(refused(|b| b.schedule.tasks[1].actual_finish = Text { offset: 1, length: 1 }.into()));
        assert!(refused(|b| b.schedule.sequences[0].predecessor = 2));
        assert!(refused(|b| b.schedule.sequences[0].lag_calendar = 0));
        assert!(refused(|b| b.schedule.task_links.push(TaskLinkRecord {
            task: 0,
            kind: LinkKind::Element.into(),
            target: 0,
            flags: 0
        })));
        assert!(refused(|b| b
            .schedule
            .calendars
            .push(CalendarRecord { n_working: u32::MAX, ..CalendarRecord::zeroed() })));
        assert!(refused(|b| b.schedule.work_times.push(WorkTimeRecord { n_periods: 1, ..WorkTimeRecord::zeroed() })));
    }
}
