//! Telemetry: a measurement as bytes, little-endian, versioned, the same on every machine.
//!
//! | offset | field |
//! |---|---|
//! | 0 | version: u8 |
//! | 1 | segment: u8 |
//! | 2 | flags: u8, bit 0 a gap before; bits 1 to 7 what else applies: moving, near-edge, clipped, unresolved, image, gap, weak |
//! | 3 | verdict of the tone: u8 |
//! | 4 | sequence: u32 |
//! | 8 | sample clock: u64 |
//! | 16 | clipped samples: u32 |
//! | 20 | frequency: i32, 2^-32 cycles per sample |
//! | 24 | sigma of the frequency: f32, cycles per sample |
//! | 28 | signal-to-noise ratio: f32, a power ratio |
//! | 32 | amplitude: f32, codes |
//! | 36 | blocks lost since the start: u32 |
//! | 40 | faults of the converter's chain since the start: u32 |
//! | 44 | outcome: u8, 0 none, 1 velocity, 2 target |
//! | 45 | verdict of the outcome: u8 |
//! | 46 | ambiguity: u8, 0 none, 1 several targets fit, 2 coupled; decided by 3 a bound, 4 the last chirp, 5 the levels |
//! | 47 | method: u8 |
//! | 48 | range: i64, 2^-32 m |
//! | 56 | velocity: i64, 2^-32 m/s; -2^63 where it is not known |
//! | 64 | sigma of the range: f32, m |
//! | 68 | sigma of the velocity: f32, m/s |
//! | 72 | range of the second candidate: i64 |
//! | 80 | velocity of the second candidate: i64 |
//! | 88 | sample rate: f64, Hz |
//! | 96 | CRC-32 of the settings in use, as the boot record has it: u32 |
//! | 100 | source of the clock: u8, as the boot record has it |
//! | 101 | effort of the measurement: u8, its number, 0 for the usual one |
//! | 102 | number of candidates: u8, 0 unless several targets fit, at most 4 |
//! | 103 | flags: u8, bit 0 bytes 96 to 101 tell nothing |
//! | 104 | the candidates, each a range: i64, a velocity: i64, and its odds: f32 |
//!
//! Layouts of the same version may append fields. Earlier programs end at byte 96, and so does a record that tells nothing of settings,
//! clock and candidates. Earlier programs have the first two candidates alone, without their odds. Readers ignore what follows the bytes that they know.

use super::frame::{self, Frame, Kind};
use crate::boot::Clock;
use crate::bytes::{Reader, Writer};
use fixed::types::{I0F32, I32F32};
use heapless::Vec;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::methods::registry::Method;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::candidates::{Ambiguity, CANDIDATES, Candidate, Candidates};
use picket_dsp::solve::chirp::Target;
use picket_dsp::solve::doppler::Velocity;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::{Tone, Verdict, Verdicts};

/// The version of the layout.
pub const VERSION: u8 = 2;

/// Length of the fields that every record has, bytes.
pub const LENGTH: usize = 96;

/// Length of a record without candidates, bytes.
pub const LONG: usize = LENGTH + 8;

/// Length of the longest record, bytes.
pub const LONGEST: usize = LONG + 20 * CANDIDATES;

/// By what a record was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Basis {
    /// CRC-32 of the settings in use, as in the boot record.
    pub settings: u32,
    /// The source of the sample clock.
    pub clock: Clock,
    /// The effort of the measurement: its number, see [`Effort::from_number`](picket_dsp::Effort::from_number).
    pub effort: u8,
}

/// What the front end lost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// Blocks that were filled and not delivered.
    pub lost: u32,
    /// Spurious interrupts, failed transfers and converter overruns.
    pub faults: u32,
}

/// A measurement, and the state of the instrument that made it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Telemetry {
    /// The measurement.
    pub measurement: Measurement,
    /// The method of estimation.
    pub method: Method,
    /// What was lost so far.
    pub health: Health,
    /// By what it was measured; earlier programs do not tell.
    pub basis: Option<Basis>,
}

/// Why a frame holds no telemetry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TelemetryError {
    /// The frame is of another kind.
    Kind(Kind),
    /// The payload is of another version.
    Version(u8),
    /// The payload is shorter than [`LENGTH`].
    Short,
    /// A field holds an unknown number, or one that its verdict forbids.
    Field,
}

