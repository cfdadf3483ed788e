//! The tone's envelope, and a line close to it, as nine numbers: orders 0 to 8 along Legendre functions of time.
//!
//! In units of noise, with the tone's phase u and its distance d from the reference of the columns, the envelope is
//!
//! ```text
//! c = u exp(pi d A) sum_i j^(order + quarter) x_i  +  b l(g)
//! ```
//!
//! where the first x is the tone's strength, any other a change of its amplitude, or by a quarter turn of its phase, with a normal prior;
//! `b l(g)` is the close line. Time, as it acts on these numbers, is `A c = t_(p+1) c_(p+1) - t_p c_(p-1)`: a real matrix, antisymmetric.

use super::columns::line_envelope;
use super::constants::{ORDERS, P, TIME};
use super::elimination::Elimination;
use super::factor::Factor;
use super::logarithm::Product;
use super::shape::{Orders, Reals, inner, turned};
use crate::math::scalar::{Scalar as _, larger};
use crate::tone::within;
use core::f32::consts::PI;
use heapless::Vec;
use num_complex::Complex;

/// The most terms: the tone, and changes of amplitude and phase of every order but the phase of order 1, which is the frequency.
const TERMS: usize = 2 * ORDERS;

/// The most unknowns: terms, a close line's three, and the tone's phase and frequency.
const UNKNOWNS: usize = TERMS + 5;

/// The tone's strength or a change of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The order along time.
    pub order: usize,
    /// 1 for a change of the phase, 0 for one of the amplitude.
    pub quarter: usize,
    /// The size, in deviations of the noise.
    pub size: f32,
    /// The precision of the size's prior.
    pub prior: f32,
}

/// A line within a bin of the tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Its distance from the reference, bins.
    pub at: f32,
    /// Its strength.
    pub value: Complex<f32>,
    /// The precisions of the priors of strength and place.
    pub priors: [f32; 2],
}

/// The envelope.
#[derive(Clone, Debug)]
pub struct Envelope {
    /// The tone's phase.
    pub unit: Complex<f32>,
    /// The tone's strength, and its changes.
    pub terms: Vec<Term, TERMS>,
    /// The tone's distance from the reference, bins.
    pub delta: f32,
    /// The close line.
    pub near: Option<Near>,
    /// The variance of the offset that order 1 of a wandering phase adds: this order is the frequency itself.
    pub hidden: f32,
    /// The variance of the tone's distance in bins squared, for noise of the ring's power.
    pub variance: f32,
    /// Half the logarithm of the information over the priors'.
    pub cost: f32,
}

/// The room of a step.
#[derive(Debug)]
pub struct Room {
    factor: Factor<UNKNOWNS>,
}

impl Room {
    /// Room for a step.
    pub const fn new() -> Self {
        Self { factor: Factor::new() }
    }
}

/// The precision that holds a frequency in place during a step, over the tone's energy.
const HELD: f32 = 1e12;

impl Envelope {
    /// A steady tone of this strength at the reference.
    pub fn new(value: Complex<f32>) -> Self {
        let size = larger(value.norm_sqr().root(), 1e-30);
        let mut terms = Vec::new();
        let _ = terms.push(Term { order: 0, quarter: 0, size, prior: 0.0 });
        let (unit, near) = (value * (1.0 / size), None);
        Self { unit, terms, delta: 0.0, near, hidden: 0.0, variance: 0.0, cost: 0.0 }
    }

    /// Whether the tone changes.
    pub fn changes(&self) -> bool {
        self.terms.len() > 1
    }

    /// Whether all orders matter: the tone changes, or a line is close.
    pub fn is_wide(&self) -> bool {
        self.changes() || self.near.is_some()
    }

    /// The tone's strength.
    pub fn size(&self) -> f32 {
        self.terms.first().map_or(0.0, |term| term.size)
    }

    /// The tone's strength and phase.
    pub fn value(&self) -> Complex<f32> {
        self.unit * self.size()
    }

    /// The terms' own energy under their priors.
    pub fn own(&self) -> f32 {
        let near = self.near.map_or(0.0, |near| near.priors[0] * near.value.norm_sqr());
        self.terms.iter().map(|term| term.prior * term.size * term.size).sum::<f32>() + near
    }

