//! Shared-memory pages: allocated before they are written, so that a full memory is an error and not a SIGBUS.

use crate::generation::SHARED_MEMORY;
use rustix::fs::statvfs;
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};
use std::io;
use std::mem::MaybeUninit;

/// Left free for the small segments that the bus library makes without asking.
pub(crate) const RESERVE_BYTES: u64 = 8 << 20;

/// Pages are made this many bytes at a time, with a look at what is left in between.
const STEP_BYTES: usize = 4 << 20;

/// Smallest page that Linux has; a start below the first byte of a payload would still lie in its segment.
const PAGE_BYTES: usize = 4096;

/// Bytes of shared memory that are free.
pub(crate) fn free_bytes() -> u64 {
    // A machine without the folder has no shared memory: nothing is free there.
    statvfs(SHARED_MEMORY).map_or(0, |s| s.f_bavail.saturating_mul(s.f_frsize))
}

/// Makes the pages of a loan. On failure its pages are given back, so that others can go on.
///
/// # Errors
/// Shared memory is full, or would be but for the reserve.
pub(crate) fn populate<T>(memory: &mut [MaybeUninit<T>]) -> io::Result<()> {
    let length = size_of_val(memory);
    let start = memory.as_mut_ptr() as usize;
    let mut from = start & !(PAGE_BYTES - 1);
    let end = (start + length).next_multiple_of(PAGE_BYTES);
    while from < end {
        let to = (from + STEP_BYTES).min(end);
        let free_before = free_bytes();
        let mut made = advise(from, to, Advice::LinuxPopulateWrite);
        let free_after = free_bytes();
        if made.is_ok() && free_after < RESERVE_BYTES && free_after < free_before {
            made = Err(Errno::NOSPC);
        }
        match made {
            Ok(()) => from = to,
            // Linux before 5.14 has no such advice: there a full memory is not noticed.
            Err(Errno::INVAL) => return Ok(()),
            Err(Errno::INTR | Errno::AGAIN) => {}
            Err(errno) => {
                give_back(start, end);
                return Err(errno.into());
            }
        }
    }
    Ok(())
}

/// Returns the pages that lie wholly inside the loan; the first and the last may belong to neighbours too.
fn give_back(start: usize, end: usize) {
    let (from, to) = (start.next_multiple_of(PAGE_BYTES), end.saturating_sub(PAGE_BYTES));
    if from < to {
        // What cannot be returned stays with the loan's chunk: no harm beyond the room that it takes.
        let _ = advise(from, to, Advice::LinuxRemove);
    }
}

fn advise(from: usize, to: usize, advice: Advice) -> Result<(), Errno> {
    // SAFETY: the range holds only pages that a loan overlaps, which are mapped while it is held. Populating changes no
    // byte; pages are removed only inside the loan, whose bytes are not written and not readable yet.
    unsafe { madvise(from as *mut _, to - from, advice) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_ordinary_memory_are_made_and_its_content_stays() {
        let mut memory = vec![MaybeUninit::new(7u8); 3 * STEP_BYTES + 5];
        populate(&mut memory[1..]).unwrap();
        // SAFETY: every byte was written when the vector was made.
        assert!(memory.iter().all(|b| unsafe { b.assume_init() } == 7));
    }
}
