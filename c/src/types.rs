//! What crosses the border, as `picket.h` lays it out. Every field has a width of its own, and no structure has holes.

use crate::status::Status;
use core::mem::size_of;
use picket_dsp::accumulate::MOST_BLOCKS;
use picket_dsp::acquire::burst::Counters;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::fixed::types::I32F32;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_dsp::solve::candidates::CANDIDATES;
use picket_dsp::solve::chirp::{Mixing, Shape, Target};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::track::Track;
use picket_dsp::tone::phasor::ToneWithPhase;
use picket_dsp::{
    Accumulated, Accumulator, Arithmetic, Burst, Codes, Config, Following, Reach, Record, Scene,
    Tone, Trigger,
};

/// `picket_tone`: a measured tone.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CTone {
    frequency_hz: f64,
    sigma_hz: f64,
    snr: f32,
    amplitude: f32,
    clipped: u32,
    verdict: u8,
    also: u8,
    reserved: [u8; 2],
}

impl CTone {
    /// A tone of a block in which so many samples touch a rail.
    pub fn from_tone(tone: &Tone, clipped: u32) -> Self {
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
}

/// `picket_line`: one of a block's tones, with its phase.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CLine {
    tone: CTone,
    phase_rad: f32,
    sigma_phase_rad: f32,
}

impl CLine {
    pub fn from_phasor(phasor: &ToneWithPhase, clipped: u32) -> Self {
        Self {
            tone: CTone::from_tone(&phasor.tone, clipped),
            phase_rad: phasor.phase,
            sigma_phase_rad: phasor.sigma_phase,
        }
    }
}

/// `picket_candidate`: a target that fits as others do.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CCandidate {
    range_m: f64,
    velocity_mps: f64,
    odds: f64,
}

/// `picket_target`: a range and a velocity, or a velocity alone.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CTarget {
    range_m: f64,
    velocity_mps: f64,
    candidates: [CCandidate; CANDIDATES],
    sigma_range_m: f32,
    sigma_velocity_mps: f32,
    track: u32,
    verdict: u8,
    ambiguity: u8,
    count: u8,
    reserved: u8,
}

impl CTarget {
    /// A target whose rising beat is followed by the track of this number.
    pub fn from_target(target: &Target, track: u32) -> Self {
        let mut candidates = [CCandidate::default(); CANDIDATES];
        let all = target.ambiguity.candidates();
        for (candidate, found) in candidates.iter_mut().zip(all) {
            *candidate = CCandidate {
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

/// `picket_measurement`: a tone, and what it amounts to.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CMeasurement {
    tone: CTone,
    target: CTarget,
    outcome: u8,
    reserved: [u8; 7],
}

impl CMeasurement {
    pub fn from_measurement(measurement: &Measurement) -> Self {
        let (outcome, target) = match &measurement.result {
            Outcome::None => (0, CTarget::default()),
            Outcome::Velocity(velocity) => {
                let target = Target {
                    velocity: Some(velocity.velocity),
                    sigma_velocity: velocity.sigma,
                    verdict: velocity.verdict,
                    ..Target::default()
                };
                (1, CTarget::from_target(&target, 0))
            }
            Outcome::Target(target) => (2, CTarget::from_target(target, 0)),
        };
        Self {
            tone: CTone::from_tone(&measurement.tone, measurement.clipped),
            target,
            outcome,
            reserved: [0; 7],
        }
    }
}

/// `picket_track`: a tone that is followed.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CTrack {
    tone: CTone,
    rate_hz_per_block: f32,
    number: u32,
    age: u32,
    state: u8,
    misses: u8,
    reserved: [u8; 2],
}

impl CTrack {
    pub fn from_track(track: &Track, rate_hz: f64) -> Self {
        let tone = Tone { rate_hz, ..track.tone };
        Self {
            tone: CTone::from_tone(&tone, 0),
            rate_hz_per_block: (f64::from(track.rate()) * rate_hz) as f32,
            number: track.number,
            age: track.age,
            state: track.state as u8,
            misses: track.misses,
            reserved: [0; 2],
        }
    }
}

/// `picket_stamp`: where and when a block was taken.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CStamp {
    clock: u64,
    sequence: u32,
    segment: u8,
    gap: u8,
    reserved: [u8; 2],
}

impl CStamp {
    pub fn stamp(&self) -> Result<Stamp, Status> {
        let segment = Segment::from_u8(self.segment).ok_or(Status::Option)?;
        if self.gap > 1 || self.reserved != [0; 2] {
            return Err(Status::Option);
        }
        Ok(Stamp { sequence: self.sequence, clock: self.clock, segment, gap: self.gap == 1 })
    }
}

/// `picket_config`: what a user sets. Zeros are the library's own choice, but for rate and codes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CConfig {
    rate_hz: f64,
    band_low_hz: f64,
    band_high_hz: f64,
    false_alarm: f64,
    low_code: i16,
    high_code: i16,
    arithmetic: u8,
    reach: u8,
    reserved: [u8; 2],
}

