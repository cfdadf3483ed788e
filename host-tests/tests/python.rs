//! The module for Python: the wheel in fresh environments, with the oldest and the newest numpy; its answers, to the bit, beside those
//! of `picket analyze`; the pages' lines and types; the notebooks; a cluster's workers; a ROS node. `cargo test --test python`; a plain `cargo test` leaves it out, since the
//! wheel takes minutes to build.

#[path = "../../dependents/same_bits.rs"]
#[allow(dead_code)]
mod same_bits;

use host_tests::figures::hold;
use host_tests::needed;
use picket_dsp::acquire::sample::{Iq, Real, Record};
use picket_dsp::{Codes, Verdict};
use picket_host::analyze::chirps::{self, Finding};
use picket_host::analyze::cut::Cut;
use picket_host::analyze::radar::Radar;
use picket_host::analyze::told::{self, Told};
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
use picket_host::recording::{self, Format};
use picket_host::toolchain::{build_wheel, environment, workspace};
use picket_host::views;
use picket_wire::view;
use same_bits::{Random, fill};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

fn temporary(name: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python").join(name);
    fs::create_dir_all(&place).unwrap();
    place
}

fn wheel() -> &'static Path {
    static WHEEL: OnceLock<PathBuf> = OnceLock::new();
    WHEEL.get_or_init(|| needed(build_wheel(&temporary("wheel"))))
}

/// An environment that holds the wheel and these packages and nothing else. It is made anew each time.
fn fresh(name: &str, packages: &[&str]) -> PathBuf {
    let wheel = wheel().to_str().unwrap();
    let place = temporary("environments").join(name);
    let _ = fs::remove_dir_all(&place);
    needed(environment(&place, &[packages, &[wheel]].concat()))
}

fn said(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{out}{errors}", output.status);
    println!("{out}{errors}");
    out.into_owned()
}

fn pytest(programs: &Path) -> Command {
    let mut command = Command::new(programs.join("python"));
    command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
    command.current_dir(temporary("run")).arg(workspace().join("python/tests"));
    command
}

/// A record's blocks with a name, and what `picket analyze --arith target` says of them, as files.
fn cases() -> PathBuf {
    let place = temporary("bits");
    let mut cases = Vec::new();
    for n in [64, 128, 256, 512, 1024, 2048, 4096] {
        case::<Real>(&place, n, &mut cases);
        case::<Iq>(&place, n, &mut cases);
    }
    fs::write(place.join("cases.json"), serde_json::to_vec(&cases).unwrap()).unwrap();
    frames(&place);
    place
}

