//! The tables of docs/performance.md. What emulated cores take stands in `host-tests/budget.json`, which the tests `budget` hold to what they
//! count; other programs' figures are as they were counted beside ours.

use super::Table;
use super::figures::{Budget, head, rounded, row, whole};
use crate::bench::{CORES, Core, LENGTHS, Row, precision, quoted};

const PAGE: &str = "docs/performance.md";

pub(super) const TABLES: &[Table] = &[
    Table::new(PAGE, "cycles", cycles),
    Table::new(PAGE, "instructions", instructions),
    Table::new(PAGE, "ceilings", ceilings),
    Table::new(PAGE, "modelled", modelled),
    Table::new(PAGE, "cycles-error", cycles_and_errors).slow(),
    Table::new(PAGE, "engines", engines),
    Table::new(PAGE, "cores", cores),
    Table::new(PAGE, "helium", helium),
    Table::new(PAGE, "ranging", ranging),
    Table::new(PAGE, "sizes", sizes),
];

type Lines = Result<Vec<String>, String>;

/// The lengths that the tables have.
const N: [&str; 3] = ["256", "1024", "4096"];

/// A row: its name, and the budget at these paths; nothing where there is no path.
fn of<const COUNT: usize>(
    budget: &Budget,
    name: &str,
    paths: [Option<String>; COUNT],
) -> Result<String, String> {
    let mut cells = vec![name.to_owned()];
    for path in paths {
        cells.push(path.map_or(Ok(String::new()), |path| budget.at(&path).map(rounded))?);
    }
    Ok(row(cells))
}

/// A path for each length.
fn each(path: impl Fn(&str) -> String) -> [Option<String>; 3] {
    N.map(|n| Some(path(n)))
}

/// A path for 1,024 samples alone.
fn middle(path: &str) -> [Option<String>; 3] {
    [None, Some(path.to_owned()), None]
}

fn core(name: &str) -> Result<&'static Core, String> {
    CORES.iter().find(|core| core.name == name).ok_or_else(|| format!("no core {name}"))
}

/// A row of CMSIS-DSP as it was counted.
fn cmsis(
    name: &str,
    core: &Core,
    engine: &str,
    stage: &str,
    of: fn(&Row) -> Option<u64>,
) -> Result<Vec<String>, String> {
    let mut cells = vec![name.to_owned()];
    for n in [256, 1024, 4096] {
        let rows = quoted::rows(core, n);
        let row = rows.iter().find(|row| row.engine == engine && row.stage == stage);
        let figure = row.and_then(of).ok_or_else(|| format!("{engine} of {n} is not quoted"))?;
        cells.push(rounded(figure as f64));
    }
    Ok(cells)
}

fn cycles(_: &Table) -> Lines {
    let budget = &Budget::read()?;
    let own = |stage| each(move |n| format!("/engines/picket-i32/cycles/{n}/{stage}"));
    let most = |effort| each(move |n| format!("/ceilings/M4F/real/{n}/{effort}/1"));
    let rows = vec![
        of(budget, "**Picket: FFT, peak and noise floor**, cycles", own("fft_peak"))?,
        of(
            budget,
            "**Picket: all of it, to frequency, sigma and verdict**, cycles",
            own("measurement"),
        )?,
        of(budget, "all of it, at most with two rounds, cycles", most("2"))?,
        of(budget, "all of it, at most without a round, cycles", most("0"))?,
        row(cmsis(
            "CMSIS-DSP q15: FFT, magnitudes, peak, cycles",
            core("M4F")?,
            "cmsis-q15",
            "fft_peak",
            |row| row.median_cycles,
        )?),
    ];
    Ok([head("| modelled cycles, memory without wait states | N = 256 | 1024 | 4096 |"), rows]
        .concat())
}

/// The error of a transform of 1,024 samples below the signal, at full scale and 40 dB below.
fn error(engine: &str) -> Result<String, String> {
    let rows = quoted::rows(core("M4F")?, 1024);
    let row = rows.iter().find(|row| row.engine == engine);
    let [full, low] = [row.and_then(|row| row.snr_0_db), row.and_then(|row| row.snr_m40_db)];
    let (full, low) = full.zip(low).ok_or_else(|| format!("{engine} is not quoted"))?;
    Ok(format!("{:.0} / {:.0} dB", -full, -low))
}

