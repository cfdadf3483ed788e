//! No feature of the library changes an answer. Cargo unifies features: what another dependency of a program turns on must not
//! change what the program measures.

use picket_dsp::{Codes, Iq, Real};
use picket_host::simulate::{Width, generator};
use picket_host::toolchain::dependents;
use picket_lab::impair::{Impairment, Setup};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the library may be built with: features with code on the way of a measurement, each alone, then all of them.
const SETS: [&str; 5] = [
    "",
    "methods",
    "joint-fit",
    "microfft",
    "methods,joint-fit,microfft,portable-atomic,defmt,serde",
];

/// The seed of the records.
const SEED: u64 = 38;

/// As many records are compared, or a few more.
const RECORDS: usize = 10_000;

#[test]
fn no_feature_changes_an_answer() {
    let directory = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("features");
    fs::create_dir_all(&directory).unwrap();
    let path = directory.join("records");
    let (file, count) = records();
    fs::write(&path, file).unwrap();
    let answers = SETS.map(|features| answers(&directory, features, &path));
    println!("{count} records, seed {SEED}:\n{}", answers[0]);
    for (features, answer) in SETS.iter().zip(&answers) {
        // The effort of a default plan is that of a program: its rounds are there with the joint fit.
        let alike = |answer: &str| -> Vec<String> {
            let rounds = features.contains("joint-fit");
            let compared =
                answer.lines().filter(|line| !(rounds && line.starts_with("default plan")));
            compared.map(str::to_owned).collect()
        };
        assert_eq!(alike(answer), alike(&answers[0]), "with the features {features:?}");
    }
    // What is compared must have been answered: by either arithmetic, every path.
    for path in ["fixed", "float", "default plan", "frequency only", "harmonic", "lines", "rise"] {
        assert!(answers[0].contains(&format!("{path}: ")), "{path} answered nothing");
    }
}

/// What the program says of the records when the library has these features.
fn answers(directory: &Path, features: &str, records: &Path) -> String {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(dependents().join("features")).args(["build", "--quiet", "--locked"]);
    cargo.args(["--features", features, "--target-dir"]).arg(directory);
    assert!(cargo.status().unwrap().success(), "it does not build with {features:?}");
    let mut program = Command::new(directory.join("debug/picket-on-features"));
    let output = program.arg(records).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Records of every impairment at its default severities, as the program reads them, and how many they are.
fn records() -> (Vec<u8>, usize) {
    let impairments = Impairment::all();
    let converters = [(12, 0.0), (12, 10.0), (12, 20.0), (12, 40.0), (16, 70.0)];
    let mut cells = Vec::new();
    for (n, (bits, snr_db)) in [128, 256, 1024].into_iter().flat_map(|n| converters.map(|c| (n, c)))
    {
        let setup = setup(n, bits, snr_db);
        for impairment in &impairments {
            let kinds = [(false, impairment.fits::<Real>()), (true, impairment.fits::<Iq>())];
            let kinds = kinds.into_iter().filter(|(_, fits)| *fits);
            cells.extend(kinds.map(|(iq, _)| (impairment, iq, bits, setup.clone())));
        }
    }
    let (mut file, mut count) = (Vec::new(), 0);
    while count < RECORDS {
        for (impairment, iq, bits, setup) in &cells {
            let mut rng = generator(SEED, count as u64);
            let record = match iq {
                false => impairment.record::<Real>(setup, &mut rng),
                true => impairment.record::<Iq>(setup, &mut rng),
            };
            file.extend([u8::from(*iq), setup.n.trailing_zeros() as u8, *bits]);
            for sample in record.samples {
                let parts = [sample.re, sample.im];
                let parts = parts.iter().take(1 + usize::from(*iq));
                file.extend(parts.flat_map(|&part| (part as i16).to_le_bytes()));
            }
            count += 1;
        }
    }
    (file, count)
}

fn setup(n: usize, bits: u8, snr_db: f64) -> Setup {
    let codes = if bits == 12 { Codes::signed::<12>() } else { Codes::signed::<16>() };
    let mut setup = Setup::new(n, snr_db);
    setup.width = Width::Codes(codes);
    setup
}