impl CConfig {
    /// The library's configuration of these values.
    pub fn config(&self) -> Result<Config, Status> {
        let codes = Codes::between(self.low_code, self.high_code).ok_or(Status::Codes)?;
        let mut config = Config::new(self.rate_hz, codes);
        config.arithmetic = match self.arithmetic {
            0 => Arithmetic::from_core(),
            1 => Arithmetic::Float,
            2 => Arithmetic::Fixed,
            _ => return Err(Status::Option),
        };
        // Not every core has every arithmetic, and another one gives other bits.
        if config.arithmetic != config.arithmetic.available() || self.reserved != [0; 2] {
            return Err(Status::Option);
        }
        config.reach = match self.reach {
            0 => Reach::default(),
            4 => Reach::Four,
            8 => Reach::Eight,
            16 => Reach::Sixteen,
            _ => return Err(Status::Option),
        };
        if self.band_low_hz != 0.0 || self.band_high_hz != 0.0 {
            config.band_hz = Some((self.band_low_hz, self.band_high_hz));
        }
        if self.false_alarm != 0.0 {
            config.false_alarm = self.false_alarm;
        }
        Ok(config)
    }
}

/// `picket_scene`: what the samples were taken of.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CScene {
    wavelength_m: f64,
    angle_rad: f64,
    bandwidth_hz: f64,
    duration_s: f64,
    guard_s: f64,
    sweep_curvature: f64,
    range_m: [f64; 2],
    velocity_mps: [f64; 2],
    kind: u8,
    shape: u8,
    mixing: u8,
    reserved: [u8; 5],
}

impl CScene {
    /// The bounds of a target's range and of its velocity, where they are set.
    pub fn bounds(&self) -> [Option<(f64, f64)>; 2] {
        [self.range_m, self.velocity_mps]
            .map(|[low, high]| (low != 0.0 || high != 0.0).then_some((low, high)))
    }

    /// The library's scene of these values.
    pub fn scene(&self) -> Result<Scene, Status> {
        let mixing = match self.mixing {
            0 => Mixing::TxConjRx,
            1 => Mixing::RxConjTx,
            _ => return Err(Status::Option),
        };
        let shape = match self.shape {
            0 => Shape::Trapezoid,
            1 => Shape::Triangle,
            2 => Shape::Sawtooth,
            _ => return Err(Status::Option),
        };
        if self.reserved != [0; 5] {
            return Err(Status::Option);
        }
        let Self { wavelength_m, angle_rad, bandwidth_hz, duration_s, guard_s, .. } = *self;
        match self.kind {
            0 => Ok(Scene::Tone),
            1 => Ok(Scene::Doppler { wavelength_m, angle_rad, mixing }),
            2 => {
                let sweep_curvature = self.sweep_curvature;
                Ok(Scene::Chirp(Chirp {
                    shape,
                    wavelength_m,
                    bandwidth_hz,
                    duration_s,
                    guard_s,
                    mixing,
                    sweep_curvature,
                }))
            }
            _ => Err(Status::Option),
        }
    }
}

/// `picket_following`: how tones are followed. Zeros are the library's own choice.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CFollowing {
    rate_bins: f32,
    most: u8,
    refresh: u8,
    reserved: [u8; 2],
}

