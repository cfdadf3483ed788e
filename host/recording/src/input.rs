//! Where a recording's bytes come from: a file, or `-` for stdin. Its first bytes can be looked at before it is read.

use super::RecordingError;
use std::fs::File;
use std::io::{self, BufReader, Cursor, ErrorKind, Read};
use std::path::Path;

/// The bytes that are looked at.
const HEAD: usize = 1 << 16;

/// An input with its first bytes.
pub(super) struct Input {
    /// The first bytes; all, where they are fewer than 65,536.
    pub head: Vec<u8>,
    /// The length, where it is a file's.
    pub bytes: Option<u64>,
    rest: Box<dyn Read + Send>,
}

impl Input {
    /// Opens a file, or stdin for `-`. An empty file is an error; of a pipe only reading shows whether it is empty.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let failed = |error| RecordingError::Io(path.into(), error);
        let (mut rest, bytes): (Box<dyn Read + Send>, _) = if path == Path::new("-") {
            (Box::new(io::stdin()), None)
        } else {
            let file = File::open(path).map_err(failed)?;
            let metadata = file.metadata().map_err(failed)?;
            if metadata.is_dir() {
                return Err(failed(ErrorKind::IsADirectory.into()));
            }
            (Box::new(file), metadata.is_file().then_some(metadata.len()))
        };
        let mut head = Vec::new();
        rest.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(failed)?;
        if head.is_empty() {
            return Err(RecordingError::Empty(path.into()));
        }
        Ok(Input { head, bytes, rest })
    }

    /// The input of a file's bytes. An empty one is an error.
    pub fn of_bytes(name: &Path, bytes: Vec<u8>) -> Result<Self, RecordingError> {
        if bytes.is_empty() {
            return Err(RecordingError::Empty(name.into()));
        }
        let (length, head) = (bytes.len(), bytes[..bytes.len().min(HEAD)].to_vec());
        let mut rest = Cursor::new(bytes);
        rest.set_position(head.len() as u64);
        Ok(Input { head, bytes: Some(length as u64), rest: Box::new(rest) })
    }

    /// True if the head is the whole.
    pub fn whole(&self) -> bool {
        self.head.len() < HEAD
    }

    /// True if the head is text with a digit in it: bytes of a converter are not.
    pub fn text(&self) -> bool {
        let plain = |&byte: &u8| (b' '..127).contains(&byte) || b"\t\r\n".contains(&byte);
        self.head.iter().all(plain)
            && self.head.iter().any(u8::is_ascii_digit)
            && self.head.contains(&b'\n')
    }

    /// All bytes, the first ones again.
    pub fn reader(self) -> BufReader<impl Read + Send> {
        BufReader::with_capacity(1 << 16, Cursor::new(self.head).chain(self.rest))
    }
}
