//! Files that commands write. A file that exists is a measurement until its owner says otherwise: it is replaced by --force
//! alone, and what a command reads is never replaced. A picture comes into being whole or not at all.

use clap::Args;
use same_file::Handle;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Whether files are replaced.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Output {
    /// Replaces files that exist
    #[arg(long)]
    pub force: bool,
}

impl Output {
    /// Whether `file` can become what a command writes that reads `inputs`. It is asked before the work begins.
    ///
    /// # Errors
    /// In one line, why not.
    pub fn check(self, file: &Path, inputs: &[&Path]) -> Result<(), String> {
        let name = file.display();
        // A pipe or a device takes what it is given.
        if is_device(file) {
            return Ok(());
        }
        if let Ok(own) = Handle::from_path(file) {
            let reads = |input: &&Path| match input.as_os_str() == "-" {
                true => Handle::stdin().is_ok_and(|stdin| stdin == own),
                false => Handle::from_path(input).is_ok_and(|input| input == own),
            };
            if inputs.iter().any(reads) {
                return Err(format!("{name} is what is read: name another file to write"));
            }
        }
        match fs::metadata(file) {
            Ok(about) if about.is_dir() => Err(format!("{name} is a folder: name a file")),
            Ok(_) if !self.force => Err(exists(file)),
            Ok(_) => Ok(()),
            Err(error) => match fs::metadata(folder(file)) {
                Ok(about) if about.is_dir() => Ok(()),
                _ => Err(format!("{name}: {error}")),
            },
        }
    }

    /// Whether `folder` can be filled: it is empty, or not there yet.
    ///
    /// # Errors
    /// In one line, why not.
    pub fn check_folder(self, folder: &Path) -> Result<(), String> {
        let filled = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        match filled && !self.force {
            true => {
                let name = folder.display();
                Err(format!(
                    "{name} is not empty: name another folder, or replace its files by --force"
                ))
            }
            false => Ok(()),
        }
    }

    /// Writes a file as a whole: beside its place first, so that a full disk leaves what was there.
    ///
    /// # Errors
    /// In one line.
    pub fn write(self, file: &Path, bytes: &[u8]) -> Result<(), String> {
        self.written(file, bytes).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => exists(file),
            _ => format!("{}: {error}", file.display()),
        })
    }

    fn written(self, file: &Path, bytes: &[u8]) -> io::Result<()> {
        if is_device(file) {
            return OpenOptions::new().write(true).open(file)?.write_all(bytes);
        }
        // The file that a link leads to is replaced, not the link.
        let place = match self.force {
            true => fs::canonicalize(file).unwrap_or_else(|_| file.into()),
            false => file.into(),
        };
        let mut beside = tempfile::Builder::new();
        beside.prefix(".picket-");
        if let Some(permissions) = permissions(&place) {
            beside.permissions(permissions);
        }
        let mut beside = beside.tempfile_in(folder(&place))?;
        beside.write_all(bytes)?;
        beside.as_file().sync_all()?;
        match self.force {
            true => beside.persist(&place)?,
            false => beside.persist_noclobber(&place)?,
        };
        Ok(())
    }

    /// A file that grows while a command runs: all that is written to it is kept, however the command ends. What it replaces is
    /// there until the first byte comes.
    ///
    /// # Errors
    /// The system's.
    pub fn grow(self, file: &Path) -> io::Result<Growing> {
        let device = is_device(file);
        let mut options = OpenOptions::new();
        options.write(true);
        match device {
            true => {}
            false if self.force => drop(options.create(true).truncate(false)),
            false => drop(options.create_new(true)),
        }
        let old = !device && self.force;
        Ok(Growing { path: file.into(), file: options.open(file)?, bytes: 0, old })
    }
}

/// A file that grows.
#[derive(Debug)]
pub struct Growing {
    path: PathBuf,
    file: File,
    bytes: u64,
    /// It still holds what is to be replaced.
    old: bool,
}

impl Growing {
    /// Its name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes that were written to it.
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Adds bytes at its end.
    ///
    /// # Errors
    /// The system's; what was written before is kept, and [`Growing::bytes`] counts it.
    pub fn add(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        if std::mem::take(&mut self.old) {
            self.file.set_len(0)?;
        }
        while !bytes.is_empty() {
            match self.file.write(bytes) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
                Ok(count) => {
                    self.bytes += count as u64;
                    bytes = bytes.get(count..).unwrap_or_default();
                }
            }
        }
        Ok(())
    }
}

fn exists(file: &Path) -> String {
    format!("{} exists: name another file, or replace it by --force", file.display())
}

/// What exists and is neither a file nor a folder: a pipe, a terminal, /dev/null.
fn is_device(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|about| !about.is_file() && !about.is_dir())
}

fn folder(file: &Path) -> &Path {
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent.unwrap_or(Path::new("."))
}

/// The permissions of the file that is replaced, or of a new one: a temporary file is its owner's alone.
#[cfg(unix)]
fn permissions(file: &Path) -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    let new = || Permissions::from_mode(0o666);
    Some(fs::metadata(file).map_or_else(|_| new(), |about| about.permissions()))
}

#[cfg(not(unix))]
fn permissions(_: &Path) -> Option<Permissions> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEW: Output = Output { force: false };
    const FORCE: Output = Output { force: true };

    #[test]
    fn a_file_is_replaced_by_force_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x");
        NEW.check(&file, &[]).unwrap();
        NEW.write(&file, b"first").unwrap();
        for error in [NEW.check(&file, &[]).unwrap_err(), NEW.write(&file, b"second").unwrap_err()]
        {
            assert!(error.ends_with("x exists: name another file, or replace it by --force"));
        }
        assert_eq!(NEW.grow(&file).unwrap_err().kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&file).unwrap(), b"first");
        FORCE.write(&file, b"third").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"third");
        // Nothing is left beside it.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_grows_keeps_what_was_there_until_a_byte_comes() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x");
        fs::write(&file, b"an older measurement").unwrap();
        drop(FORCE.grow(&file).unwrap());
        assert_eq!(fs::read(&file).unwrap(), b"an older measurement");
        let mut growing = FORCE.grow(&file).unwrap();
        growing.add(b"new").unwrap();
        growing.add(b"er").unwrap();
        assert_eq!((growing.bytes(), fs::read(&file).unwrap()), (5, b"newer".to_vec()));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_read_is_never_written() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link, hard] = ["x", "link", "hard"].map(|name| folder.path().join(name));
        fs::write(&file, b"samples").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        fs::hard_link(&file, &hard).unwrap();
        for to in [&file, &link, &hard] {
            let error = FORCE.check(to, &[&file]).unwrap_err();
            assert!(error.ends_with("is what is read: name another file to write"), "{error}");
        }
        // By force the file behind the link is replaced, and the link stays.
        FORCE.check(&link, &[&hard.with_extension("other")]).unwrap();
        FORCE.write(&link, b"picture").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"picture");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_leaves_no_file_and_a_device_stays_one() {
        let full = Path::new("/dev/full");
        FORCE.check(full, &[]).unwrap();
        assert!(FORCE.write(full, b"picture").unwrap_err().starts_with("/dev/full: "));
        NEW.write(Path::new("/dev/null"), b"picture").unwrap();
        assert!(is_device(full) && is_device(Path::new("/dev/null")));
        let error = NEW.check(Path::new("/nowhere/x"), &[]).unwrap_err();
        assert!(error.starts_with("/nowhere/x: "), "{error}");
    }
}