    /// The tone turned back to phase 0.
    #[inline(never)]
    fn tone(&self, tone: &mut Orders) {
        *tone = Orders::ZERO;
        let [first, ..] = &mut tone.re;
        *first = self.size();
        for term in self.terms.iter().skip(1) {
            let Complex { re, im } =
                turned(Complex::new(term.size, 0.0), term.order + term.quarter);
            if let Some((cell, other)) =
                tone.re.get_mut(term.order).zip(tone.im.get_mut(term.order))
            {
                *cell += re;
                *other += im;
            }
        }
        shift(&mut tone.re, self.delta);
        if self.changes() {
            shift(&mut tone.im, self.delta);
        }
    }

    /// The envelope.
    #[inline(never)]
    pub fn model(&self, model: &mut Orders) {
        self.tone(model);
        let Complex { re: cosine, im: sine } = self.unit;
        for (re, im) in model.re.iter_mut().zip(&mut model.im) {
            (*re, *im) = (*re * cosine - *im * sine, *re * sine + *im * cosine);
        }
        if let Some(near) = self.near {
            let line = line_envelope(near.at);
            for ((re, im), line) in model.re.iter_mut().zip(&mut model.im).zip(line) {
                *re += near.value.re * line;
                *im += near.value.im * line;
            }
        }
    }

    /// Fits the envelope to what is left of the bins, of which `O` orders count, by at most `most` Gauss-Newton steps. If `held`,
    /// the first step leaves the frequencies where they are.
    pub fn fit<const O: usize>(
        &mut self,
        from: &Elimination,
        room: &mut Room,
        most: usize,
        held: bool,
    ) {
        self.steps::<O>(from, room, most, held);
        // Of two close lines the stronger one is the tone.
        if let Some(near) = &mut self.near
            && self.terms.len() == 1
            && let Some(tone) = self.terms.first_mut()
            && near.value.norm_sqr() > tone.size * tone.size
        {
            let value = self.unit * tone.size;
            tone.size = near.value.norm_sqr().root();
            self.unit = near.value * (1.0 / tone.size);
            near.value = value;
            core::mem::swap(&mut near.at, &mut self.delta);
            self.steps::<O>(from, room, 1, false);
        }
    }

    fn steps<const O: usize>(
        &mut self,
        from: &Elimination,
        room: &mut Room,
        most: usize,
        held: bool,
    ) {
        for number in 0..most {
            let held = held && number == 0;
            let moved = self.step::<O>(from, room, held);
            if !held && moved < 4e-2 {
                break;
            }
        }
    }

