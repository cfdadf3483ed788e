//! The board's sample clock against this machine's clock, by the arrivals of its records.

use super::Style;
use super::settings::{from_answer, with_clock};
use crate::device::Said;
use picket_dsp::acquire::rate_check::{ClockError, RateCheck, WINDOWS};
use picket_wire::settings::{Calibration, Drive, Settings};
use std::time::Duration;

/// Ticks of this machine's clock in a second.
const TICKS_HZ: f64 = 1e6;
/// The fewest records with an answer: at least half the windows hold one then.
const FEWEST: usize = WINDOWS;
/// The shortest time with an answer: a wrong rate is told within five seconds.
const SHORTEST: Duration = Duration::from_secs(4);
/// The time between two answers.
const PERIOD: Duration = Duration::from_millis(500);
/// The sigma with which the clock is known well enough to be set, parts per million.
const KNOWN_PPM: f32 = 1.0;
/// The rate is wrong beyond what a board lets its owner correct: no crystal is as far off.
const TOLERANCE_PPM: f32 = Calibration::MOST_PPM;
/// The longest delay that a busy machine is taken to cause, s: one that ends or begins looks like a wrong rate until it is small beside the
/// time.
const DELAY_S: f32 = 0.5;

/// What is told of a clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Told {
    /// The error is known well enough.
    Known(ClockError),
    /// The rate is not the stated one.
    Wrong(ClockError),
}

/// Compares the clocks.
#[derive(Debug, Default)]
pub struct HostClock {
    settings: Option<(Settings, usize)>,
    running: Option<Running>,
}

/// A comparison since the board was opened or restarted.
#[derive(Debug)]
struct Running {
    check: RateCheck,
    rate_hz: f64,
    /// The clock of the last record.
    clock: u64,
    records: usize,
    begun: Duration,
    /// When the error is computed next.
    due: Duration,
    told: [bool; 2],
    /// The rate is wrong, by the last comparison.
    wrong: bool,
}

impl HostClock {
    /// The samples are counted from another start.
    pub fn restart(&mut self) {
        self.running = None;
    }

    /// Takes what is said, and when it arrived; `rate_of` is the sample rate of a block, if it is known. Gives what is to be told.
    pub fn hear(
        &mut self,
        said: &Said,
        rate_of: impl Fn(u32) -> Option<f64>,
        at: Duration,
    ) -> Option<Told> {
        match said {
            Said::Boot(_) => (self.settings, self.running) = (None, None),
            Said::Answer(_, Ok(body)) => self.settings = from_answer(body).or(self.settings),
            Said::Telemetry(record) => {
                let stamp = record.measurement.stamp;
                return self.arrive(stamp.clock, rate_of(stamp.sequence), at);
            }
            Said::ChirpFrame(frame) => {
                // It is sent when its targets are found, which takes more or less long.
                let search = Duration::try_from_secs_f32(frame.search_s).ok()?;
                let at = at.checked_sub(search)?;
                return self.arrive(frame.stamp.clock, Some(frame.rate_hz), at);
            }
            _ => {}
        }
        None
    }

    /// Takes a record's count of samples, its sample rate and the time of its arrival.
    fn arrive(&mut self, clock: u64, rate_hz: Option<f64>, at: Duration) -> Option<Told> {
        let (settings, _) = self.settings?;
        // An external source decides when samples are counted.
        let rate_hz = rate_hz.filter(|_| settings.drive != Drive::External)?;
        let goes_on = |running: &Running| running.rate_hz == rate_hz && running.clock <= clock;
        if !self.running.as_ref().is_some_and(goes_on) {
            self.running = Some(Running::new(rate_hz, at)?);
        }
        self.running.as_mut()?.arrive(clock, at)
    }

    /// The error so far, if there were enough records.
    pub fn error(&self) -> Option<ClockError> {
        self.running.as_ref()?.error()
    }

