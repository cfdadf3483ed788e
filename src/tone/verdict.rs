//! The reasons against a number, and the uses that the number still has.

/// A sigma of this many cycles per sample is as wide as the spectrum, and says nothing.
pub const WHOLE_SPECTRUM: f32 = 1.0;

macro_rules! verdicts {
    ($($(#[$about:meta])* $number:literal $variant:ident $name:literal $usable:ident $bit:literal, $reason:literal;)*) => {
        /// The reason against a number. Every number comes with a verdict, and [`Verdict::usable`] says for which use the number is good.
        /// If several reasons apply, the most severe one is given; [`Verdict::ALL`] and `<` order them by severity. A telemetry record
        /// holds a verdict as its number.
        ///
        /// ```
        /// use picket_dsp::{Codes, Pipeline, Plan, Real, Usable, Verdict};
        ///
        /// let mut pipeline = Pipeline::<Real, 1024>::new(Plan::tone(48_000.0, Codes::signed::<12>()));
        /// // Noise alone, of a linear congruential generator.
        /// let mut state = 1u32;
        /// let samples: [i16; 1024] = std::array::from_fn(|_| {
        ///     state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ///     (state >> 22) as i16 - 512
        /// });
        /// let verdict = pipeline.record(&samples)?.tone.verdict;
        /// assert_eq!((verdict, verdict.usable()), (Verdict::Weak, Usable::No));
        /// assert!(verdict > Verdict::Good, "{}", verdict.reason());
        /// # Ok::<(), picket_dsp::LengthError>(())
        /// ```
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Verdict {
            $($(#[$about])* $variant = $number,)*
        }

        impl Verdict {
            /// Every verdict, from best to worst.
            pub const ALL: [Verdict; [$($number),*].len()] = [$(Verdict::$variant),*];

            /// The name that tables and JSON show.
            pub const fn name(self) -> &'static str {
                match self { $(Verdict::$variant => $name,)* }
            }

            /// The verdict's meaning, in a sentence.
            pub const fn reason(self) -> &'static str {
                match self { $(Verdict::$variant => $reason,)* }
            }

            /// The use of a number with this verdict.
            pub const fn usable(self) -> Usable {
                match self { $(Verdict::$variant => Usable::$usable,)* }
            }

            /// The verdict's place in the order of severity. Severities 1 to 7 are the bits of [`Verdicts`] in telemetry, and frozen; a new
            /// verdict takes a severity of 8 or more, so it outranks the milder ones, and stands in no set.
            const fn severity(self) -> u8 {
                enum Place { $($variant,)* }
                match self { $(Verdict::$variant => Place::$variant as u8,)* }
            }

            /// The verdict's bit in a set of verdicts that apply beside a more severe one; 0 if it never applies beside another.
            const fn bit(self) -> u8 {
                match self { $(Verdict::$variant => $bit,)* }
            }
        }
    };
}

// One line for each verdict, from best to worst: a verdict's place is its severity. Numbers and bits are telemetry's, and never change.
verdicts! {
//  number variant name usable bit, the meaning;
    /// Use the number: sigma is its error.
    0 Good "good" Yes 0,
        "One steady tone. Sigma is the expected error.";
    /// One tone whose frequency or level changes within the record. Use the number within sigma, as the mean over the record. Two lines
    /// less than one and a half bins apart look the same.
    8 Moving "moving" WithinSigma 1,
        "The tone's frequency or level changes within the block: the frequency is the mean over it.";
    /// The tone is so near DC or Nyquist that its mirror image disturbs the estimate, or the tone is more than half a bin outside of the
    /// band in which it was sought.
    1 NearEdge "near-edge" Rough 2,
        "The tone is so near DC or Nyquist that an offset or its mirror image disturbs it, or it lies outside the band.";
    /// More than 1 % of the samples touch a rail. Use the number within sigma, which includes the shift of this tone by the harmonics of
    /// clipping. At most frequencies the harmonics hardly move it; near a simple fraction of the rate they move it hundreds of times as far
    /// as noise.
    2 Clipped "clipped" WithinSigma 4,
        "Samples touch the converter's rails: lower the gain.";
    /// Two tones too close to be separated, or beats that do not belong to one target.
    3 Unresolved "unresolved" Rough 8,
        "There is more than one tone in the line: sigma covers only the visible part of the others.";
    /// The two parts of an I/Q record do not match, for example because one is dead or late. The
    /// tone may be at minus its frequency.
    9 Image "image" WithoutSign 16,
        "The two channels do not belong together: the frequency may have the wrong sign.";
    /// Samples were lost just before this block, or within this chirp.
    4 Gap "gap" WithinSigma 32,
        "Samples were lost just before this block.";
    /// The peak is below the detection threshold: it may be noise. Or a real tone is so near DC or Nyquist, a small part of a bin, that the
    /// record shows neither its level nor its place.
    5 Weak "weak" No 64,
        "The line is too weak, or too near DC or Nyquist, to be distinguished from noise.";
    /// The beats of a chirp fit several targets, and nothing decides between them; or a sawtooth couples a target's range with its velocity.
    /// A tone is never ambiguous.
    11 Ambiguous "ambiguous" No 0,
        "The beats fit several targets: a bound of range or velocity, or the next chirp, decides.";
    /// The lines of the record are those of a fault of the digital front end: codes that wrap, or swapped samples of a word.
    /// The true tone may be another line.
    10 FrontEnd "front-end" No 0,
        "The lines are those of codes that wrap, or of swapped samples: the tone may be another line.";
    /// There is nothing in the band; the numbers mean nothing.
    #[default]
    6 NoSignal "no-signal" No 0,
        "There is nothing in the band.";
    /// Samples lie beyond the rails of the stated codes. The converter's codes differ from the stated ones, so noise, sigma and clipping
    /// mean nothing.
    7 WrongCodes "wrong-codes" No 0,
        "Samples lie beyond the stated rails: the converter has other codes.";
    /// A track's prediction. This block did not measure the tone: it is missing, is not where it was expected, or cannot be distinguished from
    /// another track's. Sigma is that of the prediction, if the target goes on as before.
    12 Coasting "coasting" No 0,
        "The block did not measure the tone: this is the track's prediction.";
}

impl Verdict {
    /// The verdict with this number, as stored in a telemetry record.
    pub fn from_u8(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|&verdict| verdict as u8 == code)
    }

    /// Whether a number of this verdict may have this sigma: a usable number has an error that is known.
    pub const fn admits(self, sigma: f32) -> bool {
        matches!(self.usable(), Usable::No) || sigma >= 0.0 && sigma < f32::INFINITY
    }
}

/// The bit of a verdict stands for its severity, and every severity has its bit in [`Reasons`].
const _: () = {
    let (mut severity, mut rest) = (0, Verdict::ALL.as_slice());
    while let [verdict, worse @ ..] = rest {
        let bit = if 1 <= severity && severity <= 7 { 1 << (severity - 1) } else { 0 };
        assert!(
            verdict.bit() == bit,
            "severities 1 to 7 are frozen: a new verdict comes behind them"
        );
        assert!(severity < u16::BITS, "`Reasons` has no bit for this verdict");
        (severity, rest) = (severity + 1, worse);
    }
};

impl Ord for Verdict {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        self.severity().cmp(&other.severity())
    }
}

