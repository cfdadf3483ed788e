//! Two hundred wrong invocations through the real program: each ends in one line, with exit code 2. `PICKET_TYPED_SEED` gives others.

use crate::cli::seed;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Wrong values of an option, by command. `@` is a good recording.
const VALUES: &[(&str, &str, &[&str])] = &[
    (
        "analyze @",
        "--n",
        &["0", "-1", "abc", "1e3", "99999999999", "18446744073709551616", "", "7"],
    ),
    ("analyze @", "--hop", &["0", "x", "-5"]),
    ("analyze @", "--skip", &["-1", "x", "99999999"]),
    (
        "analyze @ --n 1024",
        "--band",
        &["1", "1:", ":", "5:1", "a:b", "nan:nan", "0.1:0.2", "1e9:2e9", "-5:-1", "0:inf"],
    ),
    ("analyze @", "--method", &["x", "", "rife,,", "fesa", ",", "ml,zzz", "RIFE!"]),
    ("analyze @", "--k", &["0", "3", "99", "x"]),
    ("analyze @", "--arith", &["f16", ""]),
    ("analyze @", "--bits", &["0", "11", "99", "x"]),
    ("analyze @", "--scale", &["0", "-1", "nan", "inf", "x", "1e300", "1e-30"]),
    ("analyze @", "--rate", &["0", "-1", "nan", "inf", "x", "", "1e300", "1e-30"]),
    ("analyze @", "--format", &["mp3", "", "csv", "npy", "json"]),
    ("analyze @", "--channel", &["0", "x", "3", "1,", "1,9", "-1", "1,2,3"]),
    ("analyze @ --n 256", "--false-alarm", &["0", "-1", "1", "2", "x", "nan"]),
    ("analyze @", "--carrier-hz", &["0", "-1", "x", "inf"]),
    ("analyze @ --carrier-hz 24e9", "--mixing", &["x", "", "tx", "RX-CONJ-TX"]),
    ("analyze @", "--plot", &["x.gif", "noname", "/nowhere/x.svg"]),
    ("analyze @ --n 256", "--most", &["x", "0", "5"]),
    ("analyze @ --track --n 256", "--most", &["x", "300", "9"]),
    ("explain @", "--block", &["-1", "x", "", "999999", "1.5"]),
    ("explain @ --block 0", "--plot", &["x.gif", "noname", "/nowhere/x.svg"]),
    ("web", "--port", &["x", "-1", "99999", ""]),
    ("c", "--core", &["x", "", "m9", "m4f,x"]),
    ("c --core host", "--out", &["/dev/null/x"]),
    ("demo", "--scenario", &["x", "moon", ""]),
    ("demo", "--snr-db", &["x", "nan", "999", "inf"]),
    ("demo", "--seed", &["-1", "x"]),
    ("demo", "--seeds", &["0", "x", "99999", "-1"]),
    ("demo", "--versus", &["x", ""]),
    ("demo", "--method", &["x", "fesa", ""]),
    ("demo", "--replay", &["/nowhere/x.wav", "/tmp", ""]),
    ("demo", "--rate", &["48000", "x"]),
    ("demo", "--plot", &["x.gif", "noname", "/nowhere/x.svg"]),
    ("demo --scenario radar", "--plot", &["x.svg"]),
    ("demo --scenario ldv", "--plot", &["x.gif", "/nowhere/x.svg"]),
    ("demo", "--linewidth-hz", &["x", "0", "-1", "nan"]),
    ("demo", "--sweep-error", &["x", "0.25", "-1", "nan"]),
    ("demo --scenario turntable", "--spot-mm", &["x", "0", "-1", "1000", "nan"]),
    ("demo --replay @", "--n", &["5", "x", "0"]),
    ("demo --replay @", "--band", &["9000:9001", "100.1:100.2", "x"]),
    ("demo --replay @", "--carrier-hz", &["0", "-1", "x"]),
    ("demo --replay @", "--snr-db", &["3"]),
    ("watch -", "--rate", &["0", "-1", "x", "nan", "1e300"]),
    ("watch -", "--count", &["0", "x", "-1"]),
    ("watch", "--replay", &["/nowhere/x", "/tmp", "@", ""]),
    ("watch -", "--record", &["/nowhere/x", "/tmp"]),
    ("watch -", "--set-settings", &["/nowhere/x", "@", "/tmp"]),
    ("watch -", "--capture", &["3", "x", "99999999"]),
    ("calibrate -", "--reference", &["0", "-1", "x", "nan", "1e300"]),
    ("calibrate - --reference 1k", "--seconds", &["0", "-1", "x", "nan"]),
    ("calibrate --reference 1k", "--replay", &["/nowhere/x", "/tmp", "@", ""]),
];

