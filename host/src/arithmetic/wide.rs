//! The library's default engine on a desk: the definition's bits, by loops over eight numbers at a time.
//!
//! The definition, [`integer`], reads and writes a complex point at a time, which no compiler turns into vectors. Here real and
//! imaginary parts lie apart, and each pass has its factors in sequence. The additions, products and shifts of a point are the
//! definition's, in its order. The functions are compiled for two kinds of x86-64, and the processor decides.

use multiversion::multiversion;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::sample::Record;
use picket_dsp::spectrum::engine::{Engine, I32};
use picket_dsp::spectrum::fft::integer::{self, Pair, Point, Scale};
use picket_dsp::spectrum::fft::twiddle::{self, MAX_LENGTH};
use picket_dsp::spectrum::scan::Scan;
use std::cell::RefCell;
use std::mem::MaybeUninit;
use std::ops::RangeInclusive;
use std::sync::OnceLock;

/// The engine [`I32`], faster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide;

impl Engine for Wide {
    type Part = i32;
    const CENTRED: bool = I32::CENTRED;

    fn error(n: usize, iq: bool) -> f32 {
        I32::error(n, iq)
    }

    fn transform<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        WORK.with_borrow_mut(|work| transform(pairs, codes.bits(), points, work))
    }

    fn transform_portably<R: Record, const N: usize>(
        pairs: &[Pair],
        codes: Codes,
        points: &mut [Point],
    ) -> i32 {
        I32::transform_portably::<R, N>(pairs, codes, points)
    }

    fn bin<R: Record, const N: usize>(points: &[Point], k: usize) -> Point {
        I32::bin::<R, N>(points, k)
    }

    fn window<'a, R: Record, const N: usize>(
        points: &[Point],
        first: usize,
        places: &'a mut [MaybeUninit<Point>],
    ) -> &'a [Point] {
        I32::window::<R, N>(points, first, places)
    }

    fn search<R: Record, const N: usize>(
        points: &[Point],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        I32::search::<R, N>(points, bins)
    }

    fn search_portably<R: Record, const N: usize>(
        points: &[Point],
        bins: RangeInclusive<usize>,
    ) -> Option<Scan> {
        I32::search_portably::<R, N>(points, bins)
    }
}

/// The real and the imaginary parts of a transform's points, and of the first pass before it is put in order.
struct Work {
    ordered: [Box<[i32; MAX_LENGTH]>; 2],
    first: [Box<[i32; MAX_LENGTH]>; 2],
}

thread_local! {
    static WORK: RefCell<Work> = RefCell::new(Work {
        ordered: [(); 2].map(|()| Box::new([0; MAX_LENGTH])),
        first: [(); 2].map(|()| Box::new([0; MAX_LENGTH])),
    });
}

/// What a transform of one length reads.
struct Plan {
    /// The place of each group of the first pass.
    reversed: Vec<usize>,
    /// The factors of the passes behind it.
    passes: Vec<Pass>,
    /// Whether they have 32 bits.
    fine: bool,
}

/// The factors of a pass for the second, third and fourth points: those of the real parts and those of the imaginary ones.
struct Pass([[Vec<i32>; 2]; 3]);

/// The plan for `m` points, 32 to 4096.
fn plan(m: usize) -> &'static Plan {
    static PLANS: [OnceLock<Plan>; 8] = [const { OnceLock::new() }; 8];
    PLANS[m.trailing_zeros() as usize - 5].get_or_init(|| {
        let first = Scale::new(m, 16).first;
        let (fine, short) = (twiddle::fine_passes(m), twiddle::passes(m));
        let entries = fine.len().max(short.len());
        let factor = |leg: usize, index: usize| match fine.get(index) {
            Some(triple) => triple[leg],
            // As the upper word of a product has them.
            None => [(short[index][leg] << 16) as i32, (short[index][leg] & 0xffff_0000) as i32],
        };
        let lengths = std::iter::successors(Some(first), |length| Some(4 * length));
        let pass = |length: usize| {
            let indices = || (0..length).map(|index| index * (entries / length));
            let of = |leg, part: usize| indices().map(|index| factor(leg, index)[part]).collect();
            Pass([0, 1, 2].map(|leg| [0, 1].map(|part| of(leg, part))))
        };
        Plan {
            reversed: (0..m / first).map(|group| integer::reversed(group, m / first)).collect(),
            passes: lengths.take_while(|&length| length < m).map(pass).collect(),
            fine: !fine.is_empty(),
        }
    })
}

