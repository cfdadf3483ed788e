//! Settings as flash keeps them, against a reader that is written another way: with fields of later programs among them, cut off, with
//! flipped bits, and with power that ends within a save.

use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Following, Scene};
use picket_dsp::methods::registry::Method;
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_dsp::tone::arithmetic::Arithmetic;
use picket_dsp::tone::effort::Effort;
use picket_dsp::tone::fit::Reach;
use picket_instrument::Start;
use picket_instrument::crashes::Crashes;
use picket_instrument::storage::{self, PAGE, Page, Payload, Storage};
use picket_wire::boot::Origin;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use picket_wire::stored::{CRITICAL, ROOM, decode, encode};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;
use std::collections::BTreeMap;

/// Where a field lies in the positional layout of `wire/src/settings.rs`, and its length; tags without their highest bit, which
/// is set.
const PLACES: [(u8, usize, usize); 43] = [
    (1, 1, 1),
    (2, 2, 1),
    (3, 3, 1),
    (4, 4, 2),
    (5, 6, 2),
    (6, 8, 2),
    (7, 10, 4),
    (8, 14, 2),
    (9, 16, 8),
    (10, 24, 8),
    (11, 32, 4),
    (12, 36, 4),
    (13, 40, 4),
    (14, 44, 1),
    (15, 45, 1),
    (16, 46, 1),
    (17, 47, 1),
    (18, 48, 1),
    (19, 49, 1),
    (20, 50, 1),
    (21, 51, 1),
    (22, 52, 4),
    (23, 56, 4),
    (24, 60, 8),
    (25, 68, 16),
    (26, 84, 8),
    (27, 92, 8),
    (28, 100, 8),
    (29, 108, 8),
    (30, 116, 4),
    (31, 120, 4),
    (32, 124, 4),
    (33, 128, 8),
    (34, 136, 4),
    (35, 140, 4),
    (36, 144, 4),
    (37, 148, 4),
    (38, 152, 4),
    (39, 156, 4),
    (40, 160, 8),
    (41, 168, 8),
    (42, 176, 8),
    (43, 184, 8),
];

/// The known tags, their places and lengths.
fn places() -> BTreeMap<u8, (usize, usize)> {
    PLACES.iter().map(|&(tag, at, length)| (tag | CRITICAL, (at, length))).collect()
}

/// The other reader: it puts the fields into the layout of version 4, of version 5 if there is a mode, or of version 6 if there are
/// bounds, on top of the default settings.
fn model(stored: &[u8]) -> Option<Vec<u8>> {
    let mut layout = Settings::default().to_bytes(64).to_vec();
    layout.resize(Settings::BYTES, 0);
    layout[56..60].fill(0);
    layout[160..].copy_from_slice([f64::NAN.to_le_bytes(); 4].as_flattened());
    assert_eq!(stored[0], 128);
    let (mut at, mut last) = (1, 0);
    while at < stored.len() && stored[at] != 0 {
        let tag = stored[at];
        let value = stored.get(at + 2..at + 2 + *stored.get(at + 1)? as usize)?;
        at += 2 + value.len();
        match places().get(&tag) {
            Some(&(place, length)) => {
                if value.len() != length || place <= last {
                    return None;
                }
                layout[place..place + length].copy_from_slice(value);
                last = place;
            }
            // No tag of a later program.
            None if tag & !CRITICAL <= PLACES.len() as u8 => return None,
            None if tag & CRITICAL != 0 => return None,
            None => {}
        }
    }
    let bounds =
        layout[160..].as_chunks().0.iter().any(|&bound| !f64::from_le_bytes(bound).is_nan());
    layout[0] = match layout[144] == 0 && layout[145] & 1 == 0 {
        _ if bounds => 6,
        true => 4,
        false => 5,
    };
    let (settings, n) = Settings::from_bytes(&layout).ok()?;
    Some(settings.to_bytes(n).to_vec())
}

