//! Writes properties into the `site` archive.

use ifc::{Property, PropertyValue};
use messages::{AttributeKind, AttributeRecord, SiteBuilder};

/// Writes properties: (first record, number of records).
pub(crate) fn add_attributes(builder: &mut SiteBuilder, properties: &[Property]) -> (u32, u32) {
    let first = builder.attributes.len() as u32;
    for property in properties {
        let (kind, number, text) = match &property.value {
            PropertyValue::Text(text) => (AttributeKind::Text, 0.0, text.as_str()),
            PropertyValue::Number(number) => (AttributeKind::Number, *number, ""),
            PropertyValue::Boolean(yes) => (AttributeKind::Boolean, f64::from(u8::from(*yes)), ""),
        };
        let record = AttributeRecord {
            set: builder.texts.add(&property.set),
            name: builder.texts.add(&property.name),
            text: builder.texts.add(text),
            number,
            kind: kind.into(),
            reserved: 0,
        };
        builder.attributes.push(record);
    }
    (first, properties.len() as u32)
}

#[cfg(test)]
mod tests {
    #[test]
    fn sets_of_memberships_are_named_as_in_archives() {
        assert_eq!(ifc::MEMBERSHIP_SETS, messages::MEMBERSHIP_SETS);
    }
}
