//! What must come out of a case, and whether chance explains what came out.

use crate::seen::{Seen, Trial};
use picket_dsp::{Usable, Verdict};
use statrs::distribution::{Binomial, ChiSquared, ContinuousCDF, DiscreteCDF};

/// The probability that a claim which is just true fails by chance: of ten thousand cases with two limits, one fails in 200 runs.
pub const RISK: f64 = 2.5e-7;

/// What may be the case with an answer or a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// It may be used within sigma.
    Usable,
    /// It may not.
    Refused,
    /// It is `good`.
    Good,
    /// It has one of these verdicts.
    Is(&'static [Verdict]),
    /// It may be used and is so many sigmas off or more: of the usable ones.
    Off(f64),
    /// The same of its frequency alone, or of its range.
    FirstOff(f64),
    /// It may be used and is so many sigmas off or more: of all.
    Wrong(f64),
    /// It is `good` and is so many sigmas off or more: of all.
    GoodOff(f64),
    /// It may not be used, and is within five bounds of the truth.
    RefusedThoughRight,
    /// It is within so many sigmas, of the usable ones.
    Within(f64),
    /// Its ratio of signal to noise is within so many dB, of the usable ones.
    SnrWithin(f64),
    /// It is another line: more than a bin and a half off.
    Elsewhere,
    /// It is `ambiguous`, and none of its candidates is within so many sigmas.
    Unlisted(f64),
    /// A line was found, whatever else is said of it.
    Found,
    /// A trial has as many answers as sources, each where one is.
    RightNumber,
    /// A trial has an answer without a source.
    More,
    /// A trial has a `good` answer without a source.
    MoreGood,
    /// Its amplitude is off by more than this share and what noise explains, of the usable ones.
    LevelOff(f64),
    /// A trial has usable rows of more tracks than so many.
    Identities(usize),
    /// A trial's sources were not all held within so many watched blocks.
    Late(usize),
    /// A source of a trial was held, and then not.
    Lost,
    /// Other tracks hold a trial's sources in the end than in the beginning.
    Exchanged,
    /// A burst detector cut out a record: of all records.
    Cut,
    /// The cycle of a range by phase is said to be sure, of the usable ones.
    Sure,
    /// It is another cycle, of those that are said to be sure.
    OtherCycle,
    /// The cycle is not said to be sure, and none of the candidates is within so many sigmas: of the usable ones that list candidates.
    NotAmong(f64),
}

/// What must come out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// A share.
    Share {
        /// Of what.
        of: Event,
        /// At least.
        least: f64,
        /// At most.
        most: f64,
    },
    /// The mean of (error / sigma)^2 of the usable answers.
    Square {
        /// 0 for frequency or range, 1 for phase or velocity.
        quantity: usize,
        /// At least.
        least: f64,
        /// At most.
        most: f64,
    },
    /// The mean of (error / sigma)^2 of the ranges by phase whose cycle is said to be sure.
    ByPhase {
        /// At least.
        least: f64,
        /// At most.
        most: f64,
    },
    /// The root mean square of the error over its bound.
    OverBound {
        /// 0 for frequency, 1 for phase.
        quantity: usize,
        /// At most.
        most: f64,
    },
    /// The root mean square of the error of a tone's frequency, bins.
    Rms {
        /// At most.
        most: f64,
    },
    /// The mean of the ratio of signal to noise beside the truth, dB: at most so much either way.
    Snr {
        /// At most.
        most_db: f64,
    },
    /// The median of sigma over the bound, of all answers.
    Sigma {
        /// At most.
        most: f64,
    },
}

/// What came out.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// The share, or another value.
    pub value: f64,
    /// Of how many answers or trials.
    pub of: u64,
    /// Whether chance explains it.
    pub holds: bool,
}

fn usable(seen: &Seen) -> bool {
    seen.verdict.usable() <= Usable::WithinSigma
}

/// Answers that are another line, or none, have no error.
fn near(seen: &&Seen) -> bool {
    usable(seen) && (seen.bins.is_nan() || seen.bins.abs() <= 1.5)
}

