//! The evidence on a tone beside its fit, and the one function that turns evidence into a verdict.

use super::line_class::LineClass;
pub use super::verdict::WHOLE_SPECTRUM;
use super::verdict::{Reasons, Verdict};
use crate::tone::sigma::CLIPPED;
use crate::tone::{FrequencyDrift, Tone};

/// A fit to a real tone nearer to DC or Nyquist than this many bins cannot separate the mirror image from the tone. A fit to an I/Q tone
/// nearer to DC cannot separate the converter's offset from the tone: the peak is the next bin then.
pub const EDGE_BINS: f32 = 1.5;

/// Bins from a real tone to the nearer of DC and Nyquist, from an I/Q tone to DC, where a converter's offset is. `bins` is the tone's
/// frequency in a record of `n` samples; negative frequencies of I/Q may count from 0 down or from N down.
#[inline(always)]
pub fn edge_bins(iq: bool, n: usize, bins: f32) -> f32 {
    let from_dc = bins.abs();
    let end = if iq { n } else { n / 2 };
    from_dc.min(end as f32 - from_dc)
}

/// The evidence on a tone beside its fit. A measurement fills in the fields that it knows and leaves the rest as in [`Evidence::CLEAN`];
/// [`verdict`] alone draws the conclusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// The reasons of the tones that this tone was made of.
    pub said: Reasons,
    /// There is a peak in the band, and a fit to it.
    pub found: bool,
    /// The line exceeds the noise.
    pub detected: bool,
    /// The line's class, by the fit's residual.
    pub line: LineClass,
    /// The causes that joined a fit of the line with what is beside it, but for the bend of a ramp.
    pub joined: u8,
    /// The rise of the frequency within the record, where the line's class is [`LineClass::Moving`], and on a ramp by float
    /// arithmetic.
    pub drift: Option<FrequencyDrift>,
    /// An I/Q record has too strong a line at minus the frequency.
    pub image: bool,
    /// The lines are made by a fault of the digital front end, see `front_end`.
    pub front_end: bool,
    /// Samples are missing before the record.
    pub gap: bool,
    /// The frequency lies more than half a bin outside of the band.
    pub outside: bool,
    /// Samples beyond the rails of the stated codes.
    pub beyond: u32,
    /// The share of the samples that touch a rail. Its limit is [`CLIPPED`].
    pub clipped: f32,
    /// Bins to the nearer of DC and Nyquist, of an I/Q tone to DC; infinite if that is far. Its limit is [`EDGE_BINS`].
    pub edge_bins: f32,
    /// Sigma in cycles per sample, without the engine's error. Its limit is [`WHOLE_SPECTRUM`].
    pub sigma: f32,
}

impl Evidence {
    /// No evidence against the tone.
    pub const CLEAN: Self = Self::new(Reasons::NONE);

    /// No tone at all.
    pub const NO_TONE: Self = Self { found: false, ..Self::CLEAN };

    /// Evidence from the reasons that a tone already has.
    pub const fn new(said: Reasons) -> Self {
        Self {
            said,
            found: true,
            detected: true,
            line: LineClass::Steady,
            joined: 0,
            drift: None,
            image: false,
            front_end: false,
            gap: false,
            outside: false,
            beyond: 0,
            clipped: 0.0,
            edge_bins: f32::INFINITY,
            sigma: 0.0,
        }
    }

    /// The rules, each with the verdict that it leads to if it applies: the only place where an `Evidence` becomes a verdict. Their order is
    /// that of `picket explain`, and has no effect on the verdict. Sums and bursts add rules of their own.
    #[inline]
    #[deny(unused_variables)] // every finding has its rule
    pub fn rules(&self) -> [(bool, Verdict); 12] {
        #[rustfmt::skip]
        let Self {
            said: _, found, detected, line, joined: _, drift: _, image, front_end, gap, outside, beyond, clipped, edge_bins, sigma,
        } = *self;
        // A sigma or a frequency that is NaN is not good.
        let (known, inside) = (sigma < WHOLE_SPECTRUM, edge_bins >= EDGE_BINS);
        [
            (!found, Verdict::NoSignal),
            (!detected, Verdict::Weak),
            (!known, Verdict::Weak),
            (line == LineClass::Moving, Verdict::Moving),
            (line == LineClass::Unresolved, Verdict::Unresolved),
            (image, Verdict::Image),
            (front_end, Verdict::FrontEnd),
            (!inside, Verdict::NearEdge),
            (outside, Verdict::NearEdge),
            (clipped > CLIPPED, Verdict::Clipped),
            (beyond > 0, Verdict::WrongCodes),
            (gap, Verdict::Gap),
        ]
    }

