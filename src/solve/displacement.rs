//! Displacement from the phase of a tone: micrometres where a frequency shows millimetres.
//!
//! A displacement of half a wavelength turns the phase of a radar's tone once. So the phases of two blocks give the displacement between them,
//! except for whole turns. The whole turns follow from other knowledge ([`Between`]): for a Doppler radar from the frequency itself, for a chirp from
//! the target's low speed. If neither gives them for sure, the displacement restarts.

use super::waveform::{Mixing, SPEED_OF_LIGHT, Scale, Shape, metres};
use crate::acquire::sample::Stamp;
use crate::config::{Scene, beam_cosine};
use crate::error::ConfigError;
use crate::math::fixed_point::to_f32;
use crate::math::scalar::Scalar as _;
use crate::tone::phasor::ToneWithPhase;
use crate::tone::{Tone, Usable, Verdict};
use core::f32::consts::TAU;
use fixed::types::I32F32;

/// The source of the whole turns between two blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Between {
    /// A continuous wave: the phase runs on with the frequency, and the mean frequency of two blocks gives the number of turns.
    Frequency,
    /// One block in a chirp, at the same place in each: the phase is constant while the target is at rest. It turns less than this share of a
    /// turn from block to block, at most 1/4. A target that is faster, but turns the phase by less than one turn less this share, is
    /// refused.
    Turns(f32),
}

/// The displacement of a target since a start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Displacement {
    /// Metres; positive when the target went away, as ranges count.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity"))]
    pub metres: I32F32,
    /// One standard deviation, metres, of the phase in this block. The displacement of the first block is 0, and the first block's error is
    /// part of all later ones.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::sigma"))]
    pub sigma: f32,
    /// The number of the start from which the displacement counts, which is the first block after it whose tone can be used. Displacements
    /// of different starts do not belong together.
    pub start: u32,
    /// The verdict of the tone, or [`Verdict::Unresolved`] if the whole turns are not sure. The
    /// displacement restarts then.
    pub verdict: Verdict,
}

/// Follows the phase of a tone from block to block.
#[derive(Clone, Debug)]
pub struct Unwrapper {
    scale: Scale,
    between: Between,
    start: u32,
    last: Option<Last>,
}

/// The block before.
#[derive(Clone, Copy, Debug)]
struct Last {
    tone: Tone,
    /// The distance of its frequency beyond the frequency of the block before, cycles per sample.
    rise: f32,
    clock: u64,
    /// The phase, radians.
    phase: f32,
    sigma: f32,
    /// The turns since the start.
    turns: I32F32,
}

/// This many standard deviations must lie between a step and half a turn.
const SURE: f32 = 6.0;

impl Unwrapper {
    /// An unwrapper for a wavelength. `wavelength_m` is the wavelength of the carrier in the middle of the record, metres, over the cosine
    /// of the angle between beam and motion: a displacement of half of it turns the phase once. `mixing` is the direction: [`Mixing::TxConjRx`] for
    /// real records of a rising ramp. Real records of a continuous wave do not show the direction. `None` if the wavelength gives no valid
    /// scale.
    pub fn new(wavelength_m: f64, mixing: Mixing, between: Between) -> Option<Self> {
        let metres_per_turn = f64::from(mixing.sign()) * wavelength_m / 2.0;
        Some(Self { scale: Scale::new(metres_per_turn)?, between, start: 0, last: None })
    }

    /// An unwrapper for the blocks of a Doppler scene, or for one record of `n` samples in each sawtooth chirp, whose targets turn the phase by less than
    /// `most_turns` from chirp to chirp ([`Between::Turns`]).
    ///
    /// # Errors
    /// [`ConfigError::Scene`] for another scene, the errors of [`Chirp::equations`](super::equations::Chirp::equations), and
    /// [`ConfigError::Scale`].
    pub fn of_scene(
        scene: &Scene,
        rate_hz: f64,
        n: usize,
        iq: bool,
        most_turns: f32,
    ) -> Result<Self, ConfigError> {
        let unwrapper = match *scene {
            Scene::Doppler { wavelength_m, angle_rad, mixing } => {
                let along_m = wavelength_m / beam_cosine(wavelength_m, angle_rad)?;
                Self::new(along_m, mixing, Between::Frequency)
            }
            Scene::Chirp(ref chirp) if chirp.shape == Shape::Sawtooth => {
                chirp.equations(rate_hz, n, iq)?;
                let middle = (chirp.guard_s + 0.5 * n as f64 / rate_hz) / chirp.duration_s;
                let mixing = if iq { chirp.mixing } else { Mixing::TxConjRx };
                let wavelength_m = SPEED_OF_LIGHT / chirp.ramp(middle).carrier_hz;
                Self::new(wavelength_m, mixing, Between::Turns(most_turns))
            }
            _ => return Err(ConfigError::Scene),
        };
        unwrapper.ok_or(ConfigError::Scale)
    }

