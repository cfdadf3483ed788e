//! A tone that is followed without a search: the factors of its frequency, and its noise.
//!
//! A followed tone is expected within a bin or two. So a block is mixed and decimated to 32 points about this frequency
//! ([`zoom`](crate::spectrum::zoom)) and fitted there ([`zoomed`]), at a tenth of the cost of a search. The lock holds as long as the tone
//! is strong enough for a detection at one known frequency, has not faded, and leaves no more than noise. The noise is an average over the
//! blocks, with the weight 1/16 for the last one.

use super::threshold::HOLD;
use super::zoomed::{self, Found, Place};
use super::{noise::ratio, zoomed::noise};
use crate::frequency::Frequency;
use crate::math::scalar::Scalar;
use crate::spectrum::layout::Layout;
use crate::spectrum::zoom::{Oscillator, Zoom};
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
    pub fn on(tone: &Tone, layout: &Layout) -> Option<Self> {
        let centre = zoomed::centre(tone.frequency.cycles_f32() * layout.n as f32, layout)?;
        let (noise, power) = strength(layout.iq, tone)?;
        Some(Self {
            oscillator: Oscillator::new(centre, layout),
            place: Place::new(centre, layout),
            noise,
            power,
            age: 0,
        })
    }

    /// Moves an existing lock to the tone; false if the tone is beyond the lock's reach.
    pub fn renew(&mut self, tone: &Tone, layout: &Layout) -> bool {
        let Some((noise, power)) = strength(layout.iq, tone) else { return false };
        (self.noise, self.power, self.age) = (noise, power, 0);
        self.place.reaches(tone.frequency.cycles_f32() * layout.n as f32)
    }

    /// Moves the lock's centre so that it reaches a tone `expected` at this many cycles per sample; `None` if there is no such centre.
    pub fn aim(&mut self, expected: f32, layout: &Layout) -> Option<&Oscillator> {
        let bins = expected * layout.n as f32;
        if !self.place.reaches(bins) {
            let centre = zoomed::centre(bins, layout)?;
            self.oscillator = Oscillator::new(centre, layout);
            self.place = Place::new(centre, layout);
        }
        Some(&self.oscillator)
    }

    /// Measures the tone to which [`Lock::aim`] has turned, in the block's zoom; `None` if the tone is not seen well, so that the block must
    /// be searched whole. `clipped` samples touch a rail.
    pub fn measure(
        &mut self,
        zoom: &Zoom,
        expected: f32,
        clipped: u32,
        layout: &Layout,
    ) -> Option<Tone> {
        let &Layout { n, iq, .. } = layout;
        let centre = self.oscillator.centre();
        let found = self.place.fit(zoom, expected * n as f32 - centre as f32)?;
        let seen = noise(iq, &found, n);
        let strong = found.explained > STRENGTH * self.noise * n as f32;
        let faded = found.amplitude_squared < FADED * self.power;
        if !strong || faded || seen > EXCESS * self.noise || clipped as f32 > CLIPPED * n as f32 {
            return None;
        }
        self.noise += RENEWAL * (seen - self.noise);
        self.power = found.amplitude_squared;
        self.age = self.age.saturating_add(1);
        self.tone(&found, layout)
    }

    fn tone(&self, found: &Found, &Layout { n, iq, .. }: &Layout) -> Option<Tone> {
        let length = n as f32;
        let sigma = (length * self.noise / (found.information + found.information)).root();
        Some(Tone {
            frequency: Frequency::from_bins(self.oscillator.centre(), found.offset, n)?,
            sigma: sigma / length,
            snr: ratio(iq, n, found.amplitude_squared, self.noise),
            amplitude: found.amplitude_squared.root(),
            ..Tone::ZERO
        })
    }
}

/// The noise power per sample and the square of the amplitude.
fn strength(iq: bool, tone: &Tone) -> Option<(f32, f32)> {
    let share = if iq { 1.0 } else { 0.5 };
    let power = tone.amplitude * tone.amplitude;
    let noise = share * power / tone.snr;
    (noise > 0.0 && noise.is_finite()).then_some((noise, power))
}
