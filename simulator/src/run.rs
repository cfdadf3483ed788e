//! A run of a scene: its random numbers are drawn, its samples can be taken.

use crate::change::Changes;
use crate::draw::Draw;
use crate::flow::{Flow, Passed};
use crate::noise::Coloured;
use crate::path::Path;
use crate::random::{Speckle, Wander};
use crate::scene::{self, Form, Mixing, Scene, Shape, Source};
use crate::value::{Course, Value};
use crate::waveform::Waveform;
use core::f64::consts::TAU;
use picket_dsp::config::SPEED_OF_LIGHT;

/// What is true of a source in a record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// The middle of the record, s.
    pub time_s: f64,
    /// The slope of the straight line through the phases of its samples, Hz; signed as an I/Q receiver shows it.
    pub frequency_hz: f64,
    /// The mean frequency from the first sample to the end of the record, Hz.
    pub mean_hz: f64,
    /// The frequency that a tone would have unchanged, Hz.
    pub nominal_hz: f64,
    /// Amplitude in the middle before the receiver's filters, codes.
    pub amplitude: f64,
    /// The phase at sample n/2, turns; jumps and speckle included.
    pub phase_turns: f64,
    /// Range in the middle, m; of what reflects.
    pub range_m: Option<f64>,
    /// Speed towards the sensor in the middle, m/s; of what moves.
    pub velocity_mps: Option<f64>,
}

/// What reflects or radiates.
struct Voice {
    amplitude: f64,
    changes: Changes,
    what: What,
}

enum What {
    Tone { frequency: Course, start: f64, form: Form, harmonics: Vec<[f64; 2]> },
    Echo(Echo),
    Flow(Flow),
}

/// A reflector on its way.
struct Echo {
    range_m: f64,
    velocity: Course,
    /// Swings of the range: m, Hz and turns.
    swings: Vec<[f64; 3]>,
    /// Swings whose amplitude goes with the speed: a leg's share, Hz, turns.
    legs: Option<[f64; 2]>,
    turns: f64,
    amplitude_at_m: Option<f64>,
    /// Whether it falls with the range alone.
    surface: bool,
}

impl Echo {
    fn range_m(&self, time_s: f64) -> f64 {
        let swing = |&[far, hz, turns]: &[f64; 3]| far * libm::sin(TAU * (hz * time_s + turns));
        let swings: f64 = self.swings.iter().map(swing).sum();
        let legs = self.legs.map_or(0.0, |[hz, turns]| {
            self.velocity.at(time_s) / (TAU * hz) * libm::cos(TAU * (hz * time_s + turns))
        });
        self.range_m - self.velocity.integral(time_s) + swings + legs
    }

    fn level(&self, range_m: f64) -> f64 {
        self.amplitude_at_m.map_or(1.0, |at| {
            let ratio = at / range_m.max(1e-3);
            if self.surface { ratio } else { ratio * ratio }
        })
    }
}

/// What the sensor sends, as it is in a run.
struct Sent {
    waveform: Waveform,
    wander: Option<Wander>,
    sign: f64,
}

impl Sent {
    /// The phase of an echo from a range at a time, turns.
    fn turns(&self, range_m: f64, time_s: f64) -> f64 {
        let delay_s = 2.0 * range_m / SPEED_OF_LIGHT;
        let period_s = self.waveform.period_s();
        let lap = if period_s.is_finite() { libm::floor(time_s / period_s) } else { 0.0 };
        let local_s = if lap == 0.0 { time_s } else { time_s - lap * period_s };
        let own = self.wander.as_ref().map_or(0.0, |own| own.at(time_s) - own.at(time_s - delay_s));
        self.waveform.cycles(local_s, delay_s) + own
    }
}

