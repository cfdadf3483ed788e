//! Programs of `dependents/` as they are, and what their images take.

use super::Table;
use super::figures::{Budget, head, measured, row, whole};
use crate::toolchain::dependents;

const PAGE: &str = "docs/own-board.md";
const PORTING: &str = "docs/porting.md";

pub(super) const TABLES: &[Table] = &[
    Table::new("README.md", "chips", chips),
    Table::new(PAGE, "chips", chips),
    Table::new(PAGE, "sizes", sizes),
    Table::new(PAGE, "stm32f4", program),
    Table::new(PAGE, "rp2040", program),
    Table::new(PAGE, "rp2350", program),
    Table::new(PAGE, "embassy-stm32", program),
    Table::new(PAGE, "embassy-stm32g4", program),
    Table::new(PAGE, "embassy-stm32-instrument", program),
    Table::new(PAGE, "embassy-rp", program),
    Table::new(PAGE, "embassy-rp-instrument", program),
    Table::new(PAGE, "nrf52840", program),
    Table::new(PAGE, "esp32c3", program),
    Table::new(PORTING, "size", size),
    Table::new(PORTING, "skeleton", program),
];

/// The program of the package that has the table's name.
fn program(table: &Table) -> Result<Vec<String>, String> {
    let path = dependents().join(table.name).join("src/main.rs");
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let lines = text.lines().map(str::to_owned);
    Ok(["```rust".to_owned()].into_iter().chain(lines).chain(["```".to_owned()]).collect())
}

fn bytes(package: &str) -> Result<[String; 2], String> {
    Ok(measured(&format!("{package}, bytes of flash and RAM"))?.map(whole))
}

fn sizes(_: &Table) -> Result<Vec<String>, String> {
    let mut lines = head("| image, at opt-level `s` | flash, B | RAM without the stack, B |");
    for (name, package) in [
        ("[STM32 by registers](#stm32-by-registers)", "stm32f4"),
        ("[RP2040 by rp2040-hal](#rp2040-by-rp2040-hal)", "rp2040"),
        ("[RP2350 by rp235x-hal](#rp2350-by-rp235x-hal)", "rp2350"),
        ("[STM32 by embassy-stm32](#stm32-by-embassy-stm32)", "embassy-stm32"),
        ("an STM32G4 by embassy-stm32", "embassy-stm32g4"),
        (
            "[the whole instrument by embassy-stm32](#the-whole-instrument-by-embassy-stm32)",
            "embassy-stm32-instrument",
        ),
        ("[RP2040 by embassy-rp](#rp2040-by-embassy-rp)", "embassy-rp"),
        (
            "[the whole instrument by embassy-rp](#the-whole-instrument-by-embassy-rp)",
            "embassy-rp-instrument",
        ),
        ("[nRF52840 by embassy-nrf](#nrf52840-by-embassy-nrf)", "nrf52840"),
        (
            "[ESP32-C3 by esp-hal](#esp32-c3-by-esp-hal), with the interrupts' code, which runs in RAM, in both",
            "esp32c3",
        ),
    ] {
        let [flash, ram] = bytes(package)?;
        lines.push(row([name.to_owned(), flash, ram]));
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
