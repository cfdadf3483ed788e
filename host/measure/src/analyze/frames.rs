//! Targets of a recording's frames of chirps.

use super::chirps::{Radar, Ramps};
use super::cut::Cut;
use super::told::Told;
use super::unfit::{Tally, Unfit};
use crate::follow::record;
use crate::recording::Recording;
use crate::simulate::Kind;
use crate::with_record;
use picket_dsp::Chirp;
use picket_dsp::acquire::sample::Segment;
use picket_dsp::frame::{ALIASES, CHIRPS, Cells, FREE_ALIASES, Frame, FrameConfig, FrameTarget};
use picket_dsp::solve::phase_range::PhaseRange;
use picket_dsp::solve::uncertainty::Budget;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::I32;
use picket_transform::num_complex::Complex;
use std::path::Path;

/// A target of a frame.
#[derive(Clone, Debug)]
pub struct Found {
    /// The frame's number, and that of its first chirp.
    pub frame: u64,
    /// The number of its first chirp.
    pub chirp: u64,
    /// The target.
    pub found: FrameTarget,
    /// The parts of its error, where what is not known of the radar was told.
    pub budget: Option<Budget>,
    /// Its range by phase, where that was asked for, and its error.
    pub phase: Option<(PhaseRange, Option<Budget>)>,
}

/// How the chirps of a recording lie in frames.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Chirps of a frame.
    pub chirps: usize,
    /// Chirps between pauses; what does not fill a frame before a pause is left out.
    pub together: u64,
    /// From one chirp to the next, s.
    pub period_s: f64,
}

/// The frames in a recording: of an array those that its sides count, of another one those that are told. `None` where each chirp is to be
/// measured by itself.
pub fn layout(recording: &Recording, radar: &Radar, told: &Told) -> Option<Layout> {
    let there = recording.frame().filter(|there| *there > 0);
    let rows = recording.row().and_then(|row| Some(recording.length()? / row.max(1)));
    let all = there.or(rows).unwrap_or(0);
    let fits = (all as usize).min(*CHIRPS.end()).checked_ilog2().map_or(0, |power| 1 << power);
    let chirps = told.chirps.unwrap_or(fits);
    let sawtooth = radar.shape == picket_dsp::Shape::Sawtooth;
    if !sawtooth || !CHIRPS.contains(&chirps) {
        return None;
    }
    Some(Layout {
        chirps,
        together: there.unwrap_or(u64::MAX),
        period_s: told.period_s.unwrap_or(radar.chirp_s),
    })
}

/// Measures every frame. Returns how many there are, and what was left out.
pub fn run(
    file: &Path,
    recording: Recording,
    cut: &Cut,
    (ramps, layout): (&Ramps, &Layout),
    radar: &Radar,
    told: &Told,
    sink: &mut dyn FnMut(Found),
) -> Result<Tally, String> {
    let chirp = radar.chirp(recording.rate_hz(), ramps, told);
    let chirps = layout.chirps as u64;
    if layout.together < chirps {
        let there = layout.together;
        return Err(format!("the recording has {there} chirps together: give fewer --chirps"));
    }
    let (row, ramp) = (recording.row().unwrap_or(0), radar.chirp_s * recording.rate_hz());
    if told.period_s.is_none() && row as f64 > ramp + 1.0 {
        return Err(format!(
            "a record has {row} samples and a ramp {ramp:.0}: chirps pause, and velocities need the time from one's start to the next's, --period-s"
        ));
    }
    let assumed = assumed(&recording, layout, ramps, (&chirp, radar), told);
    let assumed = format!("{}: {assumed}", crate::cli::name(file));
    with_record!(recording.iq(), ramps.n, R, N => frames::<R, N>(recording, cut, (ramps, layout, chirp, &assumed), radar, told, sink))
}

/// What the numbers rest on, in a line.
fn assumed(
    recording: &Recording,
    layout: &Layout,
    ramps: &Ramps,
    (chirp, radar): (&Chirp, &Radar),
    told: &Told,
) -> String {
    let period = match told.period_s {
        Some(_) => "",
        None => {
            ", which is the ramp without a pause, and velocities go with it (--period-s says otherwise)"
        }
    };
    let aliases = match radar.velocity_mps {
        Some(_) => String::new(),
        None => format!(
            "; velocities are weighed at {FREE_ALIASES} aliases, {:.4} m/s apart, and odds are among these (--velocity-mps says otherwise)",
            alias_mps(chirp, layout)
        ),
    };
    let named = |is_told: bool, option: &str| match is_told {
        true => String::new(),
        false => format!(" ({option} says otherwise)"),
    };
    let left = match layout.together % layout.chirps as u64 {
        left @ 1.. if layout.together < u64::MAX => format!(", the last {left} are left out"),
        _ => String::new(),
    };
    format!(
        "{}{} chirps a frame{left}; one each {:.6} us{}; {} samples of a chirp, from {:.3} us into its ramp{}{aliases}",
        recording.assumed().map_or(String::new(), |assumed| assumed + "; "),
        layout.chirps,
        1e6 * layout.period_s,
        period,
        ramps.n,
        1e6 * chirp.guard_s,
        named(told.guard_s.is_some(), "--guard-s"),
    )
}

