//! A board tries itself, item by item, with one wire from an output to an input, where a host asks for it. It reports each item as a line of
//! text, ticked or not, to be pasted into a report.
//!
//! Each item begins with a reset, as new settings of the instrument do, so it finds the board in the instrument's state. An item that does
//! not hold is tried again, up to three times in all. After the list's end the instrument starts again; the byte `q` shortens the list to a
//! moment at each rate.
//!
//! What is tried of every board stands in [`items`]; a board adds what its converter, its output and its clock can try ([`Trial`]).

pub mod items;
pub mod line;
mod state;
pub mod stream;

use crate::board::Board;
use crate::instrument::handover::Handover;
use crate::instrument::meter::Meters;
use crate::instrument::stack;
use line::Line;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_dsp::tone::Verdict;
use picket_instrument::meter::Meter;
use picket_wire::boot::{Causes, LastEnd};
use picket_wire::settings::Settings;
use state::State;

/// A board that can try itself.
pub trait Trial<const N: usize, const SLOT: usize>: Board<N, SLOT> + 'static {
    /// What measures real blocks of its image.
    type Real: Meter<Real, N> + 'static;
    /// What measures I/Q blocks of its image.
    type Iq: Meter<Iq, N> + 'static;
    /// The list.
    const ITEMS: &'static [Item<Self, N, SLOT>];
    /// The tone that its output can play.
    const TONE: Tone;

    /// Plays the tone from the next start of the samples on, in step with samples by these words.
    fn play(words: &Self::Words);

    /// Whether the host that asked for the list hears the board: a port over USB opens anew after each reset.
    fn heard() -> bool {
        true
    }
}

/// A tone of an output.
pub struct Tone {
    /// What the list calls it.
    pub name: &'static str,
    /// Cycles per sample, exactly.
    pub frequency: f64,
    /// The verdict of its blocks.
    pub verdict: Verdict,
}

/// One item.
pub struct Item<B: Trial<N, SLOT>, const N: usize, const SLOT: usize> {
    /// The core's clock, MHz; 0 for the usual one.
    pub mhz: u16,
    /// Tries it.
    pub run: fn(&mut Bench<'_, B, N, SLOT>) -> Outcome,
}

/// The tools of an item.
pub struct Bench<'a, B: Trial<N, SLOT>, const N: usize, const SLOT: usize> {
    /// The board, started.
    pub board: B,
    /// What the items before have left.
    pub state: &'a mut State,
    /// What measures the blocks: the instrument's own.
    pub meters: &'static mut Meters<B::Real, B::Iq>,
    /// The causes of the chip's reset before this item.
    causes: Causes,
}

/// Whether the item holds, and the figures.
pub type Outcome = (bool, Line);

/// The most tries of an item.
const TRIES: u32 = 3;
/// The longest wait for a host that opens its port anew, seconds.
const OPENING: u32 = 10;

/// Has the next start begin the list. With `reopened`, a line waits until the host hears the board again ([`Trial::heard`]).
pub fn mark(reopened: bool) {
    State { reopened, ..State::default() }.save();
}

/// Whether this start belongs to the list.
pub fn due() -> bool {
    State::load().is_some()
}

/// Starts the instrument.
fn leave() -> ! {
    State::forget();
    Handover::default().leave()
}

/// Tries the list's next item, and ends by a reset.
pub fn run<B: Trial<N, SLOT>, const N: usize, const SLOT: usize>(
    meters: Option<&'static mut Meters<B::Real, B::Iq>>,
) -> ! {
    let Handover { last, .. } = Handover::take();
    let causes = B::causes();
    // Power and the button end the list, a reset by program or watchdog goes on with it.
    let goes_on = matches!(causes.message(), "software" | "watchdog");
    let mut state = match State::load().filter(|_| goes_on) {
        Some(state) => state,
        None => leave(),
    };
    let item = B::ITEMS.get(state.item as usize);
    let settings = Settings { core_mhz: item.map_or(0, |item| item.mhz), ..Settings::default() };
    let (Some(board), Some(meters)) = (B::start(&settings), meters) else { leave() };
    let mut bench = Bench::<B, N, SLOT> { board, state: &mut state, meters, causes };
    if bench.state.item == 0 && !bench.state.begun && bench.state.tries == 0 {
        bench.head();
    }
    match item {
        Some(_) if bench.state.begun => bench.broken_off(last),
        Some(item) => {
            bench.state.begun = true;
            bench.state.save();
            let outcome = (item.run)(&mut bench);
            bench.tell(outcome);
        }
        None => bench.end(),
    }
    bench.next()
}

