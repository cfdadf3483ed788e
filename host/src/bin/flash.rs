//! `cargo flash`: builds the NUCLEO's image, shows its size and writes it to the board.

use clap::Parser;
use picket_host::cli;
use picket_host::flash::{self, FlashError};
use std::process::ExitCode;

/// Builds the NUCLEO-F446RE's image and writes it to the board.
#[derive(Parser)]
#[command(name = "cargo flash", version)]
struct Options {
    /// Stops before the probe
    #[arg(long)]
    dry_run: bool,
}

fn main() -> ExitCode {
    cli::main(|options: Options| -> Result<ExitCode, FlashError> {
        let image = flash::build()?;
        println!("{image}");
        if !options.dry_run {
            flash::write(&image)?;
            println!("written: cargo watch-device -- /dev/ttyACM0");
        }
        Ok(ExitCode::SUCCESS)
    })
}