    /// One step; returns the square of the largest move over its variance, of those that have an order or a place.
    #[inline(never)]
    fn step<const O: usize>(&mut self, from: &Elimination, room: &mut Room, held: bool) -> f32 {
        let (schur, factor) = (&from.schur, &mut room.factor);
        let changes = self.changes();
        // The tone, its derivative by its place, and both as the bins show them.
        let mut tone = Orders::ZERO;
        self.tone(&mut tone);
        let slope = Orders { re: derivative(&tone.re), im: derivative(&tone.im) };
        let (mut turn, mut moved) = (Orders::ZERO, Orders::ZERO);
        seen::<O>(schur, &tone.re, &mut turn.re);
        seen::<O>(schur, &slope.re, &mut moved.re);
        if changes {
            seen::<O>(schur, &tone.im, &mut turn.im);
            seen::<O>(schur, &slope.im, &mut moved.im);
        }
        // The residual in the tone's phase.
        let Complex { re: cosine, im: sine } = self.unit;
        let mut left = Orders::ZERO;
        let cells = left.re.iter_mut().zip(&mut left.im);
        for (((re, im), (x, y)), (a, b)) in cells
            .zip(from.seen.re.iter().zip(&from.seen.im))
            .zip(turn.re.iter().zip(&turn.im))
            .take(O)
        {
            (*re, *im) = (x * cosine + y * sine - a, y * cosine - x * sine - b);
        }
        let close = self.near.map(|near| Close::new::<O>(&near, self.unit, schur, &mut left));
        // The equations, row by row: the changes first, each an order by itself.
        factor.clear();
        let mut x = [0.0; UNKNOWNS];
        let mut values = x.iter_mut();
        let mut priors = Product::ONE;
        let terms = self.terms.get(1..).unwrap_or_default();
        for (number, term) in terms.iter().enumerate() {
            let Some(row) = schur.get(term.order) else { continue };
            let turns = term.order + term.quarter;
            let before = terms.iter().take(number).map(|other| {
                let entry = row.get(other.order).copied().unwrap_or(0.0);
                match (other.order + other.quarter + 4 * P - turns) & 3 {
                    0 => entry,
                    2 => -entry,
                    _ => 0.0,
                }
            });
            factor.push(row.get(term.order).copied().unwrap_or(0.0), term.prior, before);
            if term.prior > 0.0 {
                priors.times(term.prior);
            }
            if let Some(value) = values.next() {
                *value = of_term(term, &left, 0) - term.prior * term.size;
            }
        }
        let of_terms = |through, turns| terms.iter().map(move |term| of_term(term, through, turns));
        let size = self.size();
        let hold = if held { HELD * size * size } else { 0.0 };
        let over = 1.0 / larger(size, 1e-30);
        if let Some(close) = &close {
            let Close { value, priors: [strength, distance], line, place, .. } = close;
            let (line_seen, place_seen) = (&close.line_seen, &close.place_seen);
            let own = inner::<O>(line, line_seen);
            let of_line = |turns| {
                let line = Orders { re: *line_seen, im: [0.0; P] };
                terms.iter().map(move |term| of_term(term, &line, turns))
            };
            factor.push(own, *strength, of_line(0));
            factor.push(own, *strength, of_line(1).chain([0.0]));
            let both = inner::<O>(line, place_seen);
            let of_place = terms.iter().map(|term| {
                let at = place_seen.get(term.order).copied().unwrap_or(0.0);
                turned(value * at, 3 * (term.order + term.quarter)).re
            });
            let places = inner::<O>(place, place_seen) * value.norm_sqr();
            let prior = if held { hold } else { *distance };
            factor.push(places, prior, of_place.chain([value.re * both, value.im * both]));
            priors.times(*strength);
            priors.times(*strength);
            priors.times(*distance);
            let [a, b, c] = close.products::<O>(&left);
            let along = [a - strength * value.re, b - strength * value.im, c];
            values.by_ref().zip(along).for_each(|(value, along)| *value = along);
        }
        // The tone's strength with all its changes, a quarter turn on, which is its phase, and its place.
        let beside = |through, turns, by: f32| {
            let of_close = close.as_ref().map(|close| {
                let [a, b, c] = close.products::<O>(through);
                match turns {
                    0 => [a, b, c],
                    _ => [-b, a, close.turned::<O>(through)],
                }
            });
            let of_close = of_close.into_iter().flatten();
            of_terms(through, turns).chain(of_close).map(move |value| value * by)
        };
        let own = product::<O>(&tone, &turn) * over * over;
        factor.push(own, 0.0, beside(&turn, 0, over));
        factor.push(own, 0.0, beside(&turn, 1, over).chain([0.0]));
        let by_tone = [product::<O>(&tone, &moved) * over, across::<O>(&tone, &moved) * over];
        factor.push(product::<O>(&slope, &moved), hold, beside(&moved, 0, 1.0).chain(by_tone));
        let along = [
            product::<O>(&tone, &left) * over,
            across::<O>(&tone, &left) * over,
            product::<O>(&slope, &left),
        ];
        values.zip(along).for_each(|(value, along)| *value = along);
        // The solution, and the last pivot, which is the frequency's.
        factor.forward(&mut x);
        let (mut information, mut last) = (Product::ONE, 1.0);
        for root in factor.diagonal() {
            information.times(root * root);
            last = root;
        }
        self.variance = 1.0 / (last * last) + self.hidden;
        self.cost = 0.5 * (information.ln() - priors.ln());
        factor.backward(&mut x);
        self.take(x, close.map(|close| close.value))
    }

    /// Takes a step; `close` is the close line's strength in the tone's phase.
    #[inline(always)]
    fn take(&mut self, x: [f32; UNKNOWNS], close: Option<Complex<f32>>) -> f32 {
        let mut x = x.into_iter();
        let mut next = || x.next().unwrap_or(0.0);
        let mut most: f32 = 0.0;
        for term in self.terms.iter_mut().skip(1) {
            let step = next();
            term.size += step;
            most = larger(step * step, most);
        }
        if let Some((near, value)) = self.near.as_mut().zip(close) {
            let value = value + Complex::new(next(), next());
            let step = next();
            let limit = ((near.at - self.delta).abs() * 0.5).clamp(0.0, 0.3);
            near.value = value * self.unit;
            near.at += within(step, limit);
            most = larger(step * step * value.norm_sqr(), most);
        }
        // The changes grow with the tone.
        let over = 1.0 / larger(self.size(), 1e-30);
        let turn = Complex::new(1.0 + next() * over, next() * over);
        let grown = turn.norm_sqr().root();
        self.terms.iter_mut().for_each(|term| term.size *= grown);
        self.unit *= turn * (1.0 / larger(grown, 1e-30));
        let step = next();
        self.delta = (self.delta + step.clamp(-0.3, 0.3)).clamp(-1.2, 1.2);
        larger(step * step / larger(self.variance, 1e-30), most)
    }
}

