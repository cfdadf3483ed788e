//! Debian's packages, downloaded by any user: apt-get works on lists and caches in a folder of ours, and nothing is installed.

use super::error::ToolError;
use super::process::on_path;
use crate::end::Owned;
use crate::progress;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{IsTerminal, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, SystemTime};

/// Lists older than this are fetched again: a package's file leaves the archive soon after its successor came.
const FRESH: Duration = Duration::from_secs(24 * 3600);

/// What apt-get says where there is no network.
const UNREACHED_WORDS: [&str; 7] = [
    "resolving",
    "Could not resolve",
    "Could not connect",
    "Cannot initiate the connection",
    "Network is unreachable",
    "onnection timed out",
    "onnection refused",
];
const NO_NETWORK: &str = "no network: ";

/// The lists that apt-get reads.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lists {
    /// Ours, as fresh as they are.
    Own,
    /// Ours, fetched now.
    Fetched,
    /// The system's, which somebody else keeps.
    System,
}

/// The package manager, with a folder of ours.
pub(super) struct Apt<'a> {
    folder: &'a Path,
}

/// The file of a package, as apt-get lists it before the download.
#[derive(Debug, PartialEq)]
struct Parcel {
    file: String,
    bytes: u64,
}

impl<'a> Apt<'a> {
    /// Finds the package manager.
    pub fn new(folder: &'a Path) -> Result<Self, String> {
        match ["apt-get", "dpkg-deb"].iter().find(|&program| on_path(program).is_none()) {
            Some(program) => Err(format!("there is no {program}, as Debian and Ubuntu have it")),
            None => Ok(Apt { folder }),
        }
    }

    /// Downloads packages and those they need that are not installed. The name of a package may have `{llvm}` for the version of
    /// LLVM that the first one needs. Gives the files and that version.
    pub fn download(
        &self,
        what: &str,
        packages: &[&str],
        into: &Path,
    ) -> Result<(Vec<PathBuf>, String), String> {
        // One look is enough: it takes its time.
        static UNREACHED: OnceLock<String> = OnceLock::new();
        if let Some(reason) = UNREACHED.get() {
            return Err(reason.clone());
        }
        let mut first = None;
        for lists in [Lists::Own, Lists::Fetched, Lists::System] {
            match self.download_by(lists, what, packages, into) {
                Ok(had) => return Ok(had),
                Err(reason) if reason.starts_with(NO_NETWORK) => {
                    return Err(UNREACHED.get_or_init(|| reason).clone());
                }
                Err(reason) => first = first.or(Some(reason)),
            }
        }
        Err(first.unwrap_or_default())
    }

    fn download_by(
        &self,
        lists: Lists,
        what: &str,
        packages: &[&str],
        into: &Path,
    ) -> Result<(Vec<PathBuf>, String), String> {
        let unreached = self.update(lists)?;
        // Old lists may do; where they do not, what kept them old is the reason.
        let better = |reason| unreached.clone().unwrap_or(reason);
        let (packages, llvm) = self.named(lists, packages).map_err(better)?;
        // A simulation tells what belongs to them, whatever could be installed beside it.
        let simulate = ["install", "--simulate", "--no-install-recommends"].map(str::to_owned);
        let plan = self.ask("apt-get", lists, &[&simulate[..], &packages].concat());
        let mut names = planned(&plan.map_err(better)?);
        names.extend(packages);
        names.sort();
        names.dedup();
        let print = ["--print-uris", "download"].map(str::to_owned);
        let uris = self.ask("apt-get", lists, &[&print[..], &names].concat())?;
        let parcels = parcels(&uris);
        let bytes = parcels.iter().map(|parcel| parcel.bytes).sum();
        self.fetch(lists, what, &names, bytes, into)?;
        Ok((parcels.iter().map(|parcel| into.join(&parcel.file)).collect(), llvm))
    }

    /// Fetches our lists where they are to be fetched. Gives the reason for which they were not.
    fn update(&self, lists: Lists) -> Result<Option<String>, String> {
        let stamp = self.folder.join("lists.fetched");
        let age = || fs::metadata(&stamp).ok()?.modified().ok()?.elapsed().ok();
        let due = match lists {
            Lists::Own => age().is_none_or(|age| age > FRESH),
            // Those of a minute ago are the archive's.
            Lists::Fetched => age().is_none_or(|age| age > Duration::from_secs(60)),
            Lists::System => false,
        };
        if !due {
            return Ok(None);
        }
        if std::io::stderr().is_terminal() {
            eprintln!("toolchain: what packages there are");
        }
        let folders = ["lists/partial", "apt/archives/partial"];
        let made = folders.iter().try_for_each(|name| fs::create_dir_all(self.folder.join(name)));
        made.map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let (_, said) = self.run("apt-get", lists, &["update".to_owned()])?;
        let unreached = unreached(&said);
        if unreached.is_none() {
            let _ = File::create(&stamp).and_then(|file| file.set_modified(SystemTime::now()));
        }
        Ok(unreached)
    }