impl Event {
    /// Of how many, and how many of them.
    fn count(self, trials: &[Trial]) -> (u64, u64) {
        let all = || trials.iter().flat_map(|trial| &trial.seen);
        let of = |among: &dyn Fn(&Seen) -> bool, is: &dyn Fn(&Seen) -> bool| {
            let among: Vec<&Seen> = all().filter(|seen| among(seen)).collect();
            (among.len() as u64, among.iter().filter(|seen| is(seen)).count() as u64)
        };
        let any = |_: &Seen| true;
        let trials_of = |is: &dyn Fn(&Trial) -> bool| {
            (trials.len() as u64, trials.iter().filter(|trial| is(trial)).count() as u64)
        };
        match self {
            Event::Usable => of(&any, &usable),
            Event::Refused => of(&any, &|seen| !usable(seen)),
            Event::Good => of(&any, &|seen| seen.verdict == Verdict::Good),
            Event::Is(verdicts) => of(&any, &|seen| verdicts.contains(&seen.verdict)),
            Event::Off(sigmas) => of(&usable, &|seen| seen.worst() > sigmas),
            Event::FirstOff(sigmas) => of(&usable, &|seen| seen.off[0].abs() > sigmas),
            Event::Wrong(sigmas) => of(&any, &|seen| usable(seen) && seen.worst() > sigmas),
            Event::GoodOff(sigmas) => {
                of(&any, &|seen| seen.verdict == Verdict::Good && seen.worst() > sigmas)
            }
            Event::RefusedThoughRight => {
                of(&any, &|seen| !usable(seen) && seen.over_bound[0].abs() < 5.0)
            }
            Event::Within(sigmas) => of(&|seen| near(&seen), &|seen| seen.worst() <= sigmas),
            Event::SnrWithin(db) => of(&|seen| near(&seen), &|seen| seen.snr_db.abs() <= db),
            Event::Elsewhere => of(&any, &|seen| seen.bins.is_nan() || seen.bins.abs() > 1.5),
            Event::Unlisted(sigmas) => of(&any, &|seen| {
                seen.verdict == Verdict::Ambiguous && seen.candidate.is_none_or(|off| off > sigmas)
            }),
            Event::Found => of(&any, &|seen| seen.verdict < Verdict::Weak),
            Event::RightNumber => trials_of(&|trial| trial.missing == 0 && trial.more == 0),
            Event::More => trials_of(&|trial| trial.more > 0),
            Event::MoreGood => trials_of(&|trial| trial.more_good > 0),
            Event::LevelOff(share) => of(&usable, &|seen| seen.level > share),
            Event::Identities(most) => trials_of(&|trial| trial.identities > most),
            Event::Late(blocks) => {
                trials_of(&|trial| trial.held_after.is_none_or(|at| at > blocks))
            }
            Event::Sure => of(&usable, &|seen| seen.cycles.is_some()),
            Event::OtherCycle => of(&|seen| seen.cycles.is_some(), &|seen| {
                seen.cycles.is_some_and(|off| off.abs() > 0.25)
            }),
            Event::NotAmong(sigmas) => {
                let listed = |seen: &Seen| seen.cycles.is_none() && seen.candidate.is_some();
                of(&|seen| usable(seen) && listed(seen), &|seen| {
                    seen.candidate.is_none_or(|off| off > sigmas)
                })
            }
            Event::Lost => trials_of(&|trial| trial.lost),
            Event::Exchanged => trials_of(&|trial| trial.exchanged),
            Event::Cut => trials
                .iter()
                .fold((0, 0), |(all, seen), trial| (all + trial.cut[0], seen + trial.cut[1])),
        }
    }
}

impl Asked {
    /// Whether the bound of each record is needed.
    pub(crate) const fn needs_bound(&self) -> bool {
        matches!(
            self,
            Asked::OverBound { .. }
                | Asked::Sigma { .. }
                | Asked::Share { of: Event::RefusedThoughRight, .. }
        )
    }

