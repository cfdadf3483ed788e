//! Settings in flash, in two pages in turn, so that one page is whole whenever the power fails.
//!
//! ```text
//! page:  magic and length | sequence | payload, word by word | CRC-32 of all before
//! ```
//!
//! A save erases the page that is *not* the newest and writes there, the CRC last. Without its CRC a page is invalid, and the other one
//! counts. With a CRC on both, the page with the higher sequence counts.
//!
//! The payload is [`Settings::to_bytes`](picket_wire::settings::Settings::to_bytes), see [`crate::words::payload`].

use crate::checksum::of_words;
use heapless::Vec;

/// The longest payload, words: the longest settings, and room for what later programs add.
pub const ROOM: usize = 64;

/// Words of a page with the longest payload.
pub const PAGE: usize = ROOM + 3;

/// The payload of a page: whole words.
pub type Payload = Vec<u8, { 4 * ROOM }>;

/// A piece of flash with two erasable pages of at least [`PAGE`] words. Erased words are all ones.
pub trait Storage {
    /// The reason why the flash refused.
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

/// Storage for boards without any: nothing survives a restart, and a save is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoStorage;

impl Storage for NoStorage {
    type Error = NoStorage;

    fn read(&self, _: Page, _: usize) -> u32 {
        u32::MAX
    }

    fn erase(&mut self, _: Page) -> Result<(), NoStorage> {
        Err(NoStorage)
    }

    fn write(&mut self, _: Page, _: usize, _: u32) -> Result<(), NoStorage> {
        Err(NoStorage)
    }
}

/// The reason why settings were not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError<E> {
    /// The flash refused.
    Flash(E),
    /// The flash reads back differently.
    Verify,
}

const MAGIC: u32 = 0x5049_0000;

/// The pages that are whole with their sequences, the newest first.
fn whole(storage: &impl Storage) -> [Option<(Page, u32)>; 2] {
    let [a, b] = [Page::A, Page::B].map(|page| Some((page, read(storage, page)?.0)));
    match (a, b) {
        // The sequence may wrap: the shorter way round decides which is newer.
        (Some((_, older)), Some((_, newer))) if newer.wrapping_sub(older) >= 1 << 31 => [a, b],
        (Some(_), None) => [a, b],
        _ => [b, a],
    }
}

/// The newest payload, with its page and sequence; `None` if no page is whole.
pub fn load(storage: &impl Storage) -> Option<(Page, u32, Payload)> {
    let [newest, _] = whole(storage);
    let (page, _) = newest?;
    let (sequence, payload) = read(storage, page)?;
    Some((page, sequence, payload))
}

/// The payload before the newest one, if its page is whole.
pub fn before(storage: &impl Storage) -> Option<Payload> {
    let [_, before] = whole(storage);
    before.and_then(|(page, _)| read(storage, page)).map(|(_, payload)| payload)
}

/// The contents of the pages, as a program reads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept<T> {
    /// Neither page was ever written.
    Nothing,
    /// The newest payload that the program can read, as read.
    Found(T),
    /// A page was written, and the program can read neither: another program's settings, or damaged ones.
    Unreadable,
}

/// The newest payload that a program can read: the newest of all, or the one before.
pub fn latest<T>(storage: &impl Storage, reads: impl Fn(&[u8]) -> Option<T>) -> Kept<T> {
    for (page, _) in whole(storage).into_iter().flatten() {
        if let Some(found) = read(storage, page).and_then(|(_, payload)| reads(&payload)) {
            return Kept::Found(found);
        }
    }
    // The length in the head depends on the program that wrote it.
    let written = |page| storage.read(page, 0) & 0xFFFF_0000 == MAGIC;
    if written(Page::A) || written(Page::B) { Kept::Unreadable } else { Kept::Nothing }
}

/// Saves a payload. If the power fails during the save, [`load`] returns either the old payload or this one. A save of the newest payload
/// writes nothing.
///
/// # Errors
/// The flash refused, or reads back differently.
pub fn save<S: Storage>(storage: &mut S, payload: &Payload) -> Result<(), SaveError<S::Error>> {
    let (page, sequence) = match load(storage) {
        Some((_, _, newest)) if newest == *payload => return Ok(()),
        Some((page, sequence, _)) => (page.other(), sequence.wrapping_add(1)),
        None => (Page::A, 0),
    };
    storage.erase(page).map_err(SaveError::Flash)?;
    let words = words(sequence, payload);
    let sum = of_words(words.clone());
    for (index, word) in words.chain([sum]).enumerate() {
        storage.write(page, index, word).map_err(SaveError::Flash)?;
    }
    match read(storage, page) {
        Some((read, saved)) if (read, &saved) == (sequence, payload) => Ok(()),
        _ => Err(SaveError::Verify),
    }
}

