//! The library's answers on the wire.

use crate::layout::{as_number, choice, layout, named};
use fixed::types::I32F32;
use heapless::Vec;
use picket_dsp::acquire::burst::Counters as BurstCounters;
use picket_dsp::acquire::frontend::Counters;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::burst::{Burst, Validation};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::doppler::Velocity;
use picket_dsp::solve::track::State;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::tone::{Tone, Verdict, Verdicts};

named! {
    Verdict: "verdict", |verdict| *verdict as u8, Verdict::from_u8, |verdict| verdict.name();
    Segment: "segment", |segment| *segment as u8, Segment::from_u8, |segment| match segment {
        Segment::Continuous => "none",
        Segment::Up => "up",
        Segment::Flat => "flat",
        Segment::Down => "down",
    };
    State: "state", |state| *state as u8, State::from_u8, |state| state.name();
    Validation: "validation", |validation| *validation as u8,
        |number| Validation::ALL.get(usize::from(number)).copied(), |validation| validation.name();
    Method: "method", |method| method.id(), Method::from_u8, |method| method.name();
}

as_number! {
    Verdicts as u8, |verdicts| verdicts.bits(), |bits| Some(Verdicts::from_bits(bits));
}

/// An ambiguity: its number, and the candidates that there are if they are several.
struct Told {
    number: Deciding,
    candidates: Vec<Candidate, CANDIDATES>,
}

/// The number of an ambiguity.
struct Deciding(u8);

named! {
    Deciding: "ambiguity", |deciding| deciding.0,
        |number| Ambiguity::from_number(number, Candidates::default()).map(|_| Deciding(number)),
        |deciding| Ambiguity::from_number(deciding.0, Candidates::default()).map_or("", |ambiguity| ambiguity.name());
}

impl crate::layout::Field for Ambiguity {
    const FORM: crate::layout::Form = Told::FORM;
    const MOST: usize = Told::MOST;

    fn put(&self, writer: &mut crate::layout::Writer<'_>) {
        let candidates = Vec::from_slice(self.candidates()).unwrap_or_default();
        Told { number: Deciding(self.number()), candidates }.put(writer);
    }

    fn take(reader: &mut crate::layout::Reader<'_>) -> Option<Self> {
        let Told { number, candidates } = Told::take(reader)?;
        let odds = candidates.iter().all(|candidate| (0.0..=1.0).contains(&candidate.odds));
        let candidates = Candidates::new(candidates);
        Ambiguity::from_number(number.0, candidates).filter(|_| odds)
    }
}

layout! {
    /// Where and when a block was taken.
    Stamp {
        /// Number of the block, modulo 2^32; lost blocks count.
        sequence: u32,
        /// Samples since the start, at the block's first.
        clock: u64,
        /// Segment of the chirp.
        segment: Segment,
        /// Samples are missing before this block.
        gap: bool,
    }

    /// A tone.
    Tone {
        /// Frequency, 2^-32 cycles per sample: times the sample rate it is in hertz.
        frequency: Frequency,
        /// Sigma of the frequency, cycles per sample.
        sigma: f32,
        /// Signal-to-noise ratio per sample, a ratio of powers.
        snr: f32,
        /// Amplitude, codes.
        amplitude: f32,
        /// Whether the frequency may be used.
        verdict: Verdict,
        /// What applies besides, from bit 0 on: moving, near-edge, clipped, unresolved, image, gap, weak.
        also: Verdicts,
        /// Sample rate, Hz; 0 where another record of the same block has it.
        rate_hz: f64,
    }

    /// A tone with its phase.
    ToneWithPhase {
        /// The tone.
        tone: Tone,
        /// Phase at sample n/2 of the block, radians, -pi to pi.
        phase: f32,
        /// Sigma of the phase, radians.
        sigma_phase: f32,
    }

    /// The fundamental of a block's harmonics. Its tone's signal-to-noise ratio is of all lines together, its amplitude of the first
    /// order, 0 if that is not seen.
    Harmonic {
        /// The fundamental.
        tone: Tone,
        /// Orders that were seen: bit 0 is the fundamental itself, bit 1 twice its frequency.
        orders: u32,
    }

    /// A velocity.
    Velocity {
        /// Velocity, 2^-32 m/s, positive when approaching.
        velocity: I32F32,
        /// Sigma of the velocity, m/s.
        sigma: f32,
        /// Whether the velocity may be used.
        verdict: Verdict,
    }

    /// A target.
    Target {
        /// Range, 2^-32 m; a negative one says that I and Q are exchanged, or that `mixing` is the other one.
        range: I32F32,
        /// Velocity, 2^-32 m/s, positive when approaching; none where it is not known.
        velocity: Option<I32F32>,
        /// Sigma of the range, m.
        sigma_range: f32,
        /// Sigma of the velocity, m/s.
        sigma_velocity: f32,
        /// The ambiguity that waveform and lines leave.
        ambiguity: Ambiguity,
        /// Whether the target may be used.
        verdict: Verdict,
    }

    /// The ambiguity of a target.
    Told {
        /// Several: several targets fit. Coupled: a sawtooth couples range and velocity. The others say what decided.
        number: Deciding,
        /// The targets that fit, the most probable first, if they are several.
        candidates: Vec<Candidate, CANDIDATES>,
    }

    /// A target that fits as others do.
    Candidate {
        /// Range, 2^-32 m.
        range: I32F32,
        /// Velocity, 2^-32 m/s.
        velocity: I32F32,
        /// Probability, 0 to 1.
        odds: f32,
    }

    /// A block's measurement.
    Measurement {
        /// The block.
        stamp: Stamp,
        /// Samples that touch a rail.
        clipped: u32,
        /// The strongest tone.
        tone: Tone,
        /// What the tone amounts to.
        result: Outcome,
    }

    /// A burst. Amplitude and signal-to-noise ratio of its tone are those at the envelope's top.
    Burst {
        /// The tone.
        tone: Tone,
        /// The middle of the envelope, samples since the start.
        arrival: f64,
        /// Standard deviation of the envelope, samples.
        deviation: f32,
        /// What is known against the burst.
        validation: Validation,
    }

    /// What the detector of bursts counted since the start.
    BurstCounters {
        /// Samples taken.
        samples: u64,
        /// Bursts cut.
        bursts: u32,
        /// Bursts lost while the samples of another were not complete.
        lost: u32,
        /// Signals that were too long for a burst.
        long: u32,
        /// Samples in which no burst could begin.
        dead: u64,
    }

    /// What the front end counted since the start, or since an order set the counters to 0.
    Counters {
        /// Blocks delivered.
        blocks: u32,
        /// Blocks dropped because the main loop held every spare slot.
        overruns: u32,
        /// Blocks dropped because their interrupt was lost.
        missed: u32,
        /// Blocks dropped because their interrupt came while the slot was being filled again.
        late: u32,
        /// Blocks dropped for a DMA error or an ADC overrun, and blocks that passed during the restart.
        broken: u32,
        /// Interrupts without a new block.
        spurious: u32,
        /// Transfers that failed.
        dma_errors: u32,
        /// The number of times that the converter overran.
        adc_overruns: u32,
    }
}

choice! {
    Outcome { 0 None {}, 1 Velocity(velocity: Velocity), 2 Target(target: Target) }
}
