//! The clock's part in sigma reaches every kind of record, and the calibration every range.

use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Block, Counters};
use picket_dsp::acquire::sample::Iq;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::pipeline::Measurement;
use picket_dsp::solve::chirp::Shape;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::Tone;
use picket_instrument::clock::{self, INTERNAL};
use picket_instrument::every::Every;
use picket_instrument::meter::Meters;
use picket_instrument::plan::Plan;
use picket_instrument::slot::Slot;
use picket_instrument::storage::NoStorage;
use picket_instrument::{Clocks, Instrument, Port, Slots, Start};
use picket_wire::boot::Clock;
use picket_wire::follow::Follow;
use picket_wire::frame::{Frame, Kind, Reader};
use picket_wire::fundamental::Fundamental;
use picket_wire::lines::Lines;
use picket_wire::settings::{Calibration, Drive, Settings};
use picket_wire::settings_error::SettingsError;
use picket_wire::telemetry::Telemetry;
use std::f64::consts::TAU;

const N: usize = 256;

/// A board of which nothing is real but its clock.
struct Board {
    clock: Clock,
    reader: Reader,
    said: Vec<Frame>,
}

/// Memory for the next block.
struct Free(Vec<Slot<N>>);

impl Slots<N> for Free {
    fn release(&mut self, slot: Slot<N>) {
        self.0.push(slot);
    }
}

impl Port<N, N> for Board {
    const NAME: &'static str = "test";
    const CODES: Codes = Codes::signed::<16>();
    type Words = ();
    type Storage = NoStorage;
    type Slots = Free;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, ()), SettingsError> {
        Ok((Plan::new(settings, settings.config.rate_hz)?, ()))
    }

    fn widen(&self, measurement: &mut Measurement) {
        clock::widen(self.clock, measurement);
    }

    fn counters(&self) -> Counters {
        Counters::default()
    }

    fn ticks(&self) -> u32 {
        0
    }

    fn has_room(&self, _: usize) -> bool {
        true
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        let frames = frame.iter().filter_map(|&byte| self.reader.push(byte)?.ok());
        self.said.extend(frames);
        true
    }
}

/// What is said of these blocks of pairs, by this clock.
fn said(settings: Settings, clock: Clock, blocks: &[Vec<[i16; 2]>]) -> Vec<Frame> {
    let memory = Box::leak(Box::new([0u32; N]));
    let mut board = Board { clock, reader: Reader::default(), said: Vec::new() };
    let clocks = Clocks { source: clock, core_hz: 1_000_000, ticks_hz: 1_000_000 };
    let start = Start { settings, clocks, ..Start::default() };
    let mut meters = Box::new(Meters::<(), Every<Iq, N, 0>>::IDLE);
    let (mut instrument, ()) = Instrument::new(&board, start, NoStorage, &mut *meters).unwrap();
    instrument.begin(&mut board, Some(Free(vec![Slot::new(memory)])));
    for (number, pairs) in blocks.iter().enumerate() {
        let mut slot = instrument.slots().unwrap().0.pop().unwrap();
        slot.samples_mut::<Iq, N>(0).copy_from_slice(pairs);
        let stamp = instrument.plan().timing.stamp(number as u64, false);
        instrument.on_block(&mut board, Block { stamp, counters: Counters::default(), slot });
    }
    board.said
}

/// Pairs of tones of these bins, and a little noise.
fn pairs(bins: &[f64], seed: u32) -> Vec<[i16; 2]> {
    let mut state = seed;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 16) / 65_536.0 * 20.0 - 10.0
    };
    let pair = |n: usize| {
        let mut sum = [noise(), noise()];
        for bin in bins {
            let angle = TAU * bin * n as f64 / N as f64;
            sum = [sum[0] + 2000.0 * angle.cos(), sum[1] + 2000.0 * angle.sin()];
        }
        sum.map(|part| part.round() as i16)
    };
    (0..N).map(pair).collect()
}