impl core::fmt::Display for TelemetryError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TelemetryError::Kind(_) => f.write_str("the frame carries no record"),
            TelemetryError::Version(version) => {
                write!(f, "the record is of version {version}, this reader knows {VERSION}")
            }
            TelemetryError::Short => f.write_str("the record is too short"),
            TelemetryError::Field => f.write_str("a field of the record has no meaning"),
        }
    }
}

impl core::error::Error for TelemetryError {}

/// The outcome, as the layout's fields.
#[derive(Default)]
struct Flat {
    outcome: u8,
    verdict: u8,
    ambiguity: u8,
    range: i64,
    velocity: i64,
    sigma_range: f32,
    sigma_velocity: f32,
    other_range: i64,
    other_velocity: i64,
    candidates: Candidates,
}

/// The velocity that is not known.
pub(crate) const UNKNOWN: i64 = i64::MIN;

/// A velocity; `None` where it is not known.
pub(crate) fn known(velocity: i64) -> Option<I32F32> {
    (velocity != UNKNOWN).then_some(I32F32::from_bits(velocity))
}

impl Flat {
    fn of(outcome: &Outcome) -> Self {
        match outcome {
            Outcome::None => Self::default(),
            Outcome::Velocity(v) => Self {
                outcome: 1,
                verdict: v.verdict as u8,
                velocity: v.velocity.to_bits(),
                sigma_velocity: v.sigma,
                ..Self::default()
            },
            Outcome::Target(t) => {
                let candidates = t.ambiguity.candidates();
                let other = candidates.get(1).copied().unwrap_or_default();
                Self {
                    outcome: 2,
                    verdict: t.verdict as u8,
                    ambiguity: t.ambiguity.number(),
                    range: t.range.to_bits(),
                    velocity: t.velocity.map_or(UNKNOWN, I32F32::to_bits),
                    sigma_range: t.sigma_range,
                    sigma_velocity: t.sigma_velocity,
                    other_range: other.range.to_bits(),
                    other_velocity: other.velocity.to_bits(),
                    candidates: Candidates::new(candidates.iter().copied()),
                }
            }
        }
    }

    /// The candidates that earlier programs tell: two of equal odds.
    fn first_two(&self) -> Candidates {
        if self.ambiguity != 1 {
            return Candidates::default();
        }
        let of = |range, velocity| Candidate {
            range: I32F32::from_bits(range),
            velocity: I32F32::from_bits(velocity),
            odds: 0.5,
        };
        let first = of(self.range, self.velocity);
        Candidates::new([first, of(self.other_range, self.other_velocity)])
    }

    fn outcome(self) -> Option<Outcome> {
        let velocity = I32F32::from_bits(self.velocity);
        let verdict = Verdict::from_u8(self.verdict)?;
        Some(match self.outcome {
            0 => Outcome::None,
            1 => Outcome::Velocity(Velocity { velocity, sigma: self.sigma_velocity, verdict }),
            2 => Outcome::Target(Target {
                range: I32F32::from_bits(self.range),
                velocity: known(self.velocity),
                sigma_range: self.sigma_range,
                sigma_velocity: self.sigma_velocity,
                ambiguity: Ambiguity::from_number(self.ambiguity, self.candidates)?,
                verdict,
            }),
            _ => return None,
        })
    }
}

impl Basis {
    /// The basis, and the number of candidates that follow. The basis is `None` where it is not told, or the clock is of a kind that is
    /// unknown here; `None` where the record ends before.
    fn read(reader: &mut Reader<'_>) -> Option<(Option<Self>, u8)> {
        let settings = reader.u32()?;
        let [clock, effort, count, flags] = reader.take()?;
        let clock = Clock::from_u8(clock).filter(|_| flags & 1 == 0);
        Some((clock.map(|clock| Self { settings, clock, effort }), count))
    }
}

/// So many candidates. `None` if they are more than there can be, or an odds is no probability.
fn candidates_of(reader: &mut Reader<'_>, count: u8) -> Option<Candidates> {
    let mut candidates = Vec::<Candidate, CANDIDATES>::new();
    for _ in 0..count {
        let range = I32F32::from_bits(reader.i64()?);
        let velocity = I32F32::from_bits(reader.i64()?);
        let odds = reader.f32().filter(|odds| (0.0..=1.0).contains(odds))?;
        candidates.push(Candidate { range, velocity, odds }).ok()?;
    }
    Some(Candidates::new(candidates))
}

impl Telemetry {
    /// The telemetry as bytes.
    pub fn to_bytes(&self) -> Vec<u8, LONGEST> {
        // A buffer of this length holds them.
        Vec::from_slice(self.written(&mut [0; LONGEST])).unwrap_or_default()
    }