impl Voice {
    /// The phase at a time, turns: what is frequency, and with jumps and speckle; and the amplitude.
    fn turns(&self, sent: Option<&Sent>, time_s: f64) -> [f64; 3] {
        let changed = self.changes.at(time_s);
        let amplitude = self.amplitude * changed.gain;
        match &self.what {
            What::Tone { frequency, start, .. } => {
                let turns = frequency.integral(time_s) + start + changed.cycles;
                [turns, turns + changed.turned, amplitude]
            }
            What::Echo(echo) => {
                let range_m = echo.range_m(time_s);
                let sign = sent.map_or(1.0, |sent| sent.sign);
                let turns = sent.map_or(0.0, |sent| sent.turns(range_m, time_s));
                let turns = turns + echo.turns + changed.cycles;
                [sign * turns, sign * (turns + changed.turned), amplitude * echo.level(range_m)]
            }
            What::Flow(flow) => {
                let hz = flow.mean_hz(time_s);
                [hz * time_s, hz * time_s, amplitude]
            }
        }
    }

    /// Its two parts at a time, codes.
    #[inline]
    fn at(&self, sent: Option<&Sent>, time_s: f64) -> [f64; 2] {
        match &self.what {
            What::Flow(flow) => match flow.near(time_s) {
                [] => [0.0; 2],
                near => {
                    let gain = self.changes.at(time_s).gain;
                    flow.light(near, time_s).map(|part| gain * part)
                }
            },
            _ => self.wave(sent, time_s),
        }
    }

    /// That of one phase.
    fn wave(&self, sent: Option<&Sent>, time_s: f64) -> [f64; 2] {
        let [_, turns, amplitude] = self.turns(sent, time_s);
        if amplitude == 0.0 {
            return [0.0; 2];
        }
        let (form, harmonics) = match &self.what {
            What::Tone { form, harmonics, .. } => (*form, harmonics.as_slice()),
            _ => (Form::Sine, &[][..]),
        };
        let mut parts = parts(form, turns).map(|part| amplitude * part);
        for &[order, level_db] in harmonics {
            // A harmonic has a phase of its own, the same in each record: that of its order times the golden ratio.
            let own = order * 0.618_033_988_749_894_9;
            let level = amplitude * libm::exp10(level_db / 20.0);
            let [i, q] = self::parts(Form::Sine, order * turns + own);
            parts = [parts[0] + level * i, parts[1] + level * q];
        }
        parts
    }
}

/// Cosine and sine of a phase in turns, or what stands for them.
fn parts(form: Form, turns: f64) -> [f64; 2] {
    let share = turns - libm::floor(turns);
    let wave = |share: f64| match form {
        Form::Sine => 0.0,
        Form::Square => {
            if !(0.25..0.75).contains(&share) {
                1.0
            } else {
                -1.0
            }
        }
        Form::Triangle => 4.0 * (share - 0.5).abs() - 1.0,
        Form::Sawtooth => 2.0 * share - 1.0,
    };
    match form {
        Form::Sine => {
            let (sin, cos) = libm::sincos(TAU * share);
            [cos, sin]
        }
        _ => [wave(share), wave(if share < 0.25 { share + 0.75 } else { share - 0.25 })],
    }
}

/// A run of a scene.
pub struct Run {
    scene: Scene,
    sent: Option<Sent>,
    voices: Vec<Voice>,
    /// The voices of each source.
    sources: Vec<core::ops::Range<usize>>,
    path: Path,
}

impl core::fmt::Debug for Run {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Run({} sources)", self.sources.len())
    }
}

/// Samples that a scene has at most: a quarter of an hour at a megahertz.
const MOST: f64 = 1e9;

