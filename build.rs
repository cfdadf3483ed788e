//! Gives firmware its memory map and its linker script; does nothing for the host.

use std::path::PathBuf;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(an505)");
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return Ok(());
    }
    let mps2 = env::var_os("CARGO_FEATURE_MPS2").is_some();
    // In the root a memory.x would hide the chosen one: the linker looks there first.
    let memory = match (mps2, variable("TARGET").starts_with("thumbv8m")) {
        (false, _) => "memory/nucleo_f446re.x",
        (true, false) => "memory/an386.x",
        (true, true) => "memory/an505.x",
    };
    if memory == "memory/an505.x" {
        println!("cargo:rustc-cfg=an505");
    }
    println!("cargo:rerun-if-changed={memory}");
    let out = PathBuf::from(variable("OUT_DIR"));
    fs::copy(memory, out.join("memory.x"))?;
    // The images name their interrupt handlers in the vector table itself.
    fs::write(out.join("device.x"), "")?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    if env::var_os("CARGO_FEATURE_LOG").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}
