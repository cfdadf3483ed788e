//! The record of a number: which samples it has, and how it is measured.

use crate::impair::{Impairment, Setup};
use crate::simulate::{Kind, Width, code, generator};
use num_complex::Complex;
use picket_dsp::tone::effort::Effort;
use picket_dsp::{
    Arithmetic, Carrier, Chirp, Codes, Config, Following, Method, Mixing, Reach, Scene, Shape,
    Stamp,
};
use picket_simulator::scene::{Noise, Receiver, Source, Target, Waveform};
use picket_simulator::{Run, Value};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// Through which type of the library the samples go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// One block, with everything that a pipeline says of it.
    Block,
    /// Blocks one after the other: tracks.
    Tracks,
    /// Blocks that are added.
    Sum,
    /// A stream with a burst.
    Bursts,
    /// Pairs in turn.
    ByTurns,
    /// The segments of a chirp.
    Chirps,
}

impl Path {
    /// Half of the records are single blocks.
    const USUAL: [Self; 10] = [
        Self::Block,
        Self::Block,
        Self::Block,
        Self::Block,
        Self::Block,
        Self::Tracks,
        Self::Sum,
        Self::Bursts,
        Self::ByTurns,
        Self::Chirps,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Tracks => "tracks",
            Self::Sum => "sum",
            Self::Bursts => "bursts",
            Self::ByTurns => "by-turns",
            Self::Chirps => "chirps",
        }
    }

    /// Blocks of the record's length.
    pub const fn blocks(self) -> usize {
        match self {
            Self::Block => 1,
            Self::ByTurns => 2,
            Self::Sum => 4,
            Self::Tracks | Self::Bursts => 8,
            Self::Chirps => 2 * Shape::Trapezoid.segments().len(),
        }
    }
}

/// One record, and how it is measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// The way of its samples.
    pub path: Path,
    /// Whether it has pairs.
    pub iq: bool,
    /// Samples of a block.
    pub n: usize,
    /// Whether the transform is that in floats.
    pub floats: bool,
    /// The settings.
    pub config: Config,
    /// Whether samples are missing before the block.
    pub gap: bool,
    impairment: Impairment,
    setup: Setup,
    rng: ChaCha8Rng,
}

/// Signal-to-noise ratios, dB.
const LEVELS_DB: [f64; 8] = [-10.0, -3.0, 3.0, 10.0, 20.0, 30.0, 45.0, 60.0];
/// A ramp, s; a record takes most of it.
const RAMP_S: f64 = 1e-3;
const RECORD_S: f64 = 0.9 * RAMP_S;
const BANDWIDTH_HZ: f64 = 200e6;
const SPEED_OF_LIGHT: f64 = picket_dsp::config::SPEED_OF_LIGHT;

