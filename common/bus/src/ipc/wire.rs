//! Types that cross process borders: transparent wrappers of `messages` records with iceoryx2's traits.

use bytemuck::{Pod, TransparentWrapper, Zeroable};
use iceoryx2::prelude::ZeroCopySend;
use messages::{Block, SampleHeader, StatusRecord};

/// Unit of payloads: a slice of them lies at a multiple of 64 bytes.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(transparent)]
pub(crate) struct WireBlock(Block);

// SAFETY: `Block` is plain bytes without padding, pointers or drop code; the name pins the contract across programs.
unsafe impl ZeroCopySend for WireBlock {
    unsafe fn type_name() -> &'static str {
        "groundplan.block64.v1"
    }
}

/// User header of latched topics.
#[derive(Debug, Clone, Copy, Zeroable, Pod, TransparentWrapper)]
#[repr(transparent)]
pub(crate) struct WireHeader(pub(crate) SampleHeader);

// SAFETY: `SampleHeader` is `repr(C)` and `Pod`: no padding, pointers or drop code.
unsafe impl ZeroCopySend for WireHeader {
    unsafe fn type_name() -> &'static str {
        "groundplan.sample_header.v1"
    }
}

impl Default for WireHeader {
    fn default() -> Self {
        Self::zeroed()
    }
}

/// Payload of the status stream.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(transparent)]
pub(crate) struct WireStatus(pub(crate) StatusRecord);

// SAFETY: `StatusRecord` is `repr(C)` and `Pod`: no padding, pointers or drop code.
unsafe impl ZeroCopySend for WireStatus {
    unsafe fn type_name() -> &'static str {
        "groundplan.status.v1"
    }
}

/// User header of commands and of their replies.
#[derive(Debug, Clone, Copy, Default, Zeroable, Pod)]
#[repr(C)]
pub(crate) struct WireCommand {
    /// Bytes of the payload that are used.
    pub(crate) length: u64,
    /// Of a reply: 1 progress, 2 done, 3 failed. Of a command: 0.
    pub(crate) kind: u32,
    /// Of a command: number of the user who sent it. Of a reply: 0.
    pub(crate) uid: u32,
}

// SAFETY: `repr(C)` and `Pod`: no padding, pointers or drop code.
unsafe impl ZeroCopySend for WireCommand {
    unsafe fn type_name() -> &'static str {
        "groundplan.command_header.v2"
    }
}
