//! The impairments by name: one entry each. The command line, the report and the tests read this list.

use super::scene::{Range, Scene};
use super::{added, converter, digital, noise, sampling, tone};
use picket_dsp::methods::registry::Records;

/// A severity of an impairment.
#[derive(Debug, PartialEq)]
pub struct Key {
    /// What the user types.
    pub name: &'static str,
    /// Its unit, as in the names of JSON keys.
    pub unit: &'static str,
    /// Its severities unless told otherwise.
    pub usual: &'static [f64],
    /// The least and the most it may be.
    pub range: (f64, f64),
}

impl Key {
    const fn new(
        name: &'static str,
        unit: &'static str,
        usual: &'static [f64],
        range: (f64, f64),
    ) -> Self {
        Key { name, unit, usual, range }
    }

    /// The key of a JSON line: the name with its unit, in snake case.
    pub fn json(&self) -> String {
        let name = self.name.replace('-', "_");
        if self.unit.is_empty() || name == self.unit || name.ends_with(&format!("_{}", self.unit)) {
            name
        } else {
            format!("{name}_{}", self.unit)
        }
    }
}

/// Where the tone lies unless told otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// Eight bins or more from both ends.
    All,
    /// Bins 4 to 20, where slow things matter.
    Low,
    /// From bin 8 up to this severity, a share of Nyquist's frequency.
    Below(usize),
    /// In the band of this middle and width, shares of Nyquist's frequency.
    Within(usize, usize),
}

impl Place {
    /// Its ends, in bins.
    pub(super) fn range(self, values: &[f64], n: usize) -> Range {
        let nyquist = n as f64 / 2.0;
        let low = f64::min(8.0, nyquist / 8.0);
        let high = nyquist - low;
        match self {
            Place::All => (low, high),
            Place::Low => (low / 2.0, 2.5 * low),
            Place::Below(corner) => (low, (values[corner] * nyquist).clamp(low, high)),
            Place::Within(middle, width) => {
                let (middle, half) = (values[middle] * nyquist, values[width] * nyquist / 2.0);
                ((middle - half).clamp(low, high), (middle + half).clamp(low, high))
            }
        }
    }
}

/// Where on its way an impairment meets the signal. Two of them in one record are applied in this order, which is that of the way
/// but for the samples' times: what source and surroundings send is read at them, so they are set first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stage {
    /// How strong the tone is at the converter.
    Level,
    /// When samples are taken.
    Sampling,
    /// The source.
    Source,
    /// Other signals.
    Added,
    /// The shape of the noise.
    Noise,
    /// Mixers, whose outputs are I and Q.
    Mixer,
    /// The amplifier before the converter.
    Amplifier,
    /// The converter.
    Converter,
    /// The converter's codes.
    Codes,
    /// The lines of the bus that the codes take.
    Bus,
    /// How they are read.
    Reading,
}

/// An impairment.
pub struct Entry {
    /// The name that lists and tables use.
    pub name: &'static str,
    /// What it is, in one line.
    pub doc: &'static str,
    /// The severities.
    pub keys: &'static [Key],
    /// Which records can have it.
    pub records: Records,
    /// Whether its records have no noise.
    pub noiseless: bool,
    pub(super) place: Place,
    pub(super) stage: Stage,
    pub(super) apply: fn(&mut Scene, &[f64]),
}

impl std::fmt::Debug for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Entry {
    const fn new(
        name: &'static str,
        doc: &'static str,
        stage: Stage,
        keys: &'static [Key],
        apply: fn(&mut Scene, &[f64]),
    ) -> Self {
        let (records, place) = (Records::Both, Place::All);
        Entry { name, doc, keys, records, noiseless: false, place, stage, apply }
    }

    const fn at(self, place: Place) -> Self {
        Entry { place, ..self }
    }

    const fn real(self) -> Self {
        Entry { records: Records::Real, ..self }
    }

