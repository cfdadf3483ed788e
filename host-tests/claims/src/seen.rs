//! What came of a record.

use picket_dsp::Verdict;

/// An answer beside the truth.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Its errors over its sigmas: of the frequency and the phase, or of range and velocity; 0 where there is none.
    pub off: [f64; 2],
    /// Its errors over their bounds, of frequency and phase.
    pub over_bound: [f64; 2],
    /// The error of a tone's frequency, bins.
    pub bins: f64,
    /// Its sigma of the frequency over the bound.
    pub sigma: f64,
    /// By how much its ratio of signal to noise is too large, dB.
    pub snr_db: f64,
    /// By how much its amplitude is off beyond what noise explains by six deviations, a share.
    pub level: f64,
    /// Its verdict.
    pub verdict: Verdict,
    /// Of several candidates that are listed, the errors over sigma of the best.
    pub candidate: Option<f64>,
    /// Of a range by phase: how many cycles it is off, if its cycle is said to be sure.
    pub cycles: Option<f64>,
}

impl Seen {
    /// No answer.
    pub const NOTHING: Self = Seen {
        off: [f64::NAN; 2],
        over_bound: [f64::NAN; 2],
        bins: f64::NAN,
        sigma: f64::NAN,
        snr_db: f64::NAN,
        level: f64::NAN,
        verdict: Verdict::NoSignal,
        candidate: None,
        cycles: None,
    };

    /// The larger of its errors over sigma.
    pub fn worst(&self) -> f64 {
        self.off[0].abs().max(self.off[1].abs())
    }
}

/// What came of a trial.
#[derive(Clone, Debug, Default)]
pub struct Trial {
    /// The answers: one of a block, a sum, a chirp or a burst; several of lines; of each block in a row; of each block's held tracks, where one
    /// without a track has nothing.
    pub seen: Vec<Seen>,
    /// Sources without an answer.
    pub missing: usize,
    /// Answers without a source.
    pub more: usize,
    /// Of them the `good` ones.
    pub more_good: usize,
    /// Numbers of tracks that had a usable row.
    pub identities: usize,
    /// Watched blocks until each source was held by a track within a bin and a half.
    pub held_after: Option<usize>,
    /// Whether one was not, later on.
    pub lost: bool,
    /// Whether the tracks that hold the sources in the last block are others than in the first one that is watched.
    pub exchanged: bool,
    /// Records of a stream, and those of them that a burst detector cut out.
    pub cut: [u64; 2],
}
