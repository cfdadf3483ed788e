//! The effort spent on a line that is not a steady tone.

/// The effort spent on a line that is not a steady tone. The effort sets the most that a block may take, so a real-time system chooses it
/// by the ceilings in `docs/performance.md`.
///
/// A block that shows one steady tone has the same answer at every effort. `Full` leaves no answer unresolved that `One` gives; `One` leaves
/// a few bursts unresolved that `Look` gives. `docs/effort.md` says which lines become usable, and how wrong they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum Effort {
    /// One fit, and tests on its residual, see `judge`. Where the tests find no steady tone, the fit goes on for two
    /// steps. Another line near the tone is `unresolved`, and so is a tone at low bins beside a drift or hum.
    Look = 1,
    /// One tone, fitted as well as it can be: where the tests find no steady tone, all steps to the fit's end, and one more fit beside a
    /// drift of the samples or slow hum.
    #[default]
    One = 0,
    /// Where these steps find no steady tone either, a joint fit of the tone and of at most three causes. The effort needs the feature
    /// `joint-fit`, and is written for cores with an FPU.
    #[cfg(feature = "joint-fit")]
    Full = 2,
}

impl Effort {
    /// Every effort of this program, the least first.
    pub const ALL: &[Self] = &[
        Self::Look,
        Self::One,
        #[cfg(feature = "joint-fit")]
        Self::Full,
    ];

    /// Whether a good tone is one by itself, and not beside other lines that were fitted as well.
    pub(crate) const fn is_one_tone(self) -> bool {
        matches!(self, Self::Look | Self::One)
    }

    /// The name in commands and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Look => "look",
            Self::One => "one",
            #[cfg(feature = "joint-fit")]
            Self::Full => "full",
        }
    }

    /// The effort of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|effort| effort.name() == name)
    }

    /// The number in settings, records and captures.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The effort of this number; `None` if this program has no such effort.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|effort| effort.number() == number)
    }

    /// The most steps of a further fit to a line that is not a steady tone. Two steps estimate the fit's end by a secant; eight steps reach
    /// it.
    pub(crate) const fn steps(self) -> u32 {
        match self {
            Self::Look => 2,
            _ => 8,
        }
    }

    /// Whether a line that is not a steady tone is fitted together with a drift or hum.
    pub(crate) const fn fits_beside_slow(self) -> bool {
        !matches!(self, Self::Look)
    }

    /// The most causes that may join a fit; `None` where no joint fit is made.
    pub(crate) const fn causes(self) -> Option<usize> {
        match self {
            Self::Look | Self::One => None,
            #[cfg(feature = "joint-fit")]
            Self::Full => Some(crate::model::constants::ROUNDS),
        }
    }
}
