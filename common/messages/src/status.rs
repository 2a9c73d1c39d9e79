//! Heartbeat record of a daemon, about once a second.

use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// Activity of a daemon.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum Activity {
    /// Waits for inputs or commands.
    #[default]
    Idle = 0,
    /// Reads its inputs.
    Reading = 1,
    /// Makes geometry.
    Meshing = 2,
    /// Writes its output.
    Writing = 3,
    /// Its output is out.
    Published = 4,
}

impl Activity {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Reading => "reading",
            Self::Meshing => "meshing",
            Self::Writing => "writing",
            Self::Published => "published",
        }
    }
}

/// A heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct StatusRecord {
    /// Number of the daemon, as the bus has it.
    pub daemon: u32,
    /// Its process.
    pub process_id: u32,
    /// What it is doing.
    pub activity: Tag<Activity>,
    /// Bytes of `error` that are used.
    pub error_length: u32,
    /// Counts the heartbeats of the process.
    pub sequence: u64,
    /// Monotonic time in nanoseconds, of the machine's boot.
    pub stamp_ns: u64,
    /// Resident memory in bytes.
    pub memory_bytes: u64,
    /// Epochs that it holds, by [`crate::ArchiveKind`] as a number; 0 for none.
    pub epochs: [u64; 16],
    /// The last error, UTF-8.
    pub error: [u8; StatusRecord::MAX_ERROR_BYTES],
}
const _: () = assert!(size_of::<StatusRecord>() == 512 && align_of::<StatusRecord>() == 8);

impl StatusRecord {
    /// Bytes of an error's text; a longer one is cut, the log has it whole.
    pub const MAX_ERROR_BYTES: usize = 344;

    /// A heartbeat without an error; what the bus fills in is zero.
    pub fn of(activity: Activity, memory_bytes: u64) -> Self {
        Self { activity: activity.into(), memory_bytes, ..Zeroable::zeroed() }
    }

    /// Sets the last error; an empty text says that there is none.
    pub fn set_error(&mut self, text: &str) {
        let end = text.floor_char_boundary(Self::MAX_ERROR_BYTES);
        self.error = [0; Self::MAX_ERROR_BYTES];
        self.error[..end].copy_from_slice(&text.as_bytes()[..end]);
        self.error_length = end as u32;
    }

    /// The last error; empty if there is none, or if it is no text.
    pub fn error(&self) -> &str {
        self.error.get(..self.error_length as usize).and_then(|e| std::str::from_utf8(e).ok()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_error_is_cut_between_letters() {
        let mut record = StatusRecord::zeroed();
        assert_eq!(record.error(), "");
        record.set_error(&"ü".repeat(StatusRecord::MAX_ERROR_BYTES));
        assert_eq!(record.error(), "ü".repeat(StatusRecord::MAX_ERROR_BYTES / 2));
        record.set_error("short");
        assert_eq!(record.error(), "short");
        record.error_length = u32::MAX;
        assert_eq!(record.error(), "");
    }
}
