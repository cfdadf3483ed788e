//! The error of a board's sample clock, from a reference of known frequency at its input.

use super::{CalibrateError, Heard, Options, Talk, collect};
use crate::cli::{decimals, print_line};
use crate::device::Said;
use crate::scatter::Scatter;
use crate::watch::settings;
use picket_dsp::config::Scene;
use picket_dsp::tone::{Tone, Usable};
use picket_wire::boot::Clock;
use picket_wire::settings::{Calibration, Mode, Settings};

/// Measures, prints the result, and saves it on request.
pub fn run(talk: &mut Talk, options: &Options, reference_hz: f64) -> Result<(), CalibrateError> {
    let mut tones = Vec::new();
    let heard =
        collect(
            talk,
            options,
            &|settings| suits(settings, reference_hz),
            &mut |said| match said {
                Some(Said::Telemetry(record)) => tones.push(record.measurement.tone),
                Some(_) => {}
                None => tones.clear(),
            },
        )?;
    let Heard { settings, n, clock, .. } = heard;
    // A record that was on its way is of the settings before.
    tones.retain(|tone: &Tone| heard.is_of_it(tone.rate_hz));
    let calibrated = Calibrated::of(&heard, &tones, reference_hz)?;
    if clock.is_some_and(|clock| clock != Clock::External) {
        eprintln!(
            "the board runs by its internal oscillator, whose rate changes with temperature and supply: this correction holds only as long as they do"
        );
    }
    if !options.json {
        calibrated.lines().iter().for_each(|line| print_line(line));
    }
    if options.save {
        talk.send(&settings::with_clock(&settings, calibrated.after_ppm), n, true)?;
    }
    match (options.json, options.save) {
        (true, _) => print_line(&calibrated.json(clock, options.save)),
        (_, true) => print_line("set and saved"),
        _ if talk.source.listens() => print_line("--save sets it and keeps it over a reset"),
        _ => {}
    }
    Ok(())
}

/// Whether a board with these settings measures the reference.
fn suits(settings: &Settings, reference_hz: f64) -> Result<(), CalibrateError> {
    let config = &settings.config;
    if matches!(config.scene, Scene::Chirp(_)) {
        return Err(CalibrateError::Chirp);
    }
    if matches!(settings.mode, Mode::Bursts(_)) {
        return Err(CalibrateError::Bursts);
    }
    if !settings.start {
        return Err(CalibrateError::Stopped);
    }
    let rate_hz = config.rate_hz;
    if reference_hz >= rate_hz / 2.0 {
        return Err(CalibrateError::Beyond { reference_hz, rate_hz });
    }
    match config.band_hz {
        Some((low, high)) if settings.order() == 0 && !(low..=high).contains(&reference_hz) => {
            Err(CalibrateError::Band { reference_hz, low, high })
        }
        _ => Ok(()),
    }
}

/// What comes out.
#[derive(Clone, Copy, Debug)]
struct Calibrated {
    reference_hz: f64,
    /// The weighted mean of what the board reads, and its standard deviation.
    mean_hz: f64,
    sigma_hz: f64,
    /// Records that were used, and those that were not.
    records: usize,
    left_out: usize,
    seconds: f64,
    /// How many times as wide as their sigmas the records scatter, if there are two or more.
    scatter: Option<f64>,
    agrees: bool,
    before_ppm: f32,
    after_ppm: f64,
    sigma_ppm: f64,
}

/// The tone's distance from the reference, as a share of it: a board's clock is off by at most the half of it before the correction, and
/// after it.
const REACH: f64 = 2.1e-6 * Calibration::MOST_PPM as f64;

