//! Frames of chirps, ranges by phase, ways and budgets: calls that know no kind or length of record.

use crate::memory::{Out, Slot, read, read_all, read_if};
use crate::status::Status;
use crate::types::{
    CBudget, CCalibration, CConfig, CDisplacement, CFrameTarget, CFraming, CLine, CPhaseRange,
    CScene, CStamp, CTarget, CUncertainty, Given, bounds,
};
use core::mem::size_of;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::frame::{Cells, Frame, FrameConfig, FramePlan, FrameTarget};
use picket_dsp::heapless::Vec;
use picket_dsp::num_complex::Complex;
use picket_dsp::solve::displacement::Unwrapper;
use picket_dsp::solve::phase_range::{Calibration, PhaseRanging};
use picket_dsp::solve::uncertainty::{Budget, Uncertainty};
use picket_dsp::spectrum::view::View;
use picket_dsp::{Chirp, Config, Scene, ToneWithPhase};

/// A frame in the caller's cells.
pub struct Framed(Frame<'static>);

/// What tells its memory from others: no length of a record is so short.
const FRAME: u16 = 1;
const WAY: u16 = 2;

/// A way.
pub struct Way(Unwrapper);

// `picket.h` reserves so much.
const _: () = assert!(size_of::<Slot<Framed>>() <= 256 && size_of::<Slot<Way>>() <= 128);

/// The chirp of a scene.
fn chirp(scene: &CScene) -> Result<Chirp, Status> {
    match scene.given()? {
        Scene::Chirp(chirp) => Ok(chirp),
        _ => Err(Status::Scene),
    }
}

/// A flag.
fn flag(value: u8) -> Result<bool, Status> {
    if value > 1 { Err(Status::Option) } else { Ok(value == 1) }
}

/// # Safety
/// What is not NULL points to what its type says.
unsafe fn plan(
    config: *const CConfig,
    scene: *const CScene,
    framing: *const CFraming,
    n: usize,
    iq: u8,
) -> Result<FramePlan, Status> {
    // SAFETY: as the caller promises.
    let (config, scene, framing) = unsafe { (read(config)?, read(scene)?, read(framing)?) };
    let known: Config = config.given()?;
    let &CFraming { period_s, false_alarm, chirps, first_bin, last_bin } = framing;
    let usual =
        FrameConfig::new(chirp(scene)?, known.rate_hz, n, flag(iq)?, chirps as usize, period_s);
    let [range_m, velocity_mps] = bounds(scene);
    let told = first_bin != 0 || last_bin != 0;
    let config = FrameConfig {
        bins: told.then_some((first_bin.into(), last_bin.into())),
        false_alarm: if false_alarm == 0.0 { usual.false_alarm } else { false_alarm },
        range_m,
        velocity_mps,
        ..usual
    };
    Ok(config.plan()?)
}

/// Bytes of a frame's memory.
#[unsafe(no_mangle)]
const extern "C" fn picket_frame_size() -> usize {
    size_of::<Slot<Framed>>()
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_frame_cells(
    config: *const CConfig,
    scene: *const CScene,
    framing: *const CFraming,
    n: usize,
    iq: u8,
    cells: *mut usize,
) -> i32 {
    let done = || {
        let cells = Out::at(cells)?;
        // SAFETY: as the header asks of the caller, here and below.
        unsafe { cells.put(plan(config, scene, framing, n, iq)?.cells()) };
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_frame_init(
    memory: *mut Slot<Framed>,
    config: *const CConfig,
    scene: *const CScene,
    framing: *const CFraming,
    n: usize,
    iq: u8,
    cells: *mut [i16; 2],
    room: usize,
) -> i32 {
    let done = || {
        let memory = Slot::place(memory)?;
        let cells = Out::at(cells)?;
        // SAFETY: as above; the cells are this frame's alone until its memory is written anew.
        unsafe {
            let plan = plan(config, scene, framing, n, iq)?;
            if room < plan.cells() {
                return Err(Status::Room);
            }
            let cells = cells.all(plan.cells());
            let frame = Frame::new(plan, Cells::Narrow(cells)).ok_or(Status::Room)?;
            Slot::write(memory, FRAME, Framed(frame));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// Takes the bins of the next chirp, of whose samples so many touch a rail.
///
/// # Safety
/// Pointers that are not NULL point to what their types say.
pub unsafe fn push(
    memory: *mut Slot<Framed>,
    (view, clipped): (&View<'_>, u32),
    complete: *mut u8,
) -> Result<(), Status> {
    // SAFETY: as the caller promises.
    unsafe {
        let Framed(frame) = Slot::open(memory, FRAME)?;
        let complete = Out::at(complete)?;
        let before = frame.filled();
        let whole = frame.push(view, clipped);
        // A chirp of another kind or length leaves a frame as it was.
        if !whole && frame.filled() == before {
            return Err(Status::Samples);
        }
        complete.put(whole.into());
    }
    Ok(())
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_frame_clear(memory: *mut Slot<Framed>) -> i32 {
    // SAFETY: as above.
    let done = unsafe { Slot::open(memory, FRAME) }.map(|Framed(frame)| frame.clear());
    Status::from(done) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_frame_background(
    memory: *mut Slot<Framed>,
    still: *mut Complex<f32>,
    room: usize,
    share: *mut f32,
) -> i32 {
    let done = || {
        // SAFETY: as above.
        unsafe {
            let Framed(frame) = Slot::open(memory, FRAME)?;
            let (still, share) = (Out::at(still)?, Out::at(share)?);
            let plan = *frame.plan();
            if room < plan.bins() {
                return Err(Status::Room);
            }
            if frame.filled() < plan.chirps() {
                return Err(Status::NoBlock);
            }
            share.put(frame.background(still.all(plan.bins())));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_frame_targets(
    memory: *mut Slot<Framed>,
    still: *const Complex<f32>,
    targets: *mut CFrameTarget,
    room: usize,
    found: *mut usize,
) -> i32 {
    let done = || {
        // SAFETY: as above.
        unsafe {
            let Framed(frame) = Slot::open(memory, FRAME)?;
            let (targets, found) = (Out::at(targets)?, Out::at(found)?);
            let plan = *frame.plan();
            if frame.filled() < plan.chirps() {
                return Err(Status::NoBlock);
            }
            let still = if still.is_null() { &[] } else { read_all(still, plan.bins())? };
            let all: Vec<FrameTarget, _> = frame.targets_beside(still);
            found.put(targets.put_all(room, all.iter().map(CFrameTarget::from_found)));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// The solver of ranges by phase.
///
/// # Safety
/// What is not NULL points to what its type says.
unsafe fn ranging(
    scene: *const CScene,
    calibration: *const CCalibration,
    (rate_hz, n, iq): (f64, usize, u8),
) -> Result<PhaseRanging, Status> {
    // SAFETY: as the caller promises.
    let (scene, told) = unsafe { (read(scene)?, read_if(calibration)?) };
    let known = told.map(Calibration::from).unwrap_or_default();
    Ok(PhaseRanging::new(&chirp(scene)?, rate_hz, n, flag(iq)?, known)?)
}

/// A line as the library has it.
fn phasor(line: &CLine, rate_hz: f64) -> Result<ToneWithPhase, Status> {
    line.phasor(rate_hz).ok_or(Status::Option)
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_range_by_phase(
    scene: *const CScene,
    calibration: *const CCalibration,
    rate_hz: f64,
    n: usize,
    iq: u8,
    segment: u8,
    line: *const CLine,
    target: *const CTarget,
    answer: *mut CPhaseRange,
) -> i32 {
    let done = || {
        let answer = Out::at(answer)?;
        let segment = Segment::from_u8(segment).ok_or(Status::Option)?;
        // SAFETY: as above.
        unsafe {
            let ranging = ranging(scene, calibration, (rate_hz, n, iq))?;
            let line = phasor(read(line)?, rate_hz)?;
            let seen = match read_if(target)? {
                None => ranging.at_rest(segment, &line),
                Some(target) => {
                    let target = target.solved().ok_or(Status::Option)?;
                    ranging.of_target(segment, &line, &target)
                }
            };
            answer.put(CPhaseRange::from_answer(&seen));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_range_by_phases(
    scene: *const CScene,
    calibration: *const CCalibration,
    rate_hz: f64,
    n: usize,
    iq: u8,
    up: *const CLine,
    down: *const CLine,
    target: *const CTarget,
    answer: *mut CPhaseRange,
) -> i32 {
    let done = || {
        let answer = Out::at(answer)?;
        // SAFETY: as above.
        unsafe {
            let ranging = ranging(scene, calibration, (rate_hz, n, iq))?;
            let (up, down) = (phasor(read(up)?, rate_hz)?, phasor(read(down)?, rate_hz)?);
            let target = read(target)?.solved().ok_or(Status::Option)?;
            answer.put(CPhaseRange::from_answer(&ranging.moving(&up, &down, &target)));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_calibrate(
    scene: *const CScene,
    rate_hz: f64,
    n: usize,
    iq: u8,
    line: *const CLine,
    known_m: f64,
    sigma_m: f32,
    calibration: *mut CCalibration,
) -> i32 {
    let done = || {
        let calibration = Out::at(calibration)?;
        if !(known_m.is_finite() && sigma_m >= 0.0) {
            return Err(Status::Option);
        }
        // SAFETY: as above.
        unsafe {
            let ranging = ranging(scene, core::ptr::null(), (rate_hz, n, iq))?;
            let line = phasor(read(line)?, rate_hz)?;
            let known = ranging.calibrate(&line, known_m, sigma_m).ok_or(Status::Unusable)?;
            calibration.put(CCalibration::from(&known));
        }
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// What is not NULL points to what its type says.
unsafe fn known(uncertainty: *const CUncertainty) -> Result<Uncertainty, Status> {
    // SAFETY: as the caller promises.
    let known = Uncertainty::from(unsafe { read(uncertainty)? });
    if known.is_valid() { Ok(known) } else { Err(Status::Option) }
}

/// Writes a budget of the mean of so many blocks.
///
/// # Safety
/// The memory is the caller's, and as large as a budget.
unsafe fn put(budget: Out<CBudget>, of: Budget, blocks: u32) -> Result<(), Status> {
    if blocks == 0 {
        return Err(Status::Option);
    }
    // SAFETY: as the caller promises.
    unsafe { budget.put(CBudget::from_budget(&of.of_mean(blocks))) };
    Ok(())
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_budget_of_target(
    uncertainty: *const CUncertainty,
    target: *const CTarget,
    angle_rad: f32,
    blocks: u32,
    budget: *mut CBudget,
) -> i32 {
    let done = || {
        let budget = Out::at(budget)?;
        // SAFETY: as above.
        unsafe {
            let known = known(uncertainty)?;
            let target = read(target)?.solved().ok_or(Status::Option)?;
            if !angle_rad.is_finite() {
                return Err(Status::Option);
            }
            put(budget, known.of_target(&target, angle_rad), blocks)
        }
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_budget_of_phase_range(
    uncertainty: *const CUncertainty,
    range: *const CPhaseRange,
    blocks: u32,
    budget: *mut CBudget,
) -> i32 {
    let done = || {
        let budget = Out::at(budget)?;
        // SAFETY: as above.
        unsafe {
            let (known, range) = (known(uncertainty)?, read(range)?);
            let target = CTarget {
                range_m: range.range_m,
                velocity_mps: range.velocity_mps,
                sigma_range_m: range.sigma_range_m,
                sigma_velocity_mps: range.sigma_velocity_mps,
                ..CTarget::default()
            };
            let target = target.solved().ok_or(Status::Option)?;
            let of = match flag(range.sure)? {
                true => known.of_range_by_phase(&target, 2.0 * range.spacing_m),
                false => known.of_target(&target, 0.0),
            };
            put(budget, of, blocks)
        }
    };
    Status::from(done()) as i32
}

/// Bytes of a way's memory.
#[unsafe(no_mangle)]
const extern "C" fn picket_way_size() -> usize {
    size_of::<Slot<Way>>()
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_way_init(
    memory: *mut Slot<Way>,
    scene: *const CScene,
    rate_hz: f64,
    n: usize,
    iq: u8,
    most_turns: f32,
) -> i32 {
    let done = || {
        let memory = Slot::place(memory)?;
        let (iq, most) = (flag(iq)?, if most_turns == 0.0 { 0.25 } else { most_turns });
        if !(most > 0.0 && most <= 0.25) {
            return Err(Status::Option);
        }
        // SAFETY: as above.
        let scene = unsafe { read(scene)? }.given()?;
        let way = Unwrapper::of_scene(&scene, rate_hz, n, iq, most)?;
        // SAFETY: `Slot::place` gave the memory.
        unsafe { Slot::write(memory, WAY, Way(way)) };
        Ok(())
    };
    Status::from(done()) as i32
}

/// # Safety
/// As the header says.
#[unsafe(no_mangle)]
unsafe extern "C" fn picket_way_push(
    memory: *mut Slot<Way>,
    stamp: *const CStamp,
    rate_hz: f64,
    line: *const CLine,
    answer: *mut CDisplacement,
) -> i32 {
    let done = || {
        // SAFETY: as above.
        unsafe {
            let Way(way) = Slot::open(memory, WAY)?;
            let answer = Out::at(answer)?;
            let (stamp, line) = (read(stamp)?.given()?, phasor(read(line)?, rate_hz)?);
            answer.put(CDisplacement::from_moved(&way.push(&stamp, &line)));
        }
        Ok(())
    };
    Status::from(done()) as i32
}
