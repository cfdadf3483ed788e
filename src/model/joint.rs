//! The joint fit of a tone's envelope and of lines beside it.
//!
//! Lines have columns in the bins, and are eliminated; the envelope is fitted to the nine numbers that remain. Both steps are repeated while
//! lines move, or while the mirror image, which is subtracted from the bins, changes by more than noise.

use super::columns::{Envelopes, envelopes, image, images};
use super::constants::{CHANCE, LINES, NEAR, ODD, P, PEAK, WIDTH};
use super::elimination::{Elimination, Sizes, products};
use super::envelope::{Envelope, Near, Room};
use super::far::Reach;
use super::shape::{NOTHING, Orders, Shape, ZERO, along, energy, inner};
use super::window::Window;
use crate::chance;
use crate::math::scalar::larger;
use crate::tone::within;
use core::f32::consts::PI;
use heapless::Vec;
use num_complex::Complex;

/// A line with columns of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Far {
    /// Its distance from the peak, bins.
    pub at: f32,
    /// Its strength.
    pub value: Complex<f32>,
    /// Where it is. The leakage of a line outside the window includes that of its mirror image.
    pub reach: Reach,
}

/// The orders that are computed for a steady tone: enough to show that it is not steady.
const FEW: usize = 4;

/// An envelope farther from its reference than this, in bins, gets a new reference.
const AWAY: f32 = 0.12;

/// The nine numbers do not describe the whole of a line farther away than this, in bins.
const BEYOND: f32 = 1.1;

/// A tone and lines in a window.
#[derive(Debug)]
pub struct Joint<'a> {
    window: &'a Window,
    /// The factor of bins that makes the noise of their parts 1.
    scale: f32,
    /// The reference of the envelope, bins from the peak.
    reference: f32,
    /// The tone's envelope.
    pub envelope: Envelope,
    /// Lines beyond the envelope's reach.
    pub lines: Vec<Far, LINES>,
    /// The most lines that may join: a pair in each round.
    most: usize,
    /// What the lines leave of the bins.
    pub from: Elimination,
    images: Envelopes,
    /// The envelope by its orders.
    model: Orders,
    room: Room,
    /// Whether all orders have their products, or a [`FEW`].
    wide: bool,
    /// The bins without images.
    bins: Shape,
    /// The residual, by bins, and along the orders, whitened.
    pub left: Shape,
    /// The residual along the orders, whitened.
    pub rest: Orders,
    /// The residual's energy, with that of the changes' sizes under their priors.
    pub energy: f32,
    /// The residual's degrees of freedom.
    pub free: f32,
}

impl<'a> Joint<'a> {
    /// Room for a fit around a tone at `reference` bins from the window's peak.
    #[inline(always)]
    pub fn new(window: &'a Window, scale: f32, reference: f32, rounds: usize) -> Self {
        Self {
            window,
            scale,
            reference,
            envelope: Envelope::new(ZERO),
            lines: Vec::new(),
            most: 2 * rounds,
            from: Elimination::new(),
            images: [[0.0; P]; WIDTH],
            model: Orders::ZERO,
            room: Room::new(),
            wide: false,
            bins: NOTHING,
            left: NOTHING,
            rest: Orders::ZERO,
            energy: 0.0,
            free: 1.0,
        }
    }

    /// Lines that may still join.
    pub fn vacant(&self) -> usize {
        self.most.saturating_sub(self.lines.len())
    }

    /// The tone's distance from the peak, bins.
    pub fn offset(&self) -> f32 {
        self.reference + self.envelope.delta
    }

    /// The tone alone, fitted to the window.
    pub fn begin(&mut self) {
        self.refer();
        let (mut sum, mut square) = (ZERO, 0.0);
        for ([order, ..], bin) in self.from.envelopes.iter().zip(&self.window.bins) {
            sum += bin * *order;
            square += order * order;
        }
        self.envelope = Envelope::new(sum * (self.scale / larger(square, 1e-9)));
        self.envelope.model(&mut self.model);
        self.settle(3, 3, true);
    }

    /// Columns around the reference.
    fn refer(&mut self) {
        envelopes(self.window, self.reference, &mut self.from.envelopes);
        self.from.refer();
        if !self.window.iq {
            images(self.window, self.reference, &mut self.images);
        }
    }

