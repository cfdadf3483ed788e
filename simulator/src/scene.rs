//! The language of scenes: what is in front of a sensor, what it transmits, and how a converter samples it. Every scene is also a JSON file.
//!
//! Times are in seconds, frequencies in hertz, levels in codes of the converter. To think in bins and records, set `rate_hz` to the
//! samples of a record: then a hertz is a bin, and a second a record.
//!
//! ```json
//! {"about": "A car that brakes before a 24 GHz radar", "rate_hz": 20000, "seconds": 8,
//!  "waveform": {"carrier_hz": 24.125e9},
//!  "sources": [{"target": {"range_m": 90, "velocity_mps": [[0, 20], [2, 20], [6, 0]], "amplitude": 400}}],
//!  "receiver": {"iq": true, "mixing": "rx-conj-tx", "quadrature_rad": 0.03, "noise": {"rms": 20},
//!               "hum": [{"frequency_hz": 50, "amplitude": 30}]}}
//! ```

use crate::value::Value;
use picket_dsp::Chirp;
use picket_dsp::config::SPEED_OF_LIGHT;
use serde::{Deserialize, Serialize};

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// What it is, in a sentence.
    pub about: String,
    /// Another seed gives other noise, phases and arrivals.
    pub seed: u64,
    /// Samples per second.
    pub rate_hz: f64,
    /// How long it lasts, s.
    pub seconds: f64,
    /// What the sensor sends. Without it there is nothing that echoes.
    pub waveform: Option<Waveform>,
    /// What stands before the sensor. The first one is what ratios refer to.
    pub sources: Vec<Source>,
    /// The way to the converter.
    pub receiver: Receiver,
    /// The converter.
    pub converter: Converter,
}

/// What a sensor sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Waveform {
    /// How its carrier runs.
    pub shape: Shape,
    /// The carrier of a continuous wave, or that at which an upward ramp starts, Hz.
    pub carrier_hz: f64,
    /// How far a ramp goes, Hz.
    pub bandwidth_hz: f64,
    /// A ramp, s; also a trapezoid's flat top.
    pub ramp_s: f64,
    /// From one repetition to the next, s; without a pause where that is less than the ramps.
    pub period_s: f64,
    /// How far the middle of a ramp lies above the straight line, a share of the bandwidth.
    pub curvature: f64,
    /// Width of its Lorentzian line at half of the height, Hz.
    pub linewidth_hz: f64,
    /// The segments of a sequence, which repeats.
    pub segments: Vec<Segment>,
    /// From this time after a repetition's start on samples are taken, `samples` of them in each segment; without it all the time.
    pub guard_s: Option<f64>,
    /// Samples of a segment's record.
    pub samples: usize,
}

impl Default for Waveform {
    fn default() -> Self {
        Waveform {
            shape: Shape::Continuous,
            carrier_hz: 24e9,
            bandwidth_hz: 0.0,
            ramp_s: 0.0,
            period_s: 0.0,
            curvature: 0.0,
            linewidth_hz: 0.0,
            segments: Vec::new(),
            guard_s: None,
            samples: 0,
        }
    }
}

impl Waveform {
    /// The ramps of a chirp, with records of `samples`; one chirp begins `period_s` after another.
    pub fn from_chirp(chirp: &Chirp, samples: usize, period_s: f64) -> Self {
        Waveform {
            shape: match chirp.shape {
                picket_dsp::Shape::Trapezoid => Shape::Trapezoid,
                picket_dsp::Shape::Triangle => Shape::Triangle,
                picket_dsp::Shape::Sawtooth => Shape::Sawtooth,
            },
            carrier_hz: SPEED_OF_LIGHT / chirp.wavelength_m,
            bandwidth_hz: chirp.bandwidth_hz,
            ramp_s: chirp.duration_s,
            period_s,
            curvature: chirp.sweep_curvature,
            guard_s: Some(chirp.guard_s),
            samples,
            ..Waveform::default()
        }
    }
}

/// How a carrier runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// It stays.
    #[default]
    Continuous,
    /// Up, level, down.
    Trapezoid,
    /// Up, down.
    Triangle,
    /// Up.
    Sawtooth,
    /// By the list of segments.
    Sequence,
}

/// A segment of a sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Segment {
    /// The carrier at its start, Hz.
    pub start_hz: f64,
    /// The carrier at its end, Hz.
    pub end_hz: f64,
    /// How long it lasts, s.
    pub seconds: f64,
    /// How far its middle lies above the straight line, Hz.
    pub bow_hz: f64,
}

