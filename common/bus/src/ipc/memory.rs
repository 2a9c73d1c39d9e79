//! Shared-memory pages: allocated before they are written, so that a full memory is an error and not a SIGBUS.

use crate::segments::SHARED_MEMORY;
use rustix::fs::statvfs;
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};
use rustix::param::page_size;
use std::io;
use std::mem::MaybeUninit;
use std::ops::Range;

/// Left free for the small segments that the bus library makes without asking.
pub(crate) const RESERVE_BYTES: u64 = 8 << 20;

/// Pages are made this many bytes at a time, with a look at what is left in between.
const STEP_BYTES: usize = 4 << 20;

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
    let Range { start: mut from, end } = pages_of(start..start + length, page_size());
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
                give_back(start..start + length);
                return Err(errno.into());
            }
        }
    }
    Ok(())
}

/// Returns the pages of a loan that no neighbour has a part of.
fn give_back(memory: Range<usize>) {
    let Range { start, end } = pages_inside(memory, page_size());
    if start < end {
        // What cannot be returned stays with the loan's chunk: no harm beyond the room that it takes.
        let _ = advise(start, end, Advice::LinuxRemove);
    }
}

/// Addresses of the pages that memory overlaps: 4 KiB, and 16 or 64 KiB on some ARM machines. The first may begin before
/// it, where its segment lies too: segments begin at pages.
fn pages_of(memory: Range<usize>, page_bytes: usize) -> Range<usize> {
    memory.start & !(page_bytes - 1)..memory.end.next_multiple_of(page_bytes)
}

/// Addresses of the pages that lie wholly inside memory; empty if there is none.
fn pages_inside(memory: Range<usize>, page_bytes: usize) -> Range<usize> {
    memory.start.next_multiple_of(page_bytes)..memory.end & !(page_bytes - 1)
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
    fn pages_are_those_of_the_machine() {
        let memory = 0x1_2345..0x4_0001;
        for (page_bytes, overlapped, inside) in [
            (0x1000, 0x1_2000..0x4_1000, 0x1_3000..0x4_0000),
            (0x4000, 0x1_0000..0x4_4000, 0x1_4000..0x4_0000),
            (0x1_0000, 0x1_0000..0x5_0000, 0x2_0000..0x4_0000),
        ] {
            assert_eq!(pages_of(memory.clone(), page_bytes), overlapped);
            assert_eq!(pages_inside(memory.clone(), page_bytes), inside);
        }
        assert!(pages_inside(0x1001..0x1fff, 0x1000).is_empty(), "a neighbour's page is not given back");
    }

    #[test]
    fn pages_of_ordinary_memory_are_made_and_its_content_stays() {
        let mut memory = vec![MaybeUninit::new(7u8); 3 * STEP_BYTES + 5];
        populate(&mut memory[1..]).unwrap();
        // SAFETY: every byte was written when the vector was made.
        assert!(memory.iter().all(|b| unsafe { b.assume_init() } == 7));
    }
}
