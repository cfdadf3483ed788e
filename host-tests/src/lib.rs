//! Tests of Picket that need more than one module; see `tests/`.

pub mod figures;

use picket_host::toolchain::{Firmware, Profile, Target, ToolError, lacks_packages, prepare};
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
            let targets: Vec<Target> = Target::ALL.into_iter().filter(|&t| builds_for(t)).collect();
            let _ = prepare(&targets, &["mps2"]);
        }
    });
}

/// Builds all images of a core that the tests run, at their first need: one after the other they would leave half of the host
/// idle. What does not build is told by the test that wants it.
pub fn prepare_images(target: Target) {
    static PREPARED: Mutex<Vec<Target>> = Mutex::new(Vec::new());
    let mut prepared = PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    if prepared.contains(&target) {
        return;
    }
    prepared.push(target);
    prepare_packages();
    let (bin, others): (_, &[_]) = match target {
        Target::M4f if every_image() => {
            ("core_check", &["bench", "bench_q15", "bench_f32", "bench_locked", "bench_several"])
        }
        Target::M4f => ("core_check", &["bench", "bench_locked"]),
        Target::M3 => ("core_check", &["bench_locked", "bench_short"]),
        Target::M33 => ("frontend_qemu", &["tracker_qemu"]),
        Target::M0 | Target::M55 => return,
    };
    let _ = Firmware { bin, target, features: &["mps2"], profile: Profile::Release }
        .build_beside(others);
}

/// Whether the variable `PICKET_IMAGES` is `all`: the images of the 16-bit and of the float engine and of several tones are
/// built, too, and the proof of freedom from panics is made for size as well as for speed.
pub fn every_image() -> bool {
    images().is_some_and(|which| which == "all")
}

/// Whether images are built for a core: for the Cortex-M4F, whose image the M7 runs, and the M33 always; for the M3 and the
/// M0 if `PICKET_IMAGES` is `cores` or `all`, for the M55 if it is `all`. Each core takes a minute and a half of compiling.
fn builds_for(target: Target) -> bool {
    match target {
        Target::M4f | Target::M33 => true,
        Target::M3 | Target::M0 => images().is_some(),
        Target::M55 => every_image(),
    }
}

/// What the variable `PICKET_IMAGES` asks for.
fn images() -> Option<String> {
    let which = std::env::var("PICKET_IMAGES").ok()?;
    assert!(["cores", "all"].contains(&&*which), "PICKET_IMAGES is `cores` or `all`, not {which}");
    Some(which)
}

/// Whether images are built for a core; a test that needs one otherwise says that it was skipped.
pub fn has_core(target: Target) -> bool {
    let built = builds_for(target);
    if !built {
        let value = if target == Target::M55 { "all" } else { "cores" };
        println!("skipped: images for {} are built only with PICKET_IMAGES={value}", target.name());
    }
    built
}

/// As [`every_image`], and a test that needs such an image says that it was skipped.
pub fn has_image(which: &str) -> bool {
    if !every_image() {
        println!("skipped: {which} is built only with PICKET_IMAGES=all");
    }
    every_image()
}

/// A file of the reference material, which lies beside the repository or where `PICKET_SHARED` says. Where it
/// is absent a test can only say that it was skipped: `None`, and that line is printed.
pub fn shared(name: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let folder = std::env::var("PICKET_SHARED").unwrap_or(beside.into());
    let path = Path::new(&folder).join(name);
    if !path.exists() {
        println!("skipped: no ../shared/{name}");
        return None;
    }
    Some(path)
}

/// How many records a statistical test takes: `short` ones, or `long` if the variable `PICKET_LONG` is set.
pub fn sized(short: u64, long: u64) -> u64 {
    if std::env::var_os("PICKET_LONG").is_some() { long } else { short }
}

/// What a tool gave. What a machine without network or without a program cannot have is skipped, and the reason is printed; any
/// other failure fails the test.
pub fn had<T>(result: Result<T, ToolError>) -> Option<T> {
    match result {
        Ok(had) => Some(had),
        Err(ToolError::Build { output, .. }) if lacks_packages(&output) => {
            println!("skipped: the packages cannot be had: {output}");
            None
        }
        Err(error @ ToolError::Missing { .. }) => {
            println!("skipped: {error}");
            None
        }
        Err(ToolError::Build { output, .. }) => panic!("{output}"),
        Err(error) => panic!("{error}"),
    }
}