/// The words of a page before its checksum.
fn words(sequence: u32, payload: &[u8]) -> impl Iterator<Item = u32> + Clone {
    let payload = payload.as_chunks().0;
    let head = MAGIC | payload.len() as u32;
    [head, sequence].into_iter().chain(payload.iter().map(|&word| u32::from_le_bytes(word)))
}

/// The sequence and payload of a page; `None` unless the page is whole.
// Not inlined: a save and a start read pages at several places.
#[inline(never)]
fn read(storage: &impl Storage, page: Page) -> Option<(u32, Payload)> {
    let length = (storage.read(page, 0) ^ MAGIC) as usize;
    let sequence = storage.read(page, 1);
    let mut payload = Payload::new();
    for index in 0..Some(length).filter(|length| *length <= ROOM)? {
        payload.extend_from_slice(&storage.read(page, index + 2).to_le_bytes()).ok()?;
    }
    let sum = storage.read(page, length + 2);
    (sum == of_words(words(sequence, &payload))).then_some((sequence, payload))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: usize = 5;
    const SIZE: usize = WORDS + 3;

    /// Flash that loses power at one of its operations. An erasure then leaves the page half
    /// erased, a write half of the bits.
    #[derive(Clone)]
    struct Mock {
        pages: [[u32; SIZE]; 2],
        /// Operations until the power fails.
        left: u32,
        /// The bits that an interrupted operation has done.
        done: u32,
        operations: u32,
    }

    /// The power has failed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    struct Off;

    impl Mock {
        fn new() -> Self {
            // A new chip, and one that held other data.
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
            self.pages[page as usize].get(index).copied().unwrap_or(u32::MAX)
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

    fn payload(round: u32) -> Payload {
        let word = |n: u32| round.wrapping_mul(0x9E37_79B9).rotate_left(n) ^ n;
        (0..WORDS as u32).flat_map(|n| word(n).to_le_bytes()).collect()
    }

    fn newest(mock: &Mock) -> Option<Payload> {
        load(mock).map(|(_, _, payload)| payload)
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
            let payload = payload(sequence);
            let before = words(sequence, &payload);
            let all: std::vec::Vec<u32> = before.clone().chain([of_words(before)]).collect();
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

    /// A payload that its reader does not understand once became default settings, reported as stored ones.
    #[test]
    fn the_newest_payload_that_can_be_read_counts() {
        let small = |bytes: &[u8]| Some(bytes[0]).filter(|first| *first < 100);
        let of = |value: u8| Payload::from([value; 4 * WORDS]);
        let mut mock = Mock::new();
        assert_eq!((latest(&mock, small), before(&mock)), (Kept::Nothing, None));
        save(&mut mock, &of(1)).unwrap();
        assert_eq!((latest(&mock, small), before(&mock)), (Kept::Found(1), None));
        save(&mut mock, &of(2)).unwrap();
        assert_eq!((latest(&mock, small), before(&mock)), (Kept::Found(2), Some(of(1))));
        save(&mut mock, &of(100)).unwrap();
        assert_eq!((latest(&mock, small), before(&mock)), (Kept::Found(2), Some(of(2))));
        save(&mut mock, &of(101)).unwrap();
        assert_eq!(latest(&mock, small), Kept::Unreadable);
        // A later program's payload may be longer than all of this one's.
        let mut later = Mock::new();
        save(&mut later, &of(3)).unwrap();
        later.pages[Page::B as usize][0] = MAGIC | (ROOM + 1) as u32;
        assert_eq!(latest(&later, small), Kept::Found(3));
        later.pages[Page::A as usize][0] = MAGIC | u32::from(u16::MAX);
        assert_eq!((latest(&later, small), load(&later)), (Kept::Unreadable, None));
        assert_eq!(latest(&NoStorage, small), Kept::Nothing);
    }

    #[test]
    fn flash_that_keeps_nothing_is_told() {
        assert_eq!(load(&NoStorage), None);
        assert_eq!(save(&mut NoStorage, &payload(1)), Err(SaveError::Flash(NoStorage)));
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
        assert_eq!(load(&Dead), None);
        assert_eq!(save(&mut Dead, &payload(1)), Err(SaveError::Verify));
    }
}
