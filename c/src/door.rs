//! The calls, for every kind and length of record.

use crate::frames::{self, Framed};
use crate::memory::{Out, Slot, read, read_if};
use crate::status::Status;
use crate::types::{
    CAccumulated, CAccumulating, CBurst, CConfig, CCounts, CFollowing, CLine, CMeasurement, CScene,
    CStamp, CTarget, CTone, CTrack, CTrigger, Given, bounds,
};
use picket_dsp::acquire::frontend::Timing;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::plan::{Solver, Terms};
use picket_dsp::solve::track::State;
use picket_dsp::tone::harmonic::HIGHEST;
use picket_dsp::{
    Accumulator, BurstProcessor, Codes, Config, Measurement, Pipeline, Plan, Record, Stamp, Target,
    Tracker, Velocity,
};

/// A pipeline, its last measurement, and the number of the next block for callers that count none.
pub struct Meter<R: Record, const N: usize> {
    pipeline: Pipeline<R, N>,
    last: Option<Measurement>,
    number: u32,
}

/// A tracker, its last segment, and the number of the next block for callers that count none.
pub struct Follower<R: Record, const N: usize> {
    tracker: Tracker<R, N>,
    rate_hz: f64,
    timing: Timing,
    number: u32,
}

/// What a memory holds.
#[derive(Clone, Copy)]
enum Holds {
    Meter = 0,
    Follower = 1,
    Sum = 2,
    Bursts = 3,
}

/// The mark that distinguishes a memory from those of other contents, kinds and lengths.
const fn number<R: Record, const N: usize>(holds: Holds) -> u16 {
    // A length has 13 bits.
    N as u16 | (R::IQ as u16) << 13 | (holds as u16) << 14
}

/// The stamps of blocks that follow one another, in the order of the plan's segments.
fn timing(terms: &Terms) -> Timing {
    let segments = match terms.solver {
        Solver::Chirp(equations) => equations.shape.segments(),
        Solver::None | Solver::Doppler(_) => &[],
    };
    Timing { segments, ..Timing::continuous(terms.n) }
}

/// The plan of what a program set.
///
/// # Safety
/// What is not NULL points to what its type says.
unsafe fn plan<R: Record, const N: usize>(
    config: *const CConfig,
    scene: *const CScene,
    following: *const CFollowing,
) -> Result<Plan<R, N>, Status> {
    // SAFETY: as the caller promises.
    let (config, scene, following) =
        unsafe { (read(config)?, read_if(scene)?, read_if(following)?) };
    let mut config: Config = config.given()?;
    if let Some(scene) = scene {
        config.scene = scene.given()?;
        [config.range_m, config.velocity_mps] = bounds(scene);
    }
    if let Some(following) = following {
        config.following = following.given()?;
    }
    Ok(config.plan()?)
}

/// The samples of a record.
///
/// # Safety
/// If there are as many as a record has, they are where the pointer says.
unsafe fn samples<'a, R: Record, const N: usize>(
    words: *const i16,
    count: usize,
) -> Result<&'a [R::Sample; N], Status> {
    if count != N {
        return Err(Status::Samples);
    }
    // SAFETY: `R` is `Real` or `Iq`, whose samples are one or two words side by side.
    unsafe { read(words.cast()) }
}

impl<R: Record, const N: usize> Meter<R, N> {
    const NUMBER: u16 = number::<R, N>(Holds::Meter);

    /// `picket_..._init`.
    ///
    /// # Safety
    /// Pointers that are not NULL point to what their types say.
    pub unsafe fn init(
        memory: *mut Slot<Self>,
        config: *const CConfig,
        scene: *const CScene,
    ) -> Result<(), Status> {
        let memory = Slot::place(memory)?;
        // SAFETY: as the caller promises.
        unsafe {
            let plan = plan(config, scene, core::ptr::null())?;
            Self::begin(memory, plan);
        }
        Ok(())
    }

