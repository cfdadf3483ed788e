//! Picket measures the frequency of a tone in ADC samples, and from it a range and a velocity, as
//! precisely as the noise allows. Each answer has a `sigma`, the standard deviation of its error, and a `verdict`
//! that says whether it may be used.
//!
//! The name comes from the *picket-fence effect*: an FFT samples the spectrum only at its bins, like a view through a picket fence; Picket
//! measures between them. The library needs no `std`, allocates nothing and cannot panic. With the same [`Arithmetic`] setting a record
//! has the same answer, to the bit, on every Cortex-M, on riscv32, on wasm32 and on a desk. The default is [`Arithmetic::Fixed`] on
//! microcontrollers without an FPU and [`Arithmetic::Float`] elsewhere.
//!
//! A tone of a recording, in a driver's chunks:
//!
//! ```
//! use picket_dsp::{Codes, Config, Format, Framer, Pipeline, Real};
//!
//! # let noise = |n: usize| ((n * n * 7919 + n * 104_729) % 1013) as f64 - 506.0;
//! # let recording: Vec<i16> =
//! #     (0..4096).map(|n| (9000.0 * (0.1309 * n as f64).sin() + noise(n)) as i16).collect();
//! # let printed = "999.995 Hz ± 0.041 Hz, SNR 25.9 dB, good";
//! let config = Config::new(48_000.0, Codes::signed::<16>());
//! let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
//! let mut framer = Framer::<Real, 1024>::new(Format::signed::<16>());
//! for chunk in recording.chunks(480) {
//!     framer.push(chunk, |stamp, samples| {
//!         let tone = pipeline.block(stamp, samples).tone;
//!         println!("{tone}"); // 999.995 Hz ± 0.041 Hz, SNR 25.9 dB, good
//! #         assert!(stamp.sequence > 0 || tone.to_string() == printed, "{tone}");
//! #         let off = tone.hertz() - 0.1309 / std::f64::consts::TAU * 48e3;
//! #         assert!(off.abs() < 3.0 * tone.sigma_hertz(), "{off}");
//!     });
//! }
//! # assert!(include_str!("../README.md").contains(printed));
//! # Ok::<(), picket_dsp::ConfigError>(())
//! ```
//!
//! The velocity of a target in front of a 24 GHz Doppler radar, from I/Q samples at 8 kHz:
//!
//! ```
//! use picket_dsp::{Codes, Config, Iq, Mixing, Outcome, Pipeline, Scene, Stamp, Usable};
//!
//! # let mut state = 1u32;
//! # let mut noise = || { state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); f64::from(state >> 16) / 6553.6 - 5.0 };
//! # let samples: [[i16; 2]; 512] = std::array::from_fn(|n| {
//! #     let (sin, cos) = (std::f64::consts::TAU * 400.0 / 8e3 * n as f64).sin_cos();
//! #     [(800.0 * cos + noise()) as i16, (800.0 * sin + noise()) as i16]
//! # });
//! let scene = Scene::Doppler { wavelength_m: 0.012427, angle_rad: 0.0, mixing: Mixing::RxConjTx };
//! let config = Config { scene, ..Config::new(8_000.0, Codes::signed::<12>()) };
//! let mut pipeline = Pipeline::<Iq, 512>::new(config.plan()?);
//! let measurement = pipeline.block(&Stamp::default(), &samples);
//! if let Outcome::Velocity(speed) = measurement.result
//!     && speed.verdict.usable() <= Usable::WithinSigma
//! {
//!     println!("{} ± {} m/s", speed.velocity, speed.sigma); // 2.485 m/s, approaching
//! #   assert!((speed.velocity.to_num::<f64>() - 2.4854).abs() < 5.0 * f64::from(speed.sigma));
//! }
//! # assert!(matches!(measurement.result, Outcome::Velocity(speed) if speed.verdict == picket_dsp::Verdict::Good));
//! # Ok::<(), picket_dsp::ConfigError>(())
//! ```
//!
//! Two tones of one block, each with its sigma and its phase:
//!
//! ```
//! use picket_dsp::{Codes, Config, Pipeline, Real, Stamp};
//!
//! # let mut state = 1u32;
//! # let mut noise = || { state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223); f64::from(state >> 16) / 6553.6 - 5.0 };
//! # let samples: [i16; 1024] = std::array::from_fn(|n| {
//! #     let turn = |hertz: f64| (std::f64::consts::TAU * hertz / 48e3 * n as f64).cos();
//! #     (900.0 * turn(5_000.0) + 300.0 * turn(7_321.0) + noise()) as i16
//! # });
//! let config = Config::new(48_000.0, Codes::signed::<12>());
//! let mut pipeline = Pipeline::<Real, 1024>::new(config.plan()?);
//! let measurement = pipeline.block(&Stamp::default(), &samples);
//! # let mut seen = 0;
//! for line in pipeline.lines(&measurement, 2) {
//!     println!("{}, phase {} ± {}", line.tone, line.phase, line.sigma_phase);
//! #   seen += 1;
//! #   let near = [5_000.0, 7_321.0].map(|hertz| (line.tone.hertz() - hertz).abs() < 5.0 * line.tone.sigma_hertz());
//! #   assert!(near.contains(&true), "{}", line.tone);
//! }
//! # assert_eq!(seen, 2);
//! # Ok::<(), picket_dsp::ConfigError>(())
//! ```
//!
//! The main types below have examples of chirps, tracks, bursts, sums and frames.
//!
//! # How the data flow
//!
//! ```text
//! words ─ Framer ───┐
//!                   ├▶ record ─▶ bins ─▶ peak, floor ─▶ Tone ─▶ Velocity, Target
//! slots ─ FrontEnd ─┘   FFT      search      fit          solver
//!     acquire               spectrum          tone        solve
//! ```
//!
//! - [`Config`] holds the settings. [`Config::plan`] checks them once and makes a [`Plan`]; nothing
//!   after that can fail. [`Codes`] are those of the converter, [`Following`] sets how tones are followed, [`Carrier`] the width of the tone
//!   itself; [`Reach`], [`Arithmetic`] and [`Effort`] set how least squares works.
//! - [`Pipeline`] measures one record. [`Tracker`] also follows tones from record to record.
//! - [`FrequencyOnly`] answers without a verdict, in a third of the program memory.
//! - [`Alternating`] measures I/Q pairs that one converter takes in turn: I is a signal in phase with a reference, Q the one a quarter
//!   of a period later.
//! - [`Framer`] makes records of a driver's chunks. [`FrontEnd`](acquire::frontend::FrontEnd)
//!   makes them of a DMA controller's slots, without a copy. [`Format`] describes where a word holds its code. A record is [`Real`] or
//!   [`Iq`], and its [`Stamp`] is the time at which it was taken.
//! - [`BurstProcessor`] finds bursts in a stream, such as particles in a laser-Doppler velocimeter, and measures each.
//! - [`Accumulator`] adds the spectra of many blocks, for echoes too weak for one.
//! - [`Pipeline::lines`] finds up to four tones of a block, each a [`ToneWithPhase`] with its phase;
//!   [`Pipeline::harmonic`] finds one fundamental of many harmonics.
//! - A [`Measurement`] is a [`Tone`] and its [`Outcome`]. A tone has a [`Frequency`], its sigma, a signal-to-noise ratio, an amplitude
//!   and a [`Verdict`]; [`Pipeline::explain`] returns the tests that led to it.
//! - [`Scene`] describes the sensor. With [`Scene::Doppler`] a measurement has a
//!   [`Velocity`], with [`Scene::Chirp`] a [`Target`]. [`solve`] also has the measurements that need phases: [`displacement`](solve::displacement), the
//!   [range by phase](solve::phase_range), the [sequence](solve::sequence) of sawtooth chirps, the [pairing](solve::pairing) of the beats
//!   of several targets.
//! - [`Frame`](frame::Frame) finds several targets with range and velocity in a frame of sawtooth chirps, even if no single chirp shows them.
//! - [`RateCheck`](acquire::rate_check::RateCheck) compares the sample clock with another; an [`Uncertainty`](solve::uncertainty::Uncertainty)
//!   makes the whole error of an answer.
//! - [`Method`] names the estimators: least squares, the default, and others by the feature `methods`.
//! - [`I32`] and `F32` are the engines of the transform: the default, and one in floats.
//!
//! Every module names the paper that its equations come from, and says where ours differ.
//!
//! # How a block becomes a tone
//!
//! A record is one block of N samples. [`Pipeline::block`] runs these steps; `with_evidence` of [`tone::measure`] does 3 to 10. The linked
//! modules cover an ordinary block; unsteady or weak lines are handled in `model`, `close_judgement`, `close_detection` and
//! `measure::unusual`.
//!
//! 1. **Transform** ([`Spectrum`](spectrum::Spectrum)): an FFT of the samples without a window, in integers by the default engine. The module
//!    documentation of [`spectrum::fft::integer`] defines it; the kernels make it faster.
//! 2. **Search** ([`spectrum::peak`]): the strongest bin of the band, and the floor, which is the sum of the powers of the bins elsewhere.
//!    [`Search`](spectrum::peak::Search) defines it; the modules `scan` and `pairs` and the engines make it faster. The bins around the peak
//!    are then read once, for the fit and for the noise ([`spectrum::neighbourhood`]).
//! 3. **Fit** ([`tone::fit`]): least squares with the exact bins of a tone ([`tone::fit::iq`]) or of a tone and its mirror image
//!    ([`tone::fit::real`]). The fit gives frequency, amplitude and residual.
//! 4. **Noise** ([`tone::noise::ring`]): the power in a ring of bins beside the tone.
//! 5. **Judgement** (`tone::judge`): a residual as strong as that noise means one steady tone. A stronger residual means that the tone moves,
//!    or that another signal is beside it, and then a joint fit finds out which ([`Effort`]).
//! 6. **Sigma** ([`tone::sigma`]): from noise and fit, wider by what the judgement found. In a record that clips, a censored fit takes the
//!    noise from the samples between the rails ([`tone::clipped`]).
//! 7. **Detection** ([`tone::detection`]): the line exceeds floor and noise by more than chance allows.
//! 8. **Image** (`tone::image`): an I/Q record has no strong line at minus the frequency.
//! 9. **Joint fit** (`model`) of a line that is not a steady tone, in up to three rounds: its answer replaces that of the fit.
//! 10. **Front end** (`tone::front_end`): the other bins look as samples of a converter that works.
//! 11. **Verdict** ([`tone::evidence`]): the results of all tests are one `Evidence`, each of its rules gives a reason, and the most severe
//!     reason is the verdict.
//!
//! Last of all, sigma is widened by the selection of a tone near the detection threshold, by the engine's error, by the carrier's width and
//! by the rounding of the frequency.
//!
//! # Features
//!
//! For one [`Arithmetic`] no feature changes an answer: every build has every verdict and every sigma.
//!
//! - `methods` adds the papers' methods and others to least squares.
//! - `both-arithmetics` is for a microcontroller's program that chooses its arithmetic at run time. Without it the program has its core's
//!   alone, whatever [`Config::arithmetic`] says; on a desk every program has both.
//! - `joint-fit` adds the rounds of [`Effort`]: a joint fit of a tone and of what else is there. Without it every effort is none.
//! - `microfft` adds the engine `F32`: a transform in floats, by the crate of this name.
//! - `portable-atomic` is for cores that cannot swap a word atomically, such as riscv32imc.
//! - `defmt` adds `defmt::Format` for answers and errors.
//! - `serde` adds `Serialize` and `Deserialize` for [`Config`] and for answers. What a configuration leaves out has its default;
//!   a frequency comes back to the bit.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![warn(missing_debug_implementations)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

