//! Memory files that nobody can change any more: what is passed to other users.

use messages::ArchiveBuffer;
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, fstat, memfd_create};
use rustix::io::Errno;
use std::io;
use std::os::fd::{AsFd, OwnedFd};

/// Neither longer, nor shorter, nor other bytes.
const SEALS: SealFlags = SealFlags::SEAL.union(SealFlags::SHRINK).union(SealFlags::GROW).union(SealFlags::WRITE);

/// A memory file with these bytes. Written with system calls: a full memory is an error, not a signal.
pub(crate) fn seal(name: &str, bytes: &[u8]) -> io::Result<OwnedFd> {
    let memory = memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
    let mut rest = bytes;
    while !rest.is_empty() {
        match rustix::io::write(&memory, rest) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => rest = &rest[written..],
            Err(Errno::INTR) => {}
            Err(errno) => return Err(errno.into()),
        }
    }
    fcntl_add_seals(&memory, SEALS)?;
    Ok(memory)
}

/// The bytes of a memory file, which must be sealed and of this length.
pub(crate) fn read_sealed(memory: impl AsFd, length: u64) -> io::Result<ArchiveBuffer> {
    let is_sealed = fcntl_get_seals(&memory)?.contains(SEALS);
    if !is_sealed || u64::try_from(fstat(&memory)?.st_size) != Ok(length) {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "the memory file is not as it was announced"));
    }
    let length = usize::try_from(length).map_err(io::Error::other)?;
    let mut buffer = ArchiveBuffer::zeroed(length);
    let mut filled = 0;
    while filled < length {
        match rustix::io::pread(&memory, &mut buffer.bytes_mut()[filled..], filled as u64) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => filled += read,
            Err(Errno::INTR) => {}
            Err(errno) => return Err(errno.into()),
        }
    }
    Ok(buffer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sealed_can_be_read_and_not_changed() {
        let bytes: Vec<u8> = (0..100_000u32).map(|k| k as u8).collect();
        let memory = seal("test", &bytes).unwrap();
        assert!(read_sealed(&memory, 100_000).unwrap().bytes() == bytes);
        assert_eq!(rustix::io::pwrite(&memory, &[1], 0), Err(Errno::PERM));
        assert_eq!(rustix::fs::ftruncate(&memory, 5), Err(Errno::PERM));
        assert_eq!(rustix::fs::ftruncate(&memory, 200_000), Err(Errno::PERM));
        assert!(read_sealed(&memory, 99_999).is_err() && read_sealed(&memory, 100_001).is_err());
    }

    #[test]
    fn memory_that_another_could_change_is_refused() {
        let memory = memfd_create("test", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING).unwrap();
        rustix::io::write(&memory, &[0; 64]).unwrap();
        assert!(read_sealed(&memory, 64).is_err());
        let file = tempfile::tempfile().unwrap();
        assert!(read_sealed(&file, 0).is_err(), "a file on a disk has no seals");
    }
}
