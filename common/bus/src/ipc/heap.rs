//! Gives freed heap memory back to the system.

/// Gives the pages of freed heap memory back to the system.
///
/// glibc keeps what was freed below anything that is still used: after a large model is read that is most of what reading
/// took. It takes a few milliseconds for each hundred megabytes; other allocators give memory back by themselves.
pub fn give_back_freed_memory() {
    #[cfg(target_env = "gnu")]
    {
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        // SAFETY: it takes the allocator's own locks, and memory that is in use stays where it is.
        unsafe { malloc_trim(0) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Resident memory in bytes.
    fn resident() -> usize {
        let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
        let pages: usize = pages.split(' ').nth(1).unwrap().parse().unwrap();
        pages * rustix::param::page_size()
    }

    #[test]
    fn what_was_freed_below_a_piece_in_use_goes_back_and_the_piece_stays() {
        const PIECE: usize = 16 << 10;
        let mut pieces: Vec<Vec<u8>> = (0..4_096).map(|k| vec![k as u8; PIECE]).collect();
        let kept = pieces.pop().unwrap();
        drop(pieces);
        let before = resident();
        give_back_freed_memory();
        let given_back = before.saturating_sub(resident());
        // Other tests allocate meanwhile.
        assert!(given_back > 32 << 20, "{given_back} of {} bytes", 4_095 * PIECE);
        assert!(kept.iter().all(|byte| *byte == 255));
    }
}
