//! The impairments by name: one entry each. The command line, the report and the tests read this list.

use super::making::{Making, Range};
use picket_dsp::methods::registry::Records;
use picket_simulator::Value;
use picket_simulator::scene::{Change, Density, Impulses, NoiseBurst, Place as At, StuckBit, Tone};
use rand::RngExt;
use std::f64::consts::TAU;

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

/// What an impairment says that no second one can say, or that others need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Concerns {
    /// How strong the tone is at the converter: what refers to it comes after.
    Level,
    /// The shape of the noise.
    Noise,
    /// Neither.
    Else,
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
    pub(super) concerns: Concerns,
    pub(super) apply: fn(&mut Making, &[f64]),
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
        keys: &'static [Key],
        apply: fn(&mut Making, &[f64]),
    ) -> Self {
        let (records, place, concerns) = (Records::Both, Place::All, Concerns::Else);
        Entry { name, doc, keys, records, noiseless: false, place, concerns, apply }
    }

    const fn level(self) -> Self {
        Entry { concerns: Concerns::Level, ..self }
    }

    const fn noise(self) -> Self {
        Entry { concerns: Concerns::Noise, ..self }
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
    ("all", LIST, "Impairments, with their default severities:"),
    (
        "signals",
        SIGNALS,
        "Signals other than a steady tone, not part of \"all\"; \"signals\" selects all of them:",
    ),
    (
        "front-end",
        FRONT_END,
        "Faults of a digital front end, no part of \"all\"; \"front-end\" is every one:",
    ),
];

/// Longer than any time at which a sample is taken, in blocks.
const FOR_EVER: f64 = 1e30;

/// The factor of an amplitude for decibels.
fn factor(db: f64) -> f64 {
    10f64.powf(db / 20.0)
}

/// A tone so many decibels beyond the rails.
fn beyond_the_rails(of: &mut Making, v: &[f64]) {
    of.amplitude = of.rail * factor(v[0]);
}

/// A jump by so many turns, or so many bins, either way and anywhere.
fn jump(turns: f64, hz: f64) -> Change {
    let at_s = (0.0..1.0).into();
    Change::Jump { turns: Value::either_way(turns), hz: Value::either_way(hz), at_s }
}

/// A straight line over the block, or a parabola, so many codes at its ends. Samples may be taken before and after the block.
fn drift(codes: f64, bent: bool) -> Value {
    let line = |u: f64| codes * (2.0 * u - 1.0);
    if !bent {
        return Value::Over([-1e3, 1e3].map(|u| [u, line(u)]).into());
    }
    // Straight between points, which is off by 1e-4 of the whole at most.
    let parabola = |u: f64| codes * (1.5 * (2.0 * u - 1.0).powi(2) - 0.5);
    Value::Over(
        (-128..=256).map(|step| f64::from(step) / 128.0).map(|u| [u, parabola(u)]).collect(),
    )
}

/// A bump or a dent of the noise, beside the tone on either side.
fn bump(of: &mut Making, v: &[f64]) {
    let (level_db, width_hz, offset_hz) = (v[0].into(), v[1].into(), Value::either_way(v[2]));
    of.shape(Density::Bump { level_db, width_hz, offset_hz, at_hz: None });
}

/// Faults of a digital front end. They are asked for by their names, and are no part of `all`: most of them give lines as strong as
/// the tone, and what tells of them is tested apart (host-tests, `front_end`).
pub const FRONT_END: &[Entry] = &[
    Entry::new(
        "wrap",
        "overdriven tone whose codes wrap around",
        &[Key::new("over-db", DB, &[0.1, 1.0, 6.0], (0.0, 40.0))],
        |of, v| {
            beyond_the_rails(of, v);
            of.converter.wraps = true;
        },
    )
    .level(),
    Entry::new("swapped", "the two samples of each word are swapped", &[], |of, _| {
        of.converter.swapped = true
    })
    .real(),
    Entry::new("wrong-sign", "unsigned codes read as signed ones, or the reverse", &[], |of, _| {
        of.converter.wrong_sign = true
    }),
    Entry::new(
        "stuck-bit",
        "a bit of the codes (0: the lowest) that is always low (0) or high (1)",
        &[Key::new("bit", "", &[4.0, 8.0], (0.0, 15.0)), Key::new("level", "", &[0.0, 1.0], ONE)],
        |of, v| {
            // A converter of fewer bits has the highest one.
            let bit = (v[0].round() as u32).min(of.converter.bits - 1);
            of.converter.stuck_bit = Some(StuckBit { bit, high: v[1] > 0.5 });
        },
    ),
    Entry::new(
        "missing-codes",
        "missing codes, LSB of them at each change of the upper three bits",
        &[Key::new("lsb", LSB, &[4.0, 16.0], MANY)],
        |of, v| of.converter.missing_codes = v[0].round() as usize,
    ),
    Entry::new(
        "stale-buffer",
        "the last SHARE of the block is that of the block before",
        &[Key::new("share", "", &[0.25, 0.5], ONE)],
        |of, v| {
            let (at, count) = (((1.0 - v[0]) * of.n).into(), of.n.into());
            of.converter.stale = Some(At { at, count });
        },
    ),
];

