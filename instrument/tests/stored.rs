//! Settings as flash keeps them: cut off, with flipped bits, of later programs, and with power that ends within a save.

use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::solve::uncertainty::Uncertainty;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use picket_instrument::Start;
use picket_instrument::crashes::Crashes;
use picket_instrument::storage::{self, PAGE, Page, Payload, Storage};
use picket_instrument::words::{payload, words};
use picket_wire::boot::Origin;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;

/// What is read, as bytes: a number that is none equals nothing.
fn read(bytes: &[u8]) -> Option<Vec<u8>> {
    Settings::from_bytes(bytes).ok().map(|(settings, n)| settings.to_bytes(n).to_vec())
}

/// Numbers as users set them, and any others.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -1e6..1e6f64, any::<f64>()]
}

prop_compose! {
    fn config()(
        rate_hz in number(),
        band_hz in proptest::option::of((number(), number())),
        method in select(Method::ALL),
        reach in select(vec![Reach::Four, Reach::Eight, Reach::Sixteen]),
        arithmetic in select(vec![Arithmetic::Float, Arithmetic::Fixed]),
        effort in select(Effort::ALL),
        false_alarm in number(),
        lengths in [number(), number(), number()],
        kind in 0..3u8,
        shape in select(vec![Shape::Trapezoid, Shape::Triangle, Shape::Sawtooth]),
        mixing in select(vec![Mixing::TxConjRx, Mixing::RxConjTx]),
        following in (number(), 0..=4u8, any::<u8>()),
        carrier in [number(), number()],
        (low, high) in (-32768..=-128i16, 127..=32767i16),
        [range_m, velocity_mps] in proptest::array::uniform2(proptest::option::of((number(), number()))),
    ) -> Config {
        let [wavelength_m, second, duration_s] = lengths;
        let scene = match kind {
            0 => Scene::Tone,
            1 => Scene::Doppler { wavelength_m, angle_rad: second, mixing },
            _ => Scene::Chirp(Chirp {
                shape,
                wavelength_m,
                bandwidth_hz: second,
                duration_s,
                mixing,
                sweep_curvature: carrier[0],
                ..Chirp::default()
            }),
        };
        let (rate, most, refresh) = following;
        Config {
            band_hz,
            method,
            reach,
            arithmetic,
            effort,
            false_alarm,
            scene,
            following: Following {
                rate_bins: rate as f32,
                most,
                refresh,
            },
            carrier: Carrier { linewidth_hz: carrier[0] as f32, envelope_hz: carrier[1] as f32 },
            range_m,
            velocity_mps,
            ..Config::new(rate_hz, Codes::between(low, high).unwrap())
        }
    }
}

prop_compose! {
    fn settings()(
        config in config(),
        words in any::<[u16; 6]>(),
        numbers in [number(), number(), number(), number(), number()],
        drive in 0..4u8,
        divider in any::<u8>(),
        mode in 0..4u8,
        counts in any::<[u32; 2]>(),
        ratio in proptest::option::of(1.05..100f32),
        bits in any::<[bool; 4]>(),
        effort in proptest::option::of(select(Effort::ALL)),
        tones in (1..=4u8, prop_oneof![Just(0), 2..=15u8]),
        known in proptest::option::of(any::<[f32; 6]>()),
    ) -> Settings {
        let [core_mhz, guard, report_every, slots, low, high] = words;
        let [reference_hz, start_hz, ppm, offset, slope] = numbers;
        let [iq, start, uncorrected, worst_case] = bits;
        Settings {
            core_mhz,
            iq,
            config,
            guard,
            drive: match drive {
                0 => Drive::Off,
                1 => Drive::Dac { low, high },
                2 => Drive::Adf4159 { reference_hz, start_hz, divider },
                _ => Drive::External,
            },
            mode: match mode {
                0 => Mode::Blocks,
                1 => Mode::Accumulate { blocks: counts[0], drift_bins: slope as f32 },
                2 => Mode::Bursts(Trigger { ratio, hold_off: counts[0], least: counts[1] }),
                _ => Mode::Frames { chirps: low, period_s: start.then_some(slope) },
            },
            report_every,
            most: tones.0,
            harmonics: tones.1,
            slots,
            start,
            uncorrected,
            worst_case,
            effort,
            calibration: Calibration {
                clock_ppm: ppm as f32,
                range_offset_m: offset as f32,
                range_slope: slope as f32,
            },
            uncertainty: known.map(
                |[clock_ppm, carrier_ppm, slope_ppm, angle_rad, range_offset_m, phase_rad]| {
                    Uncertainty {
                        clock_ppm,
                        carrier_ppm,
                        slope_ppm,
                        angle_rad,
                        range_offset_m,
                        phase_rad,
                    }
                },
            ),
        }
    }
}

