//! Settings in flash of every layout that there ever was. The bytes were written by the programs of that time, each of the commit that
//! is named, with the settings of [`written`]; none by today's encoder.

use crc::{CRC_32_ISO_HDLC, Crc};
use picket::acquire::burst::Trigger;
use picket::carrier::Carrier;
use picket::config::{Config, Scene};
use picket::solve::chirp::{Mixing, Shape};
use picket::solve::equations::Chirp;
use picket_instrument::Start;
use picket_instrument::crashes::Crashes;
use picket_instrument::storage::{self, Page, Storage};
use picket_instrument::words::{WORDS, words};
use picket_wire::boot::Origin;
use picket_wire::settings::{Calibration, Drive, Mode, Settings};

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
        Self([vec![u32::MAX; 64], vec![u32::MAX; 64]])
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
    let layouts: [(&[&str], Settings); 8] = [
        (&CODES, first),
        (&SLOTS, slots),
        (&UNCORRECTED, Settings { uncorrected: true, ..slots }),
        (&LINES, Settings { uncorrected: false, most: 3, harmonics: 5, ..slots }),
        (&WAVEFORM, waveform),
        (&CARRIER, carrier),
        (&SUM, Settings { mode: Mode::Accumulate { blocks: 100, drift_bins: -0.25 }, ..tone }),
        (&BURST, Settings { mode: Mode::Bursts(trigger), ..tone }),
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
        storage::save(&mut flash, &words(&changed, 1024)).unwrap();
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
    later[0] = 6;
    let mut longer = bytes(&BURST);
    longer.extend([0; 4]);
    let other = written().to_bytes(512).to_vec();
    let field = [&bytes(&CODES)[..45], &[99], &bytes(&CODES)[46..]].concat();
    // The first layout of all was of version 1 as the second one is, and never left its authors' desks.
    for foreign in [bytes(&FIRST), later, longer, other, field, vec![0xA5; 160]] {
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
    assert_eq!(WORDS * 4, 160, "a longer layout belongs into this file");
}
