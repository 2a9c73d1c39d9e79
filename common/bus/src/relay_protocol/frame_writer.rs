//! Puts frames into a stream without waiting: one frame at a time.

use super::frames::Frame;
use rustix::io::Errno;
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags, sendmsg};
use std::io::{self, IoSlice};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;

/// The frame that is being sent.
#[derive(Default)]
pub(crate) struct FrameWriter {
    bytes: Vec<u8>,
    sent: usize,
    descriptor: Option<Arc<OwnedFd>>,
}

impl FrameWriter {
    /// True if the last frame is out, and another can begin.
    pub(crate) fn is_idle(&self) -> bool {
        self.sent == self.bytes.len()
    }

    /// Begins a frame.
    ///
    /// # Panics
    /// If the last one is not out.
    pub(crate) fn begin(&mut self, frame: Frame) {
        assert!(self.is_idle(), "one frame at a time");
        self.bytes.clear();
        self.bytes.extend_from_slice(bytemuck::bytes_of(&frame.header));
        self.bytes.extend_from_slice(&frame.body);
        (self.sent, self.descriptor) = (0, frame.descriptor);
    }

    /// Sends as much as the stream takes; `flags` say whether it waits.
    pub(crate) fn flush(&mut self, socket: impl AsFd, flags: SendFlags) -> io::Result<()> {
        while !self.is_idle() {
            let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
            let mut control = SendAncillaryBuffer::new(&mut space);
            let descriptors;
            if let Some(descriptor) = &self.descriptor {
                descriptors = [descriptor.as_fd()];
                control.push(SendAncillaryMessage::ScmRights(&descriptors));
            }
            let rest = [IoSlice::new(&self.bytes[self.sent..])];
            match sendmsg(&socket, &rest, &mut control, flags | SendFlags::NOSIGNAL) {
                Ok(sent) => self.sent += sent,
                Err(Errno::INTR) => continue,
                Err(Errno::AGAIN) => return Ok(()),
                Err(errno) => return Err(errno.into()),
            }
            // It went with the first byte.
            self.descriptor = None;
        }
        Ok(())
    }
}
