//! Every command of the documents: README, the pages in docs/ and the recipes. What can run here is run as it stands there, from a clean folder;
//! the others are at least commands that exist. What they print is compared where it is a figure: by `lab docs`.

use crate::calibrate::BENCH;
use crate::cli::{fresh, recorded, tones};
use clap::Parser;
use picket_host::cli::Picket;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Beginnings of commands that cannot run here, and why.
const LEFT_OUT: [(&str, &str); 19] = [
    ("git clone", "it fetches the repository; this test is in a clone"),
    ("cargo lab", "it is the developers' program; lab/tests runs its commands"),
    (
        "cargo picket flash --dry-run",
        "tests/device.rs builds the image; host-tests compares its sizes",
    ),
    ("cargo picket doctor", "there is no board; tests/line.rs asks emulated ones"),
    ("cargo picket watch /dev/", "there is no board; tests/device.rs plays one"),
    ("cargo picket calibrate /dev/", "there is no board; tests/calibrate.rs plays one"),
    ("cargo picket flash", "it would write to a board"),
    ("cargo picket web", "it serves for ever; host-tests/tests/web.rs opens the page in a browser"),
    ("qemu-system-arm", "its image is the reader's; host-tests/tests/dependents.rs runs ours"),
    ("cargo add", "it belongs to a project of the reader's"),
    (
        "cargo build --release --target",
        "it builds a package outside the workspace; host-tests/tests/dependents.rs builds all of them",
    ),
    (
        "python python/examples/folder.py",
        "it needs a cluster's packages; host-tests/tests/python.rs runs it",
    ),
    ("rustup target add", "it changes the reader's toolchain"),
    ("probe-rs run", "there is no board"),
    ("cargo test", "it is what runs this"),
    (
        "pip install",
        "it changes the reader's Python; host-tests/tests/python.rs installs the wheel",
    ),
    ("jupyter nbconvert", "it needs a notebook's packages; host-tests/tests/python.rs runs it"),
    (
        "cargo picket demo --board pico --replay car.bin",
        "the reader's recording; host-tests/tests/pico/demo.rs replays one",
    ),
    ("cargo picket demo --replay car.bin", "the reader's recording; tests/demo.rs replays one"),
];

/// Beginnings of commands that take minutes, and who runs what is in them.
const LONG: [(&str, &str); 5] = [
    ("cargo picket flash --board pico --dry-run", "host-tests/tests/pico.rs builds the image"),
    ("cargo picket demo --board pico", "host-tests/tests/pico.rs runs it"),
    ("cargo picket web --build", "host-tests/tests/web.rs builds the page"),
    ("cargo picket python", "host-tests/tests/python.rs builds the wheel"),
    ("cargo picket c --core", "host-tests/tests/c.rs builds the archives"),
];

/// A command of a page.
struct Shown {
    page: String,
    command: String,
}

fn pages() -> Vec<(String, String)> {
    let folder = |name: &str| fs::read_dir(Path::new(ROOT).join(name)).unwrap();
    let docs = folder("docs").chain(folder("docs/recipes")).map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> =
        docs.filter(|path| path.extension().is_some_and(|suffix| suffix == "md")).collect();
    pages.sort();
    pages.insert(0, Path::new(ROOT).join("README.md"));
    let read = |path: PathBuf| {
        (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read_to_string(&path).unwrap())
    };
    pages.into_iter().map(read).collect()
}

/// The commands of all `console` blocks.
fn shown() -> Vec<Shown> {
    let mut all = Vec::new();
    for (page, text) in pages() {
        for block in text.split("```console\n").skip(1) {
            let block = block.split("```").next().unwrap();
            for part in format!("\n{block}").split("\n$ ").skip(1) {
                let command = part.lines().next().unwrap_or(part);
                let command = command.split("  #").next().unwrap().trim().to_owned();
                all.push(Shown { page: page.clone(), command });
            }
        }
    }
    all
}

