//! CMSIS-DSP beside ours: what is quoted of it is what its own sources give, and what the documents state.

use host_tests::figures::Document;
use host_tests::sized;
use picket_lab::bench::{CORES, Core, LENGTHS, Row, cmsis, precision, quoted};
use std::path::Path;

/// The cores that it is counted on.
fn cores() -> impl Iterator<Item = &'static Core> {
    CORES.iter().filter(|core| ["M4F", "M55"].contains(&core.name))
}

/// `PICKET_WRITE_FIGURES` writes what is counted.
#[test]
fn what_is_quoted_is_what_is_counted() {
    let write = std::env::var_os("PICKET_WRITE_FIGURES").is_some();
    let mut lines = String::new();
    for core in cores() {
        for n in LENGTHS.into_iter().filter(|n| write || [256, 1024].contains(n)) {
            let counted = match cmsis::rows(core, n) {
                Ok(rows) => rows,
                Err(error) => return println!("skipped: {error}"),
            };
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

/// The documents state it as it is quoted.
#[test]
fn the_documents_state_it() {
    let (page, readme) = (Document::performance(), Document::readme());
    for (core, words) in [("M4F", ""), ("M55", " (MVE)")] {
        let core = CORES.iter().find(|known| known.name == core).unwrap();
        let figures = |engine: &str, stage: &str, what: fn(&Row) -> u64| {
            [256, 1024, 4096].map(|n| {
                let rows = quoted::rows(core, n);
                let row = rows.iter().find(|row| row.engine == engine && row.stage == stage);
                what(row.unwrap()) as f64
            })
        };
        let (counts, cycles) =
            (|row: &Row| row.median, |row: &Row| row.median_cycles.unwrap_or_default());
        for (engine, name) in [("cmsis-q15", "q15"), ("cmsis-q31", "q31")] {
            page.assert_states(
                &format!("| CMSIS-DSP {name}{words}: FFT, magnitudes, peak | # | # | # |"),
                &figures(engine, "fft_peak", counts),
            );
        }
        if core.name == "M4F" {
            page.assert_states(
                "| CMSIS-DSP q15: FFT, magnitudes, peak, cycles | # | # | # |",
                &figures("cmsis-q15", "fft_peak", cycles),
            );
            page.assert_states(
                "| CMSIS-DSP f32: FFT alone | # | # | # |",
                &figures("cmsis-f32", "fft", counts),
            );
            readme.assert_states(
                "CMSIS-DSP takes # for its 16-bit FFT, magnitudes and peak alone.",
                &figures("cmsis-q15", "fft_peak", cycles)[1..2],
            );
        }
    }
}

/// Cycles and errors of the page's table and of its picture: two lengths, or all with `PICKET_LONG=1`.
#[test]
fn cycles_and_errors_are_those_of_the_page() {
    let page = Document::performance();
    let core = CORES.iter().find(|core| core.name == "M4F").unwrap();
    let svg = include_str!("../../docs/cycles-error.svg");
    let drawn = svg.split_once("<metadata>").and_then(|(_, rest)| rest.split_once("</metadata>"));
    let drawn = drawn.unwrap().0.replace("&quot;", "\"");
    let drawn: serde_json::Value = serde_json::from_str(&drawn).unwrap();
    for n in LENGTHS.into_iter().filter(|n| sized(u64::from([256, 1024].contains(n)), 1) > 0) {
        let (points, missing) =
            precision::points(core, n).unwrap_or_else(|error| panic!("{error}"));
        let place = LENGTHS.iter().position(|&length| length == n).unwrap();
        // On a steady tone each effort takes the same.
        let [look, one, ..] = &points[..] else { panic!("{points:?}") };
        assert_eq!((look.cycles, look.errors), (one.cycles, one.errors));
        let mut row = format!("| {n} |");
        for (number, point) in points.iter().skip(1).enumerate() {
            row += " #; #, # |";
            let figures: Vec<f64> = points[1..=1 + number]
                .iter()
                .flat_map(|point| [point.cycles as f64, point.errors[0], point.errors[1]])
                .collect();
            page.assert_states(&row, &figures);
            let label = if point.program.starts_with("picket") {
                "picket look/one"
            } else {
                &point.program
            };
            for (error, snr_db) in point.errors.iter().zip(precision::SNR_DB) {
                let at = &drawn[format!("{label}, {snr_db} dB")][place];
                let [x, y] = [0, 1].map(|which| at[which].as_f64().unwrap());
                assert!((x * 1e3 / point.cycles as f64 - 1.0).abs() < 0.02, "{point:?}: {at}");
                assert!((y / error - 1.0).abs() < 0.02, "{point:?}: {at}");
            }
        }
        if let Some(error) = missing {
            println!("skipped: {error}");
        }
    }
}