    const fn iq(self) -> Self {
        Entry { records: Records::Iq, ..self }
    }

    /// The severities of every key unless told otherwise.
    pub(super) fn defaults(&self) -> Vec<Vec<f64>> {
        self.keys.iter().map(|key| key.usual.to_vec()).collect()
    }
}

const FS: &str = "fs";
const DB: &str = "db";
const BINS: &str = "bins";
const SAMPLES: &str = "samples";
const RAD: &str = "rad";
const LSB: &str = "lsb";
const ONE: (f64, f64) = (0.0, 1.0);
const MANY: (f64, f64) = (0.0, 1e4);
const LEVEL: (f64, f64) = (-120.0, 40.0);
const CORNER: (f64, f64) = (1e-3, 10.0);

/// The lists, by the names that stand for every impairment of a list, each with its heading.
pub const GROUPS: [(&str, &[Entry], &str); 3] = [
    ("all", LIST, "Impairments, with the severities they have unless told otherwise:"),
    (
        "signals",
        SIGNALS,
        "Signals that are no steady tone, no part of \"all\"; \"signals\" is every one:",
    ),
    (
        "front-end",
        FRONT_END,
        "Faults of a digital front end, no part of \"all\"; \"front-end\" is every one:",
    ),
];

/// Faults of a digital front end. They are asked for by their names, and are no part of `all`: most of them give lines as strong as
/// the tone, and what tells of them is tested apart (host-tests, `front_end`).
pub const FRONT_END: &[Entry] = &[
    Entry::new(
        "wrap",
        "a tone so much beyond the rails, whose codes go on at the other end",
        Stage::Level,
        &[Key::new("over-db", DB, &[0.1, 1.0, 6.0], (0.0, 40.0))],
        digital::wrap,
    ),
    Entry::new(
        "swapped",
        "the two samples of each word change places",
        Stage::Reading,
        &[],
        digital::swapped,
    )
    .real(),
    Entry::new(
        "wrong-sign",
        "codes that count from 0 are read as signed ones, or the other way round",
        Stage::Reading,
        &[],
        digital::wrong_sign,
    ),
    Entry::new(
        "stuck-bit",
        "a bit of the codes, 0 the lowest, that is always low (0) or high (1)",
        Stage::Bus,
        &[Key::new("bit", "", &[4.0, 8.0], (0.0, 15.0)), Key::new("level", "", &[0.0, 1.0], ONE)],
        digital::stuck_bit,
    ),
    Entry::new(
        "missing-codes",
        "codes that never come, so many at each change of the upper three bits",
        Stage::Codes,
        &[Key::new("lsb", LSB, &[4.0, 16.0], MANY)],
        digital::missing_codes,
    ),
    Entry::new(
        "stale-buffer",
        "the end of the block, this share of it, is the end of the block before",
        Stage::Sampling,
        &[Key::new("share", "", &[0.25, 0.5], ONE)],
        digital::stale_buffer,
    ),
];

