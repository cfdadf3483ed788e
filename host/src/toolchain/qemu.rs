//! The emulator: the system's, or else its Debian packages unpacked beside the firmware.
//!
//! Unpacking needs no root, changes nothing outside the target directory, and works where installing would
//! not, because another version of one of its packages is in use.

use super::apt;
use super::error::{ToolError, io_error};
use super::process::{locked, on_path};
use super::{firmware_dir, process};
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// An emulator's program, Debian's package that has it, and the directory where that is unpacked.
struct Emulator {
    program: &'static str,
    package: &'static str,
    place: &'static str,
}

/// The path of `qemu-system-arm`; unpacks it where it is missing.
pub fn qemu() -> Result<PathBuf, ToolError> {
    static FOUND: OnceLock<PathBuf> = OnceLock::new();
    let (program, package) = ("qemu-system-arm", "qemu-system-arm");
    Emulator { program, package, place: "qemu" }.found(&FOUND)
}

/// The path of `qemu-system-riscv32`, likewise.
pub fn qemu_riscv32() -> Result<PathBuf, ToolError> {
    static FOUND: OnceLock<PathBuf> = OnceLock::new();
    let (program, package) = ("qemu-system-riscv32", "qemu-system-misc");
    Emulator { program, package, place: "qemu-misc" }.found(&FOUND)
}

impl Emulator {
    fn found(&self, known: &OnceLock<PathBuf>) -> Result<PathBuf, ToolError> {
        if let Some(path) = known.get() {
            return Ok(path.clone());
        }
        let found = match on_path(self.program) {
            Some(path) => path,
            None => self.unpacked()?,
        };
        Ok(known.get_or_init(|| found).clone())
    }

    /// The starter of the unpacked emulator.
    fn unpacked(&self) -> Result<PathBuf, ToolError> {
        let directory = firmware_dir();
        fs::create_dir_all(&directory).map_err(io_error(directory.display()))?;
        let _lock = locked(&directory.join("qemu.lock"))?;
        let place = directory.join(self.place);
        let starter = place.join(self.program);
        if !starter.exists() {
            // Whole or not at all: the last step gives it its name.
            let half = directory.join(format!("{}.part", self.place));
            if half.exists() {
                fs::remove_dir_all(&half).map_err(io_error(half.display()))?;
            }
            let root = half.join("root");
            fs::create_dir_all(&root).map_err(io_error(root.display()))?;
            let packages = self.unpack(&half, &root)?;
            write_starter(&half.join(self.program), self.program, &root)?;
            fs::rename(&half, &place).map_err(io_error(place.display()))?;
            let (program, place) = (self.program, place.display());
            eprintln!("toolchain: {program} from {packages} packages, unpacked in {place}");
        }
        Ok(starter)
    }

    /// Gives the number of packages.
    fn unpack(&self, directory: &Path, root: &Path) -> Result<usize, ToolError> {
        let packages = apt::download(self.package, directory)?;
        for package in &packages {
            let mut command = Command::new("dpkg-deb");
            command.arg("--extract").arg(package).arg(root);
            let (ok, output) = process::capture(command, process::Show::Nothing)?;
            if !ok {
                return Err(apt::missing(
                    self.program,
                    &[self.package],
                    Some(output.trim().into()),
                ));
            }
            fs::remove_file(package).map_err(io_error(package.display()))?;
        }
        Ok(packages.len())
    }
}

/// Starts the unpacked emulator with the libraries that came with it, wherever the target directory is.
fn write_starter(path: &Path, program: &str, root: &Path) -> Result<(), ToolError> {
    // Debian keeps them in a folder of the machine's name.
    let folders = ["lib", "usr/lib"].into_iter().flat_map(|parent| {
        let entries = fs::read_dir(root.join(parent)).into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.contains("-linux-gnu")).map(move |name| format!("{parent}/{name}"))
    });
    let libraries: String = folders.map(|folder| format!("$root/{folder}:")).collect();
    let text = format!(
        "#!/bin/sh\n\
         root=$(dirname \"$0\")/root\n\
         LD_LIBRARY_PATH={libraries}${{LD_LIBRARY_PATH:-/usr/lib}} exec \"$root/usr/bin/{program}\" \"$@\"\n"
    );
    fs::write(path, text).map_err(io_error(path.display()))?;
    fs::set_permissions(path, Permissions::from_mode(0o755)).map_err(io_error(path.display()))
}
