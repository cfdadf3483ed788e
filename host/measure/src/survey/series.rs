//! Lines at multiples of one frequency: of a string, a reed, a motor. Those of a stiff string are stretched:
//! `f_k = k f sqrt((1 + B k^2) / (1 + B))` with the fundamental f (Fletcher, doi:10.1121/1.1908920).

/// Partials at least, the lowest of them at most, and the highest that are sought.
const LEAST: usize = 3;
const LOWEST: u32 = 3;
const HIGHEST: u32 = 32;
/// Peaks that may be a fundamental's multiple, and up to which one.
const SEEDS: usize = 8;
const OVER: u32 = 12;
/// Stretches that are tried.
const STRETCHES: [f64; 5] = [0.0, 1e-5, 4e-5, 1e-4, 2e-4];
/// Peaks that lie so far below the strongest one, in dB, do not count.
const BELOW_DB: f64 = 45.0;
/// Most peaks within this many dB must be partials.
const STRONG_DB: f64 = 28.0;
/// A missing multiple costs this share of a present one.
const MISSING: f64 = 0.35;

/// A partial: its order, frequency and power in dB.
type Partial = (u32, f64, f64);

/// A series of partials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The fundamental.
    pub hz: f64,
    /// The highest order that was seen.
    pub highest: u32,
    /// The partials' share of all peaks' power, and the fundamental's.
    pub share: f64,
    /// The fundamental's share of the partials' power.
    pub first: f64,
}

/// The series that explains peaks of these frequencies and powers in dB best; `bin_hz` is the resolution.
pub fn series(peaks: &[(f64, f64)], bin_hz: f64) -> Option<Series> {
    let mut peaks: Vec<(f64, f64)> =
        peaks.iter().map(|&(hz, power)| (hz.abs(), power)).filter(|peak| peak.0 > 0.0).collect();
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    let strongest = peaks.first()?.1;
    peaks.retain(|peak| peak.1 > strongest - BELOW_DB);
    peaks.truncate(2 * HIGHEST as usize);
    let mut best: Option<(f64, Vec<Partial>)> = None;
    for &(seed, _) in peaks.iter().take(SEEDS) {
        for over in 1..=OVER {
            for stretch in STRETCHES {
                let partials = partials(&peaks, seed, over, stretch, bin_hz);
                let Some(score) = score(&partials, strongest) else { continue };
                if best.as_ref().is_none_or(|best| score > best.0) {
                    best = Some((score, partials));
                }
            }
        }
    }
    let (_, partials) = best?;
    // Of what is strong most has to be a partial, and some partials are: sidebands of one line are none.
    let strong = |db: f64| db > strongest - STRONG_DB;
    let own = partials.iter().filter(|it| strong(it.2)).count();
    let all = peaks.iter().filter(|it| strong(it.1)).count();
    if own < LEAST || 10 * own < 6 * all {
        return None;
    }
    let power = |db: f64| 10f64.powf(db / 10.0);
    let all: f64 = peaks.iter().map(|peak| power(peak.1)).sum();
    let own: f64 = partials.iter().map(|it| power(it.2)).sum();
    let first: f64 = partials.iter().filter(|it| it.0 == 1).map(|it| power(it.2)).sum();
    let highest = partials.iter().map(|it| it.0).max()?;
    Some(Series { hz: fundamental(&partials)?, highest, share: own / all, first: first / own })
}

/// How many times as high as the fundamental.
fn ratio(order: u32, stretch: f64) -> f64 {
    let k = f64::from(order);
    k * ((1.0 + stretch * k * k) / (1.0 + stretch)).sqrt()
}

/// Orders, frequencies and powers of the peaks at multiples, where `seed` is the one of this order.
fn partials(peaks: &[(f64, f64)], seed: f64, over: u32, stretch: f64, bin_hz: f64) -> Vec<Partial> {
    let first = seed / ratio(over, stretch);
    // Neighbours are distinguished, and none is two orders.
    if first < 8.0 * bin_hz {
        return Vec::new();
    }
    let at = |order: u32| {
        let expected = first * ratio(order, stretch);
        let near = (2.0 * bin_hz).max(0.004 * expected).min(0.2 * first);
        let close = peaks.iter().filter(|peak| (peak.0 - expected).abs() < near);
        let strongest = close.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((order, strongest.0, strongest.1))
    };
    (1..=HIGHEST).filter_map(at).collect()
}

/// How much partials explain, less what is missing among them.
fn score(partials: &[Partial], strongest: f64) -> Option<f64> {
    let lowest = partials.first()?.0;
    if partials.len() < LEAST || lowest > LOWEST {
        return None;
    }
    let weight = |it: &Partial| it.2 - strongest + BELOW_DB;
    let sum: f64 = partials.iter().map(weight).sum();
    let mean = sum / partials.len() as f64;
    let missing = partials.last()?.0 as usize - partials.len();
    Some(sum - MISSING * mean * missing as f64)
}

/// The fundamental: `(f_k / k)^2` is a line over `k^2`, each of an error of `1 / k`.
fn fundamental(partials: &[Partial]) -> Option<f64> {
    let mut sums = [0.0; 5];
    for &(order, hz, _) in partials {
        let k = f64::from(order);
        let (x, y, weight) = (k * k, (hz / k).powi(2), k * k);
        for (sum, more) in sums.iter_mut().zip([1.0, x, y, x * x, x * y]) {
            *sum += weight * more;
        }
    }
    let [n, x, y, xx, xy] = sums;
    let slope = ((n * xy - x * y) / (n * xx - x * x)).max(0.0);
    let square = (y - slope * x) / n + slope;
    (square > 0.0).then(|| square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_and_others() {
        let of = |partials: &[(u32, f64)], first: f64, stretch: f64| {
            let peak = |&(order, db): &(u32, f64)| (first * ratio(order, stretch), db);
            series(&partials.iter().map(peak).collect::<Vec<_>>(), 1.35)
        };
        for stretch in [0.0, 3e-5, 1e-4] {
            let string =
                [(1, -18.0), (2, -3.0), (3, 0.0), (4, -2.0), (5, -7.0), (7, -20.0), (9, -30.0)];
            let found = of(&string, 82.4, stretch).unwrap();
            assert!(
                (found.hz / 82.4 - 1.0).abs() < 3e-4 && found.first < 0.1,
                "{stretch}: {found:?}"
            );
        }
        let odd = of(&[(1, 0.0), (3, -9.5), (5, -14.0), (7, -17.0)], 333.3, 0.0).unwrap();
        assert!((odd.hz - 333.3).abs() < 0.1 && odd.first > 0.8, "{odd:?}");
        // The comb of a radar's ramps is none, and two tones are none.
        assert_eq!(of(&[(14, -3.0), (15, 0.0), (16, -4.0), (17, -9.0)], 200.0, 0.0), None);
        assert_eq!(of(&[(1, 0.0), (2, -3.0)], 700.0, 0.0), None);
    }
}