    /// The lines' columns and what they leave, of as many orders as count.
    fn eliminate(&mut self) {
        let strength = larger(self.envelope.value().norm_sqr(), 1e-30);
        let offset = self.offset();
        let mut priors = [[0.0; 2]; LINES];
        for ((line, columns), priors) in
            self.lines.iter().zip(&mut self.from.lines).zip(&mut priors)
        {
            let apart = line.at - offset;
            let power = larger(line.value.norm_sqr(), 1.0);
            *priors = [1.0 / strength, 4.0 / (apart * apart * power)];
            if line.reach == Reach::Slow {
                super::columns::slow(self.window, columns);
                *priors = [1.0 / strength; 2];
            } else {
                super::columns::line(self.window, line.at, columns);
            }
        }
        self.from.eliminate(priors.get(..self.lines.len()).unwrap_or_default());
        self.wide = self.envelope.is_wide();
        if self.wide { self.from.reduce::<P>() } else { self.from.reduce::<FEW>() }
    }

    /// Computes the products of all orders, and the residual along them.
    #[inline(never)]
    pub fn widen(&mut self) {
        if !self.wide {
            self.wide = true;
            self.from.reduce::<P>();
            self.from.see::<P>(&self.bins);
        }
        self.from.whiten::<P>();
        self.rest = products::<P>(&self.from.envelopes, &self.left);
        self.from.whitened(&mut self.rest);
    }

    /// Computes the bins without the mirror images of the tone and the lines.
    #[inline(never)]
    fn take_images(&mut self) {
        let Self { window, scale, bins, images, model, .. } = self;
        for (bin, seen) in bins.iter_mut().zip(&window.bins) {
            *bin = seen * *scale;
        }
        if window.iq {
            return;
        }
        // A steady tone near its reference has three orders.
        if self.envelope.is_wide() {
            take_image::<P>(bins, images, model);
        } else {
            take_image::<3>(bins, images, model);
        }
        let mut column = [0.0; WIDTH];
        for line in self.lines.iter().filter(|line| line.reach == Reach::Inside) {
            image(window, line.at, &mut column);
            for (bin, image) in bins.iter_mut().zip(&column) {
                *bin -= line.value.conj() * *image;
            }
        }
    }

    /// One fit of the envelope to what is left of the bins, by at most `most` steps.
    pub fn fit(&mut self, most: usize, held: bool) {
        let Self { envelope, from, room, .. } = self;
        if self.wide {
            envelope.fit::<P>(from, room, most, held);
        } else {
            envelope.fit::<FEW>(from, room, most, held);
        }
    }

    /// The energy that an envelope leaves of the nine numbers, with that of its sizes under their priors.
    pub fn energy_of(&self, envelope: &Envelope) -> f32 {
        let (mut left, mut model) = (self.from.seen, Orders::ZERO);
        envelope.model(&mut model);
        for (left, model) in [(&mut left.re, &model.re), (&mut left.im, &model.im)] {
            for (left, row) in left.iter_mut().zip(&self.from.schur) {
                *left -= inner::<P>(row, model);
            }
        }
        self.from.whitened(&mut left) + envelope.own()
    }

    /// The strengths of the lines beside the envelope, and a step of their places; returns the sizes, and whether a step matters.
    fn step(&mut self) -> (Sizes, bool) {
        self.envelope.model(&mut self.model);
        let model = &self.model;
        let sizes =
            if self.wide { self.from.sizes::<P>(model) } else { self.from.sizes::<FEW>(model) };
        let offset = self.offset();
        let [re, im] = &sizes;
        let cells = re.as_chunks::<2>().0.iter().zip(im.as_chunks::<2>().0);
        let mut matters = false;
        for (line, (&[a, c], &[b, d])) in self.lines.iter_mut().zip(cells) {
            let (value, slope) = (Complex::new(a, b), Complex::new(c, d));
            let strength = larger(value.norm_sqr(), 1e-30);
            let step = along(slope, value) / strength;
            matters |= line.reach != Reach::Slow && step * step * strength > 0.04;
            let apart = (line.at - offset).abs();
            let at = match line.reach {
                Reach::Slow => line.at,
                // Halfway between bins the two columns are two shapes of leakage.
                Reach::Outside => libm::floorf(line.at + within(step, 0.25 * apart)) + 0.5,
                _ => line.at + within(step, (0.5 * apart).clamp(0.0, 0.3)),
            };
            *line = Far { at, value, ..*line };
        }
        (sizes, matters)
    }

    /// The joint fit to its end, in at most `most` passes over the bins, with `steps` of the envelope in each. If `fresh`, lines or orders
    /// are new.
    #[inline(never)]
    pub fn settle(&mut self, most: usize, steps: usize, mut fresh: bool) {
        let mut sizes = [[0.0; 2 * LINES]; 2];
        for pass in 1..=most {
            if fresh {
                self.eliminate();
            }
            fresh = !self.lines.is_empty();
            self.take_images();
            if self.wide {
                self.from.see::<P>(&self.bins);
            } else {
                self.from.see::<FEW>(&self.bins);
            }
            let before = self.model;
            self.fit(steps, false);
            let moves;
            (sizes, moves) = self.step();
            if pass == most {
                break;
            }
            let from_end = self.window.from_end().max(1) as f32;
            let moved: f32 =
                before.iter().zip(self.model.iter()).map(|(a, b)| (a - b).norm_sqr()).sum();
            let image = !self.window.iq && moved > 0.1 * PI * PI * from_end * from_end;
            if self.envelope.delta.abs() > AWAY {
                self.reference += self.envelope.delta;
                if let Some(near) = &mut self.envelope.near {
                    near.at -= self.envelope.delta;
                }
                self.envelope.delta = 0.0;
                self.envelope.model(&mut self.model);
                self.refer();
                fresh = true;
            } else if !(moves || image) {
                break;
            }
        }
        self.leave(&sizes);
    }