/// A folder with what a reader of a page has at hand.
fn folder(page: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("typed").join(page);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("docs")).unwrap();
    let wav = |name: &str, samples: usize, lines: &[(f64, f64)], noise: f64| {
        let lines: Vec<_> = lines.iter().map(|&(hertz, codes)| (hertz, codes, -0.25)).collect();
        recorded(folder.join(name).to_str().unwrap(), &tones(samples, &lines, noise))
    };
    wav("tone.wav", 5 * 4096, &[(1234.567, 9000.0)], 0.0);
    wav("tones.wav", 2 * 4096, &[(1234.567, 9000.0), (5432.1, 2000.0), (9876.5, 300.0)], 20.0);
    let series = [(611.7, 300.0), (1223.4, 3000.0), (1835.1, 2500.0), (2446.8, 900.0)];
    wav("motor.wav", 2 * 4096, &series, 20.0);
    fs::copy(Path::new(ROOT).join("docs/session.bin"), folder.join("docs/session.bin")).unwrap();
    fs::create_dir_all(folder.join("docs/scenes")).unwrap();
    for scene in fs::read_dir(Path::new(ROOT).join("docs/scenes")).unwrap() {
        let scene = scene.unwrap();
        fs::copy(scene.path(), folder.join("docs/scenes").join(scene.file_name())).unwrap();
    }
    fs::write(folder.join("reference.bin"), BENCH.recording()).unwrap();
    // Two blocks as a board captures them: its codes begin at 0.
    let code = |n: i32| 2048.0 + 900.0 * (TAU * 0.1 * f64::from(n)).sin();
    let codes: Vec<u8> = (0..2048).flat_map(|n| (code(n).round() as i16).to_le_bytes()).collect();
    fs::write(folder.join("blocks.i16"), codes).unwrap();
    // Two blocks of I and Q at a positive frequency: I is the cosine, Q the sine.
    let pair = |n: i32| {
        let (sin, cos) = (TAU * 0.05 * f64::from(n)).sin_cos();
        [cos, sin].map(|part| ((800.0 * part).round() as i16).to_le_bytes())
    };
    let pairs: Vec<u8> = (0..2048).flat_map(pair).flatten().collect();
    fs::write(folder.join("hand.cs16"), pairs).unwrap();
    folder
}

/// A command line as a shell takes it, `cargo picket` being the program that the alias runs.
fn typed(command: &str, folder: &Path) -> Output {
    let script = format!(
        "cargo() {{ shift; \"$PICKET\" \"$@\"; }}\npicket() {{ \"$PICKET\" \"$@\"; }}\n{command}\n"
    );
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).env("PICKET", env!("CARGO_BIN_EXE_picket")).current_dir(folder);
    shell.output().unwrap()
}

/// Why a command is not run here, if it is not: of the beginnings that fit, the longest tells.
fn left_out(command: &str, all: bool) -> Option<&'static str> {
    let lists = [(&LEFT_OUT[..], true), (&LONG[..], !all)];
    let each = lists.into_iter().flat_map(|(list, out)| list.iter().map(move |entry| (entry, out)));
    let fit = each.filter(|((beginning, _), _)| command.starts_with(beginning));
    let ((_, why), out) = fit.max_by_key(|((beginning, _), _)| beginning.len())?;
    out.then_some(*why)
}

/// Pages are typed beside each other, each in a folder of its own.
#[test]
fn the_commands_of_the_documents_run() {
    let shown = type_pages(false);
    for (beginning, _) in LEFT_OUT.iter().chain(&LONG) {
        let still = shown.iter().any(|shown| shown.command.starts_with(beginning));
        assert!(still, "{beginning} is in no document: it need not be left out");
    }
}

#[test]
#[ignore = "needs many minutes: cargo test -p picket-host --test all -- --ignored typed"]
fn the_long_commands_of_the_documents_run() {
    type_pages(true);
}

fn type_pages(all: bool) -> Vec<Shown> {
    let pages: Vec<_> = pages().into_par_iter().map(|(page, _)| typed_page(&page, all)).collect();
    // A failure on another thread would be told to nobody.
    let ran: usize =
        pages.into_iter().map(|page| page.unwrap_or_else(|wrong| panic!("{wrong}"))).sum();
    println!("{ran} commands were run");
    assert!(ran >= 10, "{ran} commands were run");
    shown()
}

