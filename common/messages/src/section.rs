//! Declared sections as values: number, name, records and limit of each, for every kind of archive.

/// A section of a kind of archive, as it is declared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// Name of its records in the view.
    pub name: String,
    /// Its number in the section table.
    pub id: u32,
    /// Bytes per record.
    pub record_len: usize,
    /// Type of its records, as Rust prints it.
    pub record: &'static str,
    /// How many records it has.
    pub count: SectionCount,
    /// True if an archive may lack it.
    pub is_optional: bool,
}

/// How many records a section has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SectionCount {
    /// Exactly one.
    One,
    /// Any number.
    Any,
    /// No more than these.
    AtMost(usize),
}

impl Section {
    pub(crate) fn of<T>(name: &str, id: u32, count: SectionCount) -> Self {
        let record = std::any::type_name::<T>();
        Self { name: name.to_owned(), id, record_len: size_of::<T>(), record, count, is_optional: false }
    }

    /// The same section, which an archive may lack.
    pub(crate) fn optional(self) -> Self {
        Self { is_optional: true, ..self }
    }

    /// The sections of a group that an archive has or lacks as a whole; the first tells which. Their names begin with that of the group.
    pub(crate) fn optional_group(name: &str, sections: Vec<Self>) -> impl Iterator<Item = Self> {
        sections.into_iter().enumerate().map(move |(k, section)| Self {
            name: format!("{name}_{}", section.name),
            is_optional: section.is_optional || k == 0,
            ..section
        })
    }
}
