//! Shutdown: ends child processes and removes temporary folders, on exit and on signals.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};

/// The signal that asked for the end; 0 for none.
static ASKED: AtomicI32 = AtomicI32::new(0);
/// Whether the command looks at [`asked`] by itself and ends in its own way.
static LOOKS: AtomicBool = AtomicBool::new(false);
static CHILDREN: Mutex<Vec<Arc<Mutex<Child>>>> = Mutex::new(Vec::new());
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// What a command that looks may take for its own end.
const GRACE: Duration = Duration::from_secs(2);

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins to listen for Ctrl-C (SIGINT) and SIGTERM.
pub fn listen() {
    // Without it the signals end the program as they always do.
    let Ok(wait) = signals() else { return };
    std::thread::spawn(move || {
        if let Some(signal) = wait() {
            ASKED.store(signal, Ordering::SeqCst);
            if LOOKS.load(Ordering::SeqCst) {
                std::thread::sleep(GRACE);
            }
            leave(128 + signal);
        }
    });
}

/// What waits for the first signal, and gives it.
#[cfg(unix)]
fn signals() -> io::Result<impl FnOnce() -> Option<i32> + Send> {
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    Ok(move || signals.forever().next())
}

/// What waits for the first signal, and gives it: Windows has no way to wait for one.
#[cfg(not(unix))]
fn signals() -> io::Result<impl FnOnce() -> Option<i32> + Send> {
    let seen = Arc::new(std::sync::atomic::AtomicUsize::new(0));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register_usize(signal, seen.clone(), signal as usize)?;
    }
    Ok(move || {
        loop {
            match seen.load(Ordering::SeqCst) {
                0 => std::thread::sleep(Duration::from_millis(50)),
                signal => return Some(signal as i32),
            }
        }
    })
}

/// The signal that asked for the end, if one did.
pub fn asked() -> Option<i32> {
    Some(ASKED.load(Ordering::SeqCst)).filter(|&signal| signal != 0)
}

/// From now on the command looks at [`asked`] at least every second.
pub fn look() {
    LOOKS.store(true, Ordering::SeqCst);
}

/// Ends the program at once.
pub fn leave(code: i32) -> ! {
    for child in locked(&CHILDREN).iter() {
        // It may have ended by itself.
        let _ = locked(child).kill();
    }
    for folder in locked(&FOLDERS).iter() {
        let _ = std::fs::remove_dir_all(folder);
    }
    std::process::exit(code)
}

/// A folder that goes with the program.
pub fn takes_along(folder: &Path) {
    locked(&FOLDERS).push(folder.into());
}

/// A program that ends with its owner, and with this program.
#[derive(Debug)]
pub struct Owned(Arc<Mutex<Child>>);

impl Owned {
    /// Starts a program. On Linux the kernel ends it with the thread that calls this, however that ends (SIGKILL): the thread
    /// has to stay until the program has ended. Elsewhere a killed program leaves its children behind.
    ///
    /// # Errors
    /// It does not start.
    pub fn start(mut command: Command) -> io::Result<Self> {
        tie(&mut command);
        let child = Arc::new(Mutex::new(command.spawn()?));
        locked(&CHILDREN).push(child.clone());
        Ok(Owned(child))
    }

    /// Its input, if that is a pipe and not yet taken.
    pub fn stdin(&self) -> Option<ChildStdin> {
        locked(&self.0).stdin.take()
    }

    /// Its output, likewise.
    pub fn stdout(&self) -> Option<ChildStdout> {
        locked(&self.0).stdout.take()
    }

    /// Its errors, likewise.
    pub fn stderr(&self) -> Option<ChildStderr> {
        locked(&self.0).stderr.take()
    }

    /// How it ended, if it did.
    pub fn try_wait(&self) -> io::Result<Option<ExitStatus>> {
        locked(&self.0).try_wait()
    }

    /// Waits for its end.
    pub fn wait(&self) -> io::Result<ExitStatus> {
        loop {
            match self.try_wait()? {
                Some(status) => return Ok(status),
                None => std::thread::sleep(Duration::from_millis(2)),
            }
        }
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        locked(&CHILDREN).retain(|child| !Arc::ptr_eq(child, &self.0));
        let mut child = locked(&self.0);
        // Both fail only for a process that has ended and been waited for.
        let _ = child.kill();
        let _ = child.wait();
    }
}

#[cfg(target_os = "linux")]
fn tie(command: &mut Command) {
    use rustix::process::{Signal, getpid, getppid, set_parent_process_death_signal};
    use std::os::unix::process::CommandExt;
    let parent = getpid();
    let tied = move || {
        set_parent_process_death_signal(Some(Signal::KILL))?;
        // The parent may have ended before.
        match getppid() == Some(parent) {
            true => Ok(()),
            false => Err(io::ErrorKind::NotFound.into()),
        }
    };
    // SAFETY: between fork and exec it makes two calls of the system; it neither allocates nor takes a lock.
    unsafe { command.pre_exec(tied) };
}

#[cfg(not(target_os = "linux"))]
fn tie(_: &mut Command) {}
