//! The page's files, in one folder, and a server of them.

use crate::toolchain::{ToolError, build_page, io_error, page_directory, workspace};
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// The files of the page beside its modules, and what they are.
pub const FILES: [(&str, &str); 15] = [
    ("index.html", HTML),
    ("style.css", CSS),
    ("icon.svg", "image/svg+xml"),
    ("main.js", SCRIPT),
    ("core.js", SCRIPT),
    ("charts.js", SCRIPT),
    ("waterfall.js", SCRIPT),
    ("controls.js", SCRIPT),
    ("sources.js", SCRIPT),
    ("save.js", SCRIPT),
    ("tones.js", SCRIPT),
    ("words.js", SCRIPT),
    ("vendor/uPlot.iife.min.js", SCRIPT),
    ("vendor/uPlot.min.css", CSS),
    ("vendor/uPlot-LICENSE", "text/plain; charset=utf-8"),
];
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
/// The modules: all that the page does, and what finds several tones, which is loaded when that is wanted.
pub const MODULES: [(&str, &str); 2] = [("picket.wasm", WASM), ("tones.wasm", WASM)];
const WASM: &str = "application/wasm";

/// The built page.
#[derive(Clone, Debug)]
pub struct Site {
    folder: PathBuf,
}

impl Site {
    /// Builds the module and puts all files into `target/web/page`.
    ///
    /// # Errors
    /// A tool is missing, or the module does not build.
    pub fn build() -> Result<Self, ToolError> {
        let modules = build_page()?;
        let folder = page_directory().join("page");
        let copy = |from: &Path, name: &str| {
            let to = folder.join(name);
            let parent = to.parent().unwrap_or(&folder);
            fs::create_dir_all(parent).map_err(io_error(parent.display()))?;
            fs::copy(from, &to).map_err(io_error(from.display())).map(drop)
        };
        for (module, (name, _)) in modules.iter().zip(MODULES) {
            copy(module, name)?;
        }
        for (name, _) in FILES {
            copy(&workspace().join("web/page").join(name), name)?;
        }
        Ok(Site { folder })
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Serves it on this port of localhost, or on any that is free for 0, until it is dropped.
    ///
    /// # Errors
    /// The port is taken.
    pub fn serve(&self, port: u16) -> Result<Served, ToolError> {
        let taken = || io_error(format!("port {port} (choose another by --port)"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(taken())?;
        let address = listener.local_addr().map_err(taken())?;
        let over = Arc::new(AtomicBool::new(false));
        let (folder, ends) = (self.folder.clone(), Arc::clone(&over));
        let thread = thread::spawn(move || {
            for stream in listener.incoming() {
                if ends.load(Ordering::SeqCst) {
                    break;
                }
                let folder = folder.clone();
                // A browser opens several at once, some only in case. One that has gone needs no answer.
                thread::spawn(move || stream.and_then(|stream| answer(&stream, &folder)));
            }
        });
        Ok(Served { address, over, thread: Some(thread) })
    }
}

/// The longest request that is read, bytes.
const LONGEST: u64 = 1 << 14;

/// Answers one request. A connection for each is enough for a page of 17 files on the same machine.
fn answer(mut stream: &TcpStream, folder: &Path) -> io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut lines = BufReader::new(stream).take(LONGEST).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    // Its headers say nothing that matters here.
    while lines.next().transpose()?.is_some_and(|line| !line.is_empty()) {}
    let found = match request.split(' ').collect::<Vec<_>>()[..] {
        ["GET", url, _] => file(folder, url),
        _ => None,
    };
    let (status, bytes, kind) = match found {
        Some((bytes, kind)) => ("200 OK", bytes, kind),
        None => ("404 Not Found", b"no such file\n".to_vec(), "text/plain"),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
        bytes.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(&bytes)
}

/// A file of the page by its address; nothing else is served.
fn file(folder: &Path, url: &str) -> Option<(Vec<u8>, &'static str)> {
    let path = url.split(['?', '#']).next()?.trim_start_matches('/');
    let path = if path.is_empty() { "index.html" } else { path };
    let (name, kind) = FILES.into_iter().chain(MODULES).find(|(name, _)| *name == path)?;
    Some((fs::read(folder.join(name)).ok()?, kind))
}

/// A running server.
#[derive(Debug)]
pub struct Served {
    address: SocketAddr,
    over: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Served {
    /// What to open.
    pub fn address(&self) -> String {
        format!("http://{}/", self.address)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        // A last connection wakes it.
        let _ = TcpStream::connect(self.address);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
