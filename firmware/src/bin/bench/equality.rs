//! Compares kernels with their definition.

use fixed::types::I0F32;
use num_complex::Complex;
use picket::acquire::codes::Codes;
use picket::acquire::sample::{Record, Statistics};
use picket::estimate::frequency::Frequency;
use picket::estimate::unclipped::Unclipped;
use picket::spectrum::Spectrum;
use picket::spectrum::engine::Engine;
use picket::spectrum::peak::{Band, find, find_portably};
use picket_firmware::mps2::count::Random;

/// Kernels compared with their definition.
pub struct Equality<R: Record, const N: usize, E: Engine> {
    kernel: Spectrum<R, N, E>,
    definition: Spectrum<R, N, E>,
    /// Blocks compared.
    pub compared: u32,
    /// Blocks that differ.
    pub unequal: u32,
    /// After so many blocks only spectra and whole bands are compared, which is several times faster.
    pub whole: u32,
}

impl<R: Record, const N: usize, E: Engine> Default for Equality<R, N, E> {
    fn default() -> Self {
        Self {
            kernel: Spectrum::new(),
            definition: Spectrum::new(),
            compared: 0,
            unequal: 0,
            whole: u32::MAX,
        }
    }
}

impl<R: Record, const N: usize, E: Engine> Equality<R, N, E> {
    /// Compares one block.
    pub fn compare(&mut self, samples: &[R::Sample; N], codes: Codes) {
        self.kernel.transform(samples, codes);
        self.definition.transform_portably(samples, codes);
        let same = self.kernel.points() == self.definition.points()
            && self.kernel.exponent() == self.definition.exponent();
        let band = if R::IQ { Band::iq(N) } else { Band::real(N) };
        let found = |band| find(&self.kernel, band) == find_portably(&self.definition, band);
        let rest = || {
            let clipped = Statistics::of::<R>(samples, codes).clipped;
            Statistics::clipped::<R>(samples, codes) == clipped
                && self.same_between_the_rails(samples, codes)
                && found(self.part_of(band))
        };
        let equal = same && found(band) && (self.compared >= self.whole || rest());
        self.compared = self.compared.wrapping_add(1);
        if !equal {
            self.unequal = self.unequal.wrapping_add(1);
        }
    }

    /// Whether kernel and definition find the same between the rails, of another tone at each block.
    fn same_between_the_rails(&self, samples: &[R::Sample; N], codes: Codes) -> bool {
        let steps = self.compared.wrapping_mul(0x9E37_79B9) >> if R::IQ { 0 } else { 1 };
        let frequency = Frequency(I0F32::from_bits(steps as i32));
        let tone = Complex::new(700.0, -300.0);
        let bits = |free: Unclipped| [free.noise, free.offset, free.information].map(f32::to_bits);
        let kernel = Unclipped::of::<R>(samples, codes, frequency, tone);
        kernel.map(bits) == Unclipped::of_portably::<R>(samples, codes, frequency, tone).map(bits)
    }

    /// Some part of a band, another one at each block.
    fn part_of(&self, band: Band) -> Band {
        let below = |salt: u32, limit: u32| {
            self.compared.wrapping_mul(salt).checked_rem(limit).unwrap_or(0) as i32
        };
        let low = band.low + below(37, band.width());
        Band { low, high: low + below(91, Band { low, ..band }.width()) }
    }

    /// Compares this many random blocks of random strength. Every other block has only samples at
    /// the rails, or about the middle, and every eighth is periodic, so that bins are equally strong.
    pub fn drive(&mut self, blocks: u32) {
        let mut random = Random(20_220_222);
        let mut samples = [R::Sample::default(); N];
        for block in 0..blocks {
            let codes = match block % 5 {
                0 => Codes::signed::<12>(),
                1 => Codes::unsigned::<12>(),
                2 => Codes::signed::<16>(),
                3 => Codes::unsigned::<10>(),
                _ => Codes::signed::<13>(),
            };
            let (low, high) = codes.rails();
            let weaker = random.draw() % codes.bits();
            let span = (i32::from(high) - i32::from(low)) >> weaker;
            let centred = random.draw() % 2 == 0;
            let lowest = i32::from(low)
                + if centred { (i32::from(high) - i32::from(low) - span) / 2 } else { 0 };
            let period = if block % 8 == 7 { 1 << (random.draw() % 8) } else { N };
            for index in 0..N {
                let repeated =
                    index.checked_sub(period).and_then(|index| samples.get(index)).copied();
                let mut code = || {
                    let bits = random.draw();
                    if block % 2 == 0 && !centred {
                        return if bits & 1 == 0 { low } else { high };
                    }
                    let within = (bits >> 8).checked_rem(span as u32 + 1).unwrap_or(0) as i32;
                    (lowest + within) as i16
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