/// Something before the sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A line.
    Tone(Tone),
    /// What reflects the sensor's wave.
    Target(Target),
    /// A propeller, a fan or a rotor: places on its blades reflect the sensor's wave.
    Blades(Blades),
    /// A walking person: a body that sways, and legs that swing.
    Walker(Walker),
    /// Particles that cross the fringes of two laser beams.
    Particles(Particles),
}

/// A line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tone {
    /// Its frequency; of I/Q records either sign. May change with time.
    pub frequency_hz: Value,
    /// The number of a tone, from 0 on, from whose frequency its own counts.
    pub beside: Option<usize>,
    /// Amplitude, codes.
    pub amplitude: Option<Value>,
    /// Or its level over that of the first source, dB.
    pub level_db: Option<Value>,
    /// Its phase at time 0, turns.
    pub phase_turns: Value,
    /// The form of a period: a sine unless it says otherwise.
    pub form: Form,
    /// Multiples of its frequency, each with its level over the tone's, dB.
    pub harmonics: Vec<[f64; 2]>,
    /// What changes it.
    pub changes: Vec<Change>,
}

impl Default for Tone {
    fn default() -> Self {
        Tone {
            frequency_hz: Value::Fixed(0.0),
            beside: None,
            amplitude: None,
            level_db: None,
            phase_turns: Value::Between([0.0, 1.0]),
            form: Form::Sine,
            harmonics: Vec::new(),
            changes: Vec::new(),
        }
    }
}

/// The form of a period. All but the sine have steps, whose harmonics fold as those of a sampled one do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// A sine.
    #[default]
    Sine,
    /// Up and down.
    Square,
    /// To and fro.
    Triangle,
    /// Up, and back at once.
    Sawtooth,
}

/// What changes a source's level or phase with time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Change {
    /// The amplitude swings by a share of itself.
    Am {
        /// The share.
        depth: Value,
        /// How often, Hz.
        rate_hz: Value,
    },
    /// The frequency swings to each side.
    Fm {
        /// How far, Hz.
        deviation_hz: Value,
        /// How often, Hz.
        rate_hz: Value,
    },
    /// The frequency rises evenly, by `hz_per_s`; it has the stated value at `at_s`.
    Chirp {
        /// Hz a second.
        hz_per_s: Value,
        /// When, s.
        #[serde(default)]
        at_s: Value,
    },
    /// The phase, the frequency or both change once.
    Jump {
        /// The jump of the phase, turns.
        #[serde(default)]
        turns: Value,
        /// The jump of the frequency, Hz.
        #[serde(default)]
        hz: Value,
        /// When, s.
        at_s: Value,
    },
    /// The phase walks at random: a Lorentzian line, full width at half of its height.
    Walk {
        /// Hz.
        linewidth_hz: Value,
    },
    /// It is there from one time to another.
    On {
        /// From, s.
        from_s: Value,
        /// For so long, s; for ever where it is not said.
        #[serde(default = "for_ever")]
        for_s: Value,
    },
    /// Its level over the stated one, which changes with time: it fades, or something hides it.
    Level {
        /// dB.
        db: Value,
    },
    /// It dies away from `from_s` on.
    Decay {
        /// To 1/e in so long, s.
        time_s: Value,
        /// From, s.
        #[serde(default)]
        from_s: Value,
    },
    /// A Gaussian envelope.
    Burst {
        /// Its middle, s.
        middle_s: Value,
        /// Its standard deviation, s.
        deviation_s: Value,
    },
    /// Bits: on or off.
    Keyed {
        /// Bits a second.
        bits_hz: Value,
        /// Whether they come in turn; else at random.
        #[serde(default)]
        by_turns: bool,
    },
    /// Blades that pass before it and hide a share of it, for a tenth of the time between two.
    Hidden {
        /// The share.
        depth: Value,
        /// Blades a second.
        rate_hz: Value,
    },
    /// The echo of a rough surface that moves: full width of its spectrum at half of the height.
    Speckle {
        /// Hz.
        bandwidth_hz: Value,
    },
    /// Bursts that come at random: a Gaussian envelope each, with a phase of its own. They add up.
    Bursts {
        /// So many a second.
        per_s: Value,
        /// The standard deviation of each, s.
        deviation_s: Value,
        /// A burst is weaker by any number of nepers up to this one.
        nepers: Value,
    },
}

fn for_ever() -> Value {
    Value::Fixed(1e30)
}

