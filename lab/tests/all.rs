//! The developers' program as it is run, as one program: it is compiled and linked once.

mod campaign;
mod impair;
mod misuse;
mod overwrite;
mod paths;
#[path = "../../host/tests/program.rs"]
mod program;
mod readme;
mod report;
mod soak;
mod trust;

/// The program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_lab");
