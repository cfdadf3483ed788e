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
use picket_dsp::frame::{Cells, Frame, FramePlan, FrameTarget};
use picket_dsp::pipeline::{Measurement, Outcome};
use picket_recording::{Blocks, Recording, Sample};
use picket_wire::view;

/// A recording of frames, and what measures them.
pub struct Frames {
    blocks: Blocks,
    station: Station,
    plan: FramePlan,
    layout: Layout,
    codes: Codes,
    cells: Vec<[i32; 2]>,
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
            let first = self.chirps - chirps;
            let targets = frame.targets();
            self.map = map(&frame, number, &targets);
            let time_s = (first as f64 + 0.5 * chirps as f64) * self.layout.period_s;
            let answer = |found: &FrameTarget| {
                let stamp = Stamp { sequence: number as u32, clock: first, ..Stamp::default() };
                let (tone, result) = (found.line.tone, Outcome::Target(found.target));
                let measurement = Measurement { stamp, clipped: 0, tone, result };
                Answer { time_s, ..self.station.answer(&measurement) }
            };
            return Ok(Some(targets.iter().map(answer).collect()));
        }
    }

    /// The map of the last frame: the frame's number, chirps and bins; the range of the first bin at rest and from bin to bin, m; the velocity of the first
    /// row and from row to row, m/s; what the range of a place grows by for a m/s; the number of targets. Of each target: range, its sigma, velocity, its
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
fn map(frame: &Frame<'_>, number: u64, targets: &[FrameTarget]) -> Vec<f64> {
    let plan = frame.plan();
    let (bins, chirps, first) = (plan.bins(), plan.chirps(), plan.first());
    let mut numbers = places(plan, number as f64, targets);
    let mut powers = vec![0.0f32; bins * chirps];
    for bin in 0..bins {
        let mut column = vec![0.0; chirps];
        frame.powers(first + bin as i32, &mut column);
        for (row, power) in column.iter().enumerate() {
            powers[row * bins + bin] = *power;
        }
    }
    let decibels = |power: &f32| 10.0 * libm::log10(f64::from(*power) + 1e-20);
    numbers.extend(powers.iter().map(decibels));
    numbers
}

/// [`Frames::map`] without the powers.
pub fn places(plan: &FramePlan, number: f64, targets: &[FrameTarget]) -> Vec<f64> {
    let (bins, chirps, first) = (plan.bins(), plan.chirps(), plan.first());
    let half = chirps as f32 / 2.0;
    let cell = |bin: f32, row: f32| plan.cell(bin, row).map(f64::from);
    let [origin, slowest] = [cell(first as f32, 0.0)[0], cell(0.0, -half)[1]];
    let [range_step, velocity_step] = [cell(1.0, 0.0)[0], cell(0.0, 1.0)[1]];
    let shift = cell(0.0, 1.0)[0] / velocity_step;
    let mut numbers = vec![number, chirps as f64, bins as f64];
    numbers.extend([origin, range_step, slowest, velocity_step, shift, targets.len() as f64]);
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

    /// An array of chirps in front of a target, by the phase that the transmitter had when its echo left.
    fn array(chirps: usize, range_m: f64, velocity_mps: f64) -> Vec<u8> {
        let mut state = 1u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 655.36 - 50.0
        };
        let sample = |index: usize| {
            let (chirp, n) = (index / 256, index % 256);
            let t = 2e-6 + n as f64 / RATE_HZ;
            let tau = 2.0 * (range_m - velocity_mps * (t + chirp as f64 * 120e-6)) / SPEED_OF_LIGHT;
            TAU * tau * (77e9 + 3e12 * (t - 0.5 * tau))
        };
        let mut bytes = b"\x93NUMPY\x01\x00\x4e\x00".to_vec();
        let header =
            format!("{{'descr': '<c8', 'fortran_order': False, 'shape': ({chirps}, 256), }}");
        bytes.extend(format!("{header:<77}\n").bytes());
        let parts = (0..256 * chirps).map(sample).flat_map(|phase| [phase.cos(), phase.sin()]);
        bytes.extend(parts.flat_map(|part| ((100.0 * part + noise()) as f32).to_le_bytes()));
        bytes
    }

    /// The brightest cell of the map is where its target is drawn, though the target's range is where it is without its Doppler shift; without
    /// the radar's numbers the recording is given back.
    #[test]
    fn a_target_is_drawn_on_its_cell() {
        for (range_m, velocity_mps) in [(18.0, 3.0), (7.3, -6.4), (41.2, 5.1)] {
            let bytes = array(32, range_m, velocity_mps);
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
                ("velocity_low_mps", -8.0),
                ("velocity_high_mps", 8.0),
            ] {
                assert!(settings.set(name, value));
            }
            let Ok(mut frames) = Frames::of(recording, &mut settings).unwrap() else {
                panic!("it is a frame")
            };
            let targets = frames.next_frame().unwrap().unwrap();
            assert_eq!(targets.len(), 1, "{targets:?}");
            let middle_s = 15.5 * 120e-6 + 2e-6 + 127.5 / RATE_HZ;
            let far = (targets[0].range_m - (range_m - velocity_mps * middle_s))
                / targets[0].sigma_range_m;
            let fast = (targets[0].velocity_mps - velocity_mps) / targets[0].sigma_velocity_mps;
            assert!(far.abs() < 5.0 && fast.abs() < 5.0, "{far} {fast}");
            let &[0.0, 32.0, bins, range, range_step, speed, speed_step, shift, 1.0, ..] =
                frames.map()
            else {
                panic!("one frame, one target")
            };
            let &[.., map_m, map_mps, _, verdict, aliases] = &frames.map()[9..19] else { panic!() };
            assert_eq!((verdict, aliases), (0.0, 0.0));
            let powers = &frames.map()[19..];
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
