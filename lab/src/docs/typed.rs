//! What `picket` itself prints, below the command that prints it.

use super::Table;
use crate::toolchain;
use std::process::Command;

pub(super) const TABLES: &[Table] = &[
    Table::new("docs/precision.md", "drive", drive).slow(),
    Table::new("docs/precision.md", "replay", replay).slow(),
    Table::new("docs/signals.md", "ldv", |_| end("demo --scenario ldv --plot ldv.svg")),
    Table::new("docs/signals.md", "wind", |_| end("demo --scenario wind --plot wind.svg")),
    Table::new("docs/signals.md", "fan", |_| end("demo --scenario fan --plot fan.svg")).slow(),
];

/// What `picket` prints with these arguments, in a folder of its own.
///
/// # Errors
/// What it says when it fails.
pub(super) fn said(arguments: &str) -> Result<String, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    // By cargo, which builds it first where it is behind.
    let mut command = Command::new("cargo");
    let manifest = toolchain::workspace().join("Cargo.toml");
    command.args(["run", "--quiet", "--package", "picket-host", "--manifest-path"]).arg(manifest);
    command.arg("--").args(arguments.split_whitespace()).current_dir(&folder);
    let output = command.output().map_err(|error| error.to_string())?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!("picket {arguments}: {}", errors.trim_end()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// A block of a command and of lines that it prints.
fn block<'a>(command: &str, lines: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let head = ["```console".to_owned(), format!("$ cargo picket {command}")];
    let lines = lines.into_iter().map(|line| line.trim_end().to_owned());
    head.into_iter().chain(lines).chain(["```".to_owned()]).collect()
}

/// The summary behind the last empty line.
fn end(command: &str) -> Result<Vec<String>, String> {
    let text = said(command)?;
    let text = text.trim_end();
    let (_, last) = text.rsplit_once("\n\n").unwrap_or(("", text));
    Ok(block(command, ["..."].into_iter().chain(last.lines())))
}

fn drive(_: &Table) -> Result<Vec<String>, String> {
    let command = "demo --scenario drive --plot drive.svg";
    let text = said(command)?;
    let at = text.find("tracked in").ok_or("the drive has no summary")?;
    Ok(block(command, text.get(at..).unwrap_or_default().trim_end().lines()))
}

/// An excerpt: the head, and rows of the car.
fn replay(_: &Table) -> Result<Vec<String>, String> {
    let options = "--rate 48000 --n 4096 --band 300:2500 --carrier-hz 24e9";
    let file = super::recordings::data("cw24_car_moto_towards_i16_48000.bin");
    let text = said(&format!("demo --replay {} {options}", file.display()))?;
    let of_car = |line: &&str| {
        let block = line.split_whitespace().next().and_then(|word| word.parse::<u32>().ok());
        block.is_none_or(|block| [17, 18, 19, 20, 29, 30].contains(&block))
    };
    let begin = text.lines().skip_while(|line| !line.starts_with("block"));
    Ok(block(&format!("demo --replay car.bin {options}"), begin.filter(of_car)))
}
