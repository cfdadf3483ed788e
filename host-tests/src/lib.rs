//! Tests of Picket that need more than one module; see `tests/`.

pub use picket_claims::figures;

use picket_host::toolchain::{Firmware, Profile, Target, ToolError, prepare};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once, PoisonError};

/// Compiles what the images of every core take of other packages, once for all tests: for one core after the other it would leave
/// half of the host idle. Whoever wants an image calls this first. A run of some tests alone, by their names, wants few cores:
/// it compiles as it goes.
pub fn prepare_packages() {
    static PREPARED: Once = Once::new();
    let filtered = std::env::args().skip(1).any(|argument| !argument.starts_with('-'));
    PREPARED.call_once(|| {
        if !filtered {
            let targets: Vec<Target> =
                if has_ignored() { Target::ALL.to_vec() } else { vec![Target::M4f, Target::M33] };
            let _ = prepare(&targets, &["mps2"]);
        }
    });
}

/// Builds all images of a core that the tests run, at their first need: one after the other they would leave half of the host
/// idle. An image that fails to build is reported by the test that needs it.
pub fn prepare_images(target: Target) {
    static PREPARED: Mutex<Vec<Target>> = Mutex::new(Vec::new());
    let mut prepared = PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    if prepared.contains(&target) {
        return;
    }
    prepared.push(target);
    prepare_packages();
    let (bin, others): (_, &[_]) = match target {
        Target::M4f if has_ignored() => {
            ("core_check", &["bench", "bench_f32", "bench_locked", "bench_several"])
        }
        Target::M4f => ("core_check", &["bench", "bench_locked"]),
        Target::M3 => ("core_check", &["bench_locked", "bench_short"]),
        Target::M33 => ("frontend_qemu", &["tracker_qemu"]),
        Target::M0 | Target::M55 => return,
    };
    let _ = Firmware { bin, target, features: &["mps2"], profile: Profile::Release }
        .build_beside(others);
}

/// Whether this run has the tests that are ignored, whose images a plain run does not build.
fn has_ignored() -> bool {
    std::env::args().any(|argument| ["--ignored", "--include-ignored"].contains(&&*argument))
}

/// A file of `host-tests/data`, whose README says where it comes from.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// The recording of a generator's tone, which is not in the repository: `PICKET_TONE_1KHZ` names it.
pub fn tone_1khz() -> PathBuf {
    let file = std::env::var_os("PICKET_TONE_1KHZ");
    file.expect("PICKET_TONE_1KHZ names tone_1kHz_pcm2900_i16_44100.bin: host-tests/data/README.md")
        .into()
}

/// How many records a statistical test takes: `short` ones, or `long` if the variable `PICKET_LONG` is set.
pub fn sized(short: u64, long: u64) -> u64 {
    if figures::long() { long } else { short }
}

/// What a tool gave; the test fails with what it says, and with the command that gets what is missing.
pub fn needed<T>(result: Result<T, ToolError>) -> T {
    match result {
        Ok(had) => had,
        Err(ToolError::Build { output, .. }) => panic!("{output}"),
        Err(error) => panic!("{error}"),
    }
}