impl PartialOrd for Verdict {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl core::fmt::Display for Verdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

/// The uses of a number, from best to worst; `<` orders them so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Usable {
    /// For everything: sigma is its error.
    Yes,
    /// Within sigma, which covers the fault, but for no more than the verdict says.
    WithinSigma,
    /// For its size, but not for its sign.
    WithoutSign,
    /// As a rough value, if nothing better can be had: the error may be larger than sigma says.
    Rough,
    /// For nothing.
    No,
}

impl Usable {
    /// The name that tables show.
    pub const fn name(self) -> &'static str {
        match self {
            Usable::Yes => "yes",
            Usable::WithinSigma => "within sigma",
            Usable::WithoutSign => "without its sign",
            Usable::Rough => "as a rough value",
            Usable::No => "no",
        }
    }
}

impl core::fmt::Display for Usable {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

/// A set of verdicts that apply beside a more severe one. A record with a fault of the front end, without a signal or with wrong codes may
/// not be used whatever else applies: these three stand in no set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdicts(u8);

impl Verdicts {
    /// The empty set.
    pub const NONE: Self = Self(0);

    /// The set with one more verdict.
    #[must_use]
    pub const fn with(self, verdict: Verdict) -> Self {
        Self(self.0 | verdict.bit())
    }

    /// The set without one verdict.
    #[must_use]
    pub const fn without(self, verdict: Verdict) -> Self {
        Self(self.0 & !verdict.bit())
    }

