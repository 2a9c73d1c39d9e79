//! Triangles and inner bounds that a shell has, counted from its records before it is meshed.
//!
//! A face of n corners and k inner bounds is n + 2 k - 2 triangles, whatever it looks like.

use rustc_hash::FxHashMap;

use crate::crossing_cutters::FaceCount;
use crate::kernel::{File, Record};

/// Faces of one shell that are looked into; of a larger one the rest is taken to be as those.
const FACES_MAX: usize = 20_000;

/// Counts the faces of shells and face sets. Each is counted once.
pub(crate) struct FaceCounts<'f, 'a> {
    file: &'f File<'a>,
    known: FxHashMap<u32, FaceCount>,
}

impl<'f, 'a> FaceCounts<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self { file, known: FxHashMap::default() }
    }

    /// Of an IfcConnectedFaceSet or IfcPolygonalFaceSet; nothing of other records.
    pub(crate) fn of_shell(&mut self, id: u32) -> FaceCount {
        if let Some(known) = self.known.get(&id) {
            return *known;
        }
        let faces =
            self.file.record(id).map_or_else(Vec::new, |record| match record.keyword.to_ascii_uppercase().as_str() {
                "IFCCLOSEDSHELL" | "IFCOPENSHELL" | "IFCCONNECTEDFACESET" => record.at(0).references(),
                "IFCPOLYGONALFACESET" => record.at(2).references(),
                _ => Vec::new(),
            });
        let mut count = FaceCount::default();
        for face in faces.iter().take(FACES_MAX) {
            let FaceCount { triangles, ring_corners } = self.of_face(*face);
            count.triangles += triangles;
            count.ring_corners = count.ring_corners.max(ring_corners);
        }
        let n_looked_into = faces.len().clamp(1, FACES_MAX) as u64;
        count.triangles = count.triangles.saturating_mul(faces.len() as u64) / n_looked_into;
        self.known.insert(id, count);
        count
    }

    fn of_face(&self, face: u32) -> FaceCount {
        let Some(record) = self.file.record(face) else { return FaceCount::default() };
        let n = |record: &Record<'_>, at: usize| record.at(at).list().len() as u64;
        let (outer, ring_corners, n_rings) = match record.keyword.to_ascii_uppercase().as_str() {
            "IFCINDEXEDPOLYGONALFACE" => (n(&record, 0), 0, 0),
            "IFCINDEXEDPOLYGONALFACEWITHVOIDS" => {
                let rings = record.at(1).list();
                let corners = rings.iter().map(|ring| ring.list().len() as u64).sum();
                (n(&record, 0), corners, rings.len() as u64)
            }
            _ => {
                let mut bounds = record.at(0).references().into_iter();
                let outer = bounds.next().map_or(0, |bound| self.n_corners(bound));
                let rings: Vec<u64> = bounds.map(|bound| self.n_corners(bound)).collect();
                (outer, rings.iter().sum(), rings.len() as u64)
            }
        };
        FaceCount { triangles: (outer + ring_corners + 2 * n_rings).saturating_sub(2), ring_corners }
    }

    /// Corners of an IfcFaceBound; a loop of edges has as many as edges.
    fn n_corners(&self, bound: u32) -> u64 {
        let outline = self.file.record(bound).and_then(|bound| self.file.record(bound.at(0).reference()?));
        outline.map_or(0, |outline| outline.at(0).list().len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, with_file};

    fn check(records: &str, triangles: u64, ring_corners: u64) {
        let found = with_file(&file(&format!("{BASICS}{records}")), |file| FaceCounts::new(file).of_shell(1));
        assert_eq!(found, FaceCount { triangles, ring_corners }, "{records}");
    }

    #[test]
    fn inner_bounds_are_counted_with_the_corners() {
        let bounds = "#3=IFCFACEOUTERBOUND(#4,.T.);#4=IFCPOLYLOOP((#107,#107,#107,#107));
            #5=IFCFACEBOUND(#6,.T.);#6=IFCPOLYLOOP((#107,#107,#107));";
        check(&format!("#1=IFCCLOSEDSHELL((#2));#2=IFCFACE((#3));{bounds}"), 2, 0);
        // A square with two holes of three corners: 10 corners, 12 triangles.
        check(&format!("#1=IFCOPENSHELL((#2,#7));#2=IFCFACE((#3,#5,#5));#7=IFCFACE((#3));{bounds}"), 12 + 2, 6);
        let face_set = "#1=IFCPOLYGONALFACESET(#9,$,(#2,#3),$);#2=IFCINDEXEDPOLYGONALFACE((1,2,3,4,5));
            #3=IFCINDEXEDPOLYGONALFACEWITHVOIDS((1,2,3,4),((5,6,7),(8,9,10)));";
        check(face_set, 3 + 12, 6);
        check("#1=IFCEXTRUDEDAREASOLID(#111,#102,#112,3.);", 0, 0);
    }

    #[test]
    fn the_rest_of_a_large_shell_is_taken_to_be_as_its_beginning() {
        let n = 3 * FACES_MAX;
        let faces = vec!["#2"; n].join(",");
        let face = "#2=IFCFACE((#3));#3=IFCFACEOUTERBOUND(#4,.T.);#4=IFCPOLYLOOP((#107,#107,#107,#107));";
        check(&format!("#1=IFCCLOSEDSHELL(({faces}));{face}"), 2 * n as u64, 0);
    }
}