impl Scene {
    /// A run of it. Each trial has phases, arrivals and noise of its own.
    ///
    /// # Errors
    /// Something in the scene cannot be; the sentence names it.
    pub fn run(&self, trial: u64) -> Result<Run, String> {
        self.check()?;
        let (seed, rate_hz) = (self.seed, self.rate_hz);
        let (early_s, late_s) = self.off_s();
        let span_s = (-1.0 / rate_hz - early_s, self.seconds + 2.0 / rate_hz + late_s);
        let sent = self.waveform.as_ref().map(|waveform| {
            let mut draw = Draw::part(seed, trial, 1);
            // The oldest echo is that of the farthest target.
            let farthest_m = self
                .sources
                .iter()
                .map(|source| source.farthest_m(self.seconds))
                .fold(0.0, f64::max);
            let from_s = span_s.0 - 2.0 * farthest_m / SPEED_OF_LIGHT - 2.0 / rate_hz;
            let deviation = libm::sqrt(waveform.linewidth_hz / TAU);
            let wander = (deviation > 0.0)
                .then(|| Wander::new((from_s, span_s.1), rate_hz, deviation, || draw.normal()));
            let sign = match self.receiver.mixing {
                Mixing::TxConjRx => 1.0,
                Mixing::RxConjTx => -1.0,
            };
            Sent { waveform: waveform.wave(), wander, sign }
        });
        let mut run = Run {
            scene: self.clone(),
            sent,
            voices: Vec::new(),
            sources: Vec::new(),
            path: Path::default(),
        };
        let mut first = None;
        let mut tones: Vec<Course> = Vec::new();
        for (number, source) in self.sources.iter().enumerate() {
            let draw = &mut Draw::part(seed, trial, 16 + number);
            let amplitude = match source.level() {
                (Some(codes), _) => codes.draw(draw),
                (None, level_db) => {
                    let db = level_db.map_or(0.0, |value| value.draw(draw));
                    first.unwrap_or(0.0) * libm::exp10(db / 20.0)
                }
            };
            first.get_or_insert(amplitude);
            let from = run.voices.len();
            let voices = source.voices(amplitude, span_s, rate_hz, &tones, draw);
            if let [Voice { what: What::Tone { frequency, .. }, .. }] = &voices[..] {
                tones.push(frequency.clone());
            } else {
                tones.push(Value::default().course(draw));
            }
            run.voices.extend(voices);
            run.sources.push(from..run.voices.len());
        }
        let nominal_hz = tones.first().map_or(0.0, |tone| tone.at(0.0));
        run.path = Path::new(self, trial, first.unwrap_or(0.0), nominal_hz);
        Ok(run)
    }

    /// Why it cannot be.
    fn check(&self) -> Result<(), String> {
        let positive = |name: &str, x: f64| {
            (x.is_finite() && x > 0.0).then_some(()).ok_or(format!("{name}: give a number above 0"))
        };
        positive("rate_hz", self.rate_hz)?;
        positive("seconds", self.seconds)?;
        if let Some(waveform) = &self.waveform {
            waveform.check()?;
        }
        let samples = match self.gate() {
            Some((_, n)) if !self.wanders() => self.records(n) as f64 * n as f64,
            _ => self.seconds * self.rate_hz,
        };
        if samples > MOST {
            return Err(format!("seconds: more than {MOST:e} samples: give less time"));
        }
        for (number, source) in self.sources.iter().enumerate() {
            let name = |what: String| format!("sources[{number}]: {what}");
            source.check(number, self.waveform.is_some()).map_err(name)?;
        }
        self.receiver
            .check(!self.sources.is_empty())
            .map_err(|what| format!("receiver: {what}"))?;
        self.converter.check().map_err(|what| format!("converter: {what}"))
    }

    /// How far before the start and after the end samples are taken that are late, old, or after lost ones, s.
    fn off_s(&self) -> (f64, f64) {
        let count = |place: &Option<crate::scene::Place>| {
            place.as_ref().map_or(0.0, |place| place.count.most()) / self.rate_hz
        };
        let converter = &self.converter;
        let early_s = count(&converter.stale) + self.receiver.q_late_s.most();
        (early_s, count(&converter.lost) + self.receiver.q_late_s.most())
    }

    /// Whether something in it is drawn for each sample of its time, also for those that are not taken.
    fn wanders(&self) -> bool {
        let walks = |source: &Source| {
            let (Source::Tone(scene::Tone { changes, .. })
            | Source::Target(scene::Target { changes, .. })) = source
            else {
                return false;
            };
            changes.iter().any(|change| matches!(change, scene::Change::Walk { .. }))
        };
        self.waveform.as_ref().is_some_and(|waveform| waveform.linewidth_hz > 0.0)
            || !self.receiver.noise.shape.is_empty()
            || self.sources.iter().any(walks)
    }

    /// Samples of a record in each segment, if records are taken there alone.
    fn gate(&self) -> Option<(f64, usize)> {
        let waveform = self.waveform.as_ref()?;
        Some((waveform.guard_s?, waveform.samples))
    }