    /// The envelope alone has changed, by a fit to the nine numbers.
    pub fn resettle(&mut self, converted: bool) {
        if self.window.iq && !converted && self.envelope.delta.abs() < AWAY {
            let (sizes, _) = self.step();
            self.leave(&sizes);
        } else {
            self.envelope.model(&mut self.model);
            self.settle(3, 2, converted);
        }
    }

    /// The residual.
    fn leave(&mut self, sizes: &Sizes) {
        self.from.left(&self.model, sizes, &self.bins, &mut self.left);
        let changes = self.envelope.terms.iter().skip(1);
        let own: f32 = changes.clone().map(|term| term.prior * term.size * term.size).sum();
        let free = changes.filter(|term| term.prior == 0.0).count();
        self.energy = energy(&self.left) + own;
        // Each line has a strength and a place.
        let fitted = 3 + 3 * self.lines.len() + free;
        self.free = larger(self.window.numbers() - fitted as f32, 1.0);
    }

    /// A close line beyond the reach of the nine numbers gets columns of its own; returns whether there was one.
    pub fn convert(&mut self) -> bool {
        match self.envelope.near {
            Some(Near { at, value, .. })
                if (at - self.envelope.delta).abs() > BEYOND && !self.lines.is_full() =>
            {
                self.envelope.near = None;
                let _ =
                    self.lines.push(Far { at: self.reference + at, value, reach: Reach::Inside });
                true
            }
            _ => false,
        }
    }

    /// Whether the residual is more than noise: its energy, its largest bin, or its first directions.
    #[inline(never)]
    pub fn is_odd(&mut self, ring: f32) -> bool {
        let top = self.left.iter().map(Complex::norm_sqr).fold(0.0, larger);
        if self.energy > self.free * chance::ratio(ODD, self.free, ring)
            || top > 2.0 * chance::ratio(PEAK + 0.4, 2.0, ring)
        {
            return true;
        }
        self.from.whiten::<FEW>();
        let mut along = products::<FEW>(&self.from.envelopes, &self.left);
        self.from.whitened(&mut along);
        let five: f32 = along.iter().take(FEW).skip(1).map(|order| order.norm_sqr()).sum();
        five > 5.0 * chance::ratio(ODD, 5.0, ring)
    }

    /// Whether the residual is larger than the ring's noise would leave it.
    pub fn is_loud(&self, ring: f32) -> bool {
        self.energy > self.free * chance::ratio(CHANCE, self.free, ring)
    }

    /// Whether the residual is larger near the tone than noise would leave there, given the residual away from it.
    pub fn is_lumpy(&self) -> bool {
        /// The inner bins on each side of the peak.
        const INNER: i32 = 4;
        /// The fewest degrees of freedom of each part.
        const FEWEST: f32 = 4.0;
        let (mut inner, mut outer) = ([0.0; 2], [0.0; 2]);
        for ((i, left), used) in Window::places().zip(&self.left).zip(&self.window.used) {
            let [energy, numbers] = if i.abs() <= INNER { &mut inner } else { &mut outer };
            *energy += left.norm_sqr();
            *numbers += 2.0 * used;
        }
        let free = (inner[1] - (self.window.numbers() - self.free)).max(FEWEST);
        let others = outer[1].max(FEWEST);
        inner[0] * others > outer[0] * free * chance::ratio(CHANCE, free, others)
    }

    /// Whether another line is so near that it looks like a change of the tone.
    pub fn is_near(&self) -> bool {
        let offset = self.offset();
        self.envelope.near.is_some()
            || self.lines.iter().any(|line| (line.at - offset).abs() < NEAR)
    }
}

/// Subtracts the mirror image of the first `O` orders of an envelope from bins.
#[inline(always)]
fn take_image<const O: usize>(bins: &mut Shape, images: &Envelopes, model: &Orders) {
    for (bin, row) in bins.iter_mut().zip(images) {
        for ((image, re), im) in row.iter().zip(&model.re).zip(&model.im).take(O) {
            bin.re -= re * image;
            bin.im += im * image;
        }
    }
}
