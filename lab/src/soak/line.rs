//! Frames over a line that damages them: none but what was sent is accepted.

use super::tally::Tally;
use picket_dsp::acquire::frontend::Counters;
use picket_dsp::config::{Config, Scene};
use picket_wire::command::{Command, Request};
use picket_wire::frame::{Frame, Reader};
use picket_wire::settings::Settings;
use picket_wire::status::Status;
use picket_wire::telemetry::{Health, Telemetry};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Frames that are sent, and how often each is damaged.
const FRAMES: usize = 40;
const TIMES: usize = 50;

/// Sends the frames of life `number` of this seed.
///
/// # Errors
/// A damaged frame was accepted.
pub fn send(seed: u64, number: u64) -> Result<Tally, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(!seed);
    rng.set_stream(number);
    let mut tally = Tally::default();
    for _ in 0..FRAMES {
        let wire = frame(&mut rng);
        let sent = read(&wire);
        for _ in 0..TIMES {
            let mut bytes = wire.clone();
            damage(&mut bytes, &mut rng);
            if bytes == wire {
                continue;
            }
            tally.damaged += 1;
            // Damage may cut idle bytes off: then the frame is the one that was sent.
            if let Some(frame) = read(&bytes).into_iter().find(|frame| !sent.contains(frame)) {
                return Err(format!("a damaged frame is accepted: {frame:?} of {wire:02x?}"));
            }
        }
    }
    Ok(tally)
}

fn read(bytes: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::default();
    // A zero of its own, should the last one be gone.
    bytes.iter().chain(&[0]).filter_map(|&byte| reader.push(byte)?.ok()).collect()
}

fn frame(rng: &mut impl Rng) -> Vec<u8> {
    match rng.random_range(0..4) {
        0 => {
            let scene = Scene::Doppler {
                wavelength_m: rng.random(),
                angle_rad: rng.random(),
                mixing: picket_dsp::Mixing::RxConjTx,
            };
            let config = Config { rate_hz: rng.random(), scene, ..Settings::default().config };
            let settings = Settings { config, guard: rng.random(), ..Settings::default() };
            let command = Command::SetSettings(settings, 1 << rng.random_range(6..13));
            Request { tag: rng.random(), command }.to_frame().to_vec()
        }
        1 => Request { tag: rng.random(), command: Command::Capture(rng.random()) }
            .to_frame()
            .to_vec(),
        2 => {
            let counters = Counters { blocks: rng.random(), ..Counters::default() };
            Status { counters, load: rng.random(), ..Status::default() }.to_frame().to_vec()
        }
        _ => {
            let mut record = Telemetry {
                measurement: Default::default(),
                method: Default::default(),
                health: Health { lost: rng.random(), faults: rng.random() },
                basis: None,
                uncertainty: None,
            };
            record.measurement.stamp.clock = rng.random();
            record.measurement.tone.sigma = rng.random();
            record.to_frame().to_vec()
        }
    }
}

/// Bits that turn, a burst of noise, bytes that are lost or come twice, a line that stays low.
fn damage(bytes: &mut Vec<u8>, rng: &mut impl Rng) {
    let last = bytes.len() - 1;
    let from = rng.random_range(0..last);
    let to = rng.random_range(from..=last.min(from + 24));
    match rng.random_range(0..6) {
        0 => (0..rng.random_range(1..8)).for_each(|_| {
            bytes[rng.random_range(0..=last)] ^= 1 << rng.random_range(0..8);
        }),
        1 => rng.fill_bytes(&mut bytes[from..=to]),
        2 => drop(bytes.drain(from..=to)),
        3 => bytes.insert(from, rng.random()),
        4 => bytes[from..=to].fill(if rng.random() { 0 } else { 0xFF }),
        _ => {
            let twice = bytes[from..=to].to_vec();
            bytes.splice(from..from, twice);
        }
    }
}
