//! Settings in flash, in two pages by turns, so that one page is whole whenever the power fails.
//!
//! ```text
//! page:  magic and length | sequence | payload, word by word | CRC-32 of all before
//! ```
//!
//! A save erases the page that is *not* the newest and writes there, the CRC last. Without its CRC
//! a page is invalid, and the other one counts. With it, the page with the higher sequence counts.
//!
//! A page with a shorter payload was saved by an earlier program: the words that it lacks are read as 0.

use crate::checksum::of_words;

/// A piece of flash with two erasable pages of at least `WORDS + 3` words. Erased words are all
/// ones.
pub trait Storage {
    /// Why the flash refused.
    type Error;
    /// The word at `index` of a page.
    fn read(&self, page: Page, index: usize) -> u32;
    /// Erases a page.
    ///
    /// # Errors
    /// The flash refused.
    fn erase(&mut self, page: Page) -> Result<(), Self::Error>;
    /// Writes an erased word.
    ///
    /// # Errors
    /// The flash refused.
    fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Self::Error>;
}

/// One of the two pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Page {
    /// The first page.
    A = 0,
    /// The second page.
    B = 1,
}

impl Page {
    /// The other page.
    pub const fn other(self) -> Self {
        match self {
            Page::A => Page::B,
            Page::B => Page::A,
        }
    }
}

/// Storage for boards that have none: nothing survives a restart, and a save is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nowhere;

impl Storage for Nowhere {
    type Error = Nowhere;

    fn read(&self, _: Page, _: usize) -> u32 {
        u32::MAX
    }

    fn erase(&mut self, _: Page) -> Result<(), Nowhere> {
        Err(Nowhere)
    }

    fn write(&mut self, _: Page, _: usize, _: u32) -> Result<(), Nowhere> {
        Err(Nowhere)
    }
}

/// Why settings were not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError<E> {
    /// The flash refused.
    Flash(E),
    /// What was written reads back differently.
    Verify,
}

const MAGIC: u32 = 0x5049_0000;

/// A page that is whole: which one, its sequence and its payload.
type Whole<const WORDS: usize> = (Page, u32, [u32; WORDS]);

/// The pages that are whole, the newest first.
#[inline(never)]
fn whole<const WORDS: usize, S: Storage>(storage: &S) -> [Option<Whole<WORDS>>; 2] {
    let [a, b] = [Page::A, Page::B].map(|page| {
        let (sequence, words) = read::<WORDS, S>(storage, page)?;
        Some((page, sequence, words))
    });
    match (&a, &b) {
        // The sequence may wrap: the shorter way round tells which is newer.
        (Some((_, a, _)), Some((_, b, _))) if b.wrapping_sub(*a) >= 1 << 31 => {}
        (Some(_), None) => {}
        _ => return [b, a],
    }
    [a, b]
}

/// The newest payload of `WORDS` words, with its page and sequence; `None` if no page is whole.
pub fn load<const WORDS: usize, S: Storage>(storage: &S) -> Option<(Page, u32, [u32; WORDS])> {
    let [newest, _] = whole::<WORDS, S>(storage);
    newest
}

/// What the pages hold for a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept<const WORDS: usize> {
    /// Neither page was ever written.
    Nothing,
    /// The newest payload that the program can read.
    Found([u32; WORDS]),
    /// A page was written, and the program can read neither: another program's settings, or damaged ones.
    Unreadable,
}

/// What the pages hold that a program can read: the newest payload, or the one before.
pub fn latest<const WORDS: usize, S: Storage>(
    storage: &S,
    reads: impl Fn(&[u32; WORDS]) -> bool,
) -> Kept<WORDS> {
    for (_, _, words) in whole::<WORDS, S>(storage).iter().flatten() {
        if reads(words) {
            return Kept::Found(*words);
        }
    }
    // The head's length is that of whoever wrote it.
    let written = |page| storage.read(page, 0) & 0xFFFF_0000 == MAGIC;
    if written(Page::A) || written(Page::B) { Kept::Unreadable } else { Kept::Nothing }
}

