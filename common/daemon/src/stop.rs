//! Stop and reload signals: SIGTERM, SIGINT or end of standard input; SIGHUP.

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Readable as soon as the process is to stop.
#[derive(Debug)]
pub struct StopSignal {
    reader: UnixStream,
}

impl StopSignal {
    /// Listens for signals, and for the end of standard input if that is what its parent's death looks like.
    ///
    /// # Errors
    /// The system refuses.
    pub fn listen(with_stdin: bool) -> io::Result<Self> {
        let (reader, writer) = UnixStream::pair()?;
        for signal in [SIGTERM, SIGINT] {
            signal_hook::low_level::pipe::register(signal, writer.try_clone()?)?;
        }
        if with_stdin {
            let mut writer = writer;
            let watch = move || {
                // Input is ignored, its end stops the daemon.
                let _ = io::copy(&mut io::stdin(), &mut io::sink());
                let _ = writer.write_all(b"s");
            };
            std::thread::Builder::new().name("stdin".to_owned()).spawn(watch)?;
        }
        Ok(Self { reader })
    }

    /// A descriptor that is readable as soon as the process is to stop.
    ///
    /// # Errors
    /// The system has no descriptors left.
    pub fn descriptor(&self) -> io::Result<OwnedFd> {
        Ok(self.reader.try_clone()?.into())
    }

    /// Waits; true if the process is to stop.
    pub fn is_raised_within(&mut self, time: Duration) -> bool {
        let timeout = self.reader.set_read_timeout(Some(time));
        timeout.is_err() || self.reader.read(&mut [0]).is_ok()
    }
}

/// Raised by SIGHUP: the configuration is to be read again.
#[derive(Debug)]
pub struct ReloadSignal(Arc<AtomicBool>);

impl ReloadSignal {
    /// Listens for the signal.
    ///
    /// # Errors
    /// The system refuses.
    pub fn listen() -> io::Result<Self> {
        let raised = Arc::default();
        signal_hook::flag::register(SIGHUP, Arc::clone(&raised))?;
        Ok(Self(raised))
    }

    /// True once for each time that it was raised, or several of them.
    pub fn take(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}
