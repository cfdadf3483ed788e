//! The implementation of [`Board`](crate::board::Board).

use super::serial::Serial;
use super::storage::{self, Flash};
use super::words::Words;
use super::words::clock::{Speed, Tree};
use super::{N, SLOT, chirp, converter, start};
use crate::board::{Board, Clocks, Port};
use crate::instrument::clock;
use crate::instrument::plan::Plan;
use crate::slot::Slot;
use crate::{fence, self_test};
use picket_dsp::acquire::codes::Codes;
use picket_dsp::acquire::frontend::{Blocks, Counters};
use picket_dsp::pipeline::Measurement;
use picket_wire::boot::Causes;
use picket_wire::settings::{Drive, Settings};
use picket_wire::settings_error::SettingsError;

/// The NUCLEO-F446RE.
pub struct Nucleo {
    tree: Tree,
    serial: Serial,
}

impl Port<N, SLOT> for Nucleo {
    const NAME: &'static str = "nucleo-f446re";
    const CODES: Codes = Codes::unsigned::<12>();
    type Words = Words;
    type Storage = Flash;
    type Slots = Blocks<'static, Slot<SLOT>>;

    fn plan(&self, settings: &Settings) -> Result<(Plan<N>, Words), SettingsError> {
        let speed = Speed::from_mhz(settings.core_mhz).ok_or(SettingsError::Speed)?;
        Words::plan(settings, &Tree::new(speed, self.tree.source))
    }

    fn widen(&self, measurement: &mut Measurement) {
        // A played input is exact, whatever the clock.
        if !cfg!(feature = "played") {
            clock::widen(self.tree.source.clock(), measurement);
        }
    }

    fn counters(&self) -> Counters {
        converter::counters()
    }

    fn ticks(&self) -> u32 {
        start::ticks()
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.serial.has_room(bytes)
    }

    fn send(&mut self, frame: &[u8]) -> bool {
        self.serial.send(frame)
    }

    fn pause(&mut self) {
        converter::pause();
    }

    fn resume(&mut self) {
        converter::resume();
    }

    fn gate_opened(&mut self) -> bool {
        chirp::gate_opened()
    }

    fn stalled(&mut self) -> bool {
        self.serial.stalled()
    }

    fn feed(&mut self) {
        start::feed();
    }

    fn self_test(&mut self) -> bool {
        self_test::mark(false);
        true
    }
}

impl Board<N, SLOT> for Nucleo {
    fn causes() -> Causes {
        start::causes()
    }

    #[inline(never)] // once in an image, not for the self-test, too
    fn start(settings: &Settings) -> Option<Self> {
        fence::raise();
        start::buses();
        if let Drive::Dac { low, .. } = settings.drive {
            chirp::rest(low);
        }
        let tree = start::clock(Speed::from_mhz(settings.core_mhz).unwrap_or_default());
        start::pins(&tree);
        #[cfg(feature = "brown-out")]
        super::brown_out::set();
        start::watchdog();
        let serial = Serial::start(tree.apb1_hz)?;
        Some(Self { tree, serial })
    }

    fn clocks(&self) -> Clocks {
        let Tree { core_hz, timer_hz, source, .. } = self.tree;
        Clocks { source: source.clock(), core_hz, ticks_hz: timer_hz }
    }

    fn sample(&mut self, plan: &Plan<N>, words: &Words) -> Option<Blocks<'static, Slot<SLOT>>> {
        converter::start(plan, words, &self.tree)
    }

    fn clock_returned(&mut self) -> bool {
        start::returned(&self.tree)
    }

    fn receive(&mut self) -> Option<u8> {
        self.serial.receive()
    }

    fn flush(&mut self) {
        self.serial.flush();
    }

    fn sleep(&mut self, blocks: Option<&Blocks<'static, Slot<SLOT>>>) {
        converter::sleep(blocks);
    }

    fn program() -> u32 {
        storage::program()
    }
}