/// Saves a payload. If the power fails during it, [`load`] gives either the old payload or this
/// one. A save of the newest payload writes nothing.
///
/// # Errors
/// The flash refused, or what was written reads back differently.
pub fn save<const WORDS: usize, S: Storage>(
    storage: &mut S,
    payload: &[u32; WORDS],
) -> Result<(), SaveError<S::Error>> {
    let (page, sequence) = match load::<WORDS, S>(storage) {
        Some((_, _, newest)) if newest == *payload => return Ok(()),
        Some((page, sequence, _)) => (page.other(), sequence.wrapping_add(1)),
        None => (Page::A, 0),
    };
    storage.erase(page).map_err(SaveError::Flash)?;
    let words = [head(WORDS), sequence].into_iter().chain(payload.iter().copied());
    for (index, word) in words.chain([checksum(sequence, payload)]).enumerate() {
        storage.write(page, index, word).map_err(SaveError::Flash)?;
    }
    match read::<WORDS, S>(storage, page) {
        Some(whole) if whole == (sequence, *payload) => Ok(()),
        _ => Err(SaveError::Verify),
    }
}

const fn head(words: usize) -> u32 {
    MAGIC | words as u32
}

fn checksum(sequence: u32, payload: &[u32]) -> u32 {
    of_words([head(payload.len()), sequence].iter().chain(payload).copied())
}

/// The sequence and payload of a page; `None` unless the page is whole.
fn read<const WORDS: usize, S: Storage>(storage: &S, page: Page) -> Option<(u32, [u32; WORDS])> {
    let length = (storage.read(page, 0) ^ MAGIC) as usize;
    let sequence = storage.read(page, 1);
    let mut payload = [0; WORDS];
    let saved = payload.get_mut(..length)?;
    for (index, word) in saved.iter_mut().enumerate() {
        *word = storage.read(page, index + 2);
    }
    let whole = storage.read(page, length + 2) == checksum(sequence, saved);
    whole.then_some((sequence, payload))
}

#[cfg(test)]
mod tests {
    use super::*;
    use picket_wire::settings::Settings;

    const WORDS: usize = 5;
    const SIZE: usize = WORDS + 3;

    /// Flash that loses power at one of its operations. An erasure then leaves the page half
    /// erased, a write half of the bits.
    #[derive(Clone)]
    struct Mock {
        pages: [[u32; SIZE]; 2],
        /// Operations until the power fails.
        left: u32,
        /// How an interrupted operation ends: the bits that were done.
        done: u32,
        operations: u32,
    }

    /// The power has failed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    struct Off;

    impl Mock {
        fn new() -> Self {
            // A new chip, and one that held something else.
            let pages = [[u32::MAX; SIZE], [0x1234_5678; SIZE]];
            Self { pages, left: u32::MAX, done: 0, operations: 0 }
        }

        fn power(&mut self) -> bool {
            self.operations += 1;
            let on = self.left > 0;
            self.left = self.left.saturating_sub(1);
            on
        }
    }

    impl Storage for Mock {
        type Error = Off;

        fn read(&self, page: Page, index: usize) -> u32 {
            self.pages[page as usize][index]
        }

        fn erase(&mut self, page: Page) -> Result<(), Off> {
            let on = self.power();
            let done = self.done;
            for (index, word) in self.pages[page as usize].iter_mut().enumerate() {
                *word = match on {
                    true => u32::MAX,
                    // Some cells are erased, others are not; some words wholly, others not at all.
                    false if done & 1 << index != 0 => *word,
                    false => *word | done.rotate_left(index as u32),
                };
            }
            on.then_some(()).ok_or(Off)
        }

        fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Off> {
            let on = self.power();
            let place = &mut self.pages[page as usize][index];
            if on {
                assert_eq!(*place, u32::MAX, "written without erasure");
                *place = word;
                return Ok(());
            }
            // A write only clears bits.
            *place &= word | self.done;
            Err(Off)
        }
    }