/// What reflects the sensor's wave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Target {
    /// Its range at time 0, m.
    pub range_m: Value,
    /// Its speed towards the sensor, m/s. May change with time: `[[0, 20], [2, 20], [6, 0]]` brakes after two seconds and stands after six.
    pub velocity_mps: Value,
    /// Amplitude of its echo, codes; at `amplitude_at_m`, if that is said.
    pub amplitude: Option<Value>,
    /// Or its level over that of the first source, dB.
    pub level_db: Option<Value>,
    /// The range of the stated amplitude, m: its echo then falls with the square of the range.
    pub amplitude_at_m: Option<f64>,
    /// Whether the whole beam lies on it: its echo then falls with the range, not with the square of it.
    pub surface: bool,
    /// What the reflection adds to its phase, turns.
    pub phase_turns: Value,
    /// It swings to each side by an amplitude in m, at a frequency in Hz.
    pub vibration: Vec<Vibration>,
    /// The diameter of the beam's spot on a rough surface across which it moves at its own speed, m.
    pub spot_m: Option<f64>,
    /// What changes its echo.
    pub changes: Vec<Change>,
}

impl Default for Target {
    fn default() -> Self {
        Target {
            range_m: Value::Fixed(0.0),
            velocity_mps: Value::Fixed(0.0),
            amplitude: None,
            level_db: None,
            amplitude_at_m: None,
            surface: false,
            phase_turns: Value::Between([0.0, 1.0]),
            vibration: Vec::new(),
            spot_m: None,
            changes: Vec::new(),
        }
    }
}

/// A swing of the range, a sine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vibration {
    /// To each side, m.
    pub amplitude_m: Value,
    /// How often, Hz.
    pub frequency_hz: Value,
    /// Its phase at time 0, turns.
    #[serde(default)]
    pub phase_turns: Value,
}

/// A rotor with blades.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Blades {
    /// The hub's range at time 0, m.
    pub range_m: Value,
    /// The hub's speed towards the sensor, m/s. May change with time.
    pub velocity_mps: Value,
    /// Blades.
    pub blades: usize,
    /// Turns a second.
    pub turns_hz: Value,
    /// Distances from the axis at which a blade reflects, m.
    pub places_m: Vec<f64>,
    /// Amplitude of the echo of each place, codes.
    pub amplitude: Option<Value>,
    /// Or its level over that of the first source, dB.
    pub level_db: Option<Value>,
}

impl Default for Blades {
    fn default() -> Self {
        Blades {
            range_m: Value::Fixed(0.0),
            velocity_mps: Value::Fixed(0.0),
            blades: 3,
            turns_hz: Value::Fixed(0.0),
            places_m: Vec::new(),
            amplitude: None,
            level_db: None,
        }
    }
}

/// A person who walks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Walker {
    /// The body's range at time 0, m.
    pub range_m: Value,
    /// The body's mean speed towards the sensor, m/s. May change with time.
    pub velocity_mps: Value,
    /// Steps a second.
    pub steps_hz: Value,
    /// How far the body's speed swings with each step, m/s.
    pub sway_mps: Value,
    /// The echo of each leg over the body's, dB.
    pub legs_db: f64,
    /// Amplitude of the body's echo, codes; at `amplitude_at_m`, if that is said.
    pub amplitude: Option<Value>,
    /// Or its level over that of the first source, dB.
    pub level_db: Option<Value>,
    /// The range of the stated amplitude, m: its echo then falls with the square of the range.
    pub amplitude_at_m: Option<f64>,
}

impl Default for Walker {
    fn default() -> Self {
        Walker {
            range_m: Value::Fixed(0.0),
            velocity_mps: Value::Fixed(0.0),
            steps_hz: Value::Fixed(1.9),
            sway_mps: Value::Fixed(0.08),
            legs_db: -16.5,
            amplitude: None,
            level_db: None,
            amplitude_at_m: None,
        }
    }
}

/// Particles in a flow through the fringes of two laser beams. An I/Q receiver sees the fringes in quadrature, and so their direction; the
/// pedestal is on I alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Particles {
    /// From one fringe to the next, m.
    pub fringe_m: f64,
    /// Radius of the crossing at which the light is down by exp(-2), m.
    pub radius_m: f64,
    /// How deep the fringes cut the light, 0 to 1.
    pub visibility: f64,
    /// How much of the light without fringes comes through, 0 to 1: the pedestal below a burst.
    pub pedestal: f64,
    /// How fast the fringes move, Hz: a Bragg cell's shift. A particle at rest has this frequency.
    pub shift_hz: f64,
    /// The flow's mean velocity, m/s. May change with time, and its sign with it.
    pub velocity_mps: Value,
    /// Standard deviation of a particle's velocity about the mean, m/s.
    pub turbulence_mps: f64,
    /// Particles in a metre of the passing flow, which is particles per second at 1 m/s.
    pub per_m: f64,
    /// Particles that come besides, at times that are stated.
    pub at: Vec<Particle>,
    /// Amplitude of a usual particle's tone in the middle, codes.
    pub amplitude: Option<Value>,
    /// Or its level over that of the first source, dB.
    pub level_db: Option<Value>,
    /// Standard deviation of the logarithm of a particle's light.
    pub sizes: f64,
}

