//! The list that a board goes through by itself, with one wire from an output to an input.

use crate::cli::print_line;
use crate::device::{Listener, Said};
use crate::end;
use crate::watch::WatchError;
use crate::watch::port::{Piece, Source};
use picket_wire::command::{Command, Request};
use std::time::{Duration, Instant};

/// The longest silence: eight seconds of the watchdog, and a rate's ten.
const PATIENCE: Duration = Duration::from_secs(25);
/// After this the order is given again.
const AGAIN: Duration = Duration::from_secs(1);
const ORDER: Request = Request { tag: 0x5E, command: Command::SelfTest };

/// Has the board try itself, and prints its list. Returns the lines, and whether every item held; of a board that says nothing more an error.
pub fn listen(
    source: &mut Source,
    program: u32,
    quick: bool,
    emulated: bool,
) -> Result<(Vec<String>, bool), WatchError> {
    let mut list = List { program, lines: Vec::new(), begun: false, wrong: false, held: None };
    let mut listener = Listener::default();
    let mut text = Vec::new();
    let mut heard = Instant::now();
    let request = ORDER;
    let mut asked: Option<Instant> = None;
    let patience = PATIENCE * if emulated { 10 } else { 1 };
    while end::asked().is_none() && list.held.is_none() {
        if !list.begun && asked.is_none_or(|asked| asked.elapsed() > AGAIN) {
            // A zero ends whatever noise came before.
            source.send(&[0]);
            source.send(&request.to_frame());
            asked = Some(Instant::now());
        }
        let bytes = match source.piece()? {
            Piece::Opened => continue,
            Piece::End => break,
            Piece::Bytes(bytes) => bytes,
        };
        if !bytes.is_empty() {
            heard = Instant::now();
        }
        if heard.elapsed() > patience {
            return Err(WatchError::Unanswered { order: "--self-test", tries: 1 });
        }
        if !list.begun {
            for said in listener.read(&bytes) {
                if let Said::Answer(answer, Err(refusal)) = said
                    && answer == request.answer()
                {
                    return Err(WatchError::Refused(refusal));
                }
            }
        }
        text.extend(bytes);
        while let Some(length) = text.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = text.drain(..=length).collect();
            if list.line(&String::from_utf8_lossy(&line)) && quick {
                // A zero ends what a board with two ports passes on.
                source.send(b"q\0");
            }
        }
    }
    Ok((list.lines, list.held == Some(true)))
}

/// The list as it comes.
#[derive(Debug)]
struct List {
    /// The checksum that the board reported of its program.
    program: u32,
    lines: Vec<String>,
    begun: bool,
    wrong: bool,
    /// Whether every item held, at the end.
    held: Option<bool>,
}

impl List {
    /// Prints a line from the list's beginning on. True at the beginning.
    fn line(&mut self, line: &str) -> bool {
        // A port over USB that opens anew sends a zero.
        let line = line.trim_matches(|letter: char| letter == '\0' || letter.is_whitespace());
        // What the instrument said before has no end of a line.
        let head = line.find("picket self-test");
        let line = head.map_or(line, |at| &line[at..]);
        self.begun |= head.is_some();
        if !self.begun || line.is_empty() {
            return false;
        }
        self.wrong |= line.contains("WRONG");
        self.wrong |= head.is_some() && !line.contains(&format!("program {:08x}", self.program));
        print_line(line);
        self.lines.push(line.into());
        if line.starts_with("result:") {
            self.held = Some(!self.wrong);
        }
        head.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board that has begun takes the order, given once more, for nothing.
    #[test]
    fn the_order_does_not_shorten_the_list() {
        assert!(!ORDER.to_frame().contains(&b'q'));
    }

    #[test]
    fn a_list_holds_if_each_item_does() {
        let head = "\u{fffd}picket self-test 0.1.0 on nucleo-f446re, program 0000abcd, started by software";
        for (program, item, held) in [
            (0xABCD, "- [x] clock", true),
            (0xABCD, "\0- [x] clock\r\n", true),
            (0xABCD, "- once more: clock", true),
            (0xABCD, "- [ ] WRONG: clock", false),
            (0xABCE, "- [x] clock", false),
        ] {
            let lines = Vec::new();
            let mut list = List { program, lines, begun: false, wrong: false, held: None };
            assert!(!list.line("result: 0 of 1 hold") && list.held.is_none());
            assert!(list.line(head));
            assert!(!list.line(item) && !list.line("result: 1 of 1 hold"));
            assert_eq!(list.held, Some(held));
            assert_eq!(list.lines.len(), 3);
        }
    }
}
