//! Blocks whose samples do not fit integers: each has a verdict and is counted, and the analysis goes on.

use crate::recording::Sample;
use picket_dsp::acquire::codes::Codes;
use std::fmt::Display;

/// Why integers do not take a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// Samples lie beyond the rails.
    Beyond,
    /// No sample comes to one and a half codes, and they are no whole codes.
    Quiet,
}

impl Unfit {
    /// What is wrong with a block for integers of these codes.
    pub fn of(samples: &[Sample], codes: Codes) -> Option<Self> {
        let (low, high) = codes.rails();
        let beyond = |part: i16| part < low || part > high;
        let value = |sample: &Sample| sample.value.re.abs().max(sample.value.im.abs());
        // Codes of all 16 bits end at their rails.
        let narrow = low > i16::MIN || high < i16::MAX;
        if narrow && samples.iter().any(|sample| sample.code().into_iter().any(beyond)) {
            return Some(Unfit::Beyond);
        }
        if samples.iter().any(|sample| value(sample) >= 1.5) {
            return None;
        }
        let silent = samples.iter().all(|sample| value(sample) == 0.0);
        let whole = samples.iter().all(|sample| sample.value.re.fract() == 0.0);
        (!silent && !whole).then_some(Unfit::Quiet)
    }

    /// What is to be done.
    pub fn cure(self, codes: Codes) -> String {
        match self {
            Unfit::Beyond => {
                let (low, high) = codes.rails();
                format!("samples exceed {low}..{high}: add --bits 16, or --scale")
            }
            Unfit::Quiet => "samples are too small for integers: add --scale CODES".into(),
        }
    }
}

/// How many blocks were taken and how many left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Blocks read.
    pub blocks: u64,
    beyond: u64,
    quiet: u64,
}

impl Tally {
    /// Counts a block.
    pub fn add(&mut self, unfit: Option<Unfit>) {
        self.blocks += 1;
        match unfit {
            Some(Unfit::Beyond) => self.beyond += 1,
            Some(Unfit::Quiet) => self.quiet += 1,
            None => {}
        }
    }

    /// Blocks that were left out.
    pub const fn left_out(&self) -> u64 {
        self.beyond + self.quiet
    }

    /// An error where every block was left out: then the recording is not what was said of it.
    ///
    /// # Errors
    /// In one line, with the cure.
    pub fn check(&self, codes: Codes) -> Result<(), String> {
        match self.blocks > 0 && self.left_out() == self.blocks {
            true => Err(self.most().cure(codes)),
            false => Ok(()),
        }
    }

    /// Why most of them were left out.
    pub const fn most(&self) -> Unfit {
        if self.beyond >= self.quiet { Unfit::Beyond } else { Unfit::Quiet }
    }

    /// For whom silence between bursts is no loss.
    pub const fn without_quiet(self) -> Self {
        Self { quiet: 0, ..self }
    }

    /// Tells on stderr what was left out, a line for each reason.
    pub fn tell(&self, file: impl Display, codes: Codes) {
        for (count, unfit) in [(self.beyond, Unfit::Beyond), (self.quiet, Unfit::Quiet)] {
            if count > 0 {
                let blocks = self.blocks;
                eprintln!("{file}: {count} of {blocks} blocks left out: {}", unfit.cure(codes));
            }
        }
    }
}
