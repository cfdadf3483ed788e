//! The page's files, in one folder, and a server of them.

use crate::toolchain::{ToolError, build_page, io_error, page_directory, workspace};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use tiny_http::{Header, Method, Response, Server};

/// The files of the page beside `picket.wasm`, and what they are.
pub const FILES: [(&str, &str); 14] = [
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
    ("words.js", SCRIPT),
    ("vendor/uPlot.iife.min.js", SCRIPT),
    ("vendor/uPlot.min.css", CSS),
    ("vendor/uPlot-LICENSE", "text/plain; charset=utf-8"),
];
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const MODULE: (&str, &str) = ("picket.wasm", "application/wasm");

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
        let module = build_page()?;
        let folder = page_directory().join("page");
        let copy = |from: &Path, name: &str| {
            let to = folder.join(name);
            let parent = to.parent().unwrap_or(&folder);
            fs::create_dir_all(parent).map_err(io_error(parent.display()))?;
            fs::copy(from, &to).map_err(io_error(from.display())).map(drop)
        };
        copy(&module, MODULE.0)?;
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
        let taken = |error| {
            io_error(format!("port {port} (choose another by --port)"))(std::io::Error::other(error))
        };
        let server = Arc::new(Server::http(("127.0.0.1", port)).map_err(taken)?);
        let (folder, listening) = (self.folder.clone(), Arc::clone(&server));
        let thread = thread::spawn(move || {
            for request in listening.incoming_requests() {
                let answer = match request.method() {
                    Method::Get | Method::Head => file(&folder, request.url()),
                    _ => None,
                };
                // A browser that has gone needs no answer.
                let _ = match answer {
                    Some((bytes, kind)) => request.respond(with(Response::from_data(bytes), kind)),
                    None => request.respond(Response::from_string("no such file\n").with_status_code(404)),
                };
            }
        });
        Ok(Served { server, thread: Some(thread) })
    }
}

fn with<R: std::io::Read>(response: Response<R>, kind: &str) -> Response<R> {
    let headers = [("Content-Type", kind), ("Cache-Control", "no-cache")];
    let headers = headers.iter().filter_map(|(name, value)| Header::from_bytes(*name, *value).ok());
    headers.fold(response, Response::with_header)
}

/// A file of the page by its address; nothing else is served.
fn file(folder: &Path, url: &str) -> Option<(Vec<u8>, &'static str)> {
    let path = url.split(['?', '#']).next()?.trim_start_matches('/');
    let path = if path.is_empty() { "index.html" } else { path };
    let (name, kind) = FILES.into_iter().chain([MODULE]).find(|(name, _)| *name == path)?;
    Some((fs::read(folder.join(name)).ok()?, kind))
}

/// A running server.
pub struct Served {
    server: Arc<Server>,
    thread: Option<thread::JoinHandle<()>>,
}

impl std::fmt::Debug for Served {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Served({})", self.address())
    }
}

impl Served {
    /// What to open.
    pub fn address(&self) -> String {
        let port = self.server.server_addr().to_ip().map_or(0, |address| address.port());
        format!("http://localhost:{port}/")
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.server.unblock();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