/// From one alias of a velocity to the next: half a wavelength in a period.
fn alias_mps(chirp: &Chirp, layout: &Layout) -> f64 {
    0.5 * chirp.wavelength_m / layout.period_s
}

fn frames<R: Kind, const N: usize>(
    recording: Recording,
    cut: &Cut,
    (ramps, layout, chirp, assumed): (&Ramps, &Layout, Chirp, &str),
    radar: &Radar,
    told: &Told,
    sink: &mut dyn FnMut(Found),
) -> Result<Tally, String> {
    let rate_hz = recording.rate_hz();
    let text = |error: picket_dsp::ConfigError| error.to_string();
    let usual = FrameConfig::new(chirp, rate_hz, N, R::IQ, layout.chirps, layout.period_s);
    let config = FrameConfig {
        bins: cut.band_hz.map(|band| bins(band, rate_hz, N, R::IQ)),
        false_alarm: radar.false_alarm.unwrap_or(usual.false_alarm),
        range_m: told.range_m,
        velocity_mps: radar.velocity_mps,
        ..usual
    };
    let alias_mps = alias_mps(&chirp, layout);
    if let Some((low, high)) = config.velocity_mps
        && high - low > ALIASES as f64 * alias_mps
    {
        let held = (high - low) / alias_mps;
        return Err(format!(
            "these velocities hold {held:.0} aliases, and at most {ALIASES} are weighed: narrow --velocity-mps, or shorten the period"
        ));
    }
    let plan = config.plan().map_err(text)?;
    let mut cells = vec![[0i32; 2]; plan.cells()];
    let mut frame = Frame::new(plan, Cells::Wide(&mut cells)).ok_or("too few cells")?;
    let ranging = told.ranging(&chirp, rate_hz, N, R::IQ)?;
    eprintln!("{assumed}");
    let mut spectrum = Box::new(Spectrum::<R, N, I32>::new());
    let mut blocks = recording.blocks(N, ramps.hop, cut.skip + ramps.skip as u64);
    let mut tally = Tally::default();
    let (mut number, mut gaps, chirps) = (0u64, 0u64, layout.chirps as u64);
    let (mut beyond, mut quiet, mut missing) = (false, true, false);
    while let Some((_, samples)) = blocks.next_block().map_err(super::text)? {
        let place = number % layout.together;
        let chirp = number - place % chirps;
        number += 1;
        if place - place % chirps + chirps > layout.together {
            continue;
        }
        if place % chirps == 0 {
            frame.clear();
            (beyond, quiet, missing) = (false, true, false);
        }
        let unfit = Unfit::of(samples, cut.codes);
        let values: Vec<Complex<f64>> = samples.iter().map(|sample| sample.value).collect();
        (beyond, quiet) =
            (beyond | (unfit == Some(Unfit::Beyond)), quiet & (unfit == Some(Unfit::Quiet)));
        missing |= blocks.missing() > 0;
        spectrum.transform(&record::<R, N>(&values), cut.codes);
        if !frame.push(&spectrum.view()) {
            continue;
        }
        let unfit = beyond.then_some(Unfit::Beyond).or(quiet.then_some(Unfit::Quiet));
        let at = tally.blocks;
        tally.add(unfit);
        gaps += u64::from(missing);
        if missing || unfit.is_some() {
            continue;
        }
        for found in &frame.targets() {
            let uncertainty = told.uncertainty.as_ref();
            let budget = |known: &picket_dsp::solve::uncertainty::Uncertainty| {
                known.of_target(&found.target, 0.0)
            };
            let phase = ranging.as_ref().map(|ranging| {
                let answer = ranging.of_target(Segment::Up, &found.line, &found.target);
                let wavelength_m = 2.0 * answer.spacing();
                (answer, uncertainty.map(|known| known.of_phase_range(&answer, wavelength_m)))
            });
            let budget = uncertainty.map(budget);
            sink(Found { frame: at, chirp, found: *found, budget, phase });
        }
    }
    tally.check(cut.codes)?;
    if gaps > 0 {
        eprintln!("{gaps} of {} frames are left out: samples are missing in them", tally.blocks);
    }
    if tally.blocks == 0 {
        return Err(format!(
            "the recording has {number} chirps, and a frame {chirps}: give fewer --chirps"
        ));
    }
    Ok(tally)
}

/// The bins of a band, as far as a record has them.
fn bins((low, high): (f64, f64), rate_hz: f64, n: usize, iq: bool) -> (i32, i32) {
    let (bin, half) = (|hz: f64| hz / rate_hz * n as f64, n as i32 / 2);
    let least = if iq { -half } else { 1 };
    (least.max(bin(low).floor() as i32), (half - 1).min(bin(high).ceil() as i32))
}
