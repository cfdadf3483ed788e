//! Where a recording's bytes come from: a file, bytes in memory, or `-` for stdin. The first bytes can be looked at before it is read.

use super::RecordingError;
use std::fs::File;
use std::io::{self, BufReader, Cursor, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

/// The bytes that are looked at.
const HEAD: usize = 1 << 16;
/// No file that has to be held in memory is longer, in bytes.
const LONGEST: u64 = 1 << 30;

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
        let (rest, bytes): (Box<dyn Read + Send>, _) = if path == Path::new("-") {
            (Box::new(io::stdin()), None)
        } else {
            let file = File::open(path).map_err(failed)?;
            let metadata = file.metadata().map_err(failed)?;
            if metadata.is_dir() {
                return Err(failed(ErrorKind::IsADirectory.into()));
            }
            (Box::new(file), metadata.is_file().then_some(metadata.len()))
        };
        Self::of(path, rest, bytes)
    }

    /// The input of a file's bytes. An empty one is an error.
    pub fn from_bytes(name: &Path, bytes: Arc<[u8]>) -> Result<Self, RecordingError> {
        let length = bytes.len() as u64;
        Self::of(name, Box::new(Cursor::new(bytes)), Some(length))
    }

    fn of(
        path: &Path,
        mut rest: Box<dyn Read + Send>,
        bytes: Option<u64>,
    ) -> Result<Self, RecordingError> {
        let mut head = Vec::new();
        let read = rest.by_ref().take(HEAD as u64).read_to_end(&mut head);
        read.map_err(|error| RecordingError::Io(path.into(), error))?;
        if head.is_empty() {
            return Err(RecordingError::Empty(path.into()));
        }
        Ok(Input { head, bytes, rest })
    }

    /// True if the head is the whole.
    pub fn whole(&self) -> bool {
        self.head.len() < HEAD
    }

    /// All bytes, the first ones again.
    pub fn reader(self) -> BufReader<impl Read + Send> {
        BufReader::with_capacity(1 << 16, Cursor::new(self.head).chain(self.rest))
    }

    /// The bytes from a place on. Those in the head are as the head has them now.
    pub fn from(self, path: &Path, start: u64) -> Result<impl Read + Send + use<>, RecordingError> {
        let mut reader = Cursor::new(self.head).chain(self.rest);
        let skipped = io::copy(&mut reader.by_ref().take(start), &mut io::sink());
        skipped.map_err(|error| RecordingError::Io(path.into(), error))?;
        Ok(reader)
    }

    /// All bytes in memory.
    pub fn all(self, path: &Path) -> Result<Vec<u8>, RecordingError> {
        if self.bytes.is_some_and(|bytes| bytes > LONGEST) {
            return Err(RecordingError::Io(path.into(), ErrorKind::FileTooLarge.into()));
        }
        let mut bytes = self.head;
        let rest = self.rest.take(LONGEST).read_to_end(&mut bytes);
        match rest {
            Ok(_) if bytes.len() as u64 > LONGEST => {
                Err(RecordingError::Io(path.into(), ErrorKind::FileTooLarge.into()))
            }
            Ok(_) => Ok(bytes),
            Err(error) => Err(RecordingError::Io(path.into(), error)),
        }
    }
}