impl Case {
    /// The record `number` of a seed, of these impairments and kinds of record.
    pub fn new(all: &[(Impairment, bool)], seed: u64, number: u64) -> Option<Self> {
        let mut rng = generator(seed, number);
        let (impairment, iq) = all.get(number as usize % all.len().max(1))?.clone();
        let path = *Path::USUAL.choose(&mut rng)?;
        // Pairs in turn are I/Q, and half as many as the samples that are transformed.
        let path = if path == Path::ByTurns && !iq { Path::Block } else { path };
        let lengths = if path == Path::ByTurns { 6 } else { 7 };
        let n = 64 << rng.random_range(0..lengths);
        let floats = matches!(path, Path::Block | Path::Sum | Path::Chirps) && rng.random();
        let (signed, unsigned) = (Codes::signed::<12>(), Codes::unsigned::<12>());
        let wide = Codes::signed::<16>();
        // The converter's own codes, and those that the library is told of and gets.
        let (own, codes) =
            *[(signed, signed), (signed, unsigned), (wide, wide)].choose(&mut rng)?;
        let bursts = format!("{impairment}+burst:deviation=0.02,pedestal=0");
        let impairment = match Impairment::parse(&bursts) {
            Ok(pairs) if path == Path::Bursts => pairs.into_iter().next()?,
            _ => impairment,
        };
        let snr_db = *LEVELS_DB.choose(&mut rng)?;
        let mut setup = Setup::new(n * path.blocks(), snr_db);
        setup.width = Width::Codes(own);
        if !impairment.noisy() {
            setup.snr_db = f64::INFINITY;
        }
        setup.amplitude = match rng.random_range(0..6) {
            0 => Some(rng.random_range(1.0..20.0)),
            // From the rails to twice as far.
            1 => Some(f64::from(1 << (own.bits() - 1)) * rng.random_range(1.0..2.0)),
            _ => None,
        };
        if path.blocks() > 1 {
            let (blocks, half) = (path.blocks() as f64, 0.5 * n as f64);
            let bins = blocks * rng.random_range(2.0..half - 2.0);
            let bins = if iq && rng.random() { -bins } else { bins };
            setup.bins = Some((bins, bins + 1.0));
        }
        let config = if path == Path::Chirps {
            chirp(&mut rng, n, codes)?
        } else {
            scene(&mut rng, n, codes)?
        };
        let config = how(config, iq, path, &mut rng)?;
        let gap = rng.random_bool(1.0 / 16.0);
        Some(Self { path, iq, n, floats, config, gap, impairment, setup, rng })
    }

    /// What it is of.
    pub fn label(&self) -> String {
        let Self { path, iq, n, floats, config, impairment, .. } = self;
        let of = match config.scene {
            Scene::Chirp(chirp) => format!("{:?}", chirp.shape).to_lowercase(),
            _ => impairment.name(),
        };
        let engine = if *floats { "f32" } else { "i32" };
        let kind = if *iq { "iq" } else { "real" };
        format!("{} {kind} {n} {engine} {of}", path.name())
    }

    /// Its samples: the blocks one after the other, each with its stamp.
    pub fn samples<R: Kind>(&mut self) -> Result<(Vec<R::Sample>, Vec<Stamp>), String> {
        // 0 of signed codes is the middle of either.
        let zero = f64::from(self.config.codes.middle());
        let shifted = |x: Complex<f64>| code::<R>(x + Complex::new(zero, zero));
        let Scene::Chirp(told) = self.config.scene else {
            let record = self.impairment.record::<R>(&self.setup, &mut self.rng);
            let stamp = |index: usize| Stamp {
                sequence: index as u32,
                clock: (index * self.n) as u64,
                gap: self.gap && index == 0,
                ..Stamp::default()
            };
            let samples = record.samples.into_iter().map(shifted).collect();
            return Ok((samples, (0..self.path.blocks()).map(stamp).collect()));
        };
        let mut run = self.radar(&told)?;
        let (mut samples, mut stamps) = (Vec::new(), Vec::new());
        let segments = told.shape.segments();
        for index in 0..2 * segments.len() {
            let start_s = run.scene().start_s(index, self.n);
            stamps.push(Stamp {
                segment: segments[index % segments.len()],
                sequence: index as u32,
                clock: (start_s * self.config.rate_hz).round() as u64,
                gap: self.gap && index == 0,
            });
            let codes = run.record(index, self.n).into_iter();
            samples.extend(codes.map(|[i, q]| shifted(Complex::new(i.into(), q.into()))));
        }
        Ok((samples, stamps))
    }

