//! Programs that are started from Debian's packages without being installed: downloaded and unpacked into a folder of ours, by any
//! user, once.
//!
//! It changes nothing else on the machine, and works where installing would not, because another version of one of a package's needs
//! is in use.

use super::apt::{self, Apt};
use super::cache;
use super::error::{ToolError, io_error};
use super::process::{Show, capture, locked};
use crate::progress;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

/// Packages that are unpacked together, with what they need.
#[derive(Debug)]
pub(super) struct Unpacked {
    /// What people call it.
    pub what: &'static str,
    /// Its folder.
    pub folder: &'static str,
    /// The packages; `{llvm}` stands for the version of LLVM that the first one needs.
    pub packages: &'static [&'static str],
    /// The programs, and where each lies; `{llvm}` likewise.
    pub programs: &'static [(&'static str, &'static str)],
}

/// Parts of packages that are not unpacked: pages for people, and the compiler's own source, except for the library's.
const LEFT: [&str; 5] = [
    "./usr/share/doc",
    "./usr/share/man",
    "./usr/share/locale",
    "./usr/src/*/src",
    "./usr/src/*/compiler",
];

impl Unpacked {
    /// The path by which one of the programs is started; unpacks it where it is missing or does not work.
    pub fn program(&self, name: &str) -> Result<PathBuf, ToolError> {
        static KNOWN: Mutex<Option<HashMap<PathBuf, ()>>> = Mutex::new(None);
        let place = cache::folder().join(self.folder);
        let starter = place.join("bin").join(name);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.get_or_insert_default();
        if known.contains_key(&starter) {
            return Ok(starter);
        }
        if !works(&starter) {
            let _lock = locked(&place.with_extension("lock"))?;
            // Another process may have done it meanwhile.
            if !works(&starter) {
                self.unpack(&place)?;
            }
            if !works(&starter) {
                return Err(self.missing(format!("{} does not start", starter.display())));
            }
        }
        known.insert(starter.clone(), ());
        Ok(starter)
    }

    /// Whole or not at all: the last step gives the folder its name.
    fn unpack(&self, place: &Path) -> Result<(), ToolError> {
        let half = place.with_extension("part");
        for old in [&half, place] {
            if old.exists() {
                fs::remove_dir_all(old).map_err(io_error(old.display()))?;
            }
        }
        let [packed, root, bin] = ["packed", "root", "bin"].map(|name| half.join(name));
        for folder in [&packed, &root, &bin] {
            fs::create_dir_all(folder).map_err(io_error(folder.display()))?;
        }
        let (files, llvm) = {
            let folder = cache::folder();
            let _lock = locked(&folder.join("apt.lock"))?;
            let apt = Apt::new(folder).map_err(|reason| self.missing(reason))?;
            apt.download(self.what, self.packages, &packed).map_err(|why| self.missing(why))?
        };
        let bar = progress::steps(&format!("unpacking {}", self.what));
        bar.set_length(files.len() as u64);
        for file in &files {
            self.extract(file, &root)?;
            fs::remove_file(file).map_err(io_error(file.display()))?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        for (name, path) in self.programs {
            write_starter(&bin.join(name), &path.replace("{llvm}", &llvm), &root)?;
        }
        fs::remove_dir_all(&packed).map_err(io_error(packed.display()))?;
        fs::rename(&half, place).map_err(io_error(place.display()))
    }

    fn extract(&self, package: &Path, root: &Path) -> Result<(), ToolError> {
        const PIPE: &str = "dpkg-deb --fsys-tarfile \"$0\" | tar --extract --no-same-owner --no-same-permissions --no-wildcards-match-slash --directory \"$@\"";
        let mut command = Command::new("sh");
        command.args(["-c", PIPE]).arg(package).arg(root);
        command.args(LEFT.map(|pattern| format!("--exclude={pattern}")));
        match capture(command, Show::Nothing)? {
            (true, _) => Ok(()),
            (false, output) => {
                Err(self.missing(output.lines().next().unwrap_or("dpkg-deb failed").into()))
            }
        }
    }

    /// The error for which the reason is given.
    pub fn missing(&self, reason: String) -> ToolError {
        // The linker's version is apt-get's to say.
        let named = |package: &&&str| !package.contains('{');
        let packages: Vec<&str> = self.packages.iter().filter(named).copied().collect();
        apt::missing(self.what, &packages, Some(reason))
    }
}

/// Whether a program starts: the libraries that it needs are there, and none of it was removed.
fn works(starter: &Path) -> bool {
    let mut command = Command::new(starter);
    command.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    starter.is_file() && command.status().is_ok_and(|status| status.success())
}

/// Starts a program from the packages with the libraries that came with it, wherever their folder is.
fn write_starter(path: &Path, program: &str, root: &Path) -> Result<(), ToolError> {
    let libraries: Vec<String> =
        libraries(root).iter().map(|folder| format!("$root/{}", folder.display())).collect();
    let libraries = libraries.join(":");
    let text = format!(
        "#!/bin/sh\n\
         root=$(cd \"$(dirname \"$0\")/../root\" && pwd)\n\
         LD_LIBRARY_PATH=\"{libraries}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\" exec \"$root/{program}\" \"$@\"\n"
    );
    fs::write(path, text).map_err(io_error(path.display()))?;
    executable(path).map_err(io_error(path.display()))
}

/// Lets everybody execute a file.
#[cfg(unix)]
fn executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755))
}

