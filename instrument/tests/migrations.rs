//! Settings in flash of every layout that there ever was. The bytes were written by the programs of that time, each of the commit that
//! is named, with the settings of [`written`]; none by today's encoder.

use crc::{CRC_32_ISO_HDLC, Crc};
use picket_dsp::acquire::burst::Trigger;
use picket_dsp::acquire::codes::Codes;
use picket_dsp::carrier::Carrier;
use picket_dsp::config::{Config, Scene};
use picket_dsp::solve::chirp::{Mixing, Shape};
use picket_dsp::solve::equations::Chirp;
use picket_instrument::Start;
use picket_instrument::crashes::Crashes;
use picket_instrument::storage::{self, Page, Storage};
use picket_wire::boot::Origin;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};
use picket_wire::stored;

/// Commit 35f3ace: the first layout, whose configuration began with a number for the codes.
const FIRST: [&str; 4] = [
    "010100019000200003009001100e000000000000000000000000000000000000",
    "000048c19a99993ec520803f0001130200100000000000000004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

/// Commit 6d46782: rails in its place.
const CODES: [&str; 4] = [
    "010100019000200003009001100e000000000000000000000000000000000000",
    "000048c19a99993ec520803f00130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

/// Commit bce3f24: with slots.
const SLOTS: [&str; 4] = [
    "010100019000200003009001100e070000000000000000000000000000000000",
    "000048c19a99993ec520803f00130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

/// Commit 2b92604: codes that stay uncorrected.
const UNCORRECTED: [&str; 4] = [
    "010100039000200003009001100e070000000000000000000000000000000000",
    "000048c19a99993ec520803f00130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

/// Commit 7b92aae: version 2, three tones and harmonics.
const LINES: [&str; 4] = [
    "020100599000200003009001100e070000000000000000000000000000000000",
    "000048c19a99993ec520803f00130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
];

/// Commit 6b58ad2: version 3, two tones, the less usual mixing and a curved sweep.
const WAVEFORM: [&str; 5] = [
    "030100059000200003009001100e070000000000000000000000000000000000",
    "000048c19a99993ec520803f04130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
    "7b14ae47e17a84bf",
];

/// Commit 75883e1: version 4, a carrier's width.
const CARRIER: [&str; 5] = [
    "040100019000200003009001100e070000000000000000000000000000000000",
    "000048c19a99993ec520803f00130200100000000000ff0f0004000000000000",
    "80840e41000000000000000000000000000000009a9999999999893f00000000",
    "84d7a741fa9cbb5d2f4d713f8dedb5a0f7c6b03ecdcc4c3d0000000000000040",
    "7b14ae47e17a84bf0000f04200002042",
];

/// Commit 11f4d04: version 5, sums.
const SUM: [&str; 5] = [
    "0500000190000000030000000000000000000000000000000000000000000000",
    "000048c19a99993ec520803f00130000100000000000ff0f0004000000000000",
    "80840e4100000000000000000000000000000000000000000000000000000000",
    "0000000000000000000000008dedb5a0f7c6b03ecdcc4c3d0000000000000040",
    "000000000000000000000000000000000100000064000000000080be00000000",
];

/// Commit 11f4d04: version 5, bursts.
const BURST: [&str; 5] = [
    "0500000190000000030000000000000000000000000000000000000000000000",
    "000048c19a99993ec520803f00130000100000000000ff0f0004000000000000",
    "80840e4100000000000000000000000000000000000000000000000000000000",
    "0000000000000000000000008dedb5a0f7c6b03ecdcc4c3d0000000000000040",
    "0000000000000000000000000000000002000000640000000000204009000000",
];

/// The first layout with tags: what [`stored::encode`] writes of the settings of [`BURST`], and of the carrier of [`CARRIER`].
const TAGS: [&str; 3] = [
    "8084029000860203008b04000048c18c049a99993e8d04c520803f9704000400",
    "0098080000000080840e41a2040000f042a30400002042a40402000000a50464",
    "000000a60400002040a7040900000000",
];

/// A page as it lay in flash, head and checksum and all: settings of version 1 in 32 words.
const PAGE: [u32; 35] = [
    0x50490020, 0x00000007, 0x01020201, 0x00400000, 0x00000003, 0x00000000, 0x00000000, 0x419312D0,
    0xC0000000, 0x42165A0B, 0xC1480000, 0x3E99999A, 0x3F8020C5, 0x01021303, 0x00000010, 0x0FFF0000,
    0x00000400, 0x00000000, 0x411E8480, 0x00000000, 0x409F4000, 0x00000000, 0x40FD4C00, 0x9999999A,
    0x3F899999, 0x00000000, 0x41A7D784, 0x1AC14C66, 0x3F61D367, 0xA0B5ED8D, 0x3EB0C6F7, 0x3D4CCCCD,
    0x00000000, 0x40000000, 0xBCEE272A,
];

/// The settings that those programs wrote: a chirp by the DAC.
fn written() -> Settings {
    let chirp = Chirp {
        shape: Shape::Trapezoid,
        wavelength_m: 0.0125,
        bandwidth_hz: 200e6,
        duration_s: 1056.0 / 250e3,
        guard_s: 32.0 / 250e3,
        mixing: Mixing::TxConjRx,
        sweep_curvature: 0.0,
    };
    let base = Settings::default();
    Settings {
        core_mhz: 144,
        config: Config { rate_hz: 250e3, scene: Scene::Chirp(chirp), ..base.config },
        guard: 32,
        drive: Drive::Dac { low: 400, high: 3600 },
        report_every: 3,
        calibration: Calibration { clock_ppm: -12.5, range_offset_m: 0.3, range_slope: 1.001 },
        ..base
    }
}

fn bytes(lines: &[&str]) -> Vec<u8> {
    let text = lines.concat();
    let byte = |at| u8::from_str_radix(&text[at..at + 2], 16).unwrap();
    (0..text.len()).step_by(2).map(byte).collect()
}

/// Two pages of flash.
#[derive(Clone, PartialEq)]
struct Flash([Vec<u32>; 2]);

impl Flash {
    fn new() -> Self {
        Self([vec![u32::MAX; storage::PAGE], vec![u32::MAX; storage::PAGE]])
    }

    /// A page with this payload, as every program since the first writes it: "PI" and the length, a sequence, the payload, a CRC-32.
    fn put(&mut self, page: Page, sequence: u32, payload: &[u8]) {
        let head = 0x5049_0000 | (payload.len() / 4) as u32;
        let mut page_bytes = [head.to_le_bytes(), sequence.to_le_bytes()].concat();
        page_bytes.extend_from_slice(payload);
        let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&page_bytes);
        page_bytes.extend_from_slice(&crc.to_le_bytes());
        let words =
            page_bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap()));
        self.0[page as usize].iter_mut().zip(words).for_each(|(place, word)| *place = word);
    }
}

impl Storage for Flash {
    type Error = ();

    fn read(&self, page: Page, index: usize) -> u32 {
        self.0[page as usize][index]
    }

    fn erase(&mut self, page: Page) -> Result<(), ()> {
        self.0[page as usize].fill(u32::MAX);
        Ok(())
    }

    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), ()> {
        self.0[page as usize][index] = word;
        Ok(())
    }
}