    /// When record number `index` of `n` samples starts, s: one in each segment of the waveform where it has a guard, else one after the
    /// other.
    pub fn start_s(&self, index: usize, n: usize) -> f64 {
        match (self.gate(), &self.waveform) {
            (Some((guard_s, _)), Some(waveform)) => {
                let wave = waveform.wave();
                let segments = waveform.taken();
                let (lap, segment) = (index / segments, index % segments);
                lap as f64 * wave.period_s() + wave.start_s(segment) + guard_s
            }
            _ => (index * n) as f64 / self.rate_hz,
        }
    }

    /// Records that fit into its time, of `n` samples.
    pub fn records(&self, n: usize) -> usize {
        let fits = |index: usize| {
            self.start_s(index, n) + n as f64 / self.rate_hz <= self.seconds * (1.0 + 1e-9)
        };
        let (mut low, mut high) = (0, 1);
        while fits(high) {
            (low, high) = (high, 2 * high);
        }
        // The last that fits is between them.
        while high - low > 1 {
            let middle = low.midpoint(high);
            if fits(middle) { low = middle } else { high = middle }
        }
        if fits(0) { low + 1 } else { 0 }
    }

    /// Records of a repetition of its waveform: one in each segment, and one of a continuous wave.
    pub fn segments(&self) -> usize {
        self.waveform.as_ref().map_or(1, scene::Waveform::taken)
    }

    /// All of its samples: the records of the segments where there is a guard, else all in a row.
    ///
    /// # Errors
    /// Those of [`Scene::run`].
    pub fn codes(&self, trial: u64) -> Result<Vec<[i16; 2]>, String> {
        let mut run = self.run(trial)?;
        Ok(match self.gate() {
            Some((_, n)) => (0..self.records(n)).flat_map(|index| run.record(index, n)).collect(),
            None => run.codes(0.0, libm::round(self.seconds * self.rate_hz) as usize),
        })
    }
}

impl Run {
    /// The scene.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Record number `index` of `n` samples, see [`Scene::start_s`].
    pub fn record(&mut self, index: usize, n: usize) -> Vec<[i16; 2]> {
        let start_s = self.scene.start_s(index, n);
        self.codes(start_s, n)
    }

    /// The codes of `n` samples from a time on. Of a real receiver the second part is 0.
    pub fn codes(&mut self, from_s: f64, n: usize) -> Vec<[i16; 2]> {
        // A cast saturates.
        let code = |code: [f64; 2]| code.map(|part| part as i16);
        self.converted(from_s, n, true).into_iter().map(code).collect()
    }

    /// What [`Run::codes`] gives of a converter that neither rounds nor ends, whose other faults stay.
    pub fn unrounded(&mut self, from_s: f64, n: usize) -> Vec<[f64; 2]> {
        self.converted(from_s, n, false)
    }

    fn converted(&mut self, from_s: f64, n: usize, rounds: bool) -> Vec<[f64; 2]> {
        let taken = self.path.taken;
        let volts = self.voltages(from_s, n);
        self.path.convert(&volts, taken, rounds)
    }

    /// The voltages of `n` samples from a time on, in codes that are neither rounded nor cut.
    pub fn voltages(&mut self, from_s: f64, n: usize) -> Vec<[f64; 2]> {
        let Run { sent, voices, path, .. } = self;
        path.take(from_s, n, |time_s| {
            let mut sum = [0.0; 2];
            for voice in voices.iter() {
                let [i, q] = voice.at(sent.as_ref(), time_s);
                sum = [sum[0] + i, sum[1] + q];
            }
            sum
        })
    }

    /// The amplitude of a source without its changes, codes.
    pub fn amplitude(&self, source: usize) -> f64 {
        let voice = self.sources.get(source).and_then(|range| self.voices.get(range.start));
        voice.map_or(0.0, |voice| voice.amplitude)
    }

    /// The noise's standard deviation in each part before the receiver's filters, codes.
    pub const fn noise(&self) -> f64 {
        self.path.noise
    }

    /// The noise's standard deviation in each part behind the receiver's filters, codes.
    pub fn passed_noise(&self) -> f64 {
        self.path.passed_noise()
    }

