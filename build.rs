//! Gives firmware its memory map and its linker script; does nothing for the host.

use std::path::PathBuf;
use std::{env, fs, io};

/// Origin and length of program memory, origin and length of data memory.
type Map = [u32; 4];

/// QEMU mps2-an385, an386, an500: SSRAM 1 at 0 holds the program, SSRAM 2 and 3 the data.
const AN386: Map = [0x0000_0000, 4 << 20, 0x2000_0000, 4 << 20];
/// QEMU mps2-an505, secure side.
const AN505: Map = [0x1000_0000, 4 << 20, 0x3800_0000, 4 << 20];

fn main() -> io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-check-cfg=cfg(an505)");
    println!("cargo:rustc-check-cfg=cfg(armv8m)");
    println!("cargo:rustc-check-cfg=cfg(dsp)");
    println!("cargo:rustc-check-cfg=cfg(short_products)");
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return Ok(());
    }
    if has_dsp() {
        println!("cargo:rustc-cfg=dsp");
    }
    // Armv6-M multiplies to 32 bits only.
    if variable("TARGET").starts_with("thumbv6m") {
        println!("cargo:rustc-cfg=short_products");
    }
    let armv8m = variable("TARGET").starts_with("thumbv8m");
    if armv8m {
        println!("cargo:rustc-cfg=armv8m");
    }
    if env::var_os("CARGO_FEATURE_MPS2").is_some() {
        if armv8m {
            println!("cargo:rustc-cfg=an505");
        }
        let names = ["_flash_origin", "_flash_length", "_ram_origin", "_ram_length"];
        for (name, value) in names.iter().zip(if armv8m { AN505 } else { AN386 }) {
            println!("cargo:rustc-link-arg-bins=--defsym={name}={value:#x}");
        }
    }
    // The last 4 KiB of memory stand for the registers that the host plays.
    if env::var_os("CARGO_FEATURE_PLAYED").is_some() {
        println!("cargo:rustc-link-arg-bins=--defsym=_ram_length={:#x}", 124 << 10);
    }
    let out = PathBuf::from(variable("OUT_DIR"));
    // The images name their interrupt handlers in the vector table itself.
    fs::write(out.join("device.x"), "")?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    if env::var_os("CARGO_FEATURE_LOG").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}

/// Does the core have the DSP extension? A stable compiler does not tell (`target_feature = "dsp"` is shown by
/// nightly ones only): every Armv7E-M has it, an Armv8-M where its name says so.
fn has_dsp() -> bool {
    let told = variable("CARGO_CFG_TARGET_FEATURE").split(',').any(|feature| feature == "dsp");
    let flags = variable("CARGO_ENCODED_RUSTFLAGS");
    told || variable("TARGET").starts_with("thumbv7em") || flags.contains("target-cpu=cortex-m33")
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}