    /// All reasons that apply.
    #[inline]
    pub fn reasons(&self) -> Reasons {
        self.rules().into_iter().fold(
            self.said,
            |said, (applies, verdict)| {
                if applies { said.with(verdict) } else { said }
            },
        )
    }
}

/// The verdict on a tone: the most severe reason that applies.
pub fn verdict(evidence: &Evidence) -> Verdict {
    evidence.reasons().verdict()
}

impl Tone {
    /// The tone's reasons so far.
    pub(crate) fn said(&self) -> Reasons {
        Reasons::from_verdict(self.verdict, self.also)
    }

    /// Takes over wrong codes or a faulty front end from another tone of the same record.
    pub(crate) fn keep_to_codes_of(&mut self, tone: &Self) {
        let beyond = u32::from(tone.verdict == Verdict::WrongCodes);
        let front_end = tone.verdict == Verdict::FrontEnd;
        self.conclude(&Evidence { beyond, front_end, ..Evidence::new(self.said()) });
    }

    /// Sets the tone's verdict and its other reasons from the evidence.
    #[inline]
    pub(crate) fn conclude(&mut self, evidence: &Evidence) {
        let reasons = evidence.reasons();
        (self.verdict, self.also) = (reasons.verdict(), reasons.also());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Each part of the evidence alone leads to its verdict, at its limit to none; and every verdict has a part that leads to it.
    #[test]
    fn every_part_has_its_verdict() {
        let clean = Evidence::CLEAN;
        let parts = [
            (clean, Verdict::Good),
            (Evidence { line: LineClass::Moving, ..clean }, Verdict::Moving),
            (Evidence { line: LineClass::Unresolved, ..clean }, Verdict::Unresolved),
            (Evidence { edge_bins: 1.49, ..clean }, Verdict::NearEdge),
            (Evidence { edge_bins: EDGE_BINS, ..clean }, Verdict::Good),
            (Evidence { edge_bins: f32::NAN, ..clean }, Verdict::NearEdge),
            (Evidence { outside: true, ..clean }, Verdict::NearEdge),
            (Evidence { clipped: CLIPPED, ..clean }, Verdict::Good),
            (Evidence { clipped: 0.0101, ..clean }, Verdict::Clipped),
            (Evidence { image: true, ..clean }, Verdict::Image),
            (Evidence { front_end: true, ..clean }, Verdict::FrontEnd),
            (Evidence { gap: true, ..clean }, Verdict::Gap),
            (Evidence { detected: false, ..clean }, Verdict::Weak),
            (Evidence { sigma: WHOLE_SPECTRUM, ..clean }, Verdict::Weak),
            (Evidence { sigma: f32::NAN, ..clean }, Verdict::Weak),
            (Evidence::NO_TONE, Verdict::NoSignal),
            (Evidence { beyond: 1, ..clean }, Verdict::WrongCodes),
            (Evidence::new(Reasons::NONE.with(Verdict::Coasting)), Verdict::Coasting),
        ];
        for (evidence, expected) in parts {
            assert_eq!(verdict(&evidence), expected, "{evidence:?}");
        }
        // Only a target is ambiguous.
        for verdict in Verdict::ALL.into_iter().filter(|&verdict| verdict != Verdict::Ambiguous) {
            assert!(parts.iter().any(|(_, expected)| *expected == verdict), "{verdict}");
        }
    }

    #[test]
    fn a_tone_says_all_that_applies_and_the_worst_first() {
        let mut tone = Tone::ZERO;
        tone.conclude(&Evidence { line: LineClass::Moving, clipped: 0.5, ..Evidence::CLEAN });
        let reasons: Vec<Verdict> = tone.reasons().collect();
        assert_eq!(reasons, [Verdict::Clipped, Verdict::Moving]);
        assert!(std::format!("{tone}").ends_with("clipped, moving"), "{tone}");
        tone.conclude(&Evidence {
            beyond: 3,
            line: LineClass::Moving,
            ..Evidence::new(tone.said())
        });
        let reasons: Vec<Verdict> = tone.reasons().collect();
        assert_eq!(reasons, [Verdict::WrongCodes, Verdict::Clipped, Verdict::Moving]);
    }
}
