//! The stages of a measurement, for any engine.

use crate::equality::Equality;
use core::hint::black_box;
use core::marker::PhantomData;
use fixed::types::I0F32;
use picket_dsp::acquire::kind::ForRecord;
use picket_dsp::acquire::sample::{Data, Record, Statistics};
use picket_dsp::pipeline::Pipeline;
use picket_dsp::solve::chirp;
use picket_dsp::solve::equations::Chirp;
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::spectrum::fft::twiddle::MAX_LENGTH;
use picket_dsp::spectrum::peak;
use picket_dsp::tone::Tone;
use picket_dsp::tone::fit::fit_near;
use picket_dsp::tone::frequency::Frequency;
use picket_dsp::tone::measure::measure;
use picket_firmware::mps2::count::count;
use picket_firmware::mps2::playback::{Playback, Results};
use picket_firmware::mps2::{Timer, Uart, figure};
use picket_wire::capture::decode;

/// The beats of a trapezoid whose range beats at half the frequency of a tone, and whose Doppler shift is an eighth of the tone's
/// frequency.
fn beats<R: Record>(tone: &Tone) -> [Tone; 3] {
    let steps = tone.frequency.0.to_bits();
    let (range, shift) = (steps / 2, steps / 8);
    // Real records show no signs.
    let sign = if R::IQ { -1 } else { 1 };
    [range - shift, sign * shift, sign * (range + shift)]
        .map(|steps| Tone { frequency: Frequency(I0F32::from_bits(steps)), ..*tone })
}

/// The number of blocks whose spectra go to the host, own and third-party.
const SPECTRA: u32 = 8;

/// Counts the stages for the blocks of the capture.
pub struct Stages<E> {
    playback: Playback,
    engine: PhantomData<E>,
}

impl<E> Stages<E> {
    pub fn open() -> Self {
        let playback = Playback::open();
        Timer::ONE.run_free();
        Self { playback, engine: PhantomData }
    }

    /// The kind of the capture's records: whether they are I/Q, and their length.
    pub fn kind(&self) -> (bool, usize) {
        (self.playback.header.iq, self.playback.header.n as usize)
    }
}

impl<E: Engine> ForRecord for Stages<E> {
    type Output = ();

    #[inline(never)]
    fn run<R: Record, const N: usize>(self) {
        let Stages { mut playback, .. } = self;
        let header = playback.header;
        let plan = playback.plan::<R, N>();
        let mut pipeline = Pipeline::<R, N, E>::new(plan);
        let mut spectrum = Spectrum::<R, N, E>::new();
        let mut equality = Equality::<R, N, E>::default();
        let mut bytes = [0; 4 * MAX_LENGTH];
        let mut samples = [R::Sample::default(); N];
        let mut results = Results::open();
        let waveform = Chirp::default();
        let equations = waveform.equations(N as f64 / waveform.duration_s, N, R::IQ).ok();
        let equations = black_box(equations);
        for sequence in 0..header.blocks {
            if let Some(bytes) = bytes.get_mut(..header.block_bytes()) {
                playback.read(bytes);
                decode::<R>(bytes, &mut samples);
            }
            let (samples, stamp) =
                (black_box(&samples), header.timing().stamp(sequence.into(), false));
            count("fft", || spectrum.transform(samples, plan.codes));
            count("peak", || peak::find(&spectrum.view(), plan.band));
            let found = count("fft_peak", || {
                spectrum.transform(samples, plan.codes);
                peak::find(&spectrum.view(), plan.band)
            });
            let clipped =
                count("clipped", || Statistics::clipped(Data::of::<R>(samples), plan.codes));
            let found = black_box(found);
            count("estimator", || {
                found.map(|peak| {
                    measure(
                        &spectrum.view(),
                        fit_near::<R>(),
                        Data::of::<R>(samples),
                        &peak,
                        plan.codes,
                        clipped,
                        &stamp,
                        &plan.options,
                    )
                })
            });
            let measurement = count("measurement", || pipeline.block(&stamp, samples));
            let beats = black_box(beats::<R>(&measurement.tone));
            count("chirp", || {
                equations.map(|equations| chirp::trapezoid(&beats, R::IQ, &equations))
            });
            if sequence < SPECTRA {
                for k in 0..N as i32 / 2 {
                    let x = spectrum.bin(k);
                    results.write([x.re as f32, x.im as f32]);
                }
                #[cfg(feature = "rivals")]
                crate::rivals::count_all::<R, N>(samples, &mut results);
            }
            equality.compare(samples, plan.codes);
        }
        equality.drive(header.period_us, header.stride);
        figure(Uart::ONE, "pipeline_bytes", size_of::<Pipeline<R, N, E>>() as u64);
        figure(Uart::ONE, "spectrum_bytes", size_of::<Spectrum<R, N, E>>() as u64);
        equality.report();
    }
}
