//! Frames of chirps of a recording: their targets, and the map that these are in.

use crate::answer::Answer;
use crate::file::{on_the_page, sentence};
use crate::radar::{Layout, Radar};
use crate::settings::{Kind, Settings};
use crate::station::Station;
use crate::unfit::{Tally, Unfit};
use picket_dsp::Shape;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Stamp;
use picket_dsp::frame::{Cells, Filled, Frame, FramePlan, FrameTarget};
use picket_dsp::num_complex::Complex;
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_recording::{Blocks, Recording, Sample};
use picket_wire::view;

/// The last frame: what its cells hold, its number, and that of its first chirp.
#[derive(Clone, Copy)]
struct Last {
    filled: Filled,
    number: u64,
    first: u64,
}

/// What is subtracted from frames.
#[derive(Clone, Debug)]
pub struct Background {
    /// A number for each bin.
    still: Vec<Complex<f32>>,
    /// Its share of the power of the frame that it was recorded of.
    share: f64,
}

impl Background {
    /// Nothing.
    pub const NONE: Self = Self { still: Vec::new(), share: f64::NAN };
}

/// A recording of frames, and what measures them.
pub struct Frames {
    blocks: Blocks,
    station: Station,
    plan: FramePlan,
    layout: Layout,
    codes: Codes,
    cells: Vec<[i32; 2]>,
    /// The cells of the last frame.
    shown: Vec<[i32; 2]>,
    last: Option<Last>,
    background: Background,
    /// What was assumed, in a line.
    pub assumed: String,
    /// Chirps that were read.
    chirps: u64,
    tally: Tally,
    /// The map of the last frame, see [`Frames::map`].
    map: Vec<f64>,
}

impl Frames {
    /// The frames of a recording, if the settings tell of the radar and the recording of its rate; else the recording again.
    ///
    /// # Errors
    /// In a sentence: the ramps do not fit the recording.
    pub fn of(
        recording: Recording,
        settings: &mut Settings,
    ) -> Result<Result<Self, Recording>, String> {
        let radar = Radar {
            shape: Shape::Sawtooth,
            carrier_hz: settings.carrier_hz,
            bandwidth_hz: settings.file_bandwidth_hz,
            chirp_s: settings.chirp_s,
            mixing: settings.mixing.unwrap_or_default(),
            velocity_mps: (settings.velocity_mps != (0.0, 0.0)).then_some(settings.velocity_mps),
            effort: picket_dsp::Effort::default(),
            false_alarm: None,
        };
        let told = [radar.carrier_hz, radar.bandwidth_hz, radar.chirp_s];
        if !recording.knows_rate() || told.iter().any(|it| !(it.is_finite() && *it > 0.0)) {
            return Ok(Err(recording));
        }
        let given = |x: f64| (x > 0.0).then_some(x);
        let period_s = given(settings.period_s);
        let guard_s = given(settings.guard_s);
        let chirps = (settings.chirps > 0).then_some(settings.chirps);
        let (rate_hz, iq) = (recording.rate_hz(), recording.iq());
        let ramps =
            radar.ramps(&recording, None, period_s, false).map_err(|error| told_so(&error))?;
        radar.check_period(&recording, period_s).map_err(|error| told_so(&error))?;
        let layout = radar.layout(&recording, chirps, period_s).ok_or(
            "There are fewer than 8 chirps in a frame: type under Chirps how many make one, 8, 16, ... 256.",
        )?;
        if layout.together < layout.chirps as u64 {
            let together = layout.together;
            return Err(format!(
                "The recording has {together} chirps together: choose fewer under Chirps."
            ));
        }
        let chirp = radar.chirp(rate_hz, &ramps, guard_s, 0.0);
        let plan = radar
            .plan(rate_hz, (ramps.n, iq), &chirp, &layout, None, None)
            .map_err(|error| told_so(&error))?;
        let assumed = layout.assumed(
            &recording,
            &ramps,
            &chirp,
            [period_s.is_some(), guard_s.is_some(), radar.velocity_mps.is_some()],
        );
        (settings.rate_hz, settings.iq, settings.n) = (rate_hz, iq, ramps.n);
        (settings.kind, settings.sum) = (Kind::Tone, 1);
        let station = Station::new(&Settings { band_hz: (0.0, 0.0), ..*settings })?;
        let blocks = recording.blocks(ramps.n, ramps.hop, ramps.skip as u64);
        Ok(Ok(Frames {
            blocks,
            station,
            plan,
            layout,
            codes: settings.codes,
            cells: vec![[0; 2]; plan.cells()],
            shown: vec![[0; 2]; plan.cells()],
            last: None,
            background: Background::NONE,
            assumed: on_the_page(&assumed),
            chirps: 0,
            tally: Tally::default(),
            map: Vec::new(),
        }))
    }