/// Wrong as they stand.
const WHOLE: &[&str] = &[
    "",
    "x",
    "--x",
    "help x",
    "analyze",
    "analyze no-such-file.wav",
    "analyze /tmp --format i16 --rate 8",
    "analyze @ @",
    "analyze @ --json --csv",
    "analyze @ --track --method rife",
    "analyze @ --most 2 --method rife",
    "analyze @ --most 2 --n 1000",
    "analyze @ --harmonics 1",
    "analyze @ --harmonics 33",
    "analyze @ --harmonics 5 --most 2",
    "analyze @ --harmonics 5 --track",
    "analyze @ --harmonics 5 --n 1000",
    "analyze @ --most 2 --plot x.svg",
    "analyze @ --iq",
    "analyze noise.wav",
    "analyze noise.csv",
    "analyze noise.json",
    "analyze noise.npy",
    "analyze empty.wav",
    "analyze text.dat --rate 1000",
    "analyze nameless",
    "analyze - --rate 1000",
    "analyze odd.bin --rate 9",
    "analyze either.csv --rate 9",
    "analyze two.csv --n 16",
    "analyze zeros.json",
    "explain",
    "explain @",
    "explain no-such-file.wav --block 0",
    "explain @ --block 0 --method rife",
    "demo --scenario drive --versus rife",
    "demo --scenario drive --method rife",
    "demo --scenario turntable --seeds 3",
    "demo --scenario turntable --linewidth-hz 1k",
    "demo --scenario ldv --sweep-error 0.01",
    "demo --scenario ldv --method rife",
    "demo --scenario wind --log",
    "demo --scenario fan --method fesa-real",
    "demo --spot-mm 1",
    "demo --seeds 3 --plot x.svg",
    "demo --scenario board",
    "demo --scenario board --record /nowhere/x.bin",
    "demo --scenario board --record x.bin --snr-db 3",
    "demo --scenario board --record x.bin --json",
    "demo --record x.bin",
    "demo x",
    "watch /nowhere/port",
    "watch /dev/null",
    "watch noise.wav",
    "watch /tmp",
    "watch -",
    "watch - --stop",
    "watch - --csv --jsonl",
    "watch --replay noise.wav",
    "watch --replay empty.wav",
    "watch - --start --stop",
    "watch --install-udev -",
    "calibrate -",
    "calibrate /nowhere/port --reference 1k",
    "calibrate - --reference 1k",
    "calibrate - --reference 1k --save",
    "calibrate --replay empty.wav --reference 1k",
    "flash --x",
    "flash x",
    "completions",
    "completions x",
    "man x",
    "man demo x",
];

fn folder(name: &str, rng: &mut ChaCha8Rng) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 8000,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut good = hound::WavWriter::create(folder.join("good.wav"), spec).unwrap();
    (0..4096).for_each(|n| good.write_sample((9e3 * (0.6 * f64::from(n)).sin()) as i16).unwrap());
    good.finalize().unwrap();
    let noise: Vec<u8> = (0..9000).map(|_| rng.random()).collect();
    for name in ["noise.wav", "noise.csv", "noise.json", "noise.npy"] {
        fs::write(folder.join(name), &noise).unwrap();
    }
    fs::write(folder.join("empty.wav"), []).unwrap();
    fs::write(folder.join("odd.bin"), [1, 2, 3]).unwrap();
    fs::write(folder.join("nameless"), [1, 0]).unwrap();
    fs::write(folder.join("zeros.json"), [0; 4096]).unwrap();
    fs::write(folder.join("text.dat"), "1.0\n2.0\n".repeat(100)).unwrap();
    fs::write(folder.join("either.csv"), "1,250\n2,125\n0,500\n".repeat(9)).unwrap();
    let two: String =
        (0..99).map(|n| format!("{:e},{},{}\n", 1e-6 * f64::from(n), n % 7, n % 5)).collect();
    fs::write(folder.join("two.csv"), two).unwrap();
    folder
}