fn block() -> impl Strategy<Value = usize> {
    select(vec![64, 256, 1024, 4096])
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(6),
        ..ProptestConfig::default()
    })]

    /// Settings come back from flash and from the memory between two programs, to the bit.
    #[test]
    fn all_settings_come_back(settings in settings(), n in block()) {
        let wire = settings.to_bytes(n).to_vec();
        prop_assert_eq!(read(&wire), Some(wire.clone()));
        let kept = payload(&settings, n);
        prop_assert!(kept.len().is_multiple_of(4));
        prop_assert_eq!(read(&kept), Some(wire.clone()));
        let between = words(&settings, n).map(u32::to_le_bytes);
        prop_assert_eq!(read(between.as_flattened()), Some(wire));
    }

    /// A later program's settings: what says nothing new is read, what says something new is not, and the settings before count.
    #[test]
    fn settings_of_later_programs_are_read_as_far_as_they_say_nothing_new(
        (old, new) in (settings(), settings()),
        more in proptest::collection::vec(any::<u8>(), 1..8),
    ) {
        let mut flash = Flash::default();
        storage::save(&mut flash, &payload(&old, 1024)).unwrap();
        let mut later = new.to_bytes(1024).to_vec();
        let end = 6 + usize::from(later[5]);
        prop_assume!(usize::from(later[5]) + more.len() < 256 && end + more.len() <= 4 * storage::ROOM);
        later.splice(end..end, more.iter().copied());
        later[5] += more.len() as u8;
        later.resize(later.len().next_multiple_of(4), 0);
        prop_assert_eq!(read(&later), None);
        storage::save(&mut flash, &Payload::from_slice(&later).unwrap()).unwrap();
        let start = Start::new::<1024>(None, &flash, Crashes::default());
        prop_assert_eq!(start.origin, Origin::Flash);
        prop_assert_eq!(Some(start.settings.to_bytes(1024).to_vec()), read(&payload(&old, 1024)));
        // With nothing before them the board waits, and says so.
        let mut flash = Flash::default();
        storage::save(&mut flash, &Payload::from_slice(&later).unwrap()).unwrap();
        let start = Start::new::<1024>(None, &flash, Crashes::default());
        prop_assert_eq!((start.origin, start.settings.start), (Origin::Unreadable, false));
    }

    /// Cut off anywhere they are refused; with some bits flipped they are refused, or others that are told as they are.
    #[test]
    fn damaged_ones_are_refused_or_others(
        settings in settings(),
        flips in proptest::collection::vec((any::<Index>(), 0..8u8), 1..4),
    ) {
        let whole = settings.to_bytes(1024).to_vec();
        for length in 0..whole.len() {
            prop_assert_eq!(read(&whole[..length]), None);
        }
        let mut damaged = whole;
        for (place, bit) in flips {
            let at = place.index(damaged.len());
            damaged[at] ^= 1 << bit;
        }
        if let Some(other) = read(&damaged) {
            prop_assert_eq!(read(&other), Some(other.clone()));
        }
    }

    /// Bytes of nobody.
    #[test]
    fn any_bytes_are_refused_or_settings(bytes in proptest::collection::vec(any::<u8>(), 0..4 * storage::ROOM)) {
        let bytes = [vec![1, 0, 4, 0, 0], bytes].concat();
        if let Some(settings) = read(&bytes) {
            prop_assert_eq!(read(&settings), Some(settings.clone()));
        }
    }

    /// The power ends within a save: then the settings before or the new ones, never others.
    #[test]
    fn power_may_go_within_a_save(
        (old, new) in (settings(), settings()),
        left in any::<Index>(),
        done in any::<u32>(),
    ) {
        let (before, whole) = (payload(&old, 1024), payload(&new, 1024));
        let mut flash = Flash::default();
        storage::save(&mut flash, &before).unwrap();
        prop_assume!(whole != before);
        // An erasure, the words of head and payload, the checksum.
        flash.left = Some(left.index(whole.len() / 4 + 4));
        flash.done = done;
        prop_assert!(storage::save(&mut flash, &whole).is_err());
        flash.left = None;
        let (_, _, kept) = storage::load(&flash).unwrap();
        prop_assert!(kept == before || kept == whole);
        let start = Start::new::<1024>(None, &flash, Crashes::default());
        prop_assert_eq!(start.origin, Origin::Flash);
        prop_assert_eq!(Some(start.settings.to_bytes(1024).to_vec()), read(&kept));
        storage::save(&mut flash, &whole).unwrap();
        prop_assert_eq!(storage::load(&flash).unwrap().2, whole);
    }
}

/// Two pages of flash, and the operations until the power ends.
struct Flash {
    pages: [[u32; PAGE]; 2],
    left: Option<usize>,
    /// The bits that the last operation has done.
    done: u32,
}

impl Default for Flash {
    fn default() -> Self {
        Self { pages: [[u32::MAX; PAGE]; 2], left: None, done: 0 }
    }
}

impl Flash {
    fn power(&mut self) -> Result<(), ()> {
        match &mut self.left {
            Some(0) => Err(()),
            Some(left) => {
                *left -= 1;
                Ok(())
            }
            None => Ok(()),
        }
    }
}

impl Storage for Flash {
    type Error = ();

    fn read(&self, page: Page, index: usize) -> u32 {
        self.pages[page as usize][index]
    }

    fn erase(&mut self, page: Page) -> Result<(), ()> {
        let power = self.power();
        let done = if power.is_ok() { u32::MAX } else { self.done };
        self.pages[page as usize].iter_mut().for_each(|word| *word |= done);
        power
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), ()> {
        let power = self.power();
        let done = if power.is_ok() { u32::MAX } else { self.done };
        self.pages[page as usize][index] &= word | !done;
        power
    }
}
