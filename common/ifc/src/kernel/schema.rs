//! Schema lookup: entity spelling, supertypes, attribute positions.

use rustc_hash::FxHashMap;
use std::sync::LazyLock;

use ifc_lite_core::{IFC_TYPES, SchemaVersion};

/// The schema that records are read by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Schema {
    version: SchemaVersion,
    /// FILE_SCHEMA names a release before IFC2X3, which the records are read by.
    pub(crate) is_older: bool,
}

/// FILE_SCHEMA labels whose records are read by the oldest known schema.
pub(crate) const OLDEST: &str = "IFC2X3";

/// Newest first: an entity that the file's own schema does not declare is looked up in the others, because release
/// candidates and careless exporters mix them.
const ALL: [SchemaVersion; 5] =
    [SchemaVersion::Ifc4x3, SchemaVersion::Ifc4x2, SchemaVersion::Ifc4x1, SchemaVersion::Ifc4, SchemaVersion::Ifc2x3];

impl Schema {
    /// `None` for a schema that is not IFC2X, IFC2X2, IFC2X3, IFC4, IFC4X1, IFC4X2 or IFC4X3 (with their addenda and candidates).
    ///
    /// IFC2X (`IFC2X_FINAL`) and IFC2X2 are read as IFC2X3: of the entities that a map is made from it changed no attribute's
    /// place, and appended a few. IFC2.0 (`IFC20_LONGFORM`) has other relations and solids.
    pub(crate) fn from_label(label: &str) -> Option<Self> {
        if let Some(version) = SchemaVersion::from_file_schema(label) {
            return Some(Self { version, is_older: false });
        }
        let label = label.trim().to_ascii_uppercase();
        let is_older = label == "IFC2X2" || label.starts_with("IFC2X2_") || label.starts_with("IFC2X_");
        is_older.then_some(Self { version: SchemaVersion::Ifc2x3, is_older })
    }

    /// The entity itself and its supertypes, as the schema spells them; empty if no schema knows it.
    pub(crate) fn lineage(self, keyword: &str) -> Vec<&'static str> {
        let Some(version) = self.declaring(keyword) else { return Vec::new() };
        let mut names = Vec::new();
        let mut next = version.entity_info(keyword);
        while let Some(info) = next {
            names.push(spelled(info.name));
            next = info.parent.and_then(|parent| version.entity_info(parent));
        }
        names
    }

    /// Position of an attribute, inherited ones included.
    pub(crate) fn attribute(self, keyword: &str, name: &str) -> Option<usize> {
        self.declaring(keyword)?.attribute_names(keyword)?.iter().position(|n| n.eq_ignore_ascii_case(name))
    }

    fn declaring(self, keyword: &str) -> Option<SchemaVersion> {
        std::iter::once(self.version).chain(ALL).find(|version| version.entity_info(keyword).is_some())
    }
}

/// Occurrences and types that IFC4X3 no longer has.
const RETIRED: [&str; 32] = [
    "IfcBeamStandardCase",
    "IfcBuildingElement",
    "IfcBuildingElementComponent",
    "IfcBuildingElementType",
    "IfcChamferEdgeFeature",
    "IfcColumnStandardCase",
    "IfcDoorStandardCase",
    "IfcDoorStyle",
    "IfcEdgeFeature",
    "IfcElectricDistributionPoint",
    "IfcElectricHeaterType",
    "IfcElectricalCircuit",
    "IfcElectricalElement",
    "IfcEquipmentElement",
    "IfcGasTerminalType",
    "IfcMemberStandardCase",
    "IfcMove",
    "IfcOpeningStandardCase",
    "IfcOrderAction",
    "IfcPlateStandardCase",
    "IfcProjectOrderRecord",
    "IfcProxy",
    "IfcRelAssignsTasks",
    "IfcRoundedEdgeFeature",
    "IfcScheduleTimeControl",
    "IfcServiceLife",
    "IfcSlabElementedCase",
    "IfcSlabStandardCase",
    "IfcSpaceProgram",
    "IfcWallElementedCase",
    "IfcWindowStandardCase",
    "IfcWindowStyle",
];

/// The entity's name as the schema spells it; the kernel's registries hold STEP keywords, in capitals.
fn spelled(keyword: &'static str) -> &'static str {
    static NAMES: LazyLock<FxHashMap<String, &str>> = LazyLock::new(|| {
        let names = IFC_TYPES.iter().map(|t| t.name()).chain(RETIRED);
        names.map(|name| (name.to_ascii_uppercase(), name)).collect()
    });
    NAMES.get(keyword).copied().unwrap_or(keyword)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_addenda_and_candidates_are_known_and_others_are_not() {
        for label in ["IFC2X3", "IFC4", "IFC4_ADD2", "IFC4X3_RC2", "IFC4X1", "ifc4x3_add2", "IFC2X_FINAL"] {
            assert!(Schema::from_label(label).is_some(), "{label}");
        }
        for label in ["", "AP214", "CONFIG_CONTROL_DESIGN", "IFC5", "IFC20_LONGFORM", "IFC2X"] {
            assert!(Schema::from_label(label).is_none(), "{label}");
        }
    }

    #[test]
    fn lineage_is_spelled_as_the_schema_does() {
        let schema = Schema::from_label("IFC2X3").unwrap();
        let lineage = schema.lineage("IFCWALLSTANDARDCASE");
        assert_eq!(lineage[..3], ["IfcWallStandardCase", "IfcWall", "IfcBuildingElement"]);
        assert_eq!(lineage.last(), Some(&"IfcRoot"));
        assert!(schema.lineage("IFCNONSENSE").is_empty());
    }

    #[test]
    fn attributes_move_between_schemas() {
        let at = |schema, entity, name| Schema::from_label(schema).unwrap().attribute(entity, name);
        assert_eq!(at("IFC4", "IFCDOOR", "OperationType"), Some(11));
        assert_eq!(at("IFC2X3", "IFCDOOR", "OperationType"), None);
        assert_eq!(at("IFC2X3", "IFCDOORSTYLE", "OperationType"), Some(8));
        assert_eq!(at("IFC2X3", "IFCSTAIRFLIGHT", "NumberOfRiser"), Some(8));
    }

    #[test]
    fn a_body_of_every_kind_of_element_is_drawn_in_every_schema() {
        use crate::testing::{BASICS, file_of, read};
        let no_body = ["IfcFeatureElement", "IfcVirtualElement", "IfcReinforcingElement"];
        for label in ["IFC2X2_FINAL", "IFC2X3", "IFC4", "IFC4X3_ADD2"] {
            let schema = Schema::from_label(label).unwrap();
            let names = IFC_TYPES.iter().map(|t| t.name()).chain(RETIRED).map(str::to_ascii_uppercase);
            let kinds: Vec<String> = names
                .filter(|name| {
                    let lineage = schema.lineage(name);
                    lineage.contains(&"IfcElement") && !no_body.iter().any(|entity| lineage.contains(entity))
                })
                .collect();
            let record = |(k, name): (usize, &String)| format!("#{}={name}('e{k}',$,$,$,$,#103,#121,$);", 1000 + k);
            let records: String = kinds.iter().enumerate().map(record).collect();
            let (model, _) = read(&file_of(label, &format!("{BASICS}{records}"))).unwrap();
            let lost: Vec<&str> = model
                .elements
                .iter()
                .filter(|e| e.geometry.status != crate::GeometryStatus::Meshed)
                .map(|e| e.ifc_type)
                .collect();
            assert!(model.elements.len() == kinds.len() && kinds.len() > 80 && lost.is_empty(), "{label}: {lost:?}");
        }
    }
}
