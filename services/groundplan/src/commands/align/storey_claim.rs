//! The claim of an alignment on the storey: tested against all others, given by a person, or not tested.

use messages::{Alignment, PoseValidity};

/// How the storey of a pose is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StoreyClaim {
    /// There was one map: the robot may as well be on another storey.
    NotTested,
    /// Hints said it, as `--storey`, a room or an elevation; the other storeys were looked at, none fits clearly better, and those that
    /// fit alike are named.
    Given,
    /// All storeys were compared.
    Tested,
}

impl StoreyClaim {
    /// The claim where hints exclude these storeys, on which the map fits about as well: the map alone would not tell.
    pub(super) fn after_hints(self, alike: &[u32]) -> Self {
        match self {
            Self::Tested if !alike.is_empty() => Self::Given,
            other => other,
        }
    }

    /// Its name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::NotTested => "not_tested",
            Self::Given => "given",
            Self::Tested => "tested",
        }
    }

    /// What people read with a pose; empty where all storeys were compared, and without a pose. `alike` are other storeys on which the map
    /// fits about as well.
    pub(super) fn told(self, alignment: &Alignment<'_>, alike: &[u32]) -> String {
        match self {
            _ if alignment.pose().is_none() || alignment.validity() == PoseValidity::Refused => String::new(),
            Self::NotTested => {
                "  storey not tested: there is one map alone, and another storey may fit as well; give the folder that \
                                `groundplan convert` wrote\n"
                    .to_owned()
            }
            Self::Given if alike.is_empty() => "  storey as given: no other one fits as well\n".to_owned(),
            Self::Given => {
                let alike: Vec<String> = alike.iter().map(u32::to_string).collect();
                format!(
                    "  storey as given, and not known from the map: it fits about as well on storey {}; only hints say that it is not \
                     there\n",
                    alike.join(", ")
                )
            }
            Self::Tested => String::new(),
        }
    }
}
