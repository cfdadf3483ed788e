//! Programs outside the workspace that depend on the library as a stranger's: they link beside other people's crates, and measure
//! the same bits. `cargo test --test dependents`; a plain `cargo test` leaves them out, since it takes minutes to
//! build them.

#[path = "../../dependents/same_bits.rs"]
mod same_bits;

mod features;

use host_tests::figures::hold;
use host_tests::needed;
use object::{Object, ObjectSection, ObjectSymbol};
use picket_dsp::{Arithmetic, Config, Effort, Verdict};
use picket_host::console::Console;
use picket_host::device::Said;
use picket_host::emulator::Footprint;
use picket_host::toolchain::{Dependent, ToolError, dependents, node, qemu, qemu_riscv32};
use picket_wire::boot::{Boot, Clock, Origin};
use picket_wire::command::{Command as Order, Refusal};
use picket_wire::settings::{Drive, Settings};
use same_bits::{Seen, same_bits};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

const STM32F4: Dependent = Dependent { name: "stm32f4", triple: "thumbv7em-none-eabihf" };
const RP2040: Dependent = Dependent { name: "rp2040", triple: "thumbv6m-none-eabi" };
const EMBASSY_STM32: Dependent =
    Dependent { name: "embassy-stm32", triple: "thumbv7em-none-eabihf" };
const EMBASSY_STM32_INSTRUMENT: Dependent =
    Dependent { name: "embassy-stm32-instrument", triple: "thumbv7em-none-eabihf" };
const EMBASSY_RP: Dependent = Dependent { name: "embassy-rp", triple: "thumbv6m-none-eabi" };
const EMBASSY_RP_INSTRUMENT: Dependent =
    Dependent { name: "embassy-rp-instrument", triple: "thumbv6m-none-eabi" };
const EMBASSY_STM32G4: Dependent =
    Dependent { name: "embassy-stm32g4", triple: "thumbv7em-none-eabihf" };
const NRF52840: Dependent = Dependent { name: "nrf52840", triple: "thumbv7em-none-eabihf" };
const RP2350: Dependent = Dependent { name: "rp2350", triple: "thumbv8m.main-none-eabihf" };
const BGT60TR13C_STM32F4: Dependent =
    Dependent { name: "bgt60tr13c-stm32f4", triple: "thumbv7em-none-eabihf" };
const BGT60TR13C_RP2350: Dependent =
    Dependent { name: "bgt60tr13c-rp2350", triple: "thumbv8m.main-none-eabihf" };
const ESP32C3: Dependent = Dependent { name: "esp32c3", triple: "riscv32imc-unknown-none-elf" };
const RISCV32: Dependent = Dependent { name: "riscv32", triple: "riscv32imac-unknown-none-elf" };
const SKELETON: Dependent = Dependent { name: "skeleton", triple: "thumbv7m-none-eabi" };
const WASM32: Dependent = Dependent { name: "wasm32", triple: "wasm32-unknown-unknown" };

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

    fn size(&self, name: &str) -> u64 {
        let file = object::File::parse(&*self.0).unwrap();
        file.section_by_name(name).unwrap_or_else(|| panic!("no section {name}")).size()
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

    /// Asserts that the ROM of an RP2350 starts it: within the first 4 KiB is a loop of blocks, of one that says that the image is a
    /// program for the chip's Arm cores, in secure mode (datasheet, 5.9).
    fn assert_image_definition(&self) {
        let (at, block) = self.section(".start_block");
        assert!(at < 0x1000_1000 && at % 4 == 0, "{at:#x}");
        let words: Vec<u32> =
            block.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect();
        let [start, image, last, next, end] = words[..] else { panic!("{words:x?}") };
        assert_eq!((start, end), (0xFFFF_DED3, 0xAB12_3579));
        // An item of type 0x42 and one word: EXE 0, S 5:4 = 2, ARM 10:8 = 0, RP2350 14:12 = 1.
        assert_eq!(image, 0x1021_0142);
        // The last item says that one word came before it; the next block is this one.
        assert_eq!((last, next), (0x0000_01FF, 0));
    }
}