    /// The gain of the receiver's filters at a frequency, which no [`Truth`] has.
    pub fn gain(&self, hz: f64) -> f64 {
        self.path.gain(hz)
    }

    /// The noise's density at a frequency over that of white noise of the same power.
    pub fn dense(&self, hz: f64) -> f64 {
        self.path.coloured.as_ref().map_or(1.0, |coloured: &Coloured| coloured.at(hz))
    }

    /// What is true of a source in `n` samples from a time on.
    pub fn truth(&self, source: usize, from_s: f64, n: usize) -> Truth {
        let Some(voice) = self.sources.get(source).and_then(|range| self.voices.get(range.start))
        else {
            return Truth::default();
        };
        let rate_hz = self.scene.rate_hz;
        let time = |index: f64| from_s + index / rate_hz;
        let turns = |index: f64| voice.turns(self.sent.as_ref(), time(index));
        let middle = 0.5 * (n.max(1) - 1) as f64;
        let origin = turns(middle)[0];
        let (mut moment, mut spread) = (0.0, 0.0);
        for index in 0..n {
            let place = index as f64 - middle;
            moment += place * (turns(index as f64)[0] - origin);
            spread += place * place;
        }
        let [_, at_half, _] = turns((n / 2) as f64);
        let time_s = time(middle);
        let amplitude = turns(middle)[2];
        let mean_hz = (turns(n as f64)[0] - turns(0.0)[0]) * rate_hz / n as f64;
        let mut truth = Truth {
            time_s,
            frequency_hz: if spread > 0.0 { moment / spread * rate_hz } else { 0.0 },
            mean_hz,
            nominal_hz: mean_hz,
            amplitude,
            phase_turns: at_half - libm::floor(at_half),
            range_m: None,
            velocity_mps: None,
        };
        match &voice.what {
            What::Tone { frequency, .. } => truth.nominal_hz = frequency.at(time_s),
            What::Echo(echo) => {
                let range = |t: f64| echo.range_m(t);
                let h = 0.5 * n as f64 / rate_hz;
                truth.range_m = Some(range(time_s));
                truth.velocity_mps = Some((range(time_s - h) - range(time_s + h)) / (2.0 * h));
            }
            What::Flow(flow) => {
                let hz = flow.mean_hz(time_s);
                (truth.frequency_hz, truth.mean_hz, truth.nominal_hz) = (hz, hz, hz);
                truth.velocity_mps = Some(flow.mean_mps(time_s));
            }
        }
        truth
    }

    /// What is true of a source at the mean of the middles of the first and the last record of a repetition: the moment to which the range
    /// of a chirp refers.
    pub fn truth_of_lap(&self, source: usize, lap: usize, n: usize) -> Truth {
        let (scene, segments) = (&self.scene, self.scene.segments());
        let ends = [lap * segments, (lap + 1) * segments - 1].map(|index| scene.start_s(index, n));
        self.truth(source, f64::midpoint(ends[0], ends[1]), n)
    }

    /// The particles of a source, in the order of their middles.
    pub fn particles(&self, source: usize) -> &[Passed] {
        let voice = self.sources.get(source).and_then(|range| self.voices.get(range.start));
        match voice.map(|voice| &voice.what) {
            Some(What::Flow(flow)) => &flow.passed,
            _ => &[],
        }
    }
}

impl Source {
    /// The amplitude in codes, or the level.
    const fn level(&self) -> (Option<&Value>, Option<&Value>) {
        let (amplitude, level_db) = match self {
            Source::Tone(of) => (&of.amplitude, &of.level_db),
            Source::Target(of) => (&of.amplitude, &of.level_db),
            Source::Blades(of) => (&of.amplitude, &of.level_db),
            Source::Walker(of) => (&of.amplitude, &of.level_db),
            Source::Particles(of) => (&of.amplitude, &of.level_db),
        };
        (amplitude.as_ref(), level_db.as_ref())
    }

    /// No farther away than this in the scene's time, m.
    fn farthest_m(&self, seconds: f64) -> f64 {
        let (range, velocity) = match self {
            Source::Target(of) => (&of.range_m, &of.velocity_mps),
            Source::Blades(of) => (&of.range_m, &of.velocity_mps),
            Source::Walker(of) => (&of.range_m, &of.velocity_mps),
            Source::Tone(_) | Source::Particles(_) => return 0.0,
        };
        range.most() + velocity.most() * seconds + 10.0
    }

