//! Takes frames out of a stream: bodies are bounded before they are stored.

use super::frames::{FrameHeader, ProtocolError, SAMPLE};
use rustix::io::Errno;
use rustix::net::{RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, recv, recvmsg};
use std::collections::VecDeque;
use std::io::{self, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};

/// Bytes that are read at once; a peer that sends without end does not keep others waiting.
const CHUNK_BYTES: usize = 64 << 10;

/// Descriptors that may come with one chunk.
const MAX_DESCRIPTORS: usize = 4;

/// A frame that came.
pub(crate) struct Received {
    pub(crate) kind: u32,
    pub(crate) id: u64,
    pub(crate) body: Vec<u8>,
    pub(crate) descriptor: Option<OwnedFd>,
}

/// Bytes that came and were not taken as frames yet.
#[derive(Default)]
pub(crate) struct FrameReader {
    bytes: Vec<u8>,
    /// Where the next frame begins.
    from: usize,
    descriptors: VecDeque<OwnedFd>,
}

impl FrameReader {
    /// Reads what has come, a chunk at most, without waiting: the number of bytes, `None` at the end of the stream.
    /// Descriptors that come along are closed by the system: nobody keeps any open here.
    pub(crate) fn fill(&mut self, socket: impl AsFd) -> io::Result<Option<usize>> {
        self.read(|space| Ok(recv(&socket, space, RecvFlags::DONTWAIT)?.0))
    }

    /// The same, with the descriptors that come along.
    pub(crate) fn fill_with_descriptors(&mut self, socket: impl AsFd) -> io::Result<Option<usize>> {
        let mut came = Vec::new();
        let filled = self.read(|space| {
            let mut control = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_DESCRIPTORS))];
            let mut control = RecvAncillaryBuffer::new(&mut control);
            let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
            let received = recvmsg(&socket, &mut [IoSliceMut::new(space)], &mut control, flags)?;
            for message in control.drain() {
                if let RecvAncillaryMessage::ScmRights(descriptors) = message {
                    came.extend(descriptors);
                }
            }
            Ok(received.bytes)
        });
        self.descriptors.extend(came);
        filled
    }

    /// Gives a chunk of space to `receive`, which returns how much of it was filled.
    fn read(&mut self, mut receive: impl FnMut(&mut [u8]) -> Result<usize, Errno>) -> io::Result<Option<usize>> {
        self.bytes.drain(..self.from);
        self.from = 0;
        if self.bytes.is_empty() {
            // What a long frame took is not kept for the life of the peer.
            self.bytes.shrink_to(2 * CHUNK_BYTES);
        }
        let filled = self.bytes.len();
        self.bytes.resize(filled + CHUNK_BYTES, 0);
        let received = loop {
            match receive(&mut self.bytes[filled..]) {
                Err(Errno::INTR) => {}
                received => break received,
            }
        };
        self.bytes.truncate(filled + received.unwrap_or(0));
        match received {
            Ok(n_bytes) => Ok(Some(n_bytes).filter(|n_bytes| *n_bytes > 0)),
            Err(Errno::AGAIN) => Ok(Some(0)),
            Err(errno) => Err(errno.into()),
        }
    }

    /// True if a whole frame waits to be taken.
    pub(crate) fn has_frame(&self) -> bool {
        self.bytes[self.from..].split_at_checked(size_of::<FrameHeader>()).is_some_and(|(header, behind)| {
            let FrameHeader { length, .. } = bytemuck::pod_read_unaligned(header);
            behind.len() >= length as usize
        })
    }

    /// Bytes that came and were not taken.
    #[cfg(test)]
    pub(crate) fn n_bytes(&self) -> usize {
        self.bytes.len() - self.from
    }

    /// True if no byte is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.from == self.bytes.len()
    }

    /// The next whole frame; `max_body` says how long one of a kind may be.
    pub(crate) fn next(&mut self, max_body: impl Fn(u32) -> Option<usize>) -> Result<Option<Received>, ProtocolError> {
        let rest = &self.bytes[self.from..];
        let Some(header) = rest.get(..size_of::<FrameHeader>()) else { return Ok(None) };
        let FrameHeader { kind, length, id } = bytemuck::pod_read_unaligned(header);
        if max_body(kind).is_none_or(|max| length as usize > max) {
            return Err(ProtocolError::Frame { kind, length });
        }
        let end = size_of::<FrameHeader>() + length as usize;
        let Some(body) = rest.get(size_of::<FrameHeader>()..end) else { return Ok(None) };
        let body = body.to_vec();
        self.from += end;
        let descriptor = if kind == SAMPLE { self.descriptors.pop_front() } else { None };
        if kind != SAMPLE && self.descriptors.len() > MAX_DESCRIPTORS {
            // Nobody keeps a descriptor open here that no frame speaks of.
            self.descriptors.clear();
        }
        Ok(Some(Received { kind, id, body, descriptor }))
    }
}
