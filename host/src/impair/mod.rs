//! Records as front ends deliver them: one tone in noise, and one thing wrong with it.
//!
//! The generator knows nothing of the estimators. A record depends on the generator's seed and stream alone,
//! and says its own truth: the mean frequency of the tone over the block.

mod added;
mod converter;
mod digital;
mod grammar;
mod list;
mod noise;
mod sampling;
mod scene;
mod tone;

pub use grammar::help;
pub use list::{Entry, FRONT_END, Key, LIST};
pub use scene::{Impaired, Scene, Setup};

use crate::simulate::Kind;
use picket::acquire::sample::Record;
use rand_chacha::ChaCha8Rng;

/// One impairment at one severity.
#[derive(Clone, Debug, PartialEq)]
pub struct Impairment {
    entry: &'static Entry,
    values: Vec<f64>,
}

impl Impairment {
    /// The impairments that a list names, in its order: `NAME[:KEY=VALUE[/VALUE]...[,KEY=...]]`, names apart by
    /// commas, `all` for every one. A key that is not named has its default severities; every combination of
    /// severities is one impairment. An error is one line.
    pub fn parse(text: &str) -> Result<Vec<Self>, String> {
        grammar::parse(text)
    }

    /// Every impairment of [`LIST`] at its default severities.
    pub fn all() -> Vec<Self> {
        LIST.iter().flat_map(|entry| grammar::grid(entry, &entry.defaults())).collect()
    }

    /// Every fault of [`FRONT_END`] at its default severities.
    pub fn front_end() -> Vec<Self> {
        FRONT_END.iter().flat_map(|entry| grammar::grid(entry, &entry.defaults())).collect()
    }

    /// What there is to know of it.
    pub const fn entry(&self) -> &'static Entry {
        self.entry
    }

    /// The name that lists and tables use.
    pub const fn name(&self) -> &'static str {
        self.entry.name
    }

    /// The severities, each with its key.
    pub fn severities(&self) -> impl Iterator<Item = (&'static Key, f64)> {
        self.entry.keys.iter().zip(self.values.iter().copied())
    }

    /// The severities as a user would type them: `offset=0.5,level-db=-20`.
    pub fn label(&self) -> String {
        let parts: Vec<String> =
            self.severities().map(|(key, value)| format!("{}={value}", key.name)).collect();
        parts.join(",")
    }

    /// Whether it is one of records of kind `R`: an I/Q converter's are of I/Q records only.
    pub const fn fits<R: Record>(&self) -> bool {
        self.entry.records.include::<R>()
    }

    /// Whether its records have noise: a converter's rounding alone is measured without.
    pub fn noisy(&self) -> bool {
        !self.entry.noiseless
    }

    /// The next record of `rng`. The tone's place and phase are drawn first: in one range of bins all
    /// impairments of one seed have the same.
    pub fn record<R: Kind>(&self, setup: &Setup, rng: &mut ChaCha8Rng) -> Impaired {
        self.either(R::IQ, setup, rng)
    }

    /// Not generic, so that it is compiled here, once.
    fn either(&self, iq: bool, setup: &Setup, rng: &mut ChaCha8Rng) -> Impaired {
        let range = setup.bins.unwrap_or_else(|| self.entry.place.range(&self.values, setup.n));
        let mut scene = Scene::new(iq, setup, range, rng);
        (self.entry.apply)(&mut scene, &self.values);
        scene.record(setup)
    }
}
