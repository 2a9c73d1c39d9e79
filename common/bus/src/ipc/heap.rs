//! The heap: shared by threads, and what becomes of freed memory.

#[cfg(target_env = "gnu")]
use rustix::mm::{Advice, madvise};
use std::ffi::c_int;

/// What the one heap reserves at first: addresses, which take no memory before they are written to.
const RESERVED_BYTES: usize = 32 << 20;
/// More than what is left of the heap that a program starts with, and less than what gets memory of its own.
#[cfg(target_env = "gnu")]
const FIRST_BYTES: usize = 256 << 10;

/// Lets all threads share one heap, for programs of which one thread works while the others wait. It begins with large pages,
/// where the system gives such, and buffers of up to 512 KiB come from it.
///
/// With glibc each thread but the first has a heap of its own, which grows page by page. Faults of pages of 4 KiB are a tenth
/// of the CPU time of a small conversion. Up to one page of 2 MiB more is resident, and of what was freed as much as is reserved is
/// kept; buffers that would have had memory of their own leave gaps.
pub fn share_heap() {
    set_bounds(&[(M_ARENA_MAX, 1), (M_TOP_PAD, RESERVED_BYTES as c_int), (M_MMAP_THRESHOLD, 512 << 10)]);
    #[cfg(target_env = "gnu")]
    {
        let before = end_of_heap();
        // The heap grows by what is reserved.
        drop(std::hint::black_box(Vec::<u8>::with_capacity(FIRST_BYTES)));
        let n_bytes = (end_of_heap() as usize).saturating_sub(before as usize);
        // SAFETY: the range is that of the heap, which grew by it; the advice says nothing about what is in it. A system without
        // large pages refuses, and all stays as it is.
        let _ = unsafe { madvise(before, n_bytes, Advice::LinuxHugepage) };
    }
}

/// Where the heap ends.
#[cfg(target_env = "gnu")]
fn end_of_heap() -> *mut std::ffi::c_void {
    unsafe extern "C" {
        fn sbrk(increment: isize) -> *mut std::ffi::c_void;
    }
    // SAFETY: an increment of 0 changes nothing.
    unsafe { sbrk(0) }
}

/// Keeps freed heap memory for what comes next, for programs that work once and end.
///
/// glibc gives a buffer of more than 128 KiB memory of its own, which the system clears page by page and takes back when the
/// buffer is freed, and gives back the end of its heap as soon as that is as large. This makes it 4 MiB and 64 MiB, and the first
/// heap grows by 1 MiB. Other allocators have no such bounds. What meshes bodies is better off without: it leaves gaps of all sizes.
pub fn keep_freed_memory() {
    set_bounds(&[(M_MMAP_THRESHOLD, 4 << 20), (M_TRIM_THRESHOLD, 64 << 20), (M_TOP_PAD, 1 << 20)]);
}

/// Numbers of parameters in glibc's malloc.h.
const M_TRIM_THRESHOLD: c_int = -1;
const M_TOP_PAD: c_int = -2;
const M_MMAP_THRESHOLD: c_int = -3;
const M_ARENA_MAX: c_int = -8;

fn set_bounds(bounds: &[(c_int, c_int)]) {
    #[cfg(target_env = "gnu")]
    {
        unsafe extern "C" {
            fn mallopt(parameter: c_int, value: c_int) -> c_int;
        }
        for &(parameter, value) in bounds {
            // SAFETY: it takes the allocator's own locks, and a bound does not touch memory that is in use.
            unsafe { mallopt(parameter, value) };
        }
    }
    #[cfg(not(target_env = "gnu"))]
    let _ = bounds;
}

/// Gives the pages of freed heap memory back to the system.
///
/// glibc keeps what was freed below anything that is still used: after a large model is read that is most of what reading
/// took. It takes a few milliseconds for each hundred megabytes; other allocators give memory back by themselves.
pub fn give_back_freed_memory() {
    #[cfg(target_env = "gnu")]
    {
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> c_int;
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

    /// One test, because both are of the whole process.
    #[test]
    fn a_freed_buffer_is_kept_and_what_was_freed_below_a_piece_in_use_goes_back_and_the_piece_stays() {
        keep_freed_memory();
        let before = resident();
        drop(vec![1u8; 3 << 20]);
        assert!(resident().saturating_sub(before) > 1 << 20, "a buffer of 3 MiB is kept");

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
