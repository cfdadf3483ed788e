//! The pipeline with a memory: it follows tones from block to block and makes targets of them.
//!
//! Each segment of a chirp has a set of [`Track`]s, updated by the tones of its blocks. While the only tone is held, most blocks are
//! measured where it is expected ([`Lock`]), and only one in `refresh` is searched whole. The held tracks of a
//! chirp's segments are then combined to targets: each rising beat takes the flat and the falling beat that contradict it least.

use crate::acquire::sample::{Data, Record, Segment, Stamp, Statistics};
use crate::list::first;
use crate::math::scalar::Scalar as _;
use crate::pipeline::{Measured, Measurement, Pipeline, Ramps};
use crate::plan::{Plan, Solver, Terms};
use crate::solve::chirp::{self, Shape, Target};
use crate::solve::doppler::{self, Velocity};
use crate::solve::equations::Equations;
use crate::solve::hypotheses::solve;
use crate::solve::hypothesis::Line;
use crate::solve::track::Track;
use crate::solve::tracks::{TrackerBlock, Tracks};
use crate::spectrum::layout::Layout;
use crate::spectrum::peak::{self, Band};
use crate::spectrum::zoom::{Oscillator, Zoom};
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
    followed: Followed,
}

/// What is followed. Compiled once for all kinds and lengths of records.
#[derive(Clone, Debug)]
struct Followed {
    tracks: [Tracks; 3],
    /// At most one lock each: an idle tracker is zeros, which an `Option` would not be.
    locks: [Vec<Lock, 1>; 3],
}

/// A block in which a tone is followed.
struct Block<'a> {
    stamp: &'a Stamp,
    data: Data<'a>,
    layout: &'static Layout,
    terms: &'a Terms,
}

impl<R: Record, const N: usize> Tracker<R, N> {
    /// A tracker for this plan; [`Terms::tracking`](crate::plan::Terms::tracking) sets how it
    /// follows.
    pub const fn new(plan: Plan<R, N>) -> Self {
        Self { pipeline: Pipeline::new(plan), followed: Followed::new() }
    }

    /// Follows another plan from the next block on, and forgets all tracks.
    pub fn set_plan(&mut self, plan: Plan<R, N>) {
        self.pipeline.set_plan(plan);
        self.followed.tracks.iter_mut().for_each(|tracks| *tracks = Tracks::new());
        self.followed.locks.iter_mut().for_each(Vec::clear);
    }

    /// The pipeline. Its spectrum is that of the last block that was searched whole; a plan that follows no tones has all searched.
    pub const fn pipeline(&self) -> &Pipeline<R, N> {
        &self.pipeline
    }

    /// Whether the plan follows tones at all.
    pub fn follows(&self) -> bool {
        self.pipeline.plan().tracking.most > 0
    }

    /// Measures one block and updates the tracks of its segment. While the only tone is locked, it
    /// measures that tone where it is expected; otherwise it does what [`Pipeline::block`] does.
    /// With a plan that follows no tones, it is a pipeline.
    pub fn block(&mut self, stamp: &Stamp, samples: &[R::Sample; N]) -> Measurement {
        let follows = self.follows();
        let Self { pipeline, followed } = self;
        let (data, layout) = (Data::of::<R>(samples), Layout::of::<R, N>());
        let zoom = |oscillator: &Oscillator| oscillator.zoom::<R, N>(samples);
        let (terms, ramps) = pipeline.solver();
        let block = Block { stamp, data, layout, terms };
        if follows && let Some(measurement) = followed.locked(&block, ramps, &zoom) {
            return measurement;
        }
        let measurement = pipeline.block(stamp, samples);
        if follows {
            followed.search(data, &pipeline.measured(), &measurement);
        }
        measurement
    }

    /// Whether the last block of a segment was measured without a search.
    pub fn is_locked(&self, segment: Segment) -> bool {
        let lock = self.followed.locks.get(place(segment)).and_then(|lock| lock.first());
        lock.is_some_and(|lock| lock.age > 0)
    }

    /// The tracks of a segment, oldest first. Without chirps they are the tracks of all blocks.
    pub fn tracks(&self, segment: Segment) -> &[Track] {
        self.followed.tracks.get(place(segment)).map_or(&[], Tracks::all)
    }

