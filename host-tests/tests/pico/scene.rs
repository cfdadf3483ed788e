//! What is in front of the converter, and what the host makes of it.

use picket_claims::scenes::{Kind, line, tones};
use picket_dsp::acquire::sample::{Real, Stamp};
use picket_dsp::pipeline::{Measurement, Pipeline};
use picket_dsp::plan::EitherPlan;
use picket_dsp::tone::Verdict;
use picket_firmware::pico::widths::{corrected, widen};
use picket_firmware::pico::words::Words;
use picket_firmware::pico::{N, Pairs};
use picket_host::device::{Listener, Said};
use picket_host::pico;
use picket_host::pico::bench::Pico;
use picket_host::pico::converter::Converter;
use picket_simulator::Value;
use picket_simulator::scene::{Change, Tone};
use picket_wire::boot::Clock;
use picket_wire::command::Command;
use picket_wire::settings::Settings;
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use std::sync::OnceLock;

/// The image as it lies in flash. `PICKET_PICO` names another one than this source's.
pub fn image() -> &'static [u8] {
    static IMAGE: OnceLock<Vec<u8>> = OnceLock::new();
    IMAGE.get_or_init(|| {
        if let Some(other) = std::env::var_os("PICKET_PICO") {
            return std::fs::read(other).unwrap();
        }
        let elf = pico::image().unwrap_or_else(|error| panic!("{error}"));
        pico::binary(&elf).unwrap_or_else(|error| panic!("{error}"))
    })
}

/// The image's checksum.
pub fn program() -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(image())
}

/// A board with this source's image.
pub fn plug() -> Pico {
    plugged(image)
}

/// A board with the image that has a serial port over USB.
pub fn plug_usb() -> Pico {
    static IMAGE: OnceLock<Vec<u8>> = OnceLock::new();
    plugged(|| {
        IMAGE.get_or_init(|| {
            let elf = pico::usb_image().unwrap_or_else(|error| panic!("{error}"));
            pico::binary(&elf).unwrap_or_else(|error| panic!("{error}"))
        })
    })
}

fn plugged(image: impl FnOnce() -> &'static [u8]) -> Pico {
    // Before minutes of building: what is missing is said at once.
    pico::bench::emulator().unwrap_or_else(|error| panic!("{error}"));
    Pico::plug(image()).unwrap_or_else(|error| panic!("{error}"))
}

/// What the board measures by unless told otherwise.
pub fn settings() -> Settings {
    Settings::default()
}

/// Blocks whose measurement takes longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hard {
    /// A code or two.
    Constant,
    /// Half of the samples at the rails.
    Clipped,
    /// A tone whose frequency rises by three bins: its fit takes further steps.
    Moving,
    /// The same below bin 48, beside a drift: another fit has the drift in it.
    Drifting,
    /// No tone.
    Noise,
    /// These in turn.
    Mixed,
}

/// Blocks one after the other, each with a tone of its own, some of them hard: one in so many.
pub fn stream(blocks: usize, hard: Option<(u64, Hard)>, seed: u64) -> Vec<i16> {
    let mut samples = Vec::with_capacity(blocks * N);
    let mut mixed = [Hard::Constant, Hard::Clipped, Hard::Moving, Hard::Noise].into_iter().cycle();
    for number in 0..blocks as u64 {
        let kind = match hard {
            Some((every, kind)) if number % every == every - 1 => match kind {
                Hard::Mixed => mixed.next(),
                kind => Some(kind),
            },
            _ => None,
        };
        samples.extend(block(kind, seed, number));
    }
    samples
}

fn block(kind: Option<Hard>, seed: u64, number: u64) -> Vec<i16> {
    let highest = if kind == Some(Hard::Drifting) { 48.0 } else { 500.0 };
    let (amplitude, noise): (Value, Value) = match kind {
        None => ((100.0..1800.0).into(), (0.5..8.0).into()),
        Some(Hard::Constant) => (0.0.into(), 0.3.into()),
        Some(Hard::Clipped) => (4_000.0.into(), 3.0.into()),
        Some(Hard::Moving | Hard::Drifting) => (1_000.0.into(), 3.0.into()),
        Some(Hard::Noise | Hard::Mixed) => (0.0.into(), 300.0.into()),
    };
    let mut tone = Tone { amplitude: Some(amplitude), ..line(3.0..highest, 1.0) };
    if matches!(kind, Some(Hard::Moving | Hard::Drifting)) {
        tone.changes = vec![Change::Chirp { hz_per_s: 3.0.into(), at_s: 0.0.into() }];
    }
    let mut scene = tones(Kind::Real, N, [tone], 0.0);
    (scene.seed, scene.receiver.noise.rms) = (seed, Some(noise));
    scene.receiver.offset[0] = 2048.0.into();
    if kind == Some(Hard::Drifting) {
        // Codes from the record's beginning to its end.
        let half = 25.0 + (number as f64 * 61.8).rem_euclid(225.0);
        scene.receiver.drift = Some(Value::Over(vec![[0.0, -half], [1.0, half]]));
    }
    let converter = Converter::default();
    let voltages = scene.run(number).unwrap().voltages(0.0, N);
    voltages.into_iter().map(|[voltage, _]| converter.code(voltage)).collect()
}

