//! Lists of numbers in text: a debugger's, an array of C, a list of Python, the memory that gdb prints. A number may be decimal or
//! hexadecimal; brackets within the list end rows.

use super::input::Input;
use super::scaling::Unit;
use super::source::Source;
use super::words::{Word, Words, number};
use super::{Opened, Options, RecordingError, Sample, pick, text};
use std::io::BufRead;
use std::path::{Path, PathBuf};

/// So many numbers are a list.
const LEAST: usize = 8;
/// Rows of up to this many numbers are samples of as many channels; longer ones are records.
const CHANNELS: u64 = 8;
/// No number is repeated more often.
const REPEATED: u64 = 1 << 24;

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
    let mut words = Words::new(head.as_bytes(), hex);
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
    let dump = !lines.is_empty() && lines.iter().all(address);
    let many = |line: &&str| {
        line.split([',', ';', '\t', ' ']).filter(|it| number(it.trim(), false).is_some()).count()
            >= 64
    };
    let one = lines.len() == 1 && lines.iter().all(many);
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
    let mut words = Words::new(text::reader(input), found.hex);
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
