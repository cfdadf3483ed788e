//! The effort spent on a line that is not a steady tone.

/// The effort spent on a line that is not a steady tone: the number of rounds of the joint fit, 0 to 3. The effort sets the most that a
/// block may take, so a real-time system chooses it by the ceilings in `docs/performance.md`. The rounds need the feature `joint-fit`, and
/// compute in floats: a core without an FPU takes some forty times as long.
///
/// A block that shows one steady tone has the same answer at every effort. With 0 rounds two more steps of the fit, and tests of
/// what it leaves, decide whether any other line may be used. Each round joins one cause to the fit: a level that changes, a phase that bends
/// or wanders, another line, or a pair of sidebands. `docs/proofs.md` says which lines become usable, and how wrong they are.
///
/// ```
/// use picket_dsp::Effort;
/// assert_eq!(Effort::default().rounds(), 3); // on a desk
/// assert_eq!(Effort::from_rounds(4), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Effort(u8);

impl Effort {
    /// No rounds.
    pub const LOOK: Self = Self(0);
    /// One round.
    pub const ONE: Self = Self(1);
    /// Two rounds: the usual effort of a core with an FPU.
    pub const TWO: Self = Self(2);
    /// Three rounds: the usual effort of a desk.
    pub const THREE: Self = Self(3);

    /// Every effort, the least first.
    pub const ALL: &[Self] = &[Self::LOOK, Self::ONE, Self::TWO, Self::THREE];

    /// The effort of this many rounds; `None` beyond 3.
    pub const fn from_rounds(rounds: u8) -> Option<Self> {
        if rounds <= crate::model::constants::ROUNDS { Some(Self(rounds)) } else { None }
    }

    /// The most rounds of the joint fit. It is the number in settings, records and captures, too.
    pub const fn rounds(self) -> u8 {
        self.0
    }

    /// The effort that a program has for this choice: none without the feature `joint-fit`.
    pub const fn available(self) -> Self {
        if cfg!(feature = "joint-fit") { self } else { Self::LOOK }
    }

    /// The name in commands and JSON: the number of rounds.
    pub const fn name(self) -> &'static str {
        match self.0 {
            0 => "0",
            1 => "1",
            2 => "2",
            _ => "3",
        }
    }

    /// The effort of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|effort| effort.name() == name)
    }

    /// Two rounds on a microcontroller with an FPU, none on one without, three on a desk.
    pub const fn from_core() -> Self {
        if cfg!(not(target_os = "none")) {
            Self::THREE
        } else if cfg!(target_abi = "eabihf") {
            Self::TWO
        } else {
            Self::LOOK
        }
    }
}

impl Default for Effort {
    /// [`Effort::from_core`].
    fn default() -> Self {
        Self::from_core()
    }
}
