//! Tables of what boards' images, other programs and long campaigns take: `host-tests/figures.json` has what tests measured.

use super::Table;
use super::figures::{self, head, measured, row, whole};
use crate::rates::{self, Rates};
use picket_dsp::Effort;

const BOARD: &str = "docs/board.md";
const PICO: &str = "docs/pico.md";

pub(super) const TABLES: &[Table] = &[
    Table::new(BOARD, "images", images),
    Table::new(BOARD, "blocks", blocks),
    Table::new(BOARD, "rates", |_| rates_of(&rates::nucleo())),
    Table::new(BOARD, "latency", |_| latency("board", "a steady tone", "a steady tone's")),
    Table::new(BOARD, "held", held),
    Table::new(BOARD, "several", several),
    Table::new(BOARD, "sums", sums),
    Table::new(BOARD, "frames", frames),
    Table::new(PICO, "rates", |_| rates_of(&rates::pico())),
    Table::new(PICO, "worst", worst),
    Table::new(PICO, "latency", |_| latency("pico", "a usual block", "a usual block's")),
    Table::new(PICO, "codes", codes),
    Table::new("docs/proofs.md", "effort", effort),
    Table::new("docs/trust.md", "false alarms", false_alarms),
    Table::new("docs/python.md", "errors", errors),
];

/// What the board was doing when its stack was read.
const DOING: [&str; 8] = [
    "block by block",
    "following a tone",
    "with four tones",
    "with sums",
    "with sums of I/Q blocks",
    "with bursts",
    "with frames",
    "with frames of I/Q chirps",
];

type Lines = Result<Vec<String>, String>;

fn images(_: &Table) -> Lines {
    let [flash, ram] = measured("board, bytes of flash and RAM without the stack")?.map(whole);
    let mut lines = head("| | B |");
    lines.push(row(["flash".to_owned(), flash]));
    lines.push(row(["RAM without the stack".to_owned(), ram]));
    for doing in DOING {
        let [stack] = measured(&format!("board, bytes of stack, {doing}"))?.map(whole);
        lines.push(row([format!("stack {doing}"), stack]));
    }
    Ok(lines)
}

fn blocks(_: &Table) -> Lines {
    let [usual] = measured("board, instructions of a block")?;
    let worst: [f64; 8] =
        measured("board, instructions of the worst block that a short search finds")?;
    let (real, iq) = worst.split_at(4);
    let mut lines = head("| a block of 1024, instructions of this image | real | I/Q |");
    lines.push(row(["a tone".to_owned(), whole(usual), String::new()]));
    for (effort, (real, iq)) in Effort::ALL.iter().zip(real.iter().zip(iq)) {
        let name = format!("the worst that a short search found, at effort {}", effort.name());
        lines.push(row([name, whole(*real), whole(*iq)]));
    }
    Ok(lines)
}

/// In thousands a second: four digits.
fn kilohertz(hertz: f64) -> String {
    if hertz < 1e6 { format!("{:.1}", hertz / 1e3) } else { whole(hertz / 1e3) }
}

fn rates_of(all: &[Rates]) -> Lines {
    let efforts = all.first().map_or(&[][..], |rates| &rates.always_hz);
    let columns =
        efforts.iter().map(|(effort, _)| format!("any signal, effort {} |", effort.name()));
    let columns: Vec<String> = columns.collect();
    let mut lines =
        head(&format!("| the highest rate, kS/s | usual blocks | {}", columns.join(" ")));
    for Rates { kind, usual_hz, always_hz } in all {
        let mut always: Vec<String> =
            always_hz.iter().map(|(_, hertz)| kilohertz(*hertz)).collect();
        always.resize(efforts.len(), "not searched".to_owned());
        lines.push(row([kind.to_string(), kilohertz(*usual_hz)].into_iter().chain(always)));
    }
    Ok(lines)
}

fn latency(board: &str, usual: &str, whose: &str) -> Lines {
    let mut lines =
        head("| from a block's last sample to its record's last byte, ms | median | most |");
    for (what, whose) in [(usual, whose), ("a tone that takes longest", "the longest block's")] {
        let delays: [f64; 2] = measured(&format!("{board}, ms to {whose} record"))?;
        let [median, most] = delays.map(|delay| format!("{delay:.2}"));
        lines.push(row([what.to_owned(), median, most]));
    }
    Ok(lines)
}

fn held(_: &Table) -> Lines {
    let [held, search] =
        measured("board, instructions of a held block and of a search")?.map(whole);
    let mut lines = head("| a block of 1024 while it follows | instructions |");
    lines.push(row(["measured near the expected frequency".to_owned(), held]));
    lines.push(row(["searched in full".to_owned(), search]));
    Ok(lines)
}

fn several(_: &Table) -> Lines {
    let [four, two, one] =
        measured("board, instructions of blocks of 4, 2 and 1 tones")?.map(whole);
    let [harmonics] = measured("board, instructions of a block of harmonics")?.map(whole);
    let [fastest_four, fastest_two, fastest_harmonics] =
        measured("board, kS/s with 4 tones, with 2 and with harmonics")?.map(whole);
    let fastest_one = rates::nucleo().first().map_or(f64::NAN, |real| real.usual_hz);
    let mut lines = head("| a block | `most` 4 | 2 | 1 | `harmonics` 10 |");
    lines.push(row(["takes at most, instructions".to_owned(), four, two, one, harmonics]));
    let one = whole(fastest_one / 1e3);
    lines.push(row([
        "holds at 180 MHz, kS/s".to_owned(),
        fastest_four,
        fastest_two,
        one,
        fastest_harmonics,
    ]));
    Ok(lines)
}

