//! Records as front ends deliver them: one tone in noise, with one disturbance or two.
//!
//! Each is a change of a [scene](picket_simulator::Scene), whose records know nothing of the estimators. A record depends on the generator's
//! seed and stream alone, and says its own truth: the mean frequency of the tone over the block, or of a carrier with a width of its own
//! that of the carrier.

mod grammar;
mod list;
mod making;

pub use grammar::help;
pub use list::{Entry, FRONT_END, GROUPS, Key, LIST, SIGNALS};
pub use making::{Impaired, Setup};

use crate::simulate::Kind;
use making::Making;
use picket_dsp::acquire::sample::Record;
use rand_chacha::ChaCha8Rng;

/// One impairment at one severity, or a pair of them in one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Impairment {
    /// In the order in which the user names them.
    parts: Vec<Part>,
}

/// One impairment at one severity.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    entry: &'static Entry,
    values: Vec<f64>,
}

impl Part {
    /// The severities as a user would type them: `offset=0.5,level-db=-20`.
    fn label(&self) -> String {
        let severities = self.entry.keys.iter().zip(&self.values);
        let parts: Vec<String> =
            severities.map(|(key, value)| format!("{}={value}", key.name)).collect();
        parts.join(",")
    }
}

impl Impairment {
    /// The impairments that a list names, in its order: `NAME[:KEY=VALUE[/VALUE]...[,KEY=...]]`, names apart by
    /// commas, two of them joined by a plus for one record with both, `all` for every one. A key that is not named has its default
    /// severities; every combination of severities is one impairment. An error is one line.
    pub fn parse(text: &str) -> Result<Vec<Self>, String> {
        grammar::parse(text)
    }

    /// Every impairment of [`LIST`] at its default severities.
    pub fn all() -> Vec<Self> {
        Self::each(LIST)
    }

    /// Every fault of [`FRONT_END`] at its default severities.
    pub fn front_end() -> Vec<Self> {
        Self::each(FRONT_END)
    }

    /// Every signal of [`SIGNALS`] at its default severities.
    pub fn signals() -> Vec<Self> {
        Self::each(SIGNALS)
    }

    fn each(entries: &'static [Entry]) -> Vec<Self> {
        entries.iter().flat_map(|entry| grammar::grid(&[(entry, entry.defaults())])).collect()
    }

    fn entries(&self) -> impl Iterator<Item = &'static Entry> {
        self.parts.iter().map(|part| part.entry)
    }

    /// The name that lists and tables use; of a pair both, joined by a plus.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.entries().map(|entry| entry.name).collect();
        names.join("+")
    }

    /// The severities, each by the key that a JSON line has for it; a pair's keys begin with the name of the impairment.
    pub fn severities(&self) -> impl Iterator<Item = (String, f64)> {
        let pair = self.parts.len() > 1;
        self.parts.iter().flat_map(move |Part { entry, values }| {
            let of = |key: &Key| match pair {
                true => format!("{}_{}", entry.name.replace('-', "_"), key.json()),
                false => key.json(),
            };
            entry.keys.iter().map(of).zip(values.iter().copied()).collect::<Vec<_>>()
        })
    }

    /// The severities as a user would type them: `offset=0.5,level-db=-20`. A plus separates the severities of a pair.
    pub fn label(&self) -> String {
        let labels: Vec<String> =
            self.parts.iter().map(Part::label).filter(|label| !label.is_empty()).collect();
        labels.join(" + ")
    }

    /// Whether it is one of records of kind `R`: an I/Q converter's are of I/Q records only.
    pub fn fits<R: Record>(&self) -> bool {
        self.entries().all(|entry| entry.records.include::<R>())
    }

    /// Whether its records have noise: a converter's rounding alone is measured without.
    pub fn noisy(&self) -> bool {
        !self.entries().any(|entry| entry.noiseless)
    }

    /// The next record of `rng`. The tone's place and phase are drawn first: in one range of bins all
    /// impairments of one seed have the same.
    pub fn record<R: Kind>(&self, setup: &Setup, rng: &mut ChaCha8Rng) -> Impaired {
        self.either(R::IQ, setup, rng)
    }

    /// Not generic, so that it is compiled here, once.
    fn either(&self, iq: bool, setup: &Setup, rng: &mut ChaCha8Rng) -> Impaired {
        let mut parts: Vec<&Part> = self.parts.iter().collect();
        // By their names, so that a pair is the same either way round; what says how strong the tone is comes first.
        parts.sort_by_key(|part| (part.entry.concerns, part.entry.name));
        let places = parts.iter().map(|part| part.entry.place.range(&part.values, setup.n));
        let range = setup.bins.or_else(|| places.reduce(narrower)).unwrap_or_default();
        let mut making = Making::new(iq, setup, range, rng);
        for part in parts {
            (part.entry.apply)(&mut making, &part.values);
        }
        making.record(setup)
    }
}

/// What two ranges of bins have in common; else the narrower one, where a tone must be to show what is meant.
fn narrower(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let both = (a.0.max(b.0), a.1.min(b.1));
    let width = |range: (f64, f64)| range.1 - range.0;
    match width(both) >= 0.0 {
        true => both,
        false if width(a) < width(b) => a,
        false => b,
    }
}

/// As a user would type it.
impl std::fmt::Display for Impairment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let typed = |part: &Part| match part.label() {
            label if label.is_empty() => part.entry.name.to_owned(),
            label => format!("{}:{label}", part.entry.name),
        };
        f.write_str(&self.parts.iter().map(typed).collect::<Vec<_>>().join("+"))
    }
}