/// Holds what the image of a package takes, without the stack.
fn hold_footprint(package: &Dependent, image: &Path) {
    hold_bytes(package.name, Footprint::from_elf(image).unwrap());
}

fn hold_bytes(name: &str, Footprint { flash, ram }: Footprint) {
    hold(&format!("{name}, bytes of flash and RAM"), 1.0, &[flash as f64, ram as f64]);
}

/// The emulated board that is neither an MPS2 nor a NUCLEO, and its boot record. Its time is counted in instructions, 64 ns each,
/// so that a busy host makes no gaps.
fn skeleton(image: &Path) -> (Console, Boot) {
    let mut command = Command::new(needed(qemu()));
    command.args(["-machine", "lm3s6965evb", "-icount", "shift=6,align=off,sleep=on"]);
    command.args(["-nodefaults", "-nographic", "-net", "none", "-kernel"]).arg(image);
    command.args(["-chardev", "stdio,id=uart0,signal=off", "-serial", "chardev:uart0"]);
    let mut board = Console::start(command).unwrap();
    let first = boot(&mut board);
    (board, first)
}

fn boot(board: &mut Console) -> Boot {
    let boot = board.expect(|said| match said {
        Said::Boot(boot) => Some(boot),
        _ => None,
    });
    boot.unwrap()
}

/// Ten records in a row, of every `step`th block, each of them the skeleton's tone.
fn assert_ten_records(board: &mut Console, rate_hz: f64, step: u32) {
    // The pointer turns by twice the arc sine of a quarter from sample to sample.
    let expected = 2.0 * 0.25f64.asin() / std::f64::consts::TAU;
    let mut sequences = Vec::new();
    for _ in 0..10 {
        let record = board.expect(|said| match said {
            Said::Telemetry(record) => Some(record),
            _ => None,
        });
        let record = record.unwrap();
        let tone = record.measurement.tone;
        let (frequency, sigma) = (tone.frequency.bins(256) / 256.0, f64::from(tone.sigma));
        let sigmas = (frequency - expected) / sigma;
        println!("{:.4} Hz, {sigmas:+.2} sigma, {:.1} dB", frequency * rate_hz, tone.snr_db());
        assert_eq!(tone.verdict, Verdict::Good, "{record:?}");
        assert!(sigmas.abs() < 5.0, "{record:?}");
        assert_eq!((record.health.lost, record.health.faults), (0, 0));
        sequences.push(record.measurement.stamp.sequence);
    }
    let from = sequences[0];
    assert!(sequences.iter().zip(0..).all(|(&s, n)| s == from + n * step), "{sequences:?}");
}

fn settings_of(board: &mut Console, order: Order) -> Settings {
    let body = board.request(order).unwrap().unwrap();
    let (settings, n) = Settings::from_bytes(&body).unwrap();
    assert_eq!(n, 256);
    settings
}

