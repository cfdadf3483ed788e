//! An answer as programs show it: in SI units, once for all languages. C has these structures as they are; the columns of Python's arrays,
//! the page's rows and JSON's keys come from [`View::each`]; `lab schema` writes `picket.h` of them.
//!
//! Each field has a width of its own, and no structure has holes: a later field takes the place of `reserved...` or stands at the end.

mod columns;
mod frames;

pub use columns::{Column, columns};

use crate::layout::{Form, Place, Structure};
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::burst::Validation;
use picket_dsp::fixed::types::{I0F32, I32F32};
use picket_dsp::pipeline::Outcome;
use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Decision};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::track::State;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{Frequency, Verdict, Verdicts};

/// A value within a view.
pub trait View: Copy + Default {
    /// Its form.
    const FORM: Form;

    /// The number of numbers that [`View::each`] gives.
    const COUNT: usize;

    /// Calls `put` with the name and the value of each number, in order; not with those of `reserved`.
    fn each(&self, name: &'static str, put: &mut impl FnMut(&'static str, f64));

    /// Sets the number of this name, where the value `own` has it. Whether there is one.
    fn set(&mut self, own: &'static str, name: &str, value: f64) -> bool;
}

macro_rules! numbers {
    ($($number:ident),*) => {
        $(impl View for $number {
            const FORM: Form = Form::Number(stringify!($number));
            const COUNT: usize = 1;

            fn each(&self, name: &'static str, put: &mut impl FnMut(&'static str, f64)) {
                if !is_reserved(name) {
                    put(name, *self as f64);
                }
            }

            fn set(&mut self, own: &'static str, name: &str, value: f64) -> bool {
                let here = own == name && !is_reserved(own);
                if here {
                    // A cast saturates.
                    *self = value as $number;
                }
                here
            }
        })*
    };
}

numbers!(u8, u32, u64, i16, f32, f64);

impl<T: View, const N: usize> View for [T; N]
where
    [T; N]: Default,
{
    const FORM: Form = Form::Array(&T::FORM, N);
    const COUNT: usize = N * T::COUNT;

    fn each(&self, name: &'static str, put: &mut impl FnMut(&'static str, f64)) {
        self.iter().for_each(|value| value.each(name, put));
    }

    fn set(&mut self, _: &'static str, _: &str, _: f64) -> bool {
        false
    }
}

/// Whether a field is there for its width alone.
const fn is_reserved(name: &str) -> bool {
    let (mut name, mut reserved) = (name.as_bytes(), "reserved".as_bytes());
    while let ([a, rest @ ..], [b, others @ ..]) = (name, reserved) {
        if *a != *b {
            return false;
        }
        (name, reserved) = (rest, others);
    }
    reserved.is_empty()
}

