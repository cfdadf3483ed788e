//! The cosine and sine of a tone over a block of samples, and the sums of a block's samples with them.
//!
//! The table holds `cos(w k)` and `sin(w k)` for one block, and serves every block: with the phase p at the block's start, the sums follow
//! from `cos(p + w k) = cos p cos(w k) - sin p sin(w k)`.

use super::turn::{ONE, Turn, turned};
use crate::acquire::codes::Between;
use heapless::Vec;

/// The most samples of a block.
pub(super) const LONGEST: usize = GROUP * GROUPS;

/// The table's first numbers are found one after the other, the others as products of them.
const GROUP: usize = 8;
const GROUPS: usize = 10;

/// The table's 1 in Q15. Sums of rounded products then stay in 16 bits.
const UNIT: i32 = 32_764;

/// The cosine and sine of a tone in a block where its phase starts at 0, in Q15.
pub(super) struct Carrier {
    cosines: [[i16; GROUP]; GROUPS],
    sines: [[i16; GROUP]; GROUPS],
    length: usize,
    /// The sums over all samples: the kernel sums up the samples that do not count.
    #[cfg(dsp)]
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

    #[cfg(dsp)]
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

/// The sums of a loop over a block: the samples that count, with the tone, and the tone alone over the samples that do not count.
#[cfg(dsp)]
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub(super) struct Loop {
    pub out: Tone,
    pub yc: i64,
    pub ys: i64,
    pub y: i32,
}

/// The sums over a block's samples that count.
#[derive(Default)]
pub(super) struct Sums {
    tone: Tone,
    y: i32,
    yc: i64,
    ys: i64,
}

impl Carrier {
    /// The tone that turns by `forward` from sample to sample, over `length` samples: a multiple of
    /// eight, at most [`LONGEST`].
    pub fn new(forward: Turn, length: usize) -> Self {
        let (cosines, sines) = ([[0; GROUP]; GROUPS], [[0; GROUP]; GROUPS]);
        let length = length.min(LONGEST);
        #[cfg(not(dsp))]
        let mut carrier = Self { cosines, sines, length };
        #[cfg(dsp)]
        let mut carrier = Self { cosines, sines, length, whole: Tone::default() };
        carrier.fill(forward);
        #[cfg(dsp)]
        {
            let mut whole = Tone::default();
            let [cosines, sines] = carrier.parts();
            cosines.iter().zip(sines).for_each(|(&c, &s)| whole.add(c.into(), s.into()));
            carrier.whole = whole;
        }
        carrier
    }

    #[inline(never)]
    fn fill(&mut self, forward: Turn) {
        /// Half a unit of Q15, for rounding.
        const HALF: i32 = 1 << 14;
        let q15 = |turn: Turn| turn.map(|x| (((x >> 14) + 1) >> 1).min(32_767));
        let (mut turn, mut group) = ([ONE, 0], [[0; 2]; GROUP]);
        for place in &mut group {
            *place = q15(turn).map(|x| (x * UNIT + HALF) >> 15);
            turn = turned(turn, forward);
        }
        let (mut first, forward) = ([ONE, 0], turn);
        let groups = self.cosines.iter_mut().zip(&mut self.sines);
        for (cosines, sines) in groups.take(self.length / GROUP) {
            let [a, b] = q15(first);
            for ((cosine, sine), [c, d]) in cosines.iter_mut().zip(sines).zip(group) {
                *cosine = ((a * c - b * d + HALF) >> 15) as i16;
                *sine = ((a * d + b * c + HALF) >> 15) as i16;
            }
            first = turned(first, forward);
        }
    }

    /// The cosines and sines of a block.
    fn parts(&self) -> [&[i16]; 2] {
        [&self.cosines, &self.sines]
            .map(|x| x.as_flattened().get(..self.length).unwrap_or_default())
    }

    /// The sums over the samples of a block that count. A sample counts if it is inside the first
    /// bounds and its other sample is inside the second.
    #[inline(always)]
    pub fn sums(&self, samples: &[i16], others: &[i16], bounds: &[Between; 2]) -> Sums {
        #[cfg(dsp)]
        if let Some(sums) = super::carrier_dsp::sums(self.parts(), samples, others, bounds) {
            return self.ended(&sums);
        }
        self.sums_portably(samples, others, bounds)
    }

    /// [`Carrier::sums`] by its definition in portable code.
    // Few registers serve one short loop after the other better than one long loop.
    #[inline(never)]
    pub fn sums_portably(
        &self,
        samples: &[i16],
        others: &[i16],
        [inside, far_inside]: &[Between; 2],
    ) -> Sums {
        let [cosines, sines] = self.parts();
        let mut counted = Vec::<[i16; 4], LONGEST>::new();
        let turns = cosines.iter().zip(sines);
        for ((&y, &other), (&c, &s)) in samples.iter().zip(others).zip(turns) {
            if inside.holds(y) && far_inside.holds(other) {
                // It holds the longest block.
                let _ = counted.push([y, c, s, 0]);
            }
        }
        let counted = counted.iter().map(|x| x.map(i32::from));
        let product = |a: i32, b: i32| i64::from(a.wrapping_mul(b));
        let mut sums = Sums::default();
        for [y, c, s, _] in counted.clone() {
            sums.y = sums.y.wrapping_add(y);
            sums.yc = sums.yc.wrapping_add(product(y, c));
            sums.ys = sums.ys.wrapping_add(product(y, s));
        }
        for [_, c, s, _] in counted {
            sums.tone.add(c, s);
        }
        sums
    }

    #[cfg(dsp)]
    fn ended(&self, &Loop { ref out, yc, ys, y }: &Loop) -> Sums {
        Sums { tone: self.whole.less(out), y, yc, ys }
    }
}

impl Sums {
    /// The sums for a tone that enters the block with this phase.
    pub fn turned(&self, phase: Turn) -> Turned {
        /// The squares of a sample's cosine and sine together, in Q20.
        const SQUARE: i32 = ((UNIT as i64 * UNIT as i64) >> 10) as i32;
        let Tone { count, c, s, cc, cs } = self.tone;
        let square = count * SQUARE;
        let [c, s] = turned(phase, [c << 5, s << 5]);
        let twice = [(cc >> 10) as i32 - (square >> 1), (cs >> 10) as i32];
        let [more, cs] = turned(turned(phase, phase), twice);
        let cc = (square >> 1) + more;
        let [yc, ys] = turned(phase, [self.yc, self.ys].map(|sum| (sum >> 12) as i32));
        Turned { count, c, s, cc, cs, ss: square - cc, y: self.y << 3, yc, ys }
    }
}

/// [`Sums`] for the tone's own phase: sums of the tone alone in Q20, sums with a sample in Q3.
pub(super) struct Turned {
    pub count: i32,
    pub c: i32,
    pub s: i32,
    pub cc: i32,
    pub cs: i32,
    pub ss: i32,
    pub y: i32,
    pub yc: i32,
    pub ys: i32,
}
