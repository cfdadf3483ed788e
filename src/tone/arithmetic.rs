//! The arithmetic of the fit and of the noise.

/// The arithmetic of least squares and of the noise estimate, after the integer FFT.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Arithmetic {
    /// `f32` throughout.
    Float,
    /// Integers in every loop over bins, `f32` once a step.
    Fixed,
}

impl Arithmetic {
    /// Fixed on microcontrollers without a floating-point unit (targets whose ABI is not `eabihf`), float elsewhere. Each gives equal bits
    /// on every machine. The two differ by less than a tenth of the Cramér-Rao bound. Only `Float` has the nearest-bin refinement for
    /// tones with neighbours, and the search for several targets of a chirp: with `Fixed` such a tone or target stays unresolved, and its
    /// sigma is wide.
    pub const fn from_core() -> Self {
        if cfg!(all(target_os = "none", not(target_abi = "eabihf"))) {
            Arithmetic::Fixed
        } else {
            Arithmetic::Float
        }
    }
}

impl Arithmetic {
    /// The arithmetic that a program has for this choice. A microcontroller's program without the feature `both-arithmetics` has its core's
    /// alone, [`Arithmetic::from_core`]: the other one would take 20 to 30 KB.
    pub const fn available(self) -> Self {
        if cfg!(all(target_os = "none", not(feature = "both-arithmetics"))) {
            Self::from_core()
        } else {
            self
        }
    }
}

impl Default for Arithmetic {
    /// The default is [`Arithmetic::from_core`].
    fn default() -> Self {
        Self::from_core()
    }
}