    /// The targets of the next frame, the strongest first; `None` at the end.
    ///
    /// # Errors
    /// The recording is damaged from here on, or none of its frames fits the codes.
    pub fn next_frame(&mut self) -> Result<Option<Vec<Answer>>, String> {
        let name = self.blocks.recording().path().display().to_string();
        let (chirps, together) = (self.layout.chirps as u64, self.layout.together);
        let cells = Cells::Wide(&mut self.cells);
        let mut frame = Frame::new(self.plan, cells).ok_or("There is no memory for a frame.")?;
        let (mut beyond, mut quiet, mut missing) = (false, true, false);
        loop {
            let block = self.blocks.next_block().map_err(|error| sentence(&name, &error))?;
            let Some((_, samples)) = block else {
                return match (self.tally.blocks, self.tally.left_out()) {
                    (0, _) => Err(format!(
                        "{name} has {} chirps, and a frame {chirps}: choose fewer under Chirps.",
                        self.chirps
                    )),
                    (all, left) if all == left => Err(self.tally.sentence(self.codes)),
                    _ => Ok(None),
                };
            };
            let place = self.chirps % together;
            self.chirps += 1;
            if place - place % chirps + chirps > together {
                continue;
            }
            if place.is_multiple_of(chirps) {
                frame.clear();
                (beyond, quiet, missing) = (false, true, false);
            }
            let unfit = Unfit::of(samples, self.codes);
            beyond |= unfit == Some(Unfit::Beyond);
            quiet &= unfit == Some(Unfit::Quiet);
            let record: Vec<[i16; 2]> = samples.iter().map(Sample::code).collect();
            missing |= self.blocks.missing() > 0;
            let (clipped, view) = self.station.view(&record);
            if !frame.push(&view, clipped) {
                continue;
            }
            let unfit = beyond.then_some(Unfit::Beyond).or(quiet.then_some(Unfit::Quiet));
            let number = self.tally.blocks;
            self.tally.add(unfit);
            if missing || unfit.is_some() {
                continue;
            }
            let (filled, first) = (frame.so_far(), self.chirps - chirps);
            self.last = Some(Last { filled, number, first });
            std::mem::swap(&mut self.cells, &mut self.shown);
            return Ok(Some(self.measure()));
        }
    }

    /// What stands still in the last frame.
    pub fn still(&mut self) -> Background {
        let Some(frame) = self.last_frame() else { return Background::NONE };
        let mut still = vec![Complex::new(0.0, 0.0); frame.plan().bins()];
        let share = frame.background(&mut still).into();
        Background { still, share }
    }

    /// Subtracts this from now on. Gives the targets of the last frame anew.
    pub fn subtract(&mut self, background: Background) -> Vec<Answer> {
        self.background = background;
        self.measure()
    }

    fn last_frame(&mut self) -> Option<Frame<'_>> {
        Frame::resume(self.plan, Cells::Wide(&mut self.shown), self.last?.filled)
    }

    /// The targets of the last frame and its map.
    fn measure(&mut self) -> Vec<Answer> {
        let Some(Last { number, first, .. }) = self.last else { return Vec::new() };
        let background = std::mem::replace(&mut self.background, Background::NONE);
        let Some(frame) = self.last_frame() else { return Vec::new() };
        let targets = frame.targets_beside(&background.still);
        self.map = map(&frame, number, &background, &targets);
        self.background = background;
        let time_s = (first as f64 + 0.5 * self.plan.chirps() as f64) * self.layout.period_s;
        let answer = |found: &FrameTarget| {
            let stamp = Stamp { sequence: number as u32, clock: first, ..Stamp::default() };
            let (tone, result) = (found.line.tone, Outcome::Target(found.target));
            let measurement = Measurement { stamp, clipped: 0, tone, result };
            Answer { time_s, ..self.station.answer(&measurement) }
        };
        targets.iter().map(answer).collect()
    }

    /// The map of the last frame: the frame's number, chirps and bins; the range of the first bin at rest and from bin to bin, m; the velocity of the first
    /// row and from row to row, m/s; what the range of a place grows by for a m/s; the share of the background's power, NaN where none is subtracted; the number of targets. Of each target: range, its sigma, velocity, its
    /// sigma, their covariance, range and velocity in the map, signal-to-noise ratio in dB, verdict, and of the number of aliases the velocity and the odds
    /// each. Then the powers in dB of a code, row by row; a board does not tell them.
    pub fn map(&self) -> &[f64] {
        &self.map
    }
}

fn told_so(error: &str) -> String {
    format!("This cannot work: {}.", on_the_page(error))
}

