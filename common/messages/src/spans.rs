//! Spans and indices of records that point into other sections.

use crate::archive::NONE;
use std::ops::Range;

pub(crate) fn span(first: u32, n: u32) -> Range<usize> {
    first as usize..first as usize + n as usize
}

pub(crate) fn fits(first: u32, n: u32, length: usize) -> bool {
    u64::from(first) + u64::from(n) <= length as u64
}

pub(crate) fn optional(index: u32, length: usize) -> bool {
    index == NONE || (index as usize) < length
}
