//! Scenes that many cases begin with. A hertz is a bin, a second is a record.

use picket_dsp::Record;
use picket_simulator::scene::{Hum, Noise, Receiver, Source, Tone};
use picket_simulator::{Scene, Value};

/// Whether records are I/Q.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Real samples.
    Real,
    /// Pairs.
    Iq,
}

impl Kind {
    /// Both.
    pub const ALL: [Self; 2] = [Kind::Real, Kind::Iq];

    /// That of a type of records.
    pub const fn of<R: Record>() -> Self {
        if R::IQ { Kind::Iq } else { Kind::Real }
    }

    /// The name in labels.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Real => "real",
            Kind::Iq => "I/Q",
        }
    }
}

/// The largest amplitude at which four deviations of the noise do not clip, of so many tones of one level.
pub fn amplitude(snr_db: f64) -> f64 {
    2040.0 / (1.0 + 4.0 * deviation(1.0, snr_db))
}

/// The standard deviation of the noise in each part.
pub fn deviation(amplitude: f64, snr_db: f64) -> f64 {
    amplitude * (0.5 / 10f64.powf(snr_db / 10.0)).sqrt()
}

/// Anywhere that is not `near-edge`: the peak of a real tone at bins 2 to N/2 - 2, of an I/Q tone at 2 to N - 2.
pub fn anywhere(kind: Kind, n: usize) -> Value {
    let last = if kind == Kind::Iq { n } else { n / 2 } as f64;
    (1.5..last - 1.5).into()
}

/// A tone.
pub fn line(frequency_hz: impl Into<Value>, amplitude: f64) -> Tone {
    Tone { frequency_hz: frequency_hz.into(), amplitude: Some(amplitude.into()), ..Tone::default() }
}

/// A tone so many bins beside the first, at a level over it, dB.
pub fn beside(bins: impl Into<Value>, level_db: impl Into<Value>) -> Tone {
    Tone {
        frequency_hz: bins.into(),
        beside: Some(0),
        level_db: Some(level_db.into()),
        ..Tone::default()
    }
}

/// The tone that comes first.
///
/// # Panics
/// Another source does.
pub fn first(scene: &mut Scene) -> &mut Tone {
    match scene.sources.first_mut() {
        Some(Source::Tone(tone)) => tone,
        _ => panic!("a tone comes first"),
    }
}

/// Hum of so many cycles, codes.
pub fn hum(cycles: impl Into<Value>, codes: f64) -> Hum {
    let (frequency_hz, amplitude) = (cycles.into(), codes.into());
    Hum { frequency_hz, amplitude, harmonics: vec![], phase_turns: None, direction_turns: None }
}

/// Sources in noise of so many codes rms, a record of `n` samples.
pub fn records(kind: Kind, n: usize, sources: Vec<Source>, noise: f64) -> Scene {
    let receiver = Receiver {
        iq: kind == Kind::Iq,
        noise: Noise { rms: Some(noise.into()), ..Noise::default() },
        ..Receiver::default()
    };
    Scene { rate_hz: n as f64, seconds: 1.0, sources, receiver, ..Scene::default() }
}

/// Tones in noise.
pub fn tones(kind: Kind, n: usize, tones: impl IntoIterator<Item = Tone>, noise: f64) -> Scene {
    records(kind, n, tones.into_iter().map(Source::Tone).collect(), noise)
}

/// A steady tone anywhere, as large as fits.
pub fn tone(kind: Kind, n: usize, snr_db: f64) -> Scene {
    let amplitude = amplitude(snr_db);
    tones(kind, n, [line(anywhere(kind, n), amplitude)], deviation(amplitude, snr_db))
}