#[test]
fn the_skeleton_board_measures_and_follows_commands() {
    let image = needed(SKELETON.build(&[]));
    hold_footprint(&SKELETON, &image);
    let (mut board, first) = skeleton(&image);
    assert_eq!((first.board.as_str(), first.clock), ("skeleton", Clock::External));
    assert_eq!((first.n, first.core_hz), (256, 12_500_000));
    assert!(first.measuring && first.origin == Origin::Default && !first.unfit);
    // The default rate is far above what it can: it takes its fastest.
    assert_ten_records(&mut board, 5000.0, 1);
    // Settings come back as the board rounds them, and outlive the reset.
    let base = Settings::default();
    // Its program has no rounds of the joint fit.
    let config = Config { rate_hz: 3000.0, effort: Effort::LOOK, ..base.config };
    let wanted = Settings { report_every: 2, config, ..base };
    let answered = settings_of(&mut board, Order::SetSettings(wanted, 256));
    let rate_hz = 12.5e6 / 4167.0;
    let config = Config { rate_hz, ..wanted.config };
    assert_eq!(answered, Settings { config, ..wanted });
    let second = boot(&mut board);
    assert!(second.measuring && second.settings != first.settings);
    assert_eq!(settings_of(&mut board, Order::GetSettings), answered);
    assert_ten_records(&mut board, rate_hz, 2);
    // I/Q samples.
    let config = Config { band_hz: Some((-1400.0, 1400.0)), ..wanted.config };
    settings_of(&mut board, Order::SetSettings(Settings { iq: true, config, ..wanted }, 256));
    boot(&mut board);
    assert_ten_records(&mut board, rate_hz, 2);
    // What it does not have, it refuses.
    assert_eq!(board.request(Order::Save).unwrap(), Err(Refusal::Flash));
    let driven = Settings { drive: Drive::Dac { low: 0, high: 4095 }, ..base };
    let refused = board.request(Order::SetSettings(driven, 256)).unwrap();
    assert_eq!(refused, Err(Refusal::Settings([8, 0])));
    // Stopped, it answers and measures nothing.
    board.request(Order::Stop).unwrap().unwrap();
    assert!(!boot(&mut board).measuring);
    let heard = std::iter::from_fn(|| board.hear(Duration::from_secs(1)).unwrap());
    let heard: Vec<Said> = heard.take(3).collect();
    assert!(heard.iter().all(|said| matches!(said, Said::Status(_))), "{heard:?}");
    assert_eq!(board.request(Order::Capture(1)).unwrap(), Err(Refusal::Stopped));
    board.request(Order::Start).unwrap().unwrap();
    assert!(boot(&mut board).measuring);
    assert_ten_records(&mut board, rate_hz, 2);
    board.request(Order::Reboot).unwrap().unwrap();
    assert_eq!(boot(&mut board), first, "the default settings after a restart as from power-on");
    assert_eq!(board.listener().bad, 0);
}

/// The STM32F4's image, apart from where the linker may write again.
fn stm32f4() -> &'static Path {
    static COPY: OnceLock<PathBuf> = OnceLock::new();
    let built = || {
        let image = needed(STM32F4.build(&[]));
        let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stm32f4.elf");
        fs::copy(image, &copy).unwrap();
        copy
    };
    COPY.get_or_init(built)
}

#[test]
fn a_device_crates_interrupts_are_in_the_vector_table() {
    let image = stm32f4();
    hold_footprint(&STM32F4, image);
    // RM0390, table 38: 97 lines, DMA2 stream 0 is 56.
    Image::of(image).assert_vectors(0x0800_0000, 97, &[(18, "ADC"), (56, "DMA2_STREAM0")]);
}

/// The test above can fail: a package that hands the linker an empty `device.x` of its own, as this one once did, hides the
/// device crate's.
#[test]
fn a_device_file_on_the_linkers_path_would_be_seen() {
    stm32f4();
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
    let image = needed(RP2040.build(&[]));
    hold_footprint(&RP2040, &image);
    let image = Image::of(&image);
    // RP2040 datasheet, 2.3.2: 26 lines, 32 words; DMA_IRQ_0 is 11.
    image.assert_vectors(0x1000_0100, 32, &[(11, "DMA_IRQ_0")]);
    image.assert_first_stage();
}

#[test]
fn embassys_ring_buffer_on_an_stm32_links_with_its_interrupt() {
    let image = needed(EMBASSY_STM32.build(&[]));
    hold_footprint(&EMBASSY_STM32, &image);
    Image::of(&image).assert_vectors(0x0800_0000, 97, &[(56, "DMA2_STREAM0")]);
}