    /// `picket_..._init_tone`.
    ///
    /// # Safety
    /// As for [`Meter::init`].
    pub unsafe fn init_tone(
        memory: *mut Slot<Self>,
        rate_hz: f64,
        low: i16,
        high: i16,
    ) -> Result<(), Status> {
        let memory = Slot::place(memory)?;
        let codes = Codes::between(low, high).ok_or(Status::Codes)?;
        if !(1e-6..=1e12).contains(&rate_hz) {
            return Err(Status::Rate);
        }
        // SAFETY: as the caller promises.
        unsafe { Self::begin(memory, Plan::tone(rate_hz, codes)) };
        Ok(())
    }

    /// # Safety
    /// [`Slot::place`] gave the memory.
    #[inline(always)]
    unsafe fn begin(memory: *mut Slot<Self>, plan: Plan<R, N>) {
        let meter = Self { pipeline: Pipeline::new(plan), last: None, number: 0 };
        // SAFETY: as the caller promises.
        unsafe { Slot::write(memory, Self::NUMBER, meter) };
    }

    /// `picket_..._block`.
    ///
    /// # Safety
    /// As for [`Meter::init`].
    pub unsafe fn block(
        memory: *mut Slot<Self>,
        words: *const i16,
        count: usize,
        tone: *mut CTone,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let meter = Slot::open(memory, Self::NUMBER)?;
            let (samples, answer) = (samples::<R, N>(words, count)?, Out::at(tone)?);
            let stamp = Stamp { sequence: meter.number, ..Stamp::default() };
            meter.number = meter.number.wrapping_add(1);
            let (clipped, tone) = meter.pipeline.tone(&stamp, samples);
            let last = Measurement { stamp, clipped, tone, ..Measurement::default() };
            meter.last = Some(last);
            answer.put(CTone::from_tone(&tone, clipped));
        }
        Ok(())
    }

    /// `picket_..._measure`.
    ///
    /// # Safety
    /// As for [`Meter::init`].
    pub unsafe fn measure(
        memory: *mut Slot<Self>,
        stamp: *const CStamp,
        words: *const i16,
        count: usize,
        measurement: *mut CMeasurement,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let meter = Slot::open(memory, Self::NUMBER)?;
            let (samples, answer) = (samples::<R, N>(words, count)?, Out::at(measurement)?);
            let stamp = match read_if(stamp)? {
                Some(stamp) => stamp.given()?,
                None => timing(meter.pipeline.plan()).stamp(meter.number.into(), false),
            };
            meter.number = stamp.sequence.wrapping_add(1);
            let measurement = meter.pipeline.block(&stamp, samples);
            meter.last = Some(measurement);
            answer.put(CMeasurement::from_measurement(&measurement));
        }
        Ok(())
    }

    /// `picket_..._lines`.
    ///
    /// # Safety
    /// As for [`Meter::init`], and there is room for this many lines.
    pub unsafe fn lines(
        memory: *mut Slot<Self>,
        lines: *mut CLine,
        room: usize,
        found: *mut usize,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let meter = Slot::open(memory, Self::NUMBER)?;
            let (lines, found) = (Out::at(lines)?, Out::at(found)?);
            let last = meter.last.as_ref().ok_or(Status::NoBlock)?;
            let phasors = meter.pipeline.lines(last, room);
            let rows = phasors.iter().map(|phasor| CLine::from_phasor(phasor, last.clipped));
            found.put(lines.put_all(room, rows));
        }
        Ok(())
    }

    /// `picket_..._harmonics`.
    ///
    /// # Safety
    /// As for [`Meter::init`].
    pub unsafe fn harmonics(
        memory: *mut Slot<Self>,
        order: u32,
        fundamental: *mut CTone,
        orders: *mut u32,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let meter = Slot::open(memory, Self::NUMBER)?;
            let (fundamental, orders) = (Out::at(fundamental)?, Out::at(orders)?);
            if !(2..=HIGHEST).contains(&order) {
                return Err(Status::Option);
            }
            let last = meter.last.as_ref().ok_or(Status::NoBlock)?;
            let found = meter.pipeline.harmonic(last, order).unwrap_or_default();
            fundamental.put(CTone::from_tone(&found.tone, last.clipped));
            orders.put(found.orders);
        }
        Ok(())
    }
}

