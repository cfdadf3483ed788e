//! Programs outside the workspace that depend on the library as a stranger's: they link beside other people's crates, and measure
//! the same bits. `cargo test -p host-tests --test dependents`; a plain `cargo test` leaves them out, since it takes minutes to
//! build them.

#[path = "../../dependents/same_bits.rs"]
mod same_bits;

use host_tests::figures::Document;
use object::{Object, ObjectSection, ObjectSymbol};
use picket::Arithmetic;
use picket_host::emulator::Footprint;
use picket_host::toolchain::{Dependent, ToolError, dependents, qemu_riscv32};
use same_bits::{Seen, same_bits};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const STM32F4: Dependent = Dependent { name: "stm32f4", triple: "thumbv7em-none-eabihf" };
const RP2040: Dependent = Dependent { name: "rp2040", triple: "thumbv6m-none-eabi" };
const EMBASSY_STM32: Dependent =
    Dependent { name: "embassy-stm32", triple: "thumbv7em-none-eabihf" };
const EMBASSY_RP: Dependent = Dependent { name: "embassy-rp", triple: "thumbv6m-none-eabi" };
const RISCV32: Dependent = Dependent { name: "riscv32", triple: "riscv32imac-unknown-none-elf" };
const WASM32: Dependent = Dependent { name: "wasm32", triple: "wasm32-unknown-unknown" };

/// What could be had. What a machine without network cannot have is skipped, and said; anything else is a failure.
fn had<T>(result: Result<T, ToolError>) -> Option<T> {
    const OFFLINE: [&str; 4] =
        ["failed to download", "Could not resolve host", "Couldn't resolve host", "--offline"];
    match result {
        Ok(had) => Some(had),
        Err(ToolError::Build { output, .. }) if OFFLINE.iter().any(|why| output.contains(why)) => {
            println!("skipped: the packages cannot be had: {output}");
            None
        }
        Err(error @ ToolError::Missing { .. }) => {
            println!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}\n{error:?}"),
    }
}

/// An image that was linked.
struct Image(Vec<u8>);

impl Image {
    fn of(path: &Path) -> Self {
        Self(fs::read(path).unwrap())
    }

    fn section(&self, name: &str) -> (u64, Vec<u8>) {
        let file = object::File::parse(&*self.0).unwrap();
        let section = file.section_by_name(name).unwrap_or_else(|| panic!("no section {name}"));
        (section.address(), section.data().unwrap().to_vec())
    }

    /// A function's address as a vector has it: its lowest bit says that it is Thumb code.
    fn handler(&self, name: &str) -> u32 {
        let file = object::File::parse(&*self.0).unwrap();
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
        symbol.unwrap_or_else(|| panic!("no function {name}")).address() as u32 | 1
    }

    /// The vector table: the core's 16 words, then a word for each interrupt of the device.
    fn vectors(&self, address: u64) -> Vec<u32> {
        let (at, bytes) = self.section(".vector_table");
        assert_eq!(at, address);
        bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect()
    }

    /// Asserts that these interrupts have their own handlers in a table of so many, and the others the one for all.
    fn assert_vectors(&self, address: u64, interrupts: usize, own: &[(usize, &str)]) {
        let vectors = self.vectors(address);
        assert_eq!(vectors.len(), 16 + interrupts);
        assert_eq!(vectors[1], self.handler("Reset"));
        let others = self.handler("DefaultHandler_");
        for (index, &vector) in vectors[16..].iter().enumerate() {
            let right = match own.iter().find(|(number, _)| *number == index) {
                Some((_, name)) => vector == self.handler(name) && vector != others,
                // A line that the device does not have is 0.
                None => [others, 0].contains(&vector),
            };
            assert!(right, "interrupt {index}: {vector:#x}");
        }
    }

    /// Asserts that the ROM of an RP2040 starts it: the checksum at the end of its first stage is right (datasheet, 2.8.1.3.1).
    fn assert_first_stage(&self) {
        let (at, stage) = self.section(".boot2");
        assert_eq!((at, stage.len()), (0x1000_0000, 256));
        let (code, checksum) = stage.split_at(252);
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_MPEG_2).checksum(code);
        assert_eq!(checksum, crc.to_le_bytes());
    }
}

/// The page states what an image takes, behind these words.
fn assert_states_footprint(words: &str, image: &Path) {
    let Footprint { flash, ram } = Footprint::of(image).unwrap();
    let phrase = format!("{words} Flash # B, RAM # B without the stack");
    Document::own_board().assert_states(&phrase, &[flash as f64, ram as f64]);
}

#[test]
fn the_page_shows_the_programs_as_they_are() {
    let page = include_str!("../../docs/own-board.md");
    for Dependent { name, .. } in [STM32F4, RP2040, EMBASSY_STM32, EMBASSY_RP] {
        let program = fs::read_to_string(dependents().join(name).join("src/main.rs")).unwrap();
        assert!(page.contains(&format!("```rust\n{program}```\n")), "docs/own-board.md, {name}");
    }
}

/// The STM32F4's image, apart from where the linker may write again.
fn stm32f4() -> Option<&'static Path> {
    static COPY: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = || {
        let image = had(STM32F4.build(&[]))?;
        let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stm32f4.elf");
        fs::copy(image, &copy).unwrap();
        Some(copy)
    };
    COPY.get_or_init(built).as_deref()
}