/// Lets everybody execute a file: Windows has no such permission, and Debian's packages do not run there.
#[cfg(not(unix))]
fn executable(_: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// The folders below the root that hold libraries: Debian keeps them in one of the machine's name, and those of one program in a folder in that.
fn libraries(root: &Path) -> Vec<PathBuf> {
    let folders = |parent: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(root.join(parent)).into_iter().flatten().flatten();
        let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        let mut folders: Vec<PathBuf> = folders.map(|f| parent.join(f.file_name())).collect();
        folders.sort();
        folders
    };
    let holds_some = |folder: &PathBuf| {
        let entries = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.any(|name| name.starts_with("lib") && name.contains(".so"))
    };
    let mut all = Vec::new();
    for parent in ["lib", "usr/lib"] {
        let of_the_machine = |folder: &PathBuf| folder.to_string_lossy().ends_with("-linux-gnu");
        for folder in folders(Path::new(parent)).into_iter().filter(of_the_machine) {
            let private = folders(&folder).into_iter().filter(holds_some);
            let private: Vec<PathBuf> = private.collect();
            all.push(folder);
            all.extend(private);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_are_found_in_their_folders() {
        let root = tempfile::tempdir().unwrap();
        let machine = "usr/lib/aarch64-linux-gnu";
        for file in ["libz.so.1", "pulse/libcommon-16.so", "gconv/LATIN1.so", "empty/x"] {
            let path = root.path().join(machine).join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        fs::create_dir_all(root.path().join("usr/lib/llvm-22")).unwrap();
        let expected = [machine.into(), format!("{machine}/pulse")].map(PathBuf::from);
        assert_eq!(libraries(root.path()), expected);
    }

    /// In a folder whose name a shell would take apart, and moved after it was written.
    #[test]
    fn a_starter_finds_its_program_wherever_it_is() {
        let place = tempfile::tempdir().unwrap();
        let [first, second] = ["Bär äh $HOME", "it's; there"].map(|name| place.path().join(name));
        fs::create_dir_all(first.join("bin")).unwrap();
        fs::create_dir_all(first.join("root/usr/bin")).unwrap();
        let program = first.join("root/usr/bin/tool");
        fs::write(&program, "#!/bin/sh\ntest \"$1\" = --version\n").unwrap();
        executable(&program).unwrap();
        write_starter(&first.join("bin/tool"), "usr/bin/tool", &first.join("root")).unwrap();
        assert!(works(&first.join("bin/tool")));
        fs::rename(&first, &second).unwrap();
        assert!(works(&second.join("bin/tool")) && !works(&first.join("bin/tool")));
        fs::remove_file(second.join("root/usr/bin/tool")).unwrap();
        assert!(!works(&second.join("bin/tool")));
    }
}
