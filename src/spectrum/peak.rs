//! The strongest line, found in one pass over the power view.
//!
//! Source: Ye et al. 2022, section 2.3: three registers hold a bin and its two neighbours while the spectrum streams by. This
//! implementation adds band limits, defined ties and edges, and the noise floor.
//!
//! [`Search`] defines the search. [`find`] finds the same bin in a spectrum, in fewer operations. How it does so is in `scan`, `pairs` and
//! each engine's `search`: skip them unless you change them.

pub use super::band::{Band, SKIRT};
use super::fft::integer::Point;
use super::layout::Layout;
use super::scan::{Scan, Skirt};
use super::view::View;
use crate::math::products::power;
use core::mem::MaybeUninit;

/// Bins of the peak and its skirt.
const AROUND: usize = 2 * SKIRT as usize + 1;

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// The strongest bin of the band; of equals the lowest.
    pub bin: i32,
    /// The powers of the left neighbour, the peak and the right neighbour, in stored units. A neighbour outside the band reads 0; the
    /// spectrum still holds its power.
    pub power: [u64; 3],
    /// The sum of the powers of the band's other bins, without the peak's skirt. The skirt goes round the circle of an I/Q record. Of a real
    /// record [`find`] mostly leaves out the skirt's partners as well, the bins N/2-k.
    pub floor: u64,
    /// The number of bins in `floor`.
    pub floor_bins: u32,
}

/// The streaming detector, and the definition of the search. Push the powers of the band in ascending order, then call
/// [`Search::finish`].
///
/// State: three registers for the peak, a window of [`SKIRT`] powers for the floor. Cost per bin:
/// one comparison, three additions.
#[derive(Clone, Debug)]
pub struct Search {
    band: Band,
    next: i32,
    peak: i32,
    registers: [u64; 3],
    total: u64,
    recent: [u64; SKIRT as usize],
    recent_sum: u64,
    skirt: u64,
}

impl Search {
    /// A search of `band`.
    pub const fn new(band: Band) -> Self {
        Self {
            band,
            next: band.low,
            peak: band.low,
            registers: [0; 3],
            total: 0,
            recent: [0; SKIRT as usize],
            recent_sum: 0,
            skirt: 0,
        }
    }

    /// Takes the power of the next bin. The powers of one record sum to less than 2^63 (Parseval's
    /// theorem with the FFT's growth bound), so no sum overflows.
    pub fn push(&mut self, power: u64) {
        let bin = self.next;
        self.next = self.next.wrapping_add(1);
        let power = if bin == self.band.offset { 0 } else { power };
        let previous = self.newest(bin.wrapping_sub(1));
        if bin == self.band.low || power > self.registers[1] {
            self.peak = bin;
            self.registers = [previous, power, 0];
            self.skirt = self.recent_sum.wrapping_add(power);
        } else {
            let distance = bin.wrapping_sub(self.peak);
            if distance == 1 {
                self.registers[2] = power;
            }
            if distance <= SKIRT {
                self.skirt = self.skirt.wrapping_add(power);
            }
        }
        self.total = self.total.wrapping_add(power);
        self.remember(bin, power);
    }

    fn slot(bin: i32) -> usize {
        bin.checked_rem_euclid(SKIRT).unwrap_or(0) as usize
    }

    fn newest(&self, bin: i32) -> u64 {
        self.recent.get(Self::slot(bin)).copied().unwrap_or(0)
    }

    fn remember(&mut self, bin: i32, power: u64) {
        if let Some(oldest) = self.recent.get_mut(Self::slot(bin)) {
            self.recent_sum = self.recent_sum.wrapping_sub(*oldest).wrapping_add(power);
            *oldest = power;
        }
    }

    /// The peak; `None` if no bin was pushed or all powers are 0.
    pub fn finish(&self) -> Option<Peak> {
        if self.registers[1] == 0 {
            return None;
        }
        let last = self.next.wrapping_sub(1);
        let skirt = Band::new(
            self.band.low.max(self.peak.wrapping_sub(SKIRT)),
            last.min(self.peak.wrapping_add(SKIRT)),
        );
        let seen = Band { high: last, ..self.band };
        // The bin of an offset has no power, and is not a bin of the floor.
        let offset = seen.has_offset() && self.band.offset.abs_diff(self.peak) > SKIRT as u32;
        let floor_bins = seen.width().saturating_sub(skirt.width());
        Some(Peak {
            bin: self.peak,
            power: self.registers,
            floor: self.total.wrapping_sub(self.skirt),
            floor_bins: floor_bins.saturating_sub(offset.into()),
        })
    }
}

