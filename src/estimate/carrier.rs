//! The cosine and sine of a tone over a block of samples, and the sums of a block's samples with them.

use super::least_squares::fixed::product;
use super::noise::whole_fixed::Turn;
use crate::acquire::codes::Between;
use heapless::Vec;
use num_complex::Complex;

/// The most samples of a block: a sixteenth of a record of 2048.
pub(super) const LONGEST: usize = 128;

/// The product of two turns. It loses the last two bits.
#[inline(always)]
pub(super) fn advanced([a, b]: Turn, [c, d]: Turn) -> Turn {
    let upper = |x: i32, y: i32| (product(x, y) >> 32) as i32;
    [(upper(a, c) - upper(b, d)) << 2, (upper(a, d) + upper(b, c)) << 2]
}

/// The cosine and sine of a tone in a block where its phase starts at 0, in Q15.
pub(super) struct Carrier {
    cosines: Vec<i16, LONGEST>,
    sines: Vec<i16, LONGEST>,
    /// The sums over all samples.
    whole: Tone,
}

/// Sums of a tone's cosine c and sine s over some samples. Products are in Q30.
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub(super) struct Tone {
    pub count: i32,
    pub c: i32,
    pub s: i32,
    pub cc: i64,
    pub cs: i64,
}

impl Tone {
    #[inline(always)]
    fn add(&mut self, c: i32, s: i32) {
        self.count = self.count.wrapping_add(1);
        self.c = self.c.wrapping_add(c);
        self.s = self.s.wrapping_add(s);
        self.cc = self.cc.wrapping_add(i64::from(c.wrapping_mul(c)));
        self.cs = self.cs.wrapping_add(i64::from(c.wrapping_mul(s)));
    }

    fn less(&self, other: &Self) -> Self {
        Self {
            count: self.count.wrapping_sub(other.count),
            c: self.c.wrapping_sub(other.c),
            s: self.s.wrapping_sub(other.s),
            cc: self.cc.wrapping_sub(other.cc),
            cs: self.cs.wrapping_sub(other.cs),
        }
    }
}

/// The sums of a loop over a block: those of the samples that count, with the tone, and those of
/// the tone alone over the samples that do not count.
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub(super) struct Loop {
    pub out: Tone,
    pub yc: i64,
    pub ys: i64,
    pub y: i32,
}

/// The sums over a block's samples that count.
pub(super) struct Sums {
    tone: Tone,
    y: i32,
    yc: i64,
    ys: i64,
}

impl Carrier {
    /// No tone yet.
    pub const fn empty() -> Self {
        let whole = Tone { count: 0, c: 0, s: 0, cc: 0, cs: 0 };
        Self { cosines: Vec::new(), sines: Vec::new(), whole }
    }

    /// Fills an empty carrier with the tone that turns by `forward` from sample to sample, over `length`
    /// samples, at most [`LONGEST`].
    // Not inlined, because a whole carrier would be copied.
    #[inline(never)]
    pub fn fill(&mut self, forward: Turn, length: usize) {
        let mut turn = [1 << 30, 0];
        for _ in 0..length.min(LONGEST) {
            let [cosine, sine] = turn.map(|x: i32| ((x + (1 << 14)) >> 15).min(32767) as i16);
            // The vectors hold the longest.
            let _ = (self.cosines.push(cosine), self.sines.push(sine));
            self.whole.add(cosine.into(), sine.into());
            turn = advanced(turn, forward);
        }
    }

    /// The sums over the samples of a block that count. A sample counts if it is inside the first
    /// bounds and its other sample is inside the second.
    #[inline(always)]
    pub fn sums(&self, samples: &[i16], others: &[i16], bounds: &[Between; 2]) -> Sums {
        #[cfg(dsp)]
        if let Some(sums) = super::carrier_dsp::sums(self.parts(), samples, others, bounds) {
            return self.ended(&sums);
        }
        self.sums_portably::<1>(samples, others, 0, bounds)
    }

    /// The cosines and sines of a block.
    #[cfg(dsp)]
    fn parts(&self) -> [&[i16]; 2] {
        [&self.cosines, &self.sines]
    }

    /// [`Carrier::sums`] by its definition, for samples of `STRIDE` numbers of which one is read.
    #[inline(never)] // its loop needs all registers
    pub fn sums_portably<const STRIDE: usize>(
        &self,
        samples: &[i16],
        others: &[i16],
        which: usize,
        [inside, far_inside]: &[Between; 2],
    ) -> Sums {
        let mut sums = Loop::default();
        let turns = self.cosines.iter().zip(&self.sines);
        let [samples, others] = [samples, others].map(|x| x.as_chunks::<STRIDE>().0);
        let pairs = samples.iter().zip(others);
        for ((&c, &s), (sample, other)) in turns.zip(pairs) {
            let (Some(&y), Some(&other)) = (sample.get(which), other.get(which)) else { break };
            let (c, s) = (i32::from(c), i32::from(s));
            if inside.holds(y) && far_inside.holds(other) {
                let y = i32::from(y);
                sums.y = sums.y.wrapping_add(y);
                sums.yc = sums.yc.wrapping_add(i64::from(y.wrapping_mul(c)));
                sums.ys = sums.ys.wrapping_add(i64::from(y.wrapping_mul(s)));
            } else {
                sums.out.add(c, s);
            }
        }
        self.ended(&sums)
    }

    fn ended(&self, &Loop { ref out, yc, ys, y }: &Loop) -> Sums {
        Sums { tone: self.whole.less(out), y, yc, ys }
    }
}

impl Sums {
    /// The sums for a tone that enters the block with this phase.
    pub fn turned(&self, phase: Complex<f32>) -> Turned {
        const UNIT: f32 = 1.0 / 32768.0;
        // A sum of products in Q30, without the bits that a float cannot hold.
        let product = |sum: i64| (sum >> 7) as i32 as f32 * (128.0 * UNIT);
        let Tone { count, c, s, cc, cs } = self.tone;
        let half = 0.5 * count as f32;
        let first = Complex::new(c as f32, s as f32) * phase;
        let second = Complex::new(product(cc) * UNIT - half, product(cs) * UNIT) * (phase * phase);
        let y = Complex::new(product(self.yc), product(self.ys)) * phase;
        Turned {
            count: count as f32,
            c: first.re * UNIT,
            s: first.im * UNIT,
            cc: half + second.re,
            cs: second.im,
            y: self.y as f32,
            yc: y.re,
            ys: y.im,
        }
    }
}

/// [`Sums`] for the tone's own phase.
pub(super) struct Turned {
    pub count: f32,
    pub c: f32,
    pub s: f32,
    pub cc: f32,
    pub cs: f32,
    pub y: f32,
    pub yc: f32,
    pub ys: f32,
}
