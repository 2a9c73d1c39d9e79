//! Identity of an entity: STEP id, GlobalId and name.

/// An IfcRoot by its identity.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Named {
    /// STEP id in its file.
    pub step_id: u32,
    /// GlobalId, 22 characters.
    pub global_id: String,
    /// Name; empty if absent.
    pub name: String,
}