/// Searches `band` of a spectrum in fewer operations than [`Search`], with its bin and its powers. The floor alone may differ.
///
/// Where a band of a real record holds bins k and N/2-k, both go through [`super::scan`]: 13 instructions for the two on a core with the
/// DSP extension. The floor then lacks the partners N/2-k of the peak's skirt, too, unless it would lose half of its bins so.
pub fn find(view: &View, band: Band) -> Option<Peak> {
    // The offset of an I/Q record is often its strongest bin. With Helium all bins have a faster search than a part of them.
    let shifted = view.layout.iq && band.has_offset();
    let mut found = if shifted && !cfg!(mve) { both_sides(view, band) } else { view.search(band) };
    if shifted && cfg!(mve) && found.bin == band.offset {
        found = both_sides(view, band);
    }
    if band.has_offset() {
        return beside_offset(view, band, found);
    }
    // A search that knows the skirt needs only the peak and its neighbours.
    if let Some(skirt) = found.skirt {
        let mut place = MaybeUninit::<[Point; 3]>::uninit();
        let three = view.window(found.bin.wrapping_sub(1), &mut place);
        return from_scan(&found, band, skirt, three.first_chunk()?);
    }
    with_skirt(view, band, &found)
}

/// The scan of a band's bins on both sides of the offset, whose power counts in the total.
#[inline(never)] // a band without one has a shorter way
fn both_sides(view: &View, band: Band) -> Scan {
    let Band { low, high, offset } = band;
    let sides = [(low, offset.wrapping_sub(1)), (offset.wrapping_add(1), high)];
    let [below, above] = sides.map(|(low, high)| view.search(Band { low, high, offset }));
    let found = below.then(above);
    Scan { total: found.total.wrapping_add(view.power(offset)), ..found }
}

/// The peak of a band with an offset in it; the offset is neither the peak nor its neighbour nor a part of the floor.
#[inline(never)] // a band without one has a shorter way
fn beside_offset(view: &View, band: Band, mut found: Scan) -> Option<Peak> {
    let Band { low, high, offset } = band;
    if found.bin == offset && found.power > 0 {
        // Seldom: the offset was the strongest, of a real record.
        found = Scan::from(low as usize);
        for k in (low..=high).filter(|&k| k != offset) {
            found.see(k as usize, view.power(k));
        }
        found.total = found.total.wrapping_add(view.power(offset));
    }
    let mut peak = with_skirt(view, band, &found)?;
    let [before, _, after] = &mut peak.power;
    match offset.wrapping_sub(peak.bin) {
        -1 => *before = 0,
        1 => *after = 0,
        _ if view.layout.apart(offset, peak.bin) > SKIRT => {
            peak.floor = peak.floor.saturating_sub(view.power(offset));
            peak.floor_bins = peak.floor_bins.saturating_sub(1);
        }
        _ => {}
    }
    Some(peak)
}

/// The peak, with the skirt taken from its bins if the search does not know it. This is a function of its own, because the search's loop
/// needs all registers.
fn with_skirt(view: &View, band: Band, found: &Scan) -> Option<Peak> {
    let mut place = MaybeUninit::<[Point; AROUND]>::uninit();
    let around = view.window(found.bin.wrapping_sub(SKIRT), &mut place);
    let skirt = found.skirt.unwrap_or_else(|| skirt(view.layout, found.bin, band, around));
    from_scan(found, band, skirt, middle(around)?)
}

/// The number of bin `k` in a band, if the band holds the bin: an I/Q record's bins have a number on each turn of the circle.
fn named(layout: &Layout, band: Band, k: i32) -> Option<i32> {
    let held = |name: &i32| (band.low..=band.high).contains(name);
    // A band that leaves out at least a skirt has no skirt round the ends of its numbers.
    if !layout.iq || band.width().wrapping_add(SKIRT as u32) <= layout.n as u32 {
        return Some(k).filter(held);
    }
    let turn = layout.n as i32;
    [k, k.wrapping_add(turn), k.wrapping_sub(turn)].into_iter().find(held)
}

