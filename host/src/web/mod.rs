//! `picket web`: the live page, built, served on this machine, photographed.

pub mod browser;
mod site;

use crate::end;
use crate::output::Output;
use crate::toolchain::{Need, ToolError, have};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

pub use site::{FILES, MODULES, Site};

/// Shows the live page: the library in a browser, on a simulated scene, a recording, the microphone or the board.
#[derive(Args, Debug)]
pub struct Options {
    /// The port on localhost; 0 for any free one
    #[arg(long, default_value_t = 8000)]
    port: u16,
    /// Only builds the page: target/web/page can be put on any static host
    #[arg(long, conflicts_with = "port")]
    build: bool,
    /// Only makes the documentation's pictures, in this folder
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["port", "build"])]
    pictures: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// Builds the page, and serves it until the user ends it.
///
/// # Errors
/// A tool is missing, the page does not build, or the port is taken.
pub fn run(options: &Options) -> Result<ExitCode, ToolError> {
    let pictures: &[Need] = match options.pictures {
        Some(_) => &[Need::Node, Need::Browser],
        None => &[],
    };
    have(&[&[Need::Page], pictures].concat())?;
    if options.pictures.is_some() {
        browser::prepared()?;
    }
    let site = Site::build()?;
    if options.build {
        crate::cli::print_line(&site.folder().display().to_string());
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(folder) = &options.pictures {
        let served = site.serve(0)?;
        for line in browser::pictures(&served.address(), folder, options.output)? {
            crate::cli::print_line(&line);
        }
        return Ok(ExitCode::SUCCESS);
    }
    let served = site.serve(options.port)?;
    crate::cli::print_line(&format!("{} (Ctrl-C ends it)", served.address()));
    end::look();
    while end::asked().is_none() {
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(ExitCode::SUCCESS)
}