/// The transform of this many pairs as there are points: [`integer::transform`].
#[multiversion(targets("x86_64+avx2"))]
fn transform(pairs: &[Pair], bits: u32, points: &mut [Point], work: &mut Work) -> i32 {
    let (m, scale) = (points.len(), Scale::new(points.len(), bits));
    let plan = plan(m);
    let Work { first: [re, im], ordered } = work;
    let (re, im) = (&mut re[..m], &mut im[..m]);
    for ((re, im), pair) in re.iter_mut().zip(&mut *im).zip(pairs) {
        (*re, *im) = (i32::from(pair[0]), i32::from(pair[1]));
    }
    let [to, too] = ordered;
    match scale.first {
        8 => {
            match m {
                32 => first_pass::<8, 4>(re, im, scale.shift),
                _ => first_pass::<8, 8>(re, im, scale.shift),
            }
            order::<8>(re, &mut to[..m], &plan.reversed);
            order::<8>(im, &mut too[..m], &plan.reversed);
        }
        _ => {
            first_pass::<4, 8>(re, im, scale.shift);
            order::<4>(re, &mut to[..m], &plan.reversed);
            order::<4>(im, &mut too[..m], &plan.reversed);
        }
    }
    let (re, im) = (&mut to[..m], &mut too[..m]);
    let mut length = scale.first;
    for Pass(factors) in &plan.passes {
        for (re, im) in re.chunks_exact_mut(4 * length).zip(im.chunks_exact_mut(4 * length)) {
            match (plan.fine, length) {
                (true, 4) => radix4::<true, 4>(re, im, factors),
                (true, _) => radix4::<true, 8>(re, im, factors),
                (false, 4) => radix4::<false, 4>(re, im, factors),
                (false, _) => radix4::<false, 8>(re, im, factors),
            }
        }
        length *= 4;
    }
    for (point, (&re, &im)) in points.iter_mut().zip(re.iter().zip(&*im)) {
        *point = [re, im];
    }
    scale.exponent
}

/// Some points: their real parts and their imaginary ones.
type Points<const W: usize> = [[i32; W]; 2];

/// The first pass in groups of this many points, which lie a leg apart.
#[inline(always)]
fn first_pass<const LEGS: usize, const W: usize>(re: &mut [i32], im: &mut [i32], shift: u32)
where
    Group<LEGS>: Butterfly<LEGS>,
{
    let length = re.len() / LEGS;
    for at in (0..length).step_by(W) {
        let mut some: [Points<W>; LEGS] = [[[0; W]; 2]; LEGS];
        for (leg, [x, y]) in some.iter_mut().enumerate() {
            x.copy_from_slice(&re[leg * length + at..][..W]);
            y.copy_from_slice(&im[leg * length + at..][..W]);
        }
        for i in 0..W {
            let mut points = [[0; 2]; LEGS];
            for (point, [x, y]) in points.iter_mut().zip(&some) {
                *point = [x[i], y[i]];
            }
            for ([x, y], point) in some.iter_mut().zip(Group::first(points, shift)) {
                [x[i], y[i]] = point;
            }
        }
        for (leg, [x, y]) in some.iter().enumerate() {
            re[leg * length + at..][..W].copy_from_slice(x);
            im[leg * length + at..][..W].copy_from_slice(y);
        }
    }
}

/// A group of the first pass. A trait names its function, because the compiler does not inline one that is an argument.
struct Group<const LEGS: usize>;

trait Butterfly<const LEGS: usize> {
    /// The group's points, shifted up.
    fn first(points: [Point; LEGS], shift: u32) -> [Point; LEGS];
}

impl Butterfly<4> for Group<4> {
    #[inline(always)]
    fn first([a, b, c, d]: [Point; 4], shift: u32) -> [Point; 4] {
        butterfly([up(a, shift), up(b, shift), up(c, shift), up(d, shift)])
    }
}