fn instructions(_: &Table) -> Lines {
    let budget = &Budget::read()?;
    let m4f = core("M4F")?;
    let mut rows = Vec::new();
    for (name, engine) in [("Picket", "picket-i32"), ("Float engine (microfft)", "picket-f32")] {
        let path = |stage: &'static str| {
            move |n: &str| format!("/engines/{engine}/instructions/{n}/{stage}")
        };
        let [full, low] =
            [0, 1].map(|level| budget.at(&format!("/engines/{engine}/snr_db/1024/{level}")));
        let errors = format!("{:.0} / {:.0} dB", -full?, -low?);
        let peak =
            of(budget, &format!("**{name}: FFT, peak and noise floor**"), each(path("fft_peak")))?;
        rows.push(format!("{peak} {errors} |"));
        let what = if engine == "picket-i32" {
            "all of it, to frequency, sigma and verdict"
        } else {
            "all of it"
        };
        rows.push(format!(
            "{} |",
            of(budget, &format!("**{name}: {what}**"), each(path("measurement")))?
        ));
    }
    let counted = |row: &Row| Some(row.median);
    for (name, engine, stage) in [
        ("CMSIS-DSP q15: FFT, magnitudes, peak", "cmsis-q15", "fft_peak"),
        ("CMSIS-DSP q31: FFT, magnitudes, peak", "cmsis-q31", "fft_peak"),
        ("CMSIS-DSP f32: FFT alone", "cmsis-f32", "fft"),
    ] {
        let mut cells = cmsis(name, m4f, engine, stage, counted)?;
        cells.push(error(engine)?);
        rows.push(row(cells));
    }
    let head = head(
        "| executed instructions | N = 256 | 1024 | 4096 | error at 1024: full scale / -40 dBFS |",
    );
    Ok([head, rows].concat())
}

fn ceilings(_: &Table) -> Lines {
    let budget = Budget::read()?;
    let mut lines = head("| instructions / modelled cycles at most | effort 0 | effort 2 |");
    for (name, place) in [
        ("M4F, N = 64", "M4F/real/64"),
        ("M4F, 256", "M4F/real/256"),
        ("M4F, 1024", "M4F/real/1024"),
        ("M4F, 64, I/Q", "M4F/iq/64"),
        ("M4F, 1024, I/Q", "M4F/iq/1024"),
        ("M4F, 4096", "M4F/real/4096"),
        ("M3, 1024", "M3/real/1024"),
        ("M0 and M0+, 1024", "M0/real/1024"),
        ("M55, 1024", "M55/real/1024"),
    ] {
        let mut cells = vec![name.to_owned()];
        for effort in ["0", "2"] {
            let at = |which| budget.at(&format!("/ceilings/{place}/{effort}/{which}"));
            let (Ok(instructions), Ok(cycles)) = (at(0), at(1)) else {
                // Nobody has searched there.
                cells.push(String::new());
                continue;
            };
            let [instructions, cycles] = [instructions, cycles].map(whole);
            // No cycles are modelled of a core whose timing is not published.
            let modelled = if cycles == "0" { String::new() } else { format!(" / {cycles}") };
            cells.push(instructions + &modelled);
        }
        lines.push(row(cells));
    }
    Ok(lines)
}

fn modelled(_: &Table) -> Lines {
    let budget = &Budget::read()?;
    let portable = |core: &str, stage: &str| middle(&format!("/portable_cycles/{core}/{stage}"));
    let rows = vec![
        of(budget, "M3: FFT, peak and noise floor", portable("M3", "fft_peak"))?,
        of(budget, "M3: all of it", portable("M3", "measurement"))?,
        of(budget, "M0+: FFT, peak and noise floor", portable("M0", "fft_peak"))?,
        of(budget, "M0+: all of it", portable("M0", "measurement"))?,
    ];
    Ok([head("| modelled cycles, median | N = 256 | 1024 | 4096 |"), rows].concat())
}

/// By the emulated core, as `lab bench --precision` draws them.
fn cycles_and_errors(_: &Table) -> Lines {
    let core = core("M4F")?;
    let mut lines = head(
        "| N, a steady tone | Picket, effort 0 | Picket, effort 2 | microfft | CMSIS-DSP q15 | CMSIS-DSP q31 | CMSIS-DSP f32 |",
    );
    for n in LENGTHS {
        let (points, missing) = precision::points(core, n)?;
        if let Some(error) = missing {
            return Err(error.to_string());
        }
        let cells = points.iter().map(|point| {
            let [low, high] = point.errors;
            format!("{}; {low:.2}, {high:.2}", whole(point.cycles as f64))
        });
        lines.push(row([n.to_string()].into_iter().chain(cells)));
    }
    Ok(lines)
}

fn engines(_: &Table) -> Lines {
    let budget = Budget::read()?;
    let band = |kind| {
        Ok::<_, String>(
            (budget.at(&format!("/band/400/{kind}"))? - budget.at(&format!("/band/100/{kind}"))?)
                / 300.0,
        )
    };
    let whole_bin = budget.at("/engines/picket-i32/instructions/1024/peak")? / 511.0;
    let mut lines = head("| N = 1024 | |");
    for (name, engine) in [("the default", "i32"), ("the float engine", "f32")] {
        let bytes = budget.at(&format!("/engines/picket-{engine}/ram_bytes/1024"))?;
        lines.push(row([
            format!("{name}: bytes of RAM, with two records and the result"),
            whole(bytes),
        ]));
    }
    for (what, figure) in [
        ("a further bin of a band, instructions at most", band(0)?),
        ("a further bin of a band, of an I/Q record", band(1)?),
        ("a bin of a whole real spectrum", whole_bin),
    ] {
        lines.push(row([what.to_owned(), format!("{figure:.1}")]));
    }
    for (what, path) in [
        (
            "a trapezoid's three tones to range and velocity, once a chirp, on the M4F: instructions",
            "/engines/picket-i32/instructions/1024/chirp",
        ),
        ("the same on M0 and M0+", "/portable/M0/chirp"),
    ] {
        lines.push(row([what.to_owned(), rounded(budget.at(path)?)]));
    }
    Ok(lines)
}