fn false_alarms(_: &Table) -> Lines {
    let mut lines = head("| noise | N 64 | N 1024 | N 1024, bins 100 to 200 | I/Q, N 256 |");
    for (name, power) in [
        ("white", "white"),
        ("1/f", "falls with `1/f`"),
        ("1/f^2", "falls with `1/f^2`"),
        ("1/f^3", "falls with `1/f^3`"),
        ("a knee", "white, below bin 10 as `1/f^2`"),
        ("a wide hump", "10 dB louder in 32 bins in the middle"),
        ("a narrow hump", "6 dB louder in 8 bins in the middle"),
    ] {
        let alarms: [f64; 4] = measured(&format!("false alarms over those asked, {name}"))?;
        let [n64, n1024, far, iq] = alarms.map(|alarms| format!("{alarms:.1}"));
        lines.push(row([power.to_owned(), n64, n1024, far, iq]));
    }
    Ok(lines)
}

fn sums(_: &Table) -> Lines {
    let mut lines = head("| instructions | a block | the last block of a sum |");
    for kind in ["real", "I/Q"] {
        let [block, last] =
            measured(&format!("board, instructions of {kind} blocks in a sum"))?.map(whole);
        lines.push(row([format!("sums of {kind} blocks"), block, last]));
    }
    let [burst] = measured("board, instructions of a burst")?.map(whole);
    lines.push(row(["a burst, at most".to_owned(), burst, String::new()]));
    let [sums, bursts] = measured("board, kS/s with sums and with bursts")?.map(whole);
    for (what, rate) in [("sums of 100 blocks", sums), ("bursts", bursts)] {
        lines.push(row([
            format!("kS/s of real records with `slots` 8: {what}"),
            rate,
            String::new(),
        ]));
    }
    Ok(lines)
}

fn frames(_: &Table) -> Lines {
    let mut lines = head(
        "| chirps | instructions a chirp | instructions of the search for two targets | its time at 180 MHz, s | frames of 64 chirps a second at 500 kS/s |",
    );
    for kind in ["real", "I/Q"] {
        let name = format!(
            "board, instructions of a chirp in a frame and of the search for two targets, {kind}"
        );
        let [chirp, search] = measured(&name)?;
        // By the cycles that an instruction of a usual block takes.
        let seconds = 1.4 * search / 180e6;
        let frame_s = 64.0 * 1088.0 / 500e3;
        let rate = 1.0 / (frame_s + seconds);
        lines.push(row([
            kind.to_owned(),
            whole(chirp),
            whole(search),
            format!("{seconds:.2}"),
            format!("{rate:.1}"),
        ]));
    }
    Ok(lines)
}

fn worst(_: &Table) -> Lines {
    let mut lines = head(
        "| a tone below bin 48 that moves beside a drift | ms | cycles | reserved by the board, cycles |",
    );
    let [ms] = measured("pico, ms of the longest block")?;
    let reserved = picket_firmware::pico::words::WORST_CYCLES;
    lines.push(row([
        "at most".to_owned(),
        format!("{ms:.3}"),
        whole(144e3 * ms),
        whole(reserved as f64),
    ]));
    Ok(lines)
}

fn codes(_: &Table) -> Lines {
    let mut lines = head(
        "| converter and handling | error, mHz rms | median sigma, mHz | error, sigmas rms | worst of 4000, sigmas |",
    );
    for name in [
        "an ideal converter",
        "as it is",
        "`uncorrected`",
        "corrected, table right",
        "corrected, steps a third less",
        "corrected, steps a third more",
        "corrected, by turns",
    ] {
        let figures: [f64; 4] = measured(&format!("pico, wide codes, {name}"))?;
        let [rms, sigma, sigmas, worst] = figures;
        let figures = [
            format!("{rms:.2}"),
            format!("{sigma:.2}"),
            format!("{sigmas:.2}"),
            format!("{worst:.1}"),
        ];
        lines.push(row([name.to_owned()].into_iter().chain(figures)));
    }
    Ok(lines)
}

fn effort(_: &Table) -> Lines {
    let mut lines = head(
        "| beside the tone | refused %: 0 | 2 | 3 rounds | refused, right %: 0 | 2 | 3 | usable, off %: 0 | 2 | 3 | sigma: 0 | 2 | 3 |",
    );
    let all = figures::read("figures.json")?;
    let names = all.as_object().into_iter().flat_map(|all| all.keys());
    for group in names.filter_map(|name| name.strip_prefix("effort, ")) {
        let figures: [f64; 12] = measured(&format!("effort, {group}"))?;
        let figures = figures.map(|figure| format!("{figure:.2}"));
        lines.push(row([group.to_owned()].into_iter().chain(figures)));
    }
    Ok(lines)
}

fn errors(_: &Table) -> Lines {
    let mut lines = head("| | N = 256 | 1024 | 4096 |");
    let ours: [f64; 3] = measured("python, rms error, mHz")?;
    let theirs: [f64; 3] = measured("python, scipy's rms error, mHz")?;
    let digits = |figure: f64| match figure {
        ..10.0 => format!("{figure:.2}"),
        ..100.0 => format!("{figure:.1}"),
        _ => whole(figure),
    };
    lines.push(row(["rms error, mHz".to_owned()].into_iter().chain(ours.map(digits))));
    lines.push(row(["scipy's, mHz".to_owned()].into_iter().chain(theirs.map(whole))));
    Ok(lines)
}
