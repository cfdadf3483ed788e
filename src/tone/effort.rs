//! How closely a line that is no steady tone is looked at.

/// How closely a line that is no steady tone is looked at: by tests on what a fit of one tone leaves, or by a joint fit of the tone and of
/// what else is there.
///
/// A block that shows one steady tone has the same answer at every effort. More effort never takes an answer's usefulness away: where
/// the joint fit does not know either, the tests' answer stands. `docs/trust.md` says which lines become usable, and how wrong they are.
///
/// The joint fits are there with the feature `joint-fit` alone. They are written for cores with an FPU: `docs/performance.md` has their cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Effort {
    /// Tests on what the fit of one tone leaves, see [`judge`](crate::tone::judge). Another line near the tone is `unresolved`.
    #[default]
    Look,
    /// One cause joins the fit at most.
    #[cfg(feature = "joint-fit")]
    One,
    /// Three causes join the fit at most.
    #[cfg(feature = "joint-fit")]
    Full,
}

impl Effort {
    /// Every effort of this program, the least first.
    pub const ALL: &[Self] = &[
        Self::Look,
        #[cfg(feature = "joint-fit")]
        Self::One,
        #[cfg(feature = "joint-fit")]
        Self::Full,
    ];

    /// The name in commands and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Look => "look",
            #[cfg(feature = "joint-fit")]
            Self::One => "one",
            #[cfg(feature = "joint-fit")]
            Self::Full => "full",
        }
    }

    /// The effort of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|effort| effort.name() == name)
    }

    /// The number in settings and captures.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The effort of this number; `None` if this program has none such.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// How many causes may join a fit; `None` where none is made.
    pub(crate) const fn causes(self) -> Option<usize> {
        match self {
            Self::Look => None,
            #[cfg(feature = "joint-fit")]
            Self::One => Some(1),
            #[cfg(feature = "joint-fit")]
            Self::Full => Some(crate::model::constants::ROUNDS),
        }
    }
}