/// Saves settings as an instrument for blocks of 1024 samples does.
fn save(flash: &mut Flash, settings: &Settings) {
    let before = storage::load(flash).map(|(_, _, before)| before).unwrap_or_default();
    storage::save(flash, &stored::encode(settings, 1024, &before)).unwrap();
}

/// How an instrument for blocks of 1024 samples starts with this flash.
fn start(flash: &Flash) -> Start {
    Start::new::<1024>(None, flash, Crashes::default())
}

#[test]
fn every_layout_that_was_written_is_read() {
    let first = written();
    let slots = Settings { slots: 7, ..first };
    let mut waveform = Settings { most: 2, ..slots };
    let mut carrier = slots;
    if let (Scene::Chirp(chirp), Scene::Chirp(other)) =
        (&mut waveform.config.scene, &mut carrier.config.scene)
    {
        (chirp.mixing, chirp.sweep_curvature) = (Mixing::RxConjTx, -0.01);
        other.sweep_curvature = -0.01;
    }
    carrier.config.carrier = Carrier { linewidth_hz: 120.0, envelope_hz: 40.0 };
    let tone = Settings {
        config: Config { scene: Scene::Tone, ..first.config },
        guard: 0,
        drive: Drive::Off,
        ..first
    };
    let trigger = Trigger { ratio: Some(2.5), hold_off: 100, least: 9 };
    let burst = Settings { mode: Mode::Bursts(trigger), ..tone };
    let mut tags = burst;
    tags.config.carrier = carrier.config.carrier;
    let layouts: [(&[&str], Settings); 10] = [
        (&FIRST, first),
        (&CODES, first),
        (&SLOTS, slots),
        (&UNCORRECTED, Settings { uncorrected: true, ..slots }),
        (&LINES, Settings { uncorrected: false, most: 3, harmonics: 5, ..slots }),
        (&WAVEFORM, waveform),
        (&CARRIER, carrier),
        (&SUM, Settings { mode: Mode::Accumulate { blocks: 100, drift_bins: -0.25 }, ..tone }),
        (&BURST, burst),
        (&TAGS, tags),
    ];
    for (layout, settings) in layouts {
        let payload = bytes(layout);
        let mut flash = Flash::new();
        flash.put(Page::A, 0, &payload);
        let begun = start(&flash);
        assert_eq!((begun.origin, begun.settings), (Origin::Flash, settings));
        // Programs of later layouts wrote their shorter settings into longer pages, too.
        for length in [136, 144, 160] {
            let mut padded = payload.clone();
            padded.resize(payload.len().max(length), 0);
            let mut flash = Flash::new();
            flash.put(Page::B, 7, &padded);
            assert_eq!((start(&flash).origin, start(&flash).settings), (Origin::Flash, settings));
        }
        // What is saved now is read the next time, and the old page stays beside it.
        let changed = Settings { report_every: 5, ..settings };
        save(&mut flash, &changed);
        assert_eq!((start(&flash).origin, start(&flash).settings), (Origin::Flash, changed));
        let mut old = Flash::new();
        old.put(Page::A, 0, &payload);
        assert!(flash.0[0] == old.0[0]);
    }
}

