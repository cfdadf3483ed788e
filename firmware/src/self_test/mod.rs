//! The board tries itself, item by item, with one wire from A2 to A0, where a host asks for it. It reports each item as a line of text, ticked
//! or not, to be pasted into a report.
//!
//! Each item begins with a reset, as new settings of the instrument do, so it finds the board in the instrument's state. After the list's
//! end the instrument starts again; the byte `q` shortens the list to a moment at each rate.

mod items;
mod line;
mod state;
mod stream;
mod tone;

use super::Nucleo;
use crate::board::Board;
use crate::instrument::handover::Handover;
use crate::instrument::stack::Stack;
use items::{Bench, ITEMS};
use line::Line;
use picket_wire::boot::LastEnd;
use picket_wire::settings::Settings;
use state::State;

/// Has the next start begin the list.
pub fn mark() {
    State::default().save();
}

/// Whether this start belongs to the list.
pub fn due() -> bool {
    State::load().is_some()
}

/// Tries the list's next item, and ends by a reset.
pub fn run(meters: Option<&'static mut super::Measuring>) -> ! {
    let Handover { last, .. } = Handover::take();
    let causes = Nucleo::causes();
    // Power and the button end the list, a reset by program or watchdog goes on with it.
    let goes_on = matches!(causes.message(), "software" | "watchdog");
    let mut state = match State::load().filter(|_| goes_on) {
        Some(state) => state,
        None => leave(),
    };
    let item = ITEMS.get(state.item as usize);
    let settings = Settings { core_mhz: item.map_or(0, |item| item.mhz), ..Settings::default() };
    let (Some(board), Some(meters)) = (Nucleo::start(&settings), meters) else { leave() };
    let mut bench = Bench { board, state: &mut state, meters, causes };
    if bench.state.item == 0 && !bench.state.begun {
        head(&mut bench);
    }
    match item {
        Some(_) if bench.state.begun => broken_off(&mut bench, last),
        Some(item) => {
            bench.state.begun = true;
            bench.state.save();
            let outcome = (item.run)(&mut bench);
            tell(&mut bench, outcome);
        }
        None => end(&mut bench),
    }
    next(bench)
}

/// Starts the instrument.
fn leave() -> ! {
    State::forget();
    Handover::default().leave()
}

/// Judges the last item after a reset: the item that starves the watchdog ends by a reset, and so do items that fail.
fn broken_off(bench: &mut Bench, last: LastEnd) {
    if bench.causes.message() == "watchdog" && bench.state.starved_ms > 0 {
        let outcome = items::bitten(bench);
        return tell(bench, outcome);
    }
    let line = Line::new("item ").number(bench.state.item + 1).text(" ended by ");
    let line = line.text(bench.causes.message());
    let line = match last.kind {
        0 => line,
        5 => line.text(", stack overflow"),
        _ => line.text(", fault at 0x").hex(last.pc),
    };
    tell(bench, (false, line));
}

fn head(bench: &mut Bench) {
    // The host's port may open when the board's power comes.
    let begun = bench.board.ticks();
    while bench.board.ticks().wrapping_sub(begun) < bench.board.ticks_hz() / 4 {
        bench.state.quick |= bench.board.receive() == Some(b'q');
        bench.board.sleep(None);
    }
    say(bench, &Line::new(""));
    let line = Line::new("picket self-test ").text(env!("CARGO_PKG_VERSION")).text(" on ");
    let line = line.text(Nucleo::NAME).text(", program ").hex(Nucleo::program());
    let line = line.text(", started by ").text(bench.causes.message());
    say(bench, &line);
}

/// Reports an item's result, and counts it.
#[inline(never)] // once, for all items
fn tell(bench: &mut Bench, (holds, line): items::Outcome) {
    let [held, failed] = &mut bench.state.outcomes;
    *(if holds { held } else { failed }) += 1;
    say_bytes(bench, if holds { b"- [x] " } else { b"- [ ] WRONG: " });
    say(bench, &line);
    bench.state.stack = bench.state.stack.max(Stack::used());
}

#[inline(never)] // once, for all lines
fn say(bench: &mut Bench, line: &Line) {
    say_bytes(bench, line.bytes());
    say_bytes(bench, b"\r\n");
    bench.board.flush();
}

fn say_bytes(bench: &mut Bench, bytes: &[u8]) {
    // The line has room for a whole list.
    let _ = bench.board.send(bytes);
}

/// The last item, and the sum.
fn end(bench: &mut Bench) {
    let (stack, room) = (bench.state.stack, Stack::room());
    let line = Line::new("stack: ").number(stack).text(" of ").number(room).text(" B");
    tell(bench, (stack > 0 && stack < room, line));
    let [held, failed] = bench.state.outcomes;
    let line = Line::new("result: ").number(held).text(" of ").number(held + failed);
    say(bench, &line.text(" hold"));
}

/// Resets the board, for the next item or for the instrument after the last one.
fn next(mut bench: Bench) -> ! {
    let mut quick = false;
    while let Some(byte) = bench.board.receive() {
        quick |= byte == b'q';
    }
    bench.board.flush();
    if bench.state.item as usize >= ITEMS.len() {
        leave()
    }
    let quick = bench.state.quick || quick;
    State { item: bench.state.item + 1, begun: false, quick, ..*bench.state }.save();
    Handover::default().leave()
}
