//! `cargo watch-device`: an instrument's measurements, live.

use picket_host::{cli, watch};
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main(|options: watch::Options| watch::run(&options))
}
