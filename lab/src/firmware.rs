//! `lab firmware`: builds and lints the images for every core, with whatever toolchain is at hand.

use crate::emulator::{Footprint, RunError};
use crate::toolchain::{self, Firmware, Need, Profile, Target};
use clap::{Args, Subcommand};
use std::process::ExitCode;

/// Works on the firmware images.
#[derive(Args, Debug)]
pub struct Options {
    #[command(subcommand)]
    work: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    /// Lints the library and the images for every core; warnings are errors
    Clippy {
        /// The boards' own images and QEMU's alone, one of each
        #[arg(long)]
        boards: bool,
    },
    /// Builds the images for every core they run on and prints their sizes
    Size {
        /// Each image once, for size where it can be built so: whether all of them link
        #[arg(long)]
        once: bool,
    },
}

/// Images for a core, and the features of their board.
type Images = (Target, &'static [&'static str], &'static [&'static str]);

/// One image of each board.
const BOARDS: [Images; 3] = [
    (Target::M0, &["frontend_pico"], &["pico"]),
    (Target::M4f, &["frontend_nucleo"], &["nucleo"]),
    (Target::M33, &["frontend_qemu"], &["mps2"]),
];

/// The images for each core, with the board's feature. The M0's benchmark runs on the M3's board.
const IMAGES: [Images; 11] = [
    (Target::M0, &["bench"], &["mps2"]),
    (Target::M0, &["frontend_pico"], &["pico"]),
    (Target::M0, &["frontend_pico"], &["usb"]),
    (Target::M0, &["frontend_pico"], &["usb", "defmt"]),
    (Target::M3, &["bench", "bench_locked", "core_check"], &["mps2"]),
    (
        Target::M4f,
        &["bench", "bench_locked", "bench_several", "bench_short", "core_check", "single"],
        &["mps2"],
    ),
    (Target::M4f, &["frontend_nucleo"], &["nucleo"]),
    (Target::M4f, &["frontend_nucleo"], &["nucleo", "defmt"]),
    (Target::M4f, &["frontend_nucleo"], &["brown-out"]),
    (Target::M33, &["bench", "core_check", "frontend_qemu", "tracker_qemu"], &["mps2"]),
    (
        Target::M55,
        &["bench", "bench_short", "core_check", "frontend_qemu", "kernels", "tracker_qemu"],
        &["mps2"],
    ),
];

/// Does the work.
pub fn run(options: &Options) -> Result<ExitCode, RunError> {
    match options.work {
        Work::Clippy { boards: true } => clippy(&BOARDS),
        Work::Clippy { boards: false } => clippy(&IMAGES),
        Work::Size { once } => size(once),
    }
}

/// Fails before the first build if one of the images cannot be built.
fn have(images: &[Images]) -> Result<(), RunError> {
    let needs: Vec<Need> = images.iter().map(|&(target, ..)| Need::Core(target)).collect();
    Ok(toolchain::have(&needs)?)
}

fn clippy(images: &[Images]) -> Result<ExitCode, RunError> {
    have(images)?;
    for &(target, images, features) in images {
        toolchain::lint(target, images, features)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// How an image is built. `bench_several` counts, and is built for speed alone: for size the conversions of `fixed` stay calls, in which
/// the linker sees a panic that their callers have ruled out.
fn profiles(bin: &str) -> &'static [Profile] {
    match bin {
        "bench_several" => &[Profile::Release],
        _ => &[Profile::Release, Profile::Size],
    }
}

fn size(once: bool) -> Result<ExitCode, RunError> {
    have(&IMAGES)?;
    outln!(
        "{:16} {:26} {:15} {:8} {:>8} {:>8}",
        "image",
        "core",
        "features",
        "profile",
        "flash B",
        "RAM B"
    );
    for (target, images, features) in IMAGES {
        for &bin in images {
            let profiles = profiles(bin);
            let built = if once { profiles.len() - 1 } else { 0 };
            for &profile in profiles.iter().skip(built) {
                let image = Firmware { bin, target, features, profile }.build()?;
                let Footprint { flash, ram } = Footprint::from_elf(&image)?;
                let (core, profile, features) = (target.name(), profile.name(), features.join(","));
                outln!("{bin:16} {core:26} {features:15} {profile:8} {flash:8} {ram:8}");
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
