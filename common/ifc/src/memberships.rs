//! Adds zones, groups, systems and classifications to the properties of elements and spaces.

use crate::classifications::{self, Classifications};
use crate::groups::{self, Groups};
use crate::kernel::File;
use crate::products::Products;
use crate::relations::Relations;
use crate::{Element, Property, Space};
use diagnostics::{DiagnosticCode, Report, Severity};

/// Property sets that say what an object belongs to; several of their properties can have one name.
///
/// `IfcZone`, `IfcSystem`, `IfcGroup` and `IfcSpatialZone` have Name and LongName of the groups that an object is in, directly
/// or through other groups. In `IfcClassification` a property is named as a classification system and has the code in it.
pub const MEMBERSHIP_SETS: [&str; 5] =
    [groups::SETS[0], groups::SETS[1], groups::SETS[2], groups::SETS[3], classifications::SET];

/// Groups and codes that an object may have.
const PER_OBJECT_MAX: usize = 256;

/// Groups and codes that the objects of a file may have together: groups in groups multiply.
const TOTAL_MAX: usize = 1_000_000;

/// Adds the groups and classifications of every element and space behind its other properties, in the order of their relations' GlobalIds.
pub(crate) fn add(
    file: &File<'_>,
    relations: &Relations,
    products: &Products<'_, '_>,
    elements: &mut [Element],
    spaces: &mut [Space],
    report: &mut Report,
) {
    let (groups, classifications) = (Groups::read(file, report), Classifications::read(file, report));
    let mut n_total = 0;
    let objects = products.elements.iter().chain(&products.spaces).map(|product| product.record.id);
    let elements = elements.iter_mut().map(|e| (&e.id, &mut e.properties));
    let named = elements.chain(spaces.iter_mut().map(|s| (&s.id, &mut s.properties)));
    for (object, (id, properties)) in objects.zip(named) {
        // One more than there may be shows that there are too many.
        let mut of_object = groups.of(object, relations, PER_OBJECT_MAX + 1);
        of_object.extend(classifications.of(object, relations, PER_OBJECT_MAX + 1));
        if of_object.len() > PER_OBJECT_MAX {
            let message =
                format!("belongs to more than {PER_OBJECT_MAX} groups and classifications; the others are left out");
            report.add(Severity::Error, DiagnosticCode::MembershipsTooMany, Some(id.clone()), message);
            of_object.truncate(PER_OBJECT_MAX);
        }
        n_total += of_object.len();
        if n_total > TOTAL_MAX {
            let message = format!(
                "the objects of the file belong to more than {TOTAL_MAX} groups and classifications; those of this and later objects \
                 are left out"
            );
            report.add(Severity::Error, DiagnosticCode::MembershipsTooMany, Some(id.clone()), message);
            return;
        }
        add_new(properties, of_object.into_iter().flatten());
    }
}