    /// Takes the tone of the next block. [`Stamp::clock`] gives the distance between blocks.
    ///
    /// Cost: about sixty operations.
    pub fn push(&mut self, stamp: &Stamp, phasor: &ToneWithPhase) -> Displacement {
        let ToneWithPhase { tone, phase, sigma_phase } = *phasor;
        let usable = tone.verdict.usable() <= Usable::WithinSigma;
        let step = self.last.as_ref().and_then(|last| self.step(last, stamp, phasor));
        let (turns, verdict) = match step {
            _ if !usable => (I32F32::ZERO, tone.verdict),
            Some(turns) => (turns, tone.verdict),
            // The first block is an ordinary start, without any uncertainty.
            None if self.last.is_none() => (I32F32::ZERO, tone.verdict),
            None => (I32F32::ZERO, Verdict::Unresolved),
        };
        if step.is_none() || !usable {
            self.start = self.start.wrapping_add(u32::from(self.last.is_some()));
        }
        let rise = self.last.map_or(0.0, |last| tone.frequency.beyond(last.tone.frequency));
        let here = Last { tone, rise, clock: stamp.clock, phase, sigma: sigma_phase, turns };
        self.last = usable.then_some(here);
        Displacement {
            metres: metres(turns.to_bits(), self.scale.fixed),
            sigma: (self.scale.float * (sigma_phase / TAU)).abs(),
            start: self.start,
            verdict,
        }
    }

    /// The turns since the start; `None` if they are not sure.
    fn step(&self, last: &Last, stamp: &Stamp, phasor: &ToneWithPhase) -> Option<I32F32> {
        let seen = (phasor.phase - last.phase) / TAU;
        let both = libm::hypotf(phasor.sigma_phase, last.sigma) / TAU;
        if stamp.gap {
            return None;
        }
        match self.between {
            Between::Frequency => {
                let apart = u32::try_from(stamp.clock.checked_sub(last.clock)?).ok()?;
                let (tone, samples) = (&phasor.tone, apart as f32);
                let rise = tone.frequency.beyond(last.tone.frequency);
                // Half the sum of both frequencies, in steps of 2^-32. Exact for a steady acceleration.
                let (new, old) = (tone.frequency.0.to_bits(), last.tone.frequency.0.to_bits());
                let two = 2 * i64::from(old) + i64::from(new.wrapping_sub(old));
                let expected = I32F32::from_bits(two.checked_mul(i64::from(apart))? / 2);
                let rest = I32F32::checked_from_num(seen)?.checked_sub(expected.frac())?;
                let rest = rest.checked_sub(rest.checked_round()?)?;
                // The effect of a changing acceleration, from the blocks before.
                let bend = samples * (rise - last.rise) / 6.0;
                let sigma = 0.5 * samples * libm::hypotf(tone.sigma, last.tone.sigma);
                let sigma = (sigma * sigma + both * both).root();
                let reach = to_f32(rest).abs() + SURE * sigma + bend.abs();
                let step = expected.checked_add(rest)?;
                (reach < 0.5).then(|| last.turns.checked_add(step)).flatten()
            }
            Between::Turns(most) => {
                let step = seen - libm::roundf(seen);
                let most = most.clamp(0.0, 0.25);
                let sure = step.abs() + SURE * both < most.max(f32::MIN_POSITIVE);
                if sure { last.turns.checked_add(I32F32::checked_from_num(step)?) } else { None }
            }
        }
    }
}