fn cores(_: &Table) -> Lines {
    let budget = &Budget::read()?;
    let of = |name: &str, core: &str, stages: [&str; 4]| {
        let path = |stage: &str| (!stage.is_empty()).then(|| format!("/portable/{core}/{stage}"));
        of(budget, name, stages.map(path))
    };
    let rows = vec![
        of("M3, median", "M3", ["", "fft_peak", "estimator", "measurement"])?,
        of("M0 and M0+, median", "M0", ["fft", "fft_peak", "estimator", "measurement"])?,
    ];
    let head = head(
        "| executed instructions, N = 1024 | FFT alone | FFT and peak | frequency, sigma and verdict | all of it |",
    );
    Ok([head, rows].concat())
}

fn helium(_: &Table) -> Lines {
    let budget = &Budget::read()?;
    let own = |which: usize| each(move |n| format!("/helium/{n}/fft_peak/{which}"));
    let counted = |row: &Row| Some(row.median);
    let m55 = core("M55")?;
    let mut rows = vec![
        of(budget, "**With Helium: FFT, peak and noise floor**", own(0))?,
        of(budget, "with Helium, worst", own(1))?,
        of(
            budget,
            "**With Helium: all of it, to frequency, sigma and verdict**",
            middle("/helium/1024/measurement/0"),
        )?,
        row(cmsis(
            "CMSIS-DSP q15 (MVE): FFT, magnitudes, peak",
            m55,
            "cmsis-q15",
            "fft_peak",
            counted,
        )?),
        row(cmsis(
            "CMSIS-DSP q31 (MVE): FFT, magnitudes, peak",
            m55,
            "cmsis-q31",
            "fft_peak",
            counted,
        )?),
    ];
    // On the chip a vector instruction takes two cycles, and of two neighbours of different units one overlaps.
    let counted = budget.at("/helium/1024/fft_peak/0")?;
    let [least, most] = [1.1, 2.1].map(|cycles| rounded(cycles * counted));
    rows.push(row([
        "cycles of FFT, peak and floor, if every two neighbours overlap, and if none do".to_owned(),
        String::new(),
        format!("{least} to {most}"),
        String::new(),
    ]));
    let head =
        head("| executed instructions, emulated Cortex-M55 (mps3-an547) | N = 256 | 1024 | 4096 |");
    Ok([head, rows].concat())
}

fn ranging(_: &Table) -> Lines {
    let budget = Budget::read()?;
    let mut lines = head("| executed instructions | M0 | M4F |");
    for (name, stage) in [
        ("a chirp of 256 I/Q samples, measured by itself (`Pipeline::block`)", "block"),
        ("the same, transformed and kept (`Pipeline::look`, `Frame::push`)", "chirp"),
        ("the search for two targets in 32 chirps of 127 bins (`Frame::targets`)", "targets"),
        ("range by phase of a target at rest (`PhaseRanging::at_rest`)", "phase range"),
        ("of a target that moves, by both ramps (`PhaseRanging::moving`)", "phase ranges"),
        ("the whole error of a target (`Uncertainty::of_target`)", "budget"),
        ("a block's arrival (`RateCheck::push`)", "clock push"),
        ("the clock error (`RateCheck::error`)", "clock error"),
    ] {
        let of = |core: &str| budget.at(&format!("/ranging/{core}/{stage}")).map(rounded);
        lines.push(row([name.to_owned(), of("M0")?, of("M4F")?]));
    }
    Ok(lines)
}

fn sizes(_: &Table) -> Lines {
    let budget = Budget::read()?;
    let mut lines = head("| program | M0 | M3 | M4F |");
    for (name, which) in [
        (
            "`Pipeline::tone`, with every verdict and sigma (`firmware/src/bin/single.rs`), for size",
            0,
        ),
        ("the same at opt-level 3", 1),
        ("`FrequencyOnly`, without verdicts (`firmware/src/bin/frequency_only.rs`), for size", 2),
    ] {
        let mut cells = vec![name.to_owned()];
        for core in ["M0", "M3", "M4F"] {
            let bytes = budget.at(&format!("/single_images/{core}/{which}"))?;
            cells.push(format!("{:.1}", bytes / 1e3));
        }
        lines.push(row(cells));
    }
    Ok(lines)
}
