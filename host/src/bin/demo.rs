//! `cargo demo`: the main job without hardware.

use picket_host::cli;
use picket_host::demo::{self, options::Options};
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main(|options: Options| demo::run(&options))
}