/// Signals that are no steady tone, however good the front end is. They are asked for by their names, and are no part of `all`: a width of the
/// carrier's own moves it by more than its noise says, and no test of one block can see that.
pub const SIGNALS: &[Entry] = &[
    Entry::new(
        "burst",
        "a particle in a laser's fringes: a Gaussian envelope with this deviation, on this pedestal",
        &[
            Key::new("deviation", "blocks", &[0.05, 0.1, 0.2, 0.35], (1e-3, 1e3)),
            Key::new("pedestal", "", &[0.0, 1.0], MANY),
        ],
        |of, v| {
            let burst = Change::Burst {
                middle_s: of.rng.random_range(0.0..1.0).into(),
                deviation_s: v[0].into(),
            };
            of.change(burst.clone());
            if v[1] > 0.0 {
                // The pedestal is the light without its fringes: a real waveform in any direction of the plane of I and Q.
                let phase_turns = if of.iq { (0.0..1.0).into() } else { [0.0, 0.5].into() };
                let pedestal = Tone { phase_turns, ..Tone::default() };
                of.add(pedestal, 20.0 * v[1].log10(), vec![burst]);
            }
        },
    ),
    Entry::new(
        "particles",
        "particles of a steady flow at random, RATE per block; the true frequency is the flow's",
        &[
            // Each particle is in each sample: more of them, or longer ones, would take minutes.
            Key::new("rate", "", &[1.0, 4.0], (1e-2, 100.0)),
            Key::new("deviation", "blocks", &[0.1], (1e-3, 10.0)),
        ],
        |of, v| {
            // Particles are of different sizes, and cross the beam at different distances.
            let [per_s, deviation_s, nepers] = [v[0], v[1], 2.0].map(Value::Fixed);
            of.change(Change::Bursts { per_s, deviation_s, nepers });
        },
    ),
    Entry::new(
        "speckle",
        "the envelope of a rough surface that moves, full width at half of its height; the carrier is true",
        &[Key::new("bandwidth", BINS, &[0.03, 0.1, 0.3, 1.0], (1e-3, 1e3))],
        |of, v| of.change(Change::Speckle { bandwidth_hz: v[0].into() }),
    ),
    Entry::new(
        "linewidth",
        "a laser's Lorentzian line, full width at half of its height; the carrier is true",
        &[Key::new("width", BINS, &[0.003, 0.01, 0.03, 0.1], (0.0, 1e3))],
        |of, v| of.linewidth = Some(Change::Walk { linewidth_hz: v[0].into() }),
    ),
    Entry::new(
        "blades",
        "fan in front of the target: blocks DEPTH of the echo, COUNT blades per block",
        &[
            Key::new("depth", "", &[0.1, 0.5], ONE),
            Key::new("count", "", &[3.0, 10.0], (1e-3, 1e4)),
        ],
        |of, v| of.change(Change::Hidden { depth: v[0].into(), rate_hz: v[1].into() }),
    ),
    Entry::new(
        "fm",
        "frequency modulation: DEVIATION to each side, CYCLES per block",
        &[
            Key::new("deviation", BINS, &[0.3, 3.0], MANY),
            Key::new("cycles", "cycles", &[0.5, 3.0, 10.0], (1e-3, 1e4)),
        ],
        |of, v| of.change(Change::Fm { deviation_hz: v[0].into(), rate_hz: v[1].into() }),
    ),
    Entry::new(
        "keying",
        "on-off keying at random, BITS per block",
        &[Key::new("bits", "", &[4.0, 16.0], (1e-3, 1e4))],
        |of, v| of.change(Change::Keyed { bits_hz: v[0].into(), by_turns: false }),
    ),
];

