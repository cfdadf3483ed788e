//! The drive by which a board takes an image: a Pico that waits for a program, a NUCLEO's programmer at any time.

use super::{Board, FlashError};
use crate::toolchain::io_error;
use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where systems mount drives: the folder of all, or those of each user.
const MOUNTS: [&str; 4] = ["/media", "/run/media", "/Volumes", "/mnt"];

/// The board's drive, if one is mounted.
pub fn find(board: Board) -> Option<PathBuf> {
    if cfg!(windows) {
        let letters = ('D'..='Z').map(|letter| PathBuf::from(format!("{letter}:\\")));
        return letters.into_iter().find(|drive| is_of(board, drive));
    }
    MOUNTS.iter().find_map(|folder| find_in(board, Path::new(folder), 2))
}

/// The drive within a folder, up to `levels` levels deep.
fn find_in(board: Board, folder: &Path, levels: u32) -> Option<PathBuf> {
    let entries = fs::read_dir(folder).ok()?.flatten();
    entries.map(|entry| entry.path()).find_map(|path| {
        if is_of(board, &path) {
            return Some(path);
        }
        if levels > 1 { find_in(board, &path, levels - 1) } else { None }
    })
}

/// Whether a folder is this board's drive, by the file in which the drive describes itself.
fn is_of(board: Board, folder: &Path) -> bool {
    let (file, mark) = match board {
        Board::Pico => ("INFO_UF2.TXT", "RPI-RP2"),
        // ST's programmer names its board by the first four digits of a code: 0777 is the NUCLEO-F446RE.
        Board::Nucleo => ("MBED.HTM", "code=0777"),
    };
    // No drive of a board holds a long file of this name.
    fs::read(folder.join(file)).is_ok_and(|text| String::from_utf8_lossy(&text).contains(mark))
}

/// The time in which a NUCLEO's programmer writes an image and says what failed.
const WRITES: Duration = Duration::from_secs(8);

/// Copies an image to a board's drive, by the image's own name.
pub fn copy(board: Board, image: &Path, drive: &Path) -> Result<(), FlashError> {
    let to = drive.join(image.file_name().map_or_else(|| OsString::from("picket"), Into::into));
    let failed = drive.join("FAIL.TXT");
    let before = fs::read(&failed).ok();
    fs::copy(image, &to).map_err(io_error(to.display()))?;
    // The drive goes away once it has all of it: what it says of the last write is no error.
    let _ = File::open(&to).and_then(|file| file.sync_all());
    let begun = Instant::now();
    while board == Board::Nucleo && to.exists() && begun.elapsed() < WRITES {
        let said = fs::read(&failed).ok().filter(|said| before.as_ref() != Some(said));
        if let Some(said) = said {
            return Err(FlashError::Drive(String::from_utf8_lossy(&said).trim().into()));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_boards_drive_is_found_among_others() {
        let folder = tempfile::tempdir().unwrap();
        let user = folder.path().join("user");
        let page = |code: &str| format!("<a href=\"http://mbed.org/device/?code={code}0221\">");
        for (name, file, about) in [
            ("STICK", "INFO_UF2.TXT", "a stick".into()),
            ("RPI-RP2", "INFO_UF2.TXT", "UF2 Bootloader v3.0\nBoard-ID: RPI-RP2\n".into()),
            ("NODE_F411RE", "MBED.HTM", page("0740")),
            ("NODE_F446RE", "MBED.HTM", page("0777")),
        ] {
            fs::create_dir_all(user.join(name)).unwrap();
            fs::write(user.join(name).join(file), about).unwrap();
        }
        for (board, name) in [(Board::Pico, "RPI-RP2"), (Board::Nucleo, "NODE_F446RE")] {
            let drive = find_in(board, folder.path(), 2).unwrap();
            assert_eq!(drive, user.join(name));
            assert_eq!(find_in(board, folder.path(), 1), None);
        }
        let drive = user.join("RPI-RP2");
        for name in ["picket-pico.uf2", "picket-other.uf2"] {
            let file = folder.path().join(name);
            fs::write(&file, name).unwrap();
            copy(Board::Pico, &file, &drive).unwrap();
            assert_eq!(fs::read(drive.join(name)).unwrap(), name.as_bytes());
        }
    }

    /// A NUCLEO's programmer takes the file away, or says why not.
    #[test]
    fn what_the_programmer_says_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let (image, drive) = (folder.path().join("picket-nucleo.bin"), folder.path().join("drive"));
        fs::write(&image, b"image").unwrap();
        fs::create_dir(&drive).unwrap();
        fs::write(drive.join("FAIL.TXT"), "of the last time").unwrap();
        for (says, holds) in [(None, true), (Some("Flash write error"), false)] {
            let programmer = std::thread::scope(|scope| {
                let copying = scope.spawn(|| copy(Board::Nucleo, &image, &drive));
                let taken = drive.join("picket-nucleo.bin");
                while !taken.exists() && !copying.is_finished() {
                    std::thread::sleep(Duration::from_millis(5));
                }
                match says {
                    Some(text) => fs::write(drive.join("FAIL.TXT"), text).unwrap(),
                    None => fs::remove_file(&taken).unwrap(),
                }
                copying.join().unwrap()
            });
            assert_eq!(programmer.is_ok(), holds);
            if let Err(error) = programmer {
                assert!(error.to_string().contains("Flash write error"), "{error}");
            }
        }
    }
}
