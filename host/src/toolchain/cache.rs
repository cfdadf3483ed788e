//! Where downloaded programs are kept.

use super::target_dir;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The folder for downloaded programs: in the user's cache, so that `cargo clean` leaves them, or else below `target`. Each system
/// has its own, since programs take what is installed from it.
pub(super) fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let (xdg, home) = (std::env::var_os("XDG_CACHE_HOME"), std::env::var_os("HOME"));
        let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
        let name = system(&release, std::env::consts::ARCH);
        let place = |folder: PathBuf| folder.join(&name);
        let users = users(xdg, home).map(place).filter(|folder| takes_files(folder));
        users.unwrap_or_else(|| place(target_dir().join("tools")))
    })
}

/// `picket` in the user's cache folder, after the XDG base directory specification: a relative path is none.
fn users(xdg: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |path: OsString| Some(PathBuf::from(path)).filter(|path| path.is_absolute());
    let cache = xdg.and_then(absolute);
    let cache = cache.or_else(|| Some(home.and_then(absolute)?.join(".cache")))?;
    Some(cache.join("picket"))
}

/// Whether a file can be made in a folder, which is made if it is not there.
fn takes_files(folder: &Path) -> bool {
    fs::create_dir_all(folder).is_ok() && tempfile::tempfile_in(folder).is_ok()
}

/// "debian-12-x86_64"
fn system(release: &str, machine: &str) -> String {
    let value = |key: &str| {
        let line = release.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='))?;
        Some(line.trim_matches('"').replace('/', "-")).filter(|value| !value.is_empty())
    };
    let parts = [value("ID"), value("VERSION_ID"), Some(machine.into())];
    parts.into_iter().flatten().collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_cache_is_where_the_specification_says() {
        let of = |xdg: Option<&str>, home: Option<&str>| {
            users(xdg.map(Into::into), home.map(Into::into)).map(|path| path.display().to_string())
        };
        assert_eq!(of(Some("/c a/ü"), Some("/h")).as_deref(), Some("/c a/ü/picket"));
        assert_eq!(of(None, Some("/h")).as_deref(), Some("/h/.cache/picket"));
        assert_eq!(of(Some(""), Some("/h")).as_deref(), Some("/h/.cache/picket"));
        assert_eq!(of(Some("relative"), Some("/h")).as_deref(), Some("/h/.cache/picket"));
        assert_eq!(of(None, None), None);
        assert_eq!(of(None, Some("")), None);
    }

    #[test]
    fn a_place_that_takes_no_files_is_none() {
        let folder = tempfile::tempdir().unwrap();
        assert!(takes_files(&folder.path().join("new/ä b")));
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(!takes_files(&file.join("below")));
    }

    #[test]
    fn each_system_has_its_own() {
        let debian =
            "PRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\nVERSION_ID=\"12\"\nID=debian\n";
        assert_eq!(system(debian, "aarch64"), "debian-12-aarch64");
        assert_eq!(system("ID=debian\n", "x86_64"), "debian-x86_64");
        assert_eq!(system("", "x86_64"), "x86_64");
    }
}