    fn written<'a>(&self, bytes: &'a mut [u8; LONGEST]) -> &'a [u8] {
        let Measurement { stamp, clipped, tone, result } = &self.measurement;
        let flat = Flat::of(result);
        let mut writer = Writer::new(bytes);
        let flags = u8::from(stamp.gap) | tone.also.bits() << 1;
        writer.put([VERSION, stamp.segment as u8, flags, tone.verdict as u8]);
        writer.u32(stamp.sequence);
        writer.u64(stamp.clock);
        writer.u32(*clipped);
        writer.i32(tone.frequency.0.to_bits());
        writer.f32(tone.sigma);
        writer.f32(tone.snr);
        writer.f32(tone.amplitude);
        writer.u32(self.health.lost);
        writer.u32(self.health.faults);
        writer.put([flat.outcome, flat.verdict, flat.ambiguity, self.method.id()]);
        writer.i64(flat.range);
        writer.i64(flat.velocity);
        writer.f32(flat.sigma_range);
        writer.f32(flat.sigma_velocity);
        writer.i64(flat.other_range);
        writer.i64(flat.other_velocity);
        writer.f64(tone.rate_hz);
        let Basis { settings, clock, effort } = self.basis.unwrap_or_default();
        writer.u32(settings);
        let told = self.basis.is_some();
        let count = flat.candidates.len();
        writer.put([clock as u8, effort, count as u8, u8::from(!told)]);
        for candidate in flat.candidates.iter() {
            writer.i64(candidate.range.to_bits());
            writer.i64(candidate.velocity.to_bits());
            writer.f32(candidate.odds);
        }
        let length = if told || count > 0 { LONG + 20 * count } else { LENGTH };
        bytes.get(..length).unwrap_or_default()
    }

    /// The telemetry as a frame, ready to send.
    pub fn to_frame(&self) -> Vec<u8, { frame::WIRE }> {
        // Telemetry is shorter than the largest payload.
        frame::encode(Kind::Telemetry, self.written(&mut [0; LONGEST])).unwrap_or_default()
    }

    /// The telemetry in a frame.
    ///
    /// # Errors
    /// The frame is of another kind, or its payload holds no telemetry.
    pub fn from_frame(frame: &Frame) -> Result<Self, TelemetryError> {
        match frame.kind {
            Kind::Telemetry => Self::from_bytes(&frame.payload),
            kind => Err(TelemetryError::Kind(kind)),
        }
    }

    /// The telemetry in these bytes.
    ///
    /// # Errors
    /// The bytes are too short, of another version, or a field holds an unknown number, or one that its verdict forbids: a number
    /// that is of use has a finite sigma.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TelemetryError> {
        match bytes.first() {
            None => return Err(TelemetryError::Short),
            Some(&VERSION) => {}
            Some(&version) => return Err(TelemetryError::Version(version)),
        }
        let Some((body, more)) = bytes.split_first_chunk::<LENGTH>() else {
            return Err(TelemetryError::Short);
        };
        let record = Self::read(&mut Reader(body)).ok_or(TelemetryError::Field)?;
        let mut more = Reader(more);
        let Some((basis, count)) = Basis::read(&mut more) else { return Ok(record) };
        let mut measurement = record.measurement;
        if let Outcome::Target(Target { ambiguity: Ambiguity::Several(candidates), .. }) =
            &mut measurement.result
            && count > 0
        {
            *candidates = candidates_of(&mut more, count).ok_or(TelemetryError::Field)?;
        }
        Ok(Self { basis, measurement, ..record })
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let [_, segment, flags, verdict] = reader.take()?;
        let stamp = Stamp {
            segment: Segment::from_u8(segment)?,
            gap: flags & 1 != 0,
            sequence: reader.u32()?,
            clock: reader.u64()?,
        };
        let clipped = reader.u32()?;
        let mut tone = Tone {
            verdict: Verdict::from_u8(verdict)?,
            also: Verdicts::from_bits(flags >> 1),
            frequency: Frequency(I0F32::from_bits(reader.i32()?)),
            sigma: reader.f32()?,
            snr: reader.f32()?,
            amplitude: reader.f32()?,
            rate_hz: 0.0,
        };
        let health = Health { lost: reader.u32()?, faults: reader.u32()? };
        let [outcome, outcome_verdict, ambiguity, method] = reader.take()?;
        let flat = Flat {
            outcome,
            verdict: outcome_verdict,
            ambiguity,
            range: reader.i64()?,
            velocity: reader.i64()?,
            sigma_range: reader.f32()?,
            sigma_velocity: reader.f32()?,
            other_range: reader.i64()?,
            other_velocity: reader.i64()?,
            candidates: Candidates::default(),
        };
        let flat = Flat { candidates: flat.first_two(), ..flat };
        tone.rate_hz = reader.f64()?;
        let result = flat.outcome()?;
        let known = tone.rate_hz >= 0.0 && tone.rate_hz.is_finite();
        if !(known && tone.is_consistent() && result.is_consistent()) {
            return None;
        }
        let method = Method::from_u8(method)?;
        let measurement = Measurement { stamp, clipped, tone, result };
        Some(Self { measurement, method, health, basis: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a reader would show as good has numbers.
    #[test]
    fn a_record_that_its_own_verdict_forbids_is_refused() {
        let tone = Tone {
            sigma: 1e-6,
            snr: 10.0,
            amplitude: 1e3,
            rate_hz: 1e5,
            verdict: Verdict::Good,
            ..Tone::default()
        };
        let velocity = Velocity { velocity: I32F32::ONE, sigma: 1e-3, verdict: Verdict::Moving };
        let told = |tone: Tone, velocity: Velocity| {
            let result = Outcome::Velocity(velocity);
            let measurement = Measurement { tone, result, ..Measurement::default() };
            let health = Health::default();
            let record = Telemetry { measurement, method: Method::default(), health, basis: None };
            Telemetry::from_bytes(&record.to_bytes())
        };
        assert!(told(tone, velocity).is_ok());
        let mut wrong = [tone; 7];
        wrong[0].sigma = f32::INFINITY;
        wrong[1].sigma = f32::NAN;
        wrong[2].sigma = -1e-6;
        wrong[3].snr = 0.0;
        wrong[4].amplitude = f32::INFINITY;
        wrong[5].rate_hz = f64::NAN;
        wrong[6].rate_hz = -1.0;
        for tone in wrong {
            assert_eq!(told(tone, velocity), Err(TelemetryError::Field), "{tone:?}");
        }
        for sigma in [f32::INFINITY, f32::NAN] {
            assert_eq!(told(tone, Velocity { sigma, ..velocity }), Err(TelemetryError::Field));
        }
        // What nobody may use has any numbers.
        let weak = Tone { sigma: f32::INFINITY, snr: 0.0, verdict: Verdict::NoSignal, ..tone };
        assert!(told(weak, velocity).is_ok());
    }

    #[test]
    fn a_record_fills_its_length_and_fits_a_frame() {
        let target = Target {
            velocity: None,
            ambiguity: Ambiguity::Several(Candidates::new([Candidate::default(); CANDIDATES])),
            ..Target::default()
        };
        let measurement = Measurement { result: Outcome::Target(target), ..Measurement::default() };
        let basis = Basis { settings: 0xDEAD_BEEF, clock: Clock::Internal, effort: 2 };
        let (method, health) = (Method::ZRife, Health::default());
        for basis in [None, Some(basis)] {
            let record = Telemetry { measurement, method, health, basis };
            // The last field ends the layout.
            let bytes = record.to_bytes();
            assert_eq!((Telemetry::from_bytes(&bytes), bytes.len()), (Ok(record), LONGEST));
            assert!(!record.to_frame().is_empty());
            // Whatever a later layout appends is skipped.
            let later = [&bytes[..], &[7; 24]].concat();
            assert_eq!(Telemetry::from_bytes(&later), Ok(record));
        }
        const { assert!(LONGEST <= frame::PAYLOAD) };
        let result = Outcome::Target(Target { ambiguity: Ambiguity::Coupled, ..target });
        let measurement = Measurement { result, ..measurement };
        for (basis, length) in [(None, LENGTH), (Some(basis), LONG)] {
            let record = Telemetry { measurement, method, health, basis };
            let bytes = record.to_bytes();
            assert_eq!((Telemetry::from_bytes(&bytes), bytes.len()), (Ok(record), length));
        }
        // What is cut off, and a clock that nobody knows here, are not told; the measurement is.
        let record = Telemetry { measurement, method, health, basis: Some(basis) };
        let unknown = Ok(Telemetry { basis: None, ..record });
        let mut bytes = record.to_bytes();
        assert_eq!(Telemetry::from_bytes(&bytes[..LONG - 1]), unknown);
        bytes[100] = 9;
        assert_eq!(Telemetry::from_bytes(&bytes), unknown);
    }
}