    fn voices(
        &self,
        amplitude: f64,
        span_s: (f64, f64),
        rate_hz: f64,
        tones: &[Course],
        draw: &mut Draw,
    ) -> Vec<Voice> {
        let unchanged = |amplitude, what| Voice { amplitude, changes: Changes::default(), what };
        match self {
            Source::Tone(of) => {
                let own = of.frequency_hz.course(draw);
                let frequency = match of.beside.and_then(|number| tones.get(number)) {
                    Some(other) => own.raised(other.at(0.0)),
                    None => own,
                };
                let start = of.phase_turns.draw(draw);
                let changes = Changes::new(&of.changes, span_s, rate_hz, draw);
                let harmonics = of.harmonics.clone();
                let what = What::Tone { frequency, start, form: of.form, harmonics };
                vec![Voice { amplitude, changes, what }]
            }
            Source::Target(of) => {
                let range_m = of.range_m.draw(draw);
                let velocity = of.velocity_mps.course(draw);
                let turns = of.phase_turns.draw(draw);
                let swings = of.vibration.iter().map(|swing| {
                    [&swing.amplitude_m, &swing.frequency_hz, &swing.phase_turns]
                        .map(|value| value.draw(draw))
                });
                let swings = swings.collect();
                let mut changes = Changes::new(&of.changes, span_s, rate_hz, draw);
                if let Some(spot_m) = of.spot_m {
                    let speed = velocity.most().max(1e-9);
                    changes =
                        changes.with_speckle(Speckle::from_spot(span_s, speed, spot_m, || {
                            draw.normal()
                        }));
                }
                let (amplitude_at_m, surface, legs) = (of.amplitude_at_m, of.surface, None);
                let echo = Echo { range_m, velocity, swings, legs, turns, amplitude_at_m, surface };
                vec![Voice { amplitude, changes, what: What::Echo(echo) }]
            }
            Source::Blades(of) => {
                let (range_m, velocity) = (of.range_m.draw(draw), of.velocity_mps.course(draw));
                let (hz, begin) = (of.turns_hz.draw(draw), draw.share());
                let places = (0..of.blades)
                    .flat_map(|blade| of.places_m.iter().map(move |&place| (blade, place)));
                let place = |(blade, place): (usize, f64)| {
                    let turns = begin + blade as f64 / of.blades as f64 + 0.25;
                    let (swings, velocity) = (vec![[place, hz, turns]], velocity.clone());
                    let turns = draw.share();
                    let (amplitude_at_m, surface, legs) = (None, false, None);
                    let echo =
                        Echo { range_m, velocity, swings, legs, turns, amplitude_at_m, surface };
                    unchanged(amplitude, What::Echo(echo))
                };
                places.map(place).collect()
            }
            Source::Walker(of) => {
                let (range_m, velocity) = (of.range_m.draw(draw), of.velocity_mps.course(draw));
                let (hz, sway) = (of.steps_hz.draw(draw), of.sway_mps.draw(draw));
                let begin = draw.share();
                let swings = vec![[sway / (TAU * hz), hz, begin]];
                let amplitude_at_m = of.amplitude_at_m;
                let surface = false;
                let mut echo = |legs| {
                    let (velocity, swings, turns) =
                        (velocity.clone(), swings.clone(), draw.share());
                    let echo =
                        Echo { range_m, velocity, swings, legs, turns, amplitude_at_m, surface };
                    What::Echo(echo)
                };
                // A leg stands for a step and goes twice as fast as the body in the next; the other one the other way round.
                let leg = amplitude * libm::exp10(of.legs_db / 20.0);
                vec![
                    unchanged(amplitude, echo(None)),
                    unchanged(leg, echo(Some([0.5 * hz, 0.5 * begin]))),
                    unchanged(leg, echo(Some([0.5 * hz, 0.5 * begin + 0.5]))),
                ]
            }
            Source::Particles(of) => {
                vec![unchanged(1.0, What::Flow(Flow::new(of, amplitude, span_s, draw)))]
            }
        }
    }