impl CFollowing {
    /// The library's terms of these values.
    pub fn following(&self) -> Result<Following, Status> {
        if self.reserved != [0; 2] {
            return Err(Status::Option);
        }
        let usual = Following::default();
        let or = |value: f32, usual: f32| if value == 0.0 { usual } else { value };
        Ok(Following {
            rate_bins: or(self.rate_bins, usual.rate_bins),
            most: self.most.max(1),
            refresh: self.refresh,
        })
    }
}

/// `picket_accumulating`: what an accumulator adds. Zeros are the library's own choice, but for the blocks.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CAccumulating {
    false_alarm: f64,
    drift_bins: f32,
    blocks: u32,
    segment: u8,
    reserved: [u8; 7],
}

impl CAccumulating {
    /// An accumulator of these terms.
    #[inline(always)]
    pub fn accumulator<R: Record, const N: usize>(&self) -> Result<Accumulator<R, N>, Status> {
        let segment = Segment::from_u8(self.segment).ok_or(Status::Option)?;
        let blocks = (1..=MOST_BLOCKS).contains(&self.blocks);
        if !blocks || !self.drift_bins.is_finite() || self.reserved != [0; 7] {
            return Err(Status::Option);
        }
        let mut sum = Accumulator::new(self.blocks).with_drift(self.drift_bins);
        if self.false_alarm != 0.0 {
            if !(self.false_alarm > 0.0 && self.false_alarm <= 0.5) {
                return Err(Status::FalseAlarm);
            }
            sum = sum.with_false_alarm(self.false_alarm);
        }
        let whole = segment == Segment::Continuous;
        Ok(if whole { sum } else { sum.for_segment(segment) })
    }
}

/// `picket_accumulated`: what a sum of blocks shows.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CAccumulated {
    tone: CTone,
    ln_chance: f32,
    blocks: u32,
}

impl CAccumulated {
    pub fn from_sum(sum: &Accumulated) -> Self {
        Self { tone: CTone::from_tone(&sum.tone, 0), ln_chance: sum.ln_chance, blocks: sum.blocks }
    }
}

/// `picket_trigger`: when a burst begins and ends. Zeros are the library's own choice.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CTrigger {
    ratio: f32,
    hold_off: u32,
    least: u32,
    reserved: u32,
}

impl CTrigger {
    /// The library's trigger of these values.
    pub fn trigger(&self) -> Result<Trigger, Status> {
        let given = self.ratio != 0.0;
        if self.reserved != 0 || given && !(self.ratio > 1.0 && self.ratio <= 1e6) {
            return Err(Status::Option);
        }
        let Self { ratio, hold_off, least, .. } = *self;
        Ok(Trigger { ratio: given.then_some(ratio), hold_off, least })
    }
}

/// `picket_burst`: a burst, and the tone within it.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CBurst {
    tone: CTone,
    arrival: f64,
    deviation: f32,
    validation: u8,
    reserved: [u8; 3],
}

impl CBurst {
    pub fn from_burst(burst: &Burst) -> Self {
        Self {
            tone: CTone::from_tone(&burst.tone, 0),
            arrival: burst.arrival,
            deviation: burst.deviation,
            validation: burst.validation as u8,
            reserved: [0; 3],
        }
    }
}

/// `picket_counts`: what was counted in a stream of bursts.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct CCounts {
    samples: u64,
    dead: u64,
    bursts: u32,
    lost: u32,
    long: u32,
    reserved: u32,
}

impl CCounts {
    pub fn from_counters(counters: &Counters) -> Self {
        let Counters { samples, bursts, lost, long, dead } = *counters;
        Self { samples, dead, bursts, lost, long, reserved: 0 }
    }
}

// As `picket.h` asserts them, too.
const _: () = assert!(
    size_of::<CTone>() == 32
        && size_of::<CLine>() == 40
        && size_of::<CTarget>() == 128
        && size_of::<CMeasurement>() == 168
        && size_of::<CTrack>() == 48
        && size_of::<CStamp>() == 16
        && size_of::<CConfig>() == 40
        && size_of::<CScene>() == 88
        && size_of::<CFollowing>() == 8
        && size_of::<CAccumulating>() == 24
        && size_of::<CAccumulated>() == 40
        && size_of::<CTrigger>() == 16
        && size_of::<CBurst>() == 48
        && size_of::<CCounts>() == 32
);
