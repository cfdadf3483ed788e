//! Records over a bad line: what arrives is what was sent, what does not is counted.

use fixed::types::{I0F32, I32F32};
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::candidates::{Ambiguity, Candidate, Candidates};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::doppler::Velocity;
use picket_dsp::solve::uncertainty::Total;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict, Verdicts};
use picket_host::device::{Listener, Said};
use picket_wire::boot::Clock;
use picket_wire::frame::{self, FrameError, Kind, Reader};
use picket_wire::layout::RecordError;
use picket_wire::telemetry::{Basis, Health, Telemetry};
use picket_wire::{cobs, frame::PAYLOAD};
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn fixed(rng: &mut impl Rng) -> I32F32 {
    I32F32::from_bits(rng.random())
}

fn float(rng: &mut impl Rng) -> f32 {
    match rng.random_range(0..8) {
        0 => f32::INFINITY,
        1 => 0.0,
        _ => rng.random::<f32>() * 10f32.powi(rng.random_range(-20..20)),
    }
}

/// A record with any numbers that its verdicts allow.
fn record(sequence: u32, rng: &mut impl Rng) -> Telemetry {
    loop {
        let record = any_record(sequence, rng);
        let Measurement { tone, result, .. } = &record.measurement;
        if tone.is_consistent() && result.is_consistent() {
            return record;
        }
    }
}

#[allow(clippy::needless_update, reason = "a field to come has its default")]
fn any_record(sequence: u32, rng: &mut impl Rng) -> Telemetry {
    let verdict = |rng: &mut _| Verdict::ALL[Rng::next_u32(rng) as usize % Verdict::ALL.len()];
    let result = match rng.random_range(0..5) {
        0 => Outcome::None,
        1 => Outcome::Velocity(Velocity {
            velocity: fixed(rng),
            sigma: float(rng),
            verdict: verdict(rng),
        }),
        other => Outcome::Target(Target {
            range: fixed(rng),
            velocity: rng.random_bool(0.5).then(|| fixed(rng)),
            sigma_range: float(rng),
            sigma_velocity: float(rng),
            ambiguity: match other {
                2 => Ambiguity::None,
                3 => {
                    let count = rng.random_range(1..=4);
                    Ambiguity::Several(Candidates::new((0..count).map(|_| Candidate {
                        range: fixed(rng),
                        velocity: fixed(rng),
                        odds: rng.random(),
                    })))
                }
                _ => Ambiguity::Coupled,
            },
            verdict: verdict(rng),
        }),
    };
    Telemetry {
        measurement: Measurement {
            stamp: Stamp {
                sequence,
                clock: rng.random(),
                segment: Segment::from_u8(rng.random_range(0..4)).unwrap(),
                gap: rng.random(),
            },
            clipped: rng.random(),
            tone: Tone {
                frequency: Frequency(I0F32::from_bits(rng.random())),
                sigma: float(rng),
                snr: float(rng),
                amplitude: float(rng),
                verdict: verdict(rng),
                also: Verdicts::from_bits(rng.random()),
                rate_hz: rng.random(),
                ..Tone::default()
            },
            result,
        },
        method: Method::ALL[rng.random_range(0..Method::ALL.len())],
        health: Health { lost: rng.random(), faults: rng.random() },
        basis: rng.random::<bool>().then(|| Basis {
            settings: rng.random(),
            clock: Clock::from_u8(rng.random_range(0..3)).unwrap(),
            effort: rng.random_range(0..=3),
        }),
        uncertainty: rng.random::<bool>().then(|| Total {
            frequency: rng.random(),
            range: rng.random(),
            velocity: rng.random(),
        }),
    }
}

#[test]
fn records_come_back_bit_for_bit() {
    println!("seed 3");
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let records: Vec<Telemetry> = (0..10_000).map(|sequence| record(sequence, &mut rng)).collect();
    let bytes: Vec<u8> = records.iter().flat_map(|r| r.to_frame()).collect();
    let mut listener = Listener::default();
    assert_eq!(listener.read(&bytes), records.into_iter().map(Said::Telemetry).collect::<Vec<_>>());
    assert_eq!((listener.records, listener.bad, listener.missing), (10_000, 0, 0));
}

#[test]
fn a_float_without_a_value_keeps_its_bits() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut sent = record(0, &mut rng);
    // A record whose frequency may be used has a sigma.
    sent.measurement.tone.verdict = Verdict::Weak;
    sent.measurement.tone.sigma = f32::from_bits(0x7fc0_1234);
    let got = Telemetry::from_bytes(&sent.to_bytes()).unwrap();
    assert_eq!(got.measurement.tone.sigma.to_bits(), 0x7fc0_1234);
}

#[test]
fn holes_and_restarts_in_the_sequence() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut listener = Listener::default();
    for sequence in [7, 8, 11, 12, 0, 1, 3] {
        listener.read(&record(sequence, &mut rng).to_frame());
    }
    assert_eq!((listener.records, listener.missing), (7, 3));
}

