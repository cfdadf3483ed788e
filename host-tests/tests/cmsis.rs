//! CMSIS-DSP beside ours: what is quoted of it is what its own sources give.

use picket_lab::bench::{CORES, Core, LENGTHS, Row, cmsis, quoted};
use std::path::Path;

/// The cores that it is counted on.
fn cores() -> impl Iterator<Item = &'static Core> {
    CORES.iter().filter(|core| ["M4F", "M55"].contains(&core.name))
}

/// `PICKET_WRITE_FIGURES` writes what is counted.
#[test]
#[ignore = "needs gcc-arm-none-eabi and CMSIS-DSP's sources: cargo test --test all -- --ignored cmsis"]
fn what_is_quoted_is_what_is_counted() {
    let write = std::env::var_os("PICKET_WRITE_FIGURES").is_some();
    let mut lines = String::new();
    for core in cores() {
        for n in LENGTHS.into_iter().filter(|n| write || [256, 1024].contains(n)) {
            let counted = cmsis::rows(core, n).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(counted.len(), 6);
            for row in &counted {
                lines += &serde_json::to_string(row).unwrap();
                lines += "\n";
            }
            if !write {
                let quoted = quoted::rows(core, n);
                assert_eq!(counted.len(), quoted.len());
                counted.iter().zip(&quoted).for_each(|(counted, quoted)| same(counted, quoted));
            }
        }
    }
    if write {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lab/cmsis/figures.jsonl");
        std::fs::write(file, lines).unwrap();
    }
}

/// Another release of the compiler may order instructions otherwise.
fn same(counted: &Row, quoted: &Row) {
    let near = |a: u64, b: u64| a.abs_diff(b) * 200 <= b;
    let what = format!("{} {} {} {}", counted.core, counted.engine, counted.n, counted.stage);
    println!("{what}: {} instructions, {:?} cycles", counted.median, counted.median_cycles);
    assert_eq!((&counted.engine, &counted.stage), (&quoted.engine, &quoted.stage));
    assert!(near(counted.median, quoted.median), "{what}: quoted {}", quoted.median);
    assert_eq!(counted.ram_bytes, quoted.ram_bytes);
    match (counted.median_cycles, quoted.median_cycles) {
        (Some(counted), Some(quoted)) => assert!(near(counted, quoted), "{what}: {quoted} cycles"),
        (counted, quoted) => assert_eq!(counted, quoted),
    }
    for (counted, quoted) in
        [(counted.snr_0_db, quoted.snr_0_db), (counted.snr_m40_db, quoted.snr_m40_db)]
    {
        assert!((counted.unwrap() - quoted.unwrap()).abs() < 0.01, "{what}");
    }
}