/// What is read, as bytes: a number that is none equals nothing.
fn read(stored: &[u8]) -> Option<Vec<u8>> {
    decode(stored).ok().map(|(settings, n)| settings.to_bytes(n).to_vec())
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
        mode in 0..3u8,
        counts in any::<[u32; 2]>(),
        ratio in proptest::option::of(1.05..100f32),
        bits in any::<[bool; 4]>(),
        tones in (1..=4u8, prop_oneof![Just(0), 2..=15u8]),
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
                _ => Mode::Bursts(Trigger { ratio, hold_off: counts[0], least: counts[1] }),
            },
            report_every,
            most: tones.0,
            harmonics: tones.1,
            slots,
            start,
            uncorrected,
            worst_case,
            calibration: Calibration {
                clock_ppm: ppm as f32,
                range_offset_m: offset as f32,
                range_slope: slope as f32,
            },
        }
    }
}

/// A field of a later program: a tag that is not known today, and a value.
fn later(critical: bool) -> impl Strategy<Value = Vec<u8>> {
    let first = 1 + PLACES.len() as u8;
    let tags: Vec<u8> =
        (first..CRITICAL).map(|tag| if critical { tag | CRITICAL } else { tag }).collect();
    (select(tags), proptest::collection::vec(any::<u8>(), 0..20))
        .prop_map(|(tag, value)| [&[tag, value.len() as u8][..], &value].concat())
}

/// Stored settings as their fields.
fn fields(stored: &[u8]) -> Vec<Vec<u8>> {
    let (mut fields, mut at) = (Vec::new(), 1);
    while at < stored.len() && stored[at] != 0 {
        let end = at + 2 + stored[at + 1] as usize;
        fields.push(stored[at..end].to_vec());
        at = end;
    }
    fields
}

