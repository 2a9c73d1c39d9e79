//! Building storeys and spatial containment.

use rustc_hash::FxHashMap;

use crate::Storey;
use crate::affine::origin;
use crate::kernel::File;
use crate::placement::Placements;
use crate::relations::Relations;
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// Finds the storey of any product.
pub(crate) struct Storeys<'r> {
    file: &'r File<'r>,
    /// By the ids that the file has.
    index: FxHashMap<u64, usize>,
    relations: &'r Relations,
}

impl<'r> Storeys<'r> {
    pub(crate) fn new(file: &'r File<'r>, storeys: &[Storey], relations: &'r Relations) -> Self {
        let index = storeys.iter().enumerate().map(|(i, storey)| (storey.id.step_id, i)).collect();
        Self { file, index, relations }
    }

    /// Through containment, else through its whole, else through the element whose opening it fills.
    pub(crate) fn of(&self, product: u32) -> Option<usize> {
        let r = self.relations;
        let host = |id| r.fills.get(&id).and_then(|opening| r.host.get(opening)).or_else(|| r.host.get(&id));
        let steps = |id| [r.container.get(&id), r.whole.get(&id), host(id)].into_iter().flatten().copied().collect();
        Relations::search(product, steps, |id| self.index.get(&self.file.written_id(id)).copied())
    }
}

/// All IfcBuildingStorey by GlobalId; lengths only where the unit is known.
pub(crate) fn storeys(
    file: &File<'_>,
    placements: Option<&mut Placements<'_, '_>>,
    unit_m: f64,
    report: &mut Report,
) -> Vec<Storey> {
    let mut placements = placements;
    let mut storeys = Vec::new();
    for record in file.records("IfcBuildingStorey", report) {
        let id = crate::products::named(file, &record);
        let placement = placements.as_mut().map_or(Ok(None), |placements| placements.of_product(&record));
        let placement = placement.unwrap_or_else(|why| {
            report.add(
                Severity::Warning,
                DiagnosticCode::PlacementUnusable,
                Some(id.clone()),
                format!("storey: {why}"),
            );
            None
        });
        let placement_z_m = placement.map(|p| origin(&p).z);
        let elevation_m = placements.is_some().then(|| file.attribute(&record, "Elevation").number()).flatten();
        storeys.push(Storey { id, placement_z_m, elevation_m: elevation_m.map(|z| z * unit_m) });
    }
    storeys
}

/// The container of the storeys: building, else site, else project; nameless if there is none.
pub(crate) fn container(file: &File<'_>, report: &mut Report) -> Named {
    let first = |entity: &str, report: &mut Report| {
        file.records(entity, report).first().map(|record| crate::products::named(file, record))
    };
    ["IfcBuilding", "IfcSite", "IfcProject"].into_iter().find_map(|entity| first(entity, report)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, read};

    /// Two storeys at 0 m and 3 m on a building that is raised by 10 m, and a space in the upper one.
    const STOREYS: &str = "
        #10=IFCBUILDINGSTOREY('lower',$,'EG',$,$,#20,$,$,.ELEMENT.,0.);#20=IFCLOCALPLACEMENT(#22,#102);
        #11=IFCBUILDINGSTOREY('upper',$,'OG',$,$,#21,$,$,.ELEMENT.,7.);#21=IFCLOCALPLACEMENT(#22,#23);
        #22=IFCLOCALPLACEMENT($,#24);#23=IFCAXIS2PLACEMENT3D(#25,$,$);#24=IFCAXIS2PLACEMENT3D(#26,$,$);
        #25=IFCCARTESIANPOINT((0.,0.,3.));#26=IFCCARTESIANPOINT((0.,0.,10.));
        #12=IFCSPACE('space',$,'1',$,$,#103,$,'Hall',.ELEMENT.,.INTERNAL.,$);#13=IFCRELAGGREGATES('a',$,$,$,#11,(#12));
    ";

    fn check(records: &str, expect: &[Option<usize>]) {
        let (model, _) = read(&file(&format!("{BASICS}{STOREYS}{records}"))).unwrap();
        let found: Vec<Option<usize>> = model.elements.iter().map(|e| e.storey).collect();
        assert_eq!(found, expect);
    }

    #[test]
    fn storeys_stand_at_their_placement_in_the_world() {
        let (model, _) = read(&file(&format!("{BASICS}{STOREYS}"))).unwrap();
        let heights: Vec<_> = model.storeys.iter().map(|s| (s.placement_z_m, s.elevation_m)).collect();
        assert_eq!(heights, [(Some(10.0), Some(0.0)), (Some(13.0), Some(7.0))]);
        assert_eq!((model.spaces[0].storey, model.spaces[0].long_name.as_str()), (Some(1), "Hall"));
    }

    #[test]
    fn parts_take_the_storey_of_their_whole() {
        check(
            "#1=IFCSTAIR('s',$,$,$,$,$,$,$,$);#2=IFCSTAIRFLIGHT('f',$,$,$,$,$,$,$,$,$,$,$,$);
             #3=IFCRELAGGREGATES('r',$,$,$,#1,(#2));#4=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#1),#11);",
            &[Some(1), Some(1)],
        );
    }

    #[test]
    fn elements_of_a_space_take_its_storey() {
        check(
            "#1=IFCFURNITURE('s',$,$,$,$,$,$,$,$);#4=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#1),#12);",
            &[Some(1)],
        );
    }

    #[test]
    fn fillings_take_the_storey_of_their_host_unless_they_have_their_own() {
        let filling = "#1=IFCWALL('w',$,$,$,$,#103,$,$,$);#2=IFCDOOR('d',$,$,$,$,#103,$,$,2.,1.,$,$,$);
            #3=IFCOPENINGELEMENT('o',$,$,$,$,#103,$,$,$);#4=IFCRELVOIDSELEMENT('v',$,$,$,#1,#3);
            #5=IFCRELFILLSELEMENT('f',$,$,$,#3,#2);#6=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#1),#11);";
        check(filling, &[Some(1), Some(1)]);
        let own = "#7=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#2),#10);";
        check(&format!("{filling}{own}"), &[Some(0), Some(1)]);
    }

    #[test]
    fn wholes_that_are_parts_of_themselves_have_no_storey() {
        check(
            "#1=IFCSTAIR('s',$,$,$,$,$,$,$,$);#2=IFCSTAIR('t',$,$,$,$,$,$,$,$);
             #3=IFCRELAGGREGATES('r',$,$,$,#1,(#2));#4=IFCRELAGGREGATES('q',$,$,$,#2,(#1));",
            &[None, None],
        );
    }
}
