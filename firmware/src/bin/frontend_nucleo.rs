//! The instrument on a NUCLEO-F446RE: ADC by DMA, a chirp by DAC or synthesiser, telemetry and commands over the probe's serial port.
//! docs/board.md explains wiring and use.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use picket_dsp::acquire::sample::{Iq, Real};
use picket_firmware::instrument::Instrument;
use picket_firmware::instrument::meter::Every;
use picket_firmware::nucleo_f446re::{CELLS, N, Nucleo, SLOT};
use picket_firmware::self_test;

picket_firmware::nucleo_vectors!();

#[entry]
fn main() -> ! {
    let meters = picket_firmware::meters!(Every<Real, N, CELLS>, Every<Iq, N, CELLS>);
    if self_test::due() {
        self_test::run::<Nucleo, N, SLOT>(meters);
    }
    match Instrument::<Nucleo, N, SLOT, _, _>::start(meters) {
        Some(instrument) => instrument.run(),
        // Memory is taken only once, here, so this case cannot happen; if it did, the watchdog would restart the chip.
        None => loop {
            cortex_m::asm::nop();
        },
    }
}