/// Every impairment of `all`.
pub const LIST: &[Entry] = &[
    Entry::new("none", "nothing: a tone in white noise", &[], |_, _| {}),
    Entry::new(
        "dc",
        "a constant offset",
        &[Key::new("fs", FS, &[0.01, 0.05], ONE)],
        |of, v| of.hum(0.0, v[0], Some(0.0.into())),
    )
    .at(Place::Low),
    Entry::new(
        "hum",
        "a sine of a few cycles a block",
        &[Key::new("cycles", "cycles", &[0.3, 1.5], MANY), Key::new("fs", FS, &[0.01, 0.05], ONE)],
        |of, v| of.hum(v[0], v[1], None),
    )
    .at(Place::Low),
    Entry::new(
        "drift",
        "a straight line (order 1) or a parabola (2) over the block",
        &[Key::new("fs", FS, &[0.01, 0.05], ONE), Key::new("order", "", &[1.0, 2.0], (1.0, 2.0))],
        |of, v| of.receiver.drift = Some(drift(v[0] * of.rail, v[1] > 1.5)),
    )
    .at(Place::Low),
    Entry::new(
        "harmonics",
        "second and third harmonic, each LEVEL-DB below the tone, folded",
        &[Key::new("level-db", DB, &[-40.0, -20.0], LEVEL)],
        |of, v| of.tone.harmonics = vec![[2.0, v[0]], [3.0, v[0]]],
    ),
    Entry::new(
        "clip-analogue",
        "amplifier that clips OVER-DB below the tone's crest, before the converter",
        &[Key::new("over-db", DB, &[0.5, 3.0], LEVEL)],
        |of, v| of.receiver.limit = Some(of.amplitude * factor(-v[0])),
    ),
    Entry::new(
        "clip-converter",
        "tone that exceeds the converter's rails by OVER-DB",
        &[Key::new("over-db", DB, &[0.1, 1.0, 6.0], LEVEL)],
        beyond_the_rails,
    ).level(),
    Entry::new(
        "impulses",
        "single samples that stick out, anywhere",
        &[
            Key::new("count", "samples", &[1.0, 5.0], MANY),
            Key::new("fs", FS, &[0.1, 0.5], (0.0, 10.0)),
        ],
        |of, v| {
            let (count, codes) = (v[0].into(), (v[1] * of.rail).into());
            of.receiver.impulses = Some(Impulses { count, codes });
        },
    ),
    Entry::new(
        "lost",
        "COUNT samples missing in one place",
        &[Key::new("count", "samples", &[1.0, 4.0, 16.0], MANY)],
        |of, v| of.converter.lost = Some(At { at: of.anywhere(), count: v[0].into() }),
    ),
    Entry::new(
        "doubled",
        "a sample that is repeated COUNT times",
        &[Key::new("count", "samples", &[1.0, 4.0, 16.0], MANY)],
        |of, v| of.converter.repeated = Some(At { at: of.anywhere(), count: v[0].into() }),
    ),
    Entry::new(
        "inl",
        "integral nonlinearity of the converter, at most LSB codes",
        &[Key::new("lsb", LSB, &[4.0, 16.0], MANY)],
        |of, v| of.converter.inl_codes = v[0].into(),
    ),
    Entry::new(
        "steps",
        "step errors of the converter: wrong weights of its upper bits, LSB codes for the top one",
        &[Key::new("lsb", LSB, &[1.0, 8.0], MANY)],
        |of, v| of.converter.step_codes = v[0].into(),
    ),
    Entry {
        noiseless: true,
        ..Entry::new(
            "quantise",
            "rounding without noise: a tone with an amplitude of CODES",
            &[Key::new("codes", "", &[2.0, 20.0, 200.0], (0.5, 1e6))],
            |of, v| {
                of.amplitude = v[0];
                of.receiver.noise.snr_db = None;
                // It meets the codes anywhere.
                of.receiver.offset = [(-0.5..0.5).into(), (-0.5..0.5).into()];
            },
        ).level()
    },
    Entry::new(
        "chirp",
        "frequency that changes evenly, by RATE over the block",
        &[Key::new("rate", BINS, &[0.05, 0.1, 0.3, 0.5, 1.0], MANY)],
        |of, v| {
            // The mean is that in the middle of the samples.
            let (hz_per_s, at_s) = (Value::either_way(v[0]), (0.5 - 0.5 / of.n).into());
            of.change(Change::Chirp { hz_per_s, at_s });
        },
    ),
    Entry::new(
        "am",
        "amplitude modulation by DEPTH, CYCLES per block",
        &[
            Key::new("depth", "", &[0.1, 0.5], ONE),
            Key::new("cycles", "cycles", &[0.3, 0.5, 1.0], MANY),
        ],
        |of, v| of.change(Change::Am { depth: v[0].into(), rate_hz: v[1].into() }),
    ),
    Entry::new(
        "phase-walk",
        "phase that wanders at random, by RMS over the block",
        &[Key::new("rms", RAD, &[0.03, 0.1, 0.3], MANY)],
        |of, v| of.change(Change::Walk { linewidth_hz: (v[0] * v[0] / TAU).into() }),
    ),
    Entry::new(
        "phase-jump",
        "phase that jumps once, anywhere",
        &[Key::new("size", RAD, &[0.05, 0.1, 0.3], MANY)],
        |of, v| of.change(jump(v[0] / TAU, 0.0)),
    ),
    Entry::new(
        "frequency-step",
        "a frequency that changes once, anywhere",
        &[Key::new("size", BINS, &[0.1, 1.0, 10.0], MANY)],
        |of, v| of.change(jump(0.0, v[0])),
    ),
    Entry::new(
        "second-tone",
        "a weaker tone at this distance",
        &[
            Key::new("offset", BINS, &[0.3, 0.5, 0.75, 1.0, 2.0, 10.0], MANY),
            Key::new("level-db", DB, &[-10.0, -20.0, -30.0, -40.0], LEVEL),
        ],
        |of, v| {
            let frequency_hz = Value::either_way(v[0]);
            of.add(Tone { frequency_hz, beside: Some(0), ..Tone::default() }, v[1], Vec::new());
        },
    ),
    Entry::new(
        "tone-burst",
        "a tone anywhere in the band that lasts for this share of the block",
        &[Key::new("share", "", &[0.2], ONE), Key::new("level-db", DB, &[-6.0], LEVEL)],
        |of, v| {
            let low = if of.iq { -0.5 * of.n } else { 0.0 };
            let tone = Tone { frequency_hz: (low..0.5 * of.n).into(), ..Tone::default() };
            let (from_s, for_s) = ((0.0..1.0 - v[0]).into(), v[0].into());
            of.add(tone, v[1], vec![Change::On { from_s, for_s }]);
        },
    ),
    Entry::new(
        "noise-burst",
        "more noise in SHARE of the block, at LEVEL-DB relative to the tone",
        &[Key::new("share", "", &[0.1], ONE), Key::new("level-db", DB, &[-10.0, 0.0], LEVEL)],
        |of, v| {
            let rms = (of.amplitude * factor(v[1]) / 2f64.sqrt()).into();
            let (from_s, for_s) = ((0.0..1.0 - v[0]).into(), v[0].into());
            of.receiver.noise_burst = Some(NoiseBurst { rms, from_s, for_s });
        },
    ),
    Entry::new(
        "noise-slope",
        "noise that rises by RISE-DB over the band",
        &[Key::new("rise-db", DB, &[-20.0, 20.0, 40.0], (-80.0, 80.0))],
        |of, v| of.shape(Density::Slope { rise_db: v[0].into() }),
    ).noise(),
    Entry::new(
        "noise-notch",
        "a notch in the noise, near the tone",
        &[
            Key::new("level-db", DB, &[-20.0], (-80.0, 0.0)),
            Key::new("width", BINS, &[10.0, 40.0], (0.1, 1e4)),
            Key::new("offset", BINS, &[0.0, 20.0], MANY),
        ],
        bump,
    ).noise(),
    Entry::new(
        "noise-hump",
        "a hump of the noise, near the tone",
        &[
            Key::new("level-db", DB, &[10.0, 20.0], (0.0, 80.0)),
            Key::new("width", BINS, &[10.0, 40.0], (0.1, 1e4)),
            Key::new("offset", BINS, &[0.0, 20.0], MANY),
        ],
        bump,
    ).noise(),
    Entry::new(
        "noise-flicker",
        "noise whose power falls with this power of the frequency",
        &[Key::new("power", "", &[1.0, 2.0], (0.0, 4.0))],
        |of, v| of.shape(Density::Flicker { power: v[0].into() }),
    ).noise(),
    Entry::new(
        "noise-low-pass",
        "noise behind a steep filter (Butterworth's), its corner a share of Nyquist's frequency",
        &[
            Key::new("corner", "", &[0.5, 0.25, 0.12], CORNER),
            Key::new("order", "", &[8.0], (1.0, 16.0)),
        ],
        |of, v| {
            of.shape(Density::LowPass { corner_hz: of.share_of_nyquist(v[0]), order: v[1] });
        },
    ).noise()
    .at(Place::Below(0)),
    Entry::new(
        "noise-rc",
        "noise behind sections of resistor and capacitor; 0.6 is docs/board.md's filter at 2.4 MS/s",
        &[
            Key::new("corner", "", &[0.6, 0.25], CORNER),
            Key::new("sections", "", &[2.0], (1.0, 8.0)),
        ],
        |of, v| of.shape(Density::Rc { corner_hz: of.share_of_nyquist(v[0]), sections: v[1] }),
    ).noise(),
    Entry::new(
        "noise-band-pass",
        "noise in one band; its middle and width are shares of Nyquist's frequency",
        &[Key::new("middle", "", &[0.5], ONE), Key::new("width", "", &[0.125, 0.5], (1e-3, 1.0))],
        |of, v| {
            let [middle_hz, width_hz] = [v[0], v[1]].map(|share| of.share_of_nyquist(share));
            of.shape(Density::BandPass { middle_hz, width_hz });
        },
    ).noise()
    .at(Place::Within(0, 1)),
    Entry::new(
        "start",
        "tone that starts after SHARE of the block",
        &[Key::new("share", "", &[0.2, 0.5, 0.8], ONE)],
        |of, v| of.change(Change::On { from_s: v[0].into(), for_s: FOR_EVER.into() }),
    ),
    Entry::new(
        "decay",
        "a tone that decays to 1/e in TIME",
        &[Key::new("time", "blocks", &[2.0, 1.0, 0.5], (1e-3, 1e6))],
        |of, v| of.change(Change::Decay { time_s: v[0].into(), from_s: 0.0.into() }),
    ),
    Entry::new(
        "jitter",
        "clock jitter, rms",
        &[Key::new("rms", SAMPLES, &[0.01, 0.1], MANY)],
        |of, v| of.converter.jitter_s = v[0] / of.n,
    ),
    Entry::new(
        "skew",
        "two converters in turn, the second late by LATE",
        &[Key::new("late", SAMPLES, &[0.02, 0.2], MANY)],
        |of, v| of.converter.skew_s = v[0] / of.n,
    ),
    Entry::new(
        "iq-gain",
        "Q stronger than I by LEVEL-DB",
        &[Key::new("level-db", DB, &[0.1, 1.0, 3.0], LEVEL)],
        |of, v| of.receiver.gain_error = (factor(v[0]) - 1.0).into(),
    )
    .iq(),
    Entry::new(
        "iq-phase",
        "Q off a right angle by ANGLE",
        &[Key::new("angle", "deg", &[1.0, 5.0, 20.0], (-180.0, 180.0))],
        |of, v| of.receiver.quadrature_rad = v[0].to_radians().into(),
    )
    .iq(),
    Entry::new(
        "iq-delay",
        "Q late by LATE",
        &[Key::new("late", SAMPLES, &[0.1, 1.0], MANY)],
        |of, v| of.receiver.q_late_s = (v[0] / of.n).into(),
    )
    .iq(),
    Entry::new(
        "iq-dead",
        "nothing on Q (part 1) or on I (0)",
        &[Key::new("part", "", &[0.0, 1.0], ONE)],
        |of, v| of.receiver.dead = Some(usize::from(v[0] > 0.5)),
    )
    .iq(),
];