impl<R: Record, const N: usize> Meter<R, N> {
    /// `picket_..._frame_push`.
    ///
    /// # Safety
    /// As for [`Meter::init`]; the meter is only read.
    pub unsafe fn frame(
        memory: *const Slot<Self>,
        frame: *mut Slot<Framed>,
        complete: *mut u8,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let meter = &*Slot::open(memory.cast_mut(), Self::NUMBER)?;
            let clipped = meter.last.as_ref().ok_or(Status::NoBlock)?.clipped;
            frames::push(frame, (&meter.pipeline.spectrum().view(), clipped), complete)
        }
    }
}

impl<R: Record, const N: usize> Follower<R, N> {
    const NUMBER: u16 = number::<R, N>(Holds::Follower);

    /// `picket_..._tracker_init`.
    ///
    /// # Safety
    /// Pointers that are not NULL point to what their types say.
    pub unsafe fn init(
        memory: *mut Slot<Self>,
        config: *const CConfig,
        scene: *const CScene,
        following: *const CFollowing,
    ) -> Result<(), Status> {
        let memory = Slot::place(memory)?;
        // SAFETY: as the caller promises. A following of zeros follows one tone.
        unsafe {
            read(following)?;
            let plan = plan::<R, N>(config, scene, following)?;
            let (rate_hz, timing) = (plan.rate_hz, timing(&plan));
            let follower = Self { tracker: Tracker::new(plan), rate_hz, timing, number: 0 };
            Slot::write(memory, Self::NUMBER, follower);
        }
        Ok(())
    }

    /// `picket_..._track`.
    ///
    /// # Safety
    /// As for [`Follower::init`], and there is room for this many tracks.
    #[allow(clippy::too_many_arguments)]
    pub unsafe fn track(
        memory: *mut Slot<Self>,
        stamp: *const CStamp,
        words: *const i16,
        count: usize,
        measurement: *mut CMeasurement,
        tracks: *mut CTrack,
        room: usize,
        found: *mut usize,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let follower = Slot::open(memory, Self::NUMBER)?;
            let (samples, answer) = (samples::<R, N>(words, count)?, Out::at(measurement)?);
            let (tracks, found) = (Out::at(tracks)?, Out::at(found)?);
            let stamp = match read_if(stamp)? {
                Some(stamp) => stamp.given()?,
                None => follower.timing.stamp(follower.number.into(), false),
            };
            follower.number = stamp.sequence.wrapping_add(1);
            answer.put(CMeasurement::from_measurement(&follower.tracker.block(&stamp, samples)));
            let all = follower.tracker.tracks(stamp.segment).iter();
            found.put(
                tracks.put_all(room, all.map(|track| CTrack::from_track(track, follower.rate_hz))),
            );
        }
        Ok(())
    }

    /// `picket_..._targets`.
    ///
    /// # Safety
    /// As for [`Follower::init`], and there is room for this many targets.
    pub unsafe fn targets(
        memory: *mut Slot<Self>,
        targets: *mut CTarget,
        room: usize,
        found: *mut usize,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let follower = Slot::open(memory, Self::NUMBER)?;
            let (targets, found) = (Out::at(targets)?, Out::at(found)?);
            let tracker = &follower.tracker;
            let held = tracker.tracks(Segment::Continuous).iter();
            let held = held.filter(|track| track.state == State::Held);
            // Of a Doppler shift each held track is a target that has a velocity alone.
            let velocities = tracker.velocities();
            let moving = held.zip(&velocities).map(|(track, velocity)| {
                let Velocity { velocity, sigma: sigma_velocity, verdict } = *velocity;
                let velocity = Some(velocity);
                let target = Target { velocity, sigma_velocity, verdict, ..Target::default() };
                CTarget::from_target(&target, track.number)
            });
            let solved = tracker.targets();
            let solved =
                solved.iter().map(|(track, target)| CTarget::from_target(target, (*track).into()));
            let rows = moving.chain(solved);
            found.put(targets.put_all(room, rows));
        }
        Ok(())
    }
}

/// The calls of an accumulator.
pub struct Sum<R: Record, const N: usize>(Accumulator<R, N>);

impl<R: Record, const N: usize> Sum<R, N> {
    const NUMBER: u16 = number::<R, N>(Holds::Sum);