#[test]
fn the_instrument_in_embassys_executor_links_with_its_interrupts() {
    let image = needed(EMBASSY_STM32_INSTRUMENT.build(&[]));
    hold_footprint(&EMBASSY_STM32_INSTRUMENT, &image);
    // USART2 is 38; the time driver has a timer of its own.
    let image = Image::of(&image);
    let vectors = image.vectors(0x0800_0000);
    for (line, handler) in [(56, "DMA2_STREAM0"), (38, "USART2")] {
        assert_eq!(vectors[16 + line], image.handler(handler), "{handler}");
    }
}

#[test]
fn embassys_ring_buffer_on_an_stm32g4_links_with_its_interrupt() {
    let image = needed(EMBASSY_STM32G4.build(&[]));
    hold_footprint(&EMBASSY_STM32G4, &image);
    // RM0440, table 97: 102 lines, DMA1 channel 1 is 11.
    Image::of(&image).assert_vectors(0x0800_0000, 102, &[(11, "DMA1_CHANNEL1")]);
}

#[test]
fn two_buffers_on_an_nrf52840_link_with_their_interrupt() {
    let image = needed(NRF52840.build(&[]));
    hold_footprint(&NRF52840, &image);
    // nRF52840 product specification, 4.2.4: a line is its peripheral's number, the SAADC's 7; 48 of them.
    Image::of(&image).assert_vectors(0, 48, &[(7, "SAADC")]);
}

#[test]
fn a_chip_that_reads_blocks_finds_the_one_of_its_image() {
    let image = needed(RP2350.build(&[]));
    hold_footprint(&RP2350, &image);
    let image = Image::of(&image);
    // RP2350 datasheet, 3.2: 52 lines, DMA_IRQ_0 is 10.
    image.assert_vectors(0x1000_0000, 52, &[(10, "DMA_IRQ_0")]);
    image.assert_image_definition();
    // The kernels for the DSP extension are in it.
    let file = object::File::parse(&*image.0).unwrap();
    assert!(
        file.symbols().any(|symbol| symbol.name().is_ok_and(|name| name.contains("kernel_dsp")))
    );
}

#[test]
fn a_core_without_atomics_links_with_its_traps_and_its_description() {
    let image = needed(ESP32C3.build(&[]));
    let image = Image::of(&image);
    // The linker's script reserves the rest: the stack, and room in each address space for what the other one shows.
    let sizes = |names: &[&str]| names.iter().map(|name| image.section(name).1.len() as u64).sum();
    let in_ram: u64 = sizes(&[".trap", ".rwtext", ".data"]);
    let flash = in_ram + sizes(&[".flash.appdesc", ".rodata", ".text"]);
    let ram = in_ram + image.size(".bss");
    hold_bytes(ESP32C3.name, Footprint { flash, ram });
    // ESP32-C3 datasheet, table 3-1: where code runs from memory, and where it is read from flash.
    let (traps, _) = image.section(".trap");
    let (text, _) = image.section(".text");
    assert!(
        (0x4037_C000..0x403E_0000).contains(&traps) && (0x4200_0000..0x4280_0000).contains(&text)
    );
    // The table of interrupts is at a multiple of 256, and each entry a jump (RISC-V privileged architecture, mtvec): `jal x0`.
    let table = u64::from(image.handler("_vector_table") - 1);
    let (at, code) = image.section(".trap");
    assert!(table % 256 == 0 && (at..at + code.len() as u64).contains(&table), "{table:#x}");
    let jumps = code[(table - at) as usize..]
        .chunks(4)
        .take(32)
        .filter(|jump| jump[0] == 0x6F && jump[1] & 15 == 0);
    assert_eq!(jumps.count(), 32);
    // What the second stage of the boot looks for in front of the constants.
    let (_, description) = image.section(".flash.appdesc");
    assert_eq!(description[..4], 0xABCD_5432_u32.to_le_bytes());
}

