//! The page's files, in one folder, and a server of them.

use crate::toolchain::{ToolError, build_page, io_error, page_directory, workspace};
use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// The files of the page beside its modules, and what they are.
pub const FILES: [(&str, &str); 19] = [
    ("index.html", HTML),
    ("style.css", CSS),
    ("icon.svg", "image/svg+xml"),
    ("main.js", SCRIPT),
    ("core.js", SCRIPT),
    ("charts.js", SCRIPT),
    ("waterfall.js", SCRIPT),
    ("controls.js", SCRIPT),
    ("sources.js", SCRIPT),
    ("map.js", SCRIPT),
    ("microphone.js", SCRIPT),
    ("design.js", SCRIPT),
    ("save.js", SCRIPT),
    ("tones.js", SCRIPT),
    ("words.js", SCRIPT),
    ("write.js", SCRIPT),
    ("vendor/uPlot.iife.min.js", SCRIPT),
    ("vendor/uPlot.min.css", CSS),
    ("vendor/uPlot-LICENSE", TEXT),
];
const TEXT: &str = "text/plain; charset=utf-8";
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
/// The modules: the page's own, and the one for several tones, which is loaded on demand.
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
    /// A file is missing, or the port is taken.
    pub fn serve(&self, port: u16) -> Result<Served, ToolError> {
        let files = Arc::new(self.files()?);
        let taken = || io_error(format!("port {port} (choose another by --port)"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(taken())?;
        let address = listener.local_addr().map_err(taken())?;
        let over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&over);
        let thread = thread::spawn(move || {
            let mut connections = Connections::default();
            for stream in listener.incoming() {
                if ends.load(Ordering::SeqCst) {
                    break;
                }
                connections.make_room();
                // No descriptor may be left: the ones that wait are closed, one each time.
                let Ok(stream) = stream else {
                    connections.close_one();
                    continue;
                };
                let (connection, files) = (connections.open(stream), Arc::clone(&files));
                // A browser opens several at once, some only in case. One that has gone needs no answer.
                thread::spawn(move || {
                    let _ = connection.answer(&files);
                    // Its descriptor is held until the next connection comes: the browser need not wait for that.
                    let _ = connection.stream.shutdown(Shutdown::Both);
                });
            }
        });
        Ok(Served { address, over, thread: Some(thread) })
    }

    /// All files with their names and kinds. A connection then takes one descriptor and no more.
    fn files(&self) -> Result<Vec<File>, ToolError> {
        let read = |(name, kind)| {
            let path = self.folder.join(name);
            let bytes = fs::read(&path).map_err(io_error(path.display()))?;
            Ok(File { name, kind, bytes })
        };
        FILES.into_iter().chain(MODULES).map(read).collect()
    }
}

/// A file of the page.
struct File {
    name: &'static str,
    kind: &'static str,
    bytes: Vec<u8>,
}

/// The longest request that is read, bytes.
const LONGEST: usize = 1 << 14;
/// A request is read, and an answer written, within this time.
const PATIENCE: Duration = Duration::from_secs(10);
/// Connections at once. A browser opens six for each of its windows.
const MOST: usize = 48;

/// What the page may load and do: its own files, its own modules, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self'; connect-src 'self'; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The connections that are open, the oldest first.
#[derive(Default)]
struct Connections(Vec<Arc<Connection>>);

impl Connections {
    fn open(&mut self, stream: TcpStream) -> Arc<Connection> {
        let connection = Arc::new(Connection { stream, asked: AtomicBool::new(false) });
        self.0.push(Arc::clone(&connection));
        connection
    }

    /// Waits until there are fewer than the most.
    fn make_room(&mut self) {
        self.forget();
        while self.0.len() >= MOST {
            self.close_one();
        }
    }