impl Default for Particles {
    fn default() -> Self {
        Particles {
            fringe_m: 4e-6,
            radius_m: 100e-6,
            visibility: 1.0,
            pedestal: 1.0,
            shift_hz: 0.0,
            velocity_mps: Value::Fixed(1.0),
            turbulence_mps: 0.0,
            per_m: 0.0,
            at: Vec::new(),
            amplitude: None,
            level_db: None,
            sizes: 0.0,
        }
    }
}

/// A particle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Particle {
    /// When it is in the middle, s.
    pub middle_s: Value,
    /// Its velocity; that of the flow's mean unless it is said, m/s.
    pub velocity_mps: Option<Value>,
    /// Its level over that of a usual one, dB.
    pub level_db: Value,
    /// Its place among the fringes, turns; any unless it is said.
    pub turns: Option<Value>,
}

/// The way to the converter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Receiver {
    /// Whether it has a second mixer and converter, in quadrature.
    pub iq: bool,
    /// Which signal its mixer conjugates: the side of 0 Hz on which an approaching target stands.
    pub mixing: Mixing,
    /// Share by which Q is stronger than I: .03 is 3 %.
    pub gain_error: Value,
    /// Q is so far from a right angle, radians: .03 puts 3 % of I into Q.
    pub quadrature_rad: Value,
    /// Q is taken so late, s.
    pub q_late_s: Value,
    /// The part that brings nothing: 0 for I, 1 for Q.
    pub dead: Option<usize>,
    /// Offset of I and of Q, codes.
    pub offset: [Value; 2],
    /// Noise.
    pub noise: Noise,
    /// Sines from the mains and other neighbours.
    pub hum: Vec<Hum>,
    /// What drifts, codes over time.
    pub drift: Option<Value>,
    /// Single samples that stick out: how many, and by how many codes.
    pub impulses: Option<Impulses>,
    /// More noise for a while.
    pub noise_burst: Option<NoiseBurst>,
    /// Corners of the sections that couple it, each a capacitor and a resistor, Hz.
    pub high_pass_hz: Vec<f64>,
    /// Corners of the sections that limit its band, Hz.
    pub low_pass_hz: Vec<f64>,
    /// Steps of the analog side per sample; its noise is white up to half of that rate.
    pub oversampling: usize,
    /// The amplifier ends here, codes.
    pub limit: Option<f64>,
}

impl Default for Receiver {
    fn default() -> Self {
        Receiver {
            iq: false,
            mixing: Mixing::default(),
            gain_error: Value::default(),
            quadrature_rad: Value::default(),
            q_late_s: Value::default(),
            dead: None,
            offset: Default::default(),
            noise: Noise::default(),
            hum: Vec::new(),
            drift: None,
            impulses: None,
            noise_burst: None,
            high_pass_hz: Vec::new(),
            low_pass_hz: Vec::new(),
            oversampling: 1,
            limit: None,
        }
    }
}

/// Which signal a mixer conjugates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mixing {
    /// The echo: a target farther away is at higher frequencies of an upward ramp.
    #[default]
    TxConjRx,
    /// The transmitter's: an approaching target is at positive frequencies of a continuous wave.
    RxConjTx,
}

impl From<picket_dsp::Mixing> for Mixing {
    fn from(mixing: picket_dsp::Mixing) -> Self {
        match mixing {
            picket_dsp::Mixing::TxConjRx => Mixing::TxConjRx,
            picket_dsp::Mixing::RxConjTx => Mixing::RxConjTx,
        }
    }
}

/// Noise, the same in both parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// Its standard deviation in each part, codes, before the filters.
    pub rms: Option<Value>,
    /// Or how far the first source is above it, dB per sample: `A^2 / (2 sigma^2)`.
    pub snr_db: Option<Value>,
    /// Whether the level is that of white noise as dense as this one is at the first tone.
    pub at_tone: bool,
    /// What shapes its spectrum; white without.
    pub shape: Vec<Density>,
    /// Whether it comes in before the mixers: what is wrong with Q is wrong with its noise, too.
    pub mixed: bool,
}

