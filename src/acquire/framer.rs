//! Records from a stream: chunks of any length in, records of `N` samples out, each with a stamp. No record crosses a gap.
//!
//! An ADC driver delivers chunks of its own length; a file delivers the result of one read. If the DMA controller itself can fill one
//! record after the other, [`crate::acquire::frontend`] needs no copy.

use super::format::{Format, Word};
use super::frontend::Timing;
use super::sample::{Record, Segment, Stamp};

/// Turns chunks into records. Its memory is a record of `N` samples.
///
/// ```
/// use picket_dsp::{Framer, Format, Real};
///
/// let mut framer = Framer::<Real, 64>::new(Format::unsigned::<12>());
/// let mut records = 0;
/// for chunk in [0u16; 1000].chunks(77) {
///     framer.push(chunk, |stamp, samples: &[i16; 64]| {
///         assert_eq!(stamp.sequence, records);
///         assert_eq!(stamp.clock, 64 * u64::from(records));
///         records += 1;
///     });
/// }
/// assert_eq!(records, 1000 / 64);
/// ```
///
/// A record starts at a multiple of the hop on the sample clock, also after a gap. So the segments of a chirp keep their order across a
/// loss, if the length of the loss is stated exactly.
#[derive(Clone)]
pub struct Framer<R: Record, const N: usize> {
    format: Format,
    /// The hop, and the segments of a chirp.
    timing: Timing,
    samples: [R::Sample; N],
    /// Samples of the record so far.
    filled: usize,
    /// Samples from the start of a segment to its record.
    guard: u32,
    /// Samples to skip before the next record.
    skip: u64,
    /// The first word of an I/Q pair, if its second word is in the next chunk.
    half: Option<i16>,
    /// The sample clock at the next sample.
    clock: u64,
    /// The number of the next record.
    number: u64,
    gap: bool,
}

/// Without its samples.
impl<R: Record, const N: usize> core::fmt::Debug for Framer<R, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Framer")
            .field("format", &self.format)
            .field("timing", &self.timing)
            .field("clock", &self.clock)
            .field("filled", &self.filled)
            .finish_non_exhaustive()
    }
}

impl<R: Record, const N: usize> Framer<R, N> {
    /// A framer of records that follow each other without a pause, of words in this format.
    pub fn new(format: Format) -> Self {
        Self {
            format,
            timing: Timing::continuous(N as u32),
            samples: [R::Sample::default(); N],
            filled: 0,
            guard: 0,
            skip: 0,
            half: None,
            clock: 0,
            number: 0,
            gap: false,
        }
    }

    /// Sets the hop: samples from the start of one record to the start of the next, at least 1.
    /// Below `N` records overlap; above `N` samples are dropped between them, such as a chirp's
    /// guard.
    #[must_use]
    pub const fn with_hop(mut self, hop: u32) -> Self {
        self.timing.period = if hop == 0 { 1 } else { hop };
        self
    }

    /// Sets the samples that are dropped before each record, from the stream's start on: a chirp's guard, [`Chirp::guard_s`] by the
    /// rate. The stream starts with the first ramp, and a record's stamp has the clock of its ramp's first sample.
    ///
    /// [`Chirp::guard_s`]: crate::solve::equations::Chirp::guard_s
    ///
    /// ```
    /// use picket_dsp::{Framer, Format, Real};
    ///
    /// // Ramps of 100 samples; the first 20 come before the echo.
    /// let mut framer = Framer::<Real, 64>::new(Format::signed::<16>()).with_hop(100).with_guard(20);
    /// let stream: Vec<i16> = (0..300).collect();
    /// framer.push(&stream, |stamp, samples| {
    ///     assert_eq!(u64::from(samples[0] as u16), stamp.clock + 20);
    /// });
    /// ```
    #[must_use]
    pub const fn with_guard(mut self, samples: u32) -> Self {
        self.guard = samples;
        self.skip = samples as u64;
        self
    }

    /// Sets the segments of a chirp, in order, one record each.
    #[must_use]
    pub const fn with_segments(mut self, segments: &'static [Segment]) -> Self {
        self.timing.segments = segments;
        self
    }

    /// Takes a chunk of the converter's words, I and Q in turn. Calls `each` with every record that
    /// the chunk completes, and its stamp.
    ///
    /// Cost: some ten instructions a word for the format. Overlapping records also copy the
    /// overlap.
    pub fn push<W: Word>(&mut self, words: &[W], mut each: impl FnMut(&Stamp, &[R::Sample; N])) {
        for &word in words {
            let code = self.format.code(word);
            let parts = match (R::IQ, self.half.take()) {
                (false, _) => [code, 0],
                (true, Some(first)) => [first, code],
                (true, None) => {
                    self.half = Some(code);
                    continue;
                }
            };
            self.sample(R::from_parts(parts), &mut each);
        }
    }