    /// One or two targets before a chirp.
    fn radar(&mut self, told: &Chirp) -> Result<Run, String> {
        // The beat of a metre, bins.
        let per_m = 2.0 * BANDWIDTH_HZ / RAMP_S * RECORD_S / SPEED_OF_LIGHT;
        let bits = self.setup.width.codes().bits();
        let rail = f64::from(1 << (bits - 1));
        let target = |share: f64| {
            Source::Target(Target {
                range_m: Value::Between([4.0 / per_m, (0.5 * self.n as f64 - 4.0) / per_m]),
                velocity_mps: Value::Between([-30.0, 30.0]),
                amplitude: Some((share * rail).into()),
                ..Target::default()
            })
        };
        let both = [0.4, 0.25].map(target);
        let sources = both.into_iter().take(self.rng.random_range(1..3)).collect();
        let waveform = Waveform::from_chirp(told, self.n, 0.0);
        let rms = 0.3 * rail / 10f64.powf(self.setup.snr_db.clamp(-10.0, 60.0) / 20.0);
        let noise = Noise { rms: Some(rms.into()), ..Noise::default() };
        let receiver =
            Receiver { iq: self.iq, mixing: told.mixing.into(), noise, ..Receiver::default() };
        let mut scene = picket_simulator::Scene {
            seed: self.rng.random(),
            rate_hz: self.config.rate_hz,
            seconds: 6.0 * RAMP_S,
            waveform: Some(waveform),
            sources,
            receiver,
            ..picket_simulator::Scene::default()
        };
        scene.converter.bits = bits;
        scene.run(0)
    }
}

/// The settings of a chirp whose records have `n` samples.
fn chirp(rng: &mut ChaCha8Rng, n: usize, codes: Codes) -> Option<Config> {
    let told = Chirp {
        shape: *[Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth].choose(rng)?,
        wavelength_m: SPEED_OF_LIGHT / *[24e9, 77e9, 122e9].choose(rng)?,
        bandwidth_hz: BANDWIDTH_HZ,
        duration_s: RAMP_S,
        guard_s: RAMP_S - RECORD_S,
        mixing: *[Mixing::TxConjRx, Mixing::RxConjTx].choose(rng)?,
        sweep_curvature: *[0.0, 0.01].choose(rng)?,
    };
    let mut config = Config::new(n as f64 / RECORD_S, codes);
    config.scene = Scene::Chirp(told);
    config.velocity_mps = rng.random_bool(0.5).then_some((-40.0, 40.0));
    config.range_m = rng.random_bool(0.25).then_some((0.0, 1e4));
    Some(config)
}

/// The settings of any other record.
fn scene(rng: &mut ChaCha8Rng, n: usize, codes: Codes) -> Option<Config> {
    let rate_hz = *[n as f64, 48e3, 2e6].choose(rng)?;
    let mut config = Config::new(rate_hz, codes);
    if rng.random_bool(0.25) {
        let (wavelength_m, angle_rad) = (1550e-9, 0.3);
        config.scene = Scene::Doppler { wavelength_m, angle_rad, mixing: Mixing::RxConjTx };
    }
    if rng.random_bool(0.125) {
        config.band_hz = Some((0.1 * rate_hz, 0.4 * rate_hz));
    }
    if rng.random_bool(0.125) {
        let [linewidth_hz, envelope_hz] =
            [0.01, 0.1].map(|bins| (bins * rate_hz / n as f64) as f32);
        config.carrier = Carrier { linewidth_hz, envelope_hz };
    }
    Some(config)
}

/// Method, reach, arithmetic, effort and tracking of any record.
fn how(config: Config, iq: bool, path: Path, rng: &mut ChaCha8Rng) -> Option<Config> {
    let fits = |method: &Method| with_kind!(iq, R => method.fits::<R>());
    let methods: Vec<Method> = Method::ALL.iter().copied().filter(fits).collect();
    // A method beside least squares has one record in four.
    let other = rng.random_bool(0.25);
    let method = if other { *methods.choose(rng)? } else { Method::default() };
    let most = rng.random_range(1..=4);
    let most = if rng.random() { 1 } else { most };
    let refresh = *[0, 4].choose(rng)?;
    let following = Following { most, refresh, ..Following::default() };
    Some(Config {
        method,
        reach: *[Reach::Four, Reach::Eight, Reach::Sixteen].choose(rng)?,
        arithmetic: *[Arithmetic::Float, Arithmetic::Fixed].choose(rng)?,
        effort: *Effort::ALL.choose(rng)?,
        false_alarm: *[1e-6, 1e-6, 1e-3].choose(rng)?,
        following: if path == Path::Tracks { following } else { Following::NONE },
        ..config
    })
}
