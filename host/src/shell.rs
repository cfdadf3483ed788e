//! `picket completions` and `picket man`: what a shell and `man` want to know of the commands.

use crate::cli::{self, Picket};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man as Page;
use std::process::ExitCode;

/// Prints the completions for a shell, for example: picket completions bash > ~/.local/share/bash-completion/completions/picket
#[derive(Args, Debug)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the manual page, of the program or of one command: picket man demo | man -l -
#[derive(Args, Debug)]
pub struct Man {
    /// The command
    command: Option<String>,
}

/// Prints completions.
pub fn completions(options: &Completions) -> Result<ExitCode, String> {
    let mut text = Vec::new();
    clap_complete::generate(options.shell, &mut Picket::command(), "picket", &mut text);
    cli::print(&String::from_utf8_lossy(&text));
    Ok(ExitCode::SUCCESS)
}

/// Prints a manual page.
pub fn man(options: &Man) -> Result<ExitCode, String> {
    let mut picket = Picket::command();
    picket.build();
    let page = match &options.command {
        None => picket,
        Some(name) => {
            let found = picket.find_subcommand(name).cloned();
            found.ok_or_else(|| format!("there is no command {name}: `picket help` lists all"))?
        }
    };
    let mut text = Vec::new();
    Page::new(page).render(&mut text).map_err(|error| error.to_string())?;
    cli::print(&String::from_utf8_lossy(&text));
    Ok(ExitCode::SUCCESS)
}