#[test]
fn embassys_chunks_on_an_rp2040_link_with_their_interrupts() {
    let image = needed(EMBASSY_RP.build(&[]));
    hold_footprint(&EMBASSY_RP, &image);
    let image = Image::of(&image);
    // ADC_IRQ_FIFO is 22; the HAL itself listens to the pins and to the other core.
    let hal = [(13, "IO_IRQ_BANK0"), (16, "SIO_IRQ_PROC1")];
    let own = [[(11, "DMA_IRQ_0"), (22, "ADC_IRQ_FIFO")], hal].concat();
    image.assert_vectors(0x1000_0100, 32, &own);
    image.assert_first_stage();
}

#[test]
fn the_instrument_in_two_of_embassys_executors_on_an_rp2040_links_with_their_interrupts() {
    let image = needed(EMBASSY_RP_INSTRUMENT.build(&[]));
    hold_footprint(&EMBASSY_RP_INSTRUMENT, &image);
    let image = Image::of(&image);
    // UART0 is 20; SWI_IRQ_1 is 27, a line without a source. The time driver has the timer's first alarm.
    let hal = [(13, "IO_IRQ_BANK0"), (16, "SIO_IRQ_PROC1"), (0, "TIMER_IRQ_0")];
    let tasks = [(11, "DMA_IRQ_0"), (20, "UART0_IRQ"), (22, "ADC_IRQ_FIFO"), (27, "SWI_IRQ_1")];
    image.assert_vectors(0x1000_0100, 32, &[&hal[..], &tasks].concat());
    image.assert_first_stage();
}

#[test]
fn a_radars_frames_by_spi_link_on_two_chips() {
    let image = needed(BGT60TR13C_STM32F4.build(&[]));
    hold_footprint(&BGT60TR13C_STM32F4, &image);
    let image = Image::of(&image);
    let vectors = image.vectors(0x0800_0000);
    for (line, handler) in [(8, "EXTI2"), (14, "DMA1_STREAM3"), (15, "DMA1_STREAM4")] {
        assert_eq!(vectors[16 + line], image.handler(handler), "{handler}");
    }
    let image = needed(BGT60TR13C_RP2350.build(&[]));
    hold_footprint(&BGT60TR13C_RP2350, &image);
    let image = Image::of(&image);
    let vectors = image.vectors(0x1000_0000);
    for (line, handler) in [(0, "TIMER0_IRQ_0"), (10, "DMA_IRQ_0"), (21, "IO_IRQ_BANK0")] {
        assert_eq!(vectors[16 + line], image.handler(handler), "{handler}");
    }
    image.assert_image_definition();
}

/// The radar played on a desk, by the package's own test.
#[test]
fn a_radars_frames_come_by_spi() {
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(dependents().join("bgt60tr13c"));
    command.args(["test", "--quiet", "--locked", "--release", "--target-dir"]);
    command.arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("bgt60tr13c"));
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("3 passed"), "{said}");
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
    let image = needed(RISCV32.build(&[]));
    let qemu = needed(qemu_riscv32());
    let mut command = Command::new(qemu);
    command.args(["-machine", "virt", "-bios", "none", "-nographic", "-kernel"]).arg(image);
    assert_same_bits(command);
}

#[test]
fn wasm32_gives_the_same_bits() {
    let module = needed(WASM32.build(&[]));
    let script: PathBuf = dependents().join("wasm32/run.mjs");
    let mut command = Command::new(needed(node()));
    command.arg(script).arg(module);
    assert_same_bits(command);
}

/// A core that swaps no word atomically needs `heapless` in another form, and the program's choice how to do without.
#[test]
fn a_core_without_atomics_has_its_feature() {
    let triple = "riscv32imc-unknown-none-elf";
    let features = "portable-atomic,heapless/portable-atomic-critical-section";
    needed(Dependent::check_library(triple, features));
    match Dependent::check_library(triple, "methods") {
        Err(ToolError::Build { output, .. }) => assert!(output.contains("heapless"), "{output}"),
        other => panic!("without the feature it must not build: {other:?}"),
    }
}