    fn check(&self, number: usize, sends: bool) -> Result<(), String> {
        const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        const SOME: (f64, f64) = (0.0, f64::INFINITY);
        let (amplitude, level_db) = self.level();
        match (amplitude, level_db) {
            (Some(_), Some(_)) => return Err("give amplitude or level_db, not both".into()),
            (None, _) if number == 0 => return Err("give its amplitude in codes".into()),
            (None, None) => return Err("give amplitude, or level_db over the first source".into()),
            _ => {}
        }
        amplitude.map_or(Ok(()), |value| value.check("amplitude", false, SOME))?;
        level_db.map_or(Ok(()), |value| value.check("level_db", false, (-300.0, 300.0)))?;
        let moves = |range: &Value, velocity: &Value| {
            range.check("range_m", false, SOME)?;
            velocity.check("velocity_mps", true, ANY)?;
            sends
                .then_some(())
                .ok_or_else(|| "nothing is sent that it could reflect: give a waveform".to_owned())
        };
        match self {
            Source::Tone(of) => {
                of.frequency_hz.check("frequency_hz", true, ANY)?;
                of.phase_turns.check("phase_turns", false, ANY)?;
                match of.beside {
                    Some(other) if other >= number => {
                        Err("beside: give the number of a source before it".into())
                    }
                    _ => check_changes(&of.changes),
                }
            }
            Source::Target(of) => {
                of.phase_turns.check("phase_turns", false, ANY)?;
                moves(&of.range_m, &of.velocity_mps)?;
                for swing in &of.vibration {
                    swing.amplitude_m.check("amplitude_m", false, SOME)?;
                    swing.frequency_hz.check("frequency_hz", false, SOME)?;
                }
                if of.spot_m.is_some_and(|spot| spot.is_nan() || spot <= 0.0) {
                    return Err("spot_m: give a number above 0".into());
                }
                check_changes(&of.changes)
            }
            Source::Blades(of) => {
                of.turns_hz.check("turns_hz", false, ANY)?;
                if of.blades == 0 || of.places_m.is_empty() {
                    return Err("give blades and places_m".into());
                }
                moves(&of.range_m, &of.velocity_mps)
            }
            Source::Walker(of) => {
                of.steps_hz.check("steps_hz", false, (1e-3, 100.0))?;
                of.sway_mps.check("sway_mps", false, SOME)?;
                moves(&of.range_m, &of.velocity_mps)
            }
            Source::Particles(of) => {
                of.velocity_mps.check("velocity_mps", true, ANY)?;
                for (name, x) in [
                    ("fringe_m", of.fringe_m),
                    ("radius_m", of.radius_m),
                    ("visibility", of.visibility),
                ] {
                    if !(x.is_finite() && x > 0.0) {
                        return Err(format!("{name}: give a number above 0"));
                    }
                }
                let most = of.velocity_mps.most() + 6.0 * of.turbulence_mps;
                if !(0.0..=1e7).contains(&(of.per_m * most)) || of.turbulence_mps < 0.0 {
                    return Err("per_m: give 0 to ten million particles a second".into());
                }
                if of.per_m == 0.0 && of.at.is_empty() {
                    return Err("give per_m, or a list at".into());
                }
                of.at.iter().try_for_each(|particle| {
                    particle.middle_s.check("middle_s", false, ANY)?;
                    particle.level_db.check("level_db", false, (-300.0, 300.0))?;
                    particle
                        .velocity_mps
                        .as_ref()
                        .map_or(Ok(()), |value| value.check("velocity_mps", false, ANY))?;
                    particle.turns.as_ref().map_or(Ok(()), |value| value.check("turns", false, ANY))
                })
            }
        }
    }
}