/// What measures a block of codes.
type Measure<'a> = dyn FnMut(&Stamp, &[i16]) -> Measurement + 'a;

/// The frames that a board sends which measures these blocks, each behind its guard, and loses none. The samples of pairs are I, Q, I, Q.
pub fn expected(settings: &Settings, samples: &[i16]) -> Vec<Vec<u8>> {
    let (plan, _) = Words::plan(settings).unwrap();
    let method = plan.plan.options.method;
    let correct = |code: i16| if settings.uncorrected { code } else { corrected(code) };
    let mut block: Box<Measure<'_>> = match plan.plan {
        EitherPlan::Real(plan) => {
            let mut pipeline = Box::new(Pipeline::<Real, N>::new(plan));
            Box::new(move |stamp, samples| {
                let block: [i16; N] = samples.try_into().unwrap();
                pipeline.block(stamp, &block.map(correct))
            })
        }
        EitherPlan::Iq(plan) => {
            let mut pipeline = Box::new(Pairs::new(plan));
            Box::new(move |stamp, samples| {
                let block: [[i16; 2]; N] = samples.as_chunks().0.try_into().unwrap();
                pipeline.block(stamp, &mut block.map(|pair| pair.map(correct)))
            })
        }
    };
    let each = if settings.iq { 2 } else { 1 };
    let guard = usize::from(settings.guard);
    let segments = samples.chunks_exact(each * (N + guard)).zip(0..);
    let frames = segments.map(|(segment, number)| {
        let mut measurement = block(&plan.timing.stamp(number, false), &segment[each * guard..]);
        widen(&mut measurement, !settings.uncorrected, settings.iq);
        Telemetry {
            measurement,
            method,
            health: Health::default(),
            basis: Some(plan.basis(Clock::External)),
            uncertainty: plan.total(&measurement),
        }
        .to_frame()
        .to_vec()
    });
    frames.collect()
}

/// Has a board follow other settings, from the first sample on of what `feed` gives it while it stands.
pub fn set_plan(pico: &mut Pico, settings: Settings, feed: impl FnOnce(&mut Pico)) {
    pico.request(Command::SetSettings(Settings { start: false, ..settings }, N)).unwrap().unwrap();
    assert!(!pico.boot().unwrap().measuring);
    pico.sent.clear();
    feed(pico);
    pico.request(Command::SetSettings(settings, N)).unwrap().unwrap();
    assert!(pico.boot().unwrap().measuring);
}

/// Lets so many more blocks be measured.
pub fn measure(pico: &mut Pico, blocks: u64) {
    let end = pico.listener().records + blocks;
    while pico.listener().records < end {
        let before = pico.listener().records;
        pico.frames(200.min(end - before), 3_000).unwrap();
        assert!(pico.listener().records > before, "it measures no more");
    }
}

/// The record in a frame.
pub fn record(frame: &[u8]) -> Option<Telemetry> {
    Listener::default().read(frame).into_iter().find_map(|said| match said {
        Said::Telemetry(record) => Some(record),
        _ => None,
    })
}

/// The records in what a board has sent: their sequence and their frames.
pub fn frames(sent: &[u8]) -> Vec<(u32, Vec<u8>)> {
    let frames = sent.split_inclusive(|&byte| byte == 0);
    frames
        .filter_map(|frame| Some((record(frame)?.measurement.stamp.sequence, frame.to_vec())))
        .collect()
}

/// A record without what tells of losses and gaps, and without its place in the sequence.
pub fn measured(frame: &[u8]) -> Option<Telemetry> {
    let mut record = record(frame)?;
    record.health = Health::default();
    // A block after a gap has another verdict, and its own beside it.
    record.measurement.tone.verdict = Verdict::default();
    record.measurement.tone.also = Default::default();
    let stamp = &mut record.measurement.stamp;
    (stamp.gap, stamp.sequence, stamp.clock) = (false, 0, 0);
    Some(record)
}

/// The board's status.
pub fn status(pico: &mut Pico) -> Status {
    // Not one of those that it sends each second.
    pico.forget_status();
    pico.request(Command::Status).unwrap().unwrap();
    pico.expect(|said| match said {
        Said::Status(status) => Some(*status),
        _ => None,
    })
    .unwrap()
}