/// What cannot be read is never taken for something else: the settings before count, else the instrument waits. It leaves the pages
/// as they are.
#[test]
fn what_no_program_of_today_wrote_is_refused_and_kept() {
    let mut later = bytes(&BURST);
    later[0] = 7;
    let mut longer = bytes(&BURST);
    longer.extend([0; 4]);
    let other = written().to_bytes(512).to_vec();
    let field = [&bytes(&CODES)[..45], &[99], &bytes(&CODES)[46..]].concat();
    let first = [&bytes(&FIRST)[..45], &[3], &bytes(&FIRST)[46..]].concat();
    let mut tags = bytes(&TAGS);
    tags[0] = 129;
    for foreign in [later, longer, other, field, first, tags, vec![0xA5; 160]] {
        let mut alone = Flash::new();
        alone.put(Page::A, 3, &foreign);
        let before = alone.clone();
        let begun = start(&alone);
        assert_eq!((begun.origin, begun.settings.start), (Origin::Unreadable, false));
        assert_eq!(Settings { start: true, ..begun.settings }, Settings::default());
        assert!(alone == before);
        // With readable settings in the other page, older or not, these count.
        for sequence in [2, 4] {
            let mut both = alone.clone();
            both.put(Page::B, sequence, &bytes(&SLOTS));
            let begun = start(&both);
            let expected = Settings { slots: 7, ..written() };
            assert_eq!((begun.origin, begun.settings), (Origin::Flash, expected));
        }
    }
    assert_eq!(Settings::MODED, 160, "a longer layout belongs into this file");
}

/// Settings in a page of flash as a program of that time left it.
#[test]
fn a_page_of_an_earlier_program_is_read_and_saved_anew_beside_it() {
    let mut flash = Flash::new();
    flash.0[1][..35].copy_from_slice(&PAGE);
    let begun = start(&flash);
    assert_eq!(
        (begun.origin, begun.settings.guard, begun.settings.report_every),
        (Origin::Flash, 64, 3)
    );
    save(&mut flash, &begun.settings);
    assert_eq!(flash.0[1][..35], PAGE);
    let (page, sequence, _) = storage::load(&flash).unwrap();
    assert_eq!((page, sequence, start(&flash)), (Page::A, 8, begun));
    // A second save of the same settings writes nothing.
    let before = flash.clone();
    save(&mut flash, &begun.settings);
    assert!(flash == before);
}

/// Further settings of the first programs, written as [`FIRST`]: other codes, and other shapes of chirps of a second. What differs are
/// these 32 bytes, and the duration.
#[test]
fn every_number_of_the_first_layout_has_its_meaning() {
    for (line, codes, shape) in [
        (
            "000048c19a99993ec520803f0000130200100000000000000004000000000000",
            Codes::signed::<12>(),
            Shape::Trapezoid,
        ),
        (
            "000048c19a99993ec520803f0002130200100000000000000004000000000000",
            Codes::signed::<16>(),
            Shape::Trapezoid,
        ),
        (
            "000048c19a99993ec520803f0001130201100000000000000004000000000000",
            Codes::unsigned::<12>(),
            Shape::Triangle,
        ),
        (
            "000048c19a99993ec520803f0001130202100000000000000004000000000000",
            Codes::unsigned::<12>(),
            Shape::Sawtooth,
        ),
    ] {
        let mut lines = FIRST;
        lines[1] = line;
        let mut expected = written();
        expected.config.codes = codes;
        if let Scene::Chirp(chirp) = &mut expected.config.scene {
            chirp.shape = shape;
        }
        assert_eq!(stored::decode(&bytes(&lines)), Ok((expected, 1024)));
    }
}