/// [`find`] by its definition in portable code. Tests compare kernels with it.
pub fn find_portably(view: &View, band: Band) -> Option<Peak> {
    let found = view.search_portably(band);
    if band.has_offset() {
        return beside_offset(view, band, found);
    }
    let around: [Point; AROUND] = core::array::from_fn(|index| {
        let x = view.bin(found.bin.wrapping_sub(SKIRT).wrapping_add(index as i32));
        [x.re, x.im]
    });
    let skirt = found.skirt.unwrap_or_else(|| skirt(view.layout, found.bin, band, &around));
    from_scan(&found, band, skirt, middle(&around)?)
}

/// The peak and its neighbours among the bins around it.
fn middle(around: &[Point]) -> Option<&[Point; 3]> {
    around.get(SKIRT as usize - 1..)?.first_chunk()
}

/// The peak that a scan over a band has found, given its skirt, itself and its neighbours.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
fn from_scan(found: &Scan, band: Band, skirt: Skirt, three: &[Point; 3]) -> Option<Peak> {
    if found.power == 0 {
        return None;
    }
    let [before, peak, after] = *three;
    Some(Peak {
        bin: found.bin,
        power: [
            if found.bin > band.low { power(before) } else { 0 },
            power(peak),
            if found.bin < band.high { power(after) } else { 0 },
        ],
        floor: found.total.saturating_sub(skirt.power),
        floor_bins: band.width().saturating_sub(skirt.points),
    })
}

/// The skirt of a peak, from the bins around it that the band holds. In an I/Q record they may be on both sides of the numbers' ends.
fn skirt(layout: &Layout, bin: i32, band: Band, around: &[Point]) -> Skirt {
    let (first, last) = (bin.wrapping_sub(SKIRT), bin.wrapping_add(SKIRT));
    let sum = |sum: u64, bin: &Point| sum.wrapping_add(power(*bin));
    if band.low <= first && last <= band.high {
        return Skirt { power: around.iter().fold(0, sum), points: around.len() as u32 };
    }
    let held = around.iter().zip(first..).filter(|&(_, k)| named(layout, band, k).is_some());
    held.fold(Skirt { power: 0, points: 0 }, |skirt, (bin, _)| Skirt {
        power: sum(skirt.power, bin),
        points: skirt.points.wrapping_add(1),
    })
}

