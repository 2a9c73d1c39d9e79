//! Participants that were silent for longer than they may be, and speak again.
//!
//! The library forgets a participant from which it hears nothing for the time that it announces, as where the network was away. Later
//! it knows its announcements by their numbers as those that it had, because a participant that has not ended goes on with the same
//! number, and takes them for no participant: neither hears the other ever again. A library that begins anew has had none.

use ros2_client::dds::rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, LostReason, StatusEvented,
};
use rustix::net::{AddressFamily, SocketFlags, SocketType, bind, socket_with, sockopt};
use std::collections::BTreeSet;
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};

/// Where participants announce themselves: group and ports by the RTPS specification, 2.5, section 9.6.2.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
const FIRST_PORT: u16 = 7400;
const PORTS_PER_DOMAIN: u16 = 250;
/// A message begins with four letters, a version and a vendor of two bytes each, and then who sends it.
const MAGIC: &[u8] = b"RTPS";
const SENDER: std::ops::Range<usize> = 8..20;

/// What all identifiers of a participant begin with.
type Prefix = [u8; SENDER.end - SENDER.start];

/// The participants that the library has lost, and the announcements of all.
pub(super) struct LostParticipants {
    events: DomainParticipantStatusListener,
    announcements: UdpSocket,
    known: Known,
}

impl LostParticipants {
    /// Hears the announcements in the domain of a participant, beside the library, which has joined their group.
    ///
    /// # Errors
    /// The port cannot be had.
    pub(super) fn of(participant: &DomainParticipant) -> io::Result<Self> {
        let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
        let socket = socket_with(AddressFamily::INET, SocketType::DGRAM, flags, None)?;
        // All programs of this computer hear on the same port.
        sockopt::set_socket_reuseaddr(&socket, true)?;
        sockopt::set_socket_reuseport(&socket, true)?;
        bind(&socket, &SocketAddrV4::new(GROUP, FIRST_PORT + PORTS_PER_DOMAIN * participant.domain_id()))?;
        Ok(Self { events: participant.status_listener(), announcements: socket.into(), known: Known::default() })
    }

    /// To be called once a second: true once one that was lost has spoken, and the library has not taken it back within a second.
    pub(super) fn has_unheard(&mut self) -> bool {
        while let Some(event) = self.events.try_recv_status() {
            match event {
                DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                    prefix(dpd.guid.prefix.as_ref()).map(|found| self.known.lost.remove(&found));
                }
                DomainParticipantStatusEvent::ParticipantLost { id, reason: LostReason::Timeout { .. } } => {
                    prefix(id.as_ref()).map(|lost| self.known.lost.insert(lost));
                }
                _ => {}
            }
        }
        let mut message = [0; SENDER.end];
        // What is longer is cut off.
        let senders =
            std::iter::from_fn(|| self.announcements.recv(&mut message).ok().map(|len| sender(&message[..len])));
        self.known.has_unheard(senders.flatten())
    }
}

/// Who is lost and who of them has spoken since.
#[derive(Default)]
struct Known {
    lost: BTreeSet<Prefix>,
    spoke: BTreeSet<Prefix>,
}

impl Known {
    /// True if one that is lost had spoken when this was called before.
    fn has_unheard(&mut self, senders: impl Iterator<Item = Prefix>) -> bool {
        let has_unheard = !self.spoke.is_disjoint(&self.lost);
        self.spoke = senders.filter(|sender| self.lost.contains(sender)).collect();
        has_unheard
    }
}

fn prefix(bytes: &[u8]) -> Option<Prefix> {
    bytes.try_into().ok()
}

/// Who sends a message; `None` for what is none.
fn sender(message: &[u8]) -> Option<Prefix> {
    message.starts_with(MAGIC).then(|| message.get(SENDER).and_then(prefix))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_is_lost_is_unheard_once_it_has_spoken_and_is_not_found_again() {
        let (one, other) = ([1; 12], [2; 12]);
        let mut known = Known { lost: [one].into(), ..Known::default() };
        let seconds = [vec![other], vec![one, other], vec![]];
        assert_eq!(seconds.map(|spoke| known.has_unheard(spoke.into_iter())), [false, false, true]);
        assert!(!known.has_unheard([one].into_iter()), "it has been silent in the second before");
        known.lost.remove(&one);
        assert!(!known.has_unheard([one].into_iter()), "it has been found");
    }

    #[test]
    fn only_a_whole_head_of_a_message_tells_who_sends_it() {
        let message: Vec<u8> = b"RTPS\x02\x05\x01\x10".iter().copied().chain(1..=12).collect();
        assert_eq!(sender(&message), Some([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]));
        assert_eq!([&message[..19], &message[1..], b"RTPX", b""].map(sender), [None; 4]);
    }
}
