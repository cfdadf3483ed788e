//! Recordings that other programs wrote: NumPy, SciPy, libsndfile, h5py, the SigMF library; and what a person types for them.
//! `tests/data/write.py` writes them.

use picket_recording::{Format, Options, Recording, Sample};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

const RATE_HZ: f64 = 8000.0;
const TONE_HZ: f64 = 987.6;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn open(name: &str, options: Options) -> Result<Recording, String> {
    Recording::open(&path(name), options).map_err(|error| error.to_string())
}

/// The share of the power, without the mean, that is the tone's.
fn share(samples: &[Sample], iq: bool) -> f64 {
    let n = samples.len() as f64;
    let mean = samples.iter().map(|it| it.value).sum::<num_complex::Complex<f64>>() / n;
    // I/Q recordings turn backwards.
    let turn = if iq { -TONE_HZ } else { TONE_HZ } / RATE_HZ * TAU;
    let mut sum = num_complex::Complex::new(0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        sum += (sample.value - mean) * num_complex::Complex::from_polar(1.0, -turn * k as f64);
    }
    let power: f64 = samples.iter().map(|it| (it.value - mean).norm_sqr()).sum();
    sum.norm_sqr() / n / power * if iq { 1.0 } else { 2.0 }
}

/// The tone is there, with all of its samples and its rate, and its codes use 16 bits where the format has more.
#[track_caller]
fn holds(name: &str, iq: bool, knows_rate: bool, options: Options) -> Recording {
    let recording = open(name, options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((recording.iq(), recording.knows_rate()), (iq, knows_rate), "{name}");
    if knows_rate {
        assert!((recording.rate_hz() - RATE_HZ).abs() < 0.01, "{name}: {}", recording.rate_hz());
    } else {
        assert_eq!(recording.rate_hz(), 1.0);
    }
    let samples: Result<Vec<Sample>, _> = recording.samples().collect();
    let samples = samples.unwrap();
    assert_eq!(samples.len(), 1024, "{name}");
    let share = share(&samples, iq);
    assert!(share > 0.998, "{name}: {share}");
    let loudest = samples.iter().map(|it| it.value.re.abs().max(it.value.im.abs()));
    let loudest = loudest.fold(0.0, f64::max);
    let whole = ["16-bit.flac", "rf64.wav", "pairs.cs16", "pairs.sigmf-meta", "pairs.sigmf-data"];
    let own = whole.contains(&name) || name.starts_with("archive") || name.ends_with('8');
    let most = if own { 20_000.0..24_000.0 } else { 27_000.0..30_000.0 };
    assert!(most.contains(&loudest), "{name}: {loudest}");
    open(name, options).unwrap()
}

#[test]
fn files_that_tell_everything() {
    let plain = Options::default();
    for name in ["double.wav", "24-bit.wav", "rf64.wav", "16-bit.flac", "scope.csv"] {
        holds(name, false, true, plain);
    }
    for name in ["stored.npz", "compressed.npz", "real.mat", "audacity.txt"] {
        holds(name, false, true, plain);
    }
    for name in ["complex.mat", "pairs.sigmf-meta", "pairs.sigmf-data", "archive.sigmf"] {
        holds(name, true, true, plain);
    }
}

/// h5py's files of either age, chunked and packed, with a rate among the attributes or a column of times.
#[test]
fn hdf5() {
    let plain = Options::default();
    holds("real.h5", false, true, plain);
    holds("times.h5", false, true, plain);
    holds("complex.h5", true, true, plain);
    holds("chirps.h5", true, false, plain);
    assert_eq!(open("chirps.h5", plain).unwrap().row(), Some(64));
    let whole = open("latest.h5", plain).unwrap().samples().map(Result::unwrap);
    assert!((share(&whole.collect::<Vec<_>>(), false) - 1.0).abs() < 0.002);
}

#[test]
fn files_without_a_rate_are_read() {
    let plain = Options::default();
    for name in ["double.npy", "big-endian.npy", "real.f64"] {
        holds(name, false, false, plain);
    }
    for name in ["complex.npy", "pairs.cf32", "pairs.cf64", "pairs.cs16", "pairs.cs8", "pairs.cu8"]
    {
        holds(name, true, false, plain);
        holds(name, true, true, Options { rate_hz: Some(RATE_HZ), ..plain });
    }
}

/// One word picks a channel, or two of them, in every format that has several.
#[test]
fn channels_are_picked_alike() {
    let channel = |first, second| Options { channel: Some((first, second)), ..Options::default() };
    let iq = Options { iq: true, ..Options::default() };
    for name in ["rows.npy", "compressed.mat"] {
        holds(name, false, name.ends_with("mat"), channel(2, None));
    }
    holds("fortran.npy", false, false, channel(1, None));
    for name in ["extensible.wav", "24-bit.flac"] {
        holds(name, true, true, iq);
        holds(name, true, true, channel(1, Some(2)));
        assert!(open(name, Options::default()).unwrap_err().contains("--iq"), "{name}");
    }
    let exchanged = open("pairs.cf32", channel(2, Some(1))).unwrap();
    let samples: Vec<Sample> = exchanged.samples().map(Result::unwrap).collect();
    assert!(share(&samples, true) < 0.01);
    holds("unicode.txt", false, true, channel(2, None));
    assert!(open("compressed.mat", Options::default()).unwrap_err().contains("2 (ch1), 3 (ch2)"));
    assert!(open("rows.npy", channel(4, None)).unwrap_err().contains("choose 1 to 3"));
}

/// Two readings are possible: it is said what to type, and both of that work.
#[test]
fn what_may_be_either_is_asked() {
    let asked = open("unnamed.raw", Options::default()).unwrap_err();
    assert!(asked.contains("--format f32 or cf32"), "{asked}");
    let cf32 = Options { format: Some(Format::Cf32), ..Options::default() };
    holds("unnamed.raw", true, false, cf32);
}

/// A cell without a number does not end the recording; its block knows.
#[test]
fn a_missing_sample_is_counted() {
    let recording = holds("unicode.txt", false, true, Options::default());
    let mut blocks = recording.blocks(256, 256, 0);
    let mut missing = Vec::new();
    while blocks.next_block().unwrap().is_some() {
        missing.push(blocks.missing());
    }
    assert_eq!(missing, [0, 0, 1, 0]);
    assert_eq!(blocks.recording().missed(), 1);
}

/// Eight bits of an oscilloscope in volts keep their steps.
#[test]
fn steps_are_kept() {
    let recording = open("scope.csv", Options::default()).unwrap();
    let step = 0.0008 * recording.scaling().factor;
    assert!((step - step.round()).abs() < 0.02 && step > 200.0, "{step}");
    for sample in recording.samples().map(Result::unwrap) {
        let code = sample.value.re / step;
        // Rounded as the file is printed, to a hundredth of a step.
        assert!((code - code.round()).abs() < 0.02, "{code}");
    }
}

/// Damaged files end in one line, whatever is cut off or turned over.
#[test]
fn damaged_files_are_refused() {
    for entry in std::fs::read_dir(path("")).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        for cut in [1, 3, 20, 100, 300, bytes.len() / 2, bytes.len() - 1] {
            for turned in [false, true] {
                let mut bytes = bytes[..cut.min(bytes.len())].to_vec();
                if turned {
                    let at = bytes.len() / 3;
                    bytes[at] ^= 0xFF;
                }
                match Recording::from_bytes(&path, bytes, Options::default()) {
                    Err(error) => assert!(!error.to_string().contains('\n')),
                    Ok(recording) => recording.samples().for_each(|sample| {
                        let _ = sample.map_err(|error| assert!(!error.to_string().contains('\n')));
                    }),
                }
            }
        }
    }
}