/// Names that two groups share, and codes that two references give, are there once.
fn add_new<'p>(properties: &mut Vec<Property>, found: impl Iterator<Item = &'p Property>) {
    let n_before = properties.len();
    for property in found {
        if !properties[n_before..].contains(property) {
            properties.push(property.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PropertyValue;
    use crate::testing::{BASICS, file_of, read};

    /// A wall `#1` and a space `#2` of IFC4, a wall `#1` of IFC2X3.
    const IFC4: &str = "#1=IFCWALL('wall',$,$,$,$,$,$,$,$);#2=IFCSPACE('space',$,$,$,$,$,$,$,$,$,$);";
    const IFC2X3: &str = "#1=IFCWALL('wall',$,$,$,$,$,$,$);";

    fn text(property: &Property) -> String {
        let PropertyValue::Text(value) = &property.value else { panic!("{property:?}") };
        format!("{}.{}={value}", property.set, property.name)
    }

    /// Properties of the only wall, then of the only space.
    fn properties(schema: &str, records: &str) -> Vec<String> {
        let (model, _) = read(&file_of(schema, &format!("{BASICS}{records}"))).unwrap();
        let of_elements = model.elements.iter().flat_map(|e| &e.properties);
        of_elements.chain(model.spaces.iter().flat_map(|s| &s.properties)).map(text).collect()
    }

    fn codes(records: &str) -> Vec<(&'static str, String)> {
        let (_, diagnostics) = read(&file_of("IFC4", &format!("{BASICS}{records}"))).unwrap();
        diagnostics.into_iter().map(|d| (d.code.name(), d.entity.unwrap_or_default().global_id)).collect()
    }

    #[test]
    fn groups_are_sets_by_their_entity_or_its_supertype_in_file_order() {
        let records = format!(
            "{IFC4}#10=IFCRELASSIGNSTOGROUP('a',$,$,$,(#2,#1),$,#20);#20=IFCZONE('z',$,'Z1',$,$,'West wing');
             #11=IFCRELASSIGNSTOGROUPBYFACTOR('b',$,$,$,(#1),$,#21,0.5);#21=IFCGROUP('g',$,' Lot 3 ',$,$);
             #12=IFCRELASSIGNSTOGROUP('c',$,$,$,(#1),$,#22);#22=IFCBUILDINGSYSTEM('s',$,'Facade',$,$,$,$);
             #13=IFCRELASSIGNSTOGROUP('d',$,$,$,(#1,#1),$,#23);#23=IFCGROUP('h',$,$,$,$);"
        );
        let expected = [
            "IfcZone.Name=Z1",
            "IfcZone.LongName=West wing",
            "IfcGroup.Name=Lot 3",
            "IfcSystem.Name=Facade",
            "IfcZone.Name=Z1",
            "IfcZone.LongName=West wing",
        ];
        assert_eq!(properties("IFC4", &records), expected);
    }

    #[test]
    fn zones_and_systems_of_ifc2x3_are_read() {
        let records = format!(
            "{IFC2X3}#10=IFCRELASSIGNSTOGROUP('a',$,$,$,(#1),$,#20);#20=IFCZONE('z',$,'Z1',$,$);
             #11=IFCRELASSIGNSTOGROUP('b',$,$,$,(#1),$,#21);#21=IFCSYSTEM('s',$,'Supply',$,$);"
        );
        assert_eq!(properties("IFC2X3", &records), ["IfcZone.Name=Z1", "IfcSystem.Name=Supply"]);
    }

    #[test]
    fn spatial_zones_are_groups_of_what_they_refer_to_or_contain() {
        let records = format!(
            "{IFC4}#10=IFCRELREFERENCEDINSPATIALSTRUCTURE('a',$,$,$,(#1),#20);#20=IFCSPATIALZONE('z',$,'Fire 1',$,$,$,$,'Stair',$);
             #11=IFCRELREFERENCEDINSPATIALSTRUCTURE('b',$,$,$,(#1),#21);#21=IFCBUILDINGSTOREY('s',$,'EG',$,$,$,$,$,$,$);
             #12=IFCRELAGGREGATES('c',$,$,$,#20,(#2));#13=IFCRELAGGREGATES('d',$,$,$,#22,(#20));
             #22=IFCSPATIALZONE('y',$,'Fire',$,$,$,$,$,$);"
        );
        let of_either = ["IfcSpatialZone.Name=Fire 1", "IfcSpatialZone.LongName=Stair", "IfcSpatialZone.Name=Fire"];
        assert_eq!(properties("IFC4", &records), [of_either, of_either].concat());
    }

    #[test]
    fn members_of_inner_groups_are_members_of_outer_ones_and_circles_end() {
        let records = format!(
            "{IFC4}#10=IFCRELASSIGNSTOGROUP('a',$,$,$,(#1),$,#20);#11=IFCRELASSIGNSTOGROUP('b',$,$,$,(#20),$,#21);
             #12=IFCRELASSIGNSTOGROUP('c',$,$,$,(#21,#2),$,#22);#13=IFCRELASSIGNSTOGROUP('d',$,$,$,(#22),$,#20);
             #20=IFCGROUP('i',$,'1',$,$);#21=IFCGROUP('j',$,'2',$,$);#22=IFCGROUP('k',$,'3',$,$);"
        );
        let expected = ["1", "2", "3", "3", "1", "2"].map(|name| format!("IfcGroup.Name={name}"));
        assert_eq!(properties("IFC4", &records), expected);
    }

    #[test]
    fn codes_are_named_by_their_system_and_the_occurrence_overrides_its_type() {
        let records = format!(
            "{IFC4}#10=IFCRELASSOCIATESCLASSIFICATION('a',$,$,$,(#1),#20);
             #20=IFCCLASSIFICATIONREFERENCE($,'21.20','Outer walls',#21,$,$);#21=IFCCLASSIFICATIONREFERENCE($,'21',$,#22,$,$);
             #22=IFCCLASSIFICATION('csi','1998',$,'Uniformat',$,$,$);
             #11=IFCRELDEFINESBYTYPE('b',$,$,$,(#1),#12);#12=IFCWALLTYPE('t',$,$,$,$,$,$,$,$,.STANDARD.);
             #13=IFCRELASSOCIATESCLASSIFICATION('c',$,$,$,(#12),#23);#23=IFCCLASSIFICATIONREFERENCE($,'99',$,#22,$,$);
             #14=IFCRELASSOCIATESCLASSIFICATION('d',$,$,$,(#12),#24);#24=IFCCLASSIFICATIONREFERENCE($,'E-1',$,#25,$,$);
             #25=IFCCLASSIFICATION('molio',$,$,'CCI',$,$,$);
             #15=IFCRELASSOCIATESCLASSIFICATION('e',$,$,$,(#2),#26);#26=IFCCLASSIFICATIONREFERENCE($,'','Office',$,$,$);
             #16=IFCRELASSOCIATESCLASSIFICATION('f',$,$,$,(#2),#25);"
        );
        let expected = [
            "IfcClassification.Uniformat=21.20",
            "IfcClassification.CCI=E-1",
            "IfcClassification.Identification=Office",
        ];
        assert_eq!(properties("IFC4", &records), expected);
    }

    #[test]
    fn item_references_of_ifc2x3_are_codes_and_sources_in_a_circle_end() {
        let records = format!(
            "{IFC2X3}#10=IFCRELASSOCIATESCLASSIFICATION('a',$,$,$,(#1),#20);
             #20=IFCCLASSIFICATIONREFERENCE('www.omniclass.org','13-13 00 00','Void Areas',#22);
             #22=IFCCLASSIFICATION('www.omniclass.org','Table 13',$,'OmniClass');
             #11=IFCRELASSOCIATESCLASSIFICATION('b',$,$,$,(#1),#23);#23=IFCCLASSIFICATIONREFERENCE('','7',$,#23);"
        );
        let expected = ["IfcClassification.OmniClass=13-13 00 00", "IfcClassification.Identification=7"];
        assert_eq!(properties("IFC2X3", &records), expected);
    }

    #[test]
    fn memberships_come_behind_property_sets() {
        let records = format!(
            "{IFC4}#10=IFCRELASSIGNSTOGROUP('a',$,$,$,(#1),$,#20);#20=IFCGROUP('g',$,'Lot',$,$);
             #11=IFCRELDEFINESBYPROPERTIES('b',$,$,$,(#1),#12);#12=IFCPROPERTYSET('p',$,'P',$,(#13));
             #13=IFCPROPERTYSINGLEVALUE('Status',$,IFCLABEL('NEW'),$);"
        );
        assert_eq!(properties("IFC4", &records), ["P.Status=NEW", "IfcGroup.Name=Lot"]);
    }

    #[test]
    fn an_assignment_to_what_is_not_there_is_reported() {
        let records = format!(
            "{IFC4}#10=IFCRELASSIGNSTOGROUP('a',$,$,$,(#1),$,#99);#11=IFCRELASSOCIATESCLASSIFICATION('b',$,$,$,(#1),#2);"
        );
        let dangling = |id: &str| ("membership_dangling", id.to_owned());
        let found: Vec<_> = codes(&records).into_iter().filter(|(code, _)| *code != "reference_dangling").collect();
        assert_eq!(found, [dangling("a"), dangling("b")]);
    }

    #[test]
    fn an_object_in_too_many_groups_is_in_the_first_ones_and_is_reported() {
        let group = |k: usize| {
            let (inner, outer) = (if k == 0 { 1 } else { 999 + k }, 1000 + k);
            format!(
                "#{outer}=IFCGROUP('g{k}',$,'{k}',$,$);#{}=IFCRELASSIGNSTOGROUP('r{k}',$,$,$,(#{inner}),$,#{outer});",
                5000 + k
            )
        };
        let chain = |n: usize| IFC4.to_owned() + &(0..n).map(group).collect::<String>();
        assert!(codes(&chain(PER_OBJECT_MAX)).is_empty());
        let records = chain(PER_OBJECT_MAX + 1);
        assert_eq!(codes(&records), [("memberships_too_many", "wall".to_owned())]);
        let found = properties("IFC4", &records);
        assert_eq!((found.len(), found[PER_OBJECT_MAX - 1].as_str()), (PER_OBJECT_MAX, "IfcGroup.Name=255"));
    }
}
