//! The pipeline with a memory: it follows tones from block to block and makes targets of them.
//!
//! Each segment of a chirp has a set of [`Track`]s, updated by the tones of its blocks. While the only tone is held, most blocks are
//! measured where it is expected ([`Lock`]), and only one in `refresh` is searched whole. The held tracks of a
//! chirp's segments are then combined to targets: each rising beat takes the flat and the falling beat that contradict it least.

use crate::acquire::sample::{Data, Record, Segment, Stamp, Statistics};
use crate::list::first;
use crate::math::scalar::Scalar as _;
use crate::pipeline::{Measurement, Pipeline};
use crate::plan::{Plan, Solver};
use crate::solve::chirp::{self, Shape, Target};
use crate::solve::doppler::{self, Velocity};
use crate::solve::equations::Equations;
use crate::solve::hypotheses::solve;
use crate::solve::hypothesis::Line;
use crate::solve::track::Track;
use crate::solve::tracks::{Sight, Tracks};
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::{self, Band};
use crate::tone::lines::MOST;
use crate::tone::lock::Lock;
use crate::tone::threshold::{HOLD, Threshold};
use crate::tone::{Tone, Usable};
use heapless::Vec;

/// Turns ADC samples into tracks. Its memory is a pipeline and about 9 KB, because each segment of a chirp has its own tracks.
///
/// ```
/// use picket_dsp::solve::track::State;
/// use picket_dsp::{Codes, Config, Following, Real, Segment, Stamp, Tracker};
///
/// let following = Following { most: 1, ..Following::default() };
/// let config = Config { following, ..Config::new(8000.0, Codes::signed::<12>()) };
/// let mut tracker = Tracker::<Real, 256>::new(config.plan()?);
/// for sequence in 0..20 {
///     let tone = |n: u32| 500.0 * (0.4 * f64::from(256 * sequence + n)).sin();
///     let stamp = Stamp { sequence, clock: u64::from(256 * sequence), ..Stamp::default() };
///     tracker.block(&stamp, &std::array::from_fn(|n| tone(n as u32).round() as i16));
/// }
/// let [track] = tracker.tracks(Segment::Continuous) else { panic!("there is one tone") };
/// assert_eq!((track.state, track.age), (State::Held, 19));
/// let error = track.tone.hertz() - 0.4 / std::f64::consts::TAU * 8000.0;
/// assert!(error.abs() < 3.0 * track.tone.sigma_hertz(), "{track:?}");
/// # Ok::<(), picket_dsp::ConfigError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tracker<R: Record, const N: usize> {
    pipeline: Pipeline<R, N>,
    tracks: [Tracks; 3],
    locks: [Option<Lock>; 3],
}

impl<R: Record, const N: usize> Tracker<R, N> {
    /// A tracker for this plan; [`Terms::tracking`](crate::plan::Terms::tracking) sets how it
    /// follows.
    pub const fn new(plan: Plan<R, N>) -> Self {
        let tracks = [const { Tracks::new() }; 3];
        let locks = [const { None }; 3];
        Self { pipeline: Pipeline::new(plan), tracks, locks }
    }

    /// Follows another plan from the next block on, and forgets all tracks.
    pub fn set_plan(&mut self, plan: Plan<R, N>) {
        self.pipeline.set_plan(plan);
        self.tracks.iter_mut().for_each(|tracks| *tracks = Tracks::new());
        self.locks.iter_mut().for_each(|lock| *lock = None);
    }

    /// Whether the plan follows tones at all.
    pub fn follows(&self) -> bool {
        self.pipeline.plan().tracking.most > 0
    }