impl Calibrated {
    fn of(heard: &Heard, tones: &[Tone], reference_hz: f64) -> Result<Self, CalibrateError> {
        let Heard { settings, seconds, clock, n } = *heard;
        if tones.is_empty() {
            let block = n as f64 / settings.config.rate_hz;
            return Err(CalibrateError::Silent { seconds, block });
        }
        let usable = |tone: &&Tone| tone.verdict.usable() <= Usable::WithinSigma;
        let readings: Vec<(f64, f64)> = tones
            .iter()
            .filter(usable)
            .map(|tone| (tone.hertz(), tone.sigma_hertz()))
            .filter(|(hertz, sigma)| *hertz != 0.0 && *sigma > 0.0 && sigma.is_finite())
            .collect();
        if readings.is_empty() {
            let most = tones.iter().map(|tone| tone.verdict);
            let count = |verdict| tones.iter().filter(|tone| tone.verdict == verdict).count();
            let verdict = most.max_by_key(|&verdict| count(verdict)).unwrap_or_default();
            return Err(CalibrateError::Unusable { records: tones.len(), verdict });
        }
        let reach = |sigma: f64| REACH * reference_hz + 5.0 * sigma;
        let near = |&&(hertz, sigma): &&(f64, f64)| (hertz - reference_hz).abs() <= reach(sigma);
        let used: Vec<(f64, f64)> = readings.iter().filter(near).copied().collect();
        let internal = clock.is_some_and(|clock| clock != Clock::External);
        let off = |hertz, ppm| CalibrateError::Off { hertz, reference_hz, ppm, internal };
        let pace = settings.calibration.true_hz(1.0);
        // The clock's error with which the board would read the reference.
        let ppm_of = |hertz: f64| (pace * reference_hz / hertz - 1.0) * 1e6;
        // A tone or two of others between those of the reference do no harm.
        if 2 * used.len() < readings.len() {
            let mut all = readings;
            all.sort_by(|(one, _), (other, _)| one.total_cmp(other));
            let (median, _) = all[all.len() / 2];
            return Err(off(median, ppm_of(median)));
        }
        let weight = |sigma: f64| 1.0 / (sigma * sigma);
        let weights: f64 = used.iter().map(|&(_, sigma)| weight(sigma)).sum();
        // Of differences, so that no digit is lost.
        let sum: f64 =
            used.iter().map(|&(hertz, sigma)| weight(sigma) * (hertz - reference_hz)).sum();
        let mean_hz = reference_hz + sum / weights;
        let squares: f64 =
            used.iter().map(|&(hertz, sigma)| weight(sigma) * (hertz - mean_hz).powi(2)).sum();
        let scatter = Scatter::of(squares, used.len());
        // A sigma that covers an internal oscillator says nothing of the scatter, which alone tells the mean's sigma.
        let agrees = internal || scatter.is_none_or(|scatter| scatter.agrees());
        let scatter = scatter.map(|scatter| scatter.times);
        // Where the records scatter more, so does their mean.
        let least = if agrees { 1.0 } else { scatter.unwrap_or(1.0).max(1.0) };
        let wider = if internal { scatter.unwrap_or(1.0) } else { least };
        let sigma_hz = wider / weights.sqrt();
        let after_ppm = ppm_of(mean_hz);
        if after_ppm.abs() > f64::from(Calibration::MOST_PPM) {
            return Err(off(mean_hz, after_ppm));
        }
        Ok(Self {
            reference_hz,
            mean_hz,
            sigma_hz,
            records: used.len(),
            left_out: tones.len() - used.len(),
            seconds,
            scatter: scatter.filter(|_| !internal),
            agrees,
            before_ppm: settings.calibration.clock_ppm,
            after_ppm,
            sigma_ppm: sigma_hz / mean_hz * pace * 1e6,
        })
    }

    /// For people.
    fn lines(&self) -> Vec<String> {
        let Self { reference_hz, mean_hz, sigma_hz, records, left_out, seconds, .. } = *self;
        let (fine, ppm) = (decimals(sigma_hz), decimals(self.sigma_ppm));
        let left = if left_out == 0 { String::new() } else { format!(", {left_out} left out") };
        let mean = format!(
            "{records} records in {seconds:.1} s{left}: {mean_hz:.fine$} Hz ± {sigma_hz:.fine$} Hz where the reference is {reference_hz} Hz"
        );
        let scatter = self.scatter.map(|scatter| match (self.agrees, scatter > 1.0) {
            (true, _) => "their scatter agrees with their sigmas".to_owned(),
            (false, true) => format!(
                "they scatter {scatter:.1} times as wide as their sigmas, and the sigma above is widened by that: the reference or the clock wanders, or something disturbs the tone"
            ),
            (false, false) => format!(
                "they scatter {scatter:.2} times as wide as their sigmas, which are too wide here"
            ),
        });
        let result = format!(
            "clock_ppm {} before, {:.ppm$} ± {:.ppm$} now; the reference's own error adds to that",
            self.before_ppm, self.after_ppm, self.sigma_ppm
        );
        [Some(mean), scatter, Some(result)].into_iter().flatten().collect()
    }

    /// For programs.
    fn json(&self, clock: Option<Clock>, saved: bool) -> String {
        serde_json::json!({
            "reference_hz": self.reference_hz, "mean_hz": self.mean_hz, "sigma_hz": self.sigma_hz,
            "records": self.records, "left_out": self.left_out, "seconds": self.seconds,
            "scatter": self.scatter, "scatter_agrees": self.agrees,
            "clock_ppm_before": f64::from(self.before_ppm), "clock_ppm": self.after_ppm,
            "sigma_ppm": self.sigma_ppm, "clock": clock.map(Clock::name), "saved": saved,
        })
        .to_string()
    }
}
