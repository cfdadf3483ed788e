//! How fast a recording is measured. It prints figures; no time fails a test.

use crate::cli::{recorded, tones};
use picket_dsp::acquire::codes::Codes;
use picket_host::analyze::{self, Analysis};
use picket_host::arithmetic::Arithmetic;
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
/// without.
#[test]
#[ignore = "prints how fast this machine is: cargo test -p picket-host --test all -- --ignored --nocapture speed"]
fn ten_minutes() {
    let path = recorded("ten-minutes.wav", &tones(600 * 48_000, &[(1234.5, 8000.0, 0.0)], 400.0));
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