/// Types the commands of a page. Returns how many ran, or what is wrong.
fn typed_page(page: &str, all: bool) -> Result<usize, String> {
    let folder = folder(page);
    let mut ran = 0;
    for Shown { command, .. } in shown().into_iter().filter(|shown| shown.page == page) {
        if let Some(why) = left_out(&command, all) {
            println!("{page}: left out: {command}: {why}");
            continue;
        }
        let begun = std::time::Instant::now();
        let done = typed(&command, &folder);
        let errors = String::from_utf8_lossy(&done.stderr).into_owned();
        if !done.status.success() {
            return Err(format!("{page}: {command}: {errors}"));
        }
        ran += 1;
        println!("{page}: ran in {:.1} s: {command}", begun.elapsed().as_secs_f64());
    }
    Ok(ran)
}

/// In blocks and in sentences alike.
#[test]
fn every_command_of_the_documents_exists() {
    let mut parsed = 0;
    for (page, text) in pages() {
        let spans = text.split('`').filter(|span| !span.contains('\n')).map(str::to_owned);
        let blocks =
            shown().into_iter().filter(|shown| shown.page == page).map(|shown| shown.command);
        for command in spans.chain(blocks) {
            let Some(arguments) =
                command.strip_prefix("cargo picket ").or(command.strip_prefix("picket "))
            else {
                continue;
            };
            let end = arguments.find([';', '|', '>', '&', '\\']).unwrap_or(arguments.len());
            let words = arguments[..end].split_whitespace();
            if arguments.contains("...")
                || arguments.contains("OPTIONS")
                || arguments.contains("COMMAND")
            {
                continue;
            }
            // Names in capitals stand for what the reader has.
            let words = words.map(|word| match word {
                "METHOD" => "z-rife",
                "FILE" => "x.svg",
                "SHELL" => "bash",
                word => word,
            });
            if let Err(error) = Picket::try_parse_from(std::iter::once("picket").chain(words)) {
                let shows =
                    [clap::error::ErrorKind::DisplayHelp, clap::error::ErrorKind::DisplayVersion];
                assert!(shows.contains(&error.kind()), "{page}: {command}: {error}");
            }
            parsed += 1;
        }
    }
    println!("{parsed} commands are parsed");
    assert!(parsed > 25, "{parsed}");
}