/// The fields with others among them, as a later program may store them.
fn mixed(stored: &[u8], others: &[(Index, Vec<u8>)]) -> Vec<u8> {
    let mut all = fields(stored);
    for (place, field) in others {
        all.insert(place.index(all.len() + 1), field.clone());
    }
    let mut bytes = [vec![128], all.concat()].concat();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// The fields that today's programs pass over.
fn unknown(stored: &[u8]) -> Vec<Vec<u8>> {
    let known = places();
    fields(stored).into_iter().filter(|field| !known.contains_key(&field[0])).collect()
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

    /// Settings come back as the layout of the wire brings them back, to the bit.
    #[test]
    fn all_settings_come_back(settings in settings(), n in block()) {
        let stored = encode(&settings, n, &[]);
        prop_assert!(stored.len() <= 280 && stored.len().is_multiple_of(4));
        let wire = settings.to_bytes(n);
        let expected = Settings::from_bytes(&wire).map(|(settings, n)| settings.to_bytes(n).to_vec());
        prop_assert_eq!(read(&stored), expected.ok());
        prop_assert_eq!(read(&stored), model(&stored));
    }

    /// A page of a later program: what it adds is passed over and handed on by the next save, but what is critical is neither.
    #[test]
    fn fields_of_later_programs_are_passed_over_and_kept(
        settings in settings(),
        other in settings(),
        n in block(),
        others in proptest::collection::vec((any::<Index>(), later(false)), 0..6),
        (place, critical) in (any::<Index>(), later(true)),
    ) {
        let plain = encode(&settings, n, &[]);
        let page = mixed(&plain, &others);
        prop_assert_eq!(read(&page), read(&plain));
        let next = encode(&other, n, &page);
        prop_assert_eq!(read(&next), read(&encode(&other, n, &[])));
        prop_assert_eq!(unknown(&next), unknown(&page));
        // Saved again it is the same.
        prop_assert_eq!(&encode(&other, n, &next), &next);
        let foreign = mixed(&page, &[(place, critical)]);
        prop_assert_eq!(read(&foreign), None);
        prop_assert_eq!(encode(&other, n, &foreign), next);
    }

    /// As many of them as have room, each as a whole.
    #[test]
    fn what_has_no_room_is_left_out_whole(
        settings in settings(),
        values in proptest::collection::vec(0..=255u8, 0..12),
    ) {
        let later = values.iter().flat_map(|&length| [&[100, length][..], &vec![7; length.into()]].concat());
        let page: Vec<u8> = [128].into_iter().chain(later).collect();
        let next = encode(&settings, 1024, &page);
        prop_assert!(next.len() <= ROOM && next.len().is_multiple_of(4));
        prop_assert_eq!(read(&next), read(&encode(&settings, 1024, &[])));
        let mut used = encode(&settings, 1024, &[]).iter().rposition(|&byte| byte != 0).unwrap_or(0) + 1;
        used = used.max(1 + fields(&next).concat().len() - unknown(&next).concat().len());
        let mut expected = Vec::new();
        for field in unknown(&page) {
            if used + field.len() <= ROOM {
                used += field.len();
                expected.push(field);
            }
        }
        prop_assert_eq!(unknown(&next), expected);
    }

    /// Cut off anywhere, or with some bits flipped, they are read as the other reader reads them, or refused as there.
    #[test]
    fn damaged_ones_are_read_as_the_model_reads_them(
        settings in settings(),
        others in proptest::collection::vec((any::<Index>(), later(false)), 0..3),
        cut in any::<Index>(),
        flips in proptest::collection::vec((any::<Index>(), 0..8u8), 0..4),
    ) {
        let page = mixed(&encode(&settings, 1024, &[]), &others);
        for length in 1..=page.len() {
            prop_assert_eq!(read(&page[..length]), model(&page[..length]));
        }
        let mut damaged = page[..1 + cut.index(page.len())].to_vec();
        for (place, bit) in flips {
            let at = place.index(damaged.len());
            damaged[at] ^= 1 << bit;
        }
        damaged[0] = 128;
        prop_assert_eq!(read(&damaged), model(&damaged));
    }

    /// Bytes of nobody.
    #[test]
    fn any_bytes_are_read_as_the_model_reads_them(bytes in proptest::collection::vec(any::<u8>(), 0..ROOM)) {
        let bytes = [vec![128], bytes].concat();
        prop_assert_eq!(read(&bytes), model(&bytes));
        let _ = decode(&bytes[1..]);
    }

    /// The power ends within a save: then the settings before or the new ones, never others, and what a later program has added is
    /// with both.
    #[test]
    fn power_may_go_within_a_save(
        (old, new) in (settings(), settings()),
        others in proptest::collection::vec((any::<Index>(), later(false)), 0..4),
        left in any::<Index>(),
        done in any::<u32>(),
    ) {
        let payload = mixed(&encode(&old, 1024, &[]), &others);
        prop_assume!(read(&payload).is_some() && payload.len() <= ROOM);
        let mut flash = Flash::default();
        for _ in 0..2 {
            storage::save(&mut flash, &Payload::from_slice(&payload).unwrap()).unwrap();
        }
        let whole = encode(&new, 1024, &payload);
        prop_assume!(whole[..] != payload[..]);
        // An erasure, the words of head and payload, the checksum.
        flash.left = Some(left.index(whole.len() / 4 + 4));
        flash.done = done;
        prop_assert!(storage::save(&mut flash, &whole).is_err());
        flash.left = None;
        let (_, _, kept) = storage::load(&flash).unwrap();
        prop_assert!(kept[..] == payload[..] || kept == whole);
        prop_assert_eq!(unknown(&kept), unknown(&payload));
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

/// The default settings have no field but the length of a block: what a field says where it is absent is what nobody has set.
#[test]
fn the_default_settings_are_a_length_alone() {
    let mut stored = vec![128, CRITICAL | 23, 4, 0, 4, 0, 0, 0];
    assert_eq!(encode(&Settings::default(), 1024, &[])[..], stored);
    stored[3] = 1;
    assert!(decode(&stored).is_err(), "no length that there is");
}
