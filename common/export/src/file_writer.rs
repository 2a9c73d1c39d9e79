//! Writes each file while the next one is made.

use crate::input::ExportFile;
use std::panic::resume_unwind;
use std::sync::mpsc::sync_channel;
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};

/// What makes files and gives each of them away; the error is that of who takes them.
pub(crate) trait MakeFiles {
    /// Makes all of them, in their order, until one is not taken.
    ///
    /// # Errors
    /// Those of `add`.
    fn make<E>(self, add: &mut dyn FnMut(ExportFile) -> Result<(), E>) -> Result<(), E>;
}

/// Nobody takes files any more.
struct NotTaken;

/// Gives files to `write` in the order in which they are made, on a thread of its own if `threads` are more than one. At most one
/// file waits while another one is written.
///
/// # Errors
/// Those of `write`, after the first of which nothing is written.
pub(crate) fn write_while_making<E: Send>(
    threads: usize,
    files: impl MakeFiles,
    write: impl FnMut(ExportFile) -> Result<(), E> + Send,
) -> Result<(), E> {
    let write = Mutex::new(write);
    let take = |file: ExportFile| (write.lock().unwrap_or_else(PoisonError::into_inner))(file);
    if threads < 2 {
        return files.make(&mut |file| take(file));
    }
    scope(|scope| {
        let (send, receive) = sync_channel(0);
        let writer = Builder::new().name("file-writer".to_owned());
        let Ok(writer) = writer.spawn_scoped(scope, || receive.into_iter().try_for_each(take)) else {
            // The machine has no thread to give.
            return files.make(&mut |file| take(file));
        };
        let made = files.make(&mut |file| send.send(file).map_err(|_| NotTaken));
        drop(send);
        match (made, writer.join()) {
            (_, Ok(written)) => written,
            (_, Err(panic)) => resume_unwind(panic),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Numbered(usize);

    impl MakeFiles for Numbered {
        fn make<E>(self, add: &mut dyn FnMut(ExportFile) -> Result<(), E>) -> Result<(), E> {
            (0..self.0).try_for_each(|k| add(ExportFile::new(k.to_string(), vec![0; k])))
        }
    }

    /// Names of the files that were written, of which the one with this number fails.
    fn written(threads: usize, n: usize, fails: usize) -> (Result<(), usize>, Vec<String>) {
        let mut names = Vec::new();
        let end = write_while_making(threads, Numbered(n), |file| {
            let k = file.bytes.len();
            names.push(file.path);
            if k == fails { Err(k) } else { Ok(()) }
        });
        (end, names)
    }

    #[test]
    fn files_are_written_in_their_order_until_one_cannot_be() {
        let names = |n: usize| (0..n).map(|k| k.to_string()).collect::<Vec<_>>();
        for threads in [1, 2] {
            assert_eq!(written(threads, 0, 9), (Ok(()), names(0)));
            assert_eq!(written(threads, 50, 99), (Ok(()), names(50)));
            assert_eq!(written(threads, 50, 49), (Err(49), names(50)));
            assert_eq!(written(threads, 50, 7), (Err(7), names(8)));
        }
    }
}
