//! A tone of several as a row of numbers. Both modules of the page leave such rows.

use picket_dsp::tone::phasor::ToneWithPhase;

/// How many numbers a tone has.
pub const COLUMNS: usize = 7;

/// Frequency and sigma in Hz, amplitude in codes, phase and its sigma in radians, signal-to-noise ratio in dB, and the
/// verdict's number.
pub fn row(
    &ToneWithPhase { tone, phase, sigma_phase }: &ToneWithPhase,
    rate_hz: f64,
) -> [f64; COLUMNS] {
    [
        tone.frequency.hertz(rate_hz),
        f64::from(tone.sigma) * rate_hz,
        tone.amplitude.into(),
        phase.into(),
        sigma_phase.into(),
        tone.snr_db().into(),
        f64::from(tone.verdict as u8),
    ]
}