    /// Closes the oldest connection that has not asked for anything yet; where each has, one of them ends soon.
    fn close_one(&mut self) {
        if let Some(at) = self.0.iter().position(|open| !open.asked.load(Ordering::SeqCst)) {
            let _ = self.0.remove(at).stream.shutdown(Shutdown::Both);
        }
        thread::sleep(Duration::from_millis(5));
        self.forget();
    }

    /// Leaves out the ones that have ended: nobody else holds them.
    fn forget(&mut self) {
        self.0.retain(|open| Arc::strong_count(open) > 1);
    }
}

struct Connection {
    stream: TcpStream,
    /// The request is complete.
    asked: AtomicBool,
}

impl Connection {
    /// Answers one request. A connection for each is enough for a page of few files on the same machine.
    fn answer(&self, files: &[File]) -> io::Result<()> {
        let request = self.request()?;
        self.asked.store(true, Ordering::SeqCst);
        let found = files.iter().find(|file| request.wants(file.name));
        let (status, kind, bytes) = match found {
            _ if !request.local => {
                ("403 Forbidden", TEXT, b"this page is for its own machine\n".as_slice())
            }
            Some(file) => ("200 OK", file.kind, &file.bytes[..]),
            None => ("404 Not Found", TEXT, b"no such file\n".as_slice()),
        };
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}\r\n\
             X-Content-Type-Options: nosniff\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
            bytes.len()
        );
        self.stream.set_write_timeout(Some(PATIENCE))?;
        (&self.stream).write_all(head.as_bytes())?;
        (&self.stream).write_all(bytes)
    }

    /// The request, when all of it has come.
    fn request(&self) -> io::Result<Request> {
        let until = Instant::now() + PATIENCE;
        let (mut bytes, mut piece) = (Vec::new(), [0; 1024]);
        while bytes.len() < LONGEST {
            let left = until.saturating_duration_since(Instant::now());
            // Of no time at all a socket makes an error, of a short one a timeout.
            self.stream.set_read_timeout(Some(left.max(Duration::from_millis(1))))?;
            let length = (&self.stream).read(&mut piece)?;
            if length == 0 || left.is_zero() {
                return Err(ErrorKind::UnexpectedEof.into());
            }
            bytes.extend_from_slice(&piece[..length]);
            if let Some(request) = Request::from_bytes(&bytes)? {
                return Ok(request);
            }
        }
        Err(ErrorKind::InvalidData.into())
    }
}

/// A request for a file.
struct Request {
    /// The path, if something is to be read.
    path: Option<String>,
    /// By one of this machine's own names. A name of somebody else's that leads here is a trick of a page elsewhere.
    local: bool,
}

impl Request {
    /// None if its end has not come.
    fn from_bytes(bytes: &[u8]) -> io::Result<Option<Self>> {
        let mut headers = [httparse::EMPTY_HEADER; 64];
        let mut request = httparse::Request::new(&mut headers);
        let status = request.parse(bytes).map_err(|_| io::Error::from(ErrorKind::InvalidData))?;
        if status.is_partial() {
            return Ok(None);
        }
        let path = request.path.filter(|_| request.method == Some("GET")).map(str::to_string);
        let mut hosts =
            request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case("host"));
        let local = hosts.next().is_some_and(|host| local(host.value)) && hosts.next().is_none();
        Ok(Some(Self { path, local }))
    }

    fn wants(&self, name: &str) -> bool {
        let path =
            self.path.as_deref().and_then(|path| path.split(['?', '#']).next()).unwrap_or("");
        let wanted = path.strip_prefix('/');
        wanted == Some(name) || (wanted == Some("") && name == "index.html")
    }
}

