//! Sets cfgs for what the target's core can do, and nothing else, so that dependents are unaffected.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(armv8m)");
    println!("cargo:rustc-check-cfg=cfg(dsp)");
    println!("cargo:rustc-check-cfg=cfg(mve)");
    println!("cargo:rustc-check-cfg=cfg(short_products)");
    if variable("CARGO_CFG_TARGET_ARCH") != "arm" || variable("CARGO_CFG_TARGET_OS") != "none" {
        return;
    }
    if has_dsp() {
        println!("cargo:rustc-cfg=dsp");
    }
    if has_mve() {
        println!("cargo:rustc-cfg=mve");
    }
    if variable("TARGET").starts_with("thumbv8m.main") && !has_dsp() {
        println!(
            "cargo:warning=picket-dsp: portable kernels; a Cortex-M33 needs -Ctarget-cpu=cortex-m33 for the fast ones"
        );
    }
    if variable("TARGET").starts_with("thumbv8m") {
        println!("cargo:rustc-cfg=armv8m");
    }
    // Armv6-M multiplies to 32 bits only.
    if variable("TARGET").starts_with("thumbv6m") {
        println!("cargo:rustc-cfg=short_products");
    }
}

/// Whether the core has the DSP extension. Only a nightly compiler shows `target_feature = "dsp"`. Every Armv7E-M
/// has the extension; an Armv8-M has it if the core's name says so.
fn has_dsp() -> bool {
    const CORES: [&str; 4] = ["cortex-m33", "cortex-m35p", "cortex-m55", "cortex-m85"];
    shows("dsp") || variable("TARGET").starts_with("thumbv7em") || CORES.contains(&&*core())
}

/// Whether the core has Helium, the vectors of Armv8.1-M. A core of this name has them unless a flag takes
/// them away.
fn has_mve() -> bool {
    const CORES: [&str; 2] = ["cortex-m55", "cortex-m85"];
    let flags = variable("CARGO_ENCODED_RUSTFLAGS");
    let taken = flags.split(['=', ',', '\x1f']).any(|flag| flag == "-mve");
    shows("mve") || (CORES.contains(&&*core()) && !taken)
}

/// Whether the compiler shows this feature of the target.
fn shows(feature: &str) -> bool {
    variable("CARGO_CFG_TARGET_FEATURE").split(',').any(|shown| shown == feature)
}

/// The core that the flags name last, as the compiler takes them.
fn core() -> String {
    let flags = variable("CARGO_ENCODED_RUSTFLAGS");
    let (_, name) = flags.rsplit_once("target-cpu=").unwrap_or_default();
    name.split('\x1f').next().unwrap_or_default().into()
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}
