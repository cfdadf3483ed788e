//! The bins of a spectrum of any kind, length and engine. What reads bins here is compiled once for all of them.

use super::band::{Band, SKIRT};
use super::fft;
#[cfg(feature = "microfft")]
use super::fft::float;
use super::fft::integer::{self, Point};
use super::layout::Layout;
use super::pairs::{self, Pairs};
use super::scan::{self, Scan};
use crate::math::products;
use core::convert::identity;
use core::mem::MaybeUninit;
use core::ops::{Range, RangeInclusive};
use num_complex::Complex;

/// An offset stands out of its neighbours if it has this many times the power of both. Noise does so in one record of 81: one over the
/// square of this number plus 1.
pub const STANDS_OUT: u64 = 8;

/// Bins on each side of a peak that are not part of the floor.
pub(super) const REACH: usize = SKIRT as usize;

/// The stored points of a transform, by engine.
#[derive(Clone, Copy, Debug)]
pub enum Points<'a> {
    /// Of [`I32`](super::engine::I32).
    Integer(&'a [Point]),
    /// Of `F32`.
    #[cfg(feature = "microfft")]
    Float(&'a [float::Float]),
}

/// A spectrum to read: a bin's value times `2^exponent` is in codes.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The record's length and kind.
    pub layout: &'static Layout,
    /// [`Spectrum::exponent`](super::Spectrum::exponent).
    pub exponent: i32,
    /// The points.
    pub points: Points<'a>,
}