/// See [`Frames::map`].
fn map(
    frame: &Frame<'_>,
    number: u64,
    background: &Background,
    targets: &[FrameTarget],
) -> Vec<f64> {
    let plan = frame.plan();
    let (bins, chirps, first) = (plan.bins(), plan.chirps(), plan.first());
    let mut numbers = places(plan, number as f64, background.share, targets);
    let mut powers = vec![0.0f32; bins * chirps];
    for bin in 0..bins {
        let mut column = vec![0.0; chirps];
        frame.powers_beside(&background.still, first + bin as i32, &mut column);
        for (row, power) in column.iter().enumerate() {
            powers[row * bins + bin] = *power;
        }
    }
    let decibels = |power: &f32| 10.0 * libm::log10(f64::from(*power) + 1e-20);
    numbers.extend(powers.iter().map(decibels));
    numbers
}

/// [`Frames::map`] without the powers.
pub fn places(plan: &FramePlan, number: f64, share: f64, targets: &[FrameTarget]) -> Vec<f64> {
    let (bins, chirps, first) = (plan.bins(), plan.chirps(), plan.first());
    let half = chirps as f32 / 2.0;
    let cell = |bin: f32, row: f32| plan.cell(bin, row).map(f64::from);
    let [origin, slowest] = [cell(first as f32, 0.0)[0], cell(0.0, -half)[1]];
    let [range_step, velocity_step] = [cell(1.0, 0.0)[0], cell(0.0, 1.0)[1]];
    let shift = cell(0.0, 1.0)[0] / velocity_step;
    let mut numbers = vec![number, chirps as f64, bins as f64];
    numbers.extend([
        origin,
        range_step,
        slowest,
        velocity_step,
        shift,
        share,
        targets.len() as f64,
    ]);
    for found in targets {
        let view::FrameTarget { target, covariance, .. } = view::FrameTarget::from_found(found);
        // Where its beat and its turns are: aliases are one place.
        let span = velocity_step * chirps as f64;
        let turns = (target.velocity_mps / span + 0.5).rem_euclid(1.0) - 0.5;
        let beat = found.line.tone.frequency.cycles() * plan.record() as f64;
        let [range_m, velocity_mps] = cell(beat as f32, (turns * chirps as f64) as f32);
        numbers.extend([target.range_m, target.sigma_range_m.into(), target.velocity_mps]);
        numbers.extend([
            target.sigma_velocity_mps.into(),
            covariance.into(),
            range_m,
            velocity_mps,
        ]);
        numbers.extend([f64::from(found.line.tone.snr_db()), target.verdict.into()]);
        numbers.push(target.count.into());
        for candidate in target.candidates.iter().take(usize::from(target.count)) {
            numbers.extend([candidate.velocity_mps, candidate.odds]);
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file;
    use std::f64::consts::TAU;

    const RATE_HZ: f64 = 2.56e6;
    const SPEED_OF_LIGHT: f64 = 299_792_458.0;

    /// An array of chirps in front of targets of such ranges, velocities and amplitudes, by the phase that the transmitter had when an echo left.
    fn array(chirps: usize, targets: &[[f64; 3]]) -> Vec<u8> {
        let mut state = 1u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 655.36 - 50.0
        };
        let part = |index: usize, of: fn(f64) -> f64| {
            let (chirp, n) = (index / 256, index % 256);
            let t = 2e-6 + n as f64 / RATE_HZ;
            let echo = |&[range_m, velocity_mps, amplitude]: &[f64; 3]| {
                let tau =
                    2.0 * (range_m - velocity_mps * (t + chirp as f64 * 120e-6)) / SPEED_OF_LIGHT;
                amplitude * of(TAU * tau * (77e9 + 3e12 * (t - 0.5 * tau)))
            };
            targets.iter().map(echo).sum::<f64>()
        };
        let mut bytes = b"\x93NUMPY\x01\x00\x4e\x00".to_vec();
        let header =
            format!("{{'descr': '<c8', 'fortran_order': False, 'shape': ({chirps}, 256), }}");
        bytes.extend(format!("{header:<77}\n").bytes());
        let parts =
            (0..256 * chirps).flat_map(|index| [part(index, f64::cos), part(index, f64::sin)]);
        bytes.extend(parts.flat_map(|part| ((part + noise()) as f32).to_le_bytes()));
        bytes
    }

    /// The frames of such an array, 32 chirps each, and the codes of a unit of it.
    fn frames(bytes: Vec<u8>) -> (Frames, f64) {
        let mut settings = Settings { file_rate_hz: RATE_HZ, ..Settings::default() };
        assert!(settings.set("bits", 16.0));
        let recording = file::recording("cube.npy", bytes, &settings).unwrap();
        let factor = recording.scaling().factor;
        let Err(recording) = Frames::of(recording, &mut settings).unwrap() else {
            panic!("nothing tells of the radar")
        };
        for (name, value) in [
            ("carrier_hz", 77e9),
            ("file_bandwidth_hz", 306e6),
            ("chirp_s", 102e-6),
            ("guard_s", 2e-6),
            ("period_s", 120e-6),
            ("chirps", 32.0),
            ("velocity_low_mps", -8.0),
            ("velocity_high_mps", 8.0),
        ] {
            assert!(settings.set(name, value));
        }
        let Ok(frames) = Frames::of(recording, &mut settings).unwrap() else {
            panic!("it is a frame")
        };
        (frames, factor)
    }

    /// Once the background is recorded, what stands still is no target, in the same frame and in the next ones, and its row of the map is as the
    /// others; without it all is as before.
    #[test]
    fn what_stands_still_is_subtracted() {
        let (mut frames, _) = frames(array(96, &[[12.0, 0.0, 400.0], [18.0, 3.0, 60.0]]));
        let first = frames.next_frame().unwrap().unwrap();
        assert_eq!(first.len(), 2, "{first:?}");
        let map = frames.map().to_vec();
        let background = frames.still();
        let beside = frames.subtract(background);
        let share = frames.map()[8];
        assert!((0.8..1.0).contains(&share), "{share}");
        let rest = |answers: &[Answer], block: f64| {
            assert_eq!(answers.len(), 1, "{answers:?}");
            let off = (answers[0].velocity_mps - 3.0) / answers[0].sigma_velocity_mps;
            assert!(answers[0].block == block && off.abs() < 5.0, "{answers:?}");
        };
        rest(&beside, 0.0);
        let still = |map: &[f64]| {
            let (bins, targets) = (map[2] as usize, map[9] as usize);
            let powers = &map[10 + 10 * targets..];
            powers[16 * bins..17 * bins].iter().copied().fold(f64::MIN, f64::max)
        };
        assert!(still(&map) - still(frames.map()) > 40.0);
        rest(&frames.next_frame().unwrap().unwrap(), 1.0);
        let again = frames.subtract(Background::NONE);
        assert!(again.len() == 2 && frames.map()[8].is_nan(), "{again:?}");
        let background = frames.still();
        frames.subtract(background);
        rest(&frames.next_frame().unwrap().unwrap(), 2.0);
        // At the end the last frame is still there.
        assert!(frames.next_frame().unwrap().is_none());
        let background = frames.still();
        rest(&frames.subtract(background), 2.0);
        let all = frames.subtract(Background::NONE);
        assert!(all.len() == 2 && all[0].block == 2.0, "{all:?}");
    }

    /// The brightest cell of the map is where its target is drawn, though the target's range is where it is without its Doppler shift; without
    /// the radar's numbers the recording is given back.
    #[test]
    fn a_target_is_drawn_on_its_cell() {
        for (range_m, velocity_mps) in [(18.0, 3.0), (7.3, -6.4), (41.2, 5.1)] {
            let (mut frames, factor) = frames(array(32, &[[range_m, velocity_mps, 100.0]]));
            let targets = frames.next_frame().unwrap().unwrap();
            assert_eq!(targets.len(), 1, "{targets:?}");
            let middle_s = 15.5 * 120e-6 + 2e-6 + 127.5 / RATE_HZ;
            let far = (targets[0].range_m - (range_m - velocity_mps * middle_s))
                / targets[0].sigma_range_m;
            let fast = (targets[0].velocity_mps - velocity_mps) / targets[0].sigma_velocity_mps;
            assert!(far.abs() < 5.0 && fast.abs() < 5.0, "{far} {fast}");
            let &[0.0, 32.0, bins, range, range_step, speed, speed_step, shift, share, 1.0, ..] =
                frames.map()
            else {
                panic!("one frame, one target")
            };
            let &[.., map_m, map_mps, _, verdict, aliases] = &frames.map()[10..20] else {
                panic!()
            };
            assert_eq!((verdict, aliases, share.is_nan()), (0.0, 0.0, true));
            let powers = &frames.map()[20..];
            assert_eq!(powers.len(), 32 * bins as usize);
            let brightest =
                (0..powers.len()).max_by(|&a, &b| powers[a].total_cmp(&powers[b])).unwrap();
            let (row, bin) = (brightest / bins as usize, brightest % bins as usize);
            let velocity = speed + row as f64 * speed_step;
            let off_rows = (map_mps - velocity) / speed_step;
            let off_bins =
                (map_m - (range + bin as f64 * range_step + shift * velocity)) / range_step;
            assert!(off_rows.abs() < 0.6 && off_bins.abs() < 0.6, "{off_rows} {off_bins}");
            // 100 of the file's numbers, 8192 samples, of which a cell loses at most 4 dB in each direction.
            let most = 20.0 * (100.0 * factor * 8192.0).log10();
            assert!((most - 8.0..most + 0.3).contains(&powers[brightest]), "{}", powers[brightest]);
            assert!(frames.next_frame().unwrap().is_none());
        }
    }
}