    /// Whether the set has a verdict.
    pub const fn has(self, verdict: Verdict) -> bool {
        self.0 & verdict.bit() != 0
    }

    /// All verdicts of the set, the most severe first.
    pub fn iter(self) -> impl Iterator<Item = Verdict> + use<> {
        Verdict::ALL.into_iter().rev().filter(move |&verdict| self.has(verdict))
    }

    /// The set as seven bits, in telemetry's order from the lowest bit on: moving, near-edge, clipped, unresolved, image, gap, weak.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The set of these seven bits.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0x7F)
    }
}

/// All reasons that apply to a tone: a set of verdicts, in which [`Verdict::Good`] means none. Bit k is the verdict of severity k.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reasons(u16);

impl Reasons {
    /// Nothing applies: the verdict is [`Verdict::Good`].
    pub const NONE: Self = Self(1);

    /// A verdict, and the other reasons that apply.
    pub(crate) const fn from_verdict(verdict: Verdict, also: Verdicts) -> Self {
        // Bit k of a set of verdicts has severity k + 1.
        Self(1 | 1 << verdict.severity() | (also.0 as u16) << 1)
    }

    /// The reasons with one more.
    #[must_use]
    pub const fn with(self, verdict: Verdict) -> Self {
        Self(self.0 | 1 << verdict.severity())
    }

    /// The reasons with [`Verdict::Weak`] where the frequency's sigma is as wide as the spectrum, or NaN.
    #[must_use]
    pub(crate) fn with_sigma(self, sigma: f32) -> Self {
        let known = sigma < WHOLE_SPECTRUM;
        if known { self } else { self.with(Verdict::Weak) }
    }

    /// The reasons without one.
    #[must_use]
    pub const fn without(self, verdict: Verdict) -> Self {
        Self(self.0 & !(1 << verdict.severity()) | 1)
    }

    /// The reasons of either.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The most severe reason.
    pub fn verdict(self) -> Verdict {
        let worst = self.0.checked_ilog2().unwrap_or(0) as usize;
        Verdict::ALL.get(worst).copied().unwrap_or(Verdict::WrongCodes)
    }

    /// The reasons beside the most severe.
    pub fn also(self) -> Verdicts {
        Verdicts::from_bits((self.0 >> 1) as u8).without(self.verdict())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The places in the list are the severities, and every set returns the verdicts that it was made of.
    #[test]
    fn reasons_are_a_verdict_and_what_applies_besides() {
        for (place, verdict) in Verdict::ALL.into_iter().enumerate() {
            assert_eq!(verdict.severity() as usize, place);
            for bits in 0..0x80 {
                let also = Verdicts::from_bits(bits);
                if also.iter().all(|other| other < verdict) {
                    let reasons = Reasons::from_verdict(verdict, also);
                    assert_eq!((reasons.verdict(), reasons.also()), (verdict, also));
                    assert_eq!(reasons.with(verdict).without(Verdict::Good), reasons);
                }
            }
        }
    }

    /// Each verdict can be stored, and iteration keeps the order of severity.
    #[test]
    fn sets_keep_the_order_of_severity() {
        let mut order: Vec<Verdict> = Verdicts::from_bits(0x7F).iter().collect();
        assert_eq!(order.len(), 7);
        order.reverse();
        assert!(order.is_sorted());
        for verdict in Verdict::ALL {
            assert_eq!(
                Verdicts::NONE.with(verdict).iter().next(),
                order.iter().copied().find(|v| *v == verdict)
            );
        }
    }
}
