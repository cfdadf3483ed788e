//! The image with logs for a debugger (feature `defmt`): it logs, and does not wait for one that does not read.

use crate::board::{Emulated, file};
use crate::settings::tone;
use object::{Object, ObjectSymbol};
use picket_host::flash;
use picket_host::toolchain::{Firmware, Profile, Target};
use picket_wire::settings::Settings;

#[test]
fn an_image_with_logs_measures_without_a_debugger() {
    let (target, profile) = (Target::M4f, Profile::Balanced);
    let features = &["nucleo", "defmt"];
    let elf = Firmware { bin: "frontend_nucleo", target, features, profile }.build();
    let elf = elf.unwrap_or_else(|error| panic!("{error}"));
    let data = std::fs::read(&elf).unwrap();
    let symbols = object::File::parse(&*data).unwrap();
    let block = symbols.symbols().find(|symbol| symbol.name() == Ok("_SEGGER_RTT")).unwrap();
    let block = block.address() as u32;
    let image = file(&flash::binary(&elf).unwrap());
    let (mut board, boot) =
        Emulated::start_with(&image, &Settings { report_every: 50, ..tone(100e3) });
    assert!(boot.measuring);
    // SEGGER's control block: 16 letters, two counts, then the first channel: name, buffer, size, write, read, flags.
    assert_eq!(board.read(block), u32::from_le_bytes(*b"SEGG"));
    let [size, written, read, flags] = [32, 36, 40, 44].map(|at| board.read(block + at));
    println!("{written} of {size} bytes logged at the start");
    assert!(size >= 256 && (20..size).contains(&written) && read == 0, "{written} of {size}");
    // What finds no room is skipped.
    assert!(flags & 3 < 2, "{flags}");
    // Overruns are logged, more than there is room for.
    for _ in 0..3 {
        board.order("overrun");
        board.run(1_100_000);
    }
    assert!(board.read(block + 36) != written, "the faults are not logged");
    let before = board.status();
    board.run(500_000);
    let after = board.status();
    assert_eq!(after.counters.lost(), before.counters.lost());
    assert!(after.counters.blocks > before.counters.blocks + 40);
    board.assert_rules();
}
