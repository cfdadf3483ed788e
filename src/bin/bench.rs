//! Counts instructions: every stage of a measurement of the capture's blocks, and, in an image with the feature
//! `rivals`, other people's transforms of the same blocks. Also compares the kernels with their
//! definition, on the capture's blocks and on random ones.
//!
//! The header's period, which has no other meaning here, is the number of random blocks.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use picket::acquire::capture::{ForRecord, decode, for_record};
use picket::acquire::sample::{Codes, Record, Statistics};
use picket::board::count::{Random, count};
use picket::board::halt::{Exit, exit};
use picket::board::mps2::{Timer, Uart, figure, handlers};
use picket::board::playback::{Playback, Results};
use picket::estimate::measure::measure;
use picket::pipeline::Pipeline;
use picket::spectrum::Spectrum;
use picket::spectrum::fft::twiddle::MAX_LENGTH;
use picket::spectrum::peak::{self, Band, Search};

picket::vectors!(handlers(&[]));

#[entry]
fn main() -> ! {
    let playback = Playback::open();
    let (iq, n) = (playback.header.iq, playback.header.n as usize);
    Timer::ONE.run_free();
    for_record(iq, n, Bench(playback));
    exit(Exit::Done)
}

struct Bench(Playback);

impl ForRecord for Bench {
    type Output = ();

    #[inline(never)]
    fn run<R: Record, const N: usize>(self) {
        let Bench(mut playback) = self;
        let header = playback.header;
        let plan = playback.plan::<R>(N);
        let mut pipeline = Pipeline::<R, N>::new(plan);
        let mut spectrum = Spectrum::<R, N>::new();
        let mut equality = Equality::<R, N>::default();
        let mut bytes = [0; 4 * MAX_LENGTH];
        let mut samples = [R::Sample::default(); N];
        let mut results = Results::open();
        for sequence in 0..header.blocks {
            if let Some(bytes) = bytes.get_mut(..header.block_bytes()) {
                playback.read(bytes);
                decode::<R>(bytes, &mut samples);
            }
            let (samples, stamp) =
                (black_box(&samples), header.timing().stamp(sequence.into(), false));
            count("fft", || spectrum.transform(samples, plan.codes));
            count("peak", || peak::find(&spectrum, plan.band));
            let found = count("fft_peak", || {
                spectrum.transform(samples, plan.codes);
                peak::find(&spectrum, plan.band)
            });
            let clipped = count("clipped", || Statistics::clipped::<R>(samples, plan.codes));
            if let Some(peak) = black_box(found) {
                count("estimator", || {
                    measure(&spectrum, samples, &peak, clipped, &stamp, &plan.options)
                });
            }
            count("measurement", || pipeline.block(stamp, samples));
            for k in 0..N as i32 / 2 {
                let x = spectrum.bin(k);
                results.write([x.re as f32, x.im as f32]);
            }
            #[cfg(feature = "rivals")]
            rivals::count_all::<R, N>(samples, &mut results);
            equality.compare(samples, plan.codes);
        }
        equality.drive(header.period_us);
        figure(Uart::ONE, "pipeline_bytes", size_of::<Pipeline<R, N>>() as u64);
        figure(Uart::ONE, "spectrum_bytes", size_of::<Spectrum<R, N>>() as u64);
        figure(Uart::ONE, "compared", equality.compared.into());
        figure(Uart::ONE, "unequal", equality.unequal.into());
    }
}

/// Kernels beside their definition.
struct Equality<R: Record, const N: usize> {
    kernel: Spectrum<R, N>,
    definition: Spectrum<R, N>,
    compared: u32,
    unequal: u32,
}

impl<R: Record, const N: usize> Default for Equality<R, N> {
    fn default() -> Self {
        Self { kernel: Spectrum::new(), definition: Spectrum::new(), compared: 0, unequal: 0 }
    }
}

impl<R: Record, const N: usize> Equality<R, N> {
    fn compare(&mut self, samples: &[R::Sample; N], codes: Codes) {
        self.kernel.transform(samples, codes);
        self.definition.transform_portably(samples, codes);
        let same = self.kernel.points() == self.definition.points()
            && self.kernel.exponent() == self.definition.exponent();
        let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
        let mut search = Search::new(band);
        for k in band.low..=band.high {
            search.push(self.definition.power(k));
        }
        self.compared = self.compared.wrapping_add(1);
        if !same || peak::find(&self.kernel, band) != search.finish() {
            self.unequal = self.unequal.wrapping_add(1);
        }
    }

