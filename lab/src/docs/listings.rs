//! The sizes of the images of `dependents/`, and the chips that the library fits.

use super::Table;
use super::figures::{Budget, head, measured, row, whole};

const PAGE: &str = "docs/own-board.md";

pub(super) const TABLES: &[Table] = &[
    Table::new("README.md", "chips", chips),
    Table::new(PAGE, "chips", chips),
    Table::new(PAGE, "sizes", sizes),
    Table::new(PAGE, "size", size),
];

fn bytes(package: &str) -> Result<[String; 2], String> {
    Ok(measured(&format!("{package}, bytes of flash and RAM"))?.map(whole))
}

fn sizes(_: &Table) -> Result<Vec<String>, String> {
    const PACKAGES: [&str; 12] = [
        "stm32f4",
        "embassy-stm32",
        "embassy-stm32g4",
        "rp2040",
        "rp2350",
        "embassy-rp",
        "nrf52840",
        "esp32c3",
        "embassy-stm32-instrument",
        "embassy-rp-instrument",
        "bgt60tr13c-stm32f4",
        "bgt60tr13c-rp2350",
    ];
    let mut lines = head("| package, at opt-level `s` | flash, B | RAM without the stack, B |");
    for package in PACKAGES {
        let [flash, ram] = bytes(package)?;
        lines.push(row([format!("`{package}`"), flash, ram]));
    }
    Ok(lines)
}

fn size(_: &Table) -> Result<Vec<String>, String> {
    let [flash, ram] = bytes("skeleton")?;
    let head = head("| the skeleton's image | flash, B | RAM without the stack, B |");
    Ok([head, vec![row([String::new(), flash, ram])]].concat())
}

/// What a tone's measurement leaves of common chips: program memory by the budget of the smallest images, RAM by that of a pipeline with
/// two records.
fn chips(_: &Table) -> Result<Vec<String>, String> {
    /// The chips, their cores, and their flash and RAM in KB.
    const CHIPS: [(&str, &str, u32, u32); 5] = [
        ("STM32G031 (64 KB, 8 KB)", "M0", 64, 8),
        ("STM32F103C8 (64 KB, 20 KB)", "M3", 64, 20),
        ("STM32F103RC (256 KB, 48 KB)", "M3", 256, 48),
        ("STM32F401RE (512 KB, 96 KB)", "M4F", 512, 96),
        ("RP2040 (2 MB, 264 KB)", "M0", 2048, 264),
    ];
    const LENGTHS: [u32; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
    let budget = Budget::read()?;
    let mut lines = head(
        "| chip (flash, RAM) | for size, KB | for speed, KB | longest real record | longest I/Q record |",
    );
    for (name, core, flash, ram) in CHIPS {
        let room = f64::from(flash) * 1024.0;
        let program = |which: u32| -> Result<String, String> {
            let bytes = budget.at(&format!("/single_images/{core}/{which}"))?;
            let kilobytes = format!("{:.0}", bytes / 1024.0);
            Ok(if bytes <= room { kilobytes } else { format!("{kilobytes}: too much") })
        };
        // A quarter of the RAM is the stack's and the driver's.
        let memory = 0.75 * f64::from(ram) * 1024.0;
        let fixed = budget.at("/engines/picket-i32/ram_bytes/1024")? - 8.0 * 1024.0;
        let longest = |bytes_a_sample: f64| {
            let fits = |n: &&u32| fixed + bytes_a_sample * f64::from(**n) <= memory;
            LENGTHS.iter().rev().find(fits).map_or("none".to_owned(), u32::to_string)
        };
        lines.push(row([name.to_owned(), program(0)?, program(1)?, longest(8.0), longest(16.0)]));
    }
    Ok(lines)
}