    /// Measures one block and updates the tracks of its segment. While the only tone is locked, it
    /// measures that tone where it is expected; otherwise it does what [`Pipeline::block`] does.
    /// With a plan that follows no tones, it is a pipeline.
    pub fn block(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Measurement {
        if !self.follows() {
            return self.pipeline.block(stamp, samples);
        }
        if let Some(measurement) = self.locked(stamp, samples) {
            return measurement;
        }
        let measurement = self.searched(stamp, samples);
        let (segment, layout) = (place(stamp.segment), Layout::of::<R, N>());
        let tracking = &self.pipeline.plan().tracking;
        let follow = tracking.refresh > 1 && tracking.most == 1;
        if let (Some(tracks), Some(lock)) = (self.tracks.get(segment), self.locks.get_mut(segment))
        {
            let tone = tracks.only().filter(|_| follow);
            let renewed = match (lock.as_mut(), tone) {
                (Some(lock), Some(tone)) => lock.renew(tone, layout),
                _ => false,
            };
            if !renewed {
                *lock = tone.and_then(|tone| Lock::on(tone, layout));
            }
        }
        measurement
    }

    /// Whether the last block of a segment was measured without a search.
    pub fn is_locked(&self, segment: Segment) -> bool {
        matches!(self.locks.get(place(segment)), Some(Some(lock)) if lock.age > 0)
    }

    /// Measures the locked tone without a search; `None` if a search is due. A search is due when
    /// the lock is old or does not see its tone.
    fn locked(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Option<Measurement> {
        let plan = self.pipeline.plan();
        let segment = place(stamp.segment);
        let lock = self.locks.get_mut(segment)?.as_mut()?;
        let tracks = self.tracks.get_mut(segment)?;
        if lock.age.saturating_add(1) >= plan.tracking.refresh {
            return None;
        }
        let expected = tracks.expected(stamp, plan.segments())?;
        let layout = Layout::of::<R, N>();
        let clipped = Statistics::clipped(Data::of::<R>(samples), plan.codes);
        let zoom = lock.aim(expected, layout)?.zoom::<R, N>(samples);
        let tone = lock.measure(&zoom, expected, clipped, layout)?;
        let width = plan.options.width.of_block() * const { 1.0 / (N * N) as f32 };
        let sigma = (tone.sigma * tone.sigma + width).root();
        let tone = Tone { rate_hz: plan.rate_hz, sigma, ..tone };
        // A tone outside the gate belongs to another target.
        tracks.lead(stamp, &tone, &plan.tracking).then_some(())?;
        let result = self.pipeline.solve(stamp, tone);
        Some(Measurement { stamp: *stamp, clipped, tone, result })
    }

    /// Measures and searches the whole block.
    fn searched(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Measurement {
        let measurement = self.pipeline.block(stamp, samples);
        let pipeline = &self.pipeline;
        let (plan, measured) = (pipeline.plan(), pipeline.measured());
        let mut tones = Vec::<Tone, MOST>::new();
        if plan.tracking.most > 1 {
            let phasors = pipeline.lines(&measurement, plan.tracking.most);
            tones = first(phasors.iter().map(|phasor| phasor.tone));
        } else {
            // The list is empty, so there is room for one.
            let _ = tones.push(measurement.tone);
        }
        let find = |tone: &Tone, gate: f32| {
            let gate = bins(measured.view.layout, tone, gate, plan.band);
            let peak = peak::within(&measured.view, plan.band, gate)?;
            [plan.options.threshold, Threshold::new(gate.width(), HOLD)]
                .into_iter()
                .map(|threshold| {
                    measured.at(
                        stamp,
                        Data::of::<R>(samples),
                        measurement.clipped,
                        &peak,
                        threshold,
                    )
                })
                .zip([true, false])
                .find(|(tone, _)| tone.verdict.usable() < Usable::No)
        };
        let every = plan.segments();
        let sight = Sight { stamp, every, bin: 1.0 / N as f32, tones: &tones, find };
        if let Some(tracks) = self.tracks.get_mut(place(stamp.segment)) {
            tracks.step(sight, &plan.tracking);
        }
        measurement
    }

    /// The tracks of a segment, oldest first. Without chirps they are the tracks of all blocks.
    pub fn tracks(&self, segment: Segment) -> &[Track] {
        self.tracks.get(place(segment)).map_or(&[], Tracks::all)
    }

    /// The velocities of the held tracks, if the scene is a Doppler shift.
    pub fn velocities(&self) -> Vec<Velocity, MOST> {
        let Solver::Doppler(scale) = self.pipeline.plan().solver else {
            return Vec::new();
        };
        let held = self.tracks.first().into_iter().flat_map(Tracks::held);
        first(held.map(|track| doppler::velocity(&track.tone, scale)))
    }

    /// Whether a block with this stamp is the last of its chirp. [`Tracker::targets`] is complete
    /// then.
    pub fn completes(&self, stamp: &Stamp) -> bool {
        match self.pipeline.plan().solver {
            Solver::Chirp(Equations { shape: Shape::Sawtooth, .. }) => stamp.segment == Segment::Up,
            Solver::Chirp(_) => stamp.segment == Segment::Down,
            Solver::None | Solver::Doppler(_) => false,
        }
    }

    /// The targets computed from the held tracks, oldest first. Each comes with the low bits of the number of its rising beat's track.
    ///
    /// The lines of a chirp are those of the tracks, and each rising beat is a target's: see `solve::hypotheses`. Where the lines leave
    /// several targets for it, its verdict is [`Verdict::Ambiguous`](crate::Verdict::Ambiguous).
    pub fn targets(&self) -> Vec<(u16, Target), MOST> {
        let mut targets = Vec::new();
        let Solver::Chirp(equations) = &self.pipeline.plan().solver else {
            return targets;
        };
        let held = |tracks: &Tracks| first(tracks.held().map(|track| Line::from(track.tone)));
        let lines = self.tracks.each_ref().map(held);
        let [up, _, downs] = &lines;
        let numbers = self.tracks.iter().flat_map(Tracks::held).map(|track| track.number as u16);
        for (place, (number, rising)) in numbers.zip(up).enumerate() {
            if equations.shape == Shape::Sawtooth {
                let _ = targets.push((number, chirp::sawtooth(&rising.tone, R::IQ, equations)));
            } else if !downs.is_empty() {
                let target = solve(&lines, place, R::IQ, equations, None);
                // There is room: a target has one rising beat.
                let _ = targets.push((number, target));
            }
        }
        targets
    }
}

/// The index of a segment's tracks.
const fn place(segment: Segment) -> usize {
    match segment {
        Segment::Continuous | Segment::Up => 0,
        Segment::Flat => 1,
        Segment::Down => 2,
    }
}

/// The bins within `gate` cycles per sample of a tone, cut to the band.
fn bins(layout: &Layout, tone: &Tone, gate: f32, band: Band) -> Band {
    let n = layout.n as i32;
    let place = tone.frequency.bins(layout.n) as f32;
    let half = gate * n as f32;
    // The casts saturate, and a gate is only some bins wide.
    let (low, high) = (libm::floorf(place - half) as i32, libm::ceilf(place + half) as i32);
    // An I/Q band may count negative frequencies from 0 down or from N down.
    let turn = if layout.iq && high < band.low { n } else { 0 };
    Band {
        low: low.saturating_add(turn).max(band.low),
        high: high.saturating_add(turn).min(band.high),
        ..band
    }
}