/// Whether a Host header names this machine, with or without a port.
fn local(host: &[u8]) -> bool {
    let host = str::from_utf8(host).unwrap_or("");
    let name =
        host.rsplit_once(':').filter(|(_, port)| port.bytes().all(|byte| byte.is_ascii_digit()));
    matches!(name.map_or(host, |(name, _)| name), "127.0.0.1" | "localhost")
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    /// A site of short files.
    fn site() -> (tempfile::TempDir, Site) {
        let folder = tempfile::tempdir().unwrap();
        for (name, _) in FILES.into_iter().chain(MODULES) {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name).unwrap();
        }
        let site = Site { folder: folder.path().into() };
        (folder, site)
    }

    /// What is answered to these bytes.
    fn said(address: &str, request: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn get(address: &str, path: &str) -> String {
        said(address, &format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n"))
    }

    fn port_of(served: &str) -> String {
        served.trim_start_matches("http://").trim_end_matches('/').into()
    }

    #[test]
    fn only_the_pages_files_are_served_and_to_its_own_machine() {
        let (_folder, site) = site();
        let served = site.serve(0).unwrap();
        let address = port_of(&served.address());
        for (path, name) in
            [("/", "index.html"), ("/main.js?x", "main.js"), ("/picket.wasm", "picket.wasm")]
        {
            let answer = get(&address, path);
            assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
            assert!(answer.ends_with(&format!("\r\n\r\n{name}")), "{answer}");
            for header in
                ["Content-Security-Policy: default-src 'none';", "X-Content-Type-Options: nosniff"]
            {
                assert!(answer.contains(header), "{answer}");
            }
        }
        for path in ["/../Cargo.toml", "//main.js", "/vendor", "main.js", "/%6dain.js"] {
            assert!(get(&address, path).starts_with("HTTP/1.1 404"), "{path}");
        }
        let port = address.rsplit(':').next().unwrap();
        for host in [format!("localhost:{port}"), "127.0.0.1".into()] {
            assert!(
                said(&address, &format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"))
                    .contains("200 OK")
            );
        }
        for head in [
            "Host: evil.example\r\n",
            "",
            "Host: localhost.evil.example:80\r\n",
            "Host: localhost\r\nHost: evil\r\n",
        ] {
            let answer = said(&address, &format!("GET / HTTP/1.1\r\n{head}\r\n"));
            assert!(answer.starts_with("HTTP/1.1 403"), "{head}: {answer}");
        }
        assert!(
            said(&address, "PUT / HTTP/1.1\r\nHost: localhost\r\n\r\n").starts_with("HTTP/1.1 404")
        );
        assert_eq!(said(&address, "\0\x01 nonsense\r\n\r\n"), "");
    }

    /// The server of the test below, in a process of its own.
    #[test]
    #[ignore = "it serves until it is killed"]
    fn a_server() {
        let (_folder, site) = site();
        let served = site.serve(0).unwrap();
        println!("{}", served.address());
        thread::sleep(Duration::from_secs(60));
    }

    /// With 64 descriptors it serves a browser's windows while 100 connections say nothing and others speak by halves.
    #[test]
    fn idle_connections_keep_nobody_out() {
        let program = std::env::current_exe().unwrap();
        let script =
            "ulimit -n 64; exec \"$0\" --ignored --exact web::site::tests::a_server --nocapture";
        let mut command = Command::new("sh");
        command.args(["-c", script]).arg(program).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let address =
            lines.find_map(|line| line.unwrap().split("http://").nth(1).map(port_of)).unwrap();
        let mut idle = Vec::new();
        for number in 0..100 {
            let mut stream = TcpStream::connect(&address).unwrap();
            if number % 2 == 0 {
                stream.write_all(b"GET / HTTP/1.1\r\nHost: loc").unwrap();
            }
            idle.push(stream);
        }
        for _ in 0..20 {
            assert!(get(&address, "/").ends_with("index.html"));
        }
        // Seven windows of six connections, each of which comes before any asks.
        drop(idle);
        let mut windows: Vec<_> = (0..42).map(|_| TcpStream::connect(&address).unwrap()).collect();
        for stream in windows.iter_mut().rev() {
            stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
            stream
                .write_all(format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())
                .unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).unwrap();
            assert!(answer.ends_with("index.html"), "{answer}");
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