    /// Takes a chunk like [`Framer::push`], whose first sample has the number `clock`, counted by a timer or a driver. Missing samples
    /// before it count as [`Framer::lost`]. Samples that were already taken are skipped.
    pub fn push_at<W: Word>(
        &mut self,
        clock: u64,
        words: &[W],
        each: impl FnMut(&Stamp, &[R::Sample; N]),
    ) {
        let mut words = words;
        // The chunk begins with a whole sample: half a sample from before comes again, or is missing.
        self.half = None;
        if clock > self.clock {
            self.lost(clock - self.clock);
        } else if clock < self.clock {
            let parts = if R::IQ { 2 } else { 1 };
            let known = usize::try_from(self.clock - clock).unwrap_or(usize::MAX);
            words = words.get(known.saturating_mul(parts)..).unwrap_or(&[]);
        }
        self.push(words, each);
    }

    /// Reports that `samples` samples are missing before the next chunk. The record in progress is dropped, and the next one is marked as
    /// following a gap. If the number is unknown, pass 1: the sample clock and the segments of a chirp are then wrong from there on.
    pub fn lost(&mut self, samples: u64) {
        let hop = u64::from(self.timing.period).max(1);
        self.clock = self.clock.saturating_add(samples.max(1));
        let guard = u64::from(self.guard);
        self.number = self.clock.saturating_sub(guard).div_ceil(hop);
        let next = self.number.saturating_mul(hop).saturating_add(guard);
        self.skip = next.saturating_sub(self.clock);
        (self.filled, self.half, self.gap) = (0, None, true);
    }