/// Signals that are no steady tone, however good the front end is. They are asked for by their names, and are no part of `all`: a width of the
/// carrier's own moves it by more than its noise says, and no test of one block can see that.
pub const SIGNALS: &[Entry] = &[
    Entry::new(
        "burst",
        "a particle in a laser's fringes: a Gaussian envelope, so many blocks wide, on this pedestal",
        Stage::Source,
        &[
            Key::new("deviation", "blocks", &[0.05, 0.1, 0.2, 0.35], (1e-3, 1e3)),
            Key::new("pedestal", "", &[0.0, 1.0], MANY),
        ],
        tone::burst,
    ),
    Entry::new(
        "particles",
        "so many such particles a block in a steady flow, at random; the flow's frequency is true",
        Stage::Source,
        &[
            // Each particle is in each sample: more of them, or longer ones, would take minutes.
            Key::new("rate", "", &[1.0, 4.0], (1e-2, 100.0)),
            Key::new("deviation", "blocks", &[0.1], (1e-3, 10.0)),
        ],
        tone::particles,
    ),
    Entry::new(
        "speckle",
        "the envelope of a rough surface that moves, full width at half of its height; the carrier is true",
        Stage::Source,
        &[Key::new("bandwidth", BINS, &[0.03, 0.1, 0.3, 1.0], (1e-3, 1e3))],
        tone::speckle,
    ),
    Entry::new(
        "linewidth",
        "a laser's Lorentzian line, full width at half of its height; the carrier is true",
        Stage::Source,
        &[Key::new("width", BINS, &[0.003, 0.01, 0.03, 0.1], (0.0, 1e3))],
        tone::linewidth,
    ),
    Entry::new(
        "blades",
        "a fan before the body, that hides so much of it, so many blades a block",
        Stage::Source,
        &[
            Key::new("depth", "", &[0.1, 0.5], ONE),
            Key::new("count", "", &[3.0, 10.0], (1e-3, 1e4)),
        ],
        tone::blades,
    ),
    Entry::new(
        "fm",
        "a frequency that swings by so much to each side, in so many cycles a block",
        Stage::Source,
        &[
            Key::new("deviation", BINS, &[0.3, 3.0], MANY),
            Key::new("cycles", "cycles", &[0.5, 3.0, 10.0], (1e-3, 1e4)),
        ],
        tone::fm,
    ),
    Entry::new(
        "keying",
        "a tone that is on or off at random, bit by bit, so many a block",
        Stage::Source,
        &[Key::new("bits", "", &[4.0, 16.0], (1e-3, 1e4))],
        tone::keying,
    ),
];

