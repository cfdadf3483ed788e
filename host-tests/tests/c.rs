//! The library for C and C++: what its archives show, that every misuse is answered, that it measures the same bits as the tools, and
//! that programs of strangers link it. `cargo test --test c`; a plain `cargo test` leaves them out, since each archive takes a minute or two.

#[path = "c/projects.rs"]
mod projects;

use host_tests::needed;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::frame::{Cells, Frame, FrameConfig, FrameTarget};
use picket_dsp::solve::displacement::Unwrapper;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::{Chirp, Config, Iq, Segment, Shape, Verdict};
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
use picket_host::c::{Core, package};
use picket_host::emulator::Footprint;
use picket_host::recording::{self, Format};
use picket_host::toolchain::archive::symbols;
use picket_host::toolchain::{Firmware, Profile, Target, qemu, workspace};
use picket_simulator::Scene;
use picket_simulator::scene::{Source, Target as Reflector, Waveform};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Flags that find what a compiler can find.
const STRICT: [&str; 6] =
    ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wstrict-prototypes", "-Werror"];

fn temporary(name: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c").join(name);
    fs::create_dir_all(&place).unwrap();
    place
}

/// The package as `cargo picket c` writes it: for this machine, a Cortex-M4F, and an M0.
fn dist() -> &'static Path {
    static DIST: OnceLock<PathBuf> = OnceLock::new();
    let write = || {
        let out = temporary("dist");
        // The first of an M4F's has its floats in registers.
        let archives =
            [Core::Host.places(), &Core::M4f.places()[..1], Core::M0plus.places()].concat();
        needed(package(&archives, &out));
        out
    };
    DIST.get_or_init(write)
}

/// Fails before minutes of building if a program is not here, with the package that has it.
fn needs(program: &str, package: &str) {
    let there = Command::new(program).arg("--version").output().is_ok();
    assert!(there, "{program} is missing: apt-get install {package}");
}

/// What a command prints, which must succeed.
fn said(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{out}{errors}", output.status);
    out.into_owned()
}

fn source(name: &str) -> PathBuf {
    workspace().join("c/tests").join(name)
}

/// The kinds that the header lists, with their lengths and parts of a sample.
fn kinds() -> Vec<(String, usize, usize)> {
    let header = fs::read_to_string(workspace().join("c/include/picket.h")).unwrap();
    let rows = header.lines().filter_map(|line| line.trim().strip_prefix("X(picket_"));
    let kinds = rows.map(|row| {
        let mut words = row.split(", ");
        let mut word = || words.next().unwrap();
        let (name, n) = (format!("picket_{}", word()), word().parse().unwrap());
        (name, n, word().trim_end_matches([')', '\\', ' ']).parse().unwrap())
    });
    let kinds: Vec<_> = kinds.collect();
    assert_eq!(kinds.len(), 14);
    kinds
}

/// The names of all functions that the header declares.
fn declared() -> Vec<String> {
    let header = fs::read_to_string(workspace().join("c/include/picket.h")).unwrap();
    let (mut names, mut each) = (Vec::new(), Vec::new());
    for word in header.split([' ', '*', '\n']) {
        let Some((name, _)) = word.split_once('(') else { continue };
        match name.strip_prefix("KIND##_") {
            Some(end) => each.push(end.to_owned()),
            None if name.starts_with("picket_") && name != "picket_version()" => {
                names.push(name.to_owned());
            }
            None => {}
        }
    }
    for (kind, _, _) in kinds() {
        names.extend(each.iter().map(|end| format!("{kind}_{end}")));
    }
    // The comment at the top shows some calls.
    names.sort();
    names.dedup();
    names
}

#[test]
fn an_archive_shows_the_headers_symbols_and_no_others() {
    let dist = dist();
    for place in ["host", "cortex-m4/fpv4-sp-d16-hard", "cortex-m0plus"] {
        let archive = dist.join("src").join(place).join("libpicket.a");
        assert_eq!(symbols(&archive).unwrap(), declared(), "{place}");
        // No way leads to a panic: its handler would ask for a function that does not exist, and nothing is asked for.
        let text = fs::read(&archive).unwrap();
        let holds = |word: &[u8]| text.windows(word.len()).any(|window| window == word);
        assert!(!holds(b"picket_can_panic") && !holds(b"panicking"), "{place}");
        assert!(holds(b"picket_real1024_block"));
    }
}

