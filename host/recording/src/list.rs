//! Lists of numbers in text: a debugger's, an array of C, a list of Python, the memory that gdb prints. A number may be decimal or
//! hexadecimal; brackets within the list end rows.

use super::input::Input;
use super::scaling::Unit;
use super::source::Source;
use super::{Opened, Options, RecordingError, Sample, pick, text};
use std::io::BufRead;
use std::path::{Path, PathBuf};

/// So many numbers are a list.
const LEAST: usize = 8;
/// Rows of no more numbers are samples of so many channels; longer ones are records.
const CHANNELS: u64 = 8;
/// A word is no longer, in bytes.
const LONGEST: usize = 64;
/// No number is repeated more often.
const REPEATED: u64 = 1 << 24;

/// A word of the text.
#[derive(Clone, Debug, PartialEq)]
enum Word {
    Open,
    Close,
    Number(f64, Option<f64>),
    /// The last number again, so many times in all.
    Repeats(u64),
    /// What the program left out.
    Dots,
    /// The end of an address.
    Address,
    Other,
}

/// Where a list begins and how it is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Opening brackets up to it; 0 where it has none.
    opens: usize,
    /// Numbers in each of its rows, where these are alike.
    row: Option<u64>,
    complex: bool,
    /// Numbers are hexadecimal without a mark.
    hex: bool,
}

/// The words of a text.
struct Words<R> {
    reader: R,
    hex: bool,
    pushed: Option<u8>,
    pending: Option<Word>,
}

