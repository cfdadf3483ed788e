//! `lab`: see [`picket_lab::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    picket_lab::cli::main()
}