#[test]
fn the_header_is_clean_in_c99_and_cpp() {
    let place = temporary("header");
    let file = place.join("header.c");
    fs::write(&file, "#include \"picket.h\"\n#include \"picket.h\"\nint picket_nothing;\n")
        .unwrap();
    for (compiler, flags) in [
        ("gcc", ["-std=c99", "-xc"]),
        ("clang", ["-std=c99", "-xc"]),
        ("g++", ["-std=c++11", "-xc++"]),
        ("clang++", ["-std=c++11", "-xc++"]),
    ] {
        let strict =
            STRICT.iter().filter(|flag| flags[1] == "-xc" || !flag.ends_with("prototypes"));
        needs(compiler, if compiler.starts_with("clang") { "clang" } else { "g++" });
        let mut command = Command::new(compiler);
        command.args(flags).args(strict).arg("-I").arg(workspace().join("c/include"));
        said(command.arg("-c").arg(&file).arg("-o").arg(place.join("header.o")));
    }
}

/// The package for this machine alone.
fn here() -> &'static Path {
    static HERE: OnceLock<PathBuf> = OnceLock::new();
    HERE.get_or_init(|| {
        let out = temporary("here");
        needed(package(Core::Host.places(), &out));
        out
    })
}

/// A program for this machine from the package, with these flags beside.
fn program(compiler: &str, name: &str, flags: &[&str]) -> PathBuf {
    let dist = here();
    let out = temporary("host").join(format!("{name}-{compiler}{}", flags.len()));
    // Two tests may want it at once, and what runs cannot be written to.
    let part = out.with_extension(format!("{:?}", std::thread::current().id()));
    let mut command = Command::new(compiler);
    command.args(["-std=c99", "-O1", "-g"]).args(STRICT).args(flags);
    command.arg("-I").arg(dist.join("src")).arg(source(name)).arg("-L").arg(dist.join("src/host"));
    said(command.args(["-lpicket", "-lm", "-o"]).arg(&part));
    fs::rename(&part, &out).unwrap();
    out
}

/// Calls that a program must not make are answered with their errors, and the right ones do their work.
fn misuse(compiler: &str, flags: &[&str]) {
    needs(compiler, compiler);
    let out = said(&mut Command::new(program(compiler, "misuse.c", flags)));
    assert_eq!(out.lines().last(), Some("0 failures"), "{out}");
}

