//! The model of cycles beside a measured chip: the very objects that were measured, from the repository of who measured them.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Real;
use picket_dsp::config::Config;
use picket_host::emulator::{Capture, Machine};
use picket_lab::bench::CORES;
use picket_lab::bench::cycles::Clock;
use picket_lab::bench::trace::Trace;
use picket_wire::capture::Header;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const OBJECTS: [&str; 8] = [
    "arm_rfft_fast_f32",
    "arm_rfft_fast_init_f32",
    "arm_cfft_f32",
    "arm_cfft_radix8_f32",
    "arm_bitreversal2",
    "arm_common_tables",
    "arm_const_structs",
    "arm_biquad_cascade_df1_f32",
];

/// Measured by E. Hughes, CM4-7_TEST_RESULTS.-ESC2017.xlsx, sheet 8: the transform of 64 to 4096 floats on an LPC4370, from RAM.
const TRANSFORM: [u64; 7] = [3_479, 6_716, 15_635, 34_325, 65_147, 149_350, 323_899];
/// Sheet 9: a filter of second order, 16 to 4096 floats.
const FILTER: [u64; 9] = [373, 669, 1_261, 2_445, 4_813, 9_549, 19_021, 37_965, 75_853];

#[test]
#[ignore = "needs a clone that is named: PICKET_ESC_M4, of github.com/ehughes/ESC-M4 (110 MB)"]
fn named_the_model_meets_a_measured_chip() {
    let clone = std::env::var_os("PICKET_ESC_M4");
    let image =
        link(Path::new(&clone.expect("PICKET_ESC_M4 names a clone of github.com/ehughes/ESC-M4")));
    let mut trace = Trace::new(Clock::of(&CORES[0]).unwrap());
    let header = Header::from_config::<Real>(Config::new(1.0, Codes::signed::<12>()), 64, 0);
    let capture = Capture::create(&header).unwrap();
    capture
        .trace(Machine::An386, &image, Duration::from_secs(120), |line| trace.line(line))
        .unwrap();
    let (transforms, filters) = trace.sections.split_at(TRANSFORM.len());
    let share = |cycles: u64, measured: u64| cycles as f64 / measured as f64 - 1.0;
    for (found, measured) in transforms.iter().zip(TRANSFORM) {
        let share = share(found.cycles, measured);
        println!(
            "transform: {} instructions, {} cycles, measured {measured}: {:+.1} %",
            found.instructions,
            found.cycles,
            100.0 * share
        );
        assert!((-0.1..-0.03).contains(&share), "{share}");
    }
    assert_eq!(filters.len(), FILTER.len());
    for (found, measured) in filters.iter().zip(FILTER) {
        // The measurement holds twelve cycles of its own.
        let share = share(found.cycles + 12, measured);
        println!(
            "filter: {} instructions, {} cycles, measured {measured}: {:+.2} %",
            found.instructions,
            found.cycles,
            100.0 * share
        );
        assert!(share.abs() < 0.001, "{share}");
    }
}

/// A program of the objects.
fn link(clone: &Path) -> PathBuf {
    let (here, folder) = (
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cmsis"),
        PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("cmsis"),
    );
    std::fs::create_dir_all(&folder).unwrap();
    let (program, image) = (folder.join("program.o"), folder.join("image.elf"));
    let done = |command: &mut Command| {
        let status = command.status();
        let status = status.expect("apt-get install binutils-arm-none-eabi");
        assert!(status.success(), "{command:?}");
    };
    done(Command::new("arm-none-eabi-as").arg("-o").arg(&program).arg(here.join("program.s")));
    let mut linker = Command::new("arm-none-eabi-ld");
    linker.arg("-T").arg(here.join("program.ld")).arg("-o").arg(&image).arg(&program);
    for name in OBJECTS {
        let file = format!("CM4_TEST/COMMON/LIB/KEIL/Objects/{name}.o");
        let blob = Command::new("git")
            .arg("-C")
            .arg(clone)
            .arg("show")
            .arg(format!("HEAD:{file}"))
            .output()
            .unwrap();
        assert!(blob.status.success(), "{file}: {}", String::from_utf8_lossy(&blob.stderr));
        let mut object = blob.stdout;
        sort_symbols(&mut object);
        let path = folder.join(name).with_extension("o");
        std::fs::write(&path, object).unwrap();
        linker.arg(path);
    }
    done(&mut linker);
    image
}

/// Local symbols first, as the format demands and the compiler of these objects does not care for.
fn sort_symbols(object: &mut [u8]) {
    let word =
        |object: &[u8], at: usize| u32::from_le_bytes(object[at..at + 4].try_into().unwrap());
    let put = |object: &mut [u8], at: usize, value: u32| {
        object[at..at + 4].copy_from_slice(&value.to_le_bytes())
    };
    let (first, count) =
        (word(object, 32) as usize, usize::from(object[48]) | usize::from(object[49]) << 8);
    // Fields of a section's header, by their place in it: kind, place, size, link, information.
    let header = |object: &[u8], index: usize, field: usize| {
        word(object, first + 40 * index + 4 * field) as usize
    };
    let table =
        (0..count).find(|&index| header(object, index, 1) == 2).expect("a table of symbols");
    let (start, symbols) = (header(object, table, 4), header(object, table, 5) / 16);
    let old: Vec<[u8; 16]> = object[start..][..16 * symbols].as_chunks().0.to_vec();
    let is_local = |index: usize| old[index][12] >> 4 == 0;
    let mut order: Vec<usize> = (0..symbols).collect();
    order.sort_by_key(|&index| !is_local(index));
    let mut new = vec![0; symbols];
    for (place, &index) in order.iter().enumerate() {
        object[start + 16 * place..][..16].copy_from_slice(&old[index]);
        new[index] = place as u32;
    }
    let locals = (0..symbols).filter(|&index| is_local(index)).count();
    put(object, first + 40 * table + 28, locals as u32);
    for index in (0..count).filter(|&index| index != table) {
        let of_table = header(object, index, 6) == table;
        match header(object, index, 1) {
            // Relocations: each names its symbol.
            9 if of_table => {
                let (start, size) = (header(object, index, 4), header(object, index, 5));
                for at in (start..start + size).step_by(8) {
                    let information = word(object, at + 4);
                    put(object, at + 4, new[(information >> 8) as usize] << 8 | information & 0xFF);
                }
            }
            // A group of sections: its name.
            17 if of_table => put(object, first + 40 * index + 28, new[header(object, index, 7)]),
            _ => {}
        }
    }
}