    /// The packages' names, and the version of LLVM in them.
    fn named(&self, lists: Lists, packages: &[&str]) -> Result<(Vec<String>, String), String> {
        const LLVM: &str = "{llvm}";
        let mut llvm = String::new();
        if let (true, Some(first)) =
            (packages.iter().any(|name| name.contains(LLVM)), packages.first())
        {
            let all = ["depends", "--recurse", "--important", first].map(str::to_owned);
            let needs = self.ask("apt-cache", lists, &all)?;
            llvm = llvm_of(&needs).ok_or_else(|| format!("{first} needs no known LLVM"))?;
        }
        Ok((packages.iter().map(|name| name.replace(LLVM, &llvm)).collect(), llvm))
    }

    /// Downloads, with a bar where stderr is a terminal, else one line.
    fn fetch(
        &self,
        lists: Lists,
        what: &str,
        names: &[String],
        bytes: u64,
        into: &Path,
    ) -> Result<(), String> {
        let (count, size, place) = (names.len(), megabytes(bytes), self.folder.display());
        eprintln!("toolchain: {what}: {count} packages, {size}, into {place}");
        let bar = progress::bytes(bytes, what);
        let mut command = self.command("apt-get", lists);
        command.arg("download").args(names).current_dir(into);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let child = Owned::start(command).map_err(|error| format!("apt-get: {error}"))?;
        let stderr = child.stderr();
        let listener = std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = stderr.map(|mut pipe| pipe.read_to_end(&mut text));
            String::from_utf8_lossy(&text).into_owned()
        });
        let status = loop {
            match child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) => std::thread::sleep(Duration::from_millis(100)),
                Err(error) => return Err(format!("apt-get: {error}")),
            }
            bar.set_position(arrived(into));
        };
        bar.finish_and_clear();
        let said = listener.join().unwrap_or_default();
        if status.success() { Ok(()) } else { Err(cause(&said)) }
    }

    /// What a program of the package manager prints.
    fn ask(&self, program: &str, lists: Lists, arguments: &[String]) -> Result<String, String> {
        let mut command = self.command(program, lists);
        let output = command.args(arguments).output().map_err(|e| format!("{program}: {e}"))?;
        match output.status.success() {
            true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
            false => Err(cause(&String::from_utf8_lossy(&output.stderr))),
        }
    }

    /// Runs it to its end. Gives whether it succeeded, and what it said.
    fn run(
        &self,
        program: &str,
        lists: Lists,
        arguments: &[String],
    ) -> Result<(bool, String), String> {
        let mut command = self.command(program, lists);
        let output = command.args(arguments).output().map_err(|e| format!("{program}: {e}"))?;
        Ok((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
    }

    fn command(&self, program: &str, lists: Lists) -> Command {
        let mut command = Command::new(program);
        command.env("DEBIAN_FRONTEND", "noninteractive").env("LC_ALL", "C").stdin(Stdio::null());
        if program == "apt-get" {
            command.arg("-qq");
        }
        // Root would hand the download to a user who may not write here.
        let mut options = vec![
            ("APT::Sandbox::User", OsString::from("root")),
            ("Dir::Cache", self.folder.join("apt").into()),
            ("Acquire::Languages", "none".into()),
            ("Acquire::Retries", "1".into()),
            ("Acquire::http::Timeout", "20".into()),
            ("Acquire::https::Timeout", "20".into()),
            ("Acquire::IndexTargets::deb::DEP-11::DefaultEnabled", "false".into()),
            ("Acquire::IndexTargets::deb::CNF::DefaultEnabled", "false".into()),
        ];
        if lists != Lists::System {
            options.push(("Dir::State::Lists", self.folder.join("lists").into()));
        }
        for (name, value) in options {
            let mut option = OsString::from(name);
            option.push("=");
            option.push(value);
            command.arg("-o").arg(option);
        }
        command
    }
}

/// How many bytes lie in a folder.
fn arrived(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).filter(|m| m.is_file()).map(|m| m.len()).sum()
}

/// "142 MB"
fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes.div_ceil(1_000_000))
}

/// The packages that a simulation would install.
fn planned(plan: &str) -> Vec<String> {
    let names = plan.lines().filter_map(|line| line.strip_prefix("Inst ")?.split(' ').next());
    names.map(str::to_owned).collect()
}

/// The files of `--print-uris`: each line has the address in quotes, the file's name, its size and its hash.
fn parcels(uris: &str) -> Vec<Parcel> {
    let parcel = |line: &str| {
        let (_, rest) = line.strip_prefix('\'')?.split_once("' ")?;
        let mut words = rest.split(' ');
        let (file, bytes) = (words.next()?, words.next()?.parse().ok()?);
        Some(Parcel { file: file.into(), bytes })
    };
    uris.lines().filter_map(parcel).collect()
}