impl View<'_> {
    /// The error in bins that the engine and the fit's `f32` add to the frequency of a strong line, rms over frequencies and phases.
    /// Rounded factors cause most of it: their errors follow the line, and do not show as noise around it. Measured against an exact
    /// transform: host-tests, `engine_error`.
    pub fn error(&self) -> f32 {
        match self.points {
            Points::Integer(_) => integer::error(self.layout.n, self.layout.iq),
            #[cfg(feature = "microfft")]
            Points::Float(_) => float::ERROR,
        }
    }

    /// Bin `k` in stored units, for any `k`: an I/Q spectrum wraps round, a real one is mirrored
    /// and conjugated at both ends, `X[-k] = conj X[k]`.
    #[inline]
    pub fn bin(&self, k: i32) -> Complex<i32> {
        let [re, im] = self.point(k);
        Complex::new(re, im)
    }

    #[inline]
    fn point(&self, k: i32) -> Point {
        let (k, mirrored) = self.held(k);
        let bin = self.stored(k);
        if mirrored { conjugate(bin) } else { bin }
    }

    /// The stored bin for bin `k`, and whether bin `k` is its mirror image.
    #[inline(always)]
    fn held(&self, k: i32) -> (usize, bool) {
        let Layout { n, iq, .. } = *self.layout;
        let k = self.layout.wrapped(k);
        let mirrored = !iq && k > n / 2;
        (if mirrored { n - k } else { k }, mirrored)
    }

    /// Bin k: k is 0..N of an I/Q record, 0..=N/2 of a real one. The powers of all bins sum to less than 2^63.
    #[inline]
    fn stored(&self, k: usize) -> Point {
        let Layout { iq, splits, sines, .. } = *self.layout;
        match self.points {
            Points::Integer(points) if iq => points.get(k).copied().unwrap_or([0; 2]),
            Points::Integer(points) if !sines.is_empty() => integer::split_finely(points, sines, k),
            Points::Integer(points) => integer::split(points, splits, k),
            #[cfg(feature = "microfft")]
            Points::Float(points) => float::bin(points, iq, k),
        }
    }

    /// `|X[k]|^2` in stored units, with the bins numbered as in [`View::bin`].
    #[inline]
    pub fn power(&self, k: i32) -> u64 {
        products::power(self.point(k))
    }

    /// The strongest bin of a band, of equals the lowest, and the total power of the band's bins.
    pub(crate) fn search(&self, band: Band) -> Scan {
        let bins = self.range(band);
        if let Some(scan) = bins.and_then(|bins| self.scan(bins)) {
            return scan;
        }
        // One window after the other.
        let mut places = [MaybeUninit::uninit(); 17];
        let (mut scan, mut next) = (Scan::from(band.low as usize), band.low);
        let mut left = band.width() as usize;
        while left > 0 {
            let count = left.min(places.len());
            let window = self.fill(next, places.get_mut(..count).unwrap_or_default());
            scan = scan.then(scan::over(window, next as usize, identity));
            next = next.wrapping_add(count as i32);
            left -= count;
        }
        scan
    }

    /// The strongest of these bins, of equals the lowest, and the power of all (see `pairs`); `None` if there is no faster way than one bin
    /// after the other.
    fn scan(&self, bins: RangeInclusive<usize>) -> Option<Scan> {
        let Layout { iq, splits, .. } = *self.layout;
        #[cfg(feature = "microfft")]
        if let Points::Float(points) = self.points {
            let first = *bins.start();
            // All bins are stored unchanged, except bins 0 and N/2 of a real record.
            let stored = iq || first > 0;
            return Some(scan::over(points.get(bins).filter(|_| stored)?, first, float::whole));
        }
        #[cfg_attr(not(feature = "microfft"), expect(irrefutable_let_patterns))]
        let Points::Integer(points) = self.points else { return None };
        #[cfg(mve)]
        if iq && bins == (0..=self.layout.n - 1) {
            return Some(fft::kernel_mve::scan_iq(points));
        }
        if iq {
            let first = *bins.start();
            return Some(scan::over(points.get(bins)?, first, identity));
        }
        let pairs = Pairs::new(points.len(), &bins)?;
        #[cfg(mve)]
        let (add, alone) =
            (fft::kernel_mve::powers, |bins| fft::kernel_mve::alone(points, splits, bins));
        #[cfg(all(dsp, not(mve)))]
        let (add, alone) = (scan::power_sum, |bins| fft::kernel_dsp::alone(points, splits, bins));
        #[cfg(not(dsp))]
        let (add, alone) = (scan::power_sum, |bins| alone_portably(points, splits, bins));
        let scan = pairs.outermost().map(|last| fft::scan(points, splits, last));
        Some(pairs.beside(pairs.with_alone(scan, alone), REACH, points, add, alone))
    }

    /// [`View::search`] by its definition in portable code.
    pub(crate) fn search_portably(&self, band: Band) -> Scan {
        let bins = self.range(band);
        if let Some(scan) = bins.and_then(|bins| self.scan_portably(bins)) {
            return scan;
        }
        (band.low..=band.high).fold(Scan::from(band.low as usize), |mut scan, k| {
            scan.see(k as usize, self.power(k));
            scan
        })
    }

    /// [`View::scan`] by its definition in portable code.
    fn scan_portably(&self, bins: RangeInclusive<usize>) -> Option<Scan> {
        let Layout { iq, splits, .. } = *self.layout;
        #[cfg_attr(not(feature = "microfft"), expect(irrefutable_let_patterns))]
        let Points::Integer(points) = self.points else { return None };
        if iq {
            let first = *bins.start();
            return Some(scan::over(points.get(bins)?, first, identity));
        }
        let pairs = Pairs::new(points.len(), &bins)?;
        let alone = |bins| alone_portably(points, splits, bins);
        let scan = pairs.outermost().map(|last| scan::real(points, splits, last));
        Some(pairs.beside(pairs.with_alone(scan, alone), REACH, points, scan::power_sum, alone))
    }

    /// The range of a band's bins, if the band neither wraps round nor is mirrored.
    fn range(&self, band: Band) -> Option<RangeInclusive<usize>> {
        let (low, high) = (usize::try_from(band.low).ok()?, usize::try_from(band.high).ok()?);
        (low <= high && high < self.layout.bins()).then_some(low..=high)
    }

    /// The K bins from `first` on, numbered as in [`View::bin`]. On a core with the DSP extension a window costs a fifth of K single
    /// bins.
    #[inline]
    pub fn window<'b, const K: usize>(
        &self,
        first: i32,
        place: &'b mut MaybeUninit<[Point; K]>,
    ) -> &'b [Point] {
        self.fill(first, place.as_mut())
    }

    /// Whether each of `count` bins from `first` on has less than this power. An engine that splits no bins for the answer may return false
    /// without need.
    #[inline]
    pub(crate) fn is_below(&self, power: u64, first: i32, count: usize) -> bool {
        let n = self.layout.n as i32;
        let first = if self.layout.iq && first >= n { first - n } else { first };
        usize::try_from(first).is_ok_and(|first| self.all_below(first..first + count, power))
    }

    #[inline]
    fn all_below(&self, bins: Range<usize>, power: u64) -> bool {
        #[cfg_attr(not(feature = "microfft"), expect(irrefutable_let_patterns))]
        let Points::Integer(points) = self.points else {
            return bins.into_iter().all(|k| products::power(self.stored(k)) < power);
        };
        let (end, length) = (bins.end, points.len().wrapping_add(1));
        let mirrored = length.wrapping_sub(end)..length.wrapping_sub(bins.start);
        let Some(own) = points.get(bins) else { return false };
        if self.layout.iq {
            return own.iter().all(|&x| products::power(x) < power);
        }
        // A pair of points has the power of both of their bins.
        let (Some(others), least) = (points.get(mirrored), scan::worth(power)) else {
            return false;
        };
        let mut pairs = own.iter().zip(others.iter().rev());
        pairs.all(|(&x, &y)| products::plus_power(products::power(x), y) < least)
    }

    /// The bins of a real record from `first` on, one for each of `places`, all within 1..N/2.
    #[inline]
    fn row<'b>(&self, first: usize, places: &'b mut [MaybeUninit<Point>]) -> &'b [Point] {
        let Layout { splits, sines, .. } = *self.layout;
        match self.points {
            Points::Integer(points) if !sines.is_empty() => {
                fft::window_finely(points, sines, first, places)
            }
            Points::Integer(points) => fft::window(points, splits, first, places),
            #[cfg(feature = "microfft")]
            Points::Float(points) => {
                let points = points.get(first..).unwrap_or_default();
                integer::filled(places, points.iter().map(|&point| float::whole(point)))
            }
        }
    }

    /// The bins from `first` on, one for each of `places`.
    #[inline]
    pub(crate) fn fill<'b>(&self, first: i32, places: &'b mut [MaybeUninit<Point>]) -> &'b [Point] {
        let end = first.saturating_add(places.len() as i32);
        let Layout { n, iq, .. } = *self.layout;
        let half = n as i32 / 2;
        if !iq && first >= 1 && end <= half {
            return self.row(first as usize, places);
        }
        // A window with a row of bins between the ends; the mirrored bins are copies of these.
        let row = (first.max(1), end.min(half));
        if !iq && row.0 < row.1 {
            return self.fill_mirrored(first, row, places);
        }
        self.fill_circle(first, places)
    }

    /// The bins of an I/Q record from `first` on, round the circle; also those of a real record that a band never holds.
    #[inline]
    fn fill_circle<'b>(&self, first: i32, places: &'b mut [MaybeUninit<Point>]) -> &'b mut [Point] {
        if let (true, Points::Integer(points)) = (self.layout.iq, self.points) {
            let (mut next, last) = (self.layout.wrapped(first), self.layout.n - 1);
            let bins = core::iter::from_fn(|| {
                let bin = points.get(next).copied();
                next = (next + 1) & last;
                bin
            });
            return integer::filled(places, bins);
        }
        integer::filled(places, (0..).map(|index| self.point(first.wrapping_add(index))))
    }

    /// The bins of a real record from `first` on: a row of bins between DC and Nyquist, `from` one `to` another, and copies for the
    /// mirrored bins beyond.
    #[inline(never)] // a window beside no end has a shorter way
    fn fill_mirrored<'b>(
        &self,
        first: i32,
        (from, to): (i32, i32),
        places: &'b mut [MaybeUninit<Point>],
    ) -> &'b [Point] {
        let middle = from.wrapping_sub(first) as usize..to.wrapping_sub(first) as usize;
        let n = self.layout.n as i32;
        let other = |place: usize, row: &[Point]| {
            let k = first.wrapping_add(place as i32) & (n - 1);
            let mirrored = k > n / 2;
            let held = if mirrored { n - k } else { k };
            match row.get(held.wrapping_sub(from) as usize) {
                Some(&bin) if mirrored => conjugate(bin),
                Some(&bin) => bin,
                None => self.point(k),
            }
        };
        integer::filled_from_middle(places, middle, |places| self.row(from as usize, places), other)
            .unwrap_or_default()
    }

    /// The bins of a real record from `first` on; zero at DC and Nyquist and beyond them, where neither a fit nor its noise reads.
    #[inline]
    fn fill_inside<'b>(&self, first: i32, places: &'b mut [MaybeUninit<Point>]) -> &'b [Point] {
        let (half, end) = (self.layout.n as i32 / 2, first.saturating_add(places.len() as i32));
        if first >= 1 && end <= half {
            return self.row(first as usize, places);
        }
        self.fill_beside_ends(first, (first.max(1), end.min(half)), places)
    }

    /// The bins `from` one `to` another, and zeros below and above.
    #[inline(never)] // a window beside no end has a shorter way
    fn fill_beside_ends<'b>(
        &self,
        first: i32,
        (from, to): (i32, i32),
        places: &'b mut [MaybeUninit<Point>],
    ) -> &'b [Point] {
        let middle = from.wrapping_sub(first) as usize..to.wrapping_sub(first) as usize;
        integer::filled_from_middle(
            places,
            middle,
            |places| self.row(from as usize, places),
            |_, _| [0; 2],
        )
        .unwrap_or_default()
    }

    /// The bins from `first` on without the offset of an I/Q converter: bin 0 is the mean of its neighbours where it stands out of them. A
    /// tone's leakage is smooth enough, and the mean's second difference is 0.
    #[inline]
    pub(crate) fn fill_beside_offset<'b>(
        &self,
        first: i32,
        places: &'b mut [MaybeUninit<Point>],
    ) -> &'b [Point] {
        if !self.layout.iq {
            return self.fill_inside(first, places);
        }
        let bins = self.fill_circle(first, places);
        let zero = self.layout.wrapped(first.wrapping_neg());
        // A short record's window goes round the circle more than once.
        for offset in bins.iter_mut().skip(zero).step_by(self.layout.n.max(1)) {
            let beside = [self.point(-1), self.point(1)];
            let [below, above] = beside.map(products::power);
            if products::power(*offset) / STANDS_OUT > below.saturating_add(above) {
                let [[a, b], [c, d]] = beside;
                *offset = [(a >> 1).wrapping_add(c >> 1), (b >> 1).wrapping_add(d >> 1)];
            }
        }
        bins
    }
}

/// Scans a range of bins within 1..M, each split by itself.
#[cfg_attr(not(dsp), inline(never))] // its loops need all registers
fn alone_portably(points: &[Point], table: &[fft::twiddle::Packed], bins: Range<usize>) -> Scan {
    pairs::alone(bins, |first, places| integer::window(points, table, first, places))
}

/// The mirror image of a bin.
#[inline(always)]
fn conjugate([re, im]: Point) -> Point {
    [re, im.wrapping_neg()]
}