/// The sigma of a number that the clock paces, and the number.
type Seen = (f64, f64);

fn tone(tone: &Tone) -> Seen {
    (tone.sigma.into(), tone.frequency.0.to_num())
}

/// Asserts that an internal oscillator widens each number that `read` finds by its part, and changes nothing else. Returns how many those
/// are.
fn widened(
    settings: Settings,
    blocks: &[Vec<[i16; 2]>],
    read: impl Fn(&Frame) -> Vec<Seen>,
) -> usize {
    let [exact, wide] = [Clock::External, Clock::Internal].map(|clock| {
        let frames = said(settings, clock, blocks);
        frames.iter().flat_map(&read).collect::<Vec<Seen>>()
    });
    assert_eq!(exact.len(), wide.len());
    for ((sigma, number), (wider, same)) in exact.iter().zip(&wide) {
        assert_eq!(number, same);
        let expected = sigma.hypot(f64::from(INTERNAL) * number);
        assert!((wider / expected - 1.0).abs() < 1e-5, "{wider} for {expected}");
    }
    exact.len()
}

fn settings(scene: Scene) -> Settings {
    let config = Config { codes: Board::CODES, scene, rate_hz: 1e4, ..Settings::default().config };
    Settings { iq: true, config, start: true, ..Settings::default() }
}

#[test]
fn tones_and_a_fundamental() {
    let settings = Settings { most: 3, harmonics: 3, ..settings(Scene::Tone) };
    let count = widened(settings, &[pairs(&[20.3, 40.6, 60.9], 1)], |frame| match frame.kind {
        Kind::Telemetry => vec![tone(&Telemetry::from_frame(frame).unwrap().measurement.tone)],
        Kind::Lines => {
            let lines = Lines::from_frame(frame).unwrap();
            lines.tones.iter().map(|line| tone(&line.tone)).collect()
        }
        Kind::Fundamental => vec![tone(&Fundamental::from_frame(frame).unwrap().harmonic.tone)],
        _ => Vec::new(),
    });
    assert_eq!(count, 1 + 3 + 1);
}

#[test]
fn tracks_and_their_targets() {
    let chirp = Chirp { shape: Shape::Triangle, duration_s: 0.0256, ..Chirp::default() };
    let mut settings = settings(Scene::Chirp(chirp));
    settings.drive = Drive::External;
    settings.config.following = Following { most: 1, ..Following::default() };
    // A target that approaches: its falling beat is higher.
    let blocks: Vec<_> =
        (0..12).map(|n| pairs(&[if n % 2 == 0 { 20.3 } else { -24.3 }], n)).collect();
    let ranges = |settings| {
        let ranges = std::cell::RefCell::new(Vec::new());
        let count = widened(settings, &blocks, |frame| {
            let Kind::Follow = frame.kind else { return Vec::new() };
            let follow = Follow::from_frame(frame).unwrap();
            let tracks = follow
                .tracks
                .iter()
                .map(|track| (f64::from(track.sigma), track.frequency.0.to_num::<f64>()));
            let targets = follow.targets.iter().map(|(_, target)| {
                ranges.borrow_mut().push(target.range.to_num::<f64>());
                (f64::from(target.sigma_velocity), target.velocity.unwrap().to_num::<f64>())
            });
            tracks.chain(targets).collect()
        });
        (count, ranges.into_inner())
    };
    let (count, ideal) = ranges(settings);
    assert!(count >= 15 && ideal.len() > 6, "{count}, {ideal:?}");
    // One block has one range, whichever record tells it.
    settings.calibration = Calibration { range_offset_m: 0.25, ..Calibration::default() };
    let (_, moved) = ranges(settings);
    for (moved, ideal) in moved.iter().zip(&ideal) {
        assert!((moved - ideal - 0.25).abs() < 1e-6, "{moved}, {ideal}");
    }
}