fn check_changes(changes: &[crate::scene::Change]) -> Result<(), String> {
    use crate::scene::Change::*;
    const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
    const SOME: (f64, f64) = (1e-12, f64::INFINITY);
    for change in changes {
        if let Level { db } = change {
            db.check("db", true, (-1e4, 300.0))?;
            continue;
        }
        let all: &[(&str, &Value, (f64, f64))] = match change {
            Am { depth, rate_hz } => &[("depth", depth, (0.0, 1.0)), ("rate_hz", rate_hz, ANY)],
            Fm { deviation_hz, rate_hz } => {
                &[("deviation_hz", deviation_hz, ANY), ("rate_hz", rate_hz, SOME)]
            }
            Chirp { hz_per_s, at_s } => &[("hz_per_s", hz_per_s, ANY), ("at_s", at_s, ANY)],
            Jump { turns, hz, at_s } => {
                &[("turns", turns, ANY), ("hz", hz, ANY), ("at_s", at_s, ANY)]
            }
            Walk { linewidth_hz } => &[("linewidth_hz", linewidth_hz, (0.0, f64::INFINITY))],
            On { from_s, for_s } => {
                &[("from_s", from_s, ANY), ("for_s", for_s, (0.0, f64::INFINITY))]
            }
            Level { .. } => &[],
            Decay { time_s, from_s } => &[("time_s", time_s, SOME), ("from_s", from_s, ANY)],
            Burst { middle_s, deviation_s } => {
                &[("middle_s", middle_s, ANY), ("deviation_s", deviation_s, SOME)]
            }
            Keyed { bits_hz, .. } => &[("bits_hz", bits_hz, SOME)],
            Hidden { depth, rate_hz } => &[("depth", depth, (0.0, 1.0)), ("rate_hz", rate_hz, ANY)],
            Speckle { bandwidth_hz } => &[("bandwidth_hz", bandwidth_hz, SOME)],
            Bursts { per_s, deviation_s, nepers } => &[
                ("per_s", per_s, (1e-12, 1e7)),
                ("deviation_s", deviation_s, SOME),
                ("nepers", nepers, (0.0, f64::INFINITY)),
            ],
        };
        all.iter().try_for_each(|(name, value, range)| value.check(name, false, *range))?;
    }
    Ok(())
}

impl crate::scene::Waveform {
    /// Segments in which records are taken.
    fn taken(&self) -> usize {
        match self.shape {
            Shape::Continuous | Shape::Sawtooth => 1,
            Shape::Triangle => 2,
            Shape::Trapezoid => 3,
            Shape::Sequence => self.segments.len().max(1),
        }
    }

    fn wave(&self) -> Waveform {
        match self.shape {
            Shape::Continuous => Waveform::continuous(self.carrier_hz),
            Shape::Sequence => {
                let segment = |of: &crate::scene::Segment| {
                    let (slope, bow) =
                        ((of.end_hz - of.start_hz) / of.seconds, 4.0 * of.bow_hz / of.seconds);
                    crate::waveform::Segment {
                        start_hz: of.start_hz,
                        slope: slope + bow,
                        bend: -bow / of.seconds,
                        duration_s: of.seconds,
                    }
                };
                Waveform::new(self.segments.iter().map(segment).collect(), self.period_s)
            }
            _ => Waveform::ramps(self),
        }
    }

    fn check(&self) -> Result<(), String> {
        let above = |name: &str, x: f64| {
            (x.is_finite() && x > 0.0)
                .then_some(())
                .ok_or(format!("waveform: {name}: give a number above 0"))
        };
        match self.shape {
            Shape::Continuous => above("carrier_hz", self.carrier_hz)?,
            Shape::Sequence => {
                if self.segments.is_empty() {
                    return Err("waveform: a sequence has segments: give them".into());
                }
                for segment in &self.segments {
                    above("seconds", segment.seconds)?;
                    above("start_hz", segment.start_hz)?;
                    above("end_hz", segment.end_hz)?;
                }
            }
            _ => {
                above("carrier_hz", self.carrier_hz)?;
                above("ramp_s", self.ramp_s)?;
                if !self.bandwidth_hz.is_finite() {
                    return Err("waveform: bandwidth_hz: give a number".into());
                }
            }
        }
        if self.guard_s.is_some() && (self.samples == 0 || self.shape == Shape::Continuous) {
            return Err(
                "waveform: guard_s is for ramps, with the samples that are taken of each".into()
            );
        }
        (self.linewidth_hz >= 0.0)
            .then_some(())
            .ok_or("waveform: linewidth_hz: give 0 or more".into())
    }
}
