//! Where a device's bytes come from: its port, stdin or a recording. A port that goes away is waited for.

use super::{WatchError, io, ports};
use crate::emulator::reader;
use picket_firmware::nucleo_f446re::words::serial::BAUD;
use serialport::SerialPort;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// A source of bytes.
pub enum Source {
    /// A serial port, open or waited for.
    Port {
        /// Its name.
        name: String,
        /// Open.
        port: Option<Box<dyn SerialPort>>,
        /// Whether its absence was reported.
        told: bool,
    },
    /// A file.
    File(File),
    /// Stdin, on a thread of its own, so that waiting for it can end.
    Stdin(Receiver<Vec<u8>>),
}

/// What a source gives.
pub enum Piece {
    /// The port is open, for the first time or again.
    Opened,
    /// Bytes; none where nothing was said for a while.
    Bytes(Vec<u8>),
    /// No more.
    End,
}

const PAUSE: Duration = Duration::from_millis(200);

impl Source {
    /// Opens a port, `-` or a recording.
    pub fn open(port: Option<&str>, replay: Option<&Path>) -> Result<Self, WatchError> {
        match (port, replay) {
            (_, Some(path)) => {
                let file = File::open(path).map_err(io(path.display()))?;
                Ok(Source::File(file))
            }
            (Some("-") | None, None) => Ok(Source::Stdin(reader(Some(std::io::stdin())))),
            // At the start a wrong name is an error; later the program waits for the port.
            (Some(name), None) => {
                let port = open(name).map_err(|error| WatchError::Port {
                    name: name.into(),
                    cure: ports::cure(&error),
                })?;
                Ok(Source::Port { name: name.into(), port: Some(port), told: true })
            }
        }
    }

    /// Whether orders can be sent.
    pub const fn listens(&self) -> bool {
        matches!(self, Source::Port { .. })
    }

    /// What comes next.
    pub fn piece(&mut self) -> Result<Piece, WatchError> {
        let mut buffer = [0; 4096];
        match self {
            Source::File(file) => match file.read(&mut buffer) {
                Ok(0) => Ok(Piece::End),
                Ok(count) => Ok(Piece::Bytes(buffer[..count].to_vec())),
                Err(error) if error.kind() == ErrorKind::Interrupted => Ok(Piece::Bytes(vec![])),
                Err(error) => Err(io("the input")(error)),
            },
            Source::Stdin(bytes) => match bytes.recv_timeout(PAUSE) {
                Ok(bytes) => Ok(Piece::Bytes(bytes)),
                Err(RecvTimeoutError::Timeout) => Ok(Piece::Bytes(vec![])),
                Err(RecvTimeoutError::Disconnected) => Ok(Piece::End),
            },
            Source::Port { name, port, told } => {
                let Some(open_port) = port else {
                    match open(name) {
                        Ok(opened) => {
                            eprintln!("{name} is back");
                            (*port, *told) = (Some(opened), true);
                        }
                        Err(_) => std::thread::sleep(PAUSE),
                    }
                    return Ok(Piece::Bytes(vec![]));
                };
                if std::mem::take(told) {
                    return Ok(Piece::Opened);
                }
                match open_port.read(&mut buffer) {
                    Ok(count) if count > 0 => return Ok(Piece::Bytes(buffer[..count].to_vec())),
                    Err(error) if quiet(error.kind()) => {}
                    _ => {
                        eprintln!(
                            "{name} is gone; waiting for it: plug the board in again, or end by Ctrl-C"
                        );
                        *port = None;
                    }
                }
                Ok(Piece::Bytes(vec![]))
            }
        }
    }

    /// Sends bytes to the device; what a port that has gone does not take is sent again when it is back.
    pub fn send(&mut self, bytes: &[u8]) {
        if let Source::Port { port: Some(port), .. } = self {
            // A failure shows at the next read.
            let _ = port.write_all(bytes);
        }
    }
}

fn quiet(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock)
}

fn open(name: &str) -> serialport::Result<Box<dyn SerialPort>> {
    serialport::new(name, BAUD).timeout(PAUSE).open()
}