/// The columns of a close line in the tone's phase: real, but for its strength.
struct Close {
    value: Complex<f32>,
    priors: [f32; 2],
    line: Reals,
    /// The change for one more bin.
    place: Reals,
    line_seen: Reals,
    place_seen: Reals,
}

impl Close {
    /// The columns; takes the line from the residual.
    #[inline(never)]
    fn new<const O: usize>(
        near: &Near,
        unit: Complex<f32>,
        schur: &[[f32; P]; P],
        left: &mut Orders,
    ) -> Self {
        let value = near.value * unit.conj();
        let line = line_envelope(near.at);
        let place = derivative(&line);
        let [mut line_seen, mut place_seen] = [[0.0; P]; 2];
        seen::<O>(schur, &line, &mut line_seen);
        seen::<O>(schur, &place, &mut place_seen);
        for ((re, im), line) in left.re.iter_mut().zip(&mut left.im).zip(&line_seen).take(O) {
            *re -= value.re * line;
            *im -= value.im * line;
        }
        Self { value, priors: near.priors, line, place, line_seen, place_seen }
    }

    /// The products of strength, of its quarter turn, and of place with what the bins see.
    fn products<const O: usize>(&self, through: &Orders) -> [f32; 3] {
        let [a, b] = [&through.re, &through.im].map(|part| inner::<O>(&self.line, part));
        let [c, d] = [&through.re, &through.im].map(|part| inner::<O>(&self.place, part));
        [a, b, self.value.re * c + self.value.im * d]
    }

    /// The product of place with a quarter turn of what the bins see.
    fn turned<const O: usize>(&self, through: &Orders) -> f32 {
        let [c, d] = [&through.re, &through.im].map(|part| inner::<O>(&self.place, part));
        self.value.im * c - self.value.re * d
    }
}

/// The product of a term with what the bins see of a column, or of its quarter turns.
#[inline(always)]
fn of_term(term: &Term, through: &Orders, turns: usize) -> f32 {
    let (re, im) = (through.re.get(term.order), through.im.get(term.order));
    let order = Complex::new(re.copied().unwrap_or(0.0), im.copied().unwrap_or(0.0));
    turned(order, turns + 3 * (term.order + term.quarter)).re
}

/// The product of two columns as real vectors.
#[inline(always)]
fn product<const O: usize>(a: &Orders, b: &Orders) -> f32 {
    inner::<O>(&a.re, &b.re) + inner::<O>(&a.im, &b.im)
}

/// The product of a quarter turn of a column with another one.
#[inline(always)]
fn across<const O: usize>(a: &Orders, b: &Orders) -> f32 {
    inner::<O>(&a.re, &b.im) - inner::<O>(&a.im, &b.re)
}

/// What the bins see of a column.
#[inline(always)]
fn seen<const O: usize>(schur: &[[f32; P]; P], column: &Reals, through: &mut Reals) {
    for (through, row) in through.iter_mut().zip(schur).take(O) {
        *through = inner::<O>(row, column);
    }
}

/// `pi A c`: the change for one more bin.
#[inline(always)]
fn derivative(c: &Reals) -> Reals {
    let [t1, t2, t3, t4, t5, t6, t7, t8] = TIME.map(|time| PI * time);
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = *c;
    [
        t1 * c1,
        t2 * c2 - t1 * c0,
        t3 * c3 - t2 * c1,
        t4 * c4 - t3 * c2,
        t5 * c5 - t4 * c3,
        t6 * c6 - t5 * c4,
        t7 * c7 - t6 * c5,
        t8 * c8 - t7 * c6,
        -t8 * c7,
    ]
}

/// `exp(pi d A) c` by its power series.
#[inline(always)]
fn shift(c: &mut Reals, d: f32) {
    /// The reciprocals of 1 to 8: for half a bin the next term has a ten-thousandth.
    const OVER: [f32; 8] = [1.0, 0.5, 1.0 / 3.0, 0.25, 0.2, 1.0 / 6.0, 1.0 / 7.0, 0.125];
    /// A smaller share changes nothing.
    const NOTHING: f32 = 3e-8;
    let mut term = *c;
    let mut share = 1.0;
    for over in OVER {
        let by = d * over;
        term = derivative(&term).map(|next| next * by);
        c.iter_mut().zip(term).for_each(|(c, term)| *c += term);
        share *= PI * by;
        if share.abs() < NOTHING {
            break;
        }
    }
}
