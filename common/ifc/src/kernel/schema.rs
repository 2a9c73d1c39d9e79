//! What the schema of the file says about entities: spelling, supertypes, places of attributes.

use std::collections::HashMap;
use std::sync::LazyLock;

use ifc_lite_core::{IFC_TYPES, SchemaVersion};

/// The schema that FILE_SCHEMA names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Schema(SchemaVersion);

/// Newest first: an entity that the file's own schema does not declare is looked up in the others, because release
/// candidates and careless exporters mix them.
const ALL: [SchemaVersion; 5] =
    [SchemaVersion::Ifc4x3, SchemaVersion::Ifc4x2, SchemaVersion::Ifc4x1, SchemaVersion::Ifc4, SchemaVersion::Ifc2x3];

impl Schema {
    /// `None` for a schema that is not IFC2X3, IFC4, IFC4X1, IFC4X2 or IFC4X3 (with their addenda and candidates).
    pub(crate) fn from_label(label: &str) -> Option<Self> {
        SchemaVersion::from_file_schema(label).map(Self)
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
        std::iter::once(self.0).chain(ALL).find(|version| version.entity_info(keyword).is_some())
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
    static NAMES: LazyLock<HashMap<String, &str>> = LazyLock::new(|| {
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
        for label in ["IFC2X3", "IFC4", "IFC4_ADD2", "IFC4X3_RC2", "IFC4X1", "ifc4x3_add2"] {
            assert!(Schema::from_label(label).is_some(), "{label}");
        }
        for label in ["", "AP214", "CONFIG_CONTROL_DESIGN", "IFC5", "IFC2X2_FINAL"] {
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
}