/// The alias itself, by cargo, from a folder of a fresh clone. What other people's packages are compiled to is shared with this
/// build; our own are compiled once more, without being optimised.
#[test]
#[ignore = "needs git, a clone and minutes: cargo test -p picket-host --test all -- --ignored typed"]
fn the_alias_runs_the_program_in_a_clone() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("cloned");
    let clone = folder.join("picket");
    fs::create_dir_all(&folder).unwrap();
    let git = |arguments: &[&str], place: &Path| {
        let output = Command::new("git").args(arguments).current_dir(place).output();
        let output = output.ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let head = git(&["rev-parse", "HEAD"], Path::new(ROOT)).expect("git, and a clone");
    // A clone that is there is brought up to date, so that what it compiled stays of use.
    if !clone.join(".git").exists() {
        git(&["clone", "--quiet", ROOT, "picket"], &folder).expect("git clone");
    }
    git(&["fetch", "--quiet", ROOT, &head], &clone).expect("git fetch");
    git(&["checkout", "--quiet", "--force", "--detach", &head], &clone).expect("git checkout");
    fs::create_dir_all(folder.join(".cargo")).unwrap();
    let ours = ["picket-dsp", "picket-firmware", "picket-host", "picket-transform", "picket-wire"];
    let plain =
        ours.map(|name| format!("[profile.dev.package.{name}]\nopt-level = 0\ndebug = 0\n"));
    fs::write(folder.join(".cargo/config.toml"), plain.concat()).unwrap();
    // `target/debug/picket` is this build's: the clone's goes to its own place.
    let build = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let typed = |arguments: &[&str]| {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo
            .args(["--quiet", "--offline", "picket"])
            .args(arguments)
            .current_dir(clone.join("docs"));
        cargo.env("CARGO_BUILD_BUILD_DIR", build).env("CARGO_TARGET_DIR", folder.join("target"));
        let output = cargo.output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {errors}");
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(typed(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
    // No `--`, and neither cargo's help nor another command of cargo's.
    assert!(typed(&["demo", "--help"]).contains("--snr-db"));
    assert!(typed(&["flash", "--board", "pico", "--help"]).contains("--dry-run"));
    let said = typed(&["watch", "--replay", "session.bin"]);
    assert!(said.contains("30 records, 0 blocks between them without one, 0 bad frames"), "{said}");
}

#[test]
fn there_is_an_alias_for_each_program() {
    let configured = fs::read_to_string(Path::new(ROOT).join(".cargo/config.toml")).unwrap();
    let alias = configured.lines().find_map(|line| line.strip_prefix("picket = ")).unwrap();
    assert_eq!(alias, "\"run --package picket-host --\"");
    // The users' program and the developers', and no other: a name of cargo's own, or of a plug-in, would take its place.
    let aliases = configured.split("[alias]").nth(1).unwrap().split("\n\n").next().unwrap();
    assert!(aliases.contains("\nlab = \"run --package picket-lab --\""), "{aliases}");
    assert_eq!(aliases.trim().lines().count(), 2, "{aliases}");
}

/// What `--help`, completions and manual pages need.
#[test]
fn shells_and_man_are_served() {
    let folder = std::env::temp_dir();
    for (command, says) in [
        ("cargo picket --version", env!("CARGO_PKG_VERSION")),
        ("cargo picket help", "demo"),
        ("cargo picket demo --help", "--snr-db"),
        ("cargo picket analyze --help", "--decimal-comma"),
        ("picket completions bash", "_picket"),
        ("picket completions zsh", "#compdef picket"),
        ("picket man", ".TH picket 1"),
        ("picket man analyze", "picket\\-analyze"),
    ] {
        let output = typed(command, &folder);
        assert!(output.status.success(), "{command}");
        assert!(String::from_utf8_lossy(&output.stdout).contains(says), "{command}");
        assert!(output.stderr.is_empty(), "{command}");
    }
}

/// A frame on the line: kind and body with their checksum, stuffed, a zero behind.
fn frame(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut plain = [&[kind], body].concat();
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&plain);
    plain.extend(checksum.to_le_bytes());
    let runs = plain.split(|&byte| byte == 0);
    let stuffed = runs.flat_map(|run| [&[run.len() as u8 + 1], run].concat());
    stuffed.chain([0]).collect()
}

/// The reader of docs/protocol.md passes over frames of other kinds, lengths and versions. Every one of them has a right checksum.
#[test]
fn the_reader_in_python_stumbles_over_no_frame() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/protocol.md")).unwrap();
    let program = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let mut bytes = Vec::new();
    for kind in 0..=255 {
        for length in [0, 1, 2, 3, 7, 8, 27, 28, 36, 63, 92, 200] {
            for version in [1, 2, 255] {
                // Bytes that are all alike are the largest counts that a body can tell.
                let mut body = vec![255; length];
                body.iter_mut().take(1).for_each(|byte| *byte = version);
                bytes.extend(frame(kind, &body));
            }
        }
    }
    let recording = fresh("frames.bin");
    fs::write(&recording, bytes).unwrap();
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/schema.json");
    let output = Command::new("python3").args(["-c", program, schema]).arg(&recording).output();
    let output = output.expect("apt-get install python3");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty(), "numbers out of nothing");
}

/// The reader of docs/protocol.md reads the recording that docs/board.md replays.
#[test]
fn the_reader_in_python_reads_a_recording() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/protocol.md")).unwrap();
    let program = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let recording = Path::new(ROOT).join("docs/session.bin");
    let schema = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/schema.json");
    let output = Command::new("python3").args(["-c", program, schema]).arg(&recording).output();
    let output = output.expect("apt-get install python3");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{errors}");
    let theirs = String::from_utf8(output.stdout).unwrap();
    let ours = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(["watch", "--jsonl", "--replay"])
        .arg(&recording)
        .output()
        .unwrap();
    let ours = String::from_utf8(ours.stdout).unwrap();
    let records = ours.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let records: Vec<_> = records
        .filter(|line| {
            line["sequence"].is_u64() && line["segment"].is_string() && !line["snr_db"].is_null()
        })
        .collect();
    assert!(records.len() > 20);
    for (line, record) in theirs.lines().zip(&records) {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let number = |at: usize| fields[at].parse::<f64>().unwrap();
        let close =
            |at: usize, key: &str| (number(at) / record[key].as_f64().unwrap() - 1.0).abs() < 1e-6;
        assert!(number(0) == record["sequence"].as_f64().unwrap(), "{line}: {record}");
        assert!(
            close(1, "frequency_cycles_per_sample") && close(2, "sigma_cycles_per_sample"),
            "{line}: {record}"
        );
    }
    assert_eq!(theirs.lines().count(), records.len());
}