    fn sample(&mut self, sample: R::Sample, each: &mut impl FnMut(&Stamp, &[R::Sample; N])) {
        self.clock = self.clock.saturating_add(1);
        if self.skip > 0 {
            self.skip -= 1;
            return;
        }
        if let Some(place) = self.samples.get_mut(self.filled) {
            *place = sample;
            self.filled += 1;
        }
        if self.filled < N {
            return;
        }
        each(&self.timing.stamp(self.number, self.gap), &self.samples);
        self.number = self.number.wrapping_add(1);
        self.gap = false;
        let hop = self.timing.period as usize;
        self.filled = N.saturating_sub(hop);
        self.skip = hop.saturating_sub(N) as u64;
        for index in 0..self.filled {
            let kept = self.samples.get(index.saturating_add(hop)).copied();
            if let Some((place, kept)) = self.samples.get_mut(index).zip(kept) {
                *place = kept;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::sample::{Iq, Real};
    use std::vec::Vec;

    const N: usize = 64;

    /// A stream: each sample is its own number.
    fn stream(length: usize) -> Vec<i16> {
        (0..length as i16).collect()
    }

    /// Stamps and first samples of the records that chunks of this length make.
    fn records(framer: &mut Framer<Real, N>, stream: &[i16], chunk: usize) -> Vec<(Stamp, i16)> {
        let mut seen = Vec::new();
        for chunk in stream.chunks(chunk) {
            framer.push(chunk, |stamp, samples| {
                let follow = samples.windows(2).all(|pair| pair[1] == pair[0] + 1);
                assert!(follow, "a record mixes what does not belong together");
                seen.push((*stamp, samples[0]));
            });
        }
        seen
    }

    #[test]
    fn chunks_of_any_length_make_the_same_records() {
        for hop in [1, 17, 63, 64, 65, 200] {
            let new = || Framer::<Real, N>::new(Format::signed::<16>()).with_hop(hop);
            let whole = records(&mut new(), &stream(2000), 2000);
            assert_eq!(whole.len(), (2000 - N) / hop as usize + 1, "hop {hop}");
            for (number, (stamp, first)) in whole.iter().enumerate() {
                assert_eq!(stamp.sequence as usize, number);
                assert_eq!(stamp.clock as usize, number * hop as usize);
                assert_eq!(*first as u64, stamp.clock);
                assert!(!stamp.gap);
            }
            for chunk in [1, 3, 63, 64, 65, 333] {
                assert_eq!(records(&mut new(), &stream(2000), chunk), whole, "hop {hop}, {chunk}");
            }
        }
    }

    #[test]
    fn no_record_crosses_a_gap_and_every_stamp_stays_right() {
        for hop in [32, 64, 100] {
            for (before, missing) in [(10, 1), (64, 64), (100, 37), (130, 1000), (0, 5)] {
                let new = || Framer::<Real, N>::new(Format::signed::<16>()).with_hop(hop);
                let all = stream(3000);
                let mut told = new();
                let mut seen = records(&mut told, &all[..before], 7);
                told.lost(missing as u64);
                seen.extend(records(&mut told, &all[before + missing..], 7));
                // The gap, found by the count; some samples come twice.
                let mut found = new();
                let mut again = Vec::new();
                let mut note = |stamp: &Stamp, samples: &[i16; N]| again.push((*stamp, samples[0]));
                found.push_at(0, &all[..before], &mut note);
                found.push_at(0, &all[..before / 2], &mut note);
                found.push_at((before + missing) as u64, &all[before + missing..2000], &mut note);
                found.push_at(1990, &all[1990..], &mut note);
                assert_eq!(seen, again, "hop {hop}, {missing} missing after {before}");
                for (stamp, first) in &seen {
                    assert_eq!(stamp.clock, u64::from(stamp.sequence) * u64::from(hop));
                    assert_eq!(*first as u64, stamp.clock);
                }
                let gaps: Vec<u64> = seen.iter().filter(|s| s.0.gap).map(|s| s.0.clock).collect();
                assert_eq!(gaps.len(), 1);
                assert!(gaps[0] >= (before + missing) as u64);
                assert!(gaps[0] < (before + missing) as u64 + u64::from(hop));
            }
        }
    }

    /// With a guard, also behind a loss, a record holds the samples from the guard on, and its stamp is that of the ramp's start.
    #[test]
    fn a_guard_is_dropped_before_every_record() {
        for (guard, hop) in [(0, 64), (20, 84), (20, 100), (36, 100), (10, 32)] {
            let whole = stream(3000);
            for lost in [0, 1, 15, 85, 300] {
                let new = Framer::<Real, N>::new(Format::signed::<16>());
                let mut framer = new.with_hop(hop).with_guard(guard);
                let mut seen = records(&mut framer, &whole[..500], 7);
                let before = seen.len();
                if lost > 0 {
                    framer.lost(lost);
                }
                seen.extend(records(&mut framer, &whole[500 + lost as usize..], 7));
                assert!(before > 3 && seen.len() > before + 20);
                for (number, (stamp, first)) in seen.iter().enumerate() {
                    let begun = i64::from(stamp.sequence) * i64::from(hop);
                    assert_eq!(i64::try_from(stamp.clock), Ok(begun));
                    assert_eq!(i64::from(*first), begun + i64::from(guard), "{guard} {hop} {lost}");
                    assert_eq!(stamp.gap, lost > 0 && number == before);
                }
            }
        }
    }

    #[test]
    fn pairs_are_kept_together_over_chunks_and_gaps() {
        let words: Vec<i16> = (0..1000).collect();
        for chunk in [1, 3, 7, 128] {
            let mut framer = Framer::<Iq, N>::new(Format::signed::<16>());
            let mut seen = 0;
            for chunk in words.chunks(chunk) {
                framer.push(chunk, |stamp, samples| {
                    assert_eq!(samples[0], [stamp.clock as i16 * 2, stamp.clock as i16 * 2 + 1]);
                    seen += 1;
                });
            }
            assert_eq!(seen, 500 / N);
        }
        // The gap also drops the first word of a pair.
        let mut framer = Framer::<Iq, N>::new(Format::signed::<16>());
        framer.push(&words[..21], |_, _| panic!("too short"));
        framer.lost(2);
        let mut first = None;
        framer.push(&words[24..], |stamp, samples| {
            first.get_or_insert((stamp.clock, samples[0]));
        });
        assert_eq!(first, Some((64, [128, 129])));
    }

    /// A driver that counts samples lost the second word of a pair, and delivers the pair again.
    #[test]
    fn half_a_pair_does_not_exchange_the_parts_of_those_after_it() {
        let words: Vec<i16> = (0..4 * N as i16).collect();
        for (cut, clock) in [(21, 10), (21, 12), (21, 7), (20, 10)] {
            let mut framer = Framer::<Iq, N>::new(Format::signed::<16>());
            let mut each = |_: &Stamp, samples: &[[i16; 2]; N]| {
                assert!(samples.iter().all(|[i, q]| i % 2 == 0 && *q == i + 1), "{samples:?}");
            };
            framer.push(&words[..cut], &mut each);
            framer.push_at(clock, &words[2 * clock as usize..], &mut each);
            assert_eq!(framer.clock, 2 * N as u64);
        }
    }

    #[test]
    fn segments_keep_their_order_over_a_loss() {
        const TRAPEZOID: &[Segment] = &[Segment::Up, Segment::Flat, Segment::Down];
        let format = Format::signed::<16>();
        let mut framer = Framer::<Real, N>::new(format).with_hop(80).with_segments(TRAPEZOID);
        let mut seen = records(&mut framer, &stream(200), 50);
        framer.lost(300);
        seen.extend(records(&mut framer, &stream(1000)[500..], 50));
        for (stamp, _) in &seen {
            assert_eq!(stamp.segment, TRAPEZOID[stamp.clock as usize / 80 % 3]);
        }
        assert!(seen.len() > 6);
    }
}