    /// What came out of these trials.
    pub fn judge(&self, trials: &[Trial]) -> Judged {
        let near: Vec<&Seen> = trials.iter().flat_map(|trial| &trial.seen).filter(near).collect();
        let of = near.len() as u64;
        let count = of as f64;
        let squares = |of: &dyn Fn(&Seen) -> f64| near.iter().map(|seen| of(seen).powi(2)).sum();
        match *self {
            Asked::Share { of, least, most } => {
                let (all, seen) = of.count(trials);
                // As many or more at the most that is allowed, as many or fewer at the least.
                let more = seen == 0 || tail(all, most, |law| 1.0 - law.cdf(seen - 1), most < 1.0);
                let fewer = tail(all, least, |law| law.cdf(seen), least > 0.0);
                let holds = all > 0 && more && fewer;
                Judged { value: seen as f64 / all as f64, of: all, holds }
            }
            Asked::Square { quantity, least, most } => {
                let sum: f64 = squares(&|seen| seen.off[quantity]);
                Judged { value: sum / count, of, holds: chi_square(sum, count, least, most) }
            }
            Asked::ByPhase { least, most } => {
                let sure: Vec<&&Seen> = near.iter().filter(|seen| seen.cycles.is_some()).collect();
                let (sum, count): (f64, _) =
                    (sure.iter().map(|seen| seen.off[0].powi(2)).sum(), sure.len() as f64);
                let holds = chi_square(sum, count, least, most);
                Judged { value: sum / count, of: sure.len() as u64, holds }
            }
            Asked::OverBound { quantity, most } => {
                let sum: f64 = squares(&|seen| seen.over_bound[quantity]);
                let holds = chi_square(sum, count, 0.0, most * most);
                Judged { value: (sum / count).sqrt(), of, holds }
            }
            Asked::Rms { most } => {
                let sum: f64 = squares(&|seen| seen.bins);
                let holds = chi_square(sum / (most * most), count, 0.0, 1.0);
                Judged { value: (sum / count).sqrt(), of, holds }
            }
            Asked::Snr { most_db } => {
                let mean = near.iter().map(|seen| seen.snr_db).sum::<f64>() / count;
                let sum: f64 = squares(&|seen| seen.snr_db - mean);
                // The normal distribution's 5 sigma have nearly this risk.
                let chance = 5.0 * (sum / count / count).sqrt();
                Judged { value: mean, of, holds: mean.abs() <= most_db + chance }
            }
            Asked::Sigma { most } => {
                let all = trials.iter().flat_map(|trial| &trial.seen);
                let mut sigmas: Vec<f64> = all.map(|seen| seen.sigma).collect();
                sigmas.sort_by(f64::total_cmp);
                let value = sigmas.get(sigmas.len() / 2).copied().unwrap_or(f64::NAN);
                Judged { value, of: sigmas.len() as u64, holds: value <= most }
            }
        }
    }
}

/// Whether a count is not too unlikely where the share is `p`.
fn tail(all: u64, p: f64, beyond: impl Fn(&Binomial) -> f64, asked: bool) -> bool {
    !asked || Binomial::new(p.clamp(0.0, 1.0), all).is_ok_and(|law| beyond(&law) > RISK)
}

/// Whether a sum of so many squares may have a mean in these bounds.
fn chi_square(sum: f64, count: f64, least: f64, most: f64) -> bool {
    let Ok(law) = ChiSquared::new(count) else { return false };
    let over = law.sf(sum / most) > RISK;
    let under = least <= 0.0 || law.cdf(sum / least) > RISK;
    count > 0.0 && sum.is_finite() && over && under
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is off by a factor of two is seen in a hundred trials; what is right is held.
    #[test]
    fn limits_tell_wrong_from_unlucky() {
        assert!(chi_square(100.0, 100.0, 0.9, 1.1) && chi_square(150.0, 100.0, 0.9, 1.1));
        assert!(!chi_square(400.0, 100.0, 0.9, 1.1) && !chi_square(25.0, 100.0, 0.9, 1.1));
        let trial =
            |verdict| Trial { seen: vec![Seen { verdict, ..Seen::NOTHING }], ..Trial::default() };
        let trials = |good: usize| {
            let good = (0..1000).map(move |i| if i < good { Verdict::Good } else { Verdict::Weak });
            good.map(trial).collect::<Vec<_>>()
        };
        let asked = Asked::Share { of: Event::Good, least: 0.5, most: 1.0 };
        assert!(asked.judge(&trials(500)).holds && asked.judge(&trials(450)).holds);
        assert!(!asked.judge(&trials(400)).holds && !asked.judge(&[]).holds);
        let asked = Asked::Share { of: Event::Good, least: 0.0, most: 0.001 };
        assert!(asked.judge(&trials(0)).holds && asked.judge(&trials(5)).holds);
        assert!(!asked.judge(&trials(15)).holds);
    }
}
