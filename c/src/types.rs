//! The types of the interface, as `picket_wire::view` describes them and `picket.h` has them.

use crate::status::Status;
use picket_dsp::accumulate::MOST_BLOCKS;
use picket_dsp::acquire::sample::{Segment, Stamp};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::{
    Accumulator, Arithmetic, Codes, Config, Following, Reach, Record, Scene, Trigger,
};

pub use picket_wire::view::{
    Accumulated as CAccumulated, Accumulating as CAccumulating, Budget as CBudget, Burst as CBurst,
    Calibration as CCalibration, Config as CConfig, Counts as CCounts,
    Displacement as CDisplacement, Following as CFollowing, FrameTarget as CFrameTarget,
    Framing as CFraming, Line as CLine, Measurement as CMeasurement, PhaseRange as CPhaseRange,
    Scene as CScene, Stamp as CStamp, Target as CTarget, Tone as CTone, Track as CTrack,
    Trigger as CTrigger, Uncertainty as CUncertainty,
};

/// What a program set, as the library has it.
pub trait Given<T> {
    /// The library's value.
    fn given(&self) -> Result<T, Status>;
}

impl Given<Stamp> for CStamp {
    fn given(&self) -> Result<Stamp, Status> {
        let segment = Segment::from_u8(self.segment).ok_or(Status::Option)?;
        if self.gap > 1 || self.reserved != [0; 2] {
            return Err(Status::Option);
        }
        Ok(Stamp { sequence: self.sequence, clock: self.clock, segment, gap: self.gap == 1 })
    }
}

impl Given<Config> for CConfig {
    fn given(&self) -> Result<Config, Status> {
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

/// The bounds of a target's range and of its velocity, where they are set.
pub fn bounds(scene: &CScene) -> [Option<(f64, f64)>; 2] {
    let &CScene { range_low_m, range_high_m, velocity_low_mps, velocity_high_mps, .. } = scene;
    [(range_low_m, range_high_m), (velocity_low_mps, velocity_high_mps)]
        .map(|(low, high)| (low != 0.0 || high != 0.0).then_some((low, high)))
}

impl Given<Scene> for CScene {
    fn given(&self) -> Result<Scene, Status> {
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

impl Given<Following> for CFollowing {
    fn given(&self) -> Result<Following, Status> {
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

impl<R: Record, const N: usize> Given<Accumulator<R, N>> for CAccumulating {
    #[inline(always)]
    fn given(&self) -> Result<Accumulator<R, N>, Status> {
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

impl Given<Trigger> for CTrigger {
    fn given(&self) -> Result<Trigger, Status> {
        let given = self.ratio != 0.0;
        if self.reserved != 0 || given && !(self.ratio > 1.0 && self.ratio <= 1e6) {
            return Err(Status::Option);
        }
        let Self { ratio, hold_off, least, .. } = *self;
        Ok(Trigger { ratio: given.then_some(ratio), hold_off, least })
    }
}