    /// Whether the stated rate is not the one at which samples arrive: every number is off by as much.
    pub fn is_wrong(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.wrong)
    }

    /// The settings with the clock's error, if it is known well enough, and its sigma.
    pub fn corrected(&self) -> Option<(Settings, usize)> {
        let error = self.error().filter(|error| error.sigma_ppm <= KNOWN_PPM)?;
        let (settings, n) = self.settings?;
        let ppm = after(&settings, error);
        (ppm.abs() <= f64::from(Calibration::MOST_PPM)).then(|| (with_clock(&settings, ppm), n))
    }

    /// What is told, for people or as JSON.
    pub fn line(&self, told: &Told, style: Style) -> String {
        let (Told::Known(error) | Told::Wrong(error)) = *told;
        let ClockError { ppm, sigma_ppm, seconds } = error;
        let before = self.settings.map(|(settings, _)| settings);
        let stated_hz = self.running.as_ref().map_or(f64::NAN, |running| running.rate_hz);
        let wrong = matches!(told, Told::Wrong(_));
        if style == Style::Jsonl {
            return serde_json::json!({
                "rate_check": if wrong { "wrong" } else { "known" }, "seconds": seconds,
                "rate_error_ppm": ppm, "sigma_rate_error_ppm": sigma_ppm, "stated_hz": stated_hz,
                "clock_ppm": before.filter(|_| !wrong).map(|settings| after(&settings, error)),
            })
            .to_string();
        }
        match (wrong, before) {
            (true, _) => {
                let true_hz = stated_hz * (1.0 + 1e-6 * f64::from(ppm));
                format!(
                    "the sample rate is wrong: {stated_hz:.6} Hz are stated, and {true_hz:.0} Hz ({:.2} %) arrive by this machine's clock: every frequency, range and velocity is off by as much; check the board's clock and the settings",
                    1e-4 * ppm + 100.0
                )
            }
            (false, Some(settings)) => format!(
                "the sample clock is off by {ppm:+.2} ± {sigma_ppm:.2} ppm of the stated rate in {seconds:.0} s by this machine's clock, whose own error adds to that; --save-clock stores clock_ppm {:.2} on the board",
                after(&settings, error)
            ),
            (false, None) => String::new(),
        }
    }
}

/// The setting `clock_ppm` with which a rate is right that is off by this much.
fn after(settings: &Settings, error: ClockError) -> f64 {
    (settings.calibration.true_hz(1.0) * (1.0 + 1e-6 * f64::from(error.ppm)) - 1.0) * 1e6
}

impl Running {
    fn new(rate_hz: f64, at: Duration) -> Option<Self> {
        Some(Self {
            check: RateCheck::new(rate_hz, TICKS_HZ)?,
            rate_hz,
            clock: 0,
            records: 0,
            begun: at,
            due: at + SHORTEST,
            told: [false; 2],
            wrong: false,
        })
    }

    fn arrive(&mut self, clock: u64, at: Duration) -> Option<Told> {
        // A frame whose targets took long to find may seem to be older than the first one.
        self.check.push(clock, u64::try_from(at.checked_sub(self.begun)?.as_micros()).ok()?);
        (self.clock, self.records) = (clock, self.records + 1);
        if at < self.due || self.records < FEWEST {
            return None;
        }
        self.due = at + PERIOD;
        let error = self.check.error()?;
        let [known, wrong] = &mut self.told;
        self.wrong = error.is_beyond(TOLERANCE_PPM + 1e6 * DELAY_S / error.seconds);
        if self.wrong {
            return (!std::mem::replace(wrong, true)).then_some(Told::Wrong(error));
        }
        let is_known = error.sigma_ppm <= KNOWN_PPM && error.ppm.abs() <= TOLERANCE_PPM;
        (is_known && !std::mem::replace(known, true)).then_some(Told::Known(error))
    }

