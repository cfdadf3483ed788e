//! The NUCLEO's real image on QEMU's STM32F405: every record to the bit, every fault counted, over commands, restarts and noise
//! on the line.

use super::tally::{Fault, Tally};
use super::{same, samples};
use crate::board::{Board, image};
use crate::device::{Blocks, Said};
use crate::emulator::RunError;
use picket_dsp::acquire::frontend::Counters;
use picket_dsp::acquire::sample::Real;
use picket_dsp::pipeline::Pipeline;
use picket_firmware::instrument::bounds::Saves;
use picket_firmware::instrument::plan::Plan;
use picket_firmware::nucleo_f446re::words::Words;
use picket_firmware::nucleo_f446re::words::clock::{Source, Speed, Tree};
use picket_wire::boot::Boot;
use picket_wire::command::{Command, Refusal, Request};
use picket_wire::settings::Settings;
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;
use std::sync::OnceLock;

const N: usize = 1024;
/// Blocks in a life.
const ROUNDS: usize = 400;

struct Life {
    rng: ChaCha8Rng,
    board: Board,
    plan: Plan<N>,
    pipeline: Box<Pipeline<Real, N>>,
    number: u64,
    gap: bool,
    expected: Counters,
    /// What the counters stood at when they were set to 0.
    zero: Counters,
    /// The saves since the power came, which restarts do not forget.
    saves: Saves,
    tally: Tally,
}

/// Lives life `number` of this seed.
///
/// # Errors
/// The emulator does not run, or what came out is not what must; in a sentence.
pub fn live(seed: u64, number: u64) -> Result<Tally, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    static IMAGE: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let path = IMAGE.get_or_init(|| image(true, false).map_err(|error| error.to_string()));
    let board = Board::start(path.as_ref()?).map_err(told)?;
    let tree = Tree::new(Speed::Mhz180, Source::Hsi);
    let planned = Words::plan::<N>(&Settings::default(), &tree);
    let (plan, _) = planned.map_err(|error| format!("{error:?}"))?;
    let terms = picket_dsp::Plan::from_terms(*plan.plan).map_err(|error| error.to_string())?;
    let (expected, zero) = (Counters::default(), Counters::default());
    let (saves, tally) = (Saves::default(), Tally { lives: 1, ..Tally::default() });
    let pipeline = Box::new(Pipeline::new(terms));
    let mut life =
        Life { rng, board, plan, pipeline, number: 0, gap: false, expected, zero, saves, tally };
    life.boot()?;
    for _ in 0..ROUNDS {
        life.round()?;
    }
    life.status()?;
    Ok(life.tally)
}

fn told(error: RunError) -> String {
    error.to_string()
}

impl Life {
    /// Waits for the start; then everything counts from 0.
    fn boot(&mut self) -> Result<(), String> {
        let boot = self.board.expect(|said| match said {
            Said::Boot(boot) => Some(boot),
            _ => None,
        });
        let Boot { measuring, last, .. } = boot.map_err(told)?;
        same("whether it measures after its start", measuring, true)?;
        same("how the last program ended", last.kind, 0)?;
        (self.number, self.gap) = (0, false);
        (self.expected, self.zero) = (Counters::default(), Counters::default());
        Ok(())
    }

    fn lose(&mut self, blocks: u32) {
        self.number += u64::from(blocks);
        self.gap |= blocks > 0;
        self.tally.lost += u64::from(blocks);
    }

    fn round(&mut self) -> Result<(), String> {
        match self.rng.random_range(0..40) {
            0..4 => {
                // A block whose interrupt is lost: the next one's tells both.
                self.tally.fault(Fault::Late);
                let lost = bytes(&samples::<Real, N>(&mut self.rng, true)?);
                let runs = self.board.fill(&lost).map_err(told)?;
                same("whether the stream runs", runs, true)?;
                self.expected.missed += 1;
                self.lose(1);
            }
            4..8 => {
                self.tally.fault(Fault::Doubled);
                self.board.interrupt().map_err(told)?;
                self.expected.spurious += 1;
                self.status()?;
            }
            8..12 => {
                self.tally.fault(Fault::Transfer);
                self.board.dma_error().map_err(told)?;
                self.expected.dma_errors += 1;
                self.expected.broken += 1;
                self.lose(1);
                self.status()?;
            }
            12..16 => {
                self.tally.fault(Fault::Overrun);
                self.board.adc_overrun().map_err(told)?;
                self.expected.adc_overruns += 1;
                self.expected.broken += 1;
                self.lose(1);
                self.status()?;
            }
            16..18 => self.noise()?,
            18 => {
                self.order(Command::Reset)?;
                self.zero = self.expected;
            }
            19 => {
                let again = if self.rng.random() { Command::Reboot } else { Command::Start };
                self.order(again)?;
                self.tally.fault(Fault::Pause);
                self.boot()?;
            }
            20 => {
                let answer = self.board.request(Command::Save).map_err(told)?;
                // A life is shorter than the ten minutes that permit one more.
                if !self.saves.permit() {
                    return same("the answer to one save more", answer, Err(Refusal::Often));
                }
                // This emulator has no flash controller. The samples stop all the same, for a block.
                same("the answer to a save", answer, Err(Refusal::Flash))?;
                self.tally.fault(Fault::Pause);
                self.expected.broken += 1;
                self.lose(1);
            }
            21 => return self.captured(),
            22 => self.status()?,
            _ => {}
        }
        self.block()
    }