/// Searches `gate`, a part of a band, with the noise floor of the whole band.
///
/// Neither the skirt of the band's strongest line nor the skirt of the found peak counts as floor. The strongest line's leakage further out
/// does: D bins away, a bin holds up to a quarter of the peak's power over D^2.
pub fn within(view: &View, band: Band, gate: Band) -> Option<Peak> {
    let whole = find(view, band)?;
    let mut bin = gate.low;
    let mut most = 0;
    for k in gate.low..=gate.high {
        let power = view.power(k);
        if power > most && k != band.offset {
            (bin, most) = (k, power);
        }
    }
    if most == 0 {
        return None;
    }
    let (mut floor, mut floor_bins) = (whole.floor, whole.floor_bins);
    for k in bin.wrapping_sub(SKIRT)..=bin.wrapping_add(SKIRT) {
        let Some(k) = named(view.layout, band, k) else {
            continue;
        };
        if view.layout.apart(k, whole.bin) > SKIRT && k != band.offset {
            floor = floor.wrapping_sub(view.power(k));
            floor_bins = floor_bins.saturating_sub(1);
        }
    }
    let apart = u64::from(view.layout.apart(bin, whole.bin).unsigned_abs());
    if apart > SKIRT as u64 {
        let leakage = whole.power[1] / (4 * apart * apart).max(1);
        floor = floor.saturating_add(leakage.saturating_mul(u64::from(floor_bins)));
    }
    let power = |k: i32| if k == band.offset { 0 } else { view.power(k) };
    let neighbours = [bin.wrapping_sub(1), bin.wrapping_add(1)].map(power);
    Some(Peak { bin, power: [neighbours[0], most, neighbours[1]], floor, floor_bins })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acquire::codes::Codes;
    use crate::acquire::sample::{Iq, Real, Record};
    use crate::spectrum::Spectrum;
    use crate::spectrum::engine::{Engine, I32};

    fn search(band: Band, powers: &[u64]) -> Option<Peak> {
        let mut search = Search::new(band);
        powers.iter().for_each(|&p| search.push(p));
        search.finish()
    }

    #[test]
    fn registers_hold_the_peak_and_its_neighbours() {
        let peak = search(Band::new(3, 7), &[1, 5, 9, 4, 2]).unwrap();
        assert_eq!((peak.bin, peak.power), (5, [5, 9, 4]));
        assert_eq!((peak.floor, peak.floor_bins), (0, 0));
    }

    #[test]
    fn the_lowest_of_equal_bins_wins() {
        assert_eq!(search(Band::new(1, 4), &[2, 7, 7, 7]).unwrap().bin, 2);
    }

    #[test]
    fn edges_read_zero_outside_the_band() {
        let first = search(Band::new(1, 3), &[9, 2, 1]).unwrap();
        assert_eq!((first.bin, first.power), (1, [0, 9, 2]));
        let last = search(Band::new(1, 3), &[1, 2, 9]).unwrap();
        assert_eq!((last.bin, last.power), (3, [2, 9, 0]));
    }

    #[test]
    fn an_empty_or_silent_band_has_no_peak() {
        assert_eq!(search(Band::new(1, 0), &[]), None);
        assert_eq!(search(Band::new(1, 3), &[0; 3]), None);
    }

    #[test]
    fn the_floor_leaves_the_skirt_out_wherever_the_peak_is() {
        for width in 1..60usize {
            for at in 0..width {
                let mut powers = std::vec![1u64; width];
                for (k, p) in powers.iter_mut().enumerate() {
                    // The powers rise towards the peak, so the candidate moves at every push.
                    *p = 1000 - at.abs_diff(k) as u64;
                }
                let band = Band::new(5, 5 + width as i32 - 1);
                let peak = search(band, &powers).unwrap();
                let outside = |k: &usize| at.abs_diff(*k) > SKIRT as usize;
                let expected: u64 = (0..width).filter(outside).map(|k| powers[k]).sum();
                assert_eq!(peak.bin, 5 + at as i32);
                assert_eq!(peak.floor, expected, "width {width}, peak at {at}");
                assert_eq!(peak.floor_bins as usize, (0..width).filter(outside).count());
            }
        }
    }

    /// A line and a stronger offset, in bands that hold the offset at their ends and inside.
    fn an_offset_is_no_peak<R: Record, E: Engine>(sample: impl Fn([i16; 2]) -> R::Sample) {
        const N: usize = 256;
        let turn = |k: i32, n: usize| {
            let angle = core::f64::consts::TAU * f64::from(k) * n as f64 / N as f64;
            [libm::cos(angle), libm::sin(angle)]
        };
        let mut spectrum = Spectrum::<R, N, E>::new();
        for (offset, line) in [(0, 40), (0, 1), (20, 90), (30, 31), (60, 12)] {
            let samples = core::array::from_fn(|n| {
                let [a, b] = [turn(offset, n), turn(line, n)];
                sample([0, 1].map(|i| (1500.0 * a[i] + 200.0 * b[i]) as i16))
            });
            spectrum.transform(&samples, Codes::signed::<12>());
            for low in [-100, 0, 1, 12, 20] {
                for high in [60, 100, 127] {
                    let band = Band { low, high, offset };
                    let mut search = Search::new(band);
                    (low..=high).for_each(|k| search.push(spectrum.power(k)));
                    let (expected, found) = (search.finish(), find(&spectrum.view(), band));
                    assert_eq!(found, find_portably(&spectrum.view(), band), "{band:?}");
                    let place = |peak: Option<Peak>| peak.map(|peak| (peak.bin, peak.power));
                    assert_eq!(place(found), place(expected), "{band:?}");
                }
            }
        }
    }

    #[test]
    fn an_offset_stronger_than_the_line_is_no_peak() {
        an_offset_is_no_peak::<Iq, I32>(|parts| parts);
        an_offset_is_no_peak::<Real, I32>(|[re, _]| re);
    }
}
