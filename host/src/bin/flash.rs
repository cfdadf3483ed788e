//! `cargo flash`: builds the NUCLEO's image, shows its size and writes it to the board.

use clap::Parser;
use picket_host::cli;
use picket_host::flash::{self, FlashError};
use std::process::ExitCode;

/// Builds the NUCLEO-F446RE's image and writes it to the board.
#[derive(Parser)]
#[command(name = "cargo flash", version)]
struct Options {
    /// The image that also follows tones from block to block: see `follow` in docs/board.md
    #[arg(long)]
    tracking: bool,
    /// Stops before the probe
    #[arg(long)]
    dry_run: bool,
}

fn main() -> ExitCode {
    cli::main(|options: Options| -> Result<ExitCode, FlashError> {
        let image = flash::build(options.tracking)?;
        println!("{image}");
        if !options.dry_run {
            flash::write(&image)?;
            println!("written: cargo watch-device -- /dev/ttyACM0");
        }
        Ok(ExitCode::SUCCESS)
    })
}