impl Butterfly<8> for Group<8> {
    #[inline(always)]
    fn first([a, b, c, d, e, f, g, h]: [Point; 8], shift: u32) -> [Point; 8] {
        let diagonal = |x: i32| upper(x << (shift + 1), integer::DIAGONAL << 15);
        let [e0, e1, e2, e3] = butterfly([a, c, e, g]);
        let (e0, e1, e2, e3) = (up(e0, shift), up(e1, shift), up(e2, shift), up(e3, shift));
        let [o0, [p, q], o2, [r, s]] = butterfly([b, d, f, h]);
        let (o0, o2) = (up(o0, shift), up([o2[1], o2[0].wrapping_neg()], shift));
        let o1 = [diagonal(p.wrapping_add(q)), diagonal(q.wrapping_sub(p))];
        let o3 = [diagonal(s.wrapping_sub(r)), diagonal(r.wrapping_add(s)).wrapping_neg()];
        let (low, high) = ([add(e0, o0), add(e1, o1)], [add(e2, o2), add(e3, o3)]);
        let (back, last) = ([sub(e0, o0), sub(e1, o1)], [sub(e2, o2), sub(e3, o3)]);
        [low[0], low[1], high[0], high[1], back[0], back[1], last[0], last[1]]
    }
}

#[inline(always)]
fn up(x: Point, shift: u32) -> Point {
    [x[0] << shift, x[1] << shift]
}

/// Puts the groups of the first pass, whose legs lie apart, in the order of the next pass.
#[inline(always)]
fn order<const LEGS: usize>(first: &[i32], ordered: &mut [i32], reversed: &[usize]) {
    let length = reversed.len();
    let legs: [&[i32]; LEGS] = std::array::from_fn(|leg| &first[leg * length..][..length]);
    for (group, &at) in ordered.as_chunks_mut::<LEGS>().0.iter_mut().zip(reversed) {
        for (point, leg) in group.iter_mut().zip(legs) {
            *point = leg[at];
        }
    }
}

/// A radix-4 pass over one block of four sub-transforms, which halves once. The first point of each sub-transform
/// has no factor: it is put in its place last.
#[inline(always)]
fn radix4<const FINE: bool, const W: usize>(
    re: &mut [i32],
    im: &mut [i32],
    factors: &[[Vec<i32>; 2]; 3],
) {
    let length = re.len() / 4;
    let alone = |leg: usize| [re[leg * length] >> 1, im[leg * length] >> 1];
    // The points without a factor, before they are written.
    let alone = butterfly([alone(0), alone(1), alone(2), alone(3)]);
    let [[f, fi], [g, gi], [h, hi]] = factors;
    let (f, fi) = (f.as_chunks::<W>().0, fi.as_chunks::<W>().0);
    let (g, gi) = (g.as_chunks::<W>().0, gi.as_chunks::<W>().0);
    let (h, hi) = (h.as_chunks::<W>().0, hi.as_chunks::<W>().0);
    let [a, b, c, d] = legs::<W>(re, length);
    let [ai, bi, ci, di] = legs::<W>(im, length);
    for at in 0..length / W {
        let some = [[a[at], ai[at]], [b[at], bi[at]], [c[at], ci[at]], [d[at], di[at]]];
        let factors = [[f[at], fi[at]], [g[at], gi[at]], [h[at], hi[at]]];
        let some = turned::<FINE, W>(&some, &factors);
        [[a[at], ai[at]], [b[at], bi[at]], [c[at], ci[at]], [d[at], di[at]]] = some;
    }
    for (leg, [x, y]) in alone.into_iter().enumerate() {
        (re[leg * length], im[leg * length]) = (x, y);
    }
}

/// The butterflies of some points in sequence, by the factors of three of them. Copies do not overlap, so the compiler makes vectors
/// of them.
#[inline(always)]
fn turned<const FINE: bool, const W: usize>(
    [a, b, c, d]: &[Points<W>; 4],
    [f, g, h]: &[Points<W>; 3],
) -> [Points<W>; 4] {
    let mut out = [[[0; W]; 2]; 4];
    for i in 0..W {
        let points = butterfly([
            [a[0][i] >> 1, a[1][i] >> 1],
            turn::<FINE>([b[0][i], b[1][i]], [f[0][i], f[1][i]]),
            turn::<FINE>([c[0][i], c[1][i]], [g[0][i], g[1][i]]),
            turn::<FINE>([d[0][i], d[1][i]], [h[0][i], h[1][i]]),
        ]);
        for (out, point) in out.iter_mut().zip(points) {
            [out[0][i], out[1][i]] = point;
        }
    }
    out
}