#[cfg(test)]
extern crate std;

/// The README's code is compiled as it stands there.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

pub mod accumulate;
pub mod acquire;
pub mod burst;
pub mod carrier;
mod chance;
pub mod config;
mod error;
pub mod frame;
pub mod frequency;
mod list;
pub mod math;
pub mod methods;
#[doc(hidden)]
pub mod model;
pub mod pipeline;
pub mod plan;
pub mod solve;
pub mod spectrum;
#[cfg(feature = "serde")]
mod stored;
pub mod tone;
pub mod tracker;

/// The crates whose types appear in signatures here: fixed point, vectors of fixed capacity, complex numbers.
#[doc(no_inline)]
pub use {fixed, heapless, num_complex};

#[doc(inline)]
pub use accumulate::{Accumulated, Accumulator};
#[doc(inline)]
pub use acquire::burst::{BurstDetector, Trigger};
#[doc(inline)]
pub use acquire::codes::Codes;
#[doc(inline)]
pub use acquire::format::Format;
#[doc(inline)]
pub use acquire::framer::Framer;
#[doc(inline)]
pub use acquire::sample::{Iq, Real, Record, Segment, Stamp};
#[doc(inline)]
pub use burst::{Burst, Validation};
#[doc(inline)]
pub use carrier::Carrier;
#[doc(inline)]
pub use config::{Config, ConfigError, Following, Scene};
#[doc(inline)]
pub use methods::registry::{Method, UnknownMethod};
#[doc(inline)]
pub use pipeline::{
    Alternating, BurstProcessor, FrequencyOnly, LengthError, Measurement, Outcome, Pipeline,
    Unjudged,
};
#[doc(inline)]
pub use plan::Plan;
#[doc(inline)]
pub use solve::candidates::{Ambiguity, Candidate, Candidates, Decision};
#[doc(inline)]
pub use solve::chirp::{Mixing, Shape, Target};
#[doc(inline)]
pub use solve::doppler::Velocity;
#[doc(inline)]
pub use solve::equations::Chirp;
#[doc(inline)]
pub use solve::track::Track;
#[cfg(feature = "microfft")]
#[doc(inline)]
pub use spectrum::engine::F32;
#[doc(inline)]
pub use spectrum::engine::I32;
#[doc(inline)]
pub use tone::Tone;
#[doc(inline)]
pub use tone::arithmetic::Arithmetic;
#[doc(inline)]
pub use tone::effort::Effort;
#[doc(inline)]
pub use tone::fit::Reach;
#[doc(inline)]
pub use tone::frequency::Frequency;
#[doc(inline)]
pub use tone::phasor::ToneWithPhase;
#[doc(inline)]
pub use tone::verdict::{Usable, Verdict, Verdicts};
#[doc(inline)]
pub use tracker::Tracker;
