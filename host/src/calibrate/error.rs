//! Why there is no calibration, in a line each, with the cure.

use crate::cli::Failure;
use crate::watch::WatchError;
use picket_dsp::tone::Verdict;
use std::fmt;

/// Why there is no calibration.
#[derive(Debug)]
#[non_exhaustive]
pub enum CalibrateError {
    /// The board is not heard, or refuses.
    Watch(WatchError),
    /// No port was named: the first there is, and what is to be measured.
    Nameless(Option<String>, &'static str),
    /// A recording without the board's settings.
    NoSettings(String),
    /// The board does not measure.
    Stopped,
    /// The board measures chirps.
    Chirp,
    /// The board waits for bursts.
    Bursts,
    /// The board measures no chirps.
    NoChirp,
    /// The board's records have no phases.
    NoPhase,
    /// The reference would fold.
    Beyond {
        /// The reference, Hz.
        reference_hz: f64,
        /// The sample rate, Hz.
        rate_hz: f64,
    },
    /// The board does not look where the reference is.
    Band {
        /// The reference, Hz.
        reference_hz: f64,
        /// Where it looks, Hz.
        low: f64,
        /// Where it looks, Hz.
        high: f64,
    },
    /// No record came.
    Silent {
        /// For so long, s.
        seconds: f64,
        /// What a block lasts, s.
        block: f64,
    },
    /// No record is of use.
    Unusable {
        /// All of them.
        records: usize,
        /// What most of them say.
        verdict: Verdict,
    },
    /// No ramp is of use.
    Unclear {
        /// All of them.
        ramps: usize,
        /// What most of them say.
        verdict: Verdict,
    },
    /// The target does not calibrate, or a file does not: why.
    Line(String),
    /// The tone is too far from the reference.
    Off {
        /// The tone, Hz.
        hertz: f64,
        /// The reference, Hz.
        reference_hz: f64,
        /// The clock's error that would follow.
        ppm: f64,
        /// Whether the board says that its crystal's clock did not come.
        internal: bool,
    },
    /// The board uses another correction than the one that it was sent.
    Another(f32),
}

impl fmt::Display for CalibrateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CalibrateError::Watch(error) => error.fmt(f),
            CalibrateError::Nameless(Some(first), wanted) => {
                write!(f, "name the port: picket calibrate {first} {wanted}")
            }
            CalibrateError::Nameless(None, _) => f.write_str(
                "there is no serial port: plug the board in by its USB socket (--help lists all)",
            ),
            CalibrateError::NoSettings(name) => write!(
                f,
                "{name}: it lacks the board's settings: record with picket watch PORT --record FILE, which requests them"
            ),
            CalibrateError::Stopped => f.write_str(
                "the board is stopped: start it by picket watch PORT --start, then try again",
            ),
            CalibrateError::Chirp => f.write_str(
                "the board measures chirps: set scene to \"tone\" and drive to \"off\" by picket watch PORT --set-settings FILE, then try again",
            ),
            CalibrateError::Bursts => f.write_str(
                "the board waits for bursts: set mode to \"blocks\" by picket watch PORT --set-settings FILE, then try again",
            ),
            CalibrateError::NoChirp => f.write_str(
                "the board measures no chirps: set scene to \"chirp\" and a drive by picket watch PORT --set-settings FILE, then try again",
            ),
            CalibrateError::NoPhase => f.write_str(
                "the recording has no phases: set most to 2 by picket watch PORT --set-settings FILE, then record again",
            ),
            CalibrateError::Unclear { ramps, verdict } => write!(
                f,
                "none of {ramps} rising ramps can be used, most are {verdict} ({}): does one target stand out, and rest?",
                verdict.reason().trim_end_matches('.')
            ),
            CalibrateError::Line(line) => f.write_str(line),
            CalibrateError::Beyond { reference_hz, rate_hz } => write!(
                f,
                "the reference of {reference_hz} Hz is not below half the board's {rate_hz} samples a second and would fold: choose a lower one, or raise rate_hz"
            ),
            CalibrateError::Band { reference_hz, low, high } => write!(
                f,
                "the board searches {low} to {high} Hz, which excludes the reference of {reference_hz} Hz: set band_hz to null by picket watch PORT --set-settings FILE, then try again"
            ),
            CalibrateError::Silent { seconds, block } => write!(
                f,
                "no record came in {seconds:.1} s, and a block lasts {block:.3} s: measure longer by --seconds, or lower report_every"
            ),
            CalibrateError::Unusable { records, verdict } => write!(
                f,
                "none of {records} records can be used, most are {verdict} ({}): is the reference at the board's input, a sine within its range?",
                verdict.reason().trim_end_matches('.')
            ),
            CalibrateError::Off { hertz, reference_hz, ppm, internal } => {
                write!(
                    f,
                    "the board reads {hertz:.3} Hz where the reference is {reference_hz} Hz: a clock_ppm of {ppm:.0} is more than the allowed 1000; "
                )?;
                f.write_str(match internal {
                    true => "it runs on its internal oscillator (1 %), so repair its external clock first (docs/board.md)",
                    false => "is it another tone, or does the board run on its internal oscillator (picket watch PORT shows it)?",
                })
            }
            CalibrateError::Another(ppm) => write!(
                f,
                "the board uses other settings (clock_ppm {ppm}) than it was sent, and nothing was saved: does another program send settings?"
            ),
        }
    }
}

impl std::error::Error for CalibrateError {}

impl From<WatchError> for CalibrateError {
    fn from(error: WatchError) -> Self {
        CalibrateError::Watch(error)
    }
}

impl From<CalibrateError> for Failure {
    fn from(error: CalibrateError) -> Self {
        match error {
            CalibrateError::Watch(error) => error.into(),
            other => other.to_string().into(),
        }
    }
}