impl<R: BufRead> Words<R> {
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
    fn next(&mut self) -> std::io::Result<Option<Word>> {
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
fn number(word: &str, hex: bool) -> Option<(f64, Option<f64>)> {
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
        let at = signs.filter(|&at| at > 0 && !complex[..at].ends_with(['e', 'E'])).last();
        let at = at.unwrap_or(0);
        let (re, im) = complex.split_at(at);
        return Some((if re.is_empty() { 0.0 } else { plain(re)? }, Some(plain(im)?)));
    }
    plain(word)
        .or_else(|| plain(word.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L'])))
        .map(|x| (x, None))
}

/// The list in a text that begins with this head, if there is one.
pub(super) fn found(head: &str) -> Option<Found> {
    let four = |word: &&str| word.len() == 4 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let marks = |c: char| c.is_whitespace() || ",;{}[]()".contains(c);
    let words: Vec<&str> = head.split(marks).filter(|word| !word.is_empty()).collect();
    let all = words.len() >= LEAST && words.iter().filter(|it| four(it)).count() + 1 >= words.len();
    let hex = all
        && words.iter().any(|word| four(word) && word.contains(|c: char| c.is_ascii_alphabetic()));
    bracketed(head, hex).or_else(|| bare(head, hex))
}

fn bracketed(head: &str, hex: bool) -> Option<Found> {
    let mut words = Words { reader: head.as_bytes(), hex, pushed: None, pending: None };
    let (mut opens, mut start, mut depth) = (0, None, 0usize);
    let (mut count, mut complex) = (0u64, false);
    let (mut row, mut rows, mut same) = (0u64, None::<u64>, true);
    // A last word may be cut off, and be none.
    while let Some(word) = words.next().ok()? {
        match word {
            Word::Open => {
                opens += 1;
                if start.is_none() || count == 0 && depth == 0 {
                    start = Some(opens);
                }
                (depth, row) = (depth + 1, 0);
            }
            Word::Close if start.is_some() => {
                depth = depth.saturating_sub(1);
                if depth > 0 && row > 0 {
                    same &= rows.is_none_or(|rows| rows == row);
                    rows.get_or_insert(row);
                }
                if depth == 0 {
                    if count >= LEAST as u64 {
                        break;
                    }
                    (start, count, rows) = (None, 0, None);
                }
            }
            Word::Number(_, im) if start.is_some() => {
                (count, row) = (count + 1, row + 1);
                complex |= im.is_some();
            }
            Word::Repeats(times) if start.is_some() => row += times.saturating_sub(1),
            Word::Dots | Word::Address if start.is_some() => {}
            // [0] = 2051 is a line of a table, and struct {int a; ...} none at all.
            _ if count < LEAST as u64 => (start, depth, count, rows) = (None, 0, 0, None),
            _ => break,
        }
    }
    let start = start.filter(|_| count >= LEAST as u64)?;
    Some(Found { opens: start, row: rows.filter(|_| same), complex, hex })
}

/// Without brackets: numbers behind addresses, hexadecimal words, or one row of many.
fn bare(head: &str, hex: bool) -> Option<Found> {
    let lines: Vec<&str> = head.lines().filter(|line| !line.trim().is_empty()).collect();
    let address = |line: &&str| {
        let first = line.split_whitespace().next().unwrap_or_default();
        line.trim_start().starts_with("0x") && (first.ends_with(':') || line.contains(">:"))
    };
    let dump = lines.len() > 1 && lines.iter().all(|line| address(&line))
        || lines.iter().take(1).all(address);
    let many = |line: &&str| {
        line.split([',', ';', '\t', ' ']).filter(|it| number(it.trim(), false).is_some()).count()
            >= 64
    };
    let one = lines.len() == 1 && lines.iter().all(|line| many(&line));
    let found = Found { opens: 0, row: None, complex: head.contains('j') && one, hex };
    (dump || hex || one).then_some(found)
}

pub(super) fn open(
    path: &Path,
    input: Input,
    found: Found,
    options: &Options,
) -> Result<Opened, RecordingError> {
    let channels = found.row.filter(|&row| row <= CHANNELS && !found.complex).unwrap_or(1) as usize;
    let picked = match (found.complex, channels) {
        (true, _) => pick::complex(path, 1, options)?,
        // Pairs are I and Q.
        (_, 2) if options.channel.is_none() => (0, Some(1)),
        _ => pick::real(path, channels, options)?,
    };
    let mut words =
        Words { reader: text::reader(input), hex: found.hex, pushed: None, pending: None };
    let failed = |error| RecordingError::Io(path.into(), error);
    let mut opens = 0;
    while opens < found.opens {
        match words.next().map_err(failed)? {
            Some(Word::Open) => opens += 1,
            Some(_) => {}
            None => return Err(RecordingError::Empty(path.into())),
        }
    }
    let row = found.row.filter(|&row| row > CHANNELS && channels == 1);
    let source = Listed {
        path: path.into(),
        words,
        depth: usize::from(found.opens > 0),
        bracket: found.opens > 0,
        channels: if found.complex { 2 } else { channels },
        picked,
        held: Vec::new(),
        last: (0.0, None),
        again: 0,
        complex: found.complex,
        ended: false,
    };
    let hex = if found.hex { ", hexadecimal" } else { "" };
    Ok(Opened {
        iq: picked.1.is_some(),
        row,
        notes: vec![format!("read as a list of numbers{hex}")],
        ..Opened::new(Unit::FREE, Box::new(source))
    })
}

/// The numbers of a list.
struct Listed {
    path: PathBuf,
    words: Words<Box<dyn BufRead + Send>>,
    depth: usize,
    bracket: bool,
    channels: usize,
    picked: (usize, Option<usize>),
    /// Numbers of a sample that is not whole yet.
    held: Vec<f64>,
    last: (f64, Option<f64>),
    again: u64,
    complex: bool,
    ended: bool,
}

impl Listed {
    /// The next number; `None` at the end.
    fn next(&mut self) -> Result<Option<(f64, Option<f64>)>, RecordingError> {
        if self.again > 0 {
            self.again -= 1;
            return Ok(Some(self.last));
        }
        while !self.ended {
            let word =
                self.words.next().map_err(|error| RecordingError::Io(self.path.clone(), error))?;
            match word {
                None => self.ended = true,
                Some(Word::Open) => self.depth += 1,
                Some(Word::Close) => {
                    self.depth = self.depth.saturating_sub(1);
                    self.ended = self.bracket && self.depth == 0;
                }
                Some(Word::Number(re, im)) => {
                    self.last = (re, im);
                    return Ok(Some(self.last));
                }
                Some(Word::Repeats(times)) if times > 1 => {
                    self.again = times.min(REPEATED) - 2;
                    return Ok(Some(self.last));
                }
                Some(Word::Dots) => {
                    let what =
                        "the program that wrote it left numbers out (...): have it print all"
                            .into();
                    return Err(RecordingError::Columns(self.path.clone(), what));
                }
                Some(Word::Other) if self.bracket => return Ok(Some((f64::NAN, None))),
                Some(_) => {}
            }
        }
        Ok(None)
    }
}

impl Source for Listed {
    fn read(&mut self, into: &mut Vec<Sample>, count: usize) -> Result<(), RecordingError> {
        let from = into.len();
        while into.len() - from < count {
            let Some((re, im)) = self.next()? else { break };
            self.held.push(re);
            if self.complex {
                self.held.push(im.unwrap_or(0.0));
            }
            if self.held.len() >= self.channels {
                let at = |place: usize| self.held.get(place).copied().unwrap_or(f64::NAN);
                into.push(Sample::of(at(self.picked.0), self.picked.1.map(at)));
                self.held.clear();
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recording;

    fn of(text: &str) -> Result<Vec<[f64; 2]>, String> {
        let format = Some(super::super::Format::Csv);
        let options = Options { format, scale: Some(1.0), ..Options::default() };
        let told = |error: RecordingError| error.to_string();
        let recording =
            Recording::from_bytes(Path::new("x.txt"), text.into(), options).map_err(told)?;
        let part = |sample: Result<Sample, RecordingError>| {
            sample.map(|it| [it.value.re, it.value.im]).map_err(told)
        };
        recording.samples().map(part).collect()
    }

    #[test]
    fn what_debuggers_and_programs_print() {
        let numbers: Vec<f64> =
            (0..40).map(|n| (2048.0 + 900.0 * (0.7 * f64::from(n)).sin()).round()).collect();
        let expected: Vec<[f64; 2]> = numbers.iter().map(|x| [*x, 0.0]).collect();
        let decimal = numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        let hex: Vec<String> =
            numbers.iter().map(|x| format!("{:#06X}", *x as u16).replace("0X", "0x")).collect();
        let plain: Vec<String> = numbers.iter().map(|x| format!("{:04X}", *x as u16)).collect();
        let memory: String = numbers
            .chunks(8)
            .zip(0..)
            .map(|(row, k)| {
                let row: Vec<String> = row.iter().map(f64::to_string).collect();
                format!("{:#x} <adc_buf+{}>:\t{}\n", 0x2000_0100 + 16 * k, 16 * k, row.join("\t"))
            })
            .collect();
        for text in [
            format!("\tDetails:{{{decimal}}}"),
            format!("$1 = {{{decimal}}}\n"),
            format!("#include <stdint.h>\nconst uint16_t adc[40] = {{\n  {decimal}\n}};\n"),
            format!("static int16_t x[] = {{ // from 0 on\n{} /* hex */ }};", hex.join(",\n")),
            format!("[{decimal}]"),
            format!("x = [{decimal}]\n"),
            format!("array([{}])", decimal.replace(',', "")),
            format!("{decimal}, {decimal}").chars().take(decimal.len()).collect::<String>()
                + &", 2048".repeat(30),
            plain.join(" ") + "\n",
            memory,
        ] {
            let found = of(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(found[..expected.len()], expected, "{text}");
        }
        assert_eq!(of("$1 = {1, 2, 3, 4, 5, 6, 7, 8, 9 <repeats 5 times>, 3}").unwrap().len(), 14);
        assert!(
            of("$1 = {1, 2, 3, 4, 5, 6, 7, 8, 9...}").unwrap_err().contains("left numbers out")
        );
        let pairs = of("[[1,2],[3,4],[5,6],[7,8],[9,10]]").unwrap();
        assert_eq!((pairs.len(), pairs[1]), (5, [3.0, 4.0]));
        let complex =
            of("[(1+2j), (3-4e-1j), 5j, (1+2j), (1+2j), (1+2j), (1+2j), (1+2j)]").unwrap();
        assert_eq!(complex[1..3], [[3.0, -0.4], [0.0, 5.0]]);
    }
}
