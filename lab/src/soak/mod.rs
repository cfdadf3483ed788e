//! `lab soak`: random faults for as long as you like, against a model that knows what must come out.

pub mod life;
pub mod line;
mod mps2;
mod nucleo;
mod stream;
pub mod tally;

use crate::cli::{self, Failure};
use crate::toolchain::{Need, Target, have};
use crate::{end, progress};
use clap::{Args, ValueEnum};
use picket_dsp::acquire::sample::Record;
use picket_simulator::Scene;
use picket_simulator::scene::{Source, Tone};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tally::{Fault, Tally};

/// Runs the instrument under random faults: no block may be mixed, every loss is counted, every stamp is exact.
#[derive(Args, Debug)]
pub struct Options {
    /// How long
    #[arg(long, default_value_t = 1.0, value_parser = minutes)]
    minutes: f64,
    /// The seed of the faults: the same ones come in the same order
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    faults: u64,
    /// Ends after this many runs from power-on
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..))]
    lives: Option<u64>,
    /// What runs
    #[arg(long, value_enum, default_value_t = Board::Host)]
    board: Board,
    /// One JSON object
    #[arg(long)]
    json: bool,
}

/// What runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Board {
    /// The front end on this machine, on a model of the NUCLEO's stream at every access to a register; and frames over a bad line
    Host,
    /// The NUCLEO's image on QEMU, block by block
    Nucleo,
    /// The front end on QEMU's AN505, at a pace at which it loses blocks
    Mps2,
}

impl Board {
    const fn name(self) -> &'static str {
        match self {
            Board::Host => "host",
            Board::Nucleo => "nucleo",
            Board::Mps2 => "mps2",
        }
    }

    const fn needs(self) -> &'static [Need] {
        match self {
            Board::Host => &[],
            Board::Nucleo => &[Need::Core(Target::M4f), Need::Emulator],
            Board::Mps2 => &[Need::Core(Target::M33), Need::Emulator],
        }
    }

    fn live(self, seed: u64, number: u64) -> Result<Tally, String> {
        match self {
            Board::Host => {
                let mut tally = life::live(seed, number)?;
                tally += line::send(seed, number)?;
                Ok(tally)
            }
            Board::Nucleo => nucleo::live(seed, number),
            Board::Mps2 => mps2::live(seed, number),
        }
    }
}

fn minutes(text: &str) -> Result<f64, String> {
    let fits = |minutes: &f64| *minutes <= 1e6;
    cli::positive(text).ok().filter(fits).ok_or_else(|| "give minutes, at most a million".into())
}

/// Runs until the time is over, the count is full, the user ends it, or something is wrong.
pub fn run(options: &Options) -> Result<ExitCode, Failure> {
    let &Options { minutes, faults: seed, lives, board, json } = options;
    have(board.needs()).map_err(|error| error.to_string())?;
    let begun = Instant::now();
    let limit = Duration::from_secs_f64(60.0 * minutes);
    let bar = progress::bar(limit.as_secs().max(1), "seconds");
    let (mut tally, mut wrong) = (Tally::default(), None);
    end::look();
    for number in 0..lives.unwrap_or(u64::MAX) {
        if begun.elapsed() >= limit || end::asked().is_some() {
            break;
        }
        match board.live(seed, number) {
            Ok(more) => tally += more,
            Err(what) => {
                wrong = Some((number, what));
                break;
            }
        }
        bar.set_position(begun.elapsed().as_secs());
    }
    bar.finish_and_clear();
    match json {
        true => cli::print_line(&object(board, seed, &tally, wrong.as_ref()).to_string()),
        false => table(board, seed, begun.elapsed(), &tally),
    }
    match wrong {
        None => Ok(ExitCode::SUCCESS),
        Some((number, what)) => Err(Failure::unwritten(format!(
            "seed {seed}, run {number}: {what}; --lives {} repeats it",
            number + 1
        ))),
    }
}

fn table(board: Board, seed: u64, time: Duration, tally: &Tally) {
    let seconds = time.as_secs_f64();
    outln!("{}, seed {seed}: {} runs from power-on in {seconds:.0} s", board.name(), tally.lives);
    let rows = [
        (tally.blocks, "blocks came out, none mixed, every stamp exact"),
        (tally.lost, "blocks were lost, every one counted"),
        (tally.wraps, "runs went over the wrap of sequence or clock"),
        (tally.damaged, "damaged frames, none accepted"),
        (tally.all_faults(), "faults:"),
    ];
    for (count, what) in rows {
        outln!("{count:>16}  {what}");
    }
    for (fault, name) in Fault::ALL {
        outln!("{:>16}    {}", tally.faults[fault as usize], name.replace('_', " "));
    }
}

fn object(board: Board, seed: u64, tally: &Tally, wrong: Option<&(u64, String)>) -> Value {
    let mut object = Map::new();
    object.insert("summary".into(), true.into());
    object.insert("board".into(), board.name().into());
    let counts = [
        ("seed", seed),
        ("lives", tally.lives),
        ("blocks", tally.blocks),
        ("lost", tally.lost),
        ("wraps", tally.wraps),
        ("damaged_frames", tally.damaged),
        ("faults", tally.all_faults()),
    ];
    for (key, count) in counts {
        object.insert(key.into(), count.into());
    }
    for (fault, key) in Fault::ALL {
        object.insert(format!("faults_{key}"), tally.faults[fault as usize].into());
    }
    let wrong = wrong.map_or(Value::Null, |(life, what)| format!("run {life}: {what}").into());
    object.insert("wrong".into(), wrong);
    object.into()
}

/// An error that says what is wrong, unless both are the same.
fn same<T: PartialEq + std::fmt::Debug>(what: &str, got: T, wanted: T) -> Result<(), String> {
    if got == wanted { Ok(()) } else { Err(format!("{what} is {got:?}, not {wanted:?}")) }
}

/// A block of 12 bits: a tone of any frequency from a code's level to more than the rails, in noise up to the rails.
fn samples<R: Record, const N: usize>(
    rng: &mut ChaCha8Rng,
    unsigned: bool,
) -> Result<[R::Sample; N], String> {
    let amplitude = 2047.0 * 10f64.powf(rng.random_range(-3.0..0.2));
    let noise = 2047.0 * 10f64.powf(rng.random_range(-4.0..0.0));
    let tone = Tone {
        frequency_hz: (-0.5..0.5).into(),
        amplitude: Some(amplitude.into()),
        ..Tone::default()
    };
    let mut scene = Scene {
        seed: rng.random(),
        rate_hz: 1.0,
        seconds: N as f64,
        sources: vec![Source::Tone(tone)],
        ..Scene::default()
    };
    scene.receiver.iq = R::IQ;
    scene.receiver.noise.rms = Some(noise.into());
    scene.converter.unsigned = unsigned;
    let codes = scene.codes(0)?;
    Ok(std::array::from_fn(|n| R::from_parts(codes.get(n).copied().unwrap_or_default())))
}
