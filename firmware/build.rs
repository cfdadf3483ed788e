//! Gives the images their memory map and their linker scripts. It does nothing for the host.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Origin and length of program memory, origin and length of data memory.
type Map = [u32; 4];

/// QEMU mps2-an385, an386, an500: SSRAM 1 at 0 holds the program, SSRAM 2 and 3 the data.
const AN386: Map = [0x0000_0000, 4 << 20, 0x2000_0000, 4 << 20];
/// QEMU mps2-an505, secure side.
const AN505: Map = [0x1000_0000, 4 << 20, 0x3800_0000, 4 << 20];
/// QEMU mps3-an547, secure side: SRAM holds the program, DTCM the data.
const AN547: Map = [0x1100_0000, 2 << 20, 0x3000_0000, 512 << 10];
/// RP2040 with 2 MiB of flash, behind the second boot stage; the last 8 KiB hold settings.
const PICO: Map = [0x1000_0100, (2 << 20) - 256 - (8 << 10), 0x2000_0000, 264 << 10];

fn main() -> io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../memory.x");
    println!("cargo:rustc-check-cfg=cfg(an505)");
    println!("cargo:rustc-check-cfg=cfg(an547)");
    println!("cargo:rustc-check-cfg=cfg(short_products)");
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return Ok(());
    }
    if variable("TARGET").starts_with("thumbv6m") {
        println!("cargo:rustc-cfg=short_products");
    }
    // Only images link. Someone else's board that uses the instrument's loop brings its own memory
    // and scripts.
    if has("CORES") {
        let armv8m = variable("TARGET").starts_with("thumbv8m");
        // The core that the flags name last, as the compiler takes them.
        let flags = variable("CARGO_ENCODED_RUSTFLAGS");
        let m55 = flags.rsplit("target-cpu=").next().is_some_and(|f| f.starts_with("cortex-m55"));
        match (armv8m, m55) {
            (true, true) => {
                println!("cargo:rustc-cfg=an547");
                println!("cargo:rerun-if-changed=an547.x");
                define(AN547);
                println!("cargo:rustc-link-arg-bins=-T{}/an547.x", variable("CARGO_MANIFEST_DIR"));
            }
            (true, false) => {
                println!("cargo:rustc-cfg=an505");
                define(AN505);
            }
            _ => define(AN386),
        }
    }
    // The last 4 KiB of memory stand for the registers that the host plays.
    if has("PLAYED") {
        println!("cargo:rustc-link-arg-bins=--defsym=_ram_length={:#x}", 124 << 10);
    }
    if has("PICO") {
        println!("cargo:rerun-if-changed=pico.x");
        define(PICO);
        // Before the scripts of all images, so that it takes its sections first.
        println!("cargo:rustc-link-arg-bins=-T{}/pico.x", variable("CARGO_MANIFEST_DIR"));
    }
    if has("CORES") || has("NUCLEO") || has("PICO") {
        let out = PathBuf::from(variable("OUT_DIR"));
        let memory = Path::new(&variable("CARGO_MANIFEST_DIR")).join("../memory.x");
        fs::copy(memory, out.join("memory.x"))?;
        // The images name their interrupt handlers in the vector table itself.
        fs::write(out.join("device.x"), "")?;
        println!("cargo:rustc-link-arg-bins=-L{}", out.display());
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
    if has("LOG") || has("DEFMT") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}

/// Gives memory.x its symbols.
fn define(map: Map) {
    let names = ["_flash_origin", "_flash_length", "_ram_origin", "_ram_length"];
    for (name, value) in names.iter().zip(map) {
        println!("cargo:rustc-link-arg-bins=--defsym={name}={value:#x}");
    }
}

fn has(feature: &str) -> bool {
    env::var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}
