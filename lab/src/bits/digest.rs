//! A digest of answers, by the bits of their numbers.

use picket_dsp::burst::Burst;
use picket_dsp::solve::track::Track;
use picket_dsp::tone::evidence::Evidence;
use picket_dsp::tone::harmonic::Harmonic;
use picket_dsp::tone::line_class::LineClass;
use picket_dsp::tone::observer::Step;
use picket_dsp::{
    Accumulated, Ambiguity, Measurement, Outcome, Target, Tone, ToneWithPhase, Unjudged,
};
use picket_measure::explain::rows::{Fitted, Note};
use std::fmt::Write as _;

/// The 64-bit FNV-1a hash of numbers, and on demand a line for each number.
#[derive(Debug)]
pub struct Digest {
    hash: u64,
    lines: Option<String>,
}

impl Digest {
    /// The digest of nothing; `listed` if its numbers are to be shown.
    pub const fn new(listed: bool) -> Self {
        // The offset basis of FNV.
        Self { hash: 0xcbf2_9ce4_8422_2325, lines: if listed { Some(String::new()) } else { None } }
    }

    /// The hash.
    pub const fn hash(&self) -> u64 {
        self.hash
    }

    /// What was hashed, a line each.
    pub fn lines(&self) -> &str {
        self.lines.as_deref().unwrap_or_default()
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            // The prime of FNV.
            self.hash = (self.hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn list(&mut self, line: impl FnOnce() -> String) {
        if let Some(lines) = &mut self.lines {
            let _ = writeln!(lines, "{}", line());
        }
    }

    /// The answer that follows.
    pub fn of(&mut self, what: &str) {
        self.bytes(what.as_bytes());
        self.list(|| format!("# {what}"));
    }

    /// A whole number.
    pub fn whole(&mut self, name: &str, number: impl Into<i128>) {
        let number: i128 = number.into();
        self.bytes(&number.to_le_bytes());
        self.list(|| format!("{name} {number}"));
    }

    fn float(&mut self, name: &str, number: f32) {
        self.bytes(&number.to_bits().to_le_bytes());
        self.list(|| format!("{name} {number:e} {:08x}", number.to_bits()));
    }

    fn double(&mut self, name: &str, number: f64) {
        self.bytes(&number.to_bits().to_le_bytes());
        self.list(|| format!("{name} {number:e} {:016x}", number.to_bits()));
    }

    fn word(&mut self, name: &str, word: &str) {
        self.bytes(word.as_bytes());
        self.list(|| format!("{name} {word}"));
    }

    /// A tone.
    pub fn tone(&mut self, tone: &Tone) {
        self.whole("frequency", tone.frequency.0.to_bits());
        self.float("sigma", tone.sigma);
        self.float("snr", tone.snr);
        self.float("amplitude", tone.amplitude);
        tone.reasons().for_each(|verdict| self.word("verdict", verdict.name()));
        self.double("rate_hz", tone.rate_hz);
    }

    /// A tone with its phase.
    pub fn phasor(&mut self, line: &ToneWithPhase) {
        self.tone(&line.tone);
        self.float("phase", line.phase);
        self.float("sigma_phase", line.sigma_phase);
    }

    /// A block's answer.
    pub fn measurement(&mut self, measurement: &Measurement) {
        self.whole("clipped", measurement.clipped);
        self.tone(&measurement.tone);
        match &measurement.result {
            Outcome::None => {}
            Outcome::Velocity(velocity) => {
                self.whole("velocity", velocity.velocity.to_bits());
                self.float("sigma", velocity.sigma);
                self.word("verdict", velocity.verdict.name());
            }
            Outcome::Target(target) => self.target(target),
        }
    }

    /// A target.
    pub fn target(&mut self, target: &Target) {
        self.whole("range", target.range.to_bits());
        if let Some(velocity) = target.velocity {
            self.whole("velocity", velocity.to_bits());
        }
        self.float("sigma_range", target.sigma_range);
        self.float("sigma_velocity", target.sigma_velocity);
        self.word("ambiguity", target.ambiguity.name());
        if let Ambiguity::Several(candidates) = &target.ambiguity {
            for candidate in candidates.iter() {
                self.whole("range", candidate.range.to_bits());
                self.whole("velocity", candidate.velocity.to_bits());
                self.float("odds", candidate.odds);
            }
        }
        self.word("verdict", target.verdict.name());
    }

    /// What a verdict follows from.
    pub fn evidence(&mut self, evidence: &Evidence) {
        for (applies, verdict) in evidence.rules() {
            self.word(verdict.name(), if applies { "yes" } else { "no" });
        }
        if let Some(drift) = evidence.drift {
            self.float("drift", drift.cycles);
            self.float("sigma", drift.sigma);
        }
        self.whole("beyond", evidence.beyond);
        self.float("clipped", evidence.clipped);
        self.float("edge_bins", evidence.edge_bins);
        self.float("sigma", evidence.sigma);
    }

    /// The tests behind a verdict.
    pub fn notes(&mut self, notes: &[Note]) {
        for note in notes {
            match note {
                Note::Begin(step) => self.word(
                    "step",
                    match step {
                        Step::Usual => "usual",
                        Step::Further => "further",
                    },
                ),
                Note::Test(test) => {
                    self.float(test.statistic.name(), test.value);
                    self.float("limit", test.limit);
                }
                Note::Judged(judgement, taken) => {
                    self.word(
                        "line",
                        match judgement.line {
                            LineClass::Steady => "steady",
                            LineClass::Moving => "moving",
                            LineClass::Unresolved => "unresolved",
                        },
                    );
                    self.float("inflation", judgement.variance_inflation);
                    self.whole("taken", u8::from(*taken));
                }
            }
        }
    }

    /// The last fit.
    pub fn fitted(&mut self, fitted: &Fitted) {
        self.whole("peak", fitted.peak);
        self.float("offset", fitted.fit.offset);
        self.float("re", fitted.fit.line.re);
        self.float("im", fitted.fit.line.im);
        self.float("noise", fitted.noise);
    }

    /// A rise of the frequency within a record.
    pub fn rise(&mut self, rise: &picket_dsp::tone::FrequencyDrift) {
        self.float("rise", rise.cycles);
        self.float("sigma", rise.sigma);
    }

    /// A fundamental.
    pub fn harmonic(&mut self, harmonic: &Harmonic) {
        self.tone(&harmonic.tone);
        self.whole("orders", harmonic.orders);
    }

    /// A frequency without a verdict.
    pub fn unjudged(&mut self, line: &Unjudged) {
        self.whole("frequency", line.frequency.0.to_bits());
        self.float("sigma", line.sigma);
    }

    /// A sum.
    pub fn accumulated(&mut self, sum: &Accumulated) {
        self.tone(&sum.tone);
        self.float("ln_chance", sum.ln_chance);
        self.whole("blocks", sum.blocks);
    }

    /// A burst.
    pub fn burst(&mut self, burst: &Burst) {
        self.tone(&burst.tone);
        self.double("arrival", burst.arrival);
        self.float("deviation", burst.deviation);
        self.word("validation", burst.validation.name());
    }

    /// A track.
    pub fn track(&mut self, track: &Track) {
        self.whole("number", track.number);
        self.word("state", track.state.name());
        self.tone(&track.tone);
        self.whole("age", track.age);
        self.whole("misses", track.misses);
        self.float("rate", track.rate());
        track.covariance().into_iter().for_each(|part| self.float("covariance", part));
    }
}
