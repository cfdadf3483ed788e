//! No image can panic: its panic handler calls a function that does not exist, so that it links only
//! if the optimiser has found no way to a panic. Images that log are left out: the logger holds panics. At opt-level "z"
//! the board's image stands for the front end.

use host_tests::prepare_packages;
use picket_host::toolchain::{Firmware, Profile, Target, ToolError};

/// The function that does not exist.
const SYMBOL: &str = "picket_can_panic";

fn link(bin: &str, target: Target, profile: Profile, features: &[&str]) -> Result<(), ToolError> {
    prepare_packages();
    Firmware { bin, target, features, profile }.build_quietly().map(drop)
}

fn assert_proved(bin: &str, target: Target, profiles: &[Profile]) {
    for &profile in profiles {
        if let Err(error) = link(bin, target, profile, &["mps2"]) {
            panic!("{bin} for {target:?}, {profile:?}: {error}\n{error:?}");
        }
        println!("{bin} for {target:?}, {profile:?}: no panic can be reached");
    }
}

#[test]
#[ignore = "needs images of the Cortex-M3: cargo test --test all -- --ignored"]
fn the_core_cannot_panic_on_cortex_m3() {
    assert_proved("core_check", Target::M3, &[Profile::Release]);
}

#[test]
fn the_core_cannot_panic_on_cortex_m4f() {
    assert_proved("core_check", Target::M4f, &[Profile::Release]);
}

#[test]
#[ignore = "needs one more image: cargo test --test all -- --ignored"]
fn the_core_cannot_panic_on_cortex_m4f_for_every_kind() {
    let link = link("core_check", Target::M4f, Profile::Release, &["mps2", "every-kind"]);
    link.unwrap_or_else(|error| panic!("{error}\n{error:?}"));
}

#[test]
#[ignore = "needs one more image: cargo test --test all -- --ignored"]
fn the_core_for_size_cannot_panic_on_cortex_m4f() {
    assert_proved("core_check", Target::M4f, &[Profile::Size]);
}

/// The float engine's transform is a crate that indexes and unwraps: only an optimiser for speed sees that none of it fails.
#[test]
#[ignore = "needs an image of the float engine: cargo test --test all -- --ignored"]
fn the_float_engine_cannot_panic_on_cortex_m4f() {
    assert_proved("bench_f32", Target::M4f, &[Profile::Release]);
}

/// Several tones, their phases and what is made of them.
#[test]
#[ignore = "needs an image of several tones: cargo test --test all -- --ignored"]
fn further_tones_cannot_panic_on_cortex_m4f() {
    assert_proved("bench_several", Target::M4f, &[Profile::Release]);
}

/// Frames of chirps, ranges by phase, a clock beside another.
#[test]
#[ignore = "needs an image of frames: cargo test --test all -- --ignored"]
fn frames_cannot_panic_on_cortex_m4f() {
    assert_proved("bench_frames", Target::M4f, &[Profile::Release]);
}

#[test]
fn the_instrument_cannot_panic_on_cortex_m33() {
    assert_proved("frontend_qemu", Target::M33, &[Profile::Release]);
}

#[test]
#[ignore = "needs images of the Cortex-M55: cargo test --test all -- --ignored"]
fn the_kernels_cannot_panic_on_cortex_m55() {
    assert_proved("kernels", Target::M55, &[Profile::Release]);
}

#[test]
fn the_boards_image_cannot_panic() {
    if let Err(error) = link("frontend_nucleo", Target::M4f, Profile::Balanced, &["nucleo"]) {
        panic!("{error}\n{error:?}");
    }
}

#[test]
#[ignore = "needs images of the Cortex-M0: cargo test --test all -- --ignored"]
fn the_picos_image_cannot_panic() {
    if let Err(error) = link("frontend_pico", Target::M0, Profile::Release, &["pico"]) {
        panic!("{error}\n{error:?}");
    }
}

/// The proof can fail: a panic that can be reached, though only by a capture of a million blocks, is
/// found.
#[test]
fn a_deliberate_panic_is_found() {
    let features = ["mps2", "deliberate-panic"];
    match link("tracker_qemu", Target::M33, Profile::Release, &features) {
        Err(ToolError::Build { output, .. }) => assert!(output.contains(SYMBOL), "{output}"),
        other => panic!("the image must not link: {other:?}"),
    }
}