#[test]
fn misuse_is_answered_and_every_call_does_its_work() {
    misuse("gcc", &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
}

#[test]
fn misuse_is_answered_as_clang_compiles_it() {
    misuse("clang", &[]);
}

/// The STM32Cube example on a stand-in for the HAL of four families: it calibrates as each does, starts its timer, and measures each half.
#[test]
fn the_cube_example_measures() {
    needs("gcc", "gcc");
    let hal = workspace().join("c/tests/hal");
    for family in ["F4", "G4", "G0", "H7"] {
        let define = format!("-DSTM32{family}");
        let flags = ["-I", hal.to_str().unwrap(), &define];
        let program = program("gcc", "cube.c", &flags);
        let out = said(&mut Command::new(program));
        let tones: Vec<&str> = out.lines().collect();
        assert_eq!(tones.len(), 8, "{family}: {out}");
        for tone in tones {
            let (hertz, good) = tone.split_once(' ').unwrap();
            assert!(
                (hertz.parse::<f64>().unwrap() - 1000.0).abs() < 0.1 && good == "1",
                "{family}: {out}"
            );
        }
    }
}

/// A frame's targets, ranges by phase, budgets and the way have the bits of the library, and are true of the simulator's scene.
#[test]
fn frames_are_those_of_the_library() {
    needs("gcc", "gcc");
    let (n, chirps) = (256, 64);
    let target = |range_m: f64, velocity_mps: f64, amplitude: f64| {
        Source::Target(Reflector {
            range_m: range_m.into(),
            velocity_mps: velocity_mps.into(),
            amplitude: Some(amplitude.into()),
            ..Reflector::default()
        })
    };
    let chirp = Chirp {
        shape: Shape::Sawtooth,
        wavelength_m: picket_dsp::config::SPEED_OF_LIGHT / 77e9,
        bandwidth_hz: 306e6,
        duration_s: 102e-6,
        guard_s: 2e-6,
        ..Chirp::default()
    };
    let mut scene = Scene { seed: 62, rate_hz: 2.56e6, seconds: 8e-3, ..Scene::default() };
    scene.waveform = Some(Waveform::from_chirp(&chirp, n, 120e-6));
    scene.sources = vec![target(18.0, 0.5, 300.0), target(24.0, -5.0, 100.0)];
    (scene.receiver.iq, scene.receiver.noise.snr_db) = (true, Some(10.0.into()));
    let mut run = scene.run(0).unwrap();
    let records: Vec<Vec<[i16; 2]>> = (0..chirps).map(|index| run.record(index, n)).collect();
    let middle_s = 0.5 * (scene.start_s(0, n) + scene.start_s(chirps - 1, n)) + 127.5 / 2.56e6;
    let program = program("gcc", "frames.c", &[]);
    for codes in [Codes::signed::<12>(), Codes::signed::<9>()] {
        let (low, high) = codes.rails();
        let clamped = |record: &Vec<[i16; 2]>| {
            record.iter().map(|parts| parts.map(|part| part.clamp(low, high))).collect()
        };
        let records: Vec<Vec<[i16; 2]>> = records.iter().map(clamped).collect();
        let expected = rows(&records, chirp, codes);
        let file = temporary("frames").join("chirps.cs16");
        let bytes = records.iter().flatten().flatten().flat_map(|code| code.to_le_bytes());
        fs::write(&file, bytes.collect::<Vec<u8>>()).unwrap();
        let mut command = Command::new(&program);
        let out = said(command.arg(&file).args([low, high].map(|rail| rail.to_string())));
        let seen = out.lines().map(|line| line.split(' ').map(|x| x.parse().unwrap()).collect());
        let seen: Vec<Vec<f64>> = seen.collect();
        assert_eq!(seen, expected);
        assert!(seen.len() >= 2, "{out}");
        let verdict = if high > 300 { Verdict::Good } else { Verdict::Clipped };
        assert!(seen.iter().all(|row| row[4] == f64::from(verdict as u8)), "{out}");
        if verdict == Verdict::Clipped {
            continue;
        }
        assert_eq!(seen.len(), 2, "{out}");
        for (index, row) in seen.iter().enumerate() {
            let truth = run.truth(index, middle_s, 1);
            assert!((row[0] - truth.range_m.unwrap()).abs() < 5.0 * row[2], "{row:?}");
            assert!((row[1] - truth.velocity_mps.unwrap()).abs() < 5.0 * row[3], "{row:?}");
        }
    }
}

/// What the library says of a frame, in the numbers of `frames.c`.
fn rows(records: &[Vec<[i16; 2]>], chirp: Chirp, codes: Codes) -> Vec<Vec<f64>> {
    let n = 256;
    let config = FrameConfig {
        velocity_mps: Some((-8.0, 8.0)),
        ..FrameConfig::new(chirp, 2.56e6, n, true, records.len(), 120e-6)
    };
    let plan = config.plan().unwrap();
    let mut cells = vec![[0i16; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Narrow(&mut cells)).unwrap();
    let pipeline_config = Config {
        scene: picket_dsp::Scene::Chirp(chirp),
        velocity_mps: Some((-8.0, 8.0)),
        ..Config::new(2.56e6, codes)
    };
    let mut pipeline = picket_dsp::Pipeline::<Iq, 256>::new(pipeline_config.plan().unwrap());
    let mut way = Unwrapper::of_scene(&pipeline_config.scene, 2.56e6, n, true, 0.25).unwrap();
    let mut moved = Default::default();
    for (index, record) in records.iter().enumerate() {
        let seen = pipeline.record(record).unwrap();
        frame.push(&pipeline.spectrum().view(), seen.clipped);
        let stamp = Stamp { clock: 300 * index as u64, ..Stamp::default() };
        for line in pipeline.lines(&seen, 1) {
            moved = way.push(&stamp, &line);
        }
    }
    let calibration = Calibration {
        phase_rad: 0.3,
        sigma_phase_rad: 0.01,
        offset_m: 2e-3,
        sigma_offset_m: 1e-4,
        slope_ppm: 0.0,
        sigma_slope_ppm: 10.0,
    };
    let ranging = PhaseRanging::new(&chirp, 2.56e6, n, true, calibration).unwrap();
    let known = Uncertainty {
        clock_ppm: 20.0,
        carrier_ppm: 1.0,
        slope_ppm: 100.0,
        angle_rad: 0.0,
        range_offset_m: 1e-3,
        phase_rad: 0.1,
    };
    let row = |found: &FrameTarget| {
        let target = &found.target;
        let velocity = target.velocity.unwrap();
        let range = ranging.of_target(Segment::Up, &found.line, target);
        let budget = known.of_target(target, 0.0).of_mean(4);
        let by_phase = known.of_phase_range(&range, 2.0 * range.spacing());
        vec![
            target.range.to_num::<f64>(),
            velocity.to_num(),
            target.sigma_range.into(),
            target.sigma_velocity.into(),
            f64::from(target.verdict as u8),
            found.line.phase.into(),
            found.covariance.into(),
            range.range.to_num(),
            range.uncertainty.into(),
            f64::from(u8::from(range.is_sure())),
            range.odds.into(),
            budget.total()[0].into(),
            budget.parts[0].velocity.into(),
            by_phase.total()[0].into(),
            moved.metres.to_num(),
        ]
    };
    frame.targets().iter().map(row).collect()
}

/// Blocks of each kind and length on a board in an emulator: a tenth, unless PICKET_LONG asks for as many as here.
fn long() -> bool {
    std::env::var_os("PICKET_LONG").is_some()
}

fn checksums(program: &Path, blocks: u32, arithmetic: &str, directory: Option<&Path>) -> String {
    let mut command = Command::new(program);
    command.args([&blocks.to_string(), arithmetic]).args(directory);
    said(&mut command)
}

/// The fields of a `picket_tone` in a file.
struct Answer {
    frequency_hz: f64,
    sigma_hz: f64,
    snr: f32,
    verdict: u8,
    also: u8,
}

fn answers(file: &Path) -> Vec<Answer> {
    let bytes = fs::read(file).unwrap();
    let tones = bytes.as_chunks::<32>().0.iter();
    let double =
        |tone: &[u8; 32], at: usize| f64::from_le_bytes(tone[at..at + 8].try_into().unwrap());
    let answer = |tone: &[u8; 32]| Answer {
        frequency_hz: double(tone, 0),
        sigma_hz: double(tone, 8),
        snr: f32::from_le_bytes(tone[16..20].try_into().unwrap()),
        verdict: tone[28],
        also: tone[29],
    };
    tones.map(answer).collect()
}

#[test]
fn ten_thousand_blocks_of_each_kind_are_those_of_picket_analyze() {
    needs("gcc", "gcc");
    let program = program("gcc", "bits.c", &[]);
    for (word, arithmetic) in [("float", Arithmetic::Target), ("fixed", Arithmetic::TargetFixed)] {
        // As many in either arithmetic in the long form; half of a minute for the usual one.
        let blocks = if word == "float" || long() { 10_000 } else { 1_000 };
        let place = temporary(word);
        checksums(&program, blocks, word, Some(&place));
        for (kind, n, parts) in kinds() {
            let seen = answers(&place.join(format!("{kind}.tones")));
            assert_eq!(seen.len(), blocks as usize, "{kind}");
            let records = place.join(format!("{kind}.i16"));
            let analysis = analysis(n, parts == 2, arithmetic);
            let (mut index, mut good) = (0, 0);
            let sink = |answer: analyze::Answer| {
                let Answer { frequency_hz, sigma_hz, snr, verdict, also } = seen[index];
                let what = format!("{kind}, {word}, block {index}");
                let verdict = picket_dsp::Verdict::from_u8(verdict).unwrap();
                assert_eq!(answer.verdict, verdict.name(), "{what}");
                let also = picket_dsp::Verdicts::from_bits(also);
                assert_eq!(
                    answer.also,
                    also.iter().map(|v| v.name()).collect::<Vec<_>>(),
                    "{what}"
                );
                assert_eq!(
                    answer.frequency_hz.map(f64::to_bits),
                    Some(frequency_hz.to_bits()),
                    "{what}"
                );
                let finite = sigma_hz.is_finite().then_some(sigma_hz);
                assert_eq!(answer.sigma_hz, finite, "{what}");
                if let Some(snr_db) = answer.snr_db {
                    assert!((snr_db - 10.0 * f64::from(snr).log10()).abs() < 1e-4, "{what}");
                }
                good += usize::from(verdict == picket_dsp::Verdict::Good);
                index += 1;
            };
            analyze::run(&records, &analysis, sink, |_| ()).unwrap();
            assert_eq!(index, seen.len(), "{kind}");
            // All sorts of blocks: most are steady tones, and not all.
            assert!((seen.len() / 4..seen.len() * 19 / 20).contains(&good), "{kind}: {good} good");
            fs::remove_file(records).unwrap();
            println!("{kind}, {word}: {index} blocks the same, {good} of them good");
        }
    }
}

fn analysis(n: usize, iq: bool, arithmetic: Arithmetic) -> Analysis {
    let read = recording::Options {
        format: Some(Format::I16),
        rate_hz: Some(48_000.0),
        iq,
        ..recording::Options::default()
    };
    Analysis { read, n: Some(n), ..Analysis::new(Codes::signed::<12>(), arithmetic) }
}

/// The compiler's words for a core, and the archive's place.
const M4F: (&[&str], &str, &str) = (
    &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    "cortex-m4/fpv4-sp-d16-hard",
    "mps2-an386",
);
/// QEMU has no Cortex-M0 with enough memory: a Cortex-M3 runs its instructions.
const M0: (&[&str], &str, &str) =
    (&["-mcpu=cortex-m0plus", "-mthumb"], "cortex-m0plus", "mps2-an385");

const CROSS: &str = "arm-none-eabi-gcc";

/// A program for a core without a library of C.
fn bare(name: &str, core: (&[&str], &str, &str), defines: &[&str]) -> PathBuf {
    let dist = dist();
    let out = temporary("bare").join(format!("{name}-{}.elf", core.2));
    let mut command = Command::new(CROSS);
    command.args(["-std=c99", "-O2", "-ffreestanding", "-fno-tree-loop-distribute-patterns"]);
    command.args(["-ffunction-sections", "-fdata-sections", "-nostdlib", "-nostartfiles"]);
    command.args(core.0).args(["-Wall", "-Wextra", "-Werror", "-DBARE"]).args(defines);
    command.arg("-I").arg(dist.join("src")).arg(source("start.c")).arg(source(name));
    command.arg(dist.join("src").join(core.1).join("libpicket.a"));
    command.args(["-lgcc", "-Wl,--gc-sections,-z,noexecstack", "-T"]).arg(source("mps2.ld"));
    said(command.arg("-o").arg(&out));
    out
}

/// What a program says on an emulated board.
fn emulated(machine: &str, image: &Path) -> String {
    let mut command = Command::new(needed(qemu()));
    command.args(["-machine", machine, "-nographic", "-monitor", "none", "-serial", "null"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(image);
    // The emulator writes what a program says by semihosting to stderr.
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    assert!(output.status.success(), "{machine}: {}\n{text}", output.status);
    text
}

/// The M4F measures the bits of a desk, and the M0 those of its arithmetic there.
#[test]
fn boards_measure_the_same_bits() {
    needs("gcc", "gcc");
    needs(CROSS, "gcc-arm-none-eabi");
    let program = program("gcc", "bits.c", &[]);
    let blocks = if long() { 10_000 } else { 300 };
    for (core, arithmetic) in [(M4F, "float"), (M0, "fixed")] {
        let define = format!("-DBLOCKS={blocks}");
        let image = bare("bits.c", core, &[&define]);
        let seen = emulated(core.2, &image);
        let here = checksums(&program, blocks, arithmetic, None);
        assert_eq!(here.lines().count(), 14, "{here}");
        assert_eq!(seen.replace('\r', ""), here, "{}", core.1);
        println!("{}: {blocks} blocks of each of 14 kinds and lengths the same", core.1);
    }
}

/// What a program with one tone and its verdict takes in C, beside the one in Rust.
#[test]
fn a_program_in_c_is_little_larger_than_a_small_one_in_rust() {
    needs(CROSS, "gcc-arm-none-eabi");
    let image = bare("single.c", M4F, &[]);
    let ours = Footprint::from_elf(&image).unwrap();
    let rust = Firmware {
        bin: "single",
        target: Target::M4f,
        features: &["mps2"],
        profile: Profile::Release,
    };
    let rust = needed(rust.build());
    let rust = Footprint::from_elf(&rust).unwrap();
    println!("C: {ours:?}, Rust: {rust:?}");
    // As docs/c.md has it.
    assert!(ours.flash <= rust.flash + 8_192, "C takes {ours:?}, Rust {rust:?}");
    let said = emulated(M4F.2, &image);
    assert!(said.is_empty(), "{said}");
}
