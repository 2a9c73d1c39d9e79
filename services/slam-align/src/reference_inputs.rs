//! Inputs of the references of an alignment, with the hashes that published archives name.

use bus::SiteSamples;
use messages::InputHashes;

/// Inputs of the references. Copied, because the samples are lent to the worker while it works.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ReferenceInputs {
    pub(crate) inputs: InputHashes,
    pub(crate) plan_time_s: i64,
    pub(crate) frame_epoch: u64,
}

impl ReferenceInputs {
    /// `None` unless site, schedule state and index of grids belong together; if not, those that are missing are on their
    /// way.
    pub(crate) fn of(samples: &SiteSamples) -> Option<Self> {
        let state = samples.state()?;
        let robot = samples.index_of(state.site)?.bytes().header().inputs.robot;
        let (site, schedule_state) = (state.site.content_hash(), state.state.content_hash());
        Some(Self {
            inputs: InputHashes { site, schedule_state, robot, ..InputHashes::default() },
            plan_time_s: state.state.view().head.plan_time_s,
            frame_epoch: state.site.bytes().header().frame_epoch,
        })
    }
}