#[test]
fn a_device_crates_interrupts_are_in_the_vector_table() {
    let Some(image) = stm32f4() else { return };
    assert_states_footprint("the interrupt by the device crate's own attribute.", image);
    // RM0390, table 38: 97 lines, DMA2 stream 0 is 56.
    Image::of(image).assert_vectors(0x0800_0000, 97, &[(56, "DMA2_STREAM0")]);
}

/// The test above can fail: a package that hands the linker an empty `device.x` of its own, as this one once did, hides the
/// device crate's.
#[test]
fn a_device_file_on_the_linkers_path_would_be_seen() {
    if stm32f4().is_none() {
        return;
    }
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shadow");
    fs::create_dir_all(&place).unwrap();
    fs::write(place.join("device.x"), "").unwrap();
    match STM32F4.build(&["-L", place.to_str().unwrap()]) {
        Err(ToolError::Build { output, .. }) => {
            assert!(output.contains("undefined symbol: "), "{output}");
        }
        other => panic!("the program must not link: {other:?}"),
    }
}

#[test]
fn a_chip_without_flash_of_its_own_finds_its_first_stage_and_its_vectors() {
    let Some(image) = had(RP2040.build(&[])) else { return };
    assert_states_footprint("Two DMA channels in turn.", &image);
    let image = Image::of(&image);
    // RP2040 datasheet, 2.3.2: 26 lines, 32 words; DMA_IRQ_0 is 11.
    image.assert_vectors(0x1000_0100, 32, &[(11, "DMA_IRQ_0")]);
    image.assert_first_stage();
}

#[test]
fn embassys_ring_buffer_on_an_stm32_links_with_its_interrupt() {
    let Some(image) = had(EMBASSY_STM32.build(&[])) else { return };
    assert_states_footprint("a DMA ring of two halves.", &image);
    Image::of(&image).assert_vectors(0x0800_0000, 97, &[(56, "DMA2_STREAM0")]);
}

#[test]
fn embassys_chunks_on_an_rp2040_link_with_their_interrupts() {
    let Some(image) = had(EMBASSY_RP.build(&[])) else { return };
    assert_states_footprint("The HAL reads a chunk by DMA, then stops.", &image);
    let image = Image::of(&image);
    // ADC_IRQ_FIFO is 22; the HAL itself listens to the pins and to the other core.
    let hal = [(13, "IO_IRQ_BANK0"), (16, "SIO_IRQ_PROC1")];
    let own = [[(11, "DMA_IRQ_0"), (22, "ADC_IRQ_FIFO")], hal].concat();
    image.assert_vectors(0x1000_0100, 32, &own);
    image.assert_first_stage();
}

/// What this machine measures, by floats and by integers.
fn here() -> &'static [Seen; 2] {
    static SEEN: OnceLock<[Seen; 2]> = OnceLock::new();
    SEEN.get_or_init(|| [Arithmetic::Float, Arithmetic::Fixed].map(same_bits))
}

fn assert_same_bits(mut command: Command) {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}{errors}");
    let [float, fixed] = here().map(|seen| seen.checksum);
    let lines: Vec<&str> = said.lines().map(str::trim_end).collect();
    assert_eq!(lines, [format!("Float {float:016x}"), format!("Fixed {fixed:016x}")]);
    println!("{} blocks by each arithmetic the same: {lines:?}", here()[0].blocks);
}

#[test]
fn the_blocks_are_of_all_sorts() {
    let [float, fixed] = here();
    // Most are tones well above the noise; some are noise, clip or hold nothing.
    for seen in [float, fixed] {
        println!("{seen:?}");
        assert_eq!(seen.blocks, 10_000);
        assert!((seen.blocks / 3..seen.blocks * 9 / 10).contains(&seen.good), "{seen:?}");
    }
    // The two arithmetics differ in last bits: each has to be compared for itself.
    assert_ne!(float.checksum, fixed.checksum);
}

#[test]
fn riscv32_gives_the_same_bits() {
    let Some(image) = had(RISCV32.build(&[])) else { return };
    let Some(qemu) = had(qemu_riscv32()) else { return };
    let mut command = Command::new(qemu);
    command.args(["-machine", "virt", "-bios", "none", "-nographic", "-kernel"]).arg(image);
    assert_same_bits(command);
}

#[test]
fn wasm32_gives_the_same_bits() {
    let Some(module) = had(WASM32.build(&[])) else { return };
    if Command::new("node").arg("--version").output().is_err() {
        println!("skipped: there is no node to run it with");
        return;
    }
    let script: PathBuf = dependents().join("wasm32/run.mjs");
    let mut command = Command::new("node");
    command.arg(script).arg(module);
    assert_same_bits(command);
}

/// A core that swaps no word atomically needs `heapless` in another form, and the program's choice how to do without.
#[test]
fn a_core_without_atomics_has_its_feature() {
    let triple = "riscv32imc-unknown-none-elf";
    let features = "portable-atomic,heapless/portable-atomic-critical-section";
    if had(Dependent::check_library(triple, features)).is_none() {
        return;
    }
    match Dependent::check_library(triple, "methods") {
        Err(ToolError::Build { output, .. }) => assert!(output.contains("heapless"), "{output}"),
        other => panic!("without the feature it must not build: {other:?}"),
    }
}