/// What a full line leaves out is missing and not lost; what the board has lost is both. A host may set the counts to 0 between.
#[test]
fn blocks_that_are_left_out_are_told_from_lost_ones() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut listener = Listener::default();
    let told = [(0, 5), (1, 5), (4, 5), (8, 7), (9, 7), (12, 1), (20, 100)];
    let expected = [(0, 0), (0, 0), (2, 0), (5, 2), (5, 2), (7, 3), (14, 10)];
    for ((sequence, lost), expected) in told.into_iter().zip(expected) {
        let mut sent = record(sequence, &mut rng);
        sent.health.lost = lost;
        listener.read(&sent.to_frame());
        assert_eq!((listener.missing, listener.lost), expected, "block {sequence}");
    }
}

#[test]
fn a_hundred_thousand_damaged_frames_and_none_accepted() {
    println!("seed 6");
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut accepted = 0;
    for sequence in 0..100_000u32 {
        let sent = record(sequence, &mut rng);
        let mut bytes = sent.to_frame().to_vec();
        let last = bytes.len() - 1;
        match rng.random_range(0..5) {
            // Bits flipped, the closing zero among them.
            0 => {
                for _ in 0..rng.random_range(1..8) {
                    let at = rng.random_range(0..=last);
                    bytes[at] ^= 1 << rng.random_range(0..8);
                }
            }
            // A burst.
            1 => {
                let from = rng.random_range(0..last);
                let to = (from + rng.random_range(1..40)).min(last);
                rng.fill_bytes(&mut bytes[from..to]);
            }
            // Bytes lost, doubled, put in.
            2 => drop(bytes.remove(rng.random_range(0..last))),
            3 => bytes.insert(rng.random_range(0..last), rng.random()),
            _ => bytes.truncate(rng.random_range(1..last)),
        }
        bytes.push(0);
        for got in Listener::default().read(&bytes) {
            // Damage may hit nothing but the closing zero, or undo itself: then the record is whole.
            accepted += u32::from(got != Said::Telemetry(sent));
        }
    }
    assert_eq!(accepted, 0);
}

#[test]
fn noise_between_frames_costs_no_frame() {
    println!("seed 8");
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut listener = Listener::default();
    let mut got = 0;
    for sequence in 0..1000 {
        let mut noise = vec![0u8; rng.random_range(0..600)];
        rng.fill_bytes(&mut noise);
        noise.push(0);
        noise.extend(record(sequence, &mut rng).to_frame());
        got += listener.read(&noise).len();
    }
    assert_eq!((got, listener.missing), (1000, 0));
    assert!(listener.bad > 0);
}

#[test]
fn errors_name_their_cause() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let sent = record(1, &mut rng);
    let frame = |bytes: &[u8]| {
        let mut reader = Reader::default();
        bytes.iter().find_map(|&b| reader.push(b)).unwrap()
    };
    let reply = |bytes: &[u8]| Telemetry::from_frame(&frame(bytes).unwrap()).unwrap_err();
    let mut newer = sent.to_bytes();
    newer[0] = 9;
    let bytes = frame::encode(Kind::Telemetry, &newer).unwrap();
    assert_eq!(reply(&bytes), RecordError::Version(9));
    let bytes = frame::encode(Kind::Telemetry, &sent.to_bytes()[..40]).unwrap();
    assert_eq!(reply(&bytes), RecordError::Field);
    let bytes = frame::encode(Kind::End, &[]).unwrap();
    assert_eq!(reply(&bytes), RecordError::Kind(Kind::End));
    let mut damaged = sent.to_frame();
    damaged[20] ^= 0x80;
    assert!(frame(&damaged).is_err());
    assert_eq!(frame(&[1, 0]), Err(FrameError::Truncated));
    assert_eq!(frame(&[&[7u8; 900][..], &[0]].concat()), Err(FrameError::TooLong));
}

proptest! {
    #[test]
    fn stuffing_has_no_zero_and_comes_back(data in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut wire = heapless::Vec::<u8, 700>::new();
        cobs::encode(&data, &mut wire).unwrap();
        prop_assert!(!wire.contains(&0) && wire.len() <= cobs::encoded_len(data.len()));
        let mut decoder = cobs::Decoder::default();
        let back: Vec<u8> = wire.iter().filter_map(|&byte| decoder.push(byte)).collect();
        prop_assert!(decoder.complete());
        prop_assert_eq!(back, data);
    }

    #[test]
    fn frames_come_back(payload in prop::collection::vec(any::<u8>(), 0..=PAYLOAD)) {
        let mut reader = Reader::default();
        let wire = frame::encode(Kind::Telemetry, &payload).unwrap();
        let read: Vec<_> = wire.iter().filter_map(|&byte| reader.push(byte)).collect();
        prop_assert_eq!(read.len(), 1);
        let frame = read[0].as_ref().unwrap();
        prop_assert_eq!((frame.kind, &frame.payload[..]), (Kind::Telemetry, &payload[..]));
    }
}