macro_rules! views {
    ($($(#[doc = $doc:literal])* $type:ident $name:literal {
        $($(#[doc = $meaning:literal])* $field:ident: $form:ty),* $(,)?
    })*) => {
        $(
            $(#[doc = $doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            #[repr(C)]
            pub struct $type {
                $($(#[doc = $meaning])* pub $field: $form),*
            }

            impl View for $type {
                const FORM: Form = Form::Structure(&Structure {
                    name: $name,
                    doc: concat!($($doc),*),
                    fields: &[$(Place {
                        name: stringify!($field),
                        doc: concat!($($meaning),*),
                        form: <$form as View>::FORM,
                        absent: "",
                    }),*],
                });
                const COUNT: usize = 0 $(+ match is_reserved(stringify!($field)) {
                    true => 0,
                    false => <$form as View>::COUNT,
                })*;

                fn each(&self, _: &'static str, put: &mut impl FnMut(&'static str, f64)) {
                    $(self.$field.each(stringify!($field), put);)*
                }

                fn set(&mut self, _: &'static str, name: &str, value: f64) -> bool {
                    $(self.$field.set(stringify!($field), name, value))||*
                }
            }

            const _: () = assert!(size_of::<$type>() == 0 $(+ size_of::<$form>())*, "no holes");
        )*

        /// Every view, each before those that contain it.
        pub const VIEWS: &[Form] = &[$(<$type as View>::FORM),*];
    };
}

views! {
    /// One measured tone.
    Tone "picket_tone" {
        /// I/Q: minus to plus half the rate; real: 0 to half the rate
        frequency_hz: f64,
        /// one standard deviation of it
        sigma_hz: f64,
        /// signal-to-noise ratio per sample, a power ratio: 10 log10 of it is dB
        snr: f32,
        /// ADC codes
        amplitude: f32,
        /// samples of the block that touch a rail
        clipped: u32,
        /// the most severe that applies
        verdict: u8,
        /// the others: picket_verdict_is_among
        also: u8,
        /// 0
        reserved: [u8; 2],
    }

    /// One of a block's tones, with its phase.
    Line "picket_line" {
        /// the tone
        tone: Tone,
        /// at sample N/2: amplitude * cos(phase + 2 pi f (n - N/2) / rate)
        phase_rad: f32,
        /// one standard deviation of it
        sigma_phase_rad: f32,
    }

    /// A target that fits the beats of a chirp as others do.
    Candidate "picket_candidate" {
        /// range
        range_m: f64,
        /// positive when approaching
        velocity_mps: f64,
        /// its probability, 0 to 1
        odds: f64,
    }

    /// A range and a velocity; of a Doppler shift a velocity alone.
    Target "picket_target" {
        /// range
        range_m: f64,
        /// positive when approaching; of real samples the speed; NaN if it is not known
        velocity_mps: f64,
        /// the most probable first, if `ambiguity` is PICKET_SEVERAL
        candidates: [Candidate; CANDIDATES],
        /// one standard deviation of the range
        sigma_range_m: f32,
        /// one standard deviation of the velocity
        sigma_velocity_mps: f32,
        /// low bits of the number of the track it comes from; 0 without a tracker
        track: u32,
        /// the most severe that applies
        verdict: u8,
        /// PICKET_UNIQUE, PICKET_SEVERAL, PICKET_COUPLED or what decided
        ambiguity: u8,
        /// of the candidates
        count: u8,
        /// 0
        reserved: u8,
    }

    /// A tone, and what it amounts to.
    Measurement "picket_measurement" {
        /// the strongest tone of the block
        tone: Tone,
        /// what it amounts to
        target: Target,
        /// PICKET_OUTCOME_...: what of `target` holds
        outcome: u8,
        /// 0
        reserved: [u8; 7],
    }

    /// A tone that is followed from block to block.
    Track "picket_track" {
        /// as filtered; `clipped` is 0
        tone: Tone,
        /// rate of its frequency
        rate_hz_per_block: f32,
        /// its number, which no other track gets
        number: u32,
        /// blocks since it was first seen
        age: u32,
        /// PICKET_TENTATIVE, PICKET_HELD or PICKET_LOST
        state: u8,
        /// blocks since it was last seen
        misses: u8,
        /// 0
        reserved: [u8; 2],
    }

    /// What a sum of blocks shows.
    Accumulated "picket_accumulated" {
        /// `clipped` is 0
        tone: Tone,
        /// natural logarithm of the probability that noise alone has such a line
        ln_chance: f32,
        /// blocks of the sum
        blocks: u32,
    }

    /// A burst: a tone with an envelope, as of a particle that crosses a beam.
    Burst "picket_burst" {
        /// amplitude and snr at the envelope's top; `clipped` is 0
        tone: Tone,
        /// the middle of the envelope, samples since the stream's first
        arrival: f64,
        /// standard deviation of the Gaussian envelope, samples
        deviation: f32,
        /// PICKET_VALID, or what is known against it
        validation: u8,
        /// 0
        reserved: [u8; 3],
    }

    /// What was counted in a stream of bursts.
    Counts "picket_counts" {
        /// taken
        samples: u64,
        /// in which no burst could begin
        dead: u64,
        /// that a record was cut around, noise that looked like one included
        bursts: u32,
        /// that ended while the record of another was not complete
        lost: u32,
        /// signals too long for a burst
        longer: u32,
        /// 0
        reserved: u32,
    }

    /// A target of a frame of chirps.
    FrameTarget "picket_frame_target" {
        /// in the middle of the frame; its candidates are aliases of the velocity
        target: Target,
        /// its beat in the middle of the frame, as picket_range_by_phase takes it; its verdict is without the aliases
        line: Line,
        /// covariance of range and velocity, m^2/s
        covariance: f32,
        /// natural logarithm of the probability that noise alone shows such a target
        ln_chance: f32,
    }

    /// A range that agrees with a phase.
    RangeCandidate "picket_range_candidate" {
        /// range
        range_m: f64,
        /// its probability, 0 to 1
        odds: f64,
    }

    /// A range by phase, or by frequency where the phase does not decide.
    PhaseRange "picket_phase_range" {
        /// by the phase if `sure`, else by the frequency
        range_m: f64,
        /// positive when approaching; NaN if it is not known
        velocity_mps: f64,
        /// the range by the frequency alone
        by_frequency_m: f64,
        /// ranges that agree with the phase, the most probable first
        candidates: [RangeCandidate; CANDIDATES],
        /// one standard deviation of the range by the noise
        sigma_range_m: f32,
        /// one standard deviation of the range by the noise and the calibration
        uncertainty_range_m: f32,
        /// one standard deviation of the velocity
        sigma_velocity_mps: f32,
        /// one standard deviation of the range by the frequency alone
        sigma_by_frequency_m: f32,
        /// one standard deviation of each candidate by the noise
        sigma_by_phase_m: f32,
        /// from one candidate to the next: half a wavelength
        spacing_m: f32,
        /// of the most probable candidate against all others together; sure from 10,000 on
        turn_odds: f32,
        /// 1 if the range is the one by the phase
        sure: u8,
        /// the most severe that applies
        verdict: u8,
        /// of the candidates
        count: u8,
        /// 0
        reserved: u8,
    }

    /// The way of a target by the phase of its tone.
    Displacement "picket_displacement" {
        /// since the start; positive when the target went away
        displacement_m: f64,
        /// one standard deviation of it
        sigma_displacement_m: f32,
        /// the start from which it counts: displacements of different starts do not belong together
        start: u32,
        /// of the tone; unresolved where the whole turns are not sure
        verdict: u8,
        /// 0
        reserved: [u8; 7],
    }

    /// One source's part of an error, as a standard deviation of the answer.
    Part "picket_part" {
        /// of the range
        range_m: f32,
        /// of the velocity
        velocity_mps: f32,
    }

    /// The parts of an answer's error, and all of it: one standard deviation by the law of JCGM 100.
    Budget "picket_budget" {
        /// all parts together
        uncertainty: Part,
        /// of the block's noise; a mean over blocks lessens this one alone
        noise: Part,
        /// of the sample clock
        clock: Part,
        /// of the carrier
        carrier: Part,
        /// of the sweep's slope
        slope: Part,
        /// of the angle between beam and motion
        angle: Part,
        /// of the range's offset
        range_offset: Part,
        /// of the phase of a target at 0 m
        phase: Part,
    }

    /// What a user sets. Zeros are the library's own choice, except for the rate and the codes.
    Config "picket_config" {
        /// samples per second
        rate_hz: f64,
        /// the band searched; both 0: the whole spectrum
        band_low_hz: f64,
        /// the band searched; both 0: the whole spectrum
        band_high_hz: f64,
        /// probability that a block of noise passes for a tone
        false_alarm: f64,
        /// the converter's rails: 0 and 4095 for 12 bits
        low_code: i16,
        /// the converter's rails: 0 and 4095 for 12 bits
        high_code: i16,
        /// PICKET_ARITHMETIC_...
        arithmetic: u8,
        /// bins on each side that the fit reads: 4, 8, 16; 0 is 16
        reach: u8,
        /// 0
        reserved: [u8; 2],
    }

    /// What the samples were taken of.
    Scene "picket_scene" {
        /// Doppler and chirp
        wavelength_m: f64,
        /// Doppler: between beam and motion
        angle_rad: f64,
        /// chirp: how far a ramp rises
        bandwidth_hz: f64,
        /// chirp: of each segment
        duration_s: f64,
        /// chirp: from a segment's start to its first sample
        guard_s: f64,
        /// chirp: 0 for straight ramps
        sweep_curvature: f64,
        /// chirp: what a target may have; both 0: not known
        range_low_m: f64,
        /// chirp: what a target may have; both 0: not known
        range_high_m: f64,
        /// chirp: likewise; positive when approaching
        velocity_low_mps: f64,
        /// chirp: likewise; positive when approaching
        velocity_high_mps: f64,
        /// PICKET_SCENE_...
        kind: u8,
        /// chirp: PICKET_TRAPEZOID, PICKET_TRIANGLE or PICKET_SAWTOOTH
        shape: u8,
        /// I/Q: PICKET_TX_CONJ_RX or PICKET_RX_CONJ_TX
        mixing: u8,
        /// 0
        reserved: [u8; 5],
    }

    /// How tones are followed.
    Following "picket_following" {
        /// sigma of a new target's rate, bins per block; 0 is 2
        rate_bins: f32,
        /// tones followed at once, 1 to 4; 0 is 1
        most: u8,
        /// one block in `refresh` is searched whole while one tone is locked; 0 searches all
        refresh: u8,
        /// 0
        reserved: [u8; 2],
    }

    /// What an accumulator adds: the spectra of many blocks without their phases, for echoes too weak for one.
    Accumulating "picket_accumulating" {
        /// probability for each sum that noise passes for a tone; 0 is 1e-6
        false_alarm: f64,
        /// bins by which the line moves from block to block
        drift_bins: f32,
        /// of a sum: 1 to 65,536
        blocks: u32,
        /// of a chirp, whose other blocks are passed over; PICKET_CONTINUOUS adds all
        segment: u8,
        /// 0
        reserved: [u8; 7],
    }

    /// When a burst begins and ends. Zeros are the library's own choice.
    Trigger "picket_trigger" {
        /// energy of an eighth of a record over that of the noise at which it begins; 0: by the noise's scatter
        ratio: f32,
        /// samples after a record in which no burst begins
        hold_off: u32,
        /// the least energy per sample, squared codes, however quiet the noise is
        least: u32,
        /// 0
        reserved: u32,
    }

    /// A frame of sawtooth chirps.
    Framing "picket_framing" {
        /// from one chirp to the next, s
        period_s: f64,
        /// probability for each frame that noise alone shows a target; 0 is 1e-6
        false_alarm: f64,
        /// 8, 16, ... 256
        chirps: u32,
        /// the bins that are kept of each chirp; both 0: all that have a range
        first_bin: i16,
        /// the bins that are kept of each chirp; both 0: all that have a range
        last_bin: i16,
    }

    /// What a measurement at a known distance tells of a sensor. Zeros are a perfect sensor.
    Calibration "picket_calibration" {
        /// the phase of a target at 0 m on the rising ramp
        phase_rad: f32,
        /// one standard deviation of it
        sigma_phase_rad: f32,
        /// what the frequency shows of a target at 0 m
        offset_m: f32,
        /// one standard deviation of it
        sigma_offset_m: f32,
        /// the sweep's true slope over the stated one less 1, parts per million
        slope_ppm: f32,
        /// one standard deviation of it
        sigma_slope_ppm: f32,
    }

    /// What is not known of a sensor, each as one standard deviation. Zeros are known.
    Uncertainty "picket_uncertainty" {
        /// of the sample clock, parts per million
        clock_ppm: f32,
        /// of the carrier, parts per million
        carrier_ppm: f32,
        /// of the sweep's slope, parts per million
        slope_ppm: f32,
        /// of the angle between beam and motion
        angle_rad: f32,
        /// of the range's offset
        range_offset_m: f32,
        /// of the phase of a target at 0 m: for ranges by phase
        phase_rad: f32,
    }

    /// Where and when a block was taken.
    Stamp "picket_stamp" {
        /// samples since the start
        clock: u64,
        /// the block's number; lost blocks count
        sequence: u32,
        /// PICKET_CONTINUOUS, PICKET_UP, PICKET_FLAT or PICKET_DOWN
        segment: u8,
        /// 1 if samples are missing before this block
        gap: u8,
        /// 0
        reserved: [u8; 2],
    }
}

/// A constant of C.
#[derive(Clone, Copy, Debug)]
pub struct Constant<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its value.
    pub value: u8,
    /// What it says; empty where the name does.
    pub doc: &'static str,
}

/// The constants of C that stand beside a structure: the structure's name, and the constants.
pub const CONSTANTS: &[(&str, &[Constant<'static>])] = &[
    (
        "picket_candidate",
        &[Constant { name: "PICKET_CANDIDATES", value: CANDIDATES as u8, doc: "" }],
    ),
    (
        "picket_target",
        &[
            Constant { name: "PICKET_UNIQUE", value: Ambiguity::None.number(), doc: "" },
            Constant {
                name: "PICKET_SEVERAL",
                value: 1,
                doc: "the beats fit several targets: the verdict is PICKET_AMBIGUOUS",
            },
            Constant {
                name: "PICKET_COUPLED",
                value: Ambiguity::Coupled.number(),
                doc: "a sawtooth: the range of a target at rest, and no velocity",
            },
            Constant {
                name: "PICKET_BY_BOUND",
                value: Ambiguity::Decided(Decision::Bound).number(),
                doc: "the bounds of range and velocity decided",
            },
            Constant {
                name: "PICKET_BY_LAST_CHIRP",
                value: Ambiguity::Decided(Decision::LastChirp).number(),
                doc: "the chirp before decided",
            },
            Constant {
                name: "PICKET_BY_LEVELS",
                value: Ambiguity::Decided(Decision::Levels).number(),
                doc: "the levels of the lines decided",
            },
        ],
    ),
    (
        "picket_measurement",
        &[
            Constant {
                name: "PICKET_OUTCOME_NONE",
                value: 0,
                doc: "a tone; or the chirp is incomplete",
            },
            Constant {
                name: "PICKET_OUTCOME_VELOCITY",
                value: 1,
                doc: "velocity_mps, sigma_velocity_mps, verdict",
            },
            Constant { name: "PICKET_OUTCOME_TARGET", value: 2, doc: "all of it" },
        ],
    ),
    (
        "picket_track",
        &[
            Constant { name: "PICKET_TENTATIVE", value: State::Tentative as u8, doc: "" },
            Constant { name: "PICKET_HELD", value: State::Held as u8, doc: "" },
            Constant { name: "PICKET_LOST", value: State::Lost as u8, doc: "" },
        ],
    ),
    (
        "picket_config",
        &[
            Constant {
                name: "PICKET_ARITHMETIC_OF_CORE",
                value: 0,
                doc: "integers without a floating-point unit, floats with one",
            },
            Constant {
                name: "PICKET_ARITHMETIC_FLOAT",
                value: 1,
                doc: "not on a core without a floating-point unit",
            },
            Constant {
                name: "PICKET_ARITHMETIC_FIXED",
                value: 2,
                doc: "not on a core with one, but on a desk",
            },
        ],
    ),
    (
        "picket_scene",
        &[
            Constant { name: "PICKET_SCENE_TONE", value: 0, doc: "" },
            Constant { name: "PICKET_SCENE_DOPPLER", value: 1, doc: "" },
            Constant { name: "PICKET_SCENE_CHIRP", value: 2, doc: "" },
        ],
    ),
    (
        "picket_scene",
        &[
            Constant { name: "PICKET_TRAPEZOID", value: Shape::Trapezoid as u8, doc: "" },
            Constant { name: "PICKET_TRIANGLE", value: Shape::Triangle as u8, doc: "" },
            Constant { name: "PICKET_SAWTOOTH", value: Shape::Sawtooth as u8, doc: "" },
        ],
    ),
    (
        "picket_scene",
        &[
            Constant {
                name: "PICKET_TX_CONJ_RX",
                value: Mixing::TxConjRx as u8,
                doc: "an approaching target's Doppler shift is negative",
            },
            Constant {
                name: "PICKET_RX_CONJ_TX",
                value: Mixing::RxConjTx as u8,
                doc: "it is positive",
            },
        ],
    ),
    (
        "picket_burst",
        &[
            Constant {
                name: "PICKET_VALID",
                value: Validation::Valid as u8,
                doc: "one particle; its tone is good",
            },
            Constant {
                name: "PICKET_TWO_PARTICLES",
                value: Validation::TwoParticles as u8,
                doc: "more than one at once",
            },
            Constant {
                name: "PICKET_FEW_CYCLES",
                value: Validation::FewCycles as u8,
                doc: "fewer than four between the points at which the power is down by exp(-2)",
            },
            Constant {
                name: "PICKET_SHORT",
                value: Validation::Short as u8,
                doc: "shorter than a thirtieth of a record: take shorter records, or a higher rate",
            },
            Constant {
                name: "PICKET_LONG",
                value: Validation::Long as u8,
                doc: "longer than two fifths of a record: take longer records",
            },
            Constant {
                name: "PICKET_BURST_WEAK",
                value: Validation::Weak as u8,
                doc: "noise, or a particle outside of the fringes",
            },
            Constant {
                name: "PICKET_BURST_CLIPPED",
                value: Validation::Clipped as u8,
                doc: "more than 1 % of its samples touch a rail",
            },
        ],
    ),
    (
        "picket_stamp",
        &[
            Constant { name: "PICKET_CONTINUOUS", value: Segment::Continuous as u8, doc: "" },
            Constant { name: "PICKET_UP", value: Segment::Up as u8, doc: "" },
            Constant { name: "PICKET_FLAT", value: Segment::Flat as u8, doc: "" },
            Constant { name: "PICKET_DOWN", value: Segment::Down as u8, doc: "" },
        ],
    ),
];

/// The numbers of a tone that a program shows in a form of its own: in bins or dB, by a name or elsewhere.
const FORMED: [&str; 7] =
    ["frequency_hz", "sigma_hz", "snr", "amplitude", "clipped", "verdict", "also"];

impl Tone {
    /// The number of numbers that [`Tone::further`] gives.
    pub const FURTHER: usize = Self::COUNT - FORMED.len();

    /// Calls `put` with the name and the value of each number that every program shows as it is here.
    pub fn further(&self, put: &mut impl FnMut(&'static str, f64)) {
        self.each("", &mut |name, value| {
            if !FORMED.contains(&name) {
                put(name, value);
            }
        });
    }

    /// A tone of a block in which `clipped` samples touch a rail.
    pub fn from_tone(tone: &picket_dsp::Tone, clipped: u32) -> Self {
        Self {
            frequency_hz: tone.hertz(),
            sigma_hz: tone.sigma_hertz(),
            snr: tone.snr,
            amplitude: tone.amplitude,
            clipped,
            verdict: tone.verdict as u8,
            also: tone.also.bits(),
            reserved: [0; 2],
        }
    }

    /// The tone that this view was made of, at its sample rate; `None` for an unknown verdict, a rate that is not positive, or a frequency beyond it.
    pub fn told(&self, rate_hz: f64) -> Option<picket_dsp::Tone> {
        let cycles = self.frequency_hz / rate_hz;
        if !(rate_hz > 0.0 && (-0.5..=0.5).contains(&cycles) && self.sigma_hz >= 0.0) {
            return None;
        }
        let steps = cycles * 4_294_967_296.0;
        let nearest = if steps < 0.0 { steps - 0.5 } else { steps + 0.5 };
        Some(picket_dsp::Tone {
            // Half the rate wraps, as on the circle.
            frequency: Frequency(I0F32::from_bits(nearest as i64 as i32)),
            sigma: (self.sigma_hz / rate_hz) as f32,
            snr: self.snr,
            amplitude: self.amplitude,
            verdict: Verdict::from_u8(self.verdict)?,
            also: Verdicts::from_bits(self.also),
            rate_hz,
        })
    }
}

impl Line {
    /// A tone with its phase.
    pub fn from_phasor(phasor: &ToneWithPhase, clipped: u32) -> Self {
        Self {
            tone: Tone::from_tone(&phasor.tone, clipped),
            phase_rad: phasor.phase,
            sigma_phase_rad: phasor.sigma_phase,
        }
    }
}

impl Target {
    /// A target whose rising beat is followed by the track of this number.
    pub fn from_target(target: &picket_dsp::Target, track: u32) -> Self {
        let mut candidates = [Candidate::default(); CANDIDATES];
        let all = target.ambiguity.candidates();
        for (candidate, found) in candidates.iter_mut().zip(all) {
            *candidate = Candidate {
                range_m: found.range.to_num(),
                velocity_mps: found.velocity.to_num(),
                odds: found.odds.into(),
            };
        }
        Self {
            range_m: target.range.to_num(),
            velocity_mps: target.velocity.map_or(f64::NAN, I32F32::to_num),
            candidates,
            sigma_range_m: target.sigma_range,
            sigma_velocity_mps: target.sigma_velocity,
            track,
            verdict: target.verdict as u8,
            ambiguity: target.ambiguity.number(),
            count: all.len() as u8,
            reserved: 0,
        }
    }
}

impl Measurement {
    /// A block's measurement.
    pub fn from_measurement(measurement: &picket_dsp::Measurement) -> Self {
        let (outcome, target) = match &measurement.result {
            Outcome::None => (0, Target::default()),
            Outcome::Velocity(velocity) => {
                let target = picket_dsp::Target {
                    velocity: Some(velocity.velocity),
                    sigma_velocity: velocity.sigma,
                    verdict: velocity.verdict,
                    ..picket_dsp::Target::default()
                };
                (1, Target::from_target(&target, 0))
            }
            Outcome::Target(target) => (2, Target::from_target(target, 0)),
        };
        Self {
            tone: Tone::from_tone(&measurement.tone, measurement.clipped),
            target,
            outcome,
            reserved: [0; 7],
        }
    }
}

impl Track {
    /// A track at this sample rate.
    pub fn from_track(track: &picket_dsp::solve::track::Track, rate_hz: f64) -> Self {
        let tone = picket_dsp::Tone { rate_hz, ..track.tone };
        Self {
            tone: Tone::from_tone(&tone, 0),
            rate_hz_per_block: (f64::from(track.rate()) * rate_hz) as f32,
            number: track.number,
            age: track.age,
            state: track.state as u8,
            misses: track.misses,
            reserved: [0; 2],
        }
    }
}

impl Accumulated {
    /// What a sum shows.
    pub fn from_sum(sum: &picket_dsp::Accumulated) -> Self {
        Self { tone: Tone::from_tone(&sum.tone, 0), ln_chance: sum.ln_chance, blocks: sum.blocks }
    }
}

impl Burst {
    /// A burst.
    pub fn from_burst(burst: &picket_dsp::Burst) -> Self {
        Self {
            tone: Tone::from_tone(&burst.tone, 0),
            arrival: burst.arrival,
            deviation: burst.deviation,
            validation: burst.validation as u8,
            reserved: [0; 3],
        }
    }
}

impl Counts {
    /// The counts of a detector.
    pub fn from_counters(counters: &Counters) -> Self {
        let Counters { samples, bursts, lost, long, dead } = *counters;
        Self { samples, dead, bursts, lost, longer: long, reserved: 0 }
    }
}