/// An option's name with a letter more, less, or another, and no other option's.
fn misspelt(name: &str, rng: &mut ChaCha8Rng) -> String {
    loop {
        let mut letters: Vec<char> = name.chars().collect();
        let at = rng.random_range(2..letters.len());
        match rng.random_range(0..3) {
            0 => letters.insert(at, rng.random_range('a'..='z')),
            1 if letters.len() > 4 => drop(letters.remove(at)),
            _ => letters[at] = rng.random_range('0'..='9'),
        }
        let name: String = letters.into_iter().collect();
        if VALUES.iter().all(|(_, option, _)| *option != name) {
            return name;
        }
    }
}

/// Runs the program, and says whether it had to be ended after 20 s.
fn run(arguments: &[String], folder: &Path) -> (Output, bool) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_picket"))
        .args(arguments)
        .current_dir(folder)
        .env("RUST_BACKTRACE", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Read as it comes: a pipe holds little.
    let mut stdout = child.stdout.take().unwrap();
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        stdout.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    let slow = child.try_wait().unwrap().is_none();
    let _ = child.kill();
    let output = child.wait_with_output().unwrap();
    (Output { stdout: reader.join().unwrap(), ..output }, slow)
}

#[test]
fn wrong_invocations_are_told_in_a_line() {
    let mut rng = ChaCha8Rng::seed_from_u64(seed(200));
    let folder = folder("bad", &mut rng);
    let words = |text: &str| -> Vec<String> {
        text.split_whitespace().map(|word| word.replace('@', "good.wav")).collect()
    };
    let mut invocations: BTreeSet<Vec<String>> = WHOLE.iter().map(|text| words(text)).collect();
    for (command, option, values) in VALUES {
        for value in *values {
            let value = value.replace('@', "good.wav");
            invocations.insert([words(command), vec![(*option).into(), value]].concat());
        }
        // Without its value, and misspelt.
        invocations.insert([words(command), vec![(*option).into()]].concat());
        invocations.insert([words(command), vec![misspelt(option, &mut rng), "1".into()]].concat());
    }
    println!("{} wrong invocations", invocations.len());
    assert!(invocations.len() >= 200);
    let mut wrong = Vec::new();
    for arguments in &invocations {
        let (output, slow) = run(arguments, &folder);
        let message = String::from_utf8_lossy(&output.stderr);
        println!("{} -> {}", arguments.join(" "), message.trim_end());
        let one_line = message.lines().count() == 1 && message.starts_with("error: ");
        // `picket watch` lists the machine's ports above its line.
        let told = one_line && message.trim_end().len() > 20 && !message.contains("panicked");
        let plain = ["invalid digit", "literal", "empty string", "target type"];
        let told = told && !plain.iter().any(|jargon| message.contains(jargon));
        // A number below zero is a value, and what is wrong with it is told.
        let number = |rest: &str| rest.starts_with(|letter: char| letter.is_ascii_digit());
        let told = told && !message.split_once("argument '-").is_some_and(|(_, rest)| number(rest));
        if slow || output.status.code() != Some(2) || !told || !output.stdout.is_empty() {
            wrong
                .push(format!("{arguments:?}: {:?}, slow {slow}: {message}", output.status.code()));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), invocations.len(), wrong.join("\n"));
}