impl<B: Trial<N, SLOT>, const N: usize, const SLOT: usize> Bench<'_, B, N, SLOT> {
    /// Judges the last item after a reset: the item that starves the watchdog ends by a reset, and so do items that fail.
    fn broken_off(&mut self, last: LastEnd) {
        if self.causes.message() == "watchdog" && self.state.starved_ms > 0 {
            let outcome = self.bitten();
            return self.tell(outcome);
        }
        let line = Line::new("item ").number(self.state.item + 1).text(" ended by ");
        let line = line.text(self.causes.message());
        let line = match last.kind {
            0 => line,
            5 => line.text(", stack overflow"),
            _ => line.text(", fault at 0x").hex(last.pc),
        };
        self.tell((false, line));
    }

    fn head(&mut self) {
        // The host's port may open when the board's power comes.
        self.listen();
        let line = Line::new("picket self-test ").text(env!("CARGO_PKG_VERSION"));
        let line = line.text(" on ").text(B::NAME).text(", program ").hex(B::program());
        // What the instrument said before has no end of a line.
        self.say("\r\n", &line.text(", started by ").text(self.causes.message()));
        // Now the host knows that it can shorten the list.
        self.listen();
    }

    /// Listens for a quarter of a second.
    fn listen(&mut self) {
        let begun = self.board.ticks();
        while self.board.ticks().wrapping_sub(begun) < self.board.clocks().ticks_hz / 4 {
            self.hear();
            self.board.sleep(None);
        }
    }

    fn hear(&mut self) {
        while let Some(byte) = self.board.receive() {
            self.state.quick |= byte == b'q';
        }
    }

    /// Reports an item's result, and counts it, unless the item shall be tried again.
    #[inline(never)] // once, for all items
    fn tell(&mut self, (holds, line): Outcome) {
        self.state.stack = self.state.stack.max(stack::used());
        self.state.tries += 1;
        self.state.again = !holds && self.state.tries < TRIES;
        let [held, failed] = &mut self.state.outcomes;
        let sign = match holds {
            true => {
                *held += 1;
                "- [x] "
            }
            false if self.state.again => "- once more: ",
            false => {
                *failed += 1;
                "- [ ] WRONG: "
            }
        };
        self.say(sign, &line);
    }

    #[inline(never)] // once, for all lines
    fn say(&mut self, sign: &str, line: &Line) {
        let begun = self.board.ticks();
        let patience = self.board.clocks().ticks_hz * OPENING;
        while self.state.reopened
            && !B::heard()
            && self.board.ticks().wrapping_sub(begun) < patience
        {
            self.board.feed();
            self.board.sleep(None);
        }
        // The line has room for a whole list.
        for part in [sign.as_bytes(), line.bytes(), b"\r\n"] {
            let _ = self.board.send(part);
        }
        self.board.flush();
    }

    /// The last item, and the sum.
    fn end(&mut self) {
        let (stack, room) = (self.state.stack, stack::room());
        let line = Line::new("stack: ").number(stack).text(" of ").number(room).text(" B");
        self.tell((stack > 0 && stack < room, line));
        let [held, failed] = self.state.outcomes;
        let line = Line::new("result: ").number(held).text(" of ").number(held + failed);
        self.say("", &line.text(" hold"));
    }

    /// Resets the board, for the next item or for the instrument after the last one.
    fn next(mut self) -> ! {
        self.hear();
        self.board.flush();
        let state = *self.state;
        if state.item as usize >= B::ITEMS.len() {
            leave()
        }
        let state = match state.again {
            true => state,
            false => State { item: state.item + 1, tries: 0, ..state },
        };
        State { begun: false, again: false, starved_ms: 0, ..state }.save();
        Handover::default().leave()
    }
}