    fn error(&self) -> Option<ClockError> {
        let lasts = |error: &ClockError| error.seconds >= SHORTEST.as_secs_f32();
        self.check.error().filter(|error| lasts(error) && self.records >= FEWEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::Stamp;
    use picket_dsp::methods::registry::Method;
    use picket_dsp::pipeline::Measurement;
    use picket_simulator::Draw;
    use picket_wire::chirp_frame::ChirpFrame;
    use picket_wire::command::Answer;
    use picket_wire::telemetry::{Health, Telemetry};

    const N: u64 = 1024;

    fn record(stamp: Stamp) -> Said {
        let (method, health) = (Method::LeastSquaresReal, Health::default());
        let measurement = Measurement { stamp, ..Measurement::default() };
        Said::Telemetry(Telemetry { measurement, method, health, basis: None, uncertainty: None })
    }

    /// A board, and the host that it is connected to.
    struct Line {
        stated_hz: f64,
        true_hz: f64,
        seconds: f64,
        /// Mean of the jitter, s; it is exponential.
        jitter_s: f64,
        /// The longest delay in a burst, s; one begins every ten seconds or so.
        burst_s: f64,
        drive: Drive,
        /// Frames of chirps, whose targets take up to a tenth of a second to find.
        frames: bool,
    }

    impl Line {
        /// What is told and when, s, and the comparison at the end.
        fn run(&self, seed: u64) -> (Vec<(f64, Told)>, HostClock) {
            let mut draw = Draw::new(seed, 0);
            let mut clock = HostClock::default();
            let settings = Settings { drive: self.drive, ..Settings::default() };
            let body = settings.to_bytes(N as usize).to_vec();
            clock.hear(&Said::Answer(Answer::default(), Ok(body)), |_| None, Duration::ZERO);
            let (mut told, mut burst, mut arrived) = (Vec::new(), 0.0, 0.0f64);
            let block_s = N as f64 / self.true_hz;
            for sequence in 0..(self.seconds / block_s) as u32 {
                if draw.share() < block_s / 10.0 {
                    burst = self.burst_s * draw.share();
                }
                burst *= (-block_s).exp();
                let late = burst + self.jitter_s * draw.exponential();
                // Records come in order.
                arrived = arrived.max(f64::from(sequence + 1) * block_s + late);
                let stamp = Stamp { sequence, clock: N * u64::from(sequence), ..Stamp::default() };
                let search_s = if self.frames { 0.1 * draw.share() as f32 } else { 0.0 };
                let at = Duration::from_secs_f64(100.0 + arrived + f64::from(search_s));
                let rate_hz = self.stated_hz;
                let said = match self.frames {
                    true => Said::ChirpFrame(ChirpFrame {
                        stamp,
                        search_s,
                        rate_hz,
                        ..ChirpFrame::default()
                    }),
                    false => record(stamp),
                };
                let heard = clock.hear(&said, |_| Some(rate_hz), at);
                told.extend(heard.map(|told| (arrived, told)));
            }
            (told, clock)
        }
    }

    const LINE: Line = Line {
        stated_hz: 48e3,
        true_hz: 48e3,
        seconds: 600.0,
        jitter_s: 1e-3,
        burst_s: 0.05,
        drive: Drive::Off,
        frames: false,
    };

    /// Ten minutes with a millisecond of jitter and bursts of delay: a part per million with a true sigma, and no right rate called wrong. When
    /// it is first told, sigma has just become small enough, by luck too: it is narrower than the truth by a quarter there.
    #[test]
    fn ten_minutes_tell_a_part_per_million() {
        const SEEDS: u64 = 100;
        println!("seeds: 0 to {}", SEEDS - 1);
        let (mut squares, mut early, mut known) = (0.0, 0.0, 0.0f64);
        for seed in 0..SEEDS {
            let ppm = 100.0 * (Draw::new(seed, 1).share() - 0.5);
            let frames = seed % 2 == 1;
            let line = Line { true_hz: 48e3 * (1.0 + 1e-6 * ppm), frames, ..LINE };
            let (told, clock) = line.run(seed);
            let off = |error: ClockError| (f64::from(error.ppm) - ppm) / f64::from(error.sigma_ppm);
            let [(at, Told::Known(first))] = told[..] else { panic!("{seed}: {told:?}") };
            known = known.max(at);
            early += off(first).powi(2);
            let error = clock.error().unwrap();
            assert!(error.sigma_ppm <= 1.0, "{seed}: {error:?}");
            squares += off(error).powi(2);
            let (settings, n) = clock.corrected().unwrap();
            assert!((f64::from(settings.calibration.clock_ppm) - ppm).abs() < 5.0, "{error:?}");
            assert_eq!(n, N as usize);
        }
        let [squares, early] = [squares, early].map(|sum| (sum / SEEDS as f64).sqrt());
        println!(
            "rms of error / sigma: {squares:.2}, {early:.2} when first told, at most after {known:.0} s"
        );
        assert!((0.8..1.2).contains(&squares) && early < 1.4, "{squares} {early}");
    }

    /// A converter at 80 % is told within five seconds, whatever the delays are.
    #[test]
    fn a_slow_converter_is_told_in_five_seconds() {
        println!("seeds: 0 to 49");
        for (stated_hz, share, within_s) in [
            (10e3, 0.8, 5.0),
            (48e3, 0.8, 5.0),
            (500e3, 0.8, 5.0),
            (48e3, 1.2, 5.0),
            (48e3, 1.01, 60.0),
        ] {
            for seed in 0..50 {
                let true_hz = share * stated_hz;
                // Frames that come half as often do not tell a percent as soon.
                let frames = seed % 2 == 1 && share < 1.0;
                let line = Line { stated_hz, true_hz, seconds: 2.0 * within_s, frames, ..LINE };
                let (told, clock) = line.run(seed);
                let [(at, told @ Told::Wrong(error))] = told[..] else {
                    panic!("{stated_hz} {seed}: {told:?}")
                };
                let ppm = 1e6 * (share - 1.0);
                let near = (f64::from(error.ppm) - ppm).abs() < 0.1 * ppm.abs();
                assert!(at < within_s && near, "{at} {error:?}");
                assert!(clock.corrected().is_none());
                let text = clock.line(&told, Style::Table);
                assert!(text.starts_with("the sample rate is wrong"), "{text}");
            }
        }
    }

    /// Half a second of delay, worse jitter, records a second apart: a right rate is never called wrong.
    #[test]
    fn a_right_rate_is_not_called_wrong() {
        println!("seeds: 0 to 99");
        let (slow, quick) = (Line { stated_hz: 1e3, true_hz: 1e3, ..LINE }, LINE);
        for line in [
            Line { burst_s: 0.5, ..quick },
            Line { jitter_s: 10e-3, ..quick },
            Line { jitter_s: 10e-3, burst_s: 0.5, ..slow },
        ] {
            for seed in 0..100 {
                let (told, _) = Line { seconds: 120.0, ..line }.run(seed);
                let wrong = told.iter().find(|(_, told)| matches!(told, Told::Wrong(_)));
                assert_eq!(wrong, None, "{seed}");
            }
        }
    }

    /// An external source counts its own samples, and settings that are not known may be its.
    #[test]
    fn an_external_source_is_left_out() {
        let line = Line { true_hz: 0.8 * 48e3, seconds: 10.0, drive: Drive::External, ..LINE };
        let (told, clock) = line.run(0);
        assert_eq!((told.len(), clock.error()), (0, None));
        let record = record(Stamp::default());
        assert_eq!(HostClock::default().hear(&record, |_| Some(48e3), Duration::ZERO), None);
    }

    /// A restart counts samples from 0 again.
    #[test]
    fn a_restart_begins_again() {
        let (_, mut clock) = Line { seconds: 20.0, ..LINE }.run(3);
        assert!(clock.error().is_some());
        let at = Duration::from_secs(200);
        assert_eq!(clock.hear(&record(Stamp::default()), |_| Some(48e3), at), None);
        assert_eq!(clock.error(), None);
    }
}
