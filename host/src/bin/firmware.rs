//! `cargo firmware`: builds and lints the images for every core, with whatever toolchain is at hand.

use clap::{Parser, Subcommand};
use picket_host::cli;
use picket_host::emulator::{Footprint, RunError};
use picket_host::toolchain::{self, Firmware, Profile, Target};
use std::process::ExitCode;

/// Works on the firmware images.
#[derive(Parser)]
#[command(name = "cargo firmware", version)]
struct Options {
    #[command(subcommand)]
    work: Work,
}

#[derive(Subcommand)]
enum Work {
    /// Lints the library and the images for every core; warnings are errors
    Clippy,
    /// Builds the images for every core they run on and prints their sizes
    Size,
}

const TARGETS: [Target; 4] = [Target::M0, Target::M3, Target::M4f, Target::M33];

fn main() -> ExitCode {
    cli::main(|options: Options| match options.work {
        Work::Clippy => clippy(),
        Work::Size => size(),
    })
}

fn clippy() -> Result<ExitCode, RunError> {
    for target in TARGETS {
        // The M0 has no board yet: its library alone.
        let features: &[&str] = if target == Target::M0 { &[] } else { &["mps2"] };
        toolchain::lint(target, features)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn size() -> Result<ExitCode, RunError> {
    println!("{:15} {:26} {:8} {:>8} {:>8}", "image", "core", "profile", "flash B", "RAM B");
    for (bin, targets) in [("frontend_qemu", &TARGETS[3..]), ("core_check", &TARGETS[1..])] {
        for &target in targets {
            for profile in [Profile::Release, Profile::Size] {
                let image = Firmware { bin, target, features: &["mps2"], profile }.build()?;
                let Footprint { flash, ram } = Footprint::of(&image)?;
                let (core, profile) = (target.triple(), profile.name());
                println!("{bin:15} {core:26} {profile:8} {flash:8} {ram:8}");
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