/// An array of chirps, and the targets that `picket analyze` finds in its frames, with their ranges by phase and their errors, as JSON lines.
fn frames(place: &Path) {
    let mut scene = picket_host::recipe::scene(Path::new("cars")).unwrap();
    scene.receiver.noise.snr_db = Some(0.0.into());
    let codes = scene.codes(0).unwrap();
    let words = codes.iter().flatten().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let file = place.join("chirps.npy");
    let shape = format!("({}, 64, 256, 2)", codes.len() / 64 / 256);
    let header = format!("{{'descr': '<i2', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    let npy = [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &words].concat();
    fs::write(&file, npy).unwrap();
    // The module's `Calibration()`: a radar whose phase at 0 m is 0.
    let perfect = place.join("perfect.json");
    fs::write(&perfect, r#"{"phase_rad": 0, "sigma_phase_rad": 0, "offset_m": 0, "sigma_offset_m": 0, "slope_ppm": 0, "sigma_slope_ppm": 0}"#).unwrap();
    let known = "clock_ppm=20,carrier_ppm=1,slope_ppm=100,range_offset_m=1e-3,phase_rad=0.1";
    let told = Told {
        period_s: Some(120e-6),
        guard_s: Some(2e-6),
        phase: true,
        calibration: Some(perfect),
        uncertainty: Some(told::uncertainty(known).unwrap()),
        ..Told::default()
    };
    let radar = Radar {
        shape: picket_dsp::Shape::Sawtooth,
        carrier_hz: 77e9,
        bandwidth_hz: 306e6,
        chirp_s: 102e-6,
        mixing: picket_dsp::Mixing::TxConjRx,
        velocity_mps: Some((-8.0, 8.0)),
        effort: picket_dsp::Effort::default(),
        false_alarm: None,
    };
    let cut = Cut {
        read: recording::Options { rate_hz: Some(2.56e6), ..recording::Options::default() },
        n: 256,
        hop: 256,
        skip: 0,
        band_hz: None,
        codes: Codes::signed::<16>(),
        reach: picket_dsp::Reach::default(),
        width: picket_dsp::Carrier::default(),
    };
    let mut lines = Vec::new();
    let sink = &mut |finding: &Finding| {
        let Finding::Frame(found) = finding else { panic!("a chirp") };
        let (answer, of_phase) = found.phase.unwrap();
        lines.push(serde_json::json!({
            "target": views::object(&view::FrameTarget::from_found(&found.found)),
            "budget": views::object(&view::Budget::from_budget(&found.budget.unwrap())),
            "phase": views::object(&view::PhaseRange::from_answer(&answer)),
            "phase_budget": views::object(&view::Budget::from_budget(&of_phase.unwrap())),
        }));
    };
    chirps::run(&file, &cut, None, &radar, &told, sink).unwrap();
    assert!(lines.len() >= 9);
    fs::write(place.join("chirps.json"), serde_json::to_vec(&lines).unwrap()).unwrap();
}

fn case<R: Record>(place: &Path, n: usize, cases: &mut Vec<serde_json::Value>) {
    let codes = Codes::signed::<12>();
    let name = format!("{}{n}", if R::IQ { "iq" } else { "real" });
    let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ (n as u64) << 1 ^ u64::from(R::IQ));
    let mut samples = vec![R::Sample::default(); n];
    let mut bytes = Vec::new();
    for _ in 0..10_000 {
        // The tools refuse records of nothing but -1, 0 and 1, as of floats that were not scaled.
        let tells = |&sample: &R::Sample| R::parts(sample).iter().any(|part| part.abs() > 1);
        fill::<R>(&mut samples, codes, &mut random);
        while !samples.iter().any(tells) {
            fill::<R>(&mut samples, codes, &mut random);
        }
        for &sample in &samples {
            let parts = R::parts(sample);
            let used = if R::IQ { &parts[..] } else { &parts[..1] };
            bytes.extend(used.iter().flat_map(|part| part.to_le_bytes()));
        }
    }
    let records = place.join(format!("{name}.i16"));
    fs::write(&records, bytes).unwrap();
    for (word, arithmetic) in [("float", Arithmetic::Target), ("fixed", Arithmetic::TargetFixed)] {
        let analysis = Analysis {
            read: recording::Options {
                format: Some(Format::I16),
                rate_hz: Some(48_000.0),
                iq: R::IQ,
                ..recording::Options::default()
            },
            n: Some(n),
            ..Analysis::new(codes, arithmetic)
        };
        let (mut rows, mut blocks) = (Vec::new(), 0);
        let sink = |answer: analyze::Answer| {
            let verdict = Verdict::ALL.iter().find(|v| v.name() == answer.verdict).unwrap();
            let number = |x: Option<f64>| x.unwrap_or(f64::INFINITY);
            let beside = answer.also.len() as f64;
            let row = [number(answer.frequency_hz), number(answer.sigma_hz)];
            let row = [row[0], row[1], f64::from(*verdict as u8), beside];
            rows.extend(row.into_iter().flat_map(f64::to_le_bytes));
            blocks += 1;
        };
        analyze::run(&records, &analysis, sink, |_| ()).unwrap();
        assert_eq!(blocks, 10_000);
        fs::write(place.join(format!("{name}.{word}")), rows).unwrap();
        cases.push(serde_json::json!({ "name": name, "n": n, "iq": R::IQ, "arithmetic": word }));
    }
}

#[test]
fn the_module_does_as_it_says_with_the_newest_numpy() {
    let packages = ["numpy", "pytest", "pandas", "scipy"];
    let programs = fresh("newest", &packages);
    said(pytest(&programs).env("PICKET_BITS", cases()));
    let speed = workspace().join("python/tests/speed.py");
    let rows = said(Command::new(programs.join("python")).arg(speed).arg("--json"));
    // How fast a machine is says nothing of the module; the errors are the same on all.
    let rms = rows.lines().map(|row| {
        let row: serde_json::Value = serde_json::from_str(row).unwrap();
        ["picket_rms_mhz", "scipy_rms_mhz"].map(|name| row[name].as_f64().unwrap())
    });
    let rms: Vec<[f64; 2]> = rms.collect();
    assert_eq!(rms.len(), 3);
    hold("python, rms error, mHz", 0.01, &[rms[0][0], rms[1][0], rms[2][0]]);
    hold("python, scipy's rms error, mHz", 1.0, &[rms[0][1], rms[1][1], rms[2][1]]);
}

/// The oldest that `python/pyproject.toml` admits, where this Python can have it.
#[test]
fn the_module_does_as_it_says_with_the_oldest_numpy() {
    let project = fs::read_to_string(workspace().join("python/pyproject.toml")).unwrap();
    let (_, rest) = project.split_once("numpy>=").unwrap();
    let oldest = format!("numpy=={}", rest.split('"').next().unwrap());
    let programs = fresh("oldest", &[&oldest, "pytest"]);
    said(&mut pytest(&programs));
}

/// The blocks of a language in a document.
fn blocks(document: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let parts = document.split(&fence).skip(1);
    parts.map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

/// The documents' programs. A page is one program: later blocks use what the first ones have made.
fn pages() -> impl Iterator<Item = (&'static str, String)> {
    ["README.md", "python/README.md", "docs/python.md"].into_iter().map(|name| {
        let program = blocks(&fs::read_to_string(workspace().join(name)).unwrap(), "python");
        assert!(program.len() == 1 || name.starts_with("docs"), "{name}");
        (name, program.concat())
    })
}

#[test]
fn the_readmes_and_the_pages_lines_run() {
    let programs = fresh("readme", &[]);
    for (name, program) in pages() {
        let file = temporary("run").join("page.py");
        fs::write(&file, program).unwrap();
        let out = said(Command::new(programs.join("python")).current_dir(workspace()).arg(&file));
        assert!(out.contains("good"), "{name}: {out}");
        if name.contains("python") {
            for shown in blocks(&fs::read_to_string(workspace().join(name)).unwrap(), "text") {
                assert!(out.contains(&shown), "{name}: {shown}\n{out}");
            }
        }
    }
}

/// The stubs say what the module has, and mypy and pyright take them, the pages and the examples.
#[test]
fn the_types_are_those_of_the_module() {
    // Pyright's node comes from PyPI, too.
    let programs = fresh("types", &["numpy", "pandas-stubs", "mypy", "pyright[nodejs]"]);
    let _ = fs::remove_dir_all(temporary("types"));
    // Without the private modules beside it, which have no stubs.
    let stubs = temporary("types/stubs/picket_dsp");
    fs::copy(workspace().join("python/picket_dsp/__init__.pyi"), stubs.join("__init__.pyi"))
        .unwrap();
    let place = temporary("types/programs");
    for (number, (_, program)) in pages().enumerate() {
        fs::write(place.join(format!("page{number}.py")), program).unwrap();
    }
    for name in ["folder.py", "radar_track.py"] {
        fs::copy(workspace().join("python/examples").join(name), place.join(name)).unwrap();
    }
    let run = |program: &str, arguments: &[&str], place: &Path| {
        let mut command = Command::new(programs.join(program));
        command.args(arguments).current_dir(place);
        command
    };
    let stubtest = ["-m", "mypy.stubtest", "picket_dsp"];
    said(run("python", &stubtest, &place).env("MYPYPATH", stubs.parent().unwrap()));
    said(&mut run("mypy", &["--strict", "__init__.pyi"], &stubs));
    // Dask and ROS are not here.
    let mypy = ["--strict", "--ignore-missing-imports", "."];
    let python = programs.join("python");
    let pyright = ["--pythonpath", python.to_str().unwrap()];
    let lenient = r#"{"reportMissingImports": false, "reportMissingModuleSource": false}"#;
    for place in [&stubs, &place] {
        fs::write(place.join("pyrightconfig.json"), lenient).unwrap();
        said(&mut run("pyright", &pyright, place));
    }
    said(&mut run("mypy", &mypy, &place));
    let wrong = "import picket_dsp\n\
        picket_dsp.Pipeline(rate_hz='fast')\n\
        picket_dsp.Chirp(bandwidth_hz=1e8, duration_s=1e-3, carrier_hz=24e9, shape='saw')\n\
        picket_dsp.Pipeline(rate_hz=48e3).blocks([0] * 1024).to_excel()\n";
    fs::write(place.join("wrong.py"), wrong).unwrap();
    for mut checker in [run("mypy", &mypy, &place), run("pyright", &pyright, &place)] {
        let output = checker.output().unwrap();
        let told = String::from_utf8_lossy(&output.stdout);
        for line in 2..=4 {
            assert!(told.contains(&format!("wrong.py:{line}:")), "{checker:?}: {told}");
        }
    }
}

#[test]
fn a_folder_is_measured_by_a_cluster_and_a_worker_that_dies_costs_nothing() {
    let programs = fresh("cluster", &["numpy", "distributed"]);
    let script = workspace().join("python/tests/cluster.py");
    let out = said(Command::new(programs.join("python")).current_dir(temporary("run")).arg(script));
    assert!(out.contains("24 files"), "{out}");
}

/// The messages' packages are no distributions of PyPI, so that stand-ins with their fields take the tracks.
#[test]
fn a_ros_node_publishes_a_boards_targets_with_their_covariance() {
    let recording = temporary("run").join("board.bin");
    let picket = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.args(["run", "-q", "-p", "picket-host", "--bin", "picket", "--"]).args(arguments);
        said(command.current_dir(workspace()))
    };
    let file = recording.to_str().unwrap();
    let _ = fs::remove_file(&recording);
    picket(&["demo", "--scenario", "board", "--record", file]);
    let lines = picket(&["watch", "--replay", file, "--jsonl"]);
    let told = temporary("run").join("board.jsonl");
    fs::write(&told, &lines).unwrap();
    let mut node = Command::new("python3");
    node.arg(workspace().join("python/tests/ros.py")).stdin(fs::File::open(&told).unwrap());
    let published = said(&mut node);
    let read = |text: &str| -> Vec<serde_json::Value> {
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let answers: Vec<_> =
        read(&lines).into_iter().filter(|answer| answer["outcome_verdict"] == "good").collect();
    let messages = read(&published);
    assert!(!answers.is_empty() && answers.len() == messages.len(), "{published}");
    for (answer, message) in answers.iter().zip(&messages) {
        let track = &message["tracks"][0];
        let [range, sigma, closing] =
            ["range_m", "sigma_range_m", "velocity_mps"].map(|name| answer[name].as_f64().unwrap());
        assert_eq!(track["position"]["x"], range);
        assert_eq!(track["velocity"]["x"], -closing);
        assert!(
            (track["position_covariance"][0].as_f64().unwrap() / (sigma * sigma) - 1.0).abs()
                < 1e-9
        );
    }
}

/// The lines of a page with something in them.
fn told(page: &str) -> Vec<&str> {
    page.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// The notebooks check their own figures. One is a page of the book, which has what it says today.
#[test]
fn the_notebooks_run() {
    let programs = fresh("notebooks", &["nbconvert", "ipykernel", "matplotlib"]);
    let notebooks = workspace().join("python/notebooks");
    let mut pages = 0;
    for entry in fs::read_dir(notebooks).unwrap() {
        let notebook = entry.unwrap().path();
        if notebook.extension().is_none_or(|end| end != "ipynb") {
            continue;
        }
        let name = notebook.file_stem().unwrap().to_str().unwrap().to_owned();
        let page = workspace().join("docs").join(&name).with_extension("md");
        let to = if page.exists() { "markdown" } else { "notebook" };
        let mut command = Command::new(programs.join("python"));
        command.args(["-m", "nbconvert", "--to", to, "--execute", "--log-level", "WARN"]);
        command.env("PICKET_RECORDING", host_tests::data("cw24_car_away.wav"));
        let place = temporary("notebooks");
        said(command.arg("--output-dir").arg(&place).arg(&notebook));
        if page.exists() {
            let made = fs::read_to_string(place.join(&name).with_extension("md")).unwrap();
            let kept = fs::read_to_string(&page).unwrap();
            assert_eq!(told(&made), told(&kept), "docs/python.md says how to make {name}.md");
            pages += 1;
        }
        println!("{name} ran");
    }
    assert_eq!(pages, 1);
}
