//! `picket`: see [`picket_host::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    picket_host::cli::main()
}
