//! The claim of an alignment on the storey: tested against all others, given by a person, or not tested.

use messages::{Alignment, PoseValidity};

/// How the storey of a pose is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StoreyClaim {
    /// There was one map: the robot may as well be on another storey.
    NotTested,
    /// A person said it; the other storeys were looked at, and none fits clearly better.
    Given,
    /// All storeys were compared.
    Tested,
}

impl StoreyClaim {
    /// Its name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::NotTested => "not_tested",
            Self::Given => "given",
            Self::Tested => "tested",
        }
    }

    /// What people read with a pose; empty where all storeys were compared, and without a pose.
    pub(super) fn told(self, alignment: &Alignment<'_>) -> &'static str {
        match self {
            _ if alignment.pose().is_none() || alignment.validity() == PoseValidity::Refused => "",
            Self::NotTested => {
                "  storey not tested: there is one map alone, and another storey may fit as well; give the folder that `groundplan \
                 convert` wrote\n"
            }
            Self::Given => "  storey as given: no other one fits clearly better\n",
            Self::Tested => "",
        }
    }
}
