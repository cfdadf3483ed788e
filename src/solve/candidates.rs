//! The targets among which a chirp does not decide, and what decides.

use core::ops::Deref;
use fixed::types::I32F32;

/// The most candidates that an answer holds.
pub const CANDIDATES: usize = 4;

/// One of several targets that fit the beats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Candidate {
    /// Range, metres.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity"))]
    pub range: I32F32,
    /// Velocity, metres per second; positive when approaching.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::quantity"))]
    pub velocity: I32F32,
    /// The probability of this candidate, 0 to 1. The rest up to 1 belongs to candidates that are not in the list, and to a
    /// target with a beat that no ramp shows.
    pub odds: f32,
}

/// The candidates of an answer, the most probable first: at most [`CANDIDATES`]. They are read as a slice.
#[derive(Clone, Copy, Default)]
pub struct Candidates {
    list: [Candidate; CANDIDATES],
    count: u8,
}

impl Candidates {
    /// The first [`CANDIDATES`] of these.
    pub fn new(all: impl IntoIterator<Item = Candidate>) -> Self {
        let mut candidates = Self::default();
        for (place, candidate) in candidates.list.iter_mut().zip(all) {
            *place = candidate;
            candidates.count += 1;
        }
        candidates
    }
}

impl Deref for Candidates {
    type Target = [Candidate];

    fn deref(&self) -> &[Candidate] {
        self.list.get(..usize::from(self.count)).unwrap_or_default()
    }
}

impl PartialEq for Candidates {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl core::fmt::Debug for Candidates {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Candidates {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}", **self);
    }
}

/// The knowledge that decided between several targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Decision {
    /// The bounds of range and velocity in the configuration.
    Bound = 0,
    /// The chirp before: only this candidate is where its velocity would have taken it.
    LastChirp = 1,
    /// The levels of the lines: the two beats of one target are equally strong.
    Levels = 2,
}

impl Decision {
    /// Every decision.
    pub const ALL: [Decision; 3] = [Decision::Bound, Decision::LastChirp, Decision::Levels];

    /// The name that tables and JSON show.
    pub const fn name(self) -> &'static str {
        match self {
            Decision::Bound => "bound",
            Decision::LastChirp => "last-chirp",
            Decision::Levels => "levels",
        }
    }
}

/// The ambiguity that waveform and lines leave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Ambiguity {
    /// The answer is unique.
    #[default]
    None,
    /// A sawtooth: range and velocity are coupled. The range is that of a target at rest, and the velocity is not known.
    Coupled,
    /// The beats fit several targets: the answer's own numbers are those of the first. The ramps of a triangle with real samples fit two,
    /// with the roles of range and Doppler exchanged; two lines on each ramp can be paired in two ways.
    Several(Candidates),
    /// The beats fit several targets, or a sawtooth couples range and velocity, and other knowledge decided.
    Decided(Decision),
}

impl Ambiguity {
    /// The name that tables and JSON show.
    pub const fn name(&self) -> &'static str {
        match self {
            Ambiguity::None => "none",
            Ambiguity::Coupled => "coupled",
            Ambiguity::Several(_) => "several",
            Ambiguity::Decided(by) => by.name(),
        }
    }

    /// The number in telemetry: 0 unique, 1 several, 2 coupled, 3 and more what decided.
    pub const fn number(&self) -> u8 {
        match self {
            Ambiguity::None => 0,
            Ambiguity::Several(_) => 1,
            Ambiguity::Coupled => 2,
            Ambiguity::Decided(by) => 3 + *by as u8,
        }
    }

    /// The ambiguity of this number, with these candidates if they are several; `None` for an unknown number.
    pub fn from_number(number: u8, candidates: Candidates) -> Option<Self> {
        match number {
            0 => Some(Ambiguity::None),
            1 => Some(Ambiguity::Several(candidates)),
            2 => Some(Ambiguity::Coupled),
            _ => {
                let by = Decision::ALL.get(usize::from(number) - 3)?;
                Some(Ambiguity::Decided(*by))
            }
        }
    }

    /// The candidates; none unless there are several.
    pub fn candidates(&self) -> &[Candidate] {
        match self {
            Ambiguity::Several(candidates) => candidates,
            _ => &[],
        }
    }
}