    /// A block, and the record of it.
    fn block(&mut self) -> Result<(), String> {
        let samples = samples::<Real, N>(&mut self.rng, true)?;
        let runs = self.board.block(&bytes(&samples)).map_err(told)?;
        same("whether the stream runs", runs, true)?;
        self.expected.blocks += 1;
        self.tally.blocks += 1;
        let stamp = self.plan.timing.stamp(self.number, self.gap);
        let measurement = self.pipeline.block(&stamp, &samples);
        let since = self.expected.since(&self.zero);
        let health = Health { lost: since.lost(), faults: since.faults() };
        let (method, basis) =
            (self.plan.plan.options.method, Some(self.plan.basis(Source::Hsi.clock())));
        let ours = Telemetry { measurement, method, health, basis, uncertainty: None };
        let theirs = self.board.expect(|said| match said {
            Said::Telemetry(record) => Some(record),
            _ => None,
        });
        let theirs = theirs.map_err(told)?;
        if theirs.to_bytes() != ours.to_bytes() {
            return Err(format!("block {}: {theirs:?}, not {ours:?}", self.number));
        }
        (self.number, self.gap) = (self.number + 1, false);
        Ok(())
    }

    /// The board's counters are those that are expected.
    fn status(&mut self) -> Result<(), String> {
        self.order(Command::Status)?;
        let status = self.board.expect(|said| match said {
            Said::Status(status) => Some(status),
            _ => None,
        });
        let Status { counters, dropped, .. } = status.map_err(told)?;
        same("the counters", counters, self.expected.since(&self.zero))?;
        same("frames that had no room", dropped, 0)
    }

    fn order(&mut self, command: Command) -> Result<(), String> {
        match self.board.request(command).map_err(told)? {
            Ok(_) => Ok(()),
            Err(refusal) => Err(format!("{command:?}: {refusal}")),
        }
    }

    /// Damaged commands: each is refused, and none followed.
    fn noise(&mut self) -> Result<(), String> {
        for _ in 0..10 {
            let request = Request { tag: self.rng.random(), command: Command::Stop };
            let mut wire = request.to_frame().to_vec();
            let place = self.rng.random_range(0..wire.len() - 1);
            wire[place] ^= 1 << self.rng.random_range(0..8);
            // A zero of its own ends what the damage may have joined.
            wire.push(0);
            self.board.send(&wire).map_err(told)?;
            self.tally.damaged += 1;
        }
        // It measures still.
        self.status()
    }

    /// A block's samples come back as they were played.
    fn captured(&mut self) -> Result<(), String> {
        self.order(Command::Capture(1))?;
        let samples = samples::<Real, N>(&mut self.rng, true)?;
        let runs = self.board.block(&bytes(&samples)).map_err(told)?;
        same("whether the stream runs", runs, true)?;
        let mut pieces = Blocks::default();
        let raw = self.board.expect(|said| match said {
            Said::Raw(raw) => pieces.push(&raw, 2 * N),
            _ => None,
        });
        let (sequence, raw) = raw.map_err(told)?;
        same("a captured block's number", sequence, self.number as u32)?;
        same("a captured block", raw == bytes(&samples), true)?;
        self.expected.blocks += 1;
        self.tally.blocks += 1;
        // The record of it went by; the pipeline here measures no chirp, and so forgets nothing.
        (self.number, self.gap) = (self.number + 1, false);
        Ok(())
    }
}

fn bytes(samples: &[i16]) -> Vec<u8> {
    samples.iter().flat_map(|sample| sample.to_le_bytes()).collect()
}