/// Every impairment of `all`.
pub const LIST: &[Entry] = &[
    Entry::new("none", "nothing: a tone in white noise", Stage::Source, &[], |_, _| {}),
    Entry::new(
        "dc",
        "a constant offset",
        Stage::Added,
        &[Key::new("fs", FS, &[0.01, 0.05], ONE)],
        added::dc,
    )
    .at(Place::Low),
    Entry::new(
        "hum",
        "a sine of a few cycles a block",
        Stage::Added,
        &[Key::new("cycles", "cycles", &[0.3, 1.5], MANY), Key::new("fs", FS, &[0.01, 0.05], ONE)],
        added::hum,
    )
    .at(Place::Low),
    Entry::new(
        "drift",
        "a straight line (order 1) or a parabola (2) over the block",
        Stage::Added,
        &[Key::new("fs", FS, &[0.01, 0.05], ONE), Key::new("order", "", &[1.0, 2.0], (1.0, 2.0))],
        added::drift,
    )
    .at(Place::Low),
    Entry::new(
        "harmonics",
        "the second harmonic and the third, each so much below the tone, folded",
        Stage::Added,
        &[Key::new("level-db", DB, &[-40.0, -20.0], LEVEL)],
        added::harmonics,
    ),
    Entry::new(
        "clip-analogue",
        "an amplifier that ends so much below the tone's crest, before the converter",
        Stage::Amplifier,
        &[Key::new("over-db", DB, &[0.5, 3.0], LEVEL)],
        converter::clip_analogue,
    ),
    Entry::new(
        "clip-converter",
        "a tone so much beyond the converter's rails",
        Stage::Level,
        &[Key::new("over-db", DB, &[0.1, 1.0, 6.0], LEVEL)],
        converter::clip_converter,
    ),
    Entry::new(
        "impulses",
        "single samples that stick out, anywhere",
        Stage::Added,
        &[
            Key::new("count", "samples", &[1.0, 5.0], MANY),
            Key::new("fs", FS, &[0.1, 0.5], (0.0, 10.0)),
        ],
        added::impulses,
    ),
    Entry::new(
        "lost",
        "samples that are missing in one place",
        Stage::Sampling,
        &[Key::new("count", "samples", &[1.0, 4.0, 16.0], MANY)],
        sampling::lost,
    ),
    Entry::new(
        "doubled",
        "a sample that comes again, so many times",
        Stage::Sampling,
        &[Key::new("count", "samples", &[1.0, 4.0, 16.0], MANY)],
        sampling::doubled,
    ),
    Entry::new(
        "inl",
        "a bent characteristic of the converter: so many codes at most",
        Stage::Converter,
        &[Key::new("lsb", LSB, &[4.0, 16.0], MANY)],
        converter::inl,
    ),
    Entry::new(
        "steps",
        "step errors of the converter: its upper bits weigh wrong, by so many codes the top one",
        Stage::Converter,
        &[Key::new("lsb", LSB, &[1.0, 8.0], MANY)],
        converter::steps,
    ),
    Entry {
        noiseless: true,
        ..Entry::new(
            "quantise",
            "rounding alone, without noise: a tone of so many codes",
            Stage::Level,
            &[Key::new("codes", "", &[2.0, 20.0, 200.0], (0.5, 1e6))],
            converter::quantise,
        )
    },
    Entry::new(
        "chirp",
        "a frequency that changes evenly, so much over the block",
        Stage::Source,
        &[Key::new("rate", BINS, &[0.05, 0.1, 0.3, 0.5, 1.0], MANY)],
        tone::chirp,
    ),
    Entry::new(
        "am",
        "an amplitude that swings by this share of itself, in so many cycles a block",
        Stage::Source,
        &[
            Key::new("depth", "", &[0.1, 0.5], ONE),
            Key::new("cycles", "cycles", &[0.3, 0.5, 1.0], MANY),
        ],
        tone::am,
    ),
    Entry::new(
        "phase-walk",
        "a phase that wanders at random, rms so far over the block",
        Stage::Source,
        &[Key::new("rms", RAD, &[0.03, 0.1, 0.3], MANY)],
        tone::phase_walk,
    ),
    Entry::new(
        "phase-jump",
        "a phase that jumps once, anywhere",
        Stage::Source,
        &[Key::new("size", RAD, &[0.05, 0.1, 0.3], MANY)],
        tone::phase_jump,
    ),
    Entry::new(
        "frequency-step",
        "a frequency that changes once, anywhere",
        Stage::Source,
        &[Key::new("size", BINS, &[0.1, 1.0, 10.0], MANY)],
        tone::frequency_step,
    ),
    Entry::new(
        "second-tone",
        "a weaker tone so far beside",
        Stage::Added,
        &[
            Key::new("offset", BINS, &[0.3, 0.5, 0.75, 1.0, 2.0, 10.0], MANY),
            Key::new("level-db", DB, &[-10.0, -20.0, -30.0, -40.0], LEVEL),
        ],
        added::second_tone,
    ),
    Entry::new(
        "tone-burst",
        "a tone anywhere in the band that lasts for this share of the block",
        Stage::Added,
        &[Key::new("share", "", &[0.2], ONE), Key::new("level-db", DB, &[-6.0], LEVEL)],
        added::tone_burst,
    ),
    Entry::new(
        "noise-burst",
        "more noise in this share of the block, so strong against the tone",
        Stage::Added,
        &[Key::new("share", "", &[0.1], ONE), Key::new("level-db", DB, &[-10.0, 0.0], LEVEL)],
        added::noise_burst,
    ),
    Entry::new(
        "noise-slope",
        "noise that rises by so many decibels over the band",
        Stage::Noise,
        &[Key::new("rise-db", DB, &[-20.0, 20.0, 40.0], (-80.0, 80.0))],
        noise::slope,
    ),
    Entry::new(
        "noise-notch",
        "a dent in the noise, beside the tone",
        Stage::Noise,
        &[
            Key::new("level-db", DB, &[-20.0], (-80.0, 0.0)),
            Key::new("width", BINS, &[10.0, 40.0], (0.1, 1e4)),
            Key::new("offset", BINS, &[0.0, 20.0], MANY),
        ],
        noise::bump,
    ),
    Entry::new(
        "noise-hump",
        "a bump of the noise, beside the tone",
        Stage::Noise,
        &[
            Key::new("level-db", DB, &[10.0, 20.0], (0.0, 80.0)),
            Key::new("width", BINS, &[10.0, 40.0], (0.1, 1e4)),
            Key::new("offset", BINS, &[0.0, 20.0], MANY),
        ],
        noise::bump,
    ),
    Entry::new(
        "noise-flicker",
        "noise whose power goes with this power of one over the frequency",
        Stage::Noise,
        &[Key::new("power", "", &[1.0, 2.0], (0.0, 4.0))],
        noise::flicker,
    ),
    Entry::new(
        "noise-low-pass",
        "noise behind a steep filter (Butterworth's), its corner a share of Nyquist's frequency",
        Stage::Noise,
        &[
            Key::new("corner", "", &[0.5, 0.25, 0.12], CORNER),
            Key::new("order", "", &[8.0], (1.0, 16.0)),
        ],
        noise::low_pass,
    )
    .at(Place::Below(0)),
    Entry::new(
        "noise-rc",
        "noise behind sections of resistor and capacitor; 0.6 is docs/board.md's filter at 2.4 MS/s",
        Stage::Noise,
        &[
            Key::new("corner", "", &[0.6, 0.25], CORNER),
            Key::new("sections", "", &[2.0], (1.0, 8.0)),
        ],
        noise::rc,
    ),
    Entry::new(
        "noise-band-pass",
        "noise in a band alone, its middle and width shares of Nyquist's frequency",
        Stage::Noise,
        &[Key::new("middle", "", &[0.5], ONE), Key::new("width", "", &[0.125, 0.5], (1e-3, 1.0))],
        noise::band_pass,
    )
    .at(Place::Within(0, 1)),
    Entry::new(
        "start",
        "a tone that is not there for this share of the block, then begins",
        Stage::Source,
        &[Key::new("share", "", &[0.2, 0.5, 0.8], ONE)],
        tone::start,
    ),
    Entry::new(
        "decay",
        "a tone that dies away, to 1/e in so many blocks",
        Stage::Source,
        &[Key::new("time", "blocks", &[2.0, 1.0, 0.5], (1e-3, 1e6))],
        tone::decay,
    ),
    Entry::new(
        "jitter",
        "a clock that trembles, rms",
        Stage::Sampling,
        &[Key::new("rms", SAMPLES, &[0.01, 0.1], MANY)],
        sampling::jitter,
    ),
    Entry::new(
        "skew",
        "two converters in turn, the second so late",
        Stage::Sampling,
        &[Key::new("late", SAMPLES, &[0.02, 0.2], MANY)],
        sampling::skew,
    ),
    Entry::new(
        "iq-gain",
        "Q so much stronger than I",
        Stage::Mixer,
        &[Key::new("level-db", DB, &[0.1, 1.0, 3.0], LEVEL)],
        converter::iq_gain,
    )
    .iq(),
    Entry::new(
        "iq-phase",
        "Q so far from right angles",
        Stage::Mixer,
        &[Key::new("angle", "deg", &[1.0, 5.0, 20.0], (-180.0, 180.0))],
        converter::iq_phase,
    )
    .iq(),
    Entry::new(
        "iq-delay",
        "Q so late",
        Stage::Sampling,
        &[Key::new("late", SAMPLES, &[0.1, 1.0], MANY)],
        sampling::iq_delay,
    )
    .iq(),
    Entry::new(
        "iq-dead",
        "nothing on Q (part 1) or on I (0)",
        Stage::Mixer,
        &[Key::new("part", "", &[0.0, 1.0], ONE)],
        converter::iq_dead,
    )
    .iq(),
];