/// The version of LLVM among the packages that a package needs.
fn llvm_of(needs: &str) -> Option<String> {
    let versions = needs.lines().filter_map(|line| {
        let (_, name) = line.split_once("Depends: libllvm")?;
        name.chars().all(|c| c.is_ascii_digit()).then_some(name)
    });
    versions.filter(|version| !version.is_empty()).map(str::to_owned).next()
}

/// The line that says that there is no network.
fn unreached(said: &str) -> Option<String> {
    let line = said.lines().find(|line| UNREACHED_WORDS.iter().any(|why| line.contains(why)))?;
    // The address is as long as a line, and says no more than its host.
    let words = line.trim_start_matches(['E', 'W', ':', ' ']);
    let words = words
        .strip_prefix("Failed to fetch ")
        .map_or(words, |rest| rest.split_once(' ').map_or(rest, |(_, why)| why.trim_start()));
    Some(format!("{NO_NETWORK}{words}"))
}

/// Why apt-get failed, in a line.
fn cause(said: &str) -> String {
    let error = || said.lines().rev().find(|line| line.starts_with("E:")).map(str::to_owned);
    unreached(said).or_else(error).unwrap_or_else(|| "apt-get failed".into())
}

/// The error that names the command which installs these packages.
pub(super) fn missing(what: &str, packages: &[&str], reason: Option<String>) -> ToolError {
    const OTHERS: [(&str, &str); 5] = [
        ("dnf", "sudo dnf install"),
        ("zypper", "sudo zypper install"),
        ("pacman", "sudo pacman -S"),
        ("apk", "sudo apk add"),
        ("brew", "brew install"),
    ];
    let packages = packages.join(" ");
    let other = OTHERS.iter().find(|(program, _)| on_path(program).is_some());
    let command = match other {
        Some((_, command)) if on_path("apt-get").is_none() => format!("{command} {packages}"),
        _ => format!("sudo apt-get install {packages}"),
    };
    ToolError::Missing { what: what.into(), command, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_tool_names_the_command() {
        let error = missing("qemu-system-arm", &["qemu-system-arm"], Some("no network".into()));
        let text = error.to_string();
        assert!(text.contains("qemu-system-arm") && text.contains("no network"), "{text}");
        assert!(!text.contains('\n'), "{text}");
    }

    #[test]
    fn addresses_have_names_and_sizes() {
        let uris = "'http://deb.debian.org/a/lld-22_22.1.8-1%7edeb12u1_amd64.deb' lld-22_1%3a22.1.8-1~deb12u1_amd64.deb 1487860 SHA256:1310\n\
                    W: a line of something else\n\
                    'file:/srv/x y/b_1_all.deb' b_1_all.deb 7 \n";
        let parcel = |file: &str, bytes| Parcel { file: file.into(), bytes };
        let expected =
            [parcel("lld-22_1%3a22.1.8-1~deb12u1_amd64.deb", 1_487_860), parcel("b_1_all.deb", 7)];
        assert_eq!(parcels(uris), expected);
        assert_eq!(parcels(""), []);
    }

    #[test]
    fn a_simulation_tells_what_would_be_installed() {
        let plan = "NOTE: This is only a simulation!\nRemv rustc [1.63]\n\
                    Inst libllvm22 (1:22.1.8 Debian-Security:12 [amd64])\n\
                    Inst rustc-web [1.85] (1.96 Debian-Security:12 [amd64])\nConf libllvm22\n";
        assert_eq!(planned(plan), ["libllvm22", "rustc-web"]);
    }

    #[test]
    fn the_linker_is_of_the_compilers_llvm() {
        let needs = "rustc-web\n  Depends: libc6\n  Depends: libllvm-dev\n  Depends: libllvm22\n";
        assert_eq!(llvm_of(needs).as_deref(), Some("22"));
        assert_eq!(llvm_of("rustc\n  Depends: gcc\n"), None);
    }

    #[test]
    fn no_network_is_told_from_other_causes() {
        let said = "W: Failed to fetch http://deb.debian.org/debian/dists/bookworm/InRelease  Temporary failure resolving 'deb.debian.org'\n\
                    W: Some index files failed to download.";
        let cause_of = |said| cause(said);
        assert_eq!(cause_of(said), "no network: Temporary failure resolving 'deb.debian.org'");
        assert_eq!(
            cause("E: one\nE: Unable to locate package x\n"),
            "E: Unable to locate package x"
        );
        assert!(unreached("W: Some index files failed to download.").is_none());
        assert!(!cause("").is_empty());
    }
}
