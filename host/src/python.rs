//! `picket python`: the wheel of the module `picket_dsp`.

use crate::toolchain::{Need, ToolError, build_wheel, have};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Builds the wheel for Python, for `pip install`. It needs Python 3.10 or later, and gets maturin itself.
#[derive(Args, Debug)]
pub struct Options {
    /// The folder for the wheel
    #[arg(long, value_name = "DIR", default_value = "dist")]
    out: PathBuf,
}

/// Builds the wheel and prints where it is.
pub fn run(options: &Options) -> Result<ExitCode, ToolError> {
    have(&[Need::Python])?;
    let wheel = build_wheel(&options.out)?;
    outln!("{}", wheel.display());
    Ok(ExitCode::SUCCESS)
}