/// Headers of which any byte may be anything: never a panic, and never silence.
#[test]
fn damaged_headers() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("damaged");
    fs::create_dir_all(&folder).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed(201));
    let mut header = b"RIFF\x24\x20\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0data\0\x20\0\0".to_vec();
    header
        .extend((0..4096).flat_map(|n| ((9e3 * (0.6 * f64::from(n)).sin()) as i16).to_le_bytes()));
    let array = b"\x93NUMPY\x01\x00\x46\0{'descr': '<i2', 'fortran_order': False, 'shape': (2000,), }          \n";
    let array = [&array[..], &header[44..4044]].concat();
    for trial in 0..60 {
        let (mut bytes, name) =
            if trial % 2 == 0 { (header.clone(), "x.wav") } else { (array.clone(), "x.npy") };
        for _ in 0..rng.random_range(1..4) {
            bytes[rng.random_range(0..44)] = rng.random();
        }
        bytes.truncate(rng.random_range(1..9000));
        let path = folder.join(name);
        fs::write(&path, &bytes).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_picket"))
            .args(["analyze", "--rate", "8000", "--n", "64"])
            .arg(&path)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        let answered = output.status.success() && !output.stdout.is_empty();
        let told = output.status.code() == Some(2) && message.starts_with("error: ");
        assert!(answered || told, "trial {trial}: {:?}: {message}", output.status);
    }
}

/// Right as they stand. `@` is a good recording.
const RIGHT: &[&str] = &[
    "analyze @",
    "analyze @ --n 256 --hop 64 --band 100:2000 --method rife,z-rife --json",
    "analyze @ --n 512 --most 3 --carrier-hz 24e9",
    "analyze @ --n 64 --track --carrier-hz 24e9 --mixing tx-conj-rx",
    "analyze @ --n 64 --most 4 --track --csv",
    "analyze @ --bits 16 --arith target --k 4 --false-alarm 1e-3",
    "analyze text.dat --format csv --rate 1000 --scale 100 --n 64",
    "analyze two.csv --column 2 --n 64",
    "watch --replay session.bin --csv",
    "completions bash",
    "man analyze",
    "help analyze",
];

/// A letter more, less, or another in one of the words, or a word more, less, or elsewhere.
fn damage(words: &mut Vec<String>, rng: &mut ChaCha8Rng) {
    const ANY: &[u8] = b"-0123456789.,:=eEnNx@ \"'";
    let at = rng.random_range(0..words.len());
    let mut letters: Vec<char> = words[at].chars().collect();
    // Most other letters in a number make it none.
    let digits = letters.iter().any(char::is_ascii_digit) && rng.random_range(0..3) > 0;
    let choice = if digits { &ANY[1..11] } else { ANY };
    let letter = char::from(choice[rng.random_range(0..choice.len())]);
    let place = rng.random_range(0..=letters.len());
    match rng.random_range(0..7) {
        0 if words.len() > 1 => drop(words.remove(at)),
        1 => words.insert(at, words[at].clone()),
        2 => words.swap(0, at),
        3 | 4 if place < letters.len() => {
            letters[place] = letter;
            words[at] = letters.into_iter().collect();
        }
        5 if place < letters.len() => {
            letters.remove(place);
            words[at] = letters.into_iter().collect();
        }
        _ => {
            letters.insert(place, letter);
            words[at] = letters.into_iter().collect();
        }
    }
}

/// Right lines of which a letter or a word is another: whatever they come to, it is said.
#[test]
fn damaged_lines() {
    let mut rng = ChaCha8Rng::seed_from_u64(seed(202));
    let folder = folder("lines", &mut rng);
    let session = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/session.bin");
    fs::copy(session, folder.join("session.bin")).unwrap();
    let (mut wrong, mut refused) = (Vec::new(), 0);
    for trial in 0..180 {
        let line = RIGHT[trial % RIGHT.len()].replace('@', "good.wav");
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        damage(&mut words, &mut rng);
        let (output, slow) = run(&words, &folder);
        let message = String::from_utf8_lossy(&output.stderr);
        let said = match output.status.code() {
            Some(0) => !output.stdout.is_empty() || !message.is_empty(),
            Some(1 | 2) => {
                refused += 1;
                message.lines().last().is_some_and(|line| line.starts_with("error: "))
            }
            _ => false,
        };
        if slow || !said || message.contains("panicked") {
            wrong.push(format!("{words:?}: {}, slow {slow}: {message}", output.status));
        }
    }
    println!("{refused} of 180 lines were refused");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!((90..175).contains(&refused), "{refused} of 180 lines were refused");
}