    /// `picket_..._accumulator_init`.
    ///
    /// # Safety
    /// Pointers that are not NULL point to what their types say.
    pub unsafe fn init(memory: *mut Slot<Self>, terms: *const CAccumulating) -> Result<(), Status> {
        let memory = Slot::place(memory)?;
        // SAFETY: as the caller promises.
        unsafe {
            let sum = read(terms)?.given()?;
            Slot::write(memory, Self::NUMBER, Self(sum));
        }
        Ok(())
    }

    /// `picket_..._accumulate`.
    ///
    /// # Safety
    /// As for [`Sum::init`].
    pub unsafe fn add(
        memory: *mut Slot<Self>,
        meter: *const Slot<Meter<R, N>>,
        accumulated: *mut CAccumulated,
        complete: *mut u8,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises; the meter is only read.
        unsafe {
            let Self(sum) = Slot::open(memory, Self::NUMBER)?;
            let meter = &*Slot::open(meter.cast_mut(), Meter::<R, N>::NUMBER)?;
            let (answer, complete) = (Out::at(accumulated)?, Out::at(complete)?);
            let last = meter.last.as_ref().ok_or(Status::NoBlock)?;
            let seen = sum.add(last, &meter.pipeline);
            if let Some(seen) = &seen {
                answer.put(CAccumulated::from_sum(seen));
            }
            complete.put(seen.is_some().into());
        }
        Ok(())
    }
}

/// The calls of a burst processor.
pub struct Bursts<R: Record, const N: usize>(BurstProcessor<R, N>);

impl<R: Record, const N: usize> Bursts<R, N> {
    const NUMBER: u16 = number::<R, N>(Holds::Bursts);

    /// `picket_..._bursts_init`.
    ///
    /// # Safety
    /// Pointers that are not NULL point to what their types say.
    pub unsafe fn init(
        memory: *mut Slot<Self>,
        config: *const CConfig,
        trigger: *const CTrigger,
    ) -> Result<(), Status> {
        let memory = Slot::place(memory)?;
        // SAFETY: as the caller promises.
        unsafe {
            let plan = plan::<R, N>(config, core::ptr::null(), core::ptr::null())?;
            let trigger = read_if(trigger)?.map(|trigger| trigger.given()).transpose()?;
            let processor = BurstProcessor::with_trigger(plan, trigger.unwrap_or_default());
            Slot::write(memory, Self::NUMBER, Self(processor));
        }
        Ok(())
    }

    /// `picket_..._bursts_push`.
    ///
    /// # Safety
    /// As for [`Bursts::init`], and there are this many samples and room for this many bursts.
    pub unsafe fn push(
        memory: *mut Slot<Self>,
        words: *const i16,
        count: usize,
        bursts: *mut CBurst,
        room: usize,
        found: *mut usize,
    ) -> Result<(), Status> {
        // SAFETY: as the caller promises. `R` is `Real` or `Iq`, whose samples are one or two words side by side.
        unsafe {
            let Self(processor) = Slot::open(memory, Self::NUMBER)?;
            let first: *const R::Sample = words.cast();
            read(first)?;
            let (mut bursts, found) = (Out::at(bursts)?, Out::at(found)?);
            let mut number = 0;
            processor.push(core::slice::from_raw_parts(first, count), |burst| {
                if number < room {
                    bursts.put_at(number, CBurst::from_burst(burst));
                }
                number += 1;
            });
            found.put(number);
        }
        Ok(())
    }

    /// `picket_..._bursts_lost`.
    ///
    /// # Safety
    /// As for [`Bursts::init`].
    pub unsafe fn lost(memory: *mut Slot<Self>, samples: u64) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe { Slot::open(memory, Self::NUMBER)? }.0.lost(samples);
        Ok(())
    }

    /// `picket_..._bursts_counts`.
    ///
    /// # Safety
    /// As for [`Bursts::init`].
    pub unsafe fn counts(memory: *mut Slot<Self>, counts: *mut CCounts) -> Result<(), Status> {
        // SAFETY: as the caller promises.
        unsafe {
            let Self(processor) = Slot::open(memory, Self::NUMBER)?;
            Out::at(counts)?.put(CCounts::from_counters(processor.counters()));
        }
        Ok(())
    }
}
