//! The words of a text with numbers in it, of C, of Python and of debuggers, one after the other.

use std::io::BufRead;

/// A word is no longer, in bytes.
const LONGEST: usize = 64;

/// A word of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Word {
    Open,
    Close,
    Number(f64, Option<f64>),
    /// The last number, repeated this many times in all.
    Repeats(u64),
    /// What the program left out.
    Dots,
    /// The end of an address.
    Address,
    Other,
}

/// The words of a text.
pub(super) struct Words<R> {
    reader: R,
    hex: bool,
    pushed: Option<u8>,
    pending: Option<Word>,
}

impl<R: BufRead> Words<R> {
    /// The words of a text; `hex` where its numbers are hexadecimal without a mark.
    pub fn new(reader: R, hex: bool) -> Self {
        Self { reader, hex, pushed: None, pending: None }
    }

    fn byte(&mut self) -> std::io::Result<Option<u8>> {
        if let Some(byte) = self.pushed.take() {
            return Ok(Some(byte));
        }
        let byte = self.reader.fill_buf()?.first().copied();
        self.reader.consume(usize::from(byte.is_some()));
        Ok(byte)
    }

    fn skip_to(&mut self, end: u8) -> std::io::Result<Vec<u8>> {
        let mut begin = Vec::new();
        while let Some(byte) = self.byte()?.filter(|byte| *byte != end) {
            if begin.len() < LONGEST {
                begin.push(byte);
            }
        }
        Ok(begin)
    }

    /// The next word; `None` at the end.
    pub fn next(&mut self) -> std::io::Result<Option<Word>> {
        if let Some(word) = self.pending.take() {
            return Ok(Some(word));
        }
        let mut word = Vec::new();
        while let Some(byte) = self.byte()? {
            let ends = byte.is_ascii_whitespace() || b",;(){}[]<'\"=".contains(&byte);
            if ends && !word.is_empty() {
                self.pushed = Some(byte);
                break;
            }
            match byte {
                b'{' | b'[' => return Ok(Some(Word::Open)),
                b'}' | b']' => return Ok(Some(Word::Close)),
                b'<' => {
                    if let Some(repeats) = self.angle()? {
                        return Ok(Some(repeats));
                    }
                }
                b'=' => return Ok(Some(Word::Other)),
                _ if ends => {}
                _ if word.len() < LONGEST => {
                    word.push(byte);
                    if word == b":" {
                        // Behind a name in brackets.
                        word.clear();
                    } else if word == b"//" || word == b"#" {
                        self.skip_to(b'\n')?;
                        word.clear();
                    } else if word == b"/*" {
                        while self.skip_to(b'*')?.len() < usize::MAX {
                            match self.byte()? {
                                Some(b'/') | None => break,
                                other => self.pushed = other,
                            }
                        }
                        word.clear();
                    }
                }
                _ => {}
            }
        }
        if word.is_empty() {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&word);
        let whole = text.strip_suffix("...").filter(|number| !number.is_empty());
        if whole.is_some() {
            self.pending = Some(Word::Dots);
        }
        let word = self.word(whole.unwrap_or(&text));
        if whole.is_some() {
            return Ok(Some(word));
        }
        if matches!(word, Word::Number(..)) {
            let mut after = self.byte()?;
            while after.is_some_and(|byte| byte == b' ') {
                after = self.byte()?;
            }
            match after {
                // What is called by a name is an address.
                Some(b'<') => match self.angle()? {
                    Some(repeats) => self.pending = Some(repeats),
                    None => return Ok(Some(Word::Address)),
                },
                other => self.pushed = other,
            }
        }
        Ok(Some(word))
    }

    /// What is in angle brackets, behind the first one: how often a number comes again, or a name.
    fn angle(&mut self) -> std::io::Result<Option<Word>> {
        let inside = self.skip_to(b'>')?;
        let inside = String::from_utf8_lossy(&inside);
        let times = inside.strip_prefix("repeats ").and_then(|rest| rest.split(' ').next());
        Ok(times.and_then(|times| times.parse().ok()).map(Word::Repeats))
    }

    fn word(&self, word: &str) -> Word {
        if word.starts_with("...") {
            return Word::Dots;
        }
        if let Some(before) = word.strip_suffix(':') {
            return if number(before, false).is_some() { Word::Address } else { Word::Other };
        }
        match number(word, self.hex) {
            Some((re, im)) => Word::Number(re, im),
            None => Word::Other,
        }
    }
}

/// A number of C, of Python or of a debugger, complex ones of Python among them.
pub(super) fn number(word: &str, hex: bool) -> Option<(f64, Option<f64>)> {
    let plain = |word: &str| -> Option<f64> {
        let begins = word.trim_start_matches(['-', '+']);
        begins.starts_with(|c: char| c.is_ascii_digit() || c == '.').then(|| word.parse().ok())?
    };
    if hex {
        return u32::from_str_radix(word, 16).ok().map(|x| (f64::from(x), None));
    }
    if let Some(digits) = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X")) {
        let digits = digits.trim_end_matches(['u', 'U', 'l', 'L']);
        return u64::from_str_radix(digits, 16).ok().map(|x| (x as f64, None));
    }
    if let Some(complex) = word.strip_suffix('j') {
        // The sign that is no exponent's.
        let signs = complex.char_indices().filter(|it| matches!(it.1, '+' | '-')).map(|it| it.0);
        let at = signs.rev().find(|&at| at > 0 && !complex[..at].ends_with(['e', 'E']));
        let at = at.unwrap_or(0);
        let (re, im) = complex.split_at(at);
        return Some((if re.is_empty() { 0.0 } else { plain(re)? }, Some(plain(im)?)));
    }
    plain(word)
        .or_else(|| plain(word.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L'])))
        .map(|x| (x, None))
}
