//! How fast a recording is measured. It prints figures; no time fails a test.

use crate::cli::file;
use picket_dsp::acquire::codes::Codes;
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// What Python does with NumPy: the transform, its largest bin and a parabola through the logarithms around it, block by block.
const NUMPY: &str = "
import sys, time, wave, numpy as np
sound = wave.open(sys.argv[1])
bytes = sound.readframes(sound.getnframes())
begun = time.perf_counter()
x, n, found = np.frombuffer(bytes, '<i2'), 4096, []
for start in range(0, len(x) - n + 1, n):
    power = np.abs(np.fft.rfft(x[start:start + n]))
    k = int(power.argmax())
    a, b, c = np.log(power[k - 1:k + 2])
    found.append((k + .5 * (a - c) / (a - 2 * b + c)) * 48000 / n)
print(len(found) / (time.perf_counter() - begun))
";

/// Ten minutes at 48 kHz in blocks of 4096 samples, on one core: `picket analyze` with its reading of the file, and NumPy
/// without. Seed 44.
#[test]
#[ignore = "prints how fast this machine is: cargo test -p picket-host --test all -- --ignored --nocapture speed"]
fn ten_minutes() {
    let path = file("ten-minutes.wav", &[]);
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 48_000,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    let (mut rng, normal) = (ChaCha8Rng::seed_from_u64(44), Normal::new(0.0, 400.0).unwrap());
    let noise: Vec<f64> = normal.sample_iter(&mut rng).take(1 << 16).collect();
    for index in 0..600 * 48_000u32 {
        let turns = f64::from(index) * 1234.5 / 48e3;
        let tone = 8000.0 * (std::f64::consts::TAU * turns.fract()).sin();
        writer.write_sample((tone + noise[index as usize % noise.len()]).round() as i16).unwrap();
    }
    writer.finalize().unwrap();
    let analysis =
        Analysis { n: Some(4096), ..Analysis::new(Codes::signed::<16>(), Arithmetic::Target) };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut best = 0.0f64;
    for _ in 0..3 {
        let begun = Instant::now();
        let good = one.install(|| {
            let mut good = 0;
            let sink = |answer: analyze::Answer| {
                let off = (answer.frequency_hz.unwrap() - 1234.5) / answer.sigma_hz.unwrap();
                assert!(off.abs() < 6.0, "{answer:?}");
                good += u32::from(answer.verdict == "good");
            };
            let summary = analyze::run(Path::new(&path), &analysis, sink, |_| ()).unwrap();
            assert_eq!(summary.blocks, 7031);
            good
        });
        best = best.max(7031.0 / begun.elapsed().as_secs_f64());
        assert!(good > 7000, "{good}");
    }
    println!("picket analyze: {best:.0} blocks of 4096 samples a second on one core");
    let python = std::env::var("PICKET_PYTHON").unwrap_or("python3".into());
    let numpy =
        Command::new(python).args(["-c", NUMPY, &path]).env("OMP_NUM_THREADS", "1").output();
    match numpy.ok().filter(|output| output.status.success()) {
        Some(output) => {
            println!("NumPy: {} of them", String::from_utf8_lossy(&output.stdout).trim())
        }
        None => println!("NumPy is not here"),
    }
}
