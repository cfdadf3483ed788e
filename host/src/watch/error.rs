//! Why watching ended, in a line each, with the cure.

use crate::cli::Failure;
use picket_wire::layout::VERSION;
use std::fmt;

/// Why watching ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum WatchError {
    /// A file or port.
    Io {
        /// Which.
        what: String,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A port that does not open.
    Port {
        /// Which.
        name: String,
        /// What to do.
        cure: String,
    },
    /// No port was named: the first there is.
    Nameless(Option<String>),
    /// A file takes no more.
    Full {
        /// Which.
        what: String,
        /// The bytes that it holds.
        kept: u64,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The source ended, and nothing in it was a frame.
    Nothing(String),
    /// The records are of a version that this program does not know.
    Version {
        /// The source.
        what: String,
        /// The version.
        version: u8,
    },
    /// An order that a board does not answer.
    Unanswered {
        /// Which.
        order: &'static str,
        /// How often it was sent.
        tries: u32,
    },
    /// Nothing that came was a board's.
    Unheard {
        /// How often was asked.
        tries: u32,
        /// How much came.
        bytes: u64,
    },
    /// Captured blocks that did not come whole.
    Holes {
        /// Blocks that came whole.
        got: u16,
        /// Blocks that were asked for.
        wanted: u16,
    },
    /// The clock's error cannot be stored.
    Clock(String),
    /// Orders need a port.
    Orders,
    /// The settings' file.
    Settings(String),
    /// What comes cannot be kept where it is wanted.
    Output(String),
    /// The device refused.
    Refused(picket_wire::command::Refusal),
}

impl fmt::Display for WatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WatchError::Io { what, source } => write!(f, "{what}: {source}"),
            WatchError::Port { name, cure } => write!(f, "{name}: {cure}"),
            WatchError::Nameless(Some(first)) => write!(f, "name the port: picket watch {first}"),
            WatchError::Nameless(None) => f.write_str(
                "there is no board's serial port: plug the board in by its USB socket, name another port, or give - for bytes on stdin (--help lists all)",
            ),
            WatchError::Full { what, kept, source } => {
                write!(f, "{what}: {source}; the first {kept} bytes are kept")
            }
            WatchError::Nothing(what) => {
                write!(f, "{what}: no frame of a board is in it: give a file of --record")
            }
            WatchError::Version { what, version } => write!(f, "{what}: {}", unknown(*version)),
            WatchError::Unanswered { order, tries } => write!(
                f,
                "{order}: sent {tries} times without an answer: the board sends but does not receive, so check its receiving wire"
            ),
            WatchError::Unheard { tries, bytes } => {
                write!(f, "asked {tries} times: {}", unheard(*bytes))
            }
            WatchError::Holes { got, wanted } => write!(
                f,
                "--capture: {got} of {wanted} blocks came whole: the line loses bytes, so try a shorter cable or another USB socket"
            ),
            WatchError::Orders => {
                f.write_str("commands need a port: stdin and files cannot receive them")
            }
            WatchError::Settings(what) | WatchError::Output(what) | WatchError::Clock(what) => f.write_str(what),
            WatchError::Refused(refusal) => write!(f, "the device refuses: {refusal}"),
        }
    }
}

impl std::error::Error for WatchError {}

impl From<WatchError> for Failure {
    fn from(error: WatchError) -> Self {
        match error {
            WatchError::Full { .. } => Failure::unwritten(error.to_string()),
            _ => Failure::from(error.to_string()),
        }
    }
}

/// The error of a file or a port.
pub(super) fn io(what: impl fmt::Display) -> impl FnOnce(std::io::Error) -> WatchError {
    move |source| WatchError::Io { what: what.to_string(), source }
}

/// Records of a version that this program does not know.
pub(super) fn unknown(version: u8) -> String {
    format!(
        "its records have version {version}, this program knows version {VERSION}: update picket, or flash the board with this version's image (picket flash)"
    )
}

/// The likely reason if this many bytes came, and no frame.
pub(super) fn unheard(bytes: u64) -> String {
    let baud = picket_firmware::nucleo_f446re::words::serial::BAUD;
    match bytes {
        0 => "it says nothing; is it the board's port, and has the board power and its image (picket flash)?".into(),
        bytes => format!("{bytes} bytes came, and no frame; is it the board's port? The board sends at {baud} baud"),
    }
}