    /// So many random blocks of random strength; every other one touches nothing but the rails, and every
    /// eighth is periodic, so that bins are equally strong.
    fn drive(&mut self, blocks: u32) {
        let mut random = Random(20_220_222);
        let mut samples = [R::Sample::default(); N];
        for block in 0..blocks {
            let codes = match block % 3 {
                0 => Codes::Signed12,
                1 => Codes::Unsigned12,
                _ => Codes::Signed16,
            };
            let (low, high) = codes.rails();
            let weaker = random.draw() % codes.bits();
            let period = if block % 8 == 7 { 1 << (random.draw() % 8) } else { N };
            for index in 0..N {
                let repeated =
                    index.checked_sub(period).and_then(|index| samples.get(index)).copied();
                let mut code = || {
                    let bits = random.draw();
                    if block % 2 == 0 {
                        return if bits & 1 == 0 { low } else { high };
                    }
                    let span = (i32::from(high) - i32::from(low)) >> weaker;
                    let within = (bits >> 8).checked_rem(span as u32 + 1).unwrap_or(0) as i32;
                    (i32::from(low) + within) as i16
                };
                let fresh = R::of_parts([code(), code()]);
                if let Some(sample) = samples.get_mut(index) {
                    *sample = repeated.unwrap_or(fresh);
                }
            }
            self.compare(&samples, codes);
        }
    }
}

/// Other people's transforms. They may panic; so this image is not part of the proof that none does.
#[cfg(feature = "rivals")]
mod rivals {
    use super::{Results, count};
    use core::hint::black_box;
    use fixed_dsp::transform::{RfftI16, RfftI32};
    use picket::acquire::sample::Record;

    /// Full scale of a 16-bit transform, from 12-bit codes.
    const UP: u32 = 4;

    pub fn count_all<R: Record, const N: usize>(samples: &[R::Sample; N], results: &mut Results) {
        if R::IQ {
            return;
        }
        let codes: [i16; N] = core::array::from_fn(|index| {
            samples.get(index).map_or(0, |&sample| R::parts(sample)[0])
        });
        floats(&codes, results);
        if N <= 1024 {
            let mut input = black_box(codes.map(|code| code << UP));
            let mut output = [fixed_fft_complex(); N];
            count("fixed-fft", || {
                let _ = fixed_fft::fft_radix2_real_q15(&mut input, &mut output, true);
            });
            for x in output.iter().take(N / 2) {
                results.write([x.re as f32, x.im as f32]);
            }
        }
        let mut input = black_box(codes.map(|code| code << UP));
        let mut output = [[0i16; 2]; N];
        let transform = RfftI16::new(N, false, true);
        count("fixed-dsp-q15", || transform.run(&mut input, output.as_flattened_mut()));
        for [re, im] in output.into_iter().take(N / 2) {
            results.write([re.into(), im.into()]);
        }
        let mut input = black_box(codes.map(|code| i32::from(code) << (UP + 16)));
        let mut output = [[0i32; 2]; N];
        let transform = RfftI32::new(N, false, true);
        count("fixed-dsp-q31", || transform.run(&mut input, output.as_flattened_mut()));
        for [re, im] in output.into_iter().take(N / 2) {
            results.write([re as f32, im as f32]);
        }
    }

    /// The crate exports no name for its number type's zero, and is built on an older `num-complex`.
    fn fixed_fft_complex() -> num_complex_old::Complex<i16> {
        num_complex_old::Complex::new(0, 0)
    }

    fn floats<const N: usize>(codes: &[i16; N], results: &mut Results) {
        let mut input = black_box(codes.map(f32::from));
        macro_rules! transform {
            ($function:ident) => {{
                let Ok(input) = <&mut [f32; _]>::try_from(input.as_mut_slice()) else { return };
                let output = count("microfft", || microfft::real::$function(input));
                for (k, x) in output.iter().enumerate() {
                    // DC and Nyquist share the first bin.
                    results.write([x.re, if k == 0 { 0.0 } else { x.im }]);
                }
            }};
        }
        match N {
            64 => transform!(rfft_64),
            128 => transform!(rfft_128),
            256 => transform!(rfft_256),
            512 => transform!(rfft_512),
            1024 => transform!(rfft_1024),
            2048 => transform!(rfft_2048),
            _ => transform!(rfft_4096),
        }
    }
}