    fn payload(round: u32) -> [u32; WORDS] {
        core::array::from_fn(|n| round.wrapping_mul(0x9E37_79B9).rotate_left(n as u32) ^ n as u32)
    }

    fn newest(mock: &Mock) -> Option<[u32; WORDS]> {
        load(mock).map(|(_, _, words)| words)
    }

    #[test]
    fn power_may_go_at_every_single_write() {
        let mut whole = Mock::new();
        let mut cases = 0;
        for round in 1..=6 {
            let before = newest(&whole);
            let mut count = whole.clone();
            count.operations = 0;
            save(&mut count, &payload(round)).unwrap();
            // An erasure, two words of head, the payload, the checksum.
            assert_eq!(count.operations, 1 + SIZE as u32);
            for cut in 0..count.operations {
                for done in
                    [0, u32::MAX, 0xFFFF, 0xFFFF_0000, 0x5555_5555, 0x8000_0001, 0xF0F3_7E11]
                {
                    let mut mock = Mock { left: cut, done, ..whole.clone() };
                    assert_eq!(save(&mut mock, &payload(round)), Err(SaveError::Flash(Off)));
                    let after = newest(&mock);
                    // The last write may be complete just when the power fails.
                    let new = cut + 1 == count.operations && after == Some(payload(round));
                    assert!(after == before || new, "round {round}, cut {cut}, {done:#x}");
                    // With power back, the next save works, and the one after it.
                    mock.left = u32::MAX;
                    for next in [payload(100 + round), payload(200 + round)] {
                        save(&mut mock, &next).unwrap();
                        assert_eq!(newest(&mock), Some(next));
                    }
                    cases += 1;
                }
            }
            save(&mut whole, &payload(round)).unwrap();
            assert_eq!(newest(&whole), Some(payload(round)));
        }
        assert_eq!(cases, 6 * 9 * 7);
    }

    #[test]
    fn the_same_settings_wear_no_flash() {
        let mut mock = Mock::new();
        save(&mut mock, &payload(1)).unwrap();
        mock.operations = 0;
        save(&mut mock, &payload(1)).unwrap();
        assert_eq!(mock.operations, 0);
    }

    #[test]
    fn the_sequence_may_wrap_and_any_damaged_bit_is_seen() {
        let mut mock = Mock::new();
        for (page, sequence) in [(Page::A, u32::MAX), (Page::B, 0)] {
            let words = payload(sequence);
            mock.pages[page as usize] = [u32::MAX; SIZE];
            let all: std::vec::Vec<u32> =
                [&[head(WORDS), sequence][..], &words, &[checksum(sequence, &words)]].concat();
            mock.pages[page as usize].copy_from_slice(&all);
        }
        assert_eq!(load(&mock), Some((Page::B, 0, payload(0))));
        for bit in 0..32 * SIZE {
            let mut damaged = mock.clone();
            damaged.pages[1][bit / 32] ^= 1 << (bit % 32);
            assert_eq!(load(&damaged), Some((Page::A, u32::MAX, payload(u32::MAX))), "bit {bit}");
        }
        save(&mut mock, &payload(7)).unwrap();
        assert_eq!(load(&mock), Some((Page::A, 1, payload(7))));
    }

    /// A page with 32 words of settings of version 1, as an earlier program saved it.
    const EARLIER: [u32; 35] = [
        0x50490020, 0x00000007, 0x01020201, 0x00400000, 0x00000003, 0x00000000, 0x00000000,
        0x419312D0, 0xC0000000, 0x42165A0B, 0xC1480000, 0x3E99999A, 0x3F8020C5, 0x01021303,
        0x00000010, 0x0FFF0000, 0x00000400, 0x00000000, 0x411E8480, 0x00000000, 0x409F4000,
        0x00000000, 0x40FD4C00, 0x9999999A, 0x3F899999, 0x00000000, 0x41A7D784, 0x1AC14C66,
        0x3F61D367, 0xA0B5ED8D, 0x3EB0C6F7, 0x3D4CCCCD, 0x00000000, 0x40000000, 0xBCEE272A,
    ];