    /// The velocities of the held tracks, if the scene is a Doppler shift.
    pub fn velocities(&self) -> Vec<Velocity, MOST> {
        let Solver::Doppler(scale) = self.pipeline.plan().solver else {
            return Vec::new();
        };
        let held = self.followed.tracks.first().into_iter().flat_map(Tracks::held);
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
        let lines = self.followed.tracks.each_ref().map(held);
        let [up, _, downs] = &lines;
        let numbers =
            self.followed.tracks.iter().flat_map(Tracks::held).map(|track| track.number as u16);
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

impl Followed {
    const fn new() -> Self {
        Self { tracks: [const { Tracks::new() }; 3], locks: [const { Vec::new() }; 3] }
    }

    /// Measures the locked tone without a search, in the zoom that the lock asks for; `None` if a search is due. A search is due when the
    /// lock is old or does not see its tone.
    fn locked(
        &mut self,
        block: &Block,
        ramps: &mut Ramps,
        zoom: &dyn Fn(&Oscillator) -> Zoom,
    ) -> Option<Measurement> {
        let &Block { stamp, data, layout, terms } = block;
        let segment = place(stamp.segment);
        let lock = self.locks.get_mut(segment)?.first_mut()?;
        let tracks = self.tracks.get_mut(segment)?;
        if lock.age.saturating_add(1) >= terms.tracking.refresh {
            return None;
        }
        let expected = tracks.expected(stamp, terms.segments())?;
        let clipped = Statistics::clipped(data, terms.codes);
        let zoom = zoom(lock.aim(expected, layout)?);
        let tone = lock.measure(&zoom, expected, clipped, layout)?;
        let bin_squared = f32::two_to(-2 * layout.bits() as i32);
        let width = terms.options.width.of_block() * bin_squared;
        let sigma = (tone.sigma * tone.sigma + width).root();
        let tone = Tone { rate_hz: terms.rate_hz, sigma, ..tone };
        // A tone outside the gate belongs to another target.
        tracks.lead(stamp, &tone, &terms.tracking).then_some(())?;
        let result = ramps.solve(&terms.solver, stamp, &[tone.into()], layout.iq);
        Some(Measurement { stamp: *stamp, clipped, tone, result })
    }

    /// Updates the tracks by a block that was measured and is searched whole.
    fn search(&mut self, data: Data, measured: &Measured, measurement: &Measurement) {
        let Measurement { stamp, clipped, tone, .. } = measurement;
        let (terms, layout) = (measured.terms, measured.view.layout);
        let mut tones = Vec::<Tone, MOST>::new();
        if terms.tracking.most > 1 {
            let phasors = measured.lines(measurement, terms.tracking.most);
            tones = first(phasors.iter().map(|phasor| phasor.tone));
        } else {
            // The list is empty, so there is room for one.
            let _ = tones.push(*tone);
        }
        let find = |tone: &Tone, gate: f32| {
            let gate = bins(layout, tone, gate, terms.band);
            let peak = peak::within(&measured.view, terms.band, gate)?;
            [terms.options.threshold, Threshold::new(gate.width(), HOLD)]
                .into_iter()
                .map(|threshold| measured.at(stamp, data, *clipped, &peak, threshold))
                .zip([true, false])
                .find(|(tone, _)| tone.verdict.usable() < Usable::No)
        };
        let bin = 1.0 / layout.n as f32;
        let sight = TrackerBlock { stamp, every: terms.segments(), bin, tones: &tones, find };
        let segment = place(stamp.segment);
        let (Some(tracks), Some(lock)) =
            (self.tracks.get_mut(segment), self.locks.get_mut(segment))
        else {
            return;
        };
        tracks.step(sight, &terms.tracking);
        let follow = terms.tracking.refresh > 1 && terms.tracking.most == 1;
        let tone = tracks.only().filter(|_| follow);
        let renewed = match (lock.first_mut(), tone) {
            (Some(lock), Some(tone)) => lock.renew(tone, layout),
            _ => false,
        };
        if !renewed {
            lock.clear();
            lock.extend(tone.and_then(|tone| Lock::on(tone, layout)));
        }
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
