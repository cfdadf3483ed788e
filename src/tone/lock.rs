//! A tone that is followed without a search: the factors of its frequency, and its noise.
//!
//! A followed tone is expected within a bin or two. So a block is mixed and decimated to 32 points about this frequency
//! ([`zoom`](crate::spectrum::zoom)) and fitted there ([`zoomed`]), at a tenth of the cost of a search. The lock holds as long as the tone
//! is strong enough for a detection at one known frequency, has not faded, and leaves no more than noise. The noise is an average over the
//! blocks, with the weight 1/16 for the last one.

use super::detection::HOLD;
use super::frequency::Frequency;
use super::zoomed::{self, Found, Place};
use super::{noise::ratio, zoomed::noise};
use crate::acquire::sample::Record;
use crate::math::scalar::Scalar;
use crate::spectrum::zoom::Oscillator;
use crate::tone::Tone;
use crate::tone::sigma::CLIPPED;

/// The weight of a block in the noise estimate. One block alone gives only some 23 degrees of freedom.
const RENEWAL: f32 = 1.0 / 16.0;

/// The ratio of a tone's power to the noise power of a bin must exceed this. The largest of five bins of noise exceeds the limit with the
/// probability [`HOLD`].
const STRENGTH: f32 = {
    // -ln(0.01 / 5)
    assert!(HOLD == 1e-2);
    6.214_608
};

/// A block whose residual exceeds the noise by this factor holds another signal. Fewer than one block in 10^6 exceeds it by chance: five
/// deviations of the cube root of a power with 23 degrees of freedom (Wilson and Hilferty 1931).
const EXCESS: f32 = 3.3;

/// A tone weaker than in the block before by this factor may be the leakage of a tone that has jumped away. Where one channel of an I/Q
/// record dies, a quarter of the power is left.
const FADED: f32 = 0.5;

/// A lock on a tone.
#[derive(Clone, Debug)]
pub struct Lock {
    oscillator: Oscillator,
    place: Place,
    /// Noise power per sample.
    noise: f32,
    /// The square of the tone's amplitude in the last block.
    power: f32,
    /// Blocks since the last whole search.
    pub age: u8,
}

impl Lock {
    /// A lock on a tone that a whole search found; `None` if the tone is too near an end of the
    /// spectrum (see [`zoomed::centre`]) or its noise is not known.
    pub fn on<R: Record>(tone: &Tone, n: usize) -> Option<Self> {
        let centre = zoomed::centre::<R>(tone.frequency.cycles_f32() * n as f32, n)?;
        let (noise, power) = strength::<R>(tone)?;
        Some(Self {
            oscillator: Oscillator::new::<R>(centre, n),
            place: Place::new(centre, n),
            noise,
            power,
            age: 0,
        })
    }

    /// Moves an existing lock to the tone; false if the tone is beyond the lock's reach.
    pub fn renew<R: Record>(&mut self, tone: &Tone, n: usize) -> bool {
        let Some((noise, power)) = strength::<R>(tone) else { return false };
        (self.noise, self.power, self.age) = (noise, power, 0);
        self.place.reaches(tone.frequency.cycles_f32() * n as f32)
    }

    /// Measures a tone `expected` at this many cycles per sample; `None` if the tone is not seen well, so that the block must be searched
    /// whole. `clipped` samples touch a rail.
    pub fn measure<R: Record, const N: usize>(
        &mut self,
        samples: &[R::Sample; N],
        expected: f32,
        clipped: u32,
    ) -> Option<Tone> {
        let bins = expected * N as f32;
        if !self.place.reaches(bins) {
            let centre = zoomed::centre::<R>(bins, N)?;
            self.oscillator = Oscillator::new::<R>(centre, N);
            self.place = Place::new(centre, N);
        }
        let zoom = self.oscillator.zoom::<R, N>(samples);
        let centre = self.oscillator.centre();
        let found = self.place.fit::<R>(&zoom, bins - centre as f32)?;
        let seen = noise::<R>(&found, N);
        let strong = found.explained > STRENGTH * self.noise * N as f32;
        let faded = found.amplitude_squared < FADED * self.power;
        if !strong || faded || seen > EXCESS * self.noise || clipped as f32 > CLIPPED * N as f32 {
            return None;
        }
        self.noise += RENEWAL * (seen - self.noise);
        self.power = found.amplitude_squared;
        self.age = self.age.saturating_add(1);
        self.tone::<R>(&found, N)
    }

    // Inlined where the length is known at compile time.
    #[inline]
    fn tone<R: Record>(&self, found: &Found, n: usize) -> Option<Tone> {
        let length = n as f32;
        let sigma = (length * self.noise / (found.information + found.information)).root();
        Some(Tone {
            frequency: Frequency::from_bins(self.oscillator.centre(), found.offset, n)?,
            sigma: sigma / length,
            snr: ratio(R::IQ, n, found.amplitude_squared, self.noise),
            amplitude: found.amplitude_squared.root(),
            ..Tone::ZERO
        })
    }
}

/// The noise power per sample and the square of the amplitude.
fn strength<R: Record>(tone: &Tone) -> Option<(f32, f32)> {
    let share = if R::IQ { 1.0 } else { 0.5 };
    let power = tone.amplitude * tone.amplitude;
    let noise = share * power / tone.snr;
    (noise > 0.0 && noise.is_finite()).then_some((noise, power))
}
