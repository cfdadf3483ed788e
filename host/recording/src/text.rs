//! Text of either width: files of Windows programs have 16 bits a letter.

use super::input::Input;
use std::io::{self, BufRead, BufReader, Read};

/// Which bytes a file's text is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Letters {
    /// UTF-8.
    Narrow,
    /// UTF-16; whether the more significant byte of a letter comes first.
    Wide { big: bool },
}

fn letters(head: &[u8]) -> Letters {
    match head {
        [0xFF, 0xFE, ..] => Letters::Wide { big: false },
        [0xFE, 0xFF, ..] => Letters::Wide { big: true },
        // Digits and commas have nothing in their upper byte.
        [first, 0, third, 0, ..] if *first != 0 && *third != 0 => Letters::Wide { big: false },
        [0, first, 0, third, ..] if *first != 0 && *third != 0 => Letters::Wide { big: true },
        _ => Letters::Narrow,
    }
}

/// True where the bytes are text with a digit in it: a converter's are not.
pub(super) fn is_text(head: &[u8]) -> bool {
    let plain = |&byte: &u8| (b' '..127).contains(&byte) || b"\t\r\n".contains(&byte);
    let text = decoded(head);
    text.bytes().all(|byte| plain(&byte))
        && text.bytes().any(|byte| byte.is_ascii_digit())
        && text.contains('\n')
}

/// The text of a file's first bytes, without a mark of their order. What is no letter is replaced.
pub(super) fn decoded(head: &[u8]) -> String {
    let text = match letters(head) {
        Letters::Narrow => String::from_utf8_lossy(head).into_owned(),
        Letters::Wide { big } => {
            let unit = |pair: &[u8]| unit([pair[0], pair[1]], big);
            String::from_utf16_lossy(&head.chunks_exact(2).map(unit).collect::<Vec<_>>())
        }
    };
    text.trim_start_matches('\u{feff}').to_owned()
}

fn unit(pair: [u8; 2], big: bool) -> u16 {
    if big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
}

/// The input's text as UTF-8.
pub(super) fn reader(input: Input) -> Box<dyn BufRead + Send> {
    match letters(&input.head) {
        Letters::Narrow => Box::new(input.reader()),
        Letters::Wide { big } => Box::new(BufReader::new(Narrow {
            wide: input.reader(),
            big,
            letter: [0; 4],
            pending: 0..0,
            upper: None,
        })),
    }
}

/// UTF-16 as UTF-8.
struct Narrow<R> {
    wide: R,
    big: bool,
    /// The bytes of the last letter, and those of them that are not read yet.
    letter: [u8; 4],
    pending: std::ops::Range<usize>,
    /// The first half of a letter that has two.
    upper: Option<u16>,
}

impl<R: Read> Read for Narrow<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut count = 0;
        while let Some(byte) = into.get_mut(count) {
            if self.pending.is_empty() && !self.next_letter()? {
                break;
            }
            *byte = self.letter[self.pending.start];
            self.pending.start += 1;
            count += 1;
        }
        Ok(count)
    }
}

impl<R: Read> Narrow<R> {
    /// False at the end.
    fn next_letter(&mut self) -> io::Result<bool> {
        loop {
            let mut pair = [0; 2];
            match self.wide.read_exact(&mut pair) {
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
                other => other?,
            }
            let unit = unit(pair, self.big);
            if (0xD800..0xDC00).contains(&unit) {
                self.upper = Some(unit);
                continue;
            }
            let units = self.upper.take().into_iter().chain([unit]);
            let letter = char::decode_utf16(units).next().and_then(Result::ok);
            let text = letter.unwrap_or(char::REPLACEMENT_CHARACTER).encode_utf8(&mut self.letter);
            self.pending = 0..text.len();
            return Ok(true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn letters_of_sixteen_bits() {
        let text = "Zeit µs,1.5\n\u{1F600}2\n";
        for big in [false, true] {
            for mark in ["\u{feff}", ""] {
                let marked = format!("{mark}{text}");
                let order = |unit: u16| if big { unit.to_be_bytes() } else { unit.to_le_bytes() };
                let bytes: Vec<u8> = marked.encode_utf16().flat_map(order).collect();
                assert_eq!(decoded(&bytes), text);
                let input = Input::from_bytes(Path::new("x"), bytes.into()).unwrap();
                let mut read = String::new();
                reader(input).read_to_string(&mut read).unwrap();
                assert_eq!(read, marked);
            }
        }
        assert!(is_text(b"1,2\n") && !is_text(&[1, 0, 2, 0]) && !is_text(b"abc\n"));
    }
}
