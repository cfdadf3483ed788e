//! A case: a scene, how it is measured, and what must come out.

use crate::limit::{Asked, Event};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::{Arithmetic, Chirp, Config, Effort, Mixing, Reach, Shape};
use picket_simulator::Scene;
use picket_simulator::scene;

/// How a record becomes answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// The tone of a block.
    Block,
    /// The tones of a block, at most so many.
    Lines(usize),
    /// The sum of so many blocks, whose line drifts by so many bins a block, as the configuration says.
    Sum(u32, f32),
    /// The tones of so many blocks, one after the other.
    Blocks(usize),
    /// The tone of a block of pairs that one converter takes by turns.
    ByTurns,
    /// The tracks that are held after so many blocks, in so many more.
    Tracks(usize, usize),
    /// The burst of the first source, in a stream of so many records: the nearest valid one, or the worst where any source may be meant.
    Bursts(usize),
    /// The fundamental of a block, from as many multiples at most.
    Harmonic(u32),
    /// The tone within two bins of this one, without a search.
    Locked(i32),
    /// The target of the last of so many chirps.
    Chirps(usize),
    /// The targets of a frame of so many sawtooth chirps.
    Frame(usize),
    /// The first source in a frame of so many chirps, beside what a frame of the others alone recorded as background.
    FrameBeside(usize),
    /// The target of a frame of so many chirps, and of a second one whose period is longer by a fifth, together.
    TwoFrames(usize),
    /// The range by the phase of the target of a frame of so many chirps.
    FramePhase(usize),
    /// The range by the phase of a chirp's tones: of a sawtooth at rest, or of both ramps.
    Phase,
    /// The target of so many sawtooth chirps together; of those that are listed the nearest.
    Sequence(u32),
}

/// Which of its truths a tone's frequency is held against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Truths {
    /// The slope of the line through the phases of its samples.
    #[default]
    Line,
    /// Its mean over the record.
    Mean,
    /// What it would be unchanged: the carrier.
    Carrier,
}

/// The transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// 32-bit integers.
    #[default]
    I32,
    /// Floats.
    F32,
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Case {
    /// The claim, and what the row varies.
    pub label: String,
    /// What is measured.
    pub scene: Scene,
    /// Samples of a record.
    pub n: usize,
    /// What the library is told.
    pub config: Config,
    /// The transform.
    pub engine: Engine,
    /// How.
    pub path: Path,
    /// What is true.
    pub truths: Truths,
    /// Whether any of the sources may be meant by an answer, and not the first alone.
    pub any_source: bool,
    /// Whether an answer that may not be used counts as one that may.
    pub whatever: bool,
    /// Whether the bound is that of the first source alone, without its changes.
    pub alone: bool,
    /// Records.
    pub trials: u64,
    /// What must come out.
    pub asked: Vec<Asked>,
}

impl Case {
    /// A case of blocks of `n` samples by the usual configuration, a thousand of them. A scene that sends ramps tells the library its chirp.
    pub fn new(label: impl Into<String>, scene: Scene, n: usize) -> Self {
        let span = 1 << scene.converter.bits;
        let low = if scene.converter.unsigned { 0 } else { -span / 2 };
        let rails = [low, low + span - 1].map(|rail: i32| rail as i16);
        let rails = scene.converter.rails.unwrap_or(rails);
        let codes = Codes::between(rails[0], rails[1]).unwrap_or(Codes::signed::<12>());
        let mut config = Config::new(scene.rate_hz, codes);
        if let Some(chirp) = told(&scene) {
            config.scene = picket_dsp::Scene::Chirp(chirp);
        }
        Self {
            label: label.into(),
            scene,
            n,
            config,
            engine: Engine::I32,
            path: Path::Block,
            truths: Truths::Line,
            any_source: false,
            whatever: false,
            alone: false,
            trials: 1000,
            asked: Vec::new(),
        }
    }

    /// Measured so.
    #[must_use]
    pub fn by(self, path: Path) -> Self {
        Self { path, ..self }
    }

    /// So many records.
    #[must_use]
    pub fn trials(self, trials: u64) -> Self {
        Self { trials, ..self }
    }

    /// With another configuration.
    #[must_use]
    pub fn told(mut self, change: impl FnOnce(&mut Config)) -> Self {
        change(&mut self.config);
        self
    }

    /// With this effort.
    #[must_use]
    pub fn effort(self, effort: Effort) -> Self {
        self.told(|config| config.effort = effort)
    }

    /// With this arithmetic.
    #[must_use]
    pub fn arithmetic(self, arithmetic: Arithmetic) -> Self {
        self.told(|config| config.arithmetic = arithmetic)
    }

    /// With this reach.
    #[must_use]
    pub fn reach(self, reach: Reach) -> Self {
        self.told(|config| config.reach = reach)
    }

    /// By the transform in floats.
    #[must_use]
    pub fn in_floats(self) -> Self {
        Self { engine: Engine::F32, ..self }
    }

    /// Against another truth.
    #[must_use]
    pub fn against(self, truths: Truths) -> Self {
        Self { truths, ..self }
    }

    /// Any of the sources may be meant.
    #[must_use]
    pub fn any_source(self) -> Self {
        Self { any_source: true, ..self }
    }

    /// Whatever the verdict says.
    #[must_use]
    pub fn whatever_the_verdict(self) -> Self {
        Self { whatever: true, ..self }
    }

    /// Against the bound of the first source alone, without its changes.
    #[must_use]
    pub fn alone(self) -> Self {
        Self { alone: true, ..self }
    }

    /// And this must come out.
    #[must_use]
    pub fn asks(mut self, asked: Asked) -> Self {
        self.asked.push(asked);
        self
    }

    /// The mean of (error / sigma)^2 of usable answers is in these bounds.
    #[must_use]
    pub fn square(self, least: f64, most: f64) -> Self {
        self.asks(Asked::Square { quantity: 0, least, most })
    }

    /// At most this share of the answers has this event.
    #[must_use]
    pub fn at_most(self, most: f64, of: Event) -> Self {
        self.asks(Asked::Share { of, least: 0.0, most })
    }

    /// No answer has this event.
    #[must_use]
    pub fn never(self, of: Event) -> Self {
        self.at_most(0.0, of)
    }

    /// At least this share of the answers has this event.
    #[must_use]
    pub fn at_least(self, least: f64, of: Event) -> Self {
        self.asks(Asked::Share { of, least, most: 1.0 })
    }
}

/// The chirp that a scene sends, as the library is told of it: straight ramps.
pub fn told(scene: &Scene) -> Option<Chirp> {
    let of = scene.waveform.as_ref()?;
    let shape = match of.shape {
        scene::Shape::Trapezoid => Shape::Trapezoid,
        scene::Shape::Triangle => Shape::Triangle,
        scene::Shape::Sawtooth => Shape::Sawtooth,
        scene::Shape::Continuous | scene::Shape::Sequence => return None,
    };
    let mixing = match scene.receiver.mixing {
        scene::Mixing::TxConjRx => Mixing::TxConjRx,
        scene::Mixing::RxConjTx => Mixing::RxConjTx,
    };
    Some(Chirp {
        shape,
        wavelength_m: picket_dsp::config::SPEED_OF_LIGHT / of.carrier_hz,
        bandwidth_hz: of.bandwidth_hz,
        duration_s: of.ramp_s,
        guard_s: of.guard_s.unwrap_or(0.0),
        mixing,
        sweep_curvature: 0.0,
    })
}
