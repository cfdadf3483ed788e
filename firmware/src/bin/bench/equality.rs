//! Compares kernels with their definition.

mod blocks;

use blocks::Blocks;
use fixed::types::I0F32;
use num_complex::Complex;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::{Data, Record, Statistics};
use picket_dsp::spectrum::Spectrum;
use picket_dsp::spectrum::engine::Engine;
use picket_dsp::spectrum::peak::{Band, find, find_portably};
use picket_dsp::tone::clipped::CensoredFit;
use picket_dsp::tone::frequency::Frequency;
use picket_firmware::mps2::{Uart, figure};

/// Kernels compared with their definition.
pub struct Equality<R: Record, const N: usize, E: Engine> {
    kernel: Spectrum<R, N, E>,
    definition: Spectrum<R, N, E>,
    /// Blocks compared.
    compared: u32,
    /// Blocks that differ.
    unequal: u32,
    /// The number of the first block that differs.
    first: Option<u32>,
    /// After this number of blocks only spectra and whole bands are compared, which is several times faster.
    pub whole: u32,
}

impl<R: Record, const N: usize, E: Engine> Default for Equality<R, N, E> {
    fn default() -> Self {
        Self {
            kernel: Spectrum::new(),
            definition: Spectrum::new(),
            compared: 0,
            unequal: 0,
            first: None,
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
        let found =
            |band| find(&self.kernel.view(), band) == find_portably(&self.definition.view(), band);
        let rest = || {
            let clipped = Statistics::from_samples(Data::of::<R>(samples), codes).clipped;
            Statistics::clipped(Data::of::<R>(samples), codes) == clipped
                && self.same_between_the_rails(samples, codes)
                && found(self.part_of(band))
        };
        let equal = same && found(band) && (self.compared >= self.whole || rest());
        if !equal {
            self.unequal = self.unequal.wrapping_add(1);
            self.first = self.first.or(Some(self.compared));
        }
        self.compared = self.compared.wrapping_add(1);
    }

    /// Whether kernel and definition give equal fits between the rails, for another tone in each block.
    fn same_between_the_rails(&self, samples: &[R::Sample; N], codes: Codes) -> bool {
        let steps = self.compared.wrapping_mul(0x9E37_79B9) >> if R::IQ { 0 } else { 1 };
        let frequency = Frequency(I0F32::from_bits(steps as i32));
        let tone = Complex::new(700.0, -300.0);
        let bits =
            |free: CensoredFit| [free.noise, free.offset, free.information].map(f32::to_bits);
        let kernel = CensoredFit::from_record(Data::of::<R>(samples), codes, frequency, tone);
        kernel.map(bits)
            == CensoredFit::from_record_portably(Data::of::<R>(samples), codes, frequency, tone)
                .map(bits)
    }

    /// Some part of a band, another one at each block.
    fn part_of(&self, band: Band) -> Band {
        let below = |salt: u32, limit: u32| {
            self.compared.wrapping_mul(salt).checked_rem(limit).unwrap_or(0) as i32
        };
        let low = band.low + below(37, band.width());
        Band { low, high: low + below(91, Band { low, ..band }.width()), ..band }
    }

    /// Compares this many random blocks. The first serial port gets a byte for every
    /// [`Equality::STEP`] of them.
    pub fn drive(&mut self, blocks: u32, seed: u32) {
        let mut random = Blocks::new(seed);
        let mut samples = [R::Sample::default(); N];
        for block in 1..=blocks {
            let codes = random.codes();
            random.fill::<R>(codes, &mut samples);
            self.compare(&samples, codes);
            if block % Self::STEP == 0 {
                Uart::ZERO.send(b".");
            }
        }
    }

    /// Reports the comparison.
    pub fn report(&self) {
        figure(Uart::ONE, "compared", self.compared.into());
        figure(Uart::ONE, "unequal", self.unequal.into());
        if let Some(first) = self.first {
            figure(Uart::ONE, "first_unequal", first.into());
        }
    }

    /// Blocks between two signs of progress.
    const STEP: u32 = 256;
}