#[inline(always)]
fn legs<const W: usize>(parts: &mut [i32], length: usize) -> [&mut [[i32; W]]; 4] {
    let (low, high) = parts.split_at_mut(2 * length);
    let ((a, b), (c, d)) = (low.split_at_mut(length), high.split_at_mut(length));
    [a.as_chunks_mut().0, b.as_chunks_mut().0, c.as_chunks_mut().0, d.as_chunks_mut().0]
}

/// The radix-4 butterfly of points that are turned and halved.
#[inline(always)]
fn butterfly([a, b, c, d]: [Point; 4]) -> [Point; 4] {
    let (sum, difference) = (add(b, d), sub(b, d));
    let (even, odd) = (add(a, c), sub(a, c));
    [
        add(even, sum),
        [odd[0].wrapping_add(difference[1]), odd[1].wrapping_sub(difference[0])],
        sub(even, sum),
        [odd[0].wrapping_sub(difference[1]), odd[1].wrapping_add(difference[0])],
    ]
}

/// A point times its factor, halved.
#[inline(always)]
fn turn<const FINE: bool>([x, y]: Point, [f, g]: Point) -> Point {
    if FINE {
        let negative = ((i64::from(x) * i64::from(g)).wrapping_neg() >> 32) as i32;
        return [upper(x, f).wrapping_add(upper(y, g)), upper(y, f).wrapping_add(negative)];
    }
    [upper(x, f).wrapping_sub(upper(y, g)), upper(y, f).wrapping_add(upper(x, g))]
}

/// The upper word of a product, which is thereby floored.
#[inline(always)]
fn upper(x: i32, factor: i32) -> i32 {
    ((i64::from(x) * i64::from(factor)) >> 32) as i32
}

#[inline(always)]
fn add(x: Point, y: Point) -> Point {
    [x[0].wrapping_add(y[0]), x[1].wrapping_add(y[1])]
}

#[inline(always)]
fn sub(x: Point, y: Point) -> Point {
    [x[0].wrapping_sub(y[0]), x[1].wrapping_sub(y[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_dsp::acquire::sample::{Iq, Real};
    use picket_dsp::spectrum::Spectrum;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Records of noise, of codes at the rails alone and of one rail: seed 44. Both engines store the same points.
    fn compare<R: Record, const N: usize>() {
        let mut rng = ChaCha8Rng::seed_from_u64(44);
        let [mut own, mut other] = [(); 2].map(|()| Box::new(Spectrum::<R, N>::new()));
        let mut wide = Box::new(Spectrum::<R, N, Wide>::new());
        for codes in [Codes::signed::<12>(), Codes::unsigned::<12>(), Codes::signed::<16>()] {
            let (low, high) = codes.rails();
            for kind in 0..60 {
                let mut code = || match kind % 3 {
                    0 => rng.random_range(low..=high),
                    1 => [low, high][usize::from(rng.random::<bool>())],
                    _ => [low, high][kind / 3 % 2],
                };
                let samples = [(); N].map(|()| R::from_parts([code(), code()]));
                own.transform(&samples, codes);
                wide.transform(&samples, codes);
                other.transform_portably(&samples, codes);
                assert_eq!(own.exponent(), wide.exponent(), "{N} {codes:?}");
                assert!(own.points() == wide.points(), "{N} {codes:?} {kind}");
                assert!(other.points() == wide.points(), "{N} {codes:?} {kind}");
            }
        }
    }

    #[test]
    fn the_same_bits() {
        compare::<Real, 64>();
        compare::<Real, 128>();
        compare::<Real, 256>();
        compare::<Real, 512>();
        compare::<Real, 1024>();
        compare::<Real, 2048>();
        compare::<Real, 4096>();
        compare::<Iq, 64>();
        compare::<Iq, 512>();
        compare::<Iq, 1024>();
        compare::<Iq, 2048>();
        compare::<Iq, 4096>();
    }
}