/// A factor of the noise's density over frequency. The power of all of the noise stays what was stated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Density {
    /// The rise from one end of the band to the other, dB.
    Slope {
        /// dB.
        rise_db: Value,
    },
    /// A bump of Gaussian shape, or a dent.
    Bump {
        /// dB.
        level_db: Value,
        /// Its standard deviation, Hz.
        width_hz: Value,
        /// Its middle; beside the first tone unless `at_hz` is said, Hz.
        #[serde(default)]
        offset_hz: Value,
        /// Its middle, Hz.
        #[serde(default)]
        at_hz: Option<Value>,
    },
    /// A power of one over the frequency.
    Flicker {
        /// The power.
        power: Value,
    },
    /// Butterworth's filter.
    LowPass {
        /// Its corner, Hz.
        corner_hz: Value,
        /// Its order.
        order: f64,
    },
    /// Sections of a resistor and a capacitor.
    Rc {
        /// Their corner, Hz.
        corner_hz: Value,
        /// How many.
        sections: f64,
    },
    /// A band, of order 8 at both ends.
    BandPass {
        /// Its middle, Hz.
        middle_hz: Value,
        /// Its width, Hz.
        width_hz: Value,
    },
    /// Any: decibels at frequencies, straight lines between.
    Points {
        /// Hz and dB.
        points: Vec<[f64; 2]>,
        /// Whether the frequencies count from that of the first tone.
        #[serde(default)]
        beside_tone: bool,
    },
}

/// A sine that comes in beside the signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hum {
    /// Hz.
    pub frequency_hz: Value,
    /// Codes.
    pub amplitude: Value,
    /// Multiples of its frequency, each with its level over it, dB.
    #[serde(default)]
    pub harmonics: Vec<[f64; 2]>,
    /// Its phase at time 0, turns; any unless it is said.
    #[serde(default)]
    pub phase_turns: Option<Value>,
    /// In which direction of the plane of I and Q it comes in, turns; any unless it is said.
    #[serde(default)]
    pub direction_turns: Option<Value>,
}

/// Samples that stick out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Impulses {
    /// So many over the whole time, anywhere.
    pub count: Value,
    /// The size, codes, either way.
    pub codes: Value,
}

/// More noise for a while.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseBurst {
    /// Its standard deviation in each part, codes.
    pub rms: Value,
    /// From, s.
    pub from_s: Value,
    /// For so long, s.
    pub for_s: Value,
}

/// A converter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Converter {
    /// Its width.
    pub bits: u32,
    /// Whether its codes count from 0; else they are signed.
    pub unsigned: bool,
    /// Its lowest and its highest code, where they are not those of its width. Nothing at its input is the code above their middle.
    pub rails: Option<[i16; 2]>,
    /// Whether what is beyond the rails goes on at the other end.
    pub wraps: bool,
    /// Integral nonlinearity: a bow and an S, at most this many codes.
    pub inl_codes: Value,
    /// Steps where the upper three bits change: this many codes for the top one.
    pub step_codes: Value,
    /// Codes that never come at each change of the upper three bits.
    pub missing_codes: usize,
    /// A line of the bus that is always low or always high.
    pub stuck_bit: Option<StuckBit>,
    /// Whether each two samples change places.
    pub swapped: bool,
    /// Whether codes that count from 0 are read as signed ones, or the other way round.
    pub wrong_sign: bool,
    /// Samples that are missing in one place.
    pub lost: Option<Place>,
    /// A sample that comes again.
    pub repeated: Option<Place>,
    /// From this sample on samples of so long ago come: a buffer that was read before it was full.
    pub stale: Option<Place>,
    /// Random error of each sample's time, s rms.
    pub jitter_s: f64,
    /// Every second sample is so late, s.
    pub skew_s: f64,
    /// Its clock is so fast, millionths.
    pub clock_ppm: f64,
}

impl Default for Converter {
    fn default() -> Self {
        Converter {
            bits: 12,
            unsigned: false,
            rails: None,
            wraps: false,
            inl_codes: Value::default(),
            step_codes: Value::default(),
            missing_codes: 0,
            stuck_bit: None,
            swapped: false,
            wrong_sign: false,
            lost: None,
            repeated: None,
            stale: None,
            jitter_s: 0.0,
            skew_s: 0.0,
            clock_ppm: 0.0,
        }
    }
}

/// A line of the bus that does not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StuckBit {
    /// Which, 0 the lowest.
    pub bit: u32,
    /// Whether it is high.
    pub high: bool,
}

/// Samples in one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// From this sample on.
    pub at: Value,
    /// So many.
    pub count: Value,
}