    #[test]
    fn settings_of_an_earlier_program_are_loaded_and_saved_anew() {
        const LONG: usize = Settings::BYTES / 4;
        struct Flash([[u32; LONG + 3]; 2]);
        impl Storage for Flash {
            type Error = Off;
            fn read(&self, page: Page, index: usize) -> u32 {
                self.0[page as usize][index]
            }
            fn erase(&mut self, page: Page) -> Result<(), Off> {
                self.0[page as usize] = [u32::MAX; LONG + 3];
                Ok(())
            }
            fn write(&mut self, page: Page, index: usize, word: u32) -> Result<(), Off> {
                self.0[page as usize][index] = word;
                Ok(())
            }
        }
        let mut flash = Flash([[u32::MAX; LONG + 3]; 2]);
        flash.0[1][..35].copy_from_slice(&EARLIER);
        let (page, sequence, words) = load::<LONG, _>(&flash).unwrap();
        assert_eq!((page, sequence), (Page::B, 7));
        let bytes: std::vec::Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let (settings, n) = Settings::of_bytes(&bytes).unwrap();
        assert_eq!((n, settings.guard, settings.report_every), (1024, 64, 3));
        assert_eq!(bytes[..Settings::SHORT], settings.to_bytes(n)[..]);
        // Saved again they are no other settings, and others go to the other page.
        save(&mut flash, &words).unwrap();
        assert_eq!(load(&flash), Some((Page::B, 7, words)));
        save(&mut flash, &[5; LONG]).unwrap();
        assert_eq!(load(&flash), Some((Page::A, 8, [5; LONG])));
        // A payload of a later program is none of this one's.
        flash.0[0][0] += 1;
        assert_eq!(load(&flash), Some((Page::B, 7, words)));
    }

    /// A payload that its reader does not understand once became default settings that were called stored ones.
    #[test]
    fn the_newest_payload_that_can_be_read_counts() {
        let small = |words: &[u32; WORDS]| words[0] < 100;
        let found = |value| Kept::Found([value; WORDS]);
        let mut mock = Mock::new();
        assert_eq!(latest(&mock, small), Kept::Nothing);
        save(&mut mock, &[1; WORDS]).unwrap();
        assert_eq!(latest(&mock, small), found(1));
        save(&mut mock, &[2; WORDS]).unwrap();
        assert_eq!(latest(&mock, small), found(2));
        save(&mut mock, &[1000; WORDS]).unwrap();
        assert_eq!(latest(&mock, small), found(2));
        save(&mut mock, &[1001; WORDS]).unwrap();
        assert_eq!(latest(&mock, small), Kept::Unreadable);
        // A later program's payload is longer than this one's.
        let mut later = Mock::new();
        save(&mut later, &[3; WORDS]).unwrap();
        later.pages[Page::B as usize][0] = head(WORDS + 1);
        assert_eq!(latest(&later, small), found(3));
        later.pages[Page::A as usize][2] ^= 1;
        assert_eq!(latest(&later, small), Kept::Unreadable);
        assert_eq!(latest(&Nowhere, small), Kept::Nothing);
    }

    #[test]
    fn flash_that_keeps_nothing_is_told() {
        assert_eq!(load::<WORDS, _>(&Nowhere), None);
        assert_eq!(save(&mut Nowhere, &payload(1)), Err(SaveError::Flash(Nowhere)));
        struct Dead;
        impl Storage for Dead {
            type Error = Off;
            fn read(&self, _: Page, _: usize) -> u32 {
                0
            }
            fn erase(&mut self, _: Page) -> Result<(), Off> {
                Ok(())
            }
            fn write(&mut self, _: Page, _: usize, _: u32) -> Result<(), Off> {
                Ok(())
            }
        }
        assert_eq!(load::<WORDS, _>(&Dead), None);
        assert_eq!(save(&mut Dead, &payload(1)), Err(SaveError::Verify));
    }
}
